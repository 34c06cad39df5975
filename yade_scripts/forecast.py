"""When can the next contact begin?  Straight flight makes it a quadratic per pair, asked once per change.

Between contacts every shot flies straight at constant velocity, so the moment at which two of them touch,
or one touches the target, is exact.  ``Forecast`` keeps these moments in a heap; an entry is void once
either of its shots has changed its flight since.
"""

from __future__ import annotations

import heapq
import math
from itertools import count


def touch_time_s(a, b, now: float) -> float:
    """When the flying shots ``a`` and ``b`` touch [s], infinity when they do not.

    |p + v s| = Ra + Rb for relative position p and velocity v, s after ``now``: the earlier root.
    """
    (ax, ay, az), (bx, by, bz) = a.at(now), b.at(now)
    x, y, z = bx - ax, by - ay, bz - az
    u, v, w = b.vel[0] - a.vel[0], b.vel[1] - a.vel[1], b.vel[2] - a.vel[2]
    approach = x * u + y * v + z * w
    if approach >= 0.0:
        return math.inf
    speed2 = u * u + v * v + w * w
    gap2 = x * x + y * y + z * z - (a.radius + b.radius) ** 2
    if gap2 <= 0.0:
        return now
    root2 = approach * approach - speed2 * gap2
    return now + gap2 / (-approach + math.sqrt(root2)) if root2 > 0.0 else math.inf


def landing_time_s(shot, now: float) -> float:
    """When the flying shot touches the target [s], infinity when it does not fall."""
    fall = -shot.vel[2]
    return max(now, shot.t + (shot.pos[2] - shot.radius) / fall) if fall > 0.0 else math.inf


class Forecast:
    """The next possible contact among free shots."""

    def __init__(self):
        self._heap = []
        self._order = count()  # ties: heap entries must not compare shots

    def renew(self, shot, others, now: float) -> None:
        """``shot`` flies freely from ``now`` on: foresee its contacts with target and free ``others``."""
        shot.flight += 1
        self._push(landing_time_s(shot, now), shot, shot)
        for other in others:
            if other is not shot and not other.open:
                self._push(touch_time_s(shot, other, now), shot, other)

    def _push(self, t, a, b) -> None:
        if t < math.inf:
            heapq.heappush(self._heap, (t, next(self._order), a, a.flight, b, b.flight))

    def next(self, since: float) -> float:
        """The earliest contact foreseen [s] that begins after ``since``; infinity when none is."""
        heap = self._heap
        while heap:
            t, _, a, flight_a, b, flight_b = heap[0]
            if t >= since and a.flight == flight_a and b.flight == flight_b:
                return t
            heapq.heappop(heap)
        return math.inf
