"""What a scene will do before anything is run: regime numbers, choices, cost."""

from __future__ import annotations

from pathlib import Path


from glue.flow.arrivals import check_stream
from glue.flow.drag import drag_number
from glue.flow.footprint import expected_impacts
from glue.flow.regime import (
    choose_flow,
    collision_number,
    expected_errors,
    gravity_number,
    overlap_number,
    resolve_physics,
)
from glue.scene.consistency import estimated_dimple_radius_m, mixture_volume_fraction
from glue.scene.model import Scene
from glue.study.choices import choices
from glue.study.coverage_stage import refuse_window
from glue.study.dimple_stage import impact_speeds, refuse_dimple, scene_physics
from glue.study.exposure import estimated_areas_m2, expected_hits, speed_kept
from glue.study.flow_stage import refuse_flow, restitution_estimate
from glue.study.intensity_stage import seconds as confirmation_s
from glue.study.pieces import pieces
from glue.study.pipeline import default_out
from glue.study.reference import reference_impact
from glue.study.target_stage import expected_work, refuse_target, target_warnings
from glue.target.cell import seconds_per_impact

# YADE, which crosses free flight in one step: seconds per contact at dt = 1 P and to start (24 500 shots with
# 7500 collisions: 14 s).
_CONTACT_S, _START_S = 4e-4, 1.5
# Event-driven: seconds per contact (reference scene: 71 000 events a peening second in .16 s) and to load what was
# compiled; the first run on a machine compiles for some 20 s.
_EVENT_S, _LOAD_S = 5e-6, 1.0
_FEW_IMPACTS = 5.0  # below, one impact more or less changes the target's exposure by a fifth and more


def check(scene: Scene, scene_file: Path | None = None) -> dict:
    """Numbers that tell what the scene is like, for printing or as JSON; nothing is run.

    ``scene_file``: the file it was read from, which an STL surface is found beside.  Raises InputError when its
    stream of shots cannot be drawn, or its surface or window not be used.
    """
    if scene_file is None:
        check_stream(scene)
    else:
        refuse_dimple(scene, scene_file)
        refuse_flow(scene, scene_file)
        refuse_window(scene, scene_file)
        refuse_target(scene, scene_file)
    (nozzle, shots), target = reference_impact(scene), scene.target
    e, source = restitution_estimate(scene)
    physics = resolve_physics(scene)
    impact = scene_physics(scene)
    flow = choose_flow(scene, e)
    hits = expected_hits(scene, estimated_areas_m2(scene))
    exposure = float(hits.hits[-1].mean())
    normal_speed = nozzle.normal_speed_m_s * speed_kept(scene, nozzle, shots)
    radius = estimated_dimple_radius_m(shots, normal_speed, target.material)
    half = [0.5 * side for side in target.window_m]
    in_window = expected_impacts(scene, -half[0], half[0], -half[1], half[1])
    work = expected_work(scene)
    in_cell = work["impacts_in_cell"]
    per_pass = _per_pass(scene, half)
    optional = pieces(scene, e, exposure)
    return {
        "name": scene.name,
        "run_directory": str(default_out(scene)),
        "expected_shots": scene.expected_shots,
        "expected_impacts_in_window": in_window,
        "expected_impacts_per_pass": per_pass,
        "expected_impacts_in_cell": in_cell,
        "mass_flow_kg_s": scene.mass_flow_kg_s,
        "shot_energy_J": 0.5 * shots.mean_mass_kg * nozzle.speed_m_s**2,
        "nozzles": [_nozzle(scene, n) for n in scene.nozzles],
        "media": [_medium(scene, s) for s in scene.media],
        "solids_fraction_of_jet": max(mixture_volume_fraction(scene.media, n) for n in scene.nozzles),
        "restitution_for_estimates": e,
        "restitution_source": source,
        "collision_number": collision_number(scene, e),
        "overlap_number": overlap_number(scene, e),
        "gravity_number": gravity_number(scene),
        "drag_number": 0.0 if scene.air_drag is None else drag_number(scene),
        "expected_flow_errors": expected_errors(scene, e),
        "dimple_radius_estimate_m": radius,
        "mean_hits_per_point_estimate": exposure,
        "coverage_estimate": float(hits.coverage([scene.exposure_time_s])[0]),
        "flow_cost_estimate_s": flow_cost_s(scene, flow.model, e),
        "target_cost_estimate_s": work["seconds"],
        "intensity_cost_estimate_s": confirmation_s(scene, seconds_per_impact(scene.accuracy)),
        "warnings": [*flow.warnings, *_warnings(in_cell, per_pass), *target_warnings(scene, work, exposure)],
        "physics": {block: vars(choice) for block, choice in (physics.choices | impact.choices).items()},
        "pieces": [vars(piece) | {"misfit": piece.misfit} for piece in optional],
        "dimple_speeds_m_s": impact_speeds(scene),
        "choices": choices(scene),
        "accuracy": vars(scene.accuracy),
        "inferred": list(scene.inferred),
        "defaults_used": list(scene.defaults_used),
    }


def mean_hits_estimate(scene: Scene) -> float:
    """Hits per point of the window at the end of the exposure, with dimples of estimated size."""
    return float(expected_hits(scene, estimated_areas_m2(scene)).hits[-1].mean())


def _per_pass(scene: Scene, half: list[float]) -> list[float]:
    """Impacts expected in the window by pass, of all nozzles; one entry where nothing travels."""
    passes = max(1 if n.feed is None else n.feed.passes for n in scene.nozzles)
    return [expected_impacts(scene, -half[0], half[0], -half[1], half[1], pass_id=k) for k in range(passes)]


def _nozzle(scene: Scene, nozzle) -> dict:
    along, across = nozzle.footprint_semi_axes_m
    return {
        "speed_m_s": nozzle.speed_m_s,
        "mass_flow_kg_s": nozzle.mass_flow_kg_s,
        "impact_angle_deg": nozzle.impact_angle_deg,
        "footprint_m": [2.0 * along, 2.0 * across],
        "shots_1_s": nozzle.mass_flow_kg_s * scene.shots_per_kg,
        "passes": 1 if nozzle.feed is None else nozzle.feed.passes,
        "feed_speed_m_s": 0.0 if nozzle.feed is None else nozzle.feed.speed_m_s,
    }


def _medium(scene: Scene, shots) -> dict:
    return {
        "grade": shots.grade,
        "medium": shots.medium,
        "diameter_m": shots.diameter_m,
        "density_kg_m3": shots.density_kg_m3,
        "mass_fraction": shots.mass_fraction,
        "number_fraction": shots.mass_fraction / shots.mean_mass_kg / scene.shots_per_kg,
    }


def _warnings(in_cell: float, per_pass: list[float]) -> list[str]:
    found = []
    idle = [number for number, count in enumerate(per_pass, start=1) if count < 0.01 * max(per_pass)]
    if idle:
        found.append(
            f"pass {', '.join(map(str, idle))} of {len(per_pass)} brings no shot into the window: a smaller pitch_m, fewer"
            " passes, or a window that they reach"
        )
    if in_cell >= _FEW_IMPACTS:
        return found
    return found + [
        f"only {in_cell:.2g} impacts are expected in the target's cell: its stress is that of chance, or null when none"
        " falls into the window; a longer exposure_time_s makes it mean something"
    ]


def flow_cost_s(scene: Scene, model: str, restitution: float) -> float:
    """Wall time [s] of the flow, to a factor of two; contacts of every size take as many steps."""
    contacts = scene.expected_shots * (1.0 + collision_number(scene, restitution)["collisions_per_shot"])
    if model != "dem":
        return _LOAD_S + _EVENT_S * contacts
    steps = scene.accuracy.flow_stiffness_scale**0.1 / scene.accuracy.flow_dt_over_P  # contact s^-2/5 long, step s^-1/2
    return _START_S + _CONTACT_S * steps * contacts
