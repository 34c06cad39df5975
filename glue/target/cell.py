"""The target as a small periodic cell: every logged impact of one patch, one sphere after another, in FreeFEM.

Only exposure matters for an evenly peened surface, so a cell of a few dimple radii stands for the part.  Where
impacts overlap, plain power-law hardening never levels off; the material's bounded combined law is used.
Small strain, vertical frictionless contact; the part is taken as infinitely thick (clamped sideways).  At finite
strain a mesh this coarse tangles where spheres flatten the ridges between dents (measured: after 6-11 impacts at 6-8
elements a side, any bounded law); vertical contact forces on the undeformed surface are within a few per cent of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from glue.errors import NotConverged
from glue.scene.model import Scene
from glue.scene.presets import CELL_DEPTH_IN_RADII, Accuracy
from glue.solvers import run_freefem
from glue.target.cache import finished_key, is_finished, mark_finished
from glue.target.cell_mesh import layer_count, layer_ratio
from glue.target.cell_result import CellResult, check, read_cell
from glue.target.dimple import Dimple
from glue.target.driver import Parameter, kernel_flavour, law_table, write_driver
from glue.target.patch import Patch, choose_patches, contact_radii_m, refuse_outside, refuse_too_long
from glue.target.progress import relay

FINER_STEPS = 3  # a path that does not come out is tried once more with so many times the penetration steps

_GAP_IN_RADII = 4.4e-4
_MEAN_DILATATION = 0.9  # see freefem/plugin/block_forces.hpp
_REACH = 1.9  # of the contact candidates, over the expected contact radius; grows by itself
_MAX_ITERATIONS = 150
_SECONDS = 0.7e-6  # per impact over unknowns^1.5, 2 steps: 0.73 s with 10 thousand, 1.4 with 14.6, 1.8 with 20.4
_SOURCES = ("freefem/cell*.edp", "freefem/lib/*", "freefem/plugin/*")


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
    """As ``solve_cell`` for a patch chosen before.

    resume: a run that ended well in ``workdir`` with the same inputs is read.
    """
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
    driver, log = workdir / "driver.edp", workdir / "freefem.log"
    text = cell_driver(name, law, accuracy, dimple, patch, side_m, counts)
    key = finished_key(text, _SOURCES) if resume else ""
    if not (resume and is_finished(workdir, key)):
        driver.write_text(text)
        run_freefem(driver, cwd=workdir, log=log, status=workdir / "status", on_line=relay(progress))
    results = [read_cell(workdir, accuracy, dimple, patch, side_m, count) for count in counts]
    for result in results:
        check(result, log)
    if resume:
        mark_finished(workdir, key)
    return results


def cell_driver(
    name: str, law: list[float], accuracy: Accuracy, dimple: Dimple, patch: Patch, side_m: float,
    snapshots: Sequence[int] = (),
) -> str:  # fmt: skip
    """Text of the FreeFEM driver of a cell; lengths in mm, energies in mJ, stresses in MPa."""
    layers, radius = layer_count(accuracy), dimple.radius_m * 1e3
    mass = dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3
    parameters = [
        Parameter("string", "outDir", ".", "folder of the results"),
        Parameter("string", "statusFile", "status", "written last"),
        Parameter("real[int]", "law", law, "E nu | A B n | Q b | X1 g1 X2 g2, stresses in MPa"),
        Parameter("real", "side", side_m * 1e3, "mm, period in x and y"),
        Parameter("real", "depth", CELL_DEPTH_IN_RADII * radius, "mm"),
        Parameter("int", "elements", accuracy.cell_elements_per_side, "per side"),
        Parameter("int", "layers", layers, "of elements"),
        Parameter("real", "layerRatio", layer_ratio(layers), "thickness of a layer over that above it"),
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
    slope, reach = dimple.peak_force_N**2 / (2 * energy) / shot, _REACH * radius
    written = [int(n) for n in (snapshots or [len(patch.x_m)])]
    parameters += [
        Parameter("int", "finiteStrain", 0, "a mesh this coarse tangles at finite strain where impacts overlap"),
        Parameter("real", "meanDilatation", _MEAN_DILATATION, "share of the pressure taken as the element's mean"),
        Parameter("real", "zoneFactor", 1e3, "the whole cell is iterated on"),
        Parameter("real", "stepBend", 1.25, "above 1: short steps first"),
        Parameter("int", "releaseSteps", 1, "no restitution"),
        Parameter("int", "andersonDepth", 10, "iterates combined"),
        Parameter("real", "nominalSlope", slope, "N/mm2, expected force over penetration and shot radius"),
        Parameter("real[int]", "nominal", [energy, shot, reach],
                  "the representative impact: mJ, shot radius mm, reach mm"),
        Parameter("int[int]", "snapshots", written, "written after so many impacts"),
    ]  # fmt: skip
    loads.append(_REACH * contact_radii_m(patch, dimple) * 1e3)
    return write_driver(f"Target cell of {name}", parameters, ["cell.edp"], np.column_stack(loads).tolist(),
                        told + ", reach of the candidates mm")  # fmt: skip
