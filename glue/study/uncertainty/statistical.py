"""Chance: half widths of 95 % intervals [in the metric's unit] from a run's own log and surface.

Coverage: impacts are a Poisson process, so two points d apart are both bare with probability
exp(-lambda (2 - L(d)/<pi r^2>)), L the mean overlap of two discs; the variance of the bare share of a window is that
over both points less the product (``glue.theory.avrami.coverage_sd``, Robbins 1944).  Time to a level: the same
standard deviation at that level over the slope of the expected coverage there, dC/dt = (1 - C) ln(1/(1 - C))/t.
Hits per point of N impacts with dimple areas A_i: a compound Poisson sum, relative variance <A^2>/(N <A>^2).

Means over the log: batch means, for collisions come in bursts.  Sa, Sq and shape are means of |h|, h^2, h^3, h^4 over
the levelled window: scatter of the means over its parts, over the root of their number.  Few batches or parts know
their scatter badly: Student's factor in place of 1.96.  Sz, an extreme, scatters as much in a part as in the whole (the
extremes' distribution shifts with the area, its width stays).  Stress of a patch: the scatter over seeds in the
measured table, in proportion to the patch's side (independent places).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import normal_speed_m_s
from glue.surface.roughness import areal, level_plane
from glue.theory.avrami import coverage_sd

Z95 = 1.96
_BATCHES = 24
_RADII = 16  # quantiles of the dimple radii that stand for all
_PART_IN_RADII = 5.0  # side of a part of the surface: wide enough that neighbours are hardly alike


def coverage_half(coverage: float, radii_m: np.ndarray, window_m: tuple[float, float]) -> float | None:
    """Of the coverage of a window where ``coverage`` (below 1) is expected; None for a window as small as a dimple."""
    radius = np.quantile(radii_m, (np.arange(_RADII) + 0.5) / _RADII)
    try:
        return Z95 * coverage_sd(min(coverage, 1.0 - 1e-12), radius, window_m)
    except InputError:
        return None


def time_half(time_s: float, level: float, radii_m: np.ndarray, window_m: tuple[float, float]) -> float | None:
    """Of the time at which the counted coverage reaches ``level``."""
    half = coverage_half(level, radii_m, window_m)
    return None if half is None else half * time_s / ((1.0 - level) * -math.log1p(-level))


def hits_relative_half(radii_m: np.ndarray, count: int) -> float:
    """Of the hits per point over their mean; ``radii_m`` (n,): of the impacts in the window, ``count`` of them."""
    area = radii_m**2
    return Z95 * math.sqrt(float((area**2).mean()) / float(area.mean()) ** 2 / count)


def batch_half(values: np.ndarray) -> float | None:
    """Of the mean of ``values`` (n,) in order of time, from the scatter of the means of consecutive batches."""
    if values.size < 4 * _BATCHES:
        return None
    from scipy.special import stdtrit  # here and below: Student's, as scipy.stats has it, which loads for a second

    means = np.array([part.mean() for part in np.array_split(values, _BATCHES)])
    return float(stdtrit(_BATCHES - 1, 0.975) * means.std(ddof=1)) / math.sqrt(_BATCHES)


def flow_halves(impacts: np.ndarray, info: dict, poisson: bool) -> dict[str, float | None]:
    """Of the section ``flow``; ``info``: that section."""
    if not len(impacts):
        return {}
    speed = normal_speed_m_s(impacts)
    energy = impacts["diameter_m"] ** 3 * impacts["density_kg_m3"] * speed**2
    of_energy = batch_half(energy)
    share = info.get("mean_normal_energy_fraction")
    known = of_energy is not None and share is not None
    return {
        "mean_normal_speed_m_s": batch_half(speed),
        "mean_normal_energy_fraction": of_energy / float(energy.mean()) * share if known else None,
        "collided_fraction": batch_half((impacts["collisions_before"] > 0).astype(float)),
        "impacts": Z95 * math.sqrt(len(impacts)) if poisson else 0.0,
    }  # fmt: skip


def surface_halves(
    z_m: np.ndarray, dx_m: float, dy_m: float, radius_m: float, roughness: dict
) -> dict[str, float | None]:
    """Of Sa, Sq, Sz, Ssk, Sku, from the parts of the height map; {} for a window too small to have parts."""
    side = min(z_m.shape[0] * dy_m, z_m.shape[1] * dx_m)
    cuts = int(side // (_PART_IN_RADII * radius_m))
    if cuts < 2:
        return {}
    from scipy.special import stdtrit

    cuts = min(cuts, 5)
    factor = float(stdtrit(cuts**2 - 1, 0.975))

    def parts(field: np.ndarray) -> list[np.ndarray]:
        return [p for row in np.array_split(field, cuts, axis=0) for p in np.array_split(row, cuts, axis=1)]

    def of_mean(field: np.ndarray) -> float:
        return factor * float(np.std([part.mean() for part in parts(field)], ddof=1)) / cuts

    h, sq = level_plane(z_m, dx_m, dy_m), roughness["Sq_m"]
    found: dict[str, float | None] = {"Sa_m": of_mean(np.abs(h))}
    found["Sq_m"] = of_mean(h**2) / (2.0 * sq) if sq > 0.0 else None
    found["Sz_m"] = Z95 * float(np.std([areal(part, dx_m, dy_m)["Sz_m"] for part in parts(z_m)], ddof=1))
    if roughness.get("Ssk") is not None:
        u, skew, kurt = h / sq, roughness["Ssk"], roughness["Sku"]
        # influence functions: what a height adds, with the level and Sq that it shifts
        found["Ssk"] = of_mean(u**3 - 3.0 * u - 1.5 * skew * u**2)
        found["Sku"] = of_mean(u**4 - 4.0 * skew * u - 2.0 * kurt * u**2)
    return found


def stress_relative_half(scatter: dict, quantity: str, side_over_measured: float) -> float | None:
    """Of a patch's stress or depth, relative to its scale, from the measured table's scatter."""
    found = scatter.get(quantity)
    return None if found is None else Z95 * found["sd"] / side_over_measured


def answer(exposure_half: float | None, function: Callable[[float], float]) -> float | None:
    """Half the difference that ``function`` makes of hits per point one half width up and down (relative)."""
    if exposure_half is None:
        return None
    return 0.5 * abs(function(1.0 + exposure_half) - function(max(1.0 - exposure_half, 0.0)))
