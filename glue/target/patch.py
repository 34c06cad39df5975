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
    count = [int(w // side_m) for w in window_m]
    if min(count) < 1:
        raise InputError(
            f"target.window_m: {window_m[0]:g} x {window_m[1]:g} m is smaller than the target's cell of {side_m:.3g} m "
            "(accuracy.cell_side_in_radii dimple radii); allowed: at least one cell"
        )
    radius = dimple.radius_for(impacts["diameter_m"], normal_speed_m_s(impacts), impacts["density_kg_m3"])
    area = math.pi * radius**2
    x, y = impacts["x_m"], impacts["y_m"]
    in_window = (abs(x) <= 0.5 * window_m[0]) & (abs(y) <= 0.5 * window_m[1])
    wanted = area[in_window].sum() / (window_m[0] * window_m[1])
    energy = normal_energy_J(impacts)
    nominal = 0.5 * dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3 * dimple.speed_m_s**2
    felt = energy >= NEGLIGIBLE_ENERGY * nominal
    best = None
    for i in range(count[0]):
        for j in range(count[1]):
            x0, y0 = (i - 0.5 * count[0]) * side_m, (j - 0.5 * count[1]) * side_m
            inside = (x >= x0) & (x < x0 + side_m) & (y >= y0) & (y < y0 + side_m)
            exposure = area[inside].sum() / side_m**2
            if not (inside & felt).any():
                continue  # a sparse log leaves tiles empty; they stand for nothing
            if best is None or abs(exposure - wanted) < best[0]:
                best = (abs(exposure - wanted), x0, y0, inside, exposure)
    if best is None:
        raise InputError("no impact worth solving falls into the window (at least 1): a longer exposure_time_s is needed")
    _, x0, y0, inside, exposure = best
    kept, left_out = inside & felt, inside & ~felt
    total = energy[inside].sum()
    return Patch(
        x_m=x[kept] - x0, y_m=y[kept] - y0, energy_J=energy[kept], radius_m=0.5 * impacts["diameter_m"][kept],
        centre_m=(x0 + 0.5 * side_m, y0 + 0.5 * side_m), exposure=float(exposure), window_exposure=float(wanted),
        neglected_impacts=int(left_out.sum()),
        neglected_energy_share=float(energy[left_out].sum() / total) if total > 0 else 0.0,
        index=np.flatnonzero(kept),
    )  # fmt: skip


def contact_radii_m(patch: Patch, dimple) -> np.ndarray:
    """Expected dimple radius [m] of each impact of ``patch``, (n,).

    Full plasticity at one pressure: energy = pressure pi a^4 / (4 R), so a goes as (energy R)^(1/4).
    """
    mass = dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3
    nominal = 0.5 * mass * dimple.speed_m_s**2 * 0.5 * dimple.diameter_m
    return dimple.radius_m * (patch.energy_J * patch.radius_m / nominal) ** 0.25
