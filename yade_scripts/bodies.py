"""The bodies in YADE that shots use while they are needed there: a pool, recycled by moving them.

YADE never reuses the id of an erased body and insertion gets slower with every id used.  A body without a
shot is parked far away under another group mask: the integrator skips it, the collider finds it no partner.
"""

from __future__ import annotations

import math

from yade import O

from contact_model import LIVE, PARKED, add_shot, look_for_partners, sort_anew
from flight import Flying, FlowFailed


class Bodies:
    """``shot_of`` maps a body's id to the shot that has it. ``materials`` are YADE's, by medium."""

    def __init__(self, materials, target):
        self.materials, self.target = materials, target
        self.shot_of: dict[int, Flying] = {}
        self._parked: list[int] = []
        self._medium: dict[int, int] = {}

    def put(self, shot: Flying, now: float) -> None:
        """Give the free ``shot`` a body, exactly where its flight has it; then ``look_for_partners``."""
        if not self._parked:
            body = add_shot(self.materials[shot.medium], 2.0 * shot.radius, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            self._parked.append(body)
            self._medium[body] = shot.medium
        shot.body = self._parked.pop()
        self.shot_of[shot.body] = shot
        body = O.bodies[shot.body]
        body.mask = LIVE
        state = body.state
        if (
            state.mass != shot.mass
            or body.shape.radius != shot.radius
            or self._medium[shot.body] != shot.medium
        ):
            body.shape.radius = shot.radius
            body.material = O.materials[self.materials[shot.medium]]
            self._medium[shot.body] = shot.medium
            state.mass = shot.mass
            state.inertia = (0.4 * shot.mass * shot.radius**2,) * 3
        state.pos, state.vel, state.angVel = shot.at(now), shot.vel, shot.spin

    def park(self, shot: Flying) -> None:
        """Take the body of ``shot``, which is in no contact, away from it."""
        self.check_flight(shot)
        body = O.bodies[shot.body]
        body.mask = PARKED
        body.state.pos = (
            1e3 + shot.body,
            0.0,
            1e3,
        )  # away from contacts that the collider still thinks possible
        body.state.vel = body.state.angVel = (0.0, 0.0, 0.0)
        self.target.release(shot)
        del self.shot_of[shot.body]
        self._parked.append(shot.body)
        shot.body = -1

    def park_all(self) -> None:
        """No contact is open: every shot in here flies on by itself."""
        for shot in list(self.shot_of.values()):
            self.park(shot)
        self._parked.sort(reverse=True)  # the next contact begins with the same bodies, whatever came before

    def patch(self, key: tuple[int, int]):
        """The piece of target that the contact of these two bodies is with; None when both are shots."""
        return self.target.patches.get(key[0]) or self.target.patches.get(key[1])

    def place(self, shot: Flying) -> tuple[float, float, float]:
        """Position [m] in YADE."""
        p = O.bodies[shot.body].state.pos  # a live view; iterating it is slow
        return p[0], p[1], p[2]

    def motion(self, shot: Flying) -> tuple[tuple, tuple]:
        """(velocity [m/s], spin [rad/s]) in YADE."""
        state = O.bodies[shot.body].state
        v, w = state.vel, state.angVel
        return (v[0], v[1], v[2]), (w[0], w[1], w[2])

    def set_motion(self, shot: Flying, now: float) -> None:
        """Move the body of the free ``shot``, if it has one, as its flight now has it."""
        if shot.body >= 0:
            state = O.bodies[shot.body].state
            state.pos, state.vel = shot.at(now), shot.vel

    def check_flight(self, shot: Flying, now: float | None = None) -> None:
        """A free shot must fly as its last contact left it: else a contact was missed. Raises FlowFailed."""
        vel = self.motion(shot)[0]
        if vel != shot.vel:
            raise FlowFailed(
                f"shot {shot.shot_id} changed its velocity without a logged contact ({shot.vel} to {vel})"
            )
        if now is not None and not math.dist(self.place(shot), shot.at(now)) < 1e-3 * shot.radius:
            raise FlowFailed(f"shot {shot.shot_id} is off its straight flight at t = {now:.6g} s")

    def refresh(self) -> None:
        """After bodies were moved by hand: have the collider look at every pair (4 us with the few of a pool).

        Looking only at those whose order has changed, as it does by itself, is not enough: two bodies with
        overlapping boxes that were not to touch (by their masks), then moved together and to touch, show no change.
        """
        sort_anew()
        look_for_partners()
