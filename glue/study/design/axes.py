"""What a design may change: "nozzle.speed_m_s=20:100", "nozzle.mass_flow_kg_s=0.005:0.05:log", "shots.grade=S110,S230"."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from glue.errors import InputError

KINDS = ("linear", "log", "int")
NEAR_END = 0.02  # of a range
DIGITS = 4  # significant, of a proposed number: finer than a machine can be set


class Axis(NamedTuple):
    """A key path of the scene with its range (``low`` to ``high``) or its ``choices``; ``kind`` one of KINDS or "choice"."""

    key: str
    kind: str
    low: float = 0.0
    high: float = 0.0
    choices: tuple[str | int | float, ...] = ()

    def at(self, share: float) -> float | int | str:
        """The value at ``share`` (0 to 1, 1 excluded) of the axis."""
        if self.kind == "choice":
            return self.choices[int(share * len(self.choices))]
        if self.kind == "int":
            return int(self.low + math.floor(share * (self.high - self.low + 1)))
        if self.kind == "log":
            return self.rounded(self.low * (self.high / self.low) ** share)
        return self.rounded(self.low + share * (self.high - self.low))

    def rounded(self, value):
        """``value`` as it is written into a scene: DIGITS digits, within the range."""
        if self.kind == "choice":
            return value
        if self.kind == "int":
            return int(value)
        return min(max(float(f"{value:.{DIGITS}g}"), self.low), self.high)

    def end_at(self, value) -> str:
        """"low" or "high" when ``value`` is within NEAR_END of that end of the range, else "" (always of choices)."""
        if self.kind == "choice":
            return ""
        scale = math.log if self.kind == "log" else float
        share = (scale(value) - scale(self.low)) / (scale(self.high) - scale(self.low))
        return "low" if share < NEAR_END else "high" if share > 1.0 - NEAR_END else ""

    @property
    def ends(self) -> tuple:
        """The values that bound the axis: both ends, or every choice."""
        return self.choices if self.kind == "choice" else (self.rounded(self.low), self.rounded(self.high))

    def __str__(self) -> str:
        if self.kind == "choice":
            return f"{self.key} one of {', '.join(map(str, self.choices))}"
        return f"{self.key} {self.low:g} to {self.high:g}{'' if self.kind == 'linear' else f' ({self.kind})'}"


def read_axes(written: Sequence[str]) -> tuple[Axis, ...]:
    """Axes as written on the command line.  Raises InputError with everything that is wrong."""
    problems: list[str] = []
    found = [axis for text in written if (axis := _axis(text, problems))]
    keys = [axis.key for axis in found]
    problems += [f"--vary {key}: given twice; allowed once" for key in dict.fromkeys(keys) if keys.count(key) > 1]
    if not written:
        problems.append("--vary: nothing may change; allowed: KEY=FROM:TO[:log|:int] or KEY=A,B,C")
    if problems:
        raise InputError(problems)
    return tuple(found)


def _axis(text: str, problems: list[str]) -> Axis | None:
    form = "must be KEY=FROM:TO, KEY=FROM:TO:log, KEY=FROM:TO:int or KEY=A,B,C"
    key, equals, rest = (part.strip() for part in text.partition("="))
    if not key or not equals or not rest:
        problems.append(f"--vary {text}: {form}, such as nozzle.speed_m_s=20:100")
        return None
    if ":" not in rest:
        choices = tuple(dict.fromkeys(_number_or_word(part.strip()) for part in rest.split(",") if part.strip()))
        if len(choices) < 2:
            problems.append(f"--vary {text}: one value only; {form}")
            return None
        return Axis(key, "choice", choices=choices)
    parts = [part.strip() for part in rest.split(":")]
    kind = parts[2] if len(parts) == 3 else "linear"
    ends = [_number_or_word(part) for part in parts[:2]]
    if len(parts) > 3 or kind not in KINDS or not all(isinstance(end, int | float) and math.isfinite(end) for end in ends):
        problems.append(f"--vary {text}: {form}")
        return None
    low, high = map(float, ends)
    if not low < high or (kind == "log" and low <= 0.0) or (kind == "int" and (low % 1.0 or high % 1.0)):
        rule = {"log": "above 0 and rising", "int": "whole and rising"}.get(kind, "rising")
        problems.append(f"--vary {text}: the ends must be {rule}")
        return None
    return Axis(key, kind, low, high)


def _number_or_word(text: str) -> int | float | str:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text
