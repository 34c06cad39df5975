"""A curved target: for every contact its own small facet, laid on the true surface where it is touched.

Facets that tile the surface make a trap: a shot on the shared edge of two has two contacts (restitution .61
instead of .70, peak force 25 % high).  Here the touched point and the normal there are foreseen exactly on the
true surface (``glue.flow.surface``), and a facet is laid there as the tangent plane just before the contact.
It answers to one body only (a group mask of its own), so two shots that strike the same spot at once do not
meet each other's facet either.  Away from the touched point the plane leaves the surface by w^2 / (2 radius of
curvature): .4 um at a contact radius of .2 mm on a 50 mm cylinder.

Beyond it: a shot that touches a concave edge meets its two sides one after the other, not at once.
"""

from __future__ import annotations

import math

from yade import O, utils
from yade.minieigenHP import Quaternion, Vector3

from flight import Flying, FlowFailed
from glue.flow.surface import TargetSurface

FIRST_BIT, LAST_BIT = 2, 30  # of the group masks; 0 and 1 are LIVE and PARKED
SIDE_RADII = 12.0  # side of a facet in shot radii: contacts reach .6 radii out, sliding about as much
NEAR_RADII = 3.0  # a shot in contact with another gets a facet when its centre is nearer to the surface


class Patch:
    """A facet, and what it lies under at present."""

    def __init__(self, material: int, radius_m: float, bit: int):
        far, side = Vector3(1e3, 0.0, 1e3 + bit), SIDE_RADII * radius_m
        corners = [
            far + Vector3(side / math.sqrt(3.0) * math.cos(a), side / math.sqrt(3.0) * math.sin(a), 0.0)
            for a in (math.radians(d) for d in (90.0, 210.0, 330.0))
        ]
        self.far, self.bit = far, 1 << bit
        self.body = O.bodies.append(utils.facet(corners, material=material, wire=True))
        O.bodies[self.body].mask = self.bit

    def lay(self, shot: Flying, begin_s: float, point, normal) -> None:
        """Put the facet under ``shot`` as the plane through ``point`` across ``normal``."""
        self.begin, self.point, self.normal = begin_s, point, normal
        state = O.bodies[self.body].state
        state.pos = point
        turn = Quaternion()
        turn.setFromTwoVectors(Vector3(0.0, 0.0, 1.0), Vector3(*normal))
        state.ori = turn
        O.bodies[shot.body].mask |= self.bit

    def lift(self) -> None:
        O.bodies[self.body].state.pos = self.far

    def struck_by(self, shot: Flying) -> tuple[float, tuple, tuple]:
        """(moment of first touch [s], touched point, normal) of a shot in free flight."""
        return self.begin, self.point, self.normal

    def under(self, place) -> tuple[tuple, tuple]:
        """(touched point, normal) of a shot that is at ``place`` and touches."""
        height = sum(n * (p - q) for n, p, q in zip(self.normal, place, self.point))
        return tuple(p - height * n for p, n in zip(place, self.normal)), self.normal


class CurvedTarget:
    """As ``target_plane.PlaneTarget``, for any ``surface``."""

    def __init__(self, surface: TargetSurface, material: int, largest_radius_m: float):
        self.surface, self.material, self.largest = surface, material, largest_radius_m
        self.patches: dict[int, Patch] = {}
        self._of: dict[int, Patch] = {}  # by the body whose it is
        self.below_m = -surface.lowest_m

    def _strike(self, shot: Flying):
        """(time, point, normal) of the next touch of a free shot; asked once per flight."""
        if shot.strike is None or shot.strike[0] != shot.flight:
            t, point, normal = self.surface.touch(shot.pos, shot.vel, shot.radius)
            shot.strike = shot.flight, shot.t + t, point, normal
        return shot.strike[1:]

    def landing(self, shot: Flying, now: float) -> float:
        """When the flying shot touches the target [s], infinity when it does not."""
        return self._strike(shot)[0]

    def leaving(self, vel):
        """Which of the velocities (3, n) may be of shots that strike no more: any."""
        return vel[2] == vel[2]

    def near(self, place, distance_m: float) -> bool:
        return self.surface.clearance(place) < distance_m

    def depth_m(self, place) -> float:
        return -self.surface.clearance(place)

    def expect(self, shot: Flying, now: float) -> None:
        """``shot``, free and in YADE, is about to land: lay a facet there."""
        t, point, normal = self._strike(shot)
        if t < math.inf:
            self._patch_for(shot).lay(shot, t, point, normal)

    def support(self, shot: Flying, place, now: float) -> None:
        """``shot`` is in contact with others only and may be pushed against the target: lay a facet below it."""
        if not self.surface.clearance(place) < NEAR_RADII * shot.radius:
            return
        h = 1e-3 * shot.radius
        slope = [
            self.surface.clearance([c + h * (i == k) for i, c in enumerate(place)])
            - self.surface.clearance([c - h * (i == k) for i, c in enumerate(place)])
            for k in range(3)
        ]
        _, point, normal = self.surface.touch(place, [-s / math.hypot(*slope) for s in slope], h)
        if any(normal):
            self._patch_for(shot).lay(shot, now, point, normal)

    def _patch_for(self, shot: Flying) -> Patch:
        """The facet of the body that ``shot`` has: always the same, because the collider forgets no pair that
        could touch before it has seen the two apart, whatever their masks have become.
        """
        patch = self._of.get(shot.body)
        if patch is None:
            bit = FIRST_BIT + len(self._of)
            if bit > LAST_BIT:
                raise FlowFailed(f"more than {LAST_BIT - FIRST_BIT + 1} shots near the curved target at once")
            patch = self._of[shot.body] = Patch(self.material, self.largest, bit)
            self.patches[patch.body] = patch
        return patch

    def release(self, shot: Flying) -> None:
        """``shot`` leaves YADE: its facet leaves the target."""
        if shot.body in self._of:
            self._of[shot.body].lift()
