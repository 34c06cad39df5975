"""The impact logger: steps the simulation, sees contacts begin and end, and turns them into impact rows.

``ImpactLogger.advance`` is the custom engine callback of this project.  It is called from a Python
loop over ``O.step()`` and not from a ``PyRunner`` because that was measured: a PyRunner call costs
11-13 us even when it does nothing, an ``O.step()`` from Python .7 us more than a step of ``O.run``
(which, moreover, swallows exceptions).

How a contact is seen.  Between contacts a shot flies straight at constant velocity, so its state at
the end of its last contact (or at the nozzle) *is* its state just before the next one, bit for bit,
and first touch and separation follow from it exactly below the step.  The number of real contacts is
asked after every step (.1 us): two shots that graze may touch for a single one.  While any is open,
the peak force is the largest of |normalForce - normalViscous| over all its steps.

``leap`` crosses free flight in one large step.  The next contact is foreseen exactly (``forecast.py``);
up to two steps before it nothing but x + v t can happen, which a step of any length gives to rounding.
Leaps are whole numbers of ``dt``, so every contact meets the same sub-step phase as without them.
"""

from __future__ import annotations

import math

from yade import O

from contact_model import total_force_N
from forecast import Forecast

WALL = 0  # body id of the target plane
ENERGY_TOLERANCE = 0.01  # kinetic energy that a contact may gain; elastic ones at dt = 1.0 P scatter by .3 %


class FlowFailed(Exception):
    """A check of the running or finished simulation says that its result is wrong: one line, the cause."""


class Flying:
    """One shot on its way: who it is, and ``t, pos, vel, spin`` (SI) at the end of its last contact."""

    def __init__(self, arrival, body: int, mass: float):
        self.arrival = arrival  # a row of the arrivals (glue.flow.arrivals.COLUMNS)
        self.body = body
        self.shot_id = int(arrival["shot_id"])
        self.radius = 0.5 * float(arrival["diameter_m"])
        self.mass = mass
        self.t = float(arrival["time_s"])
        self.pos = tuple(float(arrival[c]) for c in ("x_m", "y_m", "z_m"))
        self.vel = tuple(float(arrival[c]) for c in ("vx_m_s", "vy_m_s", "vz_m_s"))
        self.spin = (0.0, 0.0, 0.0)
        self.start_speed = math.hypot(*self.vel)
        self.collisions = 0  # with other shots
        self.impacts = 0
        self.open = 0  # contacts open now; the state above is old while there are any
        self.flight = 0  # counts the changes of flight
        self.before = None  # while contacts are open: (vel, spin) at the step before this one

    def at(self, now: float) -> tuple[float, float, float]:
        """Position [m] at time ``now``; exact while no contact is open."""
        dt = now - self.t
        (x, y, z), (u, v, w) = self.pos, self.vel
        return x + u * dt, y + v * dt, z + w * dt

    def energy_J(self) -> float:
        """Kinetic energy, spin included, of the last free state."""
        inertia = 0.4 * self.mass * self.radius**2
        return 0.5 * (self.mass * sum(c * c for c in self.vel) + inertia * sum(c * c for c in self.spin))


class Contact:
    """An open contact; what its row will need of the time before it, when it is one with the target."""

    __slots__ = ("interaction", "shots", "on_target", "begin", "point", "vel", "spin", "collisions", "peak")

    def __init__(self, interaction, shots, on_target):
        self.interaction, self.shots, self.on_target = interaction, shots, on_target
        self.peak = 0.0


class ImpactLogger:
    """Runs the simulation step by step and hands impact rows to ``emit`` in order of first touch.

    ``live`` maps body id to ``Flying``; shots come and go by ``add`` and ``remove`` between calls of
    ``advance``.  Time [s] is ``step`` times ``dt_s``: a sum of 3e7 steps would lose nanoseconds.
    """

    def __init__(self, emit, *, dt_s: float, speed_limit_m_s: float, leap: bool = False):
        self.live: dict[int, Flying] = {}
        self.emit = emit
        self.dt = dt_s
        self.step = 0  # the caller may set it, before the first shot, to start before time 0
        self.executed = 0  # steps that YADE made; a leap is one
        self.speed_limit = speed_limit_m_s
        self.forecast = Forecast() if leap else None
        self.open: dict[tuple[int, int], Contact] = {}
        self.waiting: list[tuple] = []  # finished rows that an older contact, still open, must precede
        self.collisions = 0  # shot on shot, each counted once
        self.top_speed = 0.0
        self.worst_gain = -math.inf  # largest relative gain of kinetic energy in contacts
        self.worst_momentum = 0.0  # largest relative change of momentum in collisions between shots
        # since the last moment without contact: body -> (shot, energy, momentum) before it
        self._touched: dict[int, tuple[Flying, float, tuple]] = {}
        self._target_touched = False

    def clock(self) -> float:
        return self.step * self.dt

    def add(self, shot: Flying) -> None:
        """``shot`` flies from now on."""
        self.live[shot.body] = shot
        if self.forecast:
            self.forecast.renew(shot, self.live.values(), self.clock())

    def remove(self, shot: Flying) -> None:
        """``shot``, which is in no contact, leaves the simulation."""
        del self.live[shot.body]
        shot.flight += 1  # voids what was foreseen of it

    def advance(self, steps: int) -> None:
        """Go on by ``steps`` time steps. Raises FlowFailed as soon as a contact gives what no contact can."""
        step, contacts, end = O.step, O.interactions.countReal, self.step + steps
        while self.step < end:
            if self.forecast and not self.open and self._leap(end):
                continue
            step()
            self.step += 1
            self.executed += 1
            if self.open or contacts():
                self._look(contacts())

    def _leap(self, end: int) -> bool:
        """Cross free flight towards step ``end`` in one step, if there are at least two to save."""
        # a contact foreseen three steps ago and not there now was a graze between two steps
        foreseen = self.forecast.next((self.step - 3) * self.dt) / self.dt
        steps = math.floor(min(end, foreseen - 2.0)) - self.step
        if steps < 2:
            return False
        O.dt = steps * self.dt
        O.step()
        O.dt = self.dt
        self.step += steps
        self.executed += 1
        return True

    def _look(self, count: int) -> None:
        """Compare the open contacts with YADE's after a step."""
        now = self.clock()
        if count != len(self.open) or not all(c.interaction.isReal for c in self.open.values()):
            real = {tuple(sorted((i.id1, i.id2))): i for i in O.interactions if i.isReal}
            ended = [self.open.pop(k) for k, c in list(self.open.items()) if not c.interaction.isReal]
            for contact in ended:
                self._end(contact, now)
            # targets first: a collision that begins in the same step has had no time to change the velocity
            for key in sorted(real.keys() - self.open.keys()):
                self.open[key] = self._begin(key, real[key], now)
            if self.forecast:
                for shot in dict.fromkeys(s for c in ended for s in c.shots if not s.open):
                    self.forecast.renew(shot, self.live.values(), now)
            if not self.open:
                self._balance()
            if self.waiting:
                self._release(now)
        for contact in self.open.values():
            if contact.on_target:
                contact.peak = max(contact.peak, total_force_N(contact.interaction))
            for shot in contact.shots:
                state = O.bodies[shot.body].state
                shot.before = (tuple(state.vel), tuple(state.angVel))

    def _begin(self, key, interaction, now) -> Contact:
        on_target = WALL in key
        contact = Contact(interaction, [self.live[b] for b in key if b != WALL], on_target)
        for shot in contact.shots:
            if shot.body not in self._touched:
                momentum = tuple(shot.mass * c for c in shot.vel)
                self._touched[shot.body] = (shot, shot.energy_J(), momentum)
        if on_target:
            (shot,) = contact.shots
            self._target_touched = True
            contact.collisions = shot.collisions
            if shot.open:  # still held by another shot: the state one step ago is the best there is
                contact.vel, contact.spin = shot.before
                contact.begin = now
                contact.point = tuple(O.bodies[shot.body].state.pos)[:2]
            else:
                contact.vel, contact.spin = shot.vel, shot.spin
                contact.begin = shot.t + (shot.pos[2] - shot.radius) / -shot.vel[2]
                contact.point = shot.at(contact.begin)[:2]
        else:
            self.collisions += 1
            for shot in contact.shots:
                shot.collisions += 1
        for shot in contact.shots:
            shot.open += 1
        return contact

    def _end(self, contact: Contact, now: float) -> None:
        for shot in contact.shots:
            shot.open -= 1
            state = O.bodies[shot.body].state
            shot.t, shot.pos = now, tuple(state.pos)
            shot.vel, shot.spin = tuple(state.vel), tuple(state.angVel)
            speed = math.hypot(*shot.vel)
            self.top_speed = max(self.top_speed, speed)
            # a shot that met no other has no source of energy but the contact itself
            limit = self.speed_limit if shot.collisions else 1.1 * shot.start_speed
            if not speed <= limit:  # this way round, nan fails too
                raise FlowFailed(
                    f"shot {shot.shot_id} leaves a contact at {speed:.4g} m/s at t = {now:.6g} s"
                    f" (limit {limit:.4g}): the time step is too large"
                )
        if contact.on_target:
            self._row(contact, now)

    def _row(self, contact: Contact, now: float) -> None:
        (shot,) = contact.shots
        z, climb = shot.pos[2], shot.vel[2]
        end = now
        if shot.open == 0 and climb > 0.0:
            end = now - (z - shot.radius) / climb
        shot.impacts += 1
        a = shot.arrival
        row = (
            shot.shot_id,
            contact.begin,
            end - contact.begin,
            *contact.point,
            *contact.vel,
            *contact.spin,
            *shot.vel,
            *shot.spin,
            *(float(a[c]) for c in ("diameter_m", "density_kg_m3")),
            contact.peak,
            contact.collisions,
            *(0.0, 0.0, 0.0, 1.0),  # z of the target's surface, its normal
            *(int(a[c]) for c in ("nozzle_id", "pass_id", "medium")),
        )
        self.waiting.append(row)

    def _release(self, now: float) -> None:
        """Emit the rows that no impact still open or undiscovered can precede."""
        # a step finds contacts at the positions it starts from: one that begins in it is seen a step later
        safe = min([now - 2.0 * self.dt] + [c.begin for c in self.open.values() if c.on_target])
        ready = sorted((r for r in self.waiting if r[1] < safe), key=lambda r: (r[1], r[0]))
        if ready:
            self.waiting = [r for r in self.waiting if not r[1] < safe]
            self.emit(ready)

    def flush(self) -> None:
        """Emit what is left, at the end."""
        self._release(math.inf)

    def _balance(self) -> None:
        """No contact is open: energy and momentum of the shots that touched must account for themselves."""
        shots = list(self._touched.values())
        before = sum(e for _, e, _ in shots)
        after = sum(s.energy_J() for s, _, _ in shots)
        gain = after / before - 1.0
        self.worst_gain = max(self.worst_gain, gain)
        if not gain <= ENERGY_TOLERANCE:
            raise FlowFailed(
                f"kinetic energy rises by {gain:.2%} in a contact of shots"
                f" {sorted(s.shot_id for s, _, _ in shots)}: the time step is too large"
            )
        if not self._target_touched:
            size = sum(math.hypot(*p) for _, _, p in shots)
            change = [sum(s.mass * s.vel[k] - p[k] for s, _, p in shots) for k in range(3)]
            self.worst_momentum = max(self.worst_momentum, math.hypot(*change) / size)
        self._touched.clear()
        self._target_touched = False
