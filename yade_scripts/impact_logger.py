"""The impact logger: sees contacts begin and end in YADE and turns them into impact rows.

How a contact is seen.  Between contacts a shot flies straight at constant velocity, so its state at the end
of its last contact (or at the nozzle) *is* its state just before the next one, bit for bit, and first touch
and separation follow from it exactly below the step.  While a contact with the target is open, its peak
force is the largest of |normalForce - normalViscous| over all its steps.

Who makes the steps calls ``look`` whenever the real contacts in YADE differ from the open ones here; see
``leaps.py`` and ``plain_steps.py``.  That is a Python loop over ``O.step()`` and not a ``PyRunner`` because it
was measured: a PyRunner call costs 11-13 us even when it does nothing, an ``O.step()`` from Python .7 us more
than a step of ``O.run`` (which, moreover, swallows exceptions).
"""

from __future__ import annotations

import math

from yade import O

from flight import Flying, FlowFailed
from glue.flow.arrivals import COLUMNS

ENERGY_TOLERANCE = 0.01  # kinetic energy that a contact may gain; elastic ones at dt = 1.0 P scatter by .3 %
_COPIED = [COLUMNS.names.index(n) for n in ("diameter_m", "density_kg_m3", "nozzle_id", "pass_id", "medium")]


class Contact:
    """An open contact; what its row will need of the time before it, when it is one with the target."""

    __slots__ = (
        *("interaction", "phys", "shots", "on_target", "begin", "point", "normal", "vel", "spin"),
        *("collisions", "peak"),
    )

    def __init__(self, interaction, shots, on_target):
        self.interaction, self.phys = interaction, interaction.phys
        self.shots, self.on_target = shots, on_target
        self.peak = 0.0

    def sample(self) -> bool:
        """Take the normal force of this step into the peak: YADE keeps elastic part and dashpot apart.

        True while it is (nearly) the largest yet: the force of a contact left to itself then only falls.
        """
        force = (self.phys.normalForce - self.phys.normalViscous).norm()
        self.peak = max(self.peak, force)
        return force >= 0.95 * self.peak


class ImpactLogger:
    """Follows the contacts of the shots that ``bodies`` has in YADE; impact rows go to ``emit`` by first touch.

    Who makes the steps sets ``held``, called with every shot that gets into contact, and ``freed``, called with
    the shots whose last contact has ended and the time.  ``tune`` (optional) is called with every contact that
    begins, after its first step; without ``forces`` peak forces are nan.
    Time [s] is ``step`` times ``dt_s``: a sum of 3e7 steps would lose nanoseconds.
    """

    def __init__(self, emit, bodies, target, *, dt_s: float, speed_limit_m_s: float, tune=None, forces=True):
        self.emit, self.bodies, self.target, self.tune, self.forces = emit, bodies, target, tune, forces
        self.dt = dt_s
        self.step = 0  # the caller may set it, before the first shot, to start before time 0
        self.executed = 0  # steps that YADE made
        self.speed_limit = speed_limit_m_s
        self.held, self.freed = (lambda shot: None), (lambda shots, now: None)
        self.open: dict[tuple[int, int], Contact] = {}
        self.waiting: list[tuple] = []  # finished rows that an older contact, still open, must precede
        self.collisions = 0  # shot on shot, each counted once
        self.top_speed = 0.0
        self.worst_gain = -math.inf  # largest relative gain of kinetic energy in contacts
        self.worst_momentum = 0.0  # largest relative change of momentum in collisions between shots
        # since the last moment without contact, by shot_id: (energy, momentum) before it, and after
        self._before: dict[int, tuple[float, tuple]] = {}
        self._after: dict[int, tuple[float, tuple]] = {}
        self._target_touched = False
        self.watched: list[Flying] = []  # in contact with a shot while near the target

    def clock(self) -> float:
        return self.step * self.dt

    def after_step(self) -> bool:
        """To be called after every step while a contact is open; True when the contacts were another set."""
        changed = False
        if O.interactions.countReal() != len(self.open) or not all(
            c.interaction.isReal for c in self.open.values()
        ):
            self.look()
            changed = True
        for contact in self.open.values():
            if contact.on_target:
                contact.sample()
        for shot in self.watched:
            shot.before = self.bodies.motion(shot)
        return changed

    def follow_one(self, stop: int) -> None:
        """Make the steps up to ``stop`` while the only open contact stays that, the bulk of all steps."""
        (contact,) = self.open.values()
        step, count, interaction, sample = O.step, O.interactions.countReal, contact.interaction, contact.sample
        rising = contact.on_target
        now = begun = self.step
        while now < stop:
            step()
            now += 1
            if count() != 1 or not interaction.isReal:
                break
            if rising:
                rising = sample()
        self.step = now
        self.executed += now - begun
        if not (count() == 1 and interaction.isReal):
            self.after_step()

    def look(self) -> None:
        """Compare the open contacts with YADE's, which are another set than before the last step."""
        now = self.clock()
        real = {tuple(sorted((i.id1, i.id2))): i for i in O.interactions if i.isReal}
        ended = [
            self.open.pop(k) for k, c in list(self.open.items()) if not (k in real and c.interaction.isReal)
        ]
        for contact in ended:
            self._end(contact, now)
        # targets first: a collision that begins in the same step has had no time to change the velocity
        for key in sorted(real.keys() - self.open.keys()):
            self.open[key] = self._begin(key, real[key], now)
        self.watched = [
            shot
            for c in self.open.values()
            if not c.on_target
            for shot in c.shots
            if self.target.near(self.bodies.place(shot), 3.0 * shot.radius)
        ]
        free = dict.fromkeys(shot for c in ended for shot in c.shots if not shot.open)
        if free:
            self.freed(free, now)
        if not self.open:
            self._balance()
        if self.waiting:
            self._release(now)

    def _begin(self, key, interaction, now) -> Contact:
        patch = self.bodies.patch(key)
        shots = [self.bodies.shot_of[b] for b in key if b in self.bodies.shot_of]
        contact = Contact(interaction, shots, patch is not None)
        for shot in shots:
            shot.flight += 1  # voids what was foreseen of it
            self.held(shot)
            self._before.setdefault(shot.shot_id, _balance_of(shot))
        if contact.on_target:
            (shot,) = shots
            self._target_touched = True
            contact.collisions = shot.collisions
            if shot.open:  # still held by another shot: the state one step ago is the best there is
                contact.vel, contact.spin = shot.before or self.bodies.motion(shot)
                contact.begin = now
                contact.point, contact.normal = patch.under(self.bodies.place(shot))
            else:
                contact.vel, contact.spin = shot.vel, shot.spin
                contact.begin, contact.point, contact.normal = patch.struck_by(shot)
        else:
            self.collisions += 1
            for shot in shots:
                shot.collisions += 1
        for shot in shots:
            shot.open += 1
        if self.tune:
            self.tune(contact)
        return contact

    def _end(self, contact: Contact, now: float) -> None:
        for shot in contact.shots:
            shot.open -= 1
            shot.t = shot.true_at = now
            shot.pos = self.bodies.place(shot)
            shot.vel, shot.spin = self.bodies.motion(shot)
            shot.before = None
            self._after[shot.shot_id] = _balance_of(shot)
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
        (x, y, z), normal = contact.point, contact.normal
        end = now
        climb = sum(n * v for n, v in zip(normal, shot.vel))
        if shot.open == 0 and climb > 0.0:
            height = sum(n * (p - q) for n, p, q in zip(normal, shot.pos, contact.point))
            end = now - (height - shot.radius) / climb
        shot.impacts += 1
        diameter, density, *labels = (shot.arrival[i] for i in _COPIED)
        self.waiting.append(
            (
                *(shot.shot_id, contact.begin, end - contact.begin, x, y),
                *(*contact.vel, *contact.spin, *shot.vel, *shot.spin),
                *(diameter, density, contact.peak if self.forces else math.nan, contact.collisions, z, *normal, *labels),
            )
        )

    def _release(self, now: float) -> None:
        """Emit the rows that no impact still open or undiscovered can precede."""
        # a step finds contacts at the positions it starts from: one that begins in it is seen a step later
        safe = min([now - 2.0 * self.dt] + [c.begin for c in self.open.values() if c.on_target])
        ready = sorted((r for r in self.waiting if r[1] < safe), key=lambda r: (r[1], r[0]))
        if ready:
            self.waiting = [r for r in self.waiting if not r[1] < safe]
            self.emit(ready)

    def flush(self) -> None:
        """Emit what is left: at the end, or when no contact is open and none can have begun before now."""
        self._release(math.inf)

    def _balance(self) -> None:
        """No contact is open: energy and momentum of the shots that touched must account for themselves."""
        before = sum(energy for energy, _ in self._before.values())
        after = sum(energy for energy, _ in self._after.values())
        gain = after / before - 1.0
        self.worst_gain = max(self.worst_gain, gain)
        if not gain <= ENERGY_TOLERANCE:
            raise FlowFailed(
                f"kinetic energy rises by {gain:.2%} in a contact of shots {sorted(self._before)}:"
                " the time step is too large"
            )
        if not self._target_touched:
            size = sum(math.hypot(*p) for _, p in self._before.values())
            change = [
                sum(p[k] for _, p in self._after.values()) - sum(p[k] for _, p in self._before.values())
                for k in range(3)
            ]
            self.worst_momentum = max(self.worst_momentum, math.hypot(*change) / size)
        self._before.clear()
        self._after.clear()
        self._target_touched = False


def _balance_of(shot: Flying) -> tuple[float, tuple]:
    """(kinetic energy [J], momentum [kg m/s]) of its last free state."""
    return shot.energy_J(), tuple(shot.mass * c for c in shot.vel)
