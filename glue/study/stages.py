"""The six stages: what each reads, computes, writes into the run directory and reports to metrics.json."""

from __future__ import annotations

import math

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError
from glue.flow.arrivals import check_stream
from glue.flow.dem import run_dem
from glue.meshes import write_triangles
from glue.solvers import build_plugin
from glue.study.results import load_dimple, load_impacts, write_columns
from glue.study.stage import Stage, Work
from glue.study.unpeened import impacts_to_solve, unpeened
from glue.surface.coverage import coverage_history, dimple_semi_axes, time_to
from glue.surface.roughness import areal
from glue.surface.stamp import height_map
from glue.surface.stress import profile_metrics
from glue.target.cell import solve_cell
from glue.target.dimple import Dimple, solve_dimple
from glue.target.driver import kernel_flavour
from glue.target.part import part_profile
from glue.theory import avrami

ABSURD_STRAIN = 1.0
FULL_COVERAGE = 0.98  # the level at which the trade calls a surface fully covered
_CURVE_POINTS = 200
_FLOW_LIMIT = 0.94  # YADE's contact law follows the restitution asked for up to here, and again at exactly 1


def dimple_stage(work: Work) -> tuple[dict, list[str]]:
    """One shot at the nominal normal speed into the flat target."""
    ready_kernels()
    nozzle, shots = work.scene.nozzle, work.scene.shots
    dimple = solve_dimple(
        work.scene.target.material,
        speed_m_s=nozzle.normal_speed_m_s,
        density_kg_m3=shots.density_kg_m3,
        diameter_m=shots.diameter_m,
        elements_per_radius=work.scene.accuracy.dimple_elements_per_radius,
        workdir=work.path / "dimple",
        progress=work.progress,
    )
    dimple.save(work.path / "dimple" / "dimple.npz")
    fields = {"peeq": dimple.peeq, "sigma_rr_Pa": dimple.sigma_rr_Pa}
    write_triangles(
        work.path / "dimple" / "dimple.vtu", dimple.points_m, dimple.triangles, fields
    )  # for viewing
    return {"dimple": dimple_metrics(dimple)}, ["dimple/dimple.npz", "dimple/dimple.vtu"]


def ready_kernels() -> None:
    """Compile FreeFEM's kernels when their sources changed, unless the pure-script twins are asked for."""
    if kernel_flavour() == "kernel":
        build_plugin()


def dimple_metrics(dimple: Dimple) -> dict:
    """The section ``dimple`` of metrics.json; with a warning where the model is beyond what it was tried for."""
    keys = (
        "radius_m",
        "depth_m",
        "crest_radius_m",
        "restitution",
        "peak_force_N",
        "contact_time_s",
        "speed_m_s",
        "speed_exponent",
        "edge_peeq",
        "wall_s",
    )
    found = plain({k: getattr(dimple, k) for k in keys})
    if dimple.largest_peeq > ABSURD_STRAIN:
        found["warning"] = (
            f"plastic strain reaches {dimple.largest_peeq:.1f} in one impact: beyond {ABSURD_STRAIN:g} real metal cracks or"
            " melts first, take the results as a trend"
        )
    return found


def flow_stage(work: Work) -> tuple[dict, list[str]]:
    """Every shot's way from the nozzle to the target; writes the impact log."""
    restitution = work.scene.restitution.shot_target
    if restitution == "from_dimple":
        restitution = load_dimple(work.path).restitution
        if not 0.0 < restitution <= _FLOW_LIMIT:
            raise InputError(
                f"restitution.shot_target = from_dimple: the dimple gives {restitution:.3f},"
                f" outside what the flow's contact law can do, (0, {_FLOW_LIMIT}] or exactly 1;"
                " write a number into the scene"
            )
    flow = run_dem(
        work.scene,
        work.scene_file,
        work.path / "flow",
        shot_target_restitution=restitution,
        progress=work.progress,
    )
    keys = ("model", "collision_number", "impacts", "mean_normal_speed_m_s", "collided_fraction", "wall_s")
    return {"flow": plain({k: flow.info[k] for k in keys})}, ["flow/arrivals.csv", "flow/impacts.csv"]


def coverage_stage(work: Work) -> tuple[dict, list[str]]:
    """Coverage against time by the count of sample points, beside Avrami's."""
    scene, dimple, impacts = work.scene, load_dimple(work.path), load_impacts(work.path)
    window = scene.target.window_m
    major, minor, azimuth = dimple_semi_axes(dimple, impacts)
    spacing = dimple.radius_m / scene.accuracy.coverage_points_per_radius
    history = coverage_history(
        impacts["x_m"], impacts["y_m"], impacts["time_s"], major, minor, azimuth, window, spacing
    )

    inside = (abs(impacts["x_m"]) <= 0.5 * window[0]) & (abs(impacts["y_m"]) <= 0.5 * window[1])
    count = int(inside.sum())
    radius2 = float(np.mean((major * minor)[inside])) if count else math.nan
    rate = count / (scene.target.window_area_m2 * scene.exposure_time_s)
    # The last shots land after the nozzle has closed, so that the curve ends with them.
    end = max(scene.exposure_time_s, float(history.time_s[-1]) if history.time_s.size else 0.0)
    time_98 = time_to(history.time_s, history.coverage, FULL_COVERAGE)
    times = np.union1d(np.linspace(0.0, end, _CURVE_POINTS + 1), [] if time_98 is None else [time_98])
    # Avrami speaks of exposure: it stops rising when the nozzle closes.
    exposed = np.minimum(times, scene.exposure_time_s)
    counted = avrami.coverage_rate_form(radius2, rate, exposed) if count else np.zeros_like(times)
    write_columns(work.path / "coverage.csv", time_s=times, coverage=history.at(times), avrami=counted)

    final = float(history.coverage[-1]) if history.coverage.size else 0.0
    metrics = {"final": final, "time_98_s": time_98}
    if time_98 is None:
        metrics["time_98_s_reason"] = (
            f"coverage reaches {final:.4f} in {scene.exposure_time_s:g} s; a longer exposure_time_s is needed"
        )
    if count:
        metrics["avrami_final"] = float(counted[-1])
        metrics["avrami_time_98_s"] = avrami.time_to_coverage(FULL_COVERAGE, radius2, rate)
        metrics["avrami_mass_flow_final"] = float(
            avrami.mass_flow_form(
                radius2,
                scene.nozzle.mass_flow_kg_s,
                scene.nozzle.footprint_area_m2,
                _mean_cubed_radius(scene.shots),
                scene.shots.density_kg_m3,
                scene.exposure_time_s,
            )
        )
    else:
        nothing = "no impact inside the window"
        for key in ("avrami_final", "avrami_time_98_s", "avrami_mass_flow_final"):
            metrics |= {key: None, f"{key}_reason": nothing}
    metrics |= {
        "impacts_in_window": count,
        "peeq_final": None,
        "peeq_final_reason": "the target stage was not run",
    }
    return {"coverage": plain(metrics)}, ["coverage.csv"]


def target_stage(work: Work) -> tuple[dict, list[str]]:
    """Residual stress under the logged impacts."""
    impacts, dimple = load_impacts(work.path), load_dimple(work.path)
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
        load_impacts(work.path), dimple, scene.target.window_m, spacing, flow_stress_Pa=law.flow_stress_Pa
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


def plain(values: dict) -> dict:
    """``values`` for JSON: Python numbers, and null with a reason for what is not finite."""
    result = {}
    for key, value in values.items():
        value = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, float) and not math.isfinite(value):
            result |= {key: None, f"{key}_reason": f"came out as {value}"}
        else:
            result[key] = value
    return result


def _mean_cubed_radius(shots) -> float:
    """Mean of the cubed shot radius [m^3], from the mean mass."""
    return shots.mean_mass_kg / (shots.density_kg_m3 * 4.0 / 3.0 * math.pi)


_SCENE = ("glue/scene/*.py",)
_STAGES = ("glue/study/stages.py", "glue/study/unpeened.py")
_KERNELS = ("freefem/lib/law_script.idp", "freefem/plugin/*")
_AXISYM = ("freefem/single_impact.edp", "freefem/lib/*axisym*.idp")
_CELL = ("cell.edp", "lib/anderson.idp", "lib/contact_lcp.idp", "lib/output_cell.idp", "lib/points_small*.idp")
STAGES = (
    Stage(
        "dimple",
        (),
        (
            *_SCENE,
            "glue/target/*.py",
            "glue/theory/*.py",
            "glue/meshes.py",
            *_AXISYM,
            *_KERNELS,
        ),
        ("dimple",),
        dimple_stage,
        solvers=("freefem",),
    ),
    Stage(
        "flow",
        ("dimple",),
        (*_SCENE, "glue/flow/*.py", "glue/theory/*.py", "yade_scripts/*.py"),
        ("flow",),
        flow_stage,
        solvers=("yade",),
        refuse=check_stream,
    ),
    Stage(
        "coverage",
        ("dimple", "flow"),
        (*_SCENE, *_STAGES, "glue/surface/coverage.py", "glue/target/dimple.py", "glue/theory/*.py"),
        ("coverage.csv",),
        coverage_stage,
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
        (*_SCENE, *_STAGES, "glue/surface/stamp.py", "glue/surface/roughness.py", "glue/target/dimple.py"),
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
