"""The target stage: residual stress under the logged impacts by the model that the scene chose."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow.footprint import expected_impacts
from glue.flow.impacts import normal_speed_m_s
from glue.scene.consistency import estimated_dimple_radius_m
from glue.scene.measured import beside
from glue.scene.model import Scene
from glue.study.dimple_stage import ready_kernels
from glue.study.measured import read_profile
from glue.study.plausibility import stress_warnings
from glue.study.reference import reference_impact
from glue.study.results import load_dimple, load_impacts, plain, write_columns
from glue.study.stage import Work
from glue.study.target_patches import mean_profile, means, solve_patches
from glue.study.unpeened import impacts_to_solve, unpeened
from glue.surface.stress import deviation, plate_balance, profile_metrics, xray_weighted_Pa
from glue.target.between import layer_shape_between
from glue.target.block import available_GB, make_block
from glue.target.cell import cell_patches, seconds_per_impact, solve_patch
from glue.target.contact import (
    FINITE_STRAIN_EXPOSURE,
    MEMORY_LIMIT_GB,
    SECONDS_PER_IMPACT,
    ContactNumerics,
    patch_side_m,
    solve_contact,
)
from glue.target.layers import CALIBRATED, solve_layers
from glue.target.part import part_profile, strip_arc_height_m
from glue.target.patch import choose_patches, refuse_too_long

_GUESS = 2.0  # factor by which the impacts expected before a run and their time may be off
_LAYERS_S = 3.0  # of the one impact that the layers take beside the dimple's
_LONG_S = 3600.0
_NO_STRAIN_COVERAGE = {"peeq_final": None, "peeq_final_reason": "told by the cell model alone"}


class Solved(NamedTuple):
    """What a model hands on: ``profiles``, one a patch, have depth_m, sigma_xx_Pa, … as CellResult; the rest goes into metrics.json."""

    profiles: list
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
    thickness, material = scene.target.thickness_m, scene.target.material
    initial = scene.target.initial_stress
    profile, scatter = mean_profile([part_profile(each, thickness, initial, material) for each in solved.profiles])
    write_columns(work.path / "stress_profile.csv", **profile)
    mean = 0.5 * (profile["sigma_xx_Pa"] + profile["sigma_yy_Pa"])
    stress = profile_metrics(profile["depth_m"], mean) | scatter
    balances = ("force_balance_N_m", "force_balance_relative", "moment_balance_relative", "arc_height_m")
    if thickness is None:
        reason = "a part too thick to stretch or bend: what balances the layer is spread over its whole depth"
        stress |= {key: None for key in balances} | {f"{key}_reason": reason for key in balances}
    else:
        stress["moment_balance_relative"] = plate_balance(profile["depth_m"], mean)[1]
        arcs = [strip_arc_height_m(each, thickness, material.E_Pa, material.nu) for each in solved.profiles]
        stress["arc_height_m"] = float(np.mean(arcs))
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


def expected_work(scene: Scene) -> dict:
    """What the target stage will have to do, before there is a dimple or a log: to a factor of two.

    impacts_in_cell: in the square of a cell, whatever the model; impacts: in one patch of the model; seconds: of all
    patches; memory_GB: of a block, else None.
    """
    (nozzle, shots), (width, height) = reference_impact(scene), scene.target.window_m
    radius = estimated_dimple_radius_m(shots, nozzle.normal_speed_m_s, scene.target.material)
    per_area = expected_impacts(scene, -0.5 * width, 0.5 * width, -0.5 * height, 0.5 * height) / (width * height)
    in_cell = per_area * (scene.accuracy.cell_side_in_radii * radius) ** 2
    found = {"impacts_in_cell": in_cell, "impacts": in_cell, "memory_GB": None}
    if scene.models.target.model == "layers":
        return found | {"seconds_each": 0.0, "seconds": _LAYERS_S}
    each = seconds_per_impact(scene.accuracy)
    if scene.models.target.model == "contact":
        numerics, each = ContactNumerics(), SECONDS_PER_IMPACT
        side = min(numerics.side_in_radii * radius, width, height)
        found["impacts"] = per_area * side**2
        found["memory_GB"] = make_block(1e3 * radius, 1e3 * side, numerics.elements_per_radius).memory_GB
    return found | {"seconds_each": each, "seconds": each * found["impacts"] * scene.accuracy.target_patches}


def refuse_target(scene: Scene, scene_file: Path) -> None:
    """Raise InputError for more impacts or memory than the target model can take, before dimple and flow have cost anything."""
    found = expected_work(scene)
    refuse_too_long(int(found["impacts"]), found["seconds_each"] / _GUESS, f"target = {scene.models.target.model}")
    if found["memory_GB"] is not None:
        limit = min(MEMORY_LIMIT_GB, available_GB())
        if found["memory_GB"] > limit:
            raise InputError(
                f"target = contact: the block needs about {found['memory_GB']:.1f} GB; allowed: {limit:.1f} GB, of what the machine"
                ' has free. target = "cell" needs a tenth of it'
            )


def target_warnings(scene: Scene, expected: dict, exposure: float) -> list[str]:
    """Sentences for ``peen check``; expected: as from ``expected_work``; exposure: expected hits per point."""
    told, model, patches = [], scene.models.target.model, scene.accuracy.target_patches
    if expected["seconds"] > _LONG_S:
        told.append(
            f"target = {model}: some {expected['impacts'] * patches:.0f} impacts will take about {expected['seconds'] / 3600:.1f} h; "
            'a shorter exposure_time_s, fewer target_patches or target = "layers" is faster'
        )
    span = CALIBRATED["exposure"]
    if model == "layers" and not span.low <= exposure <= span.high:
        refused = "" if span.least <= exposure <= span.most else f" and refused beyond {span.most:g}"
        told.append(
            f"target = layers: about {exposure:.3g} hits per point are expected, calibrated {span.low:g} to {span.high:g}{refused}; "
            'target = "cell" has no such limit'
        )
    if model == "layers" and patches > 1:
        told.append("accuracy.target_patches has no effect with target = layers, which takes the whole window")
    return told


def _cell(work: Work, impacts: np.ndarray, dimple) -> Solved:
    ready_kernels()
    scene, many = work.scene, work.scene.accuracy.target_patches > 1
    patches = cell_patches(scene, impacts, dimple, scene.accuracy.target_patches)

    def solve(patch, folder, progress):
        return solve_patch(scene, dimple, patch, folder, progress, resume=many)

    cells, target, files = solve_patches(work, patches, solve)
    target |= means(cells, "nominal_depth_error", "nominal_force_error")
    by_strain = [c.coverage_peeq for c in cells]
    coverage = {"peeq_final": float(np.mean(by_strain))}
    if any(map(math.isnan, by_strain)):
        coverage = {
            "peeq_final": None,
            "peeq_final_reason": "one impact hardly yields the top layer: no plastic strain marks its dimple's edge",
        }
    coverage |= {"peeq_threshold": cells[0].edge_threshold, "peeq_027_final": float(np.mean([c.coverage_peeq_027 for c in cells]))}
    return Solved(cells, target, coverage, files)


def _contact(work: Work, impacts: np.ndarray, dimple) -> Solved:
    ready_kernels()
    scene, many = work.scene, work.scene.accuracy.target_patches > 1
    window = scene.target.window_m
    side = patch_side_m(dimple, window, ContactNumerics())
    patches = choose_patches(impacts, dimple, window, side, scene.accuracy.target_patches)
    # One kind of strain for all, or their mean and scatter would be of two models.
    finite = max(patch.exposure for patch in patches) <= FINITE_STRAIN_EXPOSURE
    numerics = replace(ContactNumerics(), finite_strain=finite)

    def solve(patch, folder, progress):
        result = solve_contact(
            scene.target.material, impacts, dimple, window, folder,
            patch=patch, numerics=numerics, resume=many, title=scene.name, progress=progress,
        )[-1]  # fmt: skip
        write_columns(folder / "restitution.csv", **restitution_columns(impacts, result))
        return result

    results, target, files = solve_patches(work, patches, solve)
    here = [restitution_columns(impacts, result) for result in results]
    here = {name: np.concatenate([each[name] for each in here]) for name in here[0]}
    fresh = here["hits_before"] == 0
    target |= {
        "strain": "finite" if results[0].finite_strain else "small",
        "restitution_mean": float(here["restitution"].mean()),
        "restitution_flow_mean": float(here["restitution_flow"].mean()),
        "restitution_fresh": float(here["restitution"][fresh].mean()) if fresh.any() else math.nan,
        "restitution_flow_fresh": float(here["restitution_flow"][fresh].mean()) if fresh.any() else math.nan,
    }
    files += [f.replace("driver.edp", "restitution.csv") for f in files if f.endswith("driver.edp")]
    return Solved(results, target, _NO_STRAIN_COVERAGE, files)


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
    accuracy, shape = work.scene.accuracy, None
    if accuracy.dimple_speed_ratio:
        shape = layer_shape_between(
            work.scene.target.material, dimple, elements_per_radius=accuracy.dimple_elements_per_radius,
            ratio=accuracy.dimple_speed_ratio, progress=work.progress,
        )  # fmt: skip
    result = solve_layers(work.scene, impacts, dimple, work.progress, shape)
    target = {"impacts": result.impacts, "exposure": result.exposure, "dofs": None, "wall_s": result.wall_s}
    target["dofs_reason"] = "closed forms fed by one impact's solution"
    if result.warnings:
        target["warning"] = "; ".join(result.warnings)
    return Solved([result], target, _NO_STRAIN_COVERAGE, [])


_MODELS = {"cell": _cell, "contact": _contact, "layers": _layers}
