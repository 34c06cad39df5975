"""Shots in free flight: straight at constant velocity, so known at every moment from their last free state.

``Flying`` is one shot; ``Fleet`` holds the last free states of all live ones as arrays, for the questions
that are asked of all of them at once.  No YADE in here.
"""

from __future__ import annotations

import math

import numpy as np

from glue.flow.arrivals import COLUMNS

_ID, _TIME, _DIAMETER, _DENSITY, _MEDIUM = (
    COLUMNS.names.index(n) for n in ("shot_id", "time_s", "diameter_m", "density_kg_m3", "medium")
)
_POS, _VEL = COLUMNS.names.index("x_m"), COLUMNS.names.index("vx_m_s")


PAIRS_AT_ONCE = 100_000  # in one go of Fleet.all_touches


class FlowFailed(Exception):
    """A check of the running or finished simulation says that its result is wrong: one line, the cause."""


class Flying:
    """One shot on its way: who it is, and ``t, pos, vel, spin`` (SI) at the end of its last contact."""

    __slots__ = (
        *("arrival", "shot_id", "medium", "radius", "mass", "t", "pos", "vel", "spin", "start_speed"),
        *("collisions", "impacts", "open", "flight", "slot", "body", "before", "strike", "true_at"),
    )

    def __init__(self, arrival: tuple):
        self.arrival = arrival  # values in the order of glue.flow.arrivals.COLUMNS
        self.shot_id, self.medium = arrival[_ID], arrival[_MEDIUM]
        self.radius = 0.5 * arrival[_DIAMETER]
        self.mass = arrival[_DENSITY] * math.pi / 6.0 * arrival[_DIAMETER] ** 3
        self.t = arrival[_TIME]
        self.pos, self.vel = arrival[_POS : _POS + 3], arrival[_VEL : _VEL + 3]
        self.spin = (0.0, 0.0, 0.0)
        self.start_speed = math.hypot(*self.vel)
        self.collisions = 0  # with other shots
        self.impacts = 0
        self.open = 0  # contacts open now; the state above is old while there are any
        self.flight = 0  # counts the changes of flight
        self.slot = -1  # in the fleet
        self.body = -1  # in YADE; -1 while it has none
        self.strike = None  # kept by a curved target: (flight, time, point, normal) of the next touch
        self.true_at = self.t  # when ``vel`` is the true velocity: with kicks, in the middle of a stretch
        self.before = None  # while in contact near the target: (vel, spin) at the step before this one

    def at(self, now: float) -> tuple[float, float, float]:
        """Position [m] at time ``now``; exact while no contact is open."""
        dt = now - self.t
        (x, y, z), (u, v, w) = self.pos, self.vel
        return x + u * dt, y + v * dt, z + w * dt

    @property
    def density_kg_m3(self) -> float:
        return self.arrival[_DENSITY]

    def energy_J(self) -> float:
        """Kinetic energy, spin included, of the last free state."""
        (u, v, w), (a, b, c) = self.vel, self.spin
        return 0.5 * self.mass * (u * u + v * v + w * w + 0.4 * self.radius**2 * (a * a + b * b + c * c))


class Fleet:
    """All live shots. Slots 0 … n-1 are filled; a leaving shot's is taken by the last one's.

    ``pos`` and ``vel`` (3, n), ``t``, ``radius``, ``speed`` and ``free`` (n,) are views of the filled slots,
    valid until the next ``add`` or ``remove``; a shot with an open contact is not ``free``.
    """

    def __init__(self):
        self.shots: list[Flying] = []
        self._free = np.zeros(64, bool)
        self._state = np.zeros((9, 64))  # x y z u v w t radius speed
        self._view()

    def _view(self) -> None:
        n = len(self.shots)
        s = self._state
        self.pos, self.vel, self.t, self.radius, self.speed = (
            s[0:3, :n],
            s[3:6, :n],
            s[6, :n],
            s[7, :n],
            s[8, :n],
        )
        self.free = self._free[:n]

    def add(self, shot: Flying) -> None:
        shot.slot = len(self.shots)
        self.shots.append(shot)
        if shot.slot == self._state.shape[1]:
            self._state = np.concatenate([self._state, np.zeros_like(self._state)], axis=1)
            self._free = np.concatenate([self._free, np.zeros_like(self._free)])
        self._view()
        self.renew(shot)

    def renew(self, shot: Flying) -> None:
        """Take over the free state of ``shot``."""
        vel = shot.vel
        self._state[:, shot.slot] = (*shot.pos, *vel, shot.t, shot.radius, math.hypot(*vel))
        self._free[shot.slot] = True

    def hold(self, shot: Flying) -> None:
        """``shot`` is in contact: its flight is over until it is renewed."""
        self._free[shot.slot] = False

    def remove(self, shot: Flying) -> None:
        last = self.shots.pop()
        if last is not shot:
            self.shots[shot.slot] = last
            self._state[:, shot.slot] = self._state[:, last.slot]
            self._free[shot.slot] = self._free[last.slot]
            last.slot = shot.slot
        shot.slot = -1
        self._view()

    def at(self, now: float) -> np.ndarray:
        """Positions [m] at time ``now``, shape (3, n); of the free ones exact."""
        return self.pos + self.vel * (now - self.t)

    def touches(self, shot: Flying, now: float) -> list[tuple[float, Flying]]:
        """(time [s], other) of every free shot that ``shot`` touches if both fly on from ``now``.

        |p + v s| = Ra + Rb for relative position p and velocity v, s after ``now``: the earlier root.  Shots
        that overlap and approach touch now.
        """
        if len(self.shots) < 2:
            return []
        here, way = shot.at(now), shot.vel
        p = self.at(now)
        v = self.vel.copy()
        for k in 0, 1, 2:
            p[k] -= here[k]
            v[k] -= way[k]
        approach = np.einsum("ij,ij->j", p, v)
        speed2 = np.einsum("ij,ij->j", v, v)
        gap2 = np.einsum("ij,ij->j", p, p) - (self.radius + shot.radius) ** 2
        root2 = approach * approach - speed2 * gap2
        meets = (approach < 0.0) & (root2 > 0.0) & self.free
        found = []
        for i in meets.nonzero()[0].tolist():
            other = self.shots[i]
            if other is not shot:
                after = gap2[i] / (math.sqrt(root2[i]) - approach[i]) if gap2[i] > 0.0 else 0.0
                found.append((now + float(after), other))
        return found

    def all_touches(self, now: float) -> list[tuple[float, Flying, Flying]]:
        """``touches`` of every pair of free shots, each pair once."""
        place, found = self.at(now), []
        rows = max(1, PAIRS_AT_ONCE // max(len(self.shots), 1))
        for first in range(0, len(self.shots), rows):
            some = slice(first, first + rows)
            p = place[:, None, :] - place[:, some, None]
            v = self.vel[:, None, :] - self.vel[:, some, None]
            approach = np.einsum("kij,kij->ij", p, v)
            speed2 = np.einsum("kij,kij->ij", v, v)
            gap2 = np.einsum("kij,kij->ij", p, p) - (self.radius + self.radius[some, None]) ** 2
            root2 = approach * approach - speed2 * gap2
            meets = (approach < 0.0) & (root2 > 0.0) & self.free & self.free[some, None]
            for i, j in zip(*(index.tolist() for index in meets.nonzero())):
                if j > i + first:
                    gap = float(gap2[i, j])
                    after = gap / (math.sqrt(root2[i, j]) - float(approach[i, j])) if gap > 0.0 else 0.0
                    found.append((now + after, self.shots[i + first], self.shots[j]))
        return found

    def near(self, place, reach_m: float, ahead_s: float, now: float) -> list[Flying]:
        """Free shots whose surface can come within ``reach_m`` of the point ``place`` in ``ahead_s``."""
        p = self.at(now)
        for k in 0, 1, 2:
            p[k] -= place[k]
        most = self.speed * ahead_s + self.radius + reach_m
        close = (np.einsum("ij,ij->j", p, p) < most * most) & self.free
        return [self.shots[i] for i in close.nonzero()[0].tolist()]
