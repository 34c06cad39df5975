"""The stages: what each reads, computes, writes into the run directory and reports to metrics.json."""

from __future__ import annotations

import numpy as np

from glue.atomic import atomic_path
from glue.study.coverage_stage import coverage_stage, refuse_window
from glue.study.dimple_stage import dimple_stage, refuse_dimple
from glue.study.flow_stage import flow_solvers, flow_stage, refuse_flow
from glue.study.intensity_stage import intensity_solvers, intensity_stage
from glue.study.plausibility import roughness_warnings
from glue.study.results import load_dimple, load_impacts, plain
from glue.study.stage import Stage, Work
from glue.study.target_stage import refuse_target, target_stage
from glue.surface.roughness import areal, profile, random_surface


def surface_stage(work: Work) -> tuple[dict, list[str]]:
    """The peened surface over the whole window by the energy stamp, and its roughness."""
    from glue.surface.stamp import height_map  # here: loads numba

    scene, dimple = work.scene, load_dimple(work.path)
    spacing = dimple.radius_m / scene.accuracy.stamp_points_per_radius
    law = scene.target.material.combined  # the bounded law, as in the target stage: impacts overlap
    rough, initial = scene.target.initial_roughness, None
    if rough is not None:

        def initial(shape, dx, dy):
            return random_surface(shape, dx, dy, *rough, scene.seed)

    x, y, z = height_map(
        load_impacts(work.path, scene), dimple, scene.target.window_m, spacing, flow_stress_Pa=law.flow_stress_Pa,
        initial=initial,
    )  # fmt: skip
    with atomic_path(work.path / "surface.npz") as part, open(part, "wb") as f:
        np.savez_compressed(f, x_m=x, y_m=y, z_m=z)
    step = x[1] - x[0], y[1] - y[0]
    metrics = areal(z, *step) | profile(z, *step)
    measured = scene.measured
    for key in ("Ra_m", "Rz_m"):
        if measured is not None and getattr(measured, key) is not None:
            value = getattr(measured, key)
            metrics |= {f"measured_{key}": value, f"over_measured_{key[:2]}": metrics[key] / value - 1.0}
    if told := roughness_warnings(scene, metrics):
        metrics["warning"] = "; ".join(told)
    return {"roughness": plain(metrics)}, ["surface.npz"]


def report_stage(work: Work) -> tuple[dict, list[str]]:
    """Figures and the page that holds them, of what there is."""
    from glue.report.page import write_report  # here: only this stage needs pyvista and matplotlib

    # A target that nothing struck is complete without a profile to draw.
    profile = (work.path / "stress_profile.csv").exists()
    return {}, write_report(work.path, work.scene, work.complete if profile else work.complete - {"target"})


def uncertainty_stage(work: Work) -> tuple[dict, list[str]]:
    """An interval for every metric of the stages before, and what it is made of."""
    from glue.study.uncertainty.budget import budget  # here: it reads what the others wrote

    return {"uncertainty": budget(work)}, []


_SCENE = ("glue/scene/*.py",)
_WINDOW = ("glue/study/results.py", "glue/flow/arrivals.py", "glue/surface/window.py", "glue/flow/impacts.py")
_STAGES = (
    *(f"glue/study/{name}.py" for name in ("stages", "target_stage", "plausibility", "measured", "unpeened")), *_WINDOW,
)  # fmt: skip
_TABLE = ("glue/target/dimple.py", "glue/target/speeds.py")
_KERNELS = ("freefem/lib/law_script.idp", "freefem/plugin/*")
_AXISYM = ("freefem/single_impact.edp", "freefem/lib/*axisym*.idp")
_TARGET = ("contact.edp", "cell*.edp", "lib/anderson.idp", "lib/contact_lcp.idp", "lib/*_block.idp", "lib/output_[cf]*.idp", "lib/points_small*.idp")
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
            "glue/study/target_outputs.py",
            "glue/study/target_patches.py",
            "glue/target/*.py",
            "glue/theory/plate.py",
            "glue/surface/stress.py",
            "glue/surface/roughness.py",
            "glue/meshes.py",
            *(f"freefem/{name}" for name in _TARGET),
            *_KERNELS,
        ),
        ("target", "stress_profile.csv"),
        target_stage,
        solvers=("freefem",),
        refuse=refuse_target,
    ),
    Stage(
        "surface",
        ("dimple", "flow"),
        (*_SCENE, *_STAGES, "glue/surface/stamp.py", "glue/surface/roughness.py", *_TABLE),
        ("surface.npz",),
        surface_stage,
    ),
    Stage(
        "intensity",
        (),
        (
            *_SCENE,
            *(f"glue/study/{name}.py" for name in ("intensity_stage", "strip_cells", "shot_stream", "dimple_stage")),
            "glue/surface/saturation.py",
            "glue/flow/*.py",
            "glue/target/*.py",
            "glue/theory/*.py",
            "glue/meshes.py",
            *_AXISYM,
            *(f"freefem/{name}" for name in _TARGET),
            *_KERNELS,
        ),
        (),
        intensity_stage,
        solvers=intensity_solvers,
    ),
    Stage(
        "uncertainty",
        (),
        (*_SCENE, "glue/study/uncertainty/*.py", "glue/study/tradeoff/*", "glue/theory/avrami.py", "glue/target/strength.py"),
        (),
        uncertainty_stage,
        uses=("dimple", "flow", "coverage", "target", "surface"),
    ),
    Stage(
        "report",
        (),
        ("glue/report/*.py", "glue/report/static/*", "glue/study/rows.py", "glue/study/pieces.py"),
        ("figures", "report.html"),
        report_stage,
        uses=("dimple", "flow", "coverage", "target", "surface", "intensity", "uncertainty"),
    ),
)
