"""The target as a block: every logged impact of one patch in turn, real spheres, in FreeFEM.

The most exact of the target models: runs ``freefem/contact.edp``.  The impacts of a square patch of the window, its
margin included, strike the middle of a large block; stresses and heights are taken over the inner square, where no
impact that matters is missing.  Where impacts overlap, plain power-law hardening never levels off, so the material's
bounded combined law is used, its backstresses turned with the material.

Finite strain up to an exposure of FINITE_STRAIN_EXPOSURE.  Beyond, spheres flatten the ridges between dents again and
again, and with a bounded law the elements there shear until they turn inside out.  The mesh lets go of the material
before they do (``freefem/plugin/block_rezone.hpp``), but needs to after ever fewer steps, and three times the
iterations; so many impacts are solved at small strain, their forces vertical on the undeformed surface.  ``make
bench-target`` prints what that changes where both can be solved.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook, Material
from glue.solvers import run_freefem, versions
from glue.target.block import Block, available_GB, make_block, refuse_too_large
from glue.target.cache import cache_root, content_key, finished_key, is_finished, mark_finished
from glue.target.contact_result import ContactResult, check, read_contact
from glue.target.dimple import Dimple
from glue.target.driver import LAW_COMMENT, Parameter, law_table, write_driver
from glue.target.patch import Patch, choose_patch, contact_radii_m, refuse_outside, refuse_too_long
from glue.target.progress import relay

MEMORY_LIMIT_GB = 3.0
SECONDS_PER_IMPACT = 14.0  # 10 at small strain, 17 at finite (make bench-target)
# Dimple areas over the patch's, up to which the block is solved at finite strain unless told.  Runs of 11 and 12
# impacts on 1.56 mm2 (1.2) went well, one stopped after 12 of 15 (1.25): make bench-target.
FINITE_STRAIN_EXPOSURE = 1.0

_RUN_SOURCES = ("freefem/contact.edp", "freefem/lib/*", "freefem/plugin/*")
_SOURCES = (*(f"freefem/lib/{name}_block.idp" for name in ("mesh", "solid", "contact")), "freefem/plugin/*")


@dataclass(frozen=True)
class ContactNumerics:
    """Numbers of the solution; the comments tell what was measured on the reference impact."""

    side_in_radii: float = 5.5  # of the patch whose impacts are solved
    margin_in_radii: float = 1.5  # of the patch, outside of the square over which results are taken
    elements_per_radius: float = 3.24  # spacing of the top's grid .07 mm there; 2.84: stress 15 % high in the top 15 um
    load_steps: int = 12  # 10: stress 17 % high in the top 15 um, 8 elsewhere; 5: 26 %
    step_bend: float = 1.25  # 1: equal steps; short first steps serve the top 30 um
    release_steps: int = 3  # 1: no restitution, the same stress
    mean_dilatation: float = 0.9  # see freefem/plugin/block_forces.hpp
    force_tolerance: float = 5e-3  # 1e-2: peak force another 1 % low
    gap_in_radii: float = 2.2e-4
    candidates_in_radii: float = 1.9
    zone_over_candidates: float = 1.5  # reach of the zone whose steps are nonlinear before the whole block is looked at
    anderson_depth: int = 10
    max_iterations: int = 100
    finite_strain: bool | None = None  # False: small, vertical forces on the undeformed surface; None: by the exposure
    rezone_below: float = 0.6  # det F at an element's vertex
    rezone_depth_in_radii: float = 3.0  # down to which a rezoned mesh follows the surface


def patch_side_m(dimple: Dimple, window_m: tuple[float, float], numerics: ContactNumerics) -> float:
    """Side [m] of the patch whose impacts are solved, shrunk to the window.

    Raises InputError where nothing is left to measure.
    """
    side = min(numerics.side_in_radii * dimple.radius_m, *window_m)
    least = (2 * numerics.margin_in_radii + 1.0) * dimple.radius_m
    if side <= least:
        raise InputError(
            f"target.window_m: a patch of {side:.3g} m leaves no square inside its margins of "
            f"{numerics.margin_in_radii:g} dimple radii ({dimple.radius_m:.3g} m) to measure; allowed: windows above "
            f"{least:.3g} m"
        )
    return side


def solve_contact(
    material: Material,
    impacts: np.ndarray,
    dimple: Dimple,
    window_m: tuple[float, float],
    workdir: Path,
    *,
    law: JohnsonCook | CombinedHardening | HardeningTable | None = None,
    snapshots: Sequence[int] = (),
    numerics: ContactNumerics = ContactNumerics(),  # noqa: B008 - frozen
    memory_limit_GB: float = MEMORY_LIMIT_GB,
    patch: Patch | None = None,
    resume: bool = False,
    title: str = "",
    progress: Callable[[float, str], None] | None = None,
) -> list[ContactResult]:
    """Residual stress and surface under the logged ``impacts`` of one patch of the window (shrunk to the window), after
    each of ``snapshots`` impacts (rising; those beyond the patch's impacts are left out) and after all of them.

    law: the material's combined one when None.  patch: one of side ``patch_side_m`` chosen before.  resume: tables
    that a run of the same inputs finished in ``workdir`` are read, nothing is run.  Writes driver, log, tables and a
    checkpoint into ``workdir``; a run that was stopped goes on after its last whole impact when called again with the
    same inputs.  Raises InputError (window or memory too small, no impact, one outside the patch, too many),
    SolverFailed, NotConverged.
    """
    side = patch_side_m(dimple, window_m, numerics)
    patch = choose_patch(impacts, dimple, window_m, side) if patch is None else patch
    refuse_outside(patch, side)
    refuse_too_long(len(patch.x_m), SECONDS_PER_IMPACT, "target = contact")
    radius = dimple.radius_m * 1e3
    block = make_block(radius, side * 1e3, numerics.elements_per_radius)
    if numerics.finite_strain is None:
        numerics = replace(numerics, finite_strain=patch.exposure <= FINITE_STRAIN_EXPOSURE)
    refuse_too_large(radius, block, numerics.elements_per_radius, min(memory_limit_GB, available_GB()))
    table = law_table(material.E_Pa, material.nu, material.combined if law is None else law)
    reach = numerics.candidates_in_radii * contact_radii_m(patch, dimple)
    counts = sorted({k for k in snapshots if 0 < k < len(patch.x_m)} | {len(patch.x_m)})
    text = contact_driver(title or material.key, table, numerics, dimple, block, patch, reach, counts)
    workdir.mkdir(parents=True, exist_ok=True)
    driver = workdir / "driver.edp"
    key = finished_key(text, _RUN_SOURCES) if resume else ""

    def read(count: int) -> ContactResult:
        return read_contact(workdir, block, dimple, patch, numerics.margin_in_radii, numerics.finite_strain, count)

    if resume and is_finished(workdir, key):
        return [read(count) for count in counts]
    shared, own = _shared_compliance(block, numerics, table[1]), workdir / "compliance.bin"
    if not driver.exists() or driver.read_text() != text:
        for left in (workdir / "checkpoint", own):  # of other inputs
            left.unlink(missing_ok=True)
        driver.write_text(text)
    if shared.exists() and not own.exists():
        shutil.copyfile(shared, own)
    run_freefem(driver, cwd=workdir, log=workdir / "freefem.log", status=workdir / "status", on_line=relay(progress))
    if not shared.exists():
        with atomic_path(shared) as part:
            shutil.copyfile(own, part)
    own.unlink()
    results = [read(count) for count in counts]
    for result in results:
        check(result, workdir / "freefem.log")
    (workdir / "checkpoint").unlink(missing_ok=True)
    if resume:
        mark_finished(workdir, key)
    return results


def _shared_compliance(block: Block, numerics: ContactNumerics, nu: float) -> Path:
    """Where the cache keeps the compliance of the block's contact nodes, times modulus and spacing: the same for every
    modulus and size."""
    inputs = {"columns": (block.columns / block.spacing).round(9).tolist(), "coarser": block.coarser.tolist(),
              "thickness": (block.thickness / block.spacing).round(9).tolist(), "finite_strain": numerics.finite_strain,
              "contact_half": round(block.contact_half / block.spacing, 9), "mean_dilatation": numerics.mean_dilatation,
              "nu": nu, "freefem": versions()["freefem"]["package"]}  # fmt: skip
    return cache_root() / "contact" / f"{content_key(inputs, _SOURCES)}.bin"


def contact_driver(
    name: str, law: list[float], numerics: ContactNumerics, dimple: Dimple, block: Block, patch: Patch,
    reach_m: np.ndarray, snapshots: Sequence[int] = (),
) -> str:  # fmt: skip
    """Text of the FreeFEM driver; lengths in mm, energies in mJ, stresses in MPa; the patch's middle is the origin."""
    n, half, radius = numerics, 0.5 * block.side, dimple.radius_m * 1e3
    box = [-block.contact_half, block.contact_half] * 2
    mass = dimple.density_kg_m3 * np.pi / 6.0 * dimple.diameter_m**3
    slope = dimple.peak_force_N**2 / (mass * dimple.speed_m_s**2 * 1e3) / (0.5e3 * dimple.diameter_m)
    strips = max(1, round(block.contact_half / block.spacing))
    written = [int(k) for k in snapshots] or [len(patch.x_m)]
    parameters = [
        Parameter("string", "outDir", ".", "folder of the results"),
        Parameter("string", "statusFile", "status", "written last"),
        Parameter("string", "checkpointFile", "checkpoint", "the state after the last impact; empty: none"),
        Parameter("string", "complianceFile", "compliance.bin",
                  "of the contact nodes, made when missing; empty: not kept"),
        Parameter("real[int]", "law", law, LAW_COMMENT),
        Parameter("real[int]", "columnX", block.columns.tolist(), "mm, grid lines of the top"),
        Parameter("real[int]", "columnY", block.columns.tolist(), "mm"),
        Parameter("real[int]", "layerThickness", block.thickness.tolist(), "mm, from the top"),
        Parameter("int[int]", "layerKind", block.coarser.tolist(), "1: below, the grid is twice as coarse"),
        Parameter("real[int]", "contactBox", box, "mm, x and y of the nodes that may be touched"),
        Parameter("real", "contactRim", block.spacing, "mm, nearer to the box's edge no contact is believed"),
        Parameter("int", "contactStrips", strips, "of the compliance's columns"),
        Parameter("int", "finiteStrain", int(n.finite_strain), "0: small, vertical forces on the undeformed surface"),
        Parameter("real", "rezoneBelow", n.rezone_below, "smallest det F: the mesh lets go of the material below it"),
        Parameter("real", "rezoneDepth", n.rezone_depth_in_radii * radius,
                  "mm, down to which a rezoned mesh follows the surface"),
        Parameter("real", "meanDilatation", n.mean_dilatation, "share of the pressure taken as the element's mean"),
        Parameter("real", "zoneFactor", n.zone_over_candidates,
                  "of the reach: where an impact's steps look for yielding first"),
        Parameter("int", "loadSteps", n.load_steps, "penetration steps per impact"),
        Parameter("real", "stepBend", n.step_bend, "above 1: short steps first"),
        Parameter("int", "releaseSteps", n.release_steps, "1: no restitution"),
        Parameter("int", "andersonDepth", n.anderson_depth, "iterates combined"),
        Parameter("real", "forceTolerance", n.force_tolerance, "out-of-balance over contact force"),
        Parameter("real", "gapTolerance", n.gap_in_radii * dimple.radius_m * 1e3, "mm"),
        Parameter("int", "maxIterations", n.max_iterations, "per step"),
        Parameter("int[int]", "snapshots", written, "written after so many impacts"),
        Parameter("real", "slopeOverRadius", float(slope), "N/mm2, expected force over penetration and shot radius"),
    ]  # fmt: skip
    loads = np.column_stack([patch.x_m * 1e3 - half, patch.y_m * 1e3 - half, patch.energy_J * 1e3, patch.radius_m * 1e3,
                             reach_m * 1e3])  # fmt: skip
    told = "impacts in order of time: x mm, y mm, normal kinetic energy mJ, shot radius mm, reach of the candidates mm"
    return write_driver(f"Contact model of {name}", parameters, ["contact.edp"], loads.tolist(), told)
