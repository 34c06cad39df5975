"""What the target benchmark computes: logs made by chance, cells and blocks under them, the single impact beside them."""

from __future__ import annotations

import math
import tempfile
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from glue.flow.impacts import COLUMNS
from glue.scene.catalogue import material
from glue.scene.presets import PRESETS
from glue.solvers import repo_root
from glue.target.cell import run_cell
from glue.target.cell_result import CellResult
from glue.target.contact import ContactNumerics, solve_contact
from glue.target.dimple import Dimple, solve_dimple
from glue.target.driver import law_table
from glue.target.patch import Patch, normal_energy_J
from glue.target.reduced_impact import ReducedImpact

WORK = repo_root() / "build" / "bench"
AL2024 = material("al2024-t351")
STEEL, SPEED, DIAMETER = 7800.0, 60.0, 1e-3  # kg/m3, m/s, m
EXPOSURES = {0.28: 0.3285, 0.69: 1.1712, 0.98: 3.9120}  # coverage: dimple areas over area, -ln(1 - coverage)
INSIDE = (0.13, 1.3)  # dimple radii of depth over which layer means are compared
BLOCK_SIDE = 5.5  # dimple radii, of the patch whose impacts the block solves; the inner 2.5 are measured


@cache
def dimple(elements: int = 6) -> Dimple:
    """The reference dimple; from the cache when it was solved before."""
    with tempfile.TemporaryDirectory(prefix="peen-bench-") as folder:
        return solve_dimple(AL2024, speed_m_s=SPEED, density_kg_m3=STEEL, diameter_m=DIAMETER,
                            elements_per_radius=elements, workdir=Path(folder))  # fmt: skip


def count_for(exposure: float, side_m: float) -> int:
    """Impacts of the reference shot that bring ``exposure`` to a square."""
    return max(1, round(exposure * side_m**2 / (math.pi * dimple().radius_m ** 2)))


def exposure_of(count: int, side_m: float) -> float:
    """Dimple areas of so many impacts over a square's area."""
    return count * math.pi * (dimple().radius_m / side_m) ** 2


def cell_side(preset: str = "balanced") -> float:
    return PRESETS[preset].cell_side_in_radii * dimple().radius_m


def chance_log(side_m: float, count: int, seed: int, speed: float = SPEED, diameter: float = DIAMETER) -> np.ndarray:
    """An impact log: ``count`` normal impacts anywhere in a square around the origin."""
    rng = np.random.default_rng(seed)
    log = np.zeros(count, COLUMNS)
    log["impact_id"] = log["shot_id"] = np.arange(count)
    log["time_s"] = np.arange(count) * 1e-3
    log["x_m"], log["y_m"] = rng.uniform(-0.5 * side_m, 0.5 * side_m, (2, count))
    log["vz_in_m_s"], log["vz_out_m_s"], log["nz"] = -speed, 0.34 * speed, 1.0
    log["diameter_m"], log["density_kg_m3"] = diameter, STEEL
    return log


def exposures_in(log: np.ndarray, side_m: float) -> np.ndarray:
    """(impacts,) mean hits per point of a square of ``side_m`` around the origin, after each impact of ``log``."""
    grid = np.linspace(-0.5 * side_m, 0.5 * side_m, 101)
    x, y = np.meshgrid(grid, grid)
    hit = [np.mean((x - row["x_m"]) ** 2 + (y - row["y_m"]) ** 2 < dimple().radius_m ** 2) for row in log]
    return np.cumsum(hit)


def patch_of(log: np.ndarray, side_m: float, exposure: float) -> Patch:
    """All of ``log`` as a periodic cell's patch."""
    return Patch(log["x_m"] + 0.5 * side_m, log["y_m"] + 0.5 * side_m, normal_energy_J(log), 0.5 * log["diameter_m"],
                 (0.0, 0.0), exposure, exposure, 0, 0.0, np.arange(len(log)))  # fmt: skip


def cell(folder: Path, seed: int, exposures, *, law=None, preset: str = "balanced", target=AL2024) -> list[CellResult]:
    """The cell under impacts by chance, after each exposure."""
    accuracy = PRESETS[preset]
    side = cell_side(preset)
    counts = [count_for(e, side) for e in exposures]
    log = chance_log(side, counts[-1], seed)
    table = law_table(target.E_Pa, target.nu, law or target.combined)
    return run_cell("benchmark", table, accuracy, dimple(), patch_of(log, side, exposures[-1]), side, folder, snapshots=counts, resume=True)


def block(log: np.ndarray, folder: Path, *, law=None, numerics=ContactNumerics(), snapshots=(), side_m=None):  # noqa: B008 - frozen
    """The contact model under ``log``, all of it."""
    side = side_m or BLOCK_SIDE * dimple().radius_m
    numerics = replace(numerics, side_in_radii=side / dimple().radius_m)
    return solve_contact(AL2024, log, dimple(), (side * 1.0001, side * 1.0001), folder, law=law,
                         numerics=numerics, snapshots=snapshots, title="benchmark", resume=True)  # fmt: skip


def in_plane(result) -> np.ndarray:
    """(layers,) mean of both in-plane stresses [Pa]."""
    return 0.5 * (result.sigma_xx_Pa + result.sigma_yy_Pa)


def at_depths(result, depth_m: np.ndarray) -> np.ndarray:
    return np.interp(depth_m, result.depth_m, in_plane(result))


def deviation(ours: np.ndarray, theirs: np.ndarray) -> tuple[float, float]:
    """(largest, rms) difference over the largest of ``theirs``."""
    off = (ours - theirs) / np.abs(theirs).max()
    return float(np.abs(off).max()), float(np.sqrt(np.mean(off**2)))


def depths(count: int = 24) -> np.ndarray:
    """Depths [m] over INSIDE."""
    return np.linspace(*INSIDE, count) * dimple().radius_m


def bins_of(impact: ReducedImpact, edges_mm: np.ndarray, reach_mm: float) -> np.ndarray:
    """Mean radial stress [MPa] of an axisymmetric impact within ``reach_mm`` of the axis, by depth."""
    R = 0.5e3 * DIAMETER
    r, z = impact.points["r"] * R, -impact.points["z"] * R
    near = r < reach_mm
    which, weight = np.digitize(z[near], edges_mm) - 1, impact.points["volume"][near]
    ok = (which >= 0) & (which < len(edges_mm) - 1)
    sums = [np.bincount(which[ok], w[ok], minlength=len(edges_mm) - 1) for w in (weight * impact.points["s_rr"][near], weight)]
    return sums[0] / sums[1]


def bins_of_points(points: dict[str, np.ndarray], edges_mm: np.ndarray, reach_mm: float) -> np.ndarray:
    """The same of a block's Gauss points around the origin."""
    r = np.hypot(points["x_mm"], points["y_mm"])
    near = (r < reach_mm) & (r > 0)
    c, s = points["x_mm"][near] / r[near], points["y_mm"][near] / r[near]
    radial = c * c * points["s_xx"][near] + s * s * points["s_yy"][near] + 2 * c * s * points["s_xy"][near]
    which, weight = np.digitize(-points["z_mm"][near], edges_mm) - 1, points["volume_mm3"][near]
    ok = (which >= 0) & (which < len(edges_mm) - 1)
    sums = [np.bincount(which[ok], w[ok], minlength=len(edges_mm) - 1) for w in (weight * radial, weight)]
    return sums[0] / sums[1]


class Clock:
    """Wall seconds since it was made."""

    def __init__(self):
        self.begun = time.monotonic()

    @property
    def s(self) -> float:
        return time.monotonic() - self.begun
