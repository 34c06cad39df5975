"""Almen strips and what a shop writes about them: "8A", "6-8A", "0.20 mmA".

Strips and gauge of SAE J442: a strip of spring steel is peened while screwed to a block; let go, it bulges towards the
shot.  The gauge holds it on four balls, 31.75 by 15.875 mm apart, and its dial reads the middle of the unpeened side.
"8A" is .008 inch on strip A.  Standard library only.
"""

from __future__ import annotations

import re
from typing import NamedTuple

INCH_m = 0.0254
GAUGE_LENGTH_m, GAUGE_WIDTH_m = 31.75e-3, 15.875e-3  # between the four balls


class Strip(NamedTuple):
    """One strip of SAE J442; ``low_m`` to ``high_m``: arc heights for which it is used."""

    letter: str
    thickness_m: float
    length_m: float
    width_m: float
    low_m: float
    high_m: float
    other: str  # what to say below and above


# Sizes: SAE J442 (grade A).  A is used from 4 to 24 (grade B); N below and C above it.  1C is about 3.5A and 1A about 3N (grade C), so that 4A is about 12N and 24A about 7C; half as much is left over.
STRIPS = {
    "N": Strip("N", 0.79e-3, 76e-3, 19e-3, 0.5e-3 * INCH_m, 18e-3 * INCH_m, "above, say A"),
    "A": Strip("A", 1.29e-3, 76e-3, 19e-3, 4e-3 * INCH_m, 24e-3 * INCH_m, "below 4A say N, above 24A say C"),
    "C": Strip("C", 2.39e-3, 76e-3, 19e-3, 4e-3 * INCH_m, 24e-3 * INCH_m, "below, say A"),
}

_NUMBER = r"(\d+(?:\.\d+)?|\.\d+)"
_WRITTEN = re.compile(rf"\s*{_NUMBER}(?:\s*(?:-|\.\.|to)\s*{_NUMBER})?\s*(mm|in|inch|)\s*([A-Za-z]?)\s*")
ALLOWED = 'allowed: thousandths of an inch and the strip\'s letter, such as "8A", "6-8A", "5N", or "0.20 mmA"'


class Intensity(NamedTuple):
    """What a drawing asks for: an arc height, or a window of them, on one strip."""

    low_m: float
    high_m: float  # low_m for a single value
    strip: Strip

    @property
    def aim_m(self) -> float:
        """The middle of the window."""
        return 0.5 * (self.low_m + self.high_m)

    def __str__(self) -> str:
        low, high = (f"{mils(end):.4g}" for end in (self.low_m, self.high_m))
        return f"{low if low == high else f'{low}-{high}'}{self.strip.letter}"


def mils(height_m: float) -> float:
    """Arc height [m] in thousandths of an inch."""
    return height_m / INCH_m * 1e3


def intensity_problem(text: str) -> str | None:
    """None for an intensity as a shop writes it, else the sentence that says what is wrong and what is allowed."""
    found = _WRITTEN.fullmatch(text)
    if not found:
        return f'"{text}" is no Almen intensity; {ALLOWED}'
    letter = found[4].upper()
    if letter not in STRIPS:
        wrong = "names no strip" if not letter else f'names a strip "{letter}" that there is not'
        return f'"{text}" {wrong}; allowed strips N, A, C; {ALLOWED}'
    low, high = _ends_m(found)
    if low > high or (found[2] and low == high):
        return f'"{text}": the first end of the window must be below the second; {ALLOWED}'
    strip = STRIPS[letter]
    span = f"{mils(strip.low_m):g}{letter}..{mils(strip.high_m):g}{letter} ({strip.other})"
    if low < strip.low_m * (1.0 - 1e-9):
        say = {"A": "say it on strip N", "C": "say it on strip A", "N": "too faint to measure"}[letter]
        return f'"{text}": {mils(low):.4g}{letter} is out of range of strip {letter}: {say}; allowed {span}'
    if high > strip.high_m * (1.0 + 1e-9):
        say = {"A": "say it on strip C", "N": "say it on strip A", "C": "more than shot peening gives"}[letter]
        return f'"{text}": {mils(high):.4g}{letter} is out of range of strip {letter}: {say}; allowed {span}'
    return None


def read_intensity(text: str) -> Intensity:
    """The intensity that ``text`` names.  Raises ValueError with the sentence of ``intensity_problem``."""
    if problem := intensity_problem(text):
        raise ValueError(problem)
    found = _WRITTEN.fullmatch(text)
    return Intensity(*_ends_m(found), STRIPS[found[4].upper()])


def _ends_m(found: re.Match) -> tuple[float, float]:
    unit = {"mm": 1e-3, "in": INCH_m, "inch": INCH_m, "": 1e-3 * INCH_m}[found[3]]
    low = float(found[1]) * unit
    return low, float(found[2]) * unit if found[2] else low


def eigenstrain_curvature_1_m(strain: float, depth_m: float, thickness_m: float) -> float:
    """Curvature [1/m] of a plate whose top ``depth_m`` has grown by ``strain``: 6 eps d (h - d)/h^3 (exact)."""
    return 6.0 * strain * depth_m * (thickness_m - depth_m) / thickness_m**3


def gauge_reading_m(curvature_1_m: float) -> float:
    """What the gauge reads [m] over a strip of this curvature in both directions: kappa (L^2 + W^2)/8."""
    return curvature_1_m * (GAUGE_LENGTH_m**2 + GAUGE_WIDTH_m**2) / 8.0
