"""Restitution on the target as a law: it falls with the normal speed and rises where shots struck before.

    e(v) = min(largest, e (v / speed)^-exponent)        v normal speed of approach
    e_n  = saturated - (saturated - e(v)) exp(-n / hits)   n earlier impacts within the spot

The power law is that of elastoplastic impact (Johnson, *Contact Mechanics*, 1985, ch. 11.5: exponent 1/4), which
hardening materials approach only when fast: computed dimples fall by v^-.13 at 1 m/s and v^-.25 at 100.  So a law
may be a table instead, straight lines in log e over log v; a line continues beyond either end.  A rigid shot on a
rate-free target knows density x v^2 only: one of another density rebounds as if faster by the root of the ratio.
The numbers come from the dimple stage or are a constant (exponent 0).  Standard library and numpy only: YADE's
interpreter imports this too.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from itertools import pairwise

import numpy as np

from glue.errors import InputError
from glue.scene.model import SpotHardening

LARGEST = 0.94  # YADE's contact law saturates above, except at exactly 1


@dataclass(frozen=True)
class RestitutionLaw:
    """``e`` at the normal speed ``speed_m_s``, its power law, its cap, and what earlier impacts do to it.

    A constant has exponent 0 and needs no speed.  ``e`` lies in (0, largest]; exactly 1 (nothing lost) is
    constant and its own cap.  ``hardening`` needs ``spot_radius_m``, the radius within which earlier impacts
    count.  ``points``, (speed [m/s], e) with rising speeds and falling e, replace the power law; ``e`` and
    ``speed_m_s`` then only say what is typical.  ``density_kg_m3``: of the shots that the law was found with; 0:
    the same for all.  Raises InputError for anything else.
    """

    e: float
    speed_m_s: float = 0.0
    exponent: float = 0.0
    largest: float = LARGEST
    hardening: SpotHardening | None = None
    spot_radius_m: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    density_kg_m3: float = 0.0

    def __post_init__(self):
        if self.e == 1.0:
            object.__setattr__(self, "largest", 1.0)
        problems = _problems(self)
        if problems:
            raise InputError(problems)

    def at(self, normal_speed_m_s: float, density_kg_m3: float = 0.0) -> float:
        """Restitution at this normal speed [m/s] on a surface not struck before; density of the shot, 0: the law's."""
        speed = equivalent_speed(normal_speed_m_s, density_kg_m3, self.density_kg_m3)
        return restitution_at(speed, self.e, self.speed_m_s, self.exponent, self.largest, self.logs)

    def at_speeds(self, normal_speeds_m_s: np.ndarray, densities_kg_m3: np.ndarray | None = None) -> np.ndarray:
        """``at`` of every element, shapes (n,)."""
        # a falling law is at its cap at 0, which the smallest of all speeds reaches without a logarithm of 0
        speed = np.maximum(np.asarray(normal_speeds_m_s, dtype=float), np.finfo(float).tiny)
        if densities_kg_m3 is not None and self.density_kg_m3 > 0.0:
            speed = speed * np.sqrt(np.asarray(densities_kg_m3, dtype=float) / self.density_kg_m3)
        if self.points:
            x, y = self.logs.T
            k = np.clip(np.searchsorted(x, np.log(speed)), 1, len(x) - 1)
            e = np.exp(y[k] + (y[k] - y[k - 1]) / (x[k] - x[k - 1]) * (np.log(speed) - x[k]))
            return np.minimum(self.largest, e)
        if self.exponent == 0.0:
            return np.full(np.shape(speed), min(self.largest, self.e))
        return np.minimum(self.largest, self.e * (speed / self.speed_m_s) ** -self.exponent)

    @cached_property
    def logs(self) -> np.ndarray:
        """Logarithms of ``points``, (n, 2), for ``restitution_at``; (0, 2) for a power law."""
        return np.log(np.array(self.points, dtype=float).reshape(-1, 2))

    def at_spot(self, e: float, earlier: int) -> float:
        """``e`` after ``earlier`` impacts within the spot; unchanged without hardening."""
        if self.hardening is None:
            return e
        return hardened(e, earlier, self.hardening.saturated, self.hardening.hits)

    def as_dict(self) -> dict:
        """Plain numbers for JSON, the inverse of ``from_dict``."""
        return asdict(self) | {"points": [list(point) for point in self.points]}  # as JSON gives them back

    @classmethod
    def from_dict(cls, values: dict) -> RestitutionLaw:
        """The law that ``as_dict`` gave. Raises InputError for unknown or missing keys and bad values."""
        try:
            values = dict(values)
            if values.get("hardening") is not None:
                values["hardening"] = SpotHardening(**values["hardening"])
            values["points"] = tuple((v, e) for v, e in values.get("points", ()))
            return cls(**values)
        except (TypeError, ValueError) as e:
            known = ", ".join(f.name for f in fields(cls))
            raise InputError(f"restitution law {values!r}: {e}; its keys are {known}") from None


def equivalent_speed(normal_speed_m_s: float, density_kg_m3: float, law_density_kg_m3: float) -> float:
    """Speed at which a shot of the law's density brings as much density x v^2; scalar, for numba too."""
    if density_kg_m3 > 0.0 and law_density_kg_m3 > 0.0 and density_kg_m3 != law_density_kg_m3:
        return normal_speed_m_s * math.sqrt(density_kg_m3 / law_density_kg_m3)
    return normal_speed_m_s


def restitution_at(
    normal_speed_m_s: float, e: float, speed_m_s: float, exponent: float, largest: float, logs: np.ndarray
) -> float:
    """min(largest, e (v / speed)^-exponent), or by the table ``logs`` (n, 2) of log speed and log e.

    Scalar, for numba too.  At v <= 0 a falling law is at its cap.
    """
    if len(logs) > 0:
        if normal_speed_m_s <= 0.0:
            return largest
        x, k = math.log(normal_speed_m_s), 1
        while k < len(logs) - 1 and x > logs[k, 0]:
            k += 1
        slope = (logs[k, 1] - logs[k - 1, 1]) / (logs[k, 0] - logs[k - 1, 0])
        return min(largest, math.exp(logs[k, 1] + slope * (x - logs[k, 0])))
    if exponent == 0.0:
        return min(largest, e)
    if normal_speed_m_s <= 0.0:
        return largest
    return min(largest, e * (normal_speed_m_s / speed_m_s) ** -exponent)


def hardened(e: float, earlier: int, saturated: float, hits: float) -> float:
    """Restitution ``e`` after ``earlier`` impacts on the spot, never below ``e``; scalar, for numba too."""
    return max(e, saturated - (saturated - e) * math.exp(-earlier / hits))


def _problems(law: RestitutionLaw) -> list[str]:
    numbers = {f.name: getattr(law, f.name) for f in fields(law) if f.name not in ("hardening", "points")}
    numbers.update({f"points[{k}]": x for k, point in enumerate(law.points) for x in point})
    if law.hardening is not None:
        numbers.update(saturated=law.hardening.saturated, hits=law.hardening.hits)
    bad = [
        f"restitution law: {name} = {value!r}: must be a finite number"
        for name, value in numbers.items()
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value)
    ]
    if bad:
        return bad
    rules = [
        (0.0 < law.largest <= 1.0, f"largest = {law.largest}: must lie in (0, 1]"),
        (0.0 < law.e <= law.largest, f"e = {law.e}: must lie in (0, {law.largest}] or be exactly 1"),
        (0.0 <= law.exponent < 1.0, f"exponent = {law.exponent}: must lie in [0, 1)"),
        (
            law.exponent == 0.0 or law.speed_m_s > 0.0,
            f"speed_m_s = {law.speed_m_s}: must be above 0 where the exponent is not 0",
        ),
        (law.density_kg_m3 >= 0.0, f"density_kg_m3 = {law.density_kg_m3}: must not be negative"),
        (_is_table(law.points), "points: two or more of (speed, e) with rising speeds above 0 and e falling within (0, 1]"),
        (law.e != 1.0 or (law.exponent == 0.0 and not law.points), "e = 1 loses nothing at any speed: its exponent must be 0"),
    ]
    if law.hardening is not None:
        saturated, hits = law.hardening.saturated, law.hardening.hits
        rules += [
            (0.0 < saturated <= law.largest, f"saturated = {saturated}: must lie in (0, {law.largest}]"),
            (hits > 0.0, f"hits = {hits}: must be above 0"),
            (
                law.spot_radius_m > 0.0,
                f"spot_radius_m = {law.spot_radius_m}: hardening needs the radius of the spot, above 0",
            ),
        ]
    return [f"restitution law: {sentence}" for holds, sentence in rules if not holds]


def _is_table(points) -> bool:
    steps = pairwise(points)
    return len(points) != 1 and all(0.0 < v < w and 1.0 >= e >= f > 0.0 for (v, e), (w, f) in steps)
