"""The target stage: residual stress under the logged impacts by the model that the scene chose."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.flow.impacts import normal_speed_m_s
from glue.errors import InputError
from glue.scene.measured import beside
from glue.study.dimple_stage import ready_kernels
from glue.study.measured import read_profile
from glue.study.plausibility import stress_warnings
from glue.study.results import load_dimple, load_impacts, plain, write_columns
from glue.study.stage import Work
from glue.study.unpeened import impacts_to_solve, unpeened
from glue.surface.stress import deviation, plate_balance, profile_metrics, xray_weighted_Pa
from glue.target.cell import solve_cell
from glue.target.contact import solve_contact
from glue.target.layers import solve_layers
from glue.target.part import part_profile, strip_arc_height_m
from glue.target.patch import Patch


_NO_STRAIN_COVERAGE = {"peeq_final": None, "peeq_final_reason": "told by the cell model alone"}


class Solved(NamedTuple):
    """What a model hands on: ``profile`` has depth_m, sigma_xx_Pa, … as in CellResult; the rest goes into metrics.json."""

    profile: object
    target: dict
    coverage: dict
    files: list[str]


def target_stage(work: Work) -> tuple[dict, list[str]]:
    """Residual stress under the logged impacts."""
    scene = work.scene
    impacts, dimple = load_impacts(work.path, scene), load_dimple(work.path)
    if not impacts_to_solve(scene, impacts, dimple):
        return unpeened(scene), []
    model = scene.models.target.model
    solved = _MODELS[model](work, impacts, dimple)
    profile = part_profile(solved.profile, scene.target.thickness_m, scene.target.initial_stress, scene.target.material)
    unknown = [name for name in profile if np.isnan(getattr(solved.profile, name)).all()]  # layers know no scatter
    profile = {name: column for name, column in profile.items() if name not in unknown}
    write_columns(work.path / "stress_profile.csv", **profile)
    mean = 0.5 * (profile["sigma_xx_Pa"] + profile["sigma_yy_Pa"])
    stress = profile_metrics(profile["depth_m"], mean)
    balances = ("force_balance_N_m", "force_balance_relative", "moment_balance_relative", "arc_height_m")
    if scene.target.thickness_m is None:
        reason = "a part too thick to stretch or bend: what balances the layer is spread over its whole depth"
        stress |= {key: None for key in balances} | {f"{key}_reason": reason for key in balances}
    else:
        material = scene.target.material
        stress["moment_balance_relative"] = plate_balance(profile["depth_m"], mean)[1]
        stress["arc_height_m"] = strip_arc_height_m(
            solved.profile, scene.target.thickness_m, material.E_Pa, material.nu
        )
    stress |= _beside_measured(work, profile["depth_m"], mean)
    if told := stress_warnings(scene, stress):
        stress["warning"] = "; ".join(told)
    metrics = {"target": {"model": model} | solved.target, "residual_stress": stress, "coverage": solved.coverage}
    return {section: plain(values) for section, values in metrics.items()}, ["stress_profile.csv", *solved.files]


def _beside_measured(work: Work, depth_m: np.ndarray, mean_Pa: np.ndarray) -> dict:
    """The surface stress as X-rays would read it, and how far the profile is from a measured one."""
    measured, found = work.scene.measured, {}
    if measured is None:
        return found
    if measured.xray_depth_m is not None:
        found["surface_xray_Pa"] = xray_weighted_Pa(depth_m, mean_Pa, measured.xray_depth_m)
        found["xray_depth_m"] = measured.xray_depth_m
    if measured.stress_file:
        path = beside(work.scene_file, measured.stress_file)
        if path is None:
            raise InputError(f"measured.stress_file: no file {measured.stress_file} beside {work.scene_file}")
        profile = read_profile(path)
        off = deviation(depth_m, mean_Pa, profile.depth_m, profile.stress_Pa)
        found |= {f"over_measured_{key}": value for key, value in off.items()}
    return found


def _of_patch(patch: Patch) -> dict:
    return {
        "exposure": patch.exposure,
        "window_exposure": patch.window_exposure,
        "neglected_energy_share": patch.neglected_energy_share,
    }


def _cell(work: Work, impacts: np.ndarray, dimple) -> Solved:
    ready_kernels()
    cell = solve_cell(work.scene, impacts, dimple, work.path / "target", work.progress)
    by_strain = {"peeq_final": cell.coverage_peeq}
    if math.isnan(cell.coverage_peeq):
        by_strain = {
            "peeq_final": None,
            "peeq_final_reason": "one impact hardly yields the top layer: no plastic strain marks its dimple's edge",
        }
    target = {
        "impacts": cell.impacts,
        **_of_patch(cell.patch),
        "balance_error": cell.balance_error,
        "nominal_depth_error": cell.nominal_depth_error,
        "nominal_force_error": cell.nominal_force_error,
        "Sa_m": _sa(cell.surface_z_m),
        "dofs": cell.dofs,
        "wall_s": cell.wall_s,
    }
    coverage = {**by_strain, "peeq_threshold": cell.edge_threshold, "peeq_027_final": cell.coverage_peeq_027}
    return Solved(cell, target, coverage, ["target/driver.edp"])


def _contact(work: Work, impacts: np.ndarray, dimple) -> Solved:
    ready_kernels()
    scene = work.scene
    result = solve_contact(
        scene.target.material, impacts, dimple, scene.target.window_m, work.path / "target",
        title=scene.name, progress=work.progress,
    )[-1]  # fmt: skip
    here = restitution_columns(impacts, result)
    write_columns(work.path / "target" / "restitution.csv", **here)
    fresh = here["hits_before"] == 0
    target = {
        "impacts": result.impacts,
        **_of_patch(result.patch),
        "strain": "finite" if result.finite_strain else "small",
        "balance_error": result.balance_error,
        "Sa_m": _sa(result.surface_z_m),
        "restitution_mean": float(here["restitution"].mean()),
        "restitution_flow_mean": float(here["restitution_flow"].mean()),
        "restitution_fresh": float(here["restitution"][fresh].mean()) if fresh.any() else math.nan,
        "restitution_flow_fresh": float(here["restitution_flow"][fresh].mean()) if fresh.any() else math.nan,
        "dofs": result.dofs,
        "wall_s": result.wall_s,
    }
    return Solved(result, target, _NO_STRAIN_COVERAGE, ["target/driver.edp", "target/restitution.csv"])


def restitution_columns(impacts: np.ndarray, result) -> dict[str, np.ndarray]:
    """Impact by impact, (n,) each: the contact model's restitution of the normal speed beside the flow model's.

    hits_before: earlier impacts of the patch nearer than the contact's radius; the flow knows nothing of them unless the
    scene hardens struck spots.
    """
    log, history = impacts[result.patch.index], result.history
    x, y, reach = history["x_mm"], history["y_mm"], history["contact_radius_mm"]
    near = np.hypot(x[:, None] - x, y[:, None] - y) < reach[:, None]
    speed_out = sum(log[f"v{c}_out_m_s"] * log[f"n{c}"] for c in "xyz")
    return {
        "impact_id": log["impact_id"],
        "normal_speed_m_s": normal_speed_m_s(log),
        "restitution": history["restitution"],
        "restitution_flow": speed_out / normal_speed_m_s(log),
        "hits_before": np.tril(near, -1).sum(axis=1),
    }


def _layers(work: Work, impacts: np.ndarray, dimple) -> Solved:
    ready_kernels()
    result = solve_layers(work.scene, impacts, dimple, work.progress)
    target = {"impacts": result.impacts, "exposure": result.exposure, "dofs": None, "wall_s": result.wall_s}
    target["dofs_reason"] = "closed forms fed by one impact's solution"
    if result.warnings:
        target["warning"] = "; ".join(result.warnings)
    return Solved(result, target, _NO_STRAIN_COVERAGE, [])


def _sa(z_m: np.ndarray) -> float:
    """Mean deviation of the nodes' heights from their mean [m]."""
    return float(np.abs(z_m - z_m.mean()).mean())


_MODELS = {"cell": _cell, "contact": _contact, "layers": _layers}
