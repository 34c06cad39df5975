"""The six stages: what each reads, computes, writes into the run directory and reports to metrics.json."""

from __future__ import annotations

import math

import numpy as np

from glue.atomic import atomic_path
from glue.study.coverage_stage import coverage_stage, refuse_window
from glue.study.dimple_stage import dimple_stage, ready_kernels, refuse_dimple
from glue.study.flow_stage import flow_solvers, flow_stage, refuse_flow
from glue.study.results import load_dimple, load_impacts, plain, write_columns
from glue.study.stage import Stage, Work
from glue.study.unpeened import impacts_to_solve, unpeened
from glue.surface.roughness import areal
from glue.surface.stamp import height_map
from glue.surface.stress import profile_metrics
from glue.target.cell import solve_cell
from glue.target.part import part_profile


def target_stage(work: Work) -> tuple[dict, list[str]]:
    """Residual stress under the logged impacts."""
    impacts, dimple = load_impacts(work.path, work.scene), load_dimple(work.path)
    if not impacts_to_solve(work.scene, impacts, dimple):
        return unpeened(work.scene), []
    ready_kernels()
    cell = solve_cell(work.scene, impacts, dimple, work.path / "target", work.progress)
    profile = part_profile(cell, work.scene.target.thickness_m)
    write_columns(work.path / "stress_profile.csv", **profile)
    stress = profile_metrics(profile["depth_m"], 0.5 * (profile["sigma_xx_Pa"] + profile["sigma_yy_Pa"]))
    by_strain = {"peeq_final": cell.coverage_peeq}
    if math.isnan(cell.coverage_peeq):
        by_strain = {
            "peeq_final": None,
            "peeq_final_reason": "one impact hardly yields the top layer: no plastic strain marks its dimple's edge",
        }
    if work.scene.target.thickness_m is None:
        reason = "a part too thick to stretch or bend: what balances the layer is spread over its whole depth"
        stress |= {key: None for key in ("force_balance_N_m", "force_balance_relative")}
        stress |= {f"{key}_reason": reason for key in ("force_balance_N_m", "force_balance_relative")}
    metrics = {
        "target": {
            "model": work.scene.models.target.model,
            "impacts": cell.impacts,
            "exposure": cell.patch.exposure,
            "window_exposure": cell.patch.window_exposure,
            "neglected_energy_share": cell.patch.neglected_energy_share,
            "balance_error": cell.balance_error,
            "nominal_depth_error": cell.nominal_depth_error,
            "nominal_force_error": cell.nominal_force_error,
            "cell_Sa_m": float(np.abs(cell.surface_z_m - cell.surface_z_m.mean()).mean()),
            "dofs": cell.dofs,
            "wall_s": cell.wall_s,
        },
        "residual_stress": stress,
        "coverage": {
            **by_strain,
            "peeq_threshold": cell.edge_threshold,
            "peeq_027_final": cell.coverage_peeq_027,
        },
    }
    return {section: plain(values) for section, values in metrics.items()}, [
        "stress_profile.csv",
        "target/driver.edp",
    ]


def surface_stage(work: Work) -> tuple[dict, list[str]]:
    """The peened surface over the whole window by the energy stamp, and its roughness."""
    scene, dimple = work.scene, load_dimple(work.path)
    spacing = dimple.radius_m / scene.accuracy.stamp_points_per_radius
    law = scene.target.material.combined  # the bounded law, as in the target stage: impacts overlap
    x, y, z = height_map(
        load_impacts(work.path, scene), dimple, scene.target.window_m, spacing, flow_stress_Pa=law.flow_stress_Pa
    )
    with atomic_path(work.path / "surface.npz") as part, open(part, "wb") as f:
        np.savez_compressed(f, x_m=x, y_m=y, z_m=z)
    return {"roughness": plain(areal(z, x[1] - x[0], y[1] - y[0]))}, ["surface.npz"]


def report_stage(work: Work) -> tuple[dict, list[str]]:
    """Figures and the page that holds them, of what there is."""
    from glue.report.page import write_report  # here: only this stage needs pyvista and matplotlib

    # A target that nothing struck is complete without a profile to draw.
    profile = (work.path / "stress_profile.csv").exists()
    return {}, write_report(work.path, work.scene, work.complete if profile else work.complete - {"target"})


_SCENE = ("glue/scene/*.py",)
_WINDOW = ("glue/study/results.py", "glue/surface/window.py", "glue/flow/impacts.py")
_STAGES = ("glue/study/stages.py", "glue/study/unpeened.py", *_WINDOW)
_TABLE = ("glue/target/dimple.py", "glue/target/speeds.py")
_KERNELS = ("freefem/lib/law_script.idp", "freefem/plugin/*")
_AXISYM = ("freefem/single_impact.edp", "freefem/lib/*axisym*.idp")
_CELL = ("cell*.edp", "lib/anderson.idp", "lib/contact_lcp.idp", "lib/*_block.idp", "lib/output_cell*.idp", "lib/points_small*.idp")
STAGES = (
    Stage(
        "dimple",
        (),
        (
            *_SCENE,
            "glue/target/*.py",
            "glue/theory/*.py",
            "glue/meshes.py",
            "glue/study/dimple_stage.py",
            "glue/study/reference.py",
            *_AXISYM,
            *_KERNELS,
        ),
        ("dimple",),
        dimple_stage,
        solvers=("freefem",),
        refuse=refuse_dimple,
    ),
    Stage(
        "flow",
        ("dimple",),
        (
            *_SCENE,
            "glue/flow/*.py",
            "glue/theory/*.py",
            "glue/meshes.py",
            "glue/study/flow_stage.py",
            "glue/study/target_surface.py",
            "yade_scripts/*.py",
        ),
        ("flow",),
        flow_stage,
        solvers=flow_solvers,
        refuse=refuse_flow,
        resumes=True,
    ),
    Stage(
        "coverage",
        ("dimple", "flow"),
        (
            *_SCENE,
            *_WINDOW,
            "glue/study/coverage_stage.py",
            "glue/study/exposure.py",
            *(f"glue/flow/{name}.py" for name in ("footprint", "nozzle_draws", "pulse")),
            "glue/surface/coverage.py",
            *_TABLE,
            "glue/theory/*.py",
        ),
        ("coverage.csv",),
        coverage_stage,
        refuse=refuse_window,
    ),
    Stage(
        "target",
        ("dimple", "flow"),
        (
            *_SCENE,
            *_STAGES,
            "glue/target/*.py",
            "glue/theory/plate.py",
            "glue/surface/stress.py",
            *(f"freefem/{name}" for name in _CELL),
            *_KERNELS,
        ),
        ("target", "stress_profile.csv"),
        target_stage,
        solvers=("freefem",),
    ),
    Stage(
        "surface",
        ("dimple", "flow"),
        (*_SCENE, *_STAGES, "glue/surface/stamp.py", "glue/surface/roughness.py", *_TABLE),
        ("surface.npz",),
        surface_stage,
    ),
    Stage(
        "report",
        (),
        ("glue/report/*.py", "glue/study/rows.py"),
        ("figures", "report.html"),
        report_stage,
        uses=("dimple", "flow", "coverage", "target", "surface"),
    ),
)
