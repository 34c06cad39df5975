"""Contact-aware stepping: only what is about to touch is in YADE, and only while it does.

Free flight is analytic, and the next contact foreseen exactly (``forecast.py``).  At the last step before it
the partners get bodies exactly where their flight has them; steps of ``dt`` resolve the contact; when none is
open any more the bodies are parked and time leaps to the next contact.  Steps are counted from the same zero
as in plain stepping, so every contact meets the same sub-step phase and, until rounding parts them, the same
forces.

Nothing is missed.  A contact of two free shots, or of one with the target, is foreseen whatever else happens:
both are put into YADE when it is due.  What a shot *in contact* may meet on its changing way is put there with
it: every free shot that could come that near within the next ``WATCH_STEPS``, asked again when any contact
begins and when those steps are over.
"""

from __future__ import annotations

import math

from yade import O

from bodies import Bodies
from flight import Fleet, Flying, FlowFailed
from forecast import Forecast
from impact_logger import ImpactLogger

WATCH_STEPS = 48  # a contact lasts 14-30 steps at dt = 1.0 P: one question each
GRACE_STEPS = 3  # a contact foreseen these steps ago and not there now was a graze between two steps


class Leaps:
    """Moves the shots of ``fleet`` on; they come and go by ``add`` and ``remove`` between calls of ``advance``."""

    name = "leaps over free flight"

    def __init__(self, fleet: Fleet, bodies: Bodies, logger: ImpactLogger):
        self.fleet, self.bodies, self.logger = fleet, bodies, logger
        self.forecast = Forecast(fleet, bodies.target.landing)
        logger.held, logger.freed = self._held, self._freed
        self.kicks = None  # begins every free flight with a kick, where there is drag or gravity
        self._landing: dict[Flying, int] = {}  # who is about to strike the target, and in which flight
        self._hold = -1  # step until which the contacts put into YADE must have begun
        self._watch = -1  # step until which no outsider can reach an open contact

    def add(self, shot: Flying) -> None:
        """``shot`` flies from now on."""
        if self.kicks:
            self.kicks.begin(shot, shot.t)
        self.fleet.add(shot)
        self.forecast.renew(shot, self.logger.clock())
        self._watch = -1

    def remove(self, shot: Flying) -> None:
        """``shot``, which is in no contact, leaves the simulation."""
        if shot.body >= 0:
            self.bodies.park(shot)
        self.fleet.remove(shot)
        shot.flight += 1  # voids what was foreseen of it

    def advance(self, steps: int) -> None:
        """Go on by ``steps`` time steps. Raises FlowFailed as soon as a contact gives what no contact can."""
        log, dt = self.logger, self.logger.dt
        end = log.step + steps
        while log.step < end:
            due = self.forecast.next() / dt
            if not self.bodies.shot_of:
                if due >= end:
                    log.step = end
                    return
                log.step = max(log.step, math.floor(due))
            if due < log.step + 1:
                self._stage(log.step + 1)
                due = self.forecast.next() / dt
            if log.open and log.step >= self._watch:
                self._gather()
            stop = min(end, self._watch if log.open else self._hold, due)
            self._run(math.floor(stop))
            if not log.open and log.step >= self._hold and self.bodies.shot_of:
                self._landed()
                self.bodies.park_all()

    def _stage(self, before: int) -> None:
        """Put the partners of every contact due before step ``before`` into YADE."""
        now, dt = self.logger.clock(), self.logger.dt
        while self.forecast.next() / dt < before:
            _, partners = self.forecast.take()
            for shot in partners:
                if shot.body < 0:
                    self.bodies.put(shot, now)
            if len(partners) == 1:
                self.bodies.target.expect(partners[0], now)
                self._landing[partners[0]] = partners[0].flight
        self.bodies.refresh()
        self._hold = before + GRACE_STEPS

    def _landed(self) -> None:
        """Two shots may graze between two steps, but who was about to strike the target must have."""
        for shot, flight in self._landing.items():
            if shot.flight == flight:
                raise FlowFailed(f"shot {shot.shot_id} met the target, but YADE found no contact")
        self._landing.clear()

    def _run(self, stop: int) -> None:
        """Step until ``stop`` or until contacts begin or end."""
        log, step, count = self.logger, O.step, O.interactions.countReal
        if len(log.open) == 1 and not log.watched:
            log.follow_one(stop)
            return
        now = begun = log.step
        while now < stop:
            step()
            now += 1
            if log.open or count():
                log.step = now
                if log.after_step():
                    break
        log.step = now
        log.executed += now - begun

    def _gather(self) -> None:
        """Put every free shot that could reach an open contact within ``WATCH_STEPS`` into YADE."""
        log, bodies = self.logger, self.bodies
        now, ahead = log.clock(), WATCH_STEPS * log.dt
        held = [shot for shot in bodies.shot_of.values() if shot.open]
        energy = sum(shot.energy_J() for shot in held)  # of before the contact: it can only shrink
        supported = {shot for c in log.open.values() if c.on_target for shot in c.shots}
        came = False
        for shot in held:
            if shot not in supported:
                bodies.target.support(shot, bodies.place(shot), now)
                came = True
            reach = shot.radius + math.sqrt(2.0 * energy / shot.mass) * ahead
            for other in self.fleet.near(bodies.place(shot), reach, ahead, now):
                if other.body < 0:
                    bodies.put(other, now)
                    came = True
        if came:
            bodies.refresh()
        self._watch = log.step + WATCH_STEPS

    def _held(self, shot: Flying) -> None:
        self.fleet.hold(shot)
        self._watch = -1

    def renew_all(self, now: float) -> None:
        """The free shots were all kicked."""
        for shot in self.bodies.shot_of.values():
            if not shot.open:
                self.bodies.set_motion(shot, now)
        self.forecast.renew_all(now)

    def _freed(self, shots, now: float) -> None:
        for shot in shots:
            if self.kicks:
                self.kicks.begin(shot, now)
                self.bodies.set_motion(shot, now)
            self.fleet.renew(shot)
        for shot in shots:
            self.forecast.renew(shot, now)
