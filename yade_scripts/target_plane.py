"""The flat target: one plane z = 0, body 0, for all shots."""

from __future__ import annotations

import math

from flight import Flying
from forecast import landing_time_s

WALL = 0  # body id of the target plane
UP = (0.0, 0.0, 1.0)


class PlaneTarget:
    """A target for ``Bodies`` and ``ImpactLogger``; it is its only patch."""

    def __init__(self):
        self.patches = {WALL: self}

    below_m = math.inf  # how far it reaches below z = 0

    landing = staticmethod(landing_time_s)

    def leaving(self, vel):
        """Which of the velocities (3, n) may be of shots that strike no more, (n,) bool; at least all that are."""
        return vel[2] >= 0.0

    def near(self, place, distance_m: float) -> bool:
        """Is the point within ``distance_m`` of the surface?"""
        return place[2] < distance_m

    def depth_m(self, place) -> float:
        """How far the point lies below the surface (negative above)."""
        return -place[2]

    def struck_by(self, shot: Flying) -> tuple[float, tuple, tuple]:
        """(moment of first touch [s], touched point, normal) of a shot in free flight."""
        begin = shot.t + (shot.pos[2] - shot.radius) / -shot.vel[2]
        x, y, _ = shot.at(begin)
        return begin, (x, y, 0.0), UP

    def under(self, place) -> tuple[tuple, tuple]:
        """(touched point, normal) of a shot that is at ``place`` and touches."""
        return (place[0], place[1], 0.0), UP

    def expect(self, shot: Flying, now: float) -> None:
        """The plane is there already (a curved target lays a facet, see ``target_curved.py``)."""

    def support(self, shot: Flying, place, now: float) -> None:
        """As ``expect``."""

    def release(self, shot: Flying) -> None:
        """As ``expect``."""
