"""Coverage over exposure time, counted on sample points as in the paper: the share of points hit by time t.

The sample points are a square lattice over the window.  Impacts are drawn in order of time as filled
ellipses; each counts the points that it is the first to cover, so one pass gives the whole curve.  An impact
centred outside the window covers what it reaches inside.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import normal_speed_m_s, tangential_velocity_m_s
from glue.theory.impact_scale import CONTACT_OVER_LOADING

# Points per median semi-minor axis.  The lattice's error in the covered share falls as (spacing/radius)^1.5
# and is about 1e-5 (largest of 12 draws 2.2e-5) for 10 000 discs at coverages .3 to .95.
POINTS_PER_RADIUS = 20.0

# Least squares over the areas of 3-D dimples of 1 mm steel on 2024 at 60 m/s, 75 to 20 degrees from the surface; on
# 2024 at 100 m/s and 4340 at 60 m/s, not fitted, areas come out within 1.3 % (tests/benchmarks/oblique.py).
STRETCH = 0.155
LARGEST_SWEEP = 1.28  # of the fitted areas


class History(NamedTuple):
    """Coverage right after each impact."""

    time_s: np.ndarray  # (n,), sorted
    coverage: np.ndarray  # (n,), rising, 0-1
    sample_points: int

    def at(self, times_s) -> np.ndarray:
        """Coverage at ``times_s`` (any shape): that after the last impact at or before each time."""
        steps = np.concatenate(([0.0], self.coverage))
        return steps[np.searchsorted(self.time_s, times_s, side="right")]


def coverage_history(x, y, time_s, semi_major, semi_minor, azimuth_rad, window_m, spacing_m=None) -> History:
    """First-cover history of a window centred on the origin.

    x, y, time_s, semi_major, semi_minor: (n,) impact centres [m], times [s] and dimple semi-axes [m];
    azimuth_rad: (n,) direction of the major axis from x; window_m: (width, height); spacing_m: largest
    distance of sample points (rounded down to fit the window), default the median semi_minor over
    POINTS_PER_RADIUS.  An axis of 0 covers nothing.  Raises InputError for values not finite or negative.
    """
    columns = [
        np.ascontiguousarray(c, dtype=float) for c in (x, y, time_s, semi_major, semi_minor, azimuth_rad)
    ]
    _check(columns, window_m, spacing_m)
    if spacing_m is None:
        sizes = columns[4][columns[4] > 0.0]
        spacing_m = float(np.median(sizes)) / POINTS_PER_RADIUS if sizes.size else 0.1 * min(window_m)
    order = np.argsort(columns[2], kind="stable")
    cx, cy, t, major, minor, azimuth = (c[order] for c in columns)
    width, height = window_m
    nx, ny = int(np.ceil(width / spacing_m - 1e-9)), int(np.ceil(height / spacing_m - 1e-9))
    new = _compiled()(cx, cy, major, minor, np.cos(azimuth), np.sin(azimuth), width, height, nx, ny)
    return History(t, np.cumsum(new) / (nx * ny), nx * ny)


def coverage_curve(
    x, y, time_s, semi_major, semi_minor, azimuth_rad, window_m, spacing_m, times_s
) -> np.ndarray:
    """Coverage (0-1) at each of ``times_s``; arguments and errors of :func:`coverage_history`."""
    return coverage_history(x, y, time_s, semi_major, semi_minor, azimuth_rad, window_m, spacing_m).at(
        times_s
    )


def time_to(time_s, coverage, level: float = 0.98) -> float | None:
    """First of the rising ``time_s`` (n,) with ``coverage`` (n,) not below ``level``; None if there is none.

    Exact for a :class:`History`; for a sampled curve late by up to one sample.
    """
    reached = np.asarray(coverage) >= level
    return float(np.asarray(time_s)[np.argmax(reached)]) if reached.any() else None


def stretch(sweep):
    """Semi-major axis of an oblique dimple over its semi-minor one, from the sweep s = 2 v_t t_l / a (array).

    s is the way the shot slides while it sinks in, in contact radii.  1 + STRETCH s^2 up to LARGEST_SWEEP, its
    tangent beyond.  The wall of the crater ahead keeps pushing while the shot leaves, so a dimple grows more than
    the circle carried along during loading would (that gives 1 % at s = .68, where 7 % were solved).
    """
    s = np.asarray(sweep, dtype=float)
    seen = np.minimum(s, LARGEST_SWEEP)
    return 1.0 + STRETCH * seen * (2.0 * s - seen)


def dimple_semi_axes(dimple, impacts):
    """Semi-axes [m] and azimuth [rad] of every impact's dimple: (semi_major, semi_minor, azimuth), each (n,).

    ``impacts``: rows of a log, in the window's own coordinates (``glue.surface.window``).  Across the flight a
    dimple is as wide as a normal impact of the same shot and normal speed (``dimple.radius_for``); along the
    tangential velocity it is longer by :func:`stretch` (7 % at 45 degrees and 60 m/s on 2024, 15 % at 30), with
    the reference dimple's loading time scaled by the diameter and the root of the density (by similarity; its
    weak fall with speed is left out).  The shift of the ellipse's centre (half a radius at 30 degrees) is left
    out too: equal impacts share it, so that it moves the pattern and leaves the coverage alone.
    """
    diameter, density = (np.asarray(impacts[name], dtype=float) for name in ("diameter_m", "density_kg_m3"))
    along = tangential_velocity_m_s(impacts)
    semi_minor = np.asarray(dimple.radius_for(diameter, normal_speed_m_s(impacts), density))
    speed = np.sqrt((along**2).sum(axis=-1))
    azimuth = np.arctan2(along[:, 1], along[:, 0])
    return semi_minor * lengthening(dimple, diameter, density, semi_minor, speed), semi_minor, azimuth


def lengthening(dimple, diameter_m, density_kg_m3, semi_minor_m, tangential_speed_m_s):
    """Length over width of the dimples of oblique impacts (arrays of one shape, or numbers); see ``dimple_semi_axes``."""
    heavier = np.sqrt(np.asarray(density_kg_m3) / dimple.density_kg_m3)
    loading_time = dimple.contact_time_s / CONTACT_OVER_LOADING * diameter_m / dimple.diameter_m * heavier
    with np.errstate(divide="ignore", invalid="ignore"):
        sweep = 2.0 * tangential_speed_m_s * loading_time / np.asarray(semi_minor_m, dtype=float)
    return stretch(np.where(np.asarray(semi_minor_m) > 0.0, sweep, 0.0))


def _check(columns, window_m, spacing_m):
    names = ("x", "y", "time_s", "semi_major", "semi_minor", "azimuth_rad")
    problems = [
        f"{name}: must be one-dimensional and as long as x"
        for name, column in zip(names, columns, strict=True)
        if column.shape != (columns[0].size,)
    ]
    problems += [
        f"{name}: {np.count_nonzero(~np.isfinite(column))} values are not finite"
        for name, column in zip(names, columns, strict=True)
        if not np.isfinite(column).all()
    ]
    problems += [
        f"{name}: must not be negative"
        for name, column in zip(names[3:5], columns[3:5], strict=True)
        if (column < 0.0).any()
    ]
    if not (len(window_m) == 2 and min(window_m) > 0.0 and np.isfinite(window_m).all()):
        problems.append(f"window_m = {window_m}: must be two positive lengths")
    if spacing_m is not None and not spacing_m > 0.0:
        problems.append(f"spacing_m = {spacing_m}: must be positive")
    if problems:
        raise InputError(problems)


@cache
def _compiled() -> Callable[..., np.ndarray]:
    """``_first_covers``, compiled."""
    import numba  # here: half a second that who asks for the axes of a dimple does without

    return numba.njit(cache=True)(_first_covers)


def _first_covers(cx, cy, major, minor, cos, sin, width, height, nx, ny):
    """Number of lattice points that each ellipse is the first to cover, (n,) int64, in the order given.

    Points sit at the centres of nx * ny equal cells.  Row by row the ellipse is an exact interval: with
    u = x - cx, v = y - cy it is p u^2 + 2 q u v + r v^2 <= 1.
    """
    dx, dy = width / nx, height / ny
    bare = np.ones((ny, nx), dtype=np.bool_)
    new = np.zeros(cx.size, dtype=np.int64)
    for i in range(cx.size):
        if minor[i] <= 0.0 or major[i] <= 0.0:
            continue
        a2, b2 = 1.0 / major[i] ** 2, 1.0 / minor[i] ** 2
        p = cos[i] ** 2 * a2 + sin[i] ** 2 * b2
        q = cos[i] * sin[i] * (a2 - b2)
        r = sin[i] ** 2 * a2 + cos[i] ** 2 * b2
        half_height = np.sqrt(p / (a2 * b2))
        # a lattice coordinate k belongs to position (k + .5) d - side/2
        origin_x, origin_y = cx[i] + 0.5 * width - 0.5 * dx, cy[i] + 0.5 * height - 0.5 * dy
        first_row = max(0, int(np.ceil((origin_y - half_height) / dy)))
        last_row = min(ny - 1, int(np.floor((origin_y + half_height) / dy)))
        count = 0
        for row in range(first_row, last_row + 1):
            v = row * dy - origin_y
            root = (q * v) ** 2 - p * (r * v * v - 1.0)
            if root < 0.0:
                continue
            half = np.sqrt(root) / p
            middle = origin_x - q * v / p
            first = max(0, int(np.ceil((middle - half) / dx)))
            last = min(nx - 1, int(np.floor((middle + half) / dx)))
            for column in range(first, last + 1):
                if bare[row, column]:
                    bare[row, column] = False
                    count += 1
        new[i] = count
    return new
