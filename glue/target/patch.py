"""Which logged impacts a cell of the target stands for: those of one cell-sized patch of the window.

So the exposure, the order, the speeds and the sizes are the log's own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import normal_speed_m_s

# Impacts that bring less than this share of the nominal normal energy leave dimples finer than the cell's
# elements (radius under a quarter of the nominal one); they are left out and their share is reported.
NEGLIGIBLE_ENERGY = 2e-3
LONGEST_S = 24 * 3600.0  # of the impacts of a patch, estimated; more is taken for a mistake


class Patch(NamedTuple):
    x_m: np.ndarray  # (n,) place inside the patch, 0..side
    y_m: np.ndarray
    energy_J: np.ndarray  # (n,) normal kinetic energy
    radius_m: np.ndarray  # (n,) of the shots
    centre_m: tuple[float, float]
    exposure: float  # sum of dimple areas over the patch's area
    window_exposure: float  # the same over the whole window
    neglected_impacts: int
    neglected_energy_share: float
    index: np.ndarray = np.empty(0, dtype=int)  # (n,) rows of the log


def normal_energy_J(impacts: np.ndarray) -> np.ndarray:
    """Kinetic energy of each impact's normal motion [J], (n,): mass (pi/6 rho d^3) times (v . n)^2 / 2."""
    mass = impacts["density_kg_m3"] * math.pi / 6.0 * impacts["diameter_m"] ** 3
    return 0.5 * mass * normal_speed_m_s(impacts) ** 2


def choose_patch(impacts: np.ndarray, dimple, window_m: tuple[float, float], side_m: float) -> Patch:
    """The impacts of the patch, of those that tile the window, whose exposure is nearest to the window's.

    Empty patches are passed over, ties go to the first.  impacts: structured, in order of time.
    Raises InputError when the window is smaller than a cell, or no patch of it holds an impact.
    """
    return choose_patches(impacts, dimple, window_m, side_m, 1)[0]


def choose_patches(impacts: np.ndarray, dimple, window_m: tuple[float, float], side_m: float, wanted: int) -> list[Patch]:
    """``wanted`` different patches of those that tile the window: one is as ``choose_patch`` says.

    Several are a fair sample: those in the middles of as many equal shares of all patches that hold an impact, in order
    of exposure; so their scatter is not that of look-alikes.  An impact on the window's far edge belongs to the last
    patch, when the patches reach that far.  Raises InputError as choose_patch, and when there are too few.
    """
    count = [int(w / side_m * (1.0 + 1e-12)) for w in window_m]
    if min(count) < 1:
        raise InputError(
            f"target.window_m: {window_m[0]:g} x {window_m[1]:g} m is smaller than the target's cell of {side_m:.3g} m "
            "(accuracy.cell_side_in_radii dimple radii); allowed: at least one cell"
        )
    radius = dimple.radius_for(impacts["diameter_m"], normal_speed_m_s(impacts), impacts["density_kg_m3"])
    area = math.pi * radius**2
    energy = normal_energy_J(impacts)
    nominal = 0.5 * dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3 * dimple.speed_m_s**2
    felt = energy >= NEGLIGIBLE_ENERGY * nominal
    x, y = impacts["x_m"], impacts["y_m"]
    in_window = (abs(x) <= 0.5 * window_m[0]) & (abs(y) <= 0.5 * window_m[1])
    window_exposure = float(area[in_window].sum() / (window_m[0] * window_m[1]))
    column, row = (_tile(at, n, w, side_m) for at, n, w in zip((x, y), count, window_m, strict=True))
    found = []
    for i in range(count[0]):
        for j in range(count[1]):
            inside = (column == i) & (row == j)
            if (inside & felt).any():  # a sparse log leaves tiles empty; they stand for nothing
                found.append((area[inside].sum() / side_m**2, i, j))
    if not found:
        raise InputError("no impact worth solving falls into the window (at least 1): a longer exposure_time_s is needed")
    if len(found) < wanted:
        raise InputError(
            f"accuracy.target_patches: {wanted} patches of {side_m:.3g} m are asked for, {len(found)} of the window's "
            f"{count[0] * count[1]} hold an impact; allowed: up to {len(found)}, or a larger window_m or exposure_time_s"
        )
    if wanted == 1:
        chosen = [min(found, key=lambda tile: abs(tile[0] - window_exposure))]
    else:
        ranked = sorted(found)
        chosen = [ranked[int((k + 0.5) * len(ranked) / wanted)] for k in range(wanted)]
    patches = []
    for exposure, i, j in chosen:
        inside = (column == i) & (row == j)
        kept, left_out = inside & felt, inside & ~felt
        x0, y0 = (i - 0.5 * count[0]) * side_m, (j - 0.5 * count[1]) * side_m
        total = energy[inside].sum()
        patches.append(Patch(
            x_m=x[kept] - x0, y_m=y[kept] - y0, energy_J=energy[kept], radius_m=0.5 * impacts["diameter_m"][kept],
            centre_m=(x0 + 0.5 * side_m, y0 + 0.5 * side_m), exposure=float(exposure), window_exposure=window_exposure,
            neglected_impacts=int(left_out.sum()),
            neglected_energy_share=float(energy[left_out].sum() / total) if total > 0 else 0.0,
            index=np.flatnonzero(kept),
        ))  # fmt: skip
    return patches


def _tile(at: np.ndarray, count: int, window_m: float, side_m: float) -> np.ndarray:
    """Number of the tile along one axis, (n,) int; negative or ``count`` and more outside."""
    tile = np.floor(at / side_m + 0.5 * count).astype(int)
    if count * side_m >= window_m * (1.0 - 1e-9):
        tile[(tile == count) & (at <= 0.5 * window_m)] = count - 1
    return tile


def refuse_outside(patch: Patch, side_m: float) -> None:
    """Raises InputError for impacts that are not on the patch."""
    off = [(v < -1e-9 * side_m) | (v > (1.0 + 1e-9) * side_m) for v in (patch.x_m, patch.y_m)]
    outside = np.flatnonzero(off[0] | off[1])
    if outside.size:
        k = outside[0]
        raise InputError(
            f"impact {k} of the patch strikes at ({patch.x_m[k]:.3g}, {patch.y_m[k]:.3g}) m, outside of it ({outside.size} such); "
            f"allowed: 0 to {side_m:.3g} m along x and y"
        )


def refuse_too_long(impacts: int, seconds_each: float, what: str) -> None:
    """Raises InputError when ``impacts`` of about ``seconds_each`` take longer than LONGEST_S, and says how many would fit."""
    if impacts * seconds_each > LONGEST_S:
        raise InputError(
            f"{what}: {impacts} impacts in the patch would take about {impacts * seconds_each / 3600:.0f} h at {seconds_each:.2g} s each; "
            f"allowed: {LONGEST_S / 3600:.0f} h, some {int(LONGEST_S / seconds_each)} impacts. A shorter exposure_time_s "
            'or target = "layers"'
        )


def unresolved(patch: Patch, dimple, spacing_m: float) -> np.ndarray:
    """Which impacts (n,) leave dimples finer than the mesh: expected radius under one spacing of its top's grid.

    Their energy is spent all the same, over a wider and shallower dent.
    """
    return contact_radii_m(patch, dimple) < spacing_m


def contact_radii_m(patch: Patch, dimple) -> np.ndarray:
    """Expected dimple radius [m] of each impact of ``patch``, (n,).

    Full plasticity at one pressure: energy = pressure pi a^4 / (4 R), so a goes as (energy R)^(1/4).
    """
    mass = dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3
    nominal = 0.5 * mass * dimple.speed_m_s**2 * 0.5 * dimple.diameter_m
    return dimple.radius_m * (patch.energy_J * patch.radius_m / nominal) ** 0.25
