"""Fields that only shot peening has: an Almen intensity, a coefficient of restitution.  Standard library only."""

from __future__ import annotations

from dataclasses import dataclass

from glue.scene.fields import REQUIRED, kind, number_problem, quoted
from glue.theory.almen import ALLOWED as INTENSITY_ALLOWED
from glue.theory.almen import intensity_problem


@dataclass(frozen=True)
class Almen:
    """An Almen intensity as a drawing says it, such as "8A" or "6-8A"."""

    default: object = REQUIRED
    source: str = ""
    allowed: str = INTENSITY_ALLOWED

    def problem(self, value: object) -> str | None:
        if not isinstance(value, str):
            return f"must be a text in quotes, not {kind(value)}; {self.allowed}"
        return intensity_problem(value)

    def convert(self, value: str) -> str:
        return value


@dataclass(frozen=True)
class Ratio:
    """A coefficient of restitution in (0, 0.94] or exactly 1, the values that the contact law can hold.

    With ``or_word`` that word is accepted too.
    """

    or_word: str = ""
    default: object = REQUIRED
    source: str = ""

    @property
    def allowed(self) -> str:
        return "allowed above 0 up to 0.94, or exactly 1" + (f', or "{self.or_word}"' if self.or_word else "")

    def problem(self, value: object) -> str | None:
        if self.or_word and isinstance(value, str):
            return None if value == self.or_word else f"unknown value {quoted(value)}; {self.allowed}"
        if problem := number_problem(value, self.allowed):
            return problem
        if value <= 0:
            return f"{quoted(value)} is out of range: the contact law has no answer there; {self.allowed}"
        if 0.94 < value < 1:
            return (
                f"{quoted(value)} cannot be reached: above 0.94 the contact law of YADE saturates "
                f"(0.97 rebounds at 0.965, 0.999 at 0.984); {self.allowed}"
            )
        if value > 1:
            return f"{quoted(value)} is out of range: a rebound cannot gain energy; {self.allowed}"
        return None

    def convert(self, value: float | str) -> float | str:
        return value if isinstance(value, str) else float(value)
