"""When can the next contact begin?  Straight flight makes it exact, asked once per change of flight.

``Forecast`` keeps the foreseen moments in a heap; an entry is void once either of its shots has changed
its flight since.
"""

from __future__ import annotations

import heapq
import math

from flight import Fleet, Flying


def landing_time_s(shot: Flying, now: float) -> float:
    """When the flying shot touches the plane z = 0 [s], infinity when it does not fall."""
    fall = -shot.vel[2]
    return max(now, shot.t + (shot.pos[2] - shot.radius) / fall) if fall > 0.0 else math.inf


class Forecast:
    """The next contacts among the free shots of ``fleet`` and with the target.

    ``landing`` foresees the contact of one shot with the target, as ``landing_time_s``.
    """

    def __init__(self, fleet: Fleet, landing=landing_time_s):
        self.fleet, self.landing = fleet, landing
        self._heap: list[tuple] = []  # (time, count, a, flight of a, b, flight of b); b = a: with the target
        self._count = 0  # ties: heap entries must not compare shots

    def renew(self, shot: Flying, now: float) -> None:
        """``shot`` flies freely from ``now`` on: foresee its contacts with target and free shots."""
        shot.flight += 1
        self._push(self.landing(shot, now), shot, shot)
        for t, other in self.fleet.touches(shot, now):
            self._push(t, shot, other)

    def renew_all(self, now: float) -> None:
        """All free shots changed their flight at ``now``: forget the old ones, foresee anew."""
        self._heap = []
        free = [shot for shot in self.fleet.shots if not shot.open]
        for shot in free:
            shot.flight += 1
        for shot in free:
            self._push(self.landing(shot, now), shot, shot)
        for t, a, b in self.fleet.all_touches(now):
            self._push(t, a, b)

    def _push(self, t: float, a: Flying, b: Flying) -> None:
        if t < math.inf:
            heapq.heappush(self._heap, (t, self._count, a, a.flight, b, b.flight))
            self._count += 1

    def next(self) -> float:
        """The earliest contact foreseen [s]; infinity when none is."""
        heap = self._heap
        while heap:
            t, _, a, flight_a, b, flight_b = heap[0]
            if a.flight == flight_a and b.flight == flight_b:
                return t
            heapq.heappop(heap)
        return math.inf

    def take(self) -> tuple[float, tuple[Flying, ...]]:
        """Remove the contact that ``next`` told of: (time, its one or two shots)."""
        t, _, a, _, b, _ = heapq.heappop(self._heap)
        return t, (a,) if a is b else (a, b)

    def state(self) -> list[tuple]:
        """The valid entries for a checkpoint: (time, shot_id a, shot_id b), in their order."""
        valid = [e for e in sorted(self._heap) if e[2].flight == e[3] and e[4].flight == e[5]]
        return [(t, a.shot_id, b.shot_id) for t, _, a, _, b, _ in valid]

    def restore(self, entries, shots: dict[int, Flying]) -> None:
        """Put back what ``state`` gave; ``shots`` by shot_id."""
        for t, a, b in entries:
            self._push(t, shots[int(a)], shots[int(b)])
