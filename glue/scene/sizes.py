"""Shot sizes: the distribution by number behind ``Shots.size``, its ends, moments and quantiles.

- ``mono``: every shot ``diameter_m``;
- ``distribution``: normal with mean ``diameter_m`` and ``size_cv``, cut at 2.5 standard deviations;
- ``sieve``: mass shares between sieve openings (SAE J444 states such), mass spread evenly over the
  diameters between two openings, so that the number of shots falls as diameter^-3.

Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from statistics import NormalDist

CUT_SD = 2.5  # shots are sieved: no diameter further than this from the mean
# Variance of a normal distribution cut there, over sd^2: 1 - 2 c phi(c) / (2 Phi(c) - 1).
CUT_VARIANCE = 1.0 - 2.0 * CUT_SD * math.exp(-0.5 * CUT_SD**2) / math.sqrt(2.0 * math.pi) / math.erf(
    CUT_SD / math.sqrt(2.0)
)
_NORMAL = NormalDist()
_BELOW = _NORMAL.cdf(-CUT_SD)


def smallest_m(shots) -> float:
    """Smallest diameter [m] that can be drawn: it sets the time step of a DEM run."""
    if shots.size == "sieve":
        return shots.sieve[0][0]
    return shots.diameter_m * (1.0 - (CUT_SD * shots.size_cv if shots.size == "distribution" else 0.0))


def largest_m(shots) -> float:
    """Largest diameter [m] that can be drawn."""
    if shots.size == "sieve":
        return shots.sieve[-1][0]
    return shots.diameter_m * (1.0 + (CUT_SD * shots.size_cv if shots.size == "distribution" else 0.0))


def mean_cube_m3(shots) -> float:
    """Mean of the cubed diameter over the shots [m^3]; mass of a mean shot over pi/6 density."""
    if shots.size == "sieve":
        # by mass the mean of d^-3 over a band is (a^-2 - b^-2) / (2 (b - a))
        return 1.0 / sum(mass * (a**-2 - b**-2) / (2.0 * (b - a)) for a, b, mass in _bands(shots))
    spread = 1.0 + 3.0 * CUT_VARIANCE * shots.size_cv**2 if shots.size == "distribution" else 1.0
    return shots.diameter_m**3 * spread


def mean_m(shots) -> float:
    """Mean diameter over the shots [m]."""
    if shots.size != "sieve":
        return shots.diameter_m
    return mean_cube_m3(shots) * sum(mass / (a * b) for a, b, mass in _bands(shots))  # by mass: mean of d^-2


def quantile_m(shots, share: float) -> float:
    """Diameter [m] that ``share`` (0..1) of the shots stay below, by number."""
    if shots.size == "mono":
        return shots.diameter_m
    if shots.size == "distribution":
        return shots.diameter_m * (
            1.0 + shots.size_cv * _NORMAL.inv_cdf(_BELOW + share * (1.0 - 2.0 * _BELOW))
        )
    cube = mean_cube_m3(shots)
    left = share
    for a, b, mass in _bands(shots):
        in_band = cube * mass * (a**-2 - b**-2) / (2.0 * (b - a))
        if left <= in_band or b == shots.sieve[-1][0]:
            u = min(left / in_band, 1.0) if in_band > 0.0 else 1.0
            return (a**-2 - u * (a**-2 - b**-2)) ** -0.5
        left -= in_band
    raise AssertionError("a sieve analysis ends with its last band")


def _bands(shots):
    """(lower opening [m], upper opening [m], mass share between) of a sieve analysis, from fine to coarse."""
    for (a, finer), (b, up_to) in zip(shots.sieve, shots.sieve[1:]):
        yield a, b, up_to - finer
