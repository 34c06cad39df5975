"""Plain stepping: every live shot is a body in YADE all the time, every step of ``dt`` is made.

The yardstick of ``leaps.py``: nothing is foreseen, so nothing can be foreseen wrongly.
"""

from __future__ import annotations

from yade import O

from bodies import Bodies
from contact_model import look_for_partners
from flight import Fleet, Flying
from impact_logger import ImpactLogger

SETTLE_STEPS = 4000


class PlainSteps:
    """As ``leaps.Leaps``. YADE is asked for contacts every ``stride`` steps, while one is open after each.

    A contact shorter than ``stride`` steps may be missed by the log (not by the shots); ``grazes`` counts those
    that a later question found.
    """

    name = "plain"

    def __init__(self, fleet: Fleet, bodies: Bodies, logger: ImpactLogger, stride: int = 1):
        self.fleet, self.bodies, self.logger, self.stride = fleet, bodies, logger, stride
        self.kicks = None  # begins every free flight with a kick, where there is drag or gravity
        self.grazes = 0
        self._settled = 0
        logger.held, logger.freed = fleet.hold, self._freed

    def add(self, shot: Flying) -> None:
        """``shot`` flies from now on."""
        if self.kicks:
            self.kicks.begin(shot, shot.t)
        self.fleet.add(shot)
        self.bodies.put(shot, self.logger.clock())
        look_for_partners()

    def remove(self, shot: Flying) -> None:
        """``shot``, which is in no contact, leaves the simulation."""
        self._settle(shot)
        self.bodies.park(shot)
        self.fleet.remove(shot)

    def advance(self, steps: int) -> None:
        """Go on by ``steps`` time steps. Raises FlowFailed as soon as a contact gives what no contact can."""
        log, step, count, stride = self.logger, O.step, O.interactions.countReal, self.stride
        end = log.step + steps
        if stride > 1 and log.step >= self._settled + SETTLE_STEPS:
            for shot in self.fleet.shots:
                if not shot.open:
                    self._settle(shot)
            self._settled = log.step
        while log.step < end:
            if len(log.open) == 1 and not log.watched:
                log.follow_one(end)
                continue
            n = 1 if log.open else min(stride, end - log.step)
            for _ in range(n):
                step()
            log.step += n
            log.executed += n
            if log.open or count():
                log.after_step()

    def renew_all(self, now: float) -> None:
        """The free shots were all kicked."""
        for shot in self.fleet.shots:
            if not shot.open:
                self.bodies.set_motion(shot, now)

    def _settle(self, shot: Flying) -> None:
        """Where the free ``shot`` was turned by a contact that fell between two questions, take note of it."""
        motion = self.bodies.motion(shot)
        if self.stride > 1 and motion[0] != shot.vel:
            shot.t, shot.pos = self.logger.clock(), self.bodies.place(shot)
            shot.vel, shot.spin = motion
            shot.collisions += 1
            self.grazes += 1
            self.fleet.renew(shot)

    def _freed(self, shots, now: float) -> None:
        for shot in shots:
            shot.flight += 1
            if self.kicks:
                self.kicks.begin(shot, now)
                self.bodies.set_motion(shot, now)
            self.fleet.renew(shot)
