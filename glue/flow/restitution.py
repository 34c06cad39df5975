"""Restitution on the target as a law: it falls with the normal speed and rises where shots struck before.

    e(v) = min(largest, e (v / speed)^-exponent)        v normal speed of approach
    e_n  = saturated - (saturated - e(v)) exp(-n / hits)   n earlier impacts within the spot

The power law is that of elastoplastic impact (Johnson, *Contact Mechanics*, 1985, ch. 11.5: exponent 1/4);
its numbers come from the dimple stage or are a constant (exponent 0).  Standard library and numpy only:
YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields

import numpy as np

from glue.errors import InputError
from glue.scene.model import SpotHardening

LARGEST = 0.94  # YADE's contact law saturates above, except at exactly 1


@dataclass(frozen=True)
class RestitutionLaw:
    """``e`` at the normal speed ``speed_m_s``, its power law, its cap, and what earlier impacts do to it.

    A constant has exponent 0 and needs no speed.  ``e`` lies in (0, largest]; exactly 1 (nothing lost) is
    constant and its own cap.  ``hardening`` needs ``spot_radius_m``, the radius within which earlier impacts
    count.  Raises InputError for anything else.
    """

    e: float
    speed_m_s: float = 0.0
    exponent: float = 0.0
    largest: float = LARGEST
    hardening: SpotHardening | None = None
    spot_radius_m: float = 0.0

    def __post_init__(self):
        if self.e == 1.0:
            object.__setattr__(self, "largest", 1.0)
        problems = _problems(self)
        if problems:
            raise InputError(problems)

    def at(self, normal_speed_m_s: float) -> float:
        """Restitution at this normal speed [m/s] on a surface not struck before."""
        return restitution_at(normal_speed_m_s, self.e, self.speed_m_s, self.exponent, self.largest)

    def at_speeds(self, normal_speeds_m_s: np.ndarray) -> np.ndarray:
        """``at`` of every element; speeds above 0, shape (n,)."""
        if self.exponent == 0.0:
            return np.full(np.shape(normal_speeds_m_s), min(self.largest, self.e))
        return np.minimum(self.largest, self.e * (normal_speeds_m_s / self.speed_m_s) ** -self.exponent)

    def at_spot(self, e: float, earlier: int) -> float:
        """``e`` after ``earlier`` impacts within the spot; unchanged without hardening."""
        if self.hardening is None:
            return e
        return hardened(e, earlier, self.hardening.saturated, self.hardening.hits)

    def as_dict(self) -> dict:
        """Plain numbers for JSON, the inverse of ``from_dict``."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: dict) -> RestitutionLaw:
        """The law that ``as_dict`` gave. Raises InputError for unknown or missing keys and bad values."""
        try:
            values = dict(values)
            if values.get("hardening") is not None:
                values["hardening"] = SpotHardening(**values["hardening"])
            return cls(**values)
        except (TypeError, ValueError) as e:
            known = ", ".join(f.name for f in fields(cls))
            raise InputError(f"restitution law {values!r}: {e}; its keys are {known}") from None


def restitution_at(
    normal_speed_m_s: float, e: float, speed_m_s: float, exponent: float, largest: float
) -> float:
    """min(largest, e (v / speed)^-exponent); scalar, for numba too. At v <= 0 a falling law is at its cap."""
    if exponent == 0.0:
        return min(largest, e)
    if normal_speed_m_s <= 0.0:
        return largest
    return min(largest, e * (normal_speed_m_s / speed_m_s) ** -exponent)


def hardened(e: float, earlier: int, saturated: float, hits: float) -> float:
    """Restitution ``e`` after ``earlier`` impacts on the spot, never below ``e``; scalar, for numba too."""
    return max(e, saturated - (saturated - e) * math.exp(-earlier / hits))


def _problems(law: RestitutionLaw) -> list[str]:
    numbers = {f.name: getattr(law, f.name) for f in fields(law) if f.name != "hardening"}
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
        (law.e != 1.0 or law.exponent == 0.0, "e = 1 loses nothing at any speed: its exponent must be 0"),
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
