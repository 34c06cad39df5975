"""What a scene will do before anything is run: regime numbers, choices, cost."""

from __future__ import annotations

import math

from glue.flow.arrivals import check_stream
from glue.flow.regime import collision_number
from glue.scene.consistency import estimated_dimple_radius_m, volume_fraction
from glue.scene.model import Accuracy, Scene
from glue.study.pipeline import choices, default_out

# YADE crosses free flight in one step and takes small ones only around contacts: so many per contact at
# dt = 1 P, each so long on one core with what the logger adds (468 000 steps for 15 900 contacts in 13.6 s).
_STEPS_PER_CONTACT, _STEP_S = 29.0, 29e-6
# The target's cell: seconds per impact, unknown and load step (41 impacts, 14 592 unknowns, 3 steps: 54 s).
_CELL_S = 54.0 / (41 * 14592 * 3)
# A guess of the restitution until a dimple is computed: a rigid 1 mm steel shot on 2024 at 60 m/s.
_RESTITUTION_GUESS = 0.34
_FEW_IMPACTS = 5.0  # below, one impact more or less changes the target's exposure by a fifth and more


def check(scene: Scene) -> dict:
    """Numbers that tell what the scene is like, for printing or as JSON; nothing is run.

    Raises InputError when its stream of shots cannot be drawn.
    """
    check_stream(scene)
    shots, nozzle, target = scene.shots, scene.nozzle, scene.target
    asked = scene.restitution.shot_target
    restitution = _RESTITUTION_GUESS if asked == "from_dimple" else asked
    radius = estimated_dimple_radius_m(shots, nozzle.normal_speed_m_s, target.material)
    per_area = scene.expected_shots / nozzle.footprint_area_m2
    hits = math.pi * radius**2 * per_area
    in_cell = per_area * (scene.accuracy.cell_side_in_radii * radius) ** 2
    return {
        "name": scene.name,
        "run_directory": str(default_out(scene)),
        "expected_shots": scene.expected_shots,
        "expected_impacts_in_window": per_area * target.window_area_m2,
        "expected_impacts_in_cell": in_cell,
        "mass_flow_kg_s": nozzle.mass_flow_kg_s,
        "shot_energy_J": 0.5 * shots.mean_mass_kg * nozzle.speed_m_s**2,
        "solids_fraction_of_jet": volume_fraction(shots, nozzle),
        "restitution_for_estimates": restitution,
        "restitution_source": "guess until the dimple is computed" if asked == "from_dimple" else "the scene",
        "collision_number": collision_number(scene, restitution),
        "dimple_radius_estimate_m": radius,
        "mean_hits_per_point_estimate": hits,
        "coverage_estimate": -math.expm1(-hits),
        "flow_cost_estimate_s": _flow_cost_s(scene, restitution),
        "target_cost_estimate_s": _target_cost_s(scene.accuracy, per_area, radius),
        "warnings": _warnings(in_cell),
        "choices": choices(scene),
        "accuracy": vars(scene.accuracy),
        "defaults_used": list(scene.defaults_used),
    }


def _warnings(in_cell: float) -> list[str]:
    if in_cell >= _FEW_IMPACTS:
        return []
    return [
        f"only {in_cell:.2g} impacts are expected in the target's cell: its stress is that of chance, or null when none"
        " falls into the window; a longer exposure_time_s makes it mean something"
    ]


def _flow_cost_s(scene: Scene, restitution: float) -> float:
    """Wall time [s] of the flow in YADE, to a factor of two: the steps around contacts, at most all steps."""
    shots, dt_over_P = scene.shots, scene.accuracy.flow_dt_over_P
    p_wave_s = 0.5 * shots.diameter_m * math.sqrt(shots.density_kg_m3 / shots.E_Pa)
    contacts = scene.expected_shots * (1.0 + collision_number(scene, restitution)["collisions_per_shot"])
    return _STEP_S / dt_over_P * min(contacts * _STEPS_PER_CONTACT, scene.exposure_time_s / p_wave_s)


def _target_cost_s(accuracy: Accuracy, impacts_per_m2: float, radius_m: float) -> float:
    """Wall time [s] of the target's cell, to a factor of two; P2 elements, one layer more than per side."""
    n = accuracy.cell_elements_per_side
    unknowns = 3 * (2 * n) ** 2 * (2 * (n + 1) + 1)
    impacts = impacts_per_m2 * (accuracy.cell_side_in_radii * radius_m) ** 2
    return _CELL_S * impacts * unknowns * accuracy.cell_load_steps


def check_text(scene: Scene) -> str:
    """The same as :func:`check` for reading."""
    c = check(scene)
    pi = c["collision_number"]
    s, n, t = scene.shots, scene.nozzle, scene.target
    radius_um, hits = c["dimple_radius_estimate_m"] * 1e6, c["mean_hits_per_point_estimate"]
    e, source = c["restitution_for_estimates"], c["restitution_source"]
    lines = [
        f"{scene.name}: {s.diameter_m * 1e3:g} mm {s.medium} at {n.speed_m_s:g} m/s,"
        f" {n.impact_angle_deg:g}° from the surface, on {t.material.name}, {scene.exposure_time_s:g} s",
        "",
        "What it is like",
        f"  shots                      {c['expected_shots']:.0f} expected"
        f" ({scene.shot_rate_1_s:.0f} per second),"
        f" {c['expected_impacts_in_window']:.0f} of them into the window",
        f"  energy of a shot           {c['shot_energy_J'] * 1e3:.3g} mJ",
        f"  share of the jet's volume  {c['solids_fraction_of_jet']:.2g}",
        f"  dimple radius              {radius_um:.0f} µm (estimate, energy over flow stress)",
        f"  coverage                   {c['coverage_estimate']:.4f} (estimate, {hits:.2f} hits per point)",
        f"  collision number           {pi['pi_eff']:.3g}"
        f" ({pi['collisions_per_shot']:.2g} collisions per shot;"
        f" below .01 shots hardly meet), with restitution {e:g} ({source})",
        f"  flow in YADE               about {_duration(c['flow_cost_estimate_s'])} on one core",
        f"  target in FreeFEM          about {_duration(c['target_cost_estimate_s'])} on one core",
        *(f"  warning                    {text}" for text in c["warnings"]),
        "",
        "What will be modelled",
        *(f"  {stage:<11} {choice['model']:<14} {choice['why']}" for stage, choice in c["choices"].items()),
        f"  accuracy    {scene.accuracy.preset:<14} "
        + ", ".join(f"{k} {v:g}" for k, v in c["accuracy"].items() if k != "preset"),
        "",
        "Defaults used" if scene.defaults_used else "No defaults used: the scene says everything",
        *(f"  {line}" for line in scene.defaults_used),
        "",
        f"Run it: peen run SCENE   (into {c['run_directory']})",
    ]
    return "\n".join(lines)


def _duration(seconds: float) -> str:
    return (
        f"{seconds:.0f} s"
        if seconds < 120
        else f"{seconds / 60:.0f} min"
        if seconds < 7200
        else f"{seconds / 3600:.1f} h"
    )
