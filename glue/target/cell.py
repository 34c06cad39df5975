"""The target as a small periodic cell: every logged impact of one patch, one sphere after another, in FreeFEM.

Only exposure matters for an evenly peened surface, so a cell of a few dimple radii stands for the part.  Where
impacts overlap, plain power-law hardening never levels off; the material's bounded combined law is used.
Small strain, vertical frictionless contact; the part is taken as infinitely thick (clamped sideways).  At finite strain
a mesh this coarse tangles where spheres flatten the ridges between dents (measured: after 6-11 impacts at 6-8 elements a
side, any bounded law); vertical contact forces on the undeformed surface are within a few per cent of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from glue.errors import NotConverged
from glue.scene.model import Scene
from glue.scene.presets import CELL_DEPTH_IN_RADII, Accuracy
from glue.solvers import run_freefem
from glue.target.dimple import Dimple
from glue.target.driver import Parameter, kernel_flavour, law_table, write_driver
from glue.target.cache import finished_key, is_finished, mark_finished
from glue.target.patch import Patch, choose_patches, contact_radii_m, refuse_outside, refuse_too_long, unresolved
from glue.target.progress import relay
from glue.target.tables import read_table

LITERATURE_THRESHOLD = 0.027  # equivalent plastic strain that finite-element studies often count as covered
NOMINAL_DEPTH_LIMIT = 0.3  # nominal dimple of this mesh against the representative one: +7 % balanced, +16 % at 300 m/s
BALANCE_LIMIT = 0.05  # layer mean of the vertical stress (exactly 0) over the largest in-plane one
# In-plane stress of the lowest layer over the largest: below 2 % as a rule; 30 % where a shot's force over the cell's area makes
# its whole height yield (ten on one spot, or a cell of 2.6 radii).
FLOOR_LIMIT = 0.1
FINER_STEPS = 3  # a path that does not come out is tried once more with so many times the penetration steps

_FIRST_LAYER_IN_RADII = 0.1
_GAP_IN_RADII = 4.4e-4
_MEAN_DILATATION = 0.9  # see freefem/plugin/block_forces.hpp
_REACH = 1.9  # of the contact candidates, over the expected contact radius; grows by itself
_MAX_ITERATIONS = 150
_SECONDS = 0.7e-6  # per impact over unknowns^1.5, 2 steps: 0.73 s with 10 thousand, 1.4 with 14.6, 1.8 with 20.4
_SOURCES = ("freefem/cell*.edp", "freefem/lib/*", "freefem/plugin/*")


@dataclass(frozen=True)
class CellResult:
    """Layer means over the cell (n layers, top first) and the cell's own surface."""

    depth_m: np.ndarray  # (n,) middle of each layer
    sigma_xx_Pa: np.ndarray  # (n,)
    sigma_yy_Pa: np.ndarray
    sigma_xx_std_Pa: (
        np.ndarray
    )  # standard deviation over position inside the layer, of blocks an element wide
    sigma_yy_std_Pa: np.ndarray
    peeq: np.ndarray
    peeq_std: np.ndarray
    balance_error: float  # see BALANCE_LIMIT
    coverage_peeq: float  # share of the top layer above edge_threshold; nan when one impact hardly yields the layer
    coverage_peeq_027: float  # and above LITERATURE_THRESHOLD
    edge_threshold: float  # plastic strain at the edge of the nominal dimple on this very mesh
    nominal_depth_error: (
        float  # depth of the nominal dimple on this mesh over the representative dimple's, minus 1
    )
    nominal_force_error: float
    history: dict[str, np.ndarray]  # (impacts,) each: columns of impacts_done.csv
    surface_x_m: np.ndarray  # (m,) nodes of the cell's surface
    surface_y_m: np.ndarray
    surface_z_m: np.ndarray
    patch: Patch
    side_m: float
    floor_m: float  # depth of the cell
    impacts: int
    dofs: int
    wall_s: float
    unresolved_impacts: int = 0  # whose dimples are finer than the elements, see glue.target.patch.unresolved
    unresolved_energy_share: float = 0.0


def solve_cell(
    scene: Scene,
    impacts: np.ndarray,
    dimple: Dimple,
    workdir: Path,
    progress: Callable[[float, str], None] | None = None,
) -> CellResult:
    """Residual stress and plastic strain of ``scene``'s target under the logged ``impacts`` of one patch.

    Writes the driver, log and tables into ``workdir``.  Raises InputError (window smaller than a cell, no impact in
    it, too many), SolverFailed, NotConverged.
    """
    (patch,) = cell_patches(scene, impacts, dimple, 1)
    return solve_patch(scene, dimple, patch, workdir, progress)


def cell_patches(scene: Scene, impacts: np.ndarray, dimple: Dimple, count: int) -> list[Patch]:
    """``count`` patches of the window as large as the scene's cell; raises InputError as ``choose_patches``."""
    return choose_patches(impacts, dimple, scene.target.window_m, _side_m(scene.accuracy, dimple), count)


def solve_patch(
    scene: Scene, dimple: Dimple, patch: Patch, workdir: Path, progress: Callable[[float, str], None] | None = None,
    *, resume: bool = False,
) -> CellResult:  # fmt: skip
    """As ``solve_cell`` for a patch chosen before; resume: a run that ended well in ``workdir`` with the same inputs is read."""
    material, accuracy = scene.target.material, scene.accuracy
    law = law_table(material.E_Pa, material.nu, material.combined)
    side = _side_m(accuracy, dimple)
    try:
        return run_cell(scene.name, law, accuracy, dimple, patch, side, workdir, progress=progress, resume=resume)[-1]
    except NotConverged as problem:
        if "is not found" not in problem.cause:
            raise
    # Two penetration steps can miss, again and again, the depth that spends the energy where impacts coincide.
    finer = replace(accuracy, cell_load_steps=FINER_STEPS * accuracy.cell_load_steps)
    return run_cell(scene.name, law, finer, dimple, patch, side, workdir, progress=progress, resume=resume)[-1]


def _side_m(accuracy: Accuracy, dimple: Dimple) -> float:
    return accuracy.cell_side_in_radii * dimple.radius_m


def seconds_per_impact(accuracy: Accuracy) -> float:
    """Wall time [s] of one impact, to a factor of two; the cell has one layer of P2 elements more than per side."""
    n = accuracy.cell_elements_per_side
    unknowns = 3 * (2 * n) ** 2 * (2 * (n + 1) + 1)
    return _SECONDS * unknowns**1.5 * (accuracy.cell_load_steps / 2.0) ** 0.25  # 1 to 6 steps: 7.1 to 9.8 s


def run_cell(
    name: str, law: list[float], accuracy: Accuracy, dimple: Dimple, patch: Patch, side_m: float, workdir: Path,
    *, snapshots: Sequence[int] = (), progress: Callable[[float, str], None] | None = None, resume: bool = False,
) -> list[CellResult]:  # fmt: skip
    """The cell after each of ``snapshots`` impacts (rising) and after all of them; law: as from ``law_table``.

    resume: tables that a run of the same inputs finished in ``workdir`` are read, nothing is run.
    Raises InputError (impacts outside the cell, too many), SolverFailed, NotConverged.
    """
    refuse_outside(patch, side_m)
    refuse_too_long(len(patch.x_m), seconds_per_impact(accuracy), "target = cell")
    counts = sorted({*snapshots, len(patch.x_m)})
    workdir.mkdir(parents=True, exist_ok=True)
    driver, text = workdir / "driver.edp", cell_driver(name, law, accuracy, dimple, patch, side_m, counts)
    key = finished_key(text, _SOURCES) if resume else ""
    if not (resume and is_finished(workdir, key)):
        driver.write_text(text)
        run_freefem(driver, cwd=workdir, log=workdir / "freefem.log", status=workdir / "status", on_line=relay(progress))
    results = [read_cell(workdir, accuracy, dimple, patch, side_m, count) for count in counts]
    for result in results:
        _check(result, workdir)
    if resume:
        mark_finished(workdir, key)
    return results


def layer_bounds_mm(accuracy: Accuracy, radius_m: float) -> np.ndarray:
    """Depths [mm] of the element layers' faces, (layers + 1,), 0 first; thickness grows geometrically."""
    depth, layers = CELL_DEPTH_IN_RADII * radius_m * 1e3, _layers(accuracy)
    ratio = _ratio(layers)
    return depth * (ratio ** np.arange(layers + 1) - 1.0) / (ratio**layers - 1.0)


def _layers(accuracy: Accuracy) -> int:
    return accuracy.cell_elements_per_side + 1


def _ratio(layers: int) -> float:
    """Growth that makes the first layer _FIRST_LAYER_IN_RADII thick: bisection of s (q^n - 1)/(q - 1) = depth."""
    lo, hi = 1.0 + 1e-9, 10.0
    for _ in range(80):
        q = 0.5 * (lo + hi)
        total = _FIRST_LAYER_IN_RADII * (q**layers - 1.0) / (q - 1.0)
        lo, hi = (q, hi) if total < CELL_DEPTH_IN_RADII else (lo, q)
    return 0.5 * (lo + hi)


def cell_driver(
    name: str, law: list[float], accuracy: Accuracy, dimple: Dimple, patch: Patch, side_m: float, snapshots: Sequence[int] = ()
) -> str:
    """Text of the FreeFEM driver of a cell; lengths in mm, energies in mJ, stresses in MPa."""
    layers, radius = _layers(accuracy), dimple.radius_m * 1e3
    mass = dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3
    parameters = [
        Parameter("string", "outDir", ".", "folder of the results"),
        Parameter("string", "statusFile", "status", "written last"),
        Parameter("real[int]", "law", law, "E nu | A B n | Q b | X1 g1 X2 g2, stresses in MPa"),
        Parameter("real", "side", side_m * 1e3, "mm, period in x and y"),
        Parameter("real", "depth", CELL_DEPTH_IN_RADII * radius, "mm"),
        Parameter("int", "elements", accuracy.cell_elements_per_side, "per side"),
        Parameter("int", "layers", layers, "of elements"),
        Parameter("real", "layerRatio", _ratio(layers), "thickness of a layer over that above it"),
        Parameter("int", "loadSteps", accuracy.cell_load_steps, "penetration steps per impact"),
        Parameter("real", "forceTolerance", accuracy.cell_force_tolerance, "out-of-balance over contact force"),
        Parameter("real", "gapTolerance", _GAP_IN_RADII * radius, "mm"),
        Parameter("int", "maxIterations", _MAX_ITERATIONS, "per step"),
    ]
    energy, shot = 0.5 * mass * dimple.speed_m_s**2 * 1e3, 0.5 * dimple.diameter_m * 1e3
    loads = [patch.x_m * 1e3, patch.y_m * 1e3, patch.energy_J * 1e3, patch.radius_m * 1e3]
    told = "impacts in order of time: x mm, y mm, normal kinetic energy mJ, shot radius mm"
    if kernel_flavour() == "script":
        parameters += [
            Parameter("real", "nominalEnergy", energy, "mJ, of the representative dimple"),
            Parameter("real", "nominalForce", dimple.peak_force_N, "N"),
            Parameter("real", "nominalRadius", shot, "mm, of the shot"),
        ]
        return write_driver(f"Target cell of {name}", parameters, ["points_small_script.idp", "cell_small.edp"],
                            np.column_stack(loads).tolist(), told)  # fmt: skip
    reach = _REACH * radius
    parameters += [
        Parameter("int", "finiteStrain", 0, "a mesh this coarse tangles at finite strain where impacts overlap"),
        Parameter("real", "meanDilatation", _MEAN_DILATATION, "share of the pressure taken as the element's mean"),
        Parameter("real", "zoneFactor", 1e3, "the whole cell is iterated on"),
        Parameter("real", "stepBend", 1.25, "above 1: short steps first"),
        Parameter("int", "releaseSteps", 1, "no restitution"),
        Parameter("int", "andersonDepth", 10, "iterates combined"),
        Parameter("real", "nominalSlope", dimple.peak_force_N**2 / (2 * energy) / shot, "N/mm2, expected force over penetration and shot radius"),
        Parameter("real[int]", "nominal", [energy, shot, reach], "the representative impact: mJ, shot radius mm, reach mm"),
        Parameter("int[int]", "snapshots", [int(n) for n in (snapshots or [len(patch.x_m)])], "written after so many impacts"),
    ]  # fmt: skip
    loads.append(_REACH * contact_radii_m(patch, dimple) * 1e3)
    return write_driver(f"Target cell of {name}", parameters, ["cell.edp"], np.column_stack(loads).tolist(),
                        told + ", reach of the candidates mm")  # fmt: skip


def read_cell(
    workdir: Path, accuracy: Accuracy, dimple: Dimple, patch: Patch, side_m: float, count: int
) -> CellResult:
    """Read the tables of a finished cell after ``count`` impacts and reduce them to layer means."""
    points, surface = read_table(workdir / f"points-{count}.csv"), read_table(workdir / f"surface-{count}.csv")
    result = {k: v[0] for k, v in read_table(workdir / "result.csv").items()}
    done = read_table(workdir / "impacts_done.csv")
    nominal = {k: v[0] for k, v in done.items()}
    bounds = layer_bounds_mm(accuracy, dimple.radius_m)
    layer = np.clip(np.searchsorted(bounds, -points["z_mm"]) - 1, 0, len(bounds) - 2)
    volume = np.bincount(layer, points["volume_mm3"])

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(layer, points["volume_mm3"] * values) / volume

    # Scatter is that of means over blocks of six tetrahedra: inside one element plastic flow at constant volume lets
    # the pressure oscillate from Gauss point to Gauss point (twice the scatter, no physics; layer means are free of it).
    n, size = accuracy.cell_elements_per_side, side_m * 1e3 / accuracy.cell_elements_per_side
    column = np.minimum(points["x_mm"] // size, n - 1) * n + np.minimum(points["y_mm"] // size, n - 1)
    block = layer * n * n + column.astype(int)
    block_volume = np.bincount(block, points["volume_mm3"])

    def spread(values: np.ndarray) -> np.ndarray:
        return (
            (np.bincount(block, points["volume_mm3"] * values) / block_volume).reshape(-1, n * n).std(axis=1)
        )

    vertical, in_plane = mean(points["s_zz"]), mean(0.5 * (points["s_xx"] + points["s_yy"]))
    top, fresh = read_table(workdir / "final_top.csv"), read_table(workdir / "nominal_top.csv")
    threshold = edge_threshold(fresh["peeq"], fresh["volume_mm3"], math.pi * dimple.radius_m**2 / side_m**2)
    faint = unresolved(patch, dimple, side_m / n)[:count]
    return CellResult(
        depth_m=0.5e-3 * (bounds[:-1] + bounds[1:]),
        sigma_xx_Pa=mean(points["s_xx"]) * 1e6, sigma_yy_Pa=mean(points["s_yy"]) * 1e6,
        sigma_xx_std_Pa=spread(points["s_xx"]) * 1e6, sigma_yy_std_Pa=spread(points["s_yy"]) * 1e6,
        peeq=mean(points["peeq"]), peeq_std=spread(points["peeq"]),
        balance_error=float(np.abs(vertical).max() / np.abs(in_plane).max()),
        coverage_peeq=_share(top, threshold) if threshold > 0.0 else math.nan, coverage_peeq_027=_share(top, LITERATURE_THRESHOLD), edge_threshold=threshold,
        nominal_depth_error=float(nominal["depth_mm"] * 1e-3 / dimple.depth_m - 1.0),
        nominal_force_error=float(nominal["peak_force_N"] / dimple.peak_force_N - 1.0),
        history={k: v[1 : count + 1] for k, v in done.items()},
        surface_x_m=surface["x_mm"] * 1e-3, surface_y_m=surface["y_mm"] * 1e-3, surface_z_m=surface["u_z"] * 1e-3,
        patch=patch, side_m=side_m, floor_m=1e-3 * bounds[-1], impacts=count, dofs=int(result["dofs"]), wall_s=float(result["wall_s"]),
        unresolved_impacts=int(faint.sum()),
        unresolved_energy_share=float(patch.energy_J[:count][faint].sum() / patch.energy_J[:count].sum()),
    )  # fmt: skip


def edge_threshold(peeq: np.ndarray, volume: np.ndarray, share: float) -> float:
    """Plastic strain that is exceeded on ``share`` of the layer: after one impact, that at its dimple's edge.

    The same mesh and the same kinematics then judge one impact and many alike.  0 when less than ``share`` yielded.
    """
    order = np.argsort(peeq)[::-1]
    covered = np.cumsum(volume[order]) / volume.sum()
    return float(np.interp(share, covered, peeq[order]))


def _share(table: dict[str, np.ndarray], threshold: float) -> float:
    return float(table["volume_mm3"][table["peeq"] >= threshold].sum() / table["volume_mm3"].sum())


def _check(result: CellResult, workdir: Path) -> None:
    problems = []
    if not abs(result.nominal_depth_error) <= NOMINAL_DEPTH_LIMIT:
        problems.append(
            f"the nominal dimple comes out {result.nominal_depth_error:+.0%} deep against the representative one"
            f" (limit {NOMINAL_DEPTH_LIMIT:.0%})"
        )
    if not result.balance_error <= BALANCE_LIMIT:
        problems.append(
            f"mean vertical stress is {result.balance_error:.1%} of the in-plane one (limit {BALANCE_LIMIT:.0%})"
        )
    mean = np.abs(0.5 * (result.sigma_xx_Pa + result.sigma_yy_Pa))
    if not mean[-1] <= FLOOR_LIMIT * mean.max():
        problems.append(
            f"stress at the cell's floor is {mean[-1] / mean.max():.0%} of the largest (limit {FLOOR_LIMIT:.0%}): the plastic zone"
            " reaches it"
        )
    if problems:
        raise NotConverged("the target cell is not to be trusted", cause="; ".join(problems),
                           log=workdir / "freefem.log", advice="a finer preset (--accuracy reference)")  # fmt: skip
