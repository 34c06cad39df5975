"""Height map of a surface under many impacts: the energy stamp, about .1 ms per impact.

Every impact has the same energy to spend, so it does not lower the surface by a fixed shape.  It is pressed
into the *current* surface: the sphere's cap, with the radius of curvature that the single dimple keeps after
rebound, sinks until the volume it takes away [m^3] is

    V = V0 * ratio(k),      V0 the volume of the single dimple below the original surface,        (1)

and ridges from earlier impacts go first.  k is the mean number of earlier impacts under the disc of the
zero-height radius.  Hardened material yields less volume for the same work.  With W(p) = integral of
sigma_y dp [J/m^3] from 0 to p the plastic work per volume up to the mean equivalent plastic strain p,

    W(p_k) = k W(p_1),      ratio(k) = (p_{k+1} - p_k) / p_1,                                     (2)

for the same work buys less and less strain, and volume goes with strain.  p_1, the mean strain of a first
impact, comes from its own plastic work spread over a disc of the zero-height radius a and depth
WORK_DEPTH a:   W(p_1) = m v^2 (1 - e^2) / 2 / (WORK_DEPTH pi a^3).                                (3)

Where the cap did not touch, the single dimple's pile-up is added, times ratio(k).

Limits: shapes are circular also for oblique impacts (normal speed only, no ploughing); nothing flows back
from the sides.  Agreement with sequential finite-element cells: tests/surface/test_stamp.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from glue.errors import InputError
from glue.flow.impacts import normal_speed_m_s

# Depth, in dimple radii, over which the work is spread in (3): fitted to the growth in the tests (Sa changes
# by 6 % between 1 and 2).  At 2, p_1 = .182 for the reference impact; the mean equivalent plastic strain of
# its finite-element solution over that volume is .180.
WORK_DEPTH = 2.0
CAP_REACH = 1.6  # the cap is followed to this many dimple radii: a ridge may meet it outside the disc
PILE_REACH = 3.0  # the pile-up is cut off at this many dimple radii, shifted to be zero there
TABLE = 512  # entries of the pile-up's table
MAX_COUNT = 1000  # ratio(k) is tabulated up to here and constant beyond


class Stamp(NamedTuple):
    """A single dimple made ready for stamping."""

    cap_radius_m: float
    volume_m3: float
    radius_m: float
    pile_m: np.ndarray  # (TABLE,) pile-up at r = 0 .. PILE_REACH * radius_m, even steps


def stamp_of(dimple) -> Stamp:
    """Stamp of a dimple with ``profile_r_m``, ``profile_z_m`` (z < 0 in the dent), ``radius_m``, ``depth_m``.

    The cap has the dimple's own depth d and volume V: V = pi d^2 (3 R - d)/3, so R = V/(pi d^2) + d/3, and
    one impact on a flat surface gives both back.  Raises InputError when the profile holds no dent.
    """
    r = np.linspace(0.0, dimple.radius_m, 4001)
    dent = np.maximum(-np.interp(r, dimple.profile_r_m, dimple.profile_z_m), 0.0)
    volume = float(np.sum(math.pi * (r[1:] ** 2 - r[:-1] ** 2) * 0.5 * (dent[1:] + dent[:-1])))
    if not (volume > 0.0 and dimple.depth_m > 0.0):
        raise InputError(f"the dimple has no dent: depth {dimple.depth_m} m, volume {volume} m3")
    depth = dimple.depth_m
    r = np.linspace(0.0, PILE_REACH * dimple.radius_m, TABLE)
    height = np.interp(r, dimple.profile_r_m, dimple.profile_z_m)
    pile = np.where(r > dimple.radius_m, np.maximum(height - height[-1], 0.0), 0.0)
    return Stamp(volume / (math.pi * depth**2) + depth / 3.0, volume, dimple.radius_m, pile)


def plastic_work_density_Pa(dimple) -> float:
    """Plastic work of one impact per volume [J/m^3], equation (3), from the dimple's speed and rebound."""
    mass = dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3
    work = 0.5 * mass * dimple.speed_m_s**2 * (1.0 - dimple.restitution**2)
    return work / (WORK_DEPTH * math.pi * dimple.radius_m**3)


def volume_ratio(flow_stress_Pa, work_density_Pa: float, counts: int = MAX_COUNT) -> np.ndarray:
    """ratio(k) of equation (2) for k = 0 .. counts-1 earlier impacts, shape (counts,); ratio(0) = 1.

    flow_stress_Pa: function of the equivalent plastic strain (float) -> flow stress [Pa];
    work_density_Pa: plastic work of one impact per volume [J/m^3].
    """
    most = (
        counts * work_density_Pa / flow_stress_Pa(0.0)
    )  # strain cannot exceed that of a perfectly plastic law
    strain = np.concatenate(([0.0], np.geomspace(1e-6 * most, most * (1.0 + 1e-9), 4000)))
    stress = np.array([flow_stress_Pa(float(p)) for p in strain])
    work = np.concatenate(([0.0], np.cumsum(0.5 * (stress[1:] + stress[:-1]) * np.diff(strain))))
    # inverted exactly for the polygon through (strain, stress): linear interpolation of W would make steps
    wanted = np.arange(counts + 1) * work_density_Pa
    i = np.clip(np.searchsorted(work, wanted, side="right") - 1, 0, strain.size - 2)
    slope = (stress[i + 1] - stress[i]) / (strain[i + 1] - strain[i])
    rest = wanted - work[i]
    reached = strain[i] + 2.0 * rest / (stress[i] + np.sqrt(stress[i] ** 2 + 2.0 * slope * rest))
    return np.diff(reached) / reached[1]


def height_map(impacts, dimple, window_m, spacing_m: float, *, flow_stress_Pa, initial=None):
    """Height map (x_m (nx,), y_m (ny,), z_m (ny, nx)) [m] of a window centred on the origin, z = 0 untouched.

    impacts: rows of a log in the window's own coordinates (``glue.surface.window``), those outside the window
    that reach in included; dimple: see :func:`stamp_of`, with ``radius_for(diameter_m, normal_speed_m_s,
    density_kg_m3)``, restitution and the diameter, density and speed it was solved for; spacing_m: largest
    distance of points; flow_stress_Pa: the material law in use, as for :func:`volume_ratio`; initial: a function
    (shape, dx, dy) that gives the heights before peening, default flat.

    Other sizes, densities and speeds scale the stamp: lengths across with the radius a, the cap's radius with
    the shot diameter D, heights with a^2/D.  Raises InputError.
    """
    width, height = window_m
    if not (spacing_m > 0.0 and width > 0.0 and height > 0.0 and math.isfinite(width * height / spacing_m)):
        raise InputError(f"window_m = {window_m}, spacing_m = {spacing_m}: must be positive and finite")
    nx, ny = math.ceil(width / spacing_m - 1e-9), math.ceil(height / spacing_m - 1e-9)
    dx, dy = width / nx, height / ny
    stamp = stamp_of(dimple)
    order = np.argsort(impacts["time_s"], kind="stable")
    diameter = np.asarray(impacts["diameter_m"], dtype=float)[order]
    speed = np.asarray(normal_speed_m_s(impacts), dtype=float)[order]
    x, y, density = (np.asarray(impacts[name], dtype=float)[order] for name in ("x_m", "y_m", "density_kg_m3"))
    finite = all(np.isfinite(column).all() for column in (x, y, diameter, speed, density))
    if not finite or (diameter <= 0.0).any() or (speed <= 0.0).any():
        raise InputError("impacts: positions, sizes and speeds must be finite, and every shot must move into the target")
    radius = np.asarray(dimple.radius_for(diameter, speed, density), dtype=float)
    largest = float(radius.max(initial=0.0))
    # Impacts that only reach in need their own earlier impacts too: the margin holds a whole disc more.
    margin = (PILE_REACH + CAP_REACH) * largest
    mx, my = math.ceil(margin / dx), math.ceil(margin / dy)
    near = (np.abs(x) < 0.5 * width + PILE_REACH * radius) & (np.abs(y) < 0.5 * height + PILE_REACH * radius)
    shape = (ny + 2 * my, nx + 2 * mx)
    z = np.zeros(shape) if initial is None else np.ascontiguousarray(initial(shape, dx, dy), dtype=float)
    if near.any():
        ratio = volume_ratio(flow_stress_Pa, plastic_work_density_Pa(dimple))
        scale = radius[near] / stamp.radius_m, diameter[near] / dimple.diameter_m
        # to grid coordinates, in which point (row, column) lies at (column dx, row dy)
        gx, gy = x[near] + 0.5 * width + (mx - 0.5) * dx, y[near] + 0.5 * height + (my - 0.5) * dy
        _press(z, dx, dy, gx, gy, scale[0], scale[1], *stamp[:3], stamp.pile_m, ratio)
    x_m, y_m = (np.arange(nx) + 0.5) * dx - 0.5 * width, (np.arange(ny) + 0.5) * dy - 0.5 * height
    return x_m, y_m, np.ascontiguousarray(z[my : my + ny, mx : mx + nx])


@numba.njit(cache=True)
def _press(z, dx, dy, gx, gy, across, size, cap_radius, volume, radius, pile, ratio):
    """Press stamps into ``z`` in order; ``across`` = a/a0 and ``size`` = D/D0 of each."""
    count = np.zeros(z.shape, dtype=np.int32)
    half_width = int(CAP_REACH * radius * across.max() / min(dx, dy)) + 2
    cap = np.empty((2 * half_width + 1, 2 * half_width + 1))
    for i in range(gx.size):
        a = radius * across[i]
        sphere = cap_radius * size[i]
        reach2 = min(CAP_REACH * a, 0.999 * sphere) ** 2
        row0, row1, col0, col1 = _box(z, dx, dy, gx[i], gy[i], math.sqrt(reach2))
        # the cap above its own lowest point, the earlier impacts and the lowest gap, in one pass
        touched, under, lowest = 0, 0, np.inf
        for row in range(row0, row1 + 1):
            for col in range(col0, col1 + 1):
                r2 = (col * dx - gx[i]) ** 2 + (row * dy - gy[i]) ** 2
                if r2 > reach2:
                    cap[row - row0, col - col0] = np.inf
                    continue
                cap[row - row0, col - col0] = sphere - math.sqrt(sphere * sphere - r2)
                lowest = min(lowest, z[row, col] - cap[row - row0, col - col0])
                if r2 <= a * a:
                    touched += count[row, col]
                    under += 1
                    count[row, col] += 1
        if under == 0:  # smaller than the grid sees: a grazing shot
            continue
        hardening = _at(ratio, touched / under)
        heights = across[i] ** 2 / size[i] * hardening
        target = volume * across[i] ** 2 * heights
        tip = _sink(z, cap, row0, row1, col0, col1, lowest, target / (dx * dy))
        for row in range(row0, row1 + 1):
            for col in range(col0, col1 + 1):
                level = tip + cap[row - row0, col - col0]
                if z[row, col] > level:
                    z[row, col] = level
                    cap[row - row0, col - col0] = -1.0  # touched: no pile-up here
        step = PILE_REACH * a / (pile.size - 1)
        outer = _box(z, dx, dy, gx[i], gy[i], PILE_REACH * a)
        for row in range(outer[0], outer[1] + 1):
            for col in range(outer[2], outer[3] + 1):
                if row0 <= row <= row1 and col0 <= col <= col1 and cap[row - row0, col - col0] < 0.0:
                    continue
                r2 = (col * dx - gx[i]) ** 2 + (row * dy - gy[i]) ** 2
                if a * a < r2 < (PILE_REACH * a) ** 2:
                    z[row, col] += heights * _at(pile, math.sqrt(r2) / step)


@numba.njit(cache=True)
def _sink(z, cap, row0, row1, col0, col1, lowest, target):
    """Height of the cap's tip at which it displaces ``target`` (sum of heights over grid points).

    The displaced sum is convex and piecewise linear in the tip's height, so Newton from below rises
    monotonically and ends exactly; from the lowest gap, where every point is touched, one step gets below.
    """
    tip = lowest
    for _ in range(200):
        displaced, points = 0.0, 0
        for row in range(row0, row1 + 1):
            for col in range(col0, col1 + 1):
                gap = z[row, col] - cap[row - row0, col - col0] - tip
                if gap >= 0.0:
                    displaced += gap
                    points += 1
        step = (displaced - target) / points
        tip += step
        if abs(displaced - target) <= 1e-12 * target:
            break
    return tip


@numba.njit(cache=True)
def _box(z, dx, dy, x, y, reach):
    """First and last row and column of ``z`` within ``reach`` of (x, y)."""
    return (
        max(0, int(math.ceil((y - reach) / dy))),
        min(z.shape[0] - 1, int(math.floor((y + reach) / dy))),
        max(0, int(math.ceil((x - reach) / dx))),
        min(z.shape[1] - 1, int(math.floor((x + reach) / dx))),
    )


@numba.njit(cache=True)
def _at(table, position):
    """Linear interpolation in an even table, constant beyond its end."""
    k = int(position)
    if k >= table.size - 1:
        return table[table.size - 1]
    return table[k] + (position - k) * (table[k + 1] - table[k])
