"""What a key of the scene file may hold, and the sentence that says why a value is refused.

Each field answers ``problem(value)`` with None or a sentence that ends with the allowed range or values;
sentences guess at the unit mistake behind a number that is out of range.  Standard library only.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Protocol

from glue.scene.catalogue import closest

REQUIRED = object()  # default of a key that has none

# Unit of a key: its name in words, and the units it is mistaken for with their size in it.
UNITS: dict[str, tuple[str, tuple[tuple[str, float], ...]]] = {
    "m": ("in metres", (("mm", 1e-3), ("um", 1e-6), ("inch", 0.0254))),
    "s": ("in seconds", (("ms", 1e-3), ("min", 60.0))),
    "m/s": ("in metres per second", (("mm/s", 1e-3), ("km/s", 1e3))),
    "kg/s": ("in kilograms per second", (("kg/min", 1.0 / 60.0), ("g/s", 1e-3), ("kg/h", 1.0 / 3600.0))),
    "kg/m3": ("in kilograms per cubic metre", (("g/cm3", 1e3), ("tonne/mm3", 1e12))),
    "Pa": ("in pascals", (("MPa", 1e6), ("GPa", 1e9))),
    "m/s2": ("in metres per second squared", (("g", 9.81),)),
    "Pa s": ("in pascal seconds", (("mPa s", 1e-3), ("uPa s", 1e-6))),
    "Hz": ("in hertz", (("kHz", 1e3), ("1/min", 1.0 / 60.0))),
    "deg": ("in degrees", (("rad", 180.0 / math.pi),)),
    "1/s": ("in one over seconds", ()),
    "K": ("in kelvin", ()),
    "J/kg/K": ("in joules per kilogram and kelvin", (("kJ/kg/K", 1e3),)),
    "": ("a plain number", ()),
    "%": ("in per cent", (("a share of one", 100.0),)),
    "share": ("a share of one", (("%", 1e-2),)),
}


class Field(Protocol):
    """What every field below offers."""

    default: object
    source: str

    @property
    def allowed(self) -> str:
        """The allowed range or values, in words."""

    def problem(self, value: object) -> str | None:
        """None for a value that may stand, else the sentence that says what is wrong and what is allowed."""

    def convert(self, value: object) -> object:
        """A value without problem in the type that the scene holds."""


def show(number: float) -> str:
    """Shortest plain form of a number: 2e-5, not 2e-05."""
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m[1].replace("+", "") + m[2], f"{number:.6g}")


def quoted(value: object) -> str:
    """A value as the user wrote it, cut short."""
    text = (
        f'"{value}"'
        if isinstance(value, str)
        else str(value).lower()
        if isinstance(value, bool)
        else str(value)
    )
    return text if len(text) <= 60 else text[:57] + "..."


def kind(value: object) -> str:
    """The TOML type of a value, in words, for "must be …, not …"."""
    if isinstance(value, bool):
        return f"the boolean {quoted(value)}"
    names = {str: "the text", int: "the integer", float: "the number", list: "an array", dict: "a table"}
    name = names.get(type(value), "a date or time")
    return name if isinstance(value, list | dict) else f"{name} {quoted(value)}"


def number_problem(value: object, allowed: str) -> str | None:
    """None for a finite number, else the sentence that says what is wrong; ``allowed`` ends it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"must be a number, not {kind(value)}{_number_in_quotes(value)}; {allowed}"
    if isinstance(value, float) and not math.isfinite(value):
        return f"must be a finite number, not {value}; {allowed}"
    return None


def _number_in_quotes(value: object) -> str:
    """Hint for a number written as text."""
    if isinstance(value, str):
        try:
            float(value)
        except ValueError:
            return ""
        return " (write it without quotes)"
    return ""


@dataclass(frozen=True)
class Number:
    """A finite number in [low, high], an integer accepted too.

    ``source`` belongs to the default; ``reason`` says why the range ends where it does.
    """

    low: float
    high: float
    unit: str = ""
    default: object = REQUIRED
    source: str = ""
    reason: str = ""

    @property
    def allowed(self) -> str:
        unit = "" if self.unit == "share" else f" {self.unit}"
        return f"allowed {show(self.low)}..{show(self.high)}{unit}".rstrip()

    def problem(self, value: object) -> str | None:
        if problem := number_problem(value, self.allowed):
            return problem
        if not self.low <= value <= self.high:
            reason = f" ({self.reason})" if self.reason else ""
            return f"{self._off(value)}; {self.allowed}{reason}"
        return None

    def convert(self, value: float) -> float:
        return float(value)

    def _off(self, value: float) -> str:
        """What a value out of range amounts to, and the unit that it was probably meant in."""
        words, mistaken = UNITS[self.unit]
        said = f"{quoted(value)} is out of range"
        if abs(value) > 1e300:  # no unit makes sense of it, and an integer may not even be a float
            return said
        if self.unit == "m":
            said = f"{quoted(value)} is {show(value * 1e3)} mm"
        if self.unit:
            said += f"; this key is {words}"
        for name, size in mistaken:
            if self.low <= value * size <= self.high:
                return f"{said} ({quoted(value)} {name} is written {show(value * size)})"
        return said


@dataclass(frozen=True)
class Vector:
    """A fixed number of coordinates, each a :class:`Number`; ``axes`` holds their one-letter names."""

    axes: str
    each: Number
    default: object = REQUIRED
    source: str = ""

    @property
    def _count(self) -> str:
        return {2: "two numbers", 3: "three numbers"}[len(self.axes)]

    @property
    def allowed(self) -> str:
        each = self.each.allowed.removeprefix("allowed ")
        return f"allowed: {self._count} [{', '.join(self.axes)}], each {each}"

    def problem(self, value: object) -> str | None:
        if not isinstance(value, list):
            return f"must be {self._count}, not {kind(value)}; {self.allowed}"
        if len(value) != len(self.axes):
            return f"must be {self._count}, not {len(value)}; {self.allowed}"
        problems = [(axis, self.each.problem(item)) for axis, item in zip(self.axes, value)]
        return "; ".join(f"{axis}: {problem}" for axis, problem in problems if problem) or None

    def convert(self, value: list) -> tuple[float, ...]:
        return tuple(float(item) for item in value)


@dataclass(frozen=True)
class Integer:
    """A whole number in [low, high]."""

    low: int
    high: int
    default: object = REQUIRED
    source: str = ""

    @property
    def allowed(self) -> str:
        return f"allowed {self.low}..{self.high}" if self.low != self.high else f"allowed {self.low}"

    def problem(self, value: object) -> str | None:
        if isinstance(value, bool) or not isinstance(value, int):
            return f"must be a whole number, not {kind(value)}{_number_in_quotes(value)}; {self.allowed}"
        return None if self.low <= value <= self.high else f"{quoted(value)} is out of range; {self.allowed}"

    def convert(self, value: int) -> int:
        return value


@dataclass(frozen=True)
class Text:
    """A text that matches ``pattern`` as a whole; ``allowed`` says the same in words."""

    pattern: str
    allowed: str
    default: object = REQUIRED
    source: str = ""

    def problem(self, value: object) -> str | None:
        if not isinstance(value, str):
            return f"must be a text in quotes, not {kind(value)}; {self.allowed}"
        return (
            None if re.fullmatch(self.pattern, value) else f"{quoted(value)} is no valid text; {self.allowed}"
        )

    def convert(self, value: str) -> str:
        return value


@dataclass(frozen=True)
class Word:
    """One of a few words. ``not_built`` maps words of later versions to what they stand for."""

    words: tuple[str, ...]
    default: object = REQUIRED
    source: str = ""
    not_built: dict[str, str] = field(default_factory=dict)

    @property
    def allowed(self) -> str:
        return "allowed " + ", ".join(f'"{word}"' for word in self.words)

    def problem(self, value: object) -> str | None:
        if not isinstance(value, str):
            return f"must be a text in quotes, not {kind(value)}; {self.allowed}"
        if value in self.words:
            return None
        if value in self.not_built:
            return (
                f"{quoted(value)} ({self.not_built[value]}) is not built yet in this version; {self.allowed}"
            )
        guess = closest(value, self.words)
        hint = f' did you mean "{guess}"?' if guess else ""
        return f"unknown value {quoted(value)};{hint} {self.allowed}"

    def convert(self, value: str) -> str:
        return value


@dataclass(frozen=True)
class Flag:
    """true or false."""

    default: object = REQUIRED
    source: str = ""
    allowed: str = "allowed true, false"

    def problem(self, value: object) -> str | None:
        return None if isinstance(value, bool) else f"must be true or false, not {kind(value)}; {self.allowed}"

    def convert(self, value: bool) -> bool:
        return value
