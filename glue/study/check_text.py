"""``peen check`` for reading: the numbers of ``check.py`` in a reader's units."""

from __future__ import annotations

from pathlib import Path

from glue.scene.model import Scene
from glue.study.check import check
from glue.study.pieces import table_text
from glue.study.tradeoff.choose import preset_block


def check_text(scene: Scene, scene_file: Path | None = None) -> str:
    """The same as :func:`glue.study.check.check`, as a page of text."""
    c, measured = check(scene, scene_file), preset_block(scene)
    lines = [
        f"{scene.name}: {scene.target.material.name}, {_surface(scene)}, {scene.exposure_time_s:g} s",
        "",
        "What it is like",
        *(_row(what, text) for what, text in _facts(scene, c)),
        *(_row("warning", text) for text in c["warnings"]),
        "",
        *(["Inferred from the specification", *(f"  {line}" for line in scene.inferred), ""] if scene.inferred else []),
        "What will be modelled",
        *(f"  {stage:<11} {choice['model']:<14} {choice['why']}" for stage, choice in c["choices"].items()),
        f"  accuracy    {scene.accuracy.preset:<14} "
        + ", ".join(f"{k} {v:g}" for k, v in c["accuracy"].items() if k != "preset" and v),
        "",
        "Optional physics, all of it",
        *table_text(c["pieces"]),
        "",
        *(["What its preset costs and how far off it is, measured", *measured, ""] if measured else []),
        "Defaults used" if scene.defaults_used else "No defaults used: the scene says everything",
        *(f"  {line}" for line in scene.defaults_used),
        "",
        f"Run it: peen run SCENE   (into {c['run_directory']})",
    ]
    return "\n".join(lines)


def _facts(scene: Scene, c: dict):
    """(what, value in words) in reading order."""
    for m in c["media"]:
        share = f", {100 * m['mass_fraction']:.3g} % by mass, {100 * m['number_fraction']:.3g} % by number"
        alone = len(c["media"]) == 1
        yield "shots", f"{m['grade'] or 'own'}: {m['diameter_m'] * 1e3:.3g} mm {m['medium']}{'' if alone else share}"
    for k, n in enumerate(c["nozzles"]):
        feed = f", {n['passes']} pass{'es' if n['passes'] > 1 else ''} at {n['feed_speed_m_s'] * 1e3:g} mm/s" if n["feed_speed_m_s"] else ""
        along, across = (1e3 * side for side in n["footprint_m"])
        yield (
            "nozzle" if len(c["nozzles"]) == 1 else f"nozzle[{k + 1}]",
            f"{n['speed_m_s']:g} m/s, {60 * n['mass_flow_kg_s']:.3g} kg/min, {n['impact_angle_deg']:g}° from the surface,"
            f" footprint {along:.3g} x {across:.3g} mm{feed}",
        )
    yield (
        "shots fed",
        f"{c['expected_shots']:.0f} expected ({scene.shot_rate_1_s:.0f} per second),"
        f" {c['expected_impacts_in_window']:.0f} of them into the window",
    )
    if len(c["expected_impacts_per_pass"]) > 1:
        yield "  in each pass", ", ".join(f"{count:.0f}" for count in c["expected_impacts_per_pass"])
    largest = " (largest dimple's)" if len(c["media"]) * len(c["nozzles"]) > 1 else ""
    yield "energy of a shot", f"{c['shot_energy_J'] * 1e3:.3g} mJ{largest}"
    yield "share of the jet's volume", f"{c['solids_fraction_of_jet']:.2g}"
    radius = f"{c['dimple_radius_estimate_m'] * 1e6:.0f} µm (estimate, energy over flow stress)"
    yield "dimple radius", radius + (", the largest" if largest else "")
    speeds = c["dimple_speeds_m_s"]
    yield "dimples solved", f"{len(speeds)} speeds, {speeds[0]:.3g} to {speeds[-1]:.3g} m/s"
    hits = c["mean_hits_per_point_estimate"]
    yield "coverage", f"{c['coverage_estimate']:.4f} (estimate, {hits:.2f} hits per point)"
    pi, e, source = c["collision_number"], c["restitution_for_estimates"], c["restitution_source"]
    yield (
        "collision number",
        f"Pi {pi['pi']:.3g}, with angle and spread {pi['pi_eff']:.3g}: {pi['collisions_per_shot']:.2g} collisions per"
        f" shot (below .01 shots hardly meet), with restitution {e:g} ({source})",
    )
    yield "third shots in a contact", f"{c['overlap_number']:.2g} of the contacts"
    if scene.gravity is not None:
        yield "gravity number", f"{c['gravity_number']:.2g} of a shot's energy, or its sag over the jet's radius"
    if scene.air_drag is not None:
        yield "drag number", f"{c['drag_number']:.2g} of the speed lost (or gained) on the way"
    errors = ", ".join(f"{model} {error:.2g}" for model, error in c["expected_flow_errors"].items())
    yield "error of a flow model", f"{errors} (accepted: {scene.accuracy.flow_tolerance:g})"
    yield "flow", f"about {_duration(c['flow_cost_estimate_s'])} on one core ({c['choices']['flow']['model']})"
    yield "target in FreeFEM", f"about {_duration(c['target_cost_estimate_s'])} on one core"
    if c["intensity_cost_estimate_s"]:
        yield "intensity confirmed", f"about {_duration(c['intensity_cost_estimate_s'])} on one core, once: cells of strip steel"


def _row(what: str, text: str) -> str:
    return f"  {what:<26} {text}"


def _surface(scene: Scene) -> str:
    surface, (width, height) = scene.target.surface, scene.target.window_m
    shape = {
        "plane": "plane",
        "cylinder": f"cylinder of {1e3 * (surface.radius_m or 0.0):g} mm radius along {surface.axis}",
        "stl": f"surface {surface.file}",
    }[surface.kind]
    return f"{shape}, window {1e3 * width:g} x {1e3 * height:g} mm"


def _duration(seconds: float) -> str:
    return (
        f"{seconds:.0f} s"
        if seconds < 120
        else f"{seconds / 60:.0f} min"
        if seconds < 7200
        else f"{seconds / 3600:.1f} h"
    )
