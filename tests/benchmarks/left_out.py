"""What a scene leaves out by its number costs nothing and would change nothing: PASS or FAIL rows (make thresholds).

    python tests/benchmarks/left_out.py [--json FILE]

In every shipped example each optional block says "auto".  For each that is then off: the run is that of a scene without
the block, to the byte of its FreeFEM driver or impact log; forced on it changes no metric by more than the tolerance.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Iterator

import numpy as np

from glue.checkrows import Rows
from glue.flow.arrivals import draw_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.event_driven import run_event
from glue.flow.impacts import normal_speed_m_s
from glue.flow.regime import choose_flow, resolve_physics
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import from_scene
from glue.scene.effects import AirDrag, Gravity, StrainRate, Switch
from glue.scene.model import Choice, Scene
from glue.scene.reader import EXAMPLES, read_scene
from glue.study.reference import reference_impact
from glue.target import regime
from glue.target.dimple import zero_height_radius
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import ReducedImpact, solve_reduced

PRESET, SHOTS, E = "fast", 20_000, 0.4
AUTO = {"gravity": Gravity(9.81, auto=True), "air_drag": AirDrag(1.204, 1.81e-5, auto=True), "strain_rate": StrainRate(auto=True),
        "target_inertia": Switch(auto=True), "elastic_shot": Switch(auto=True)}  # fmt: skip


def all_auto(scene: Scene, **changes) -> Scene:
    """Every optional block "auto"; a stream of at most SHOTS."""
    few = min(scene.exposure_time_s, SHOTS / scene.shot_rate_1_s)
    if all(nozzle.feed is None for nozzle in scene.nozzles):
        scene = dataclasses.replace(scene, exposure_time_s=few)
    asked = Choice("auto", "left_out")
    return dataclasses.replace(scene, models=dataclasses.replace(scene.models, flow=asked), **(AUTO | changes))


def scenes() -> Iterator[tuple[str, Scene]]:
    """The examples, the default one with so few shots that they hardly meet, and one so slow that waves carry nothing off."""
    for path in sorted(EXAMPLES.glob("*.toml")):
        yield path.stem, read_scene(path, preset=PRESET)
    thin = read_scene(EXAMPLES / "al2024-s390.toml", preset=PRESET)
    nozzle = dataclasses.replace(thin.nozzle, mass_flow_kg_s=5e-4)
    yield "al2024-s390 at .03 kg/min", dataclasses.replace(thin, nozzles=(nozzle,), exposure_time_s=100.0)
    yield "al2024-s390 at 1.5 m/s", dataclasses.replace(thin, nozzles=(dataclasses.replace(nozzle, speed_m_s=1.5),), exposure_time_s=100.0)


def fly(scene: Scene, model: str) -> np.ndarray:
    run = run_ballistic if model == "ballistic" else run_event
    return run(scene, draw_arrivals(scene), RestitutionLaw(E), from_scene(scene))[0]


def stream_metrics(scene: Scene, impacts: np.ndarray) -> dict[str, float]:
    """What coverage and the target take from the stream: the energy brought, in all and each, and how many come."""
    energy = normal_speed_m_s(impacts) ** 2
    return {"mean normal energy": float(energy.mean()), "impacts": float(len(impacts)), "energy in all": float(energy.sum())}


def stream_rows(rows: Rows, name: str, scene: Scene) -> None:
    model = choose_flow(scene, E).model
    decided = resolve_physics(scene)
    tolerance = scene.accuracy.flow_tolerance
    base = fly(decided.scene, model)
    for block, choice in decided.choices.items():
        if choice.model == "on":
            continue
        without = resolve_physics(dataclasses.replace(scene, **{block: None})).scene
        rows.true(f"{name}: {block} left out: the log of a scene without it, to the byte", fly(without, model).tobytes() == base.tobytes())
        forced = fly(dataclasses.replace(decided.scene, **{block: dataclasses.replace(AUTO[block], auto=False)}), model)
        worst(rows, f"{name}: {block} forced on", stream_metrics(scene, forced), stream_metrics(scene, base), tolerance, choice.why)
    if model == "ballistic":
        worst(rows, f"{name}: shot-shot collisions forced on", stream_metrics(scene, fly(decided.scene, "event")),
              stream_metrics(scene, base), tolerance, choose_flow(scene, E).why)  # fmt: skip


def solve(scene: Scene, physics: ImpactPhysics) -> ReducedImpact:
    nozzle, shots = reference_impact(scene)
    target = scene.target.material
    return solve_reduced(target, target.single_law, speed_m_s=nozzle.normal_speed_m_s, density_kg_m3=shots.density_kg_m3,
                         elements_per_radius=scene.accuracy.dimple_elements_per_radius, physics=physics)  # fmt: skip


def impact_rows(rows: Rows, name: str, scene: Scene) -> None:
    nozzle, shots = reference_impact(scene)
    decided = regime.impact_physics(scene, shots, nozzle.normal_speed_m_s)
    off = [block for block, choice in decided.choices.items() if choice.model == "off"]
    if not off:
        return
    base = solve(scene, decided.physics)
    for block in off:
        without = regime.impact_physics(dataclasses.replace(scene, **{block: None}), shots, nozzle.normal_speed_m_s).physics
        lean = solve(scene, without)
        rows.true(f"{name}: {block} left out: the driver of a scene without it, to the byte",
                  lean.log.with_name("driver.edp").read_bytes() == base.log.with_name("driver.edp").read_bytes(), f"{base.dofs} unknowns")  # fmt: skip
        stated = StrainRate() if block == "strain_rate" else Switch()
        on = regime.impact_physics(dataclasses.replace(scene, **{block: stated}), shots, nozzle.normal_speed_m_s).physics
        worst(rows, f"{name}: {block} forced on", impact_metrics(solve(scene, on)), impact_metrics(base), regime.TOLERANCE,
              decided.choices[block].why)  # fmt: skip


def impact_metrics(impact: ReducedImpact) -> dict[str, float]:
    return {"restitution": impact.restitution, "dimple radius": zero_height_radius(impact), "dimple depth": float(impact.surface_z[0]),
            "peak force": impact.peak_force}  # fmt: skip


def worst(rows: Rows, name: str, got: dict[str, float], base: dict[str, float], tolerance: float, why: str) -> None:
    changes = {key: abs(got[key] / base[key] - 1.0) for key in base}
    most = max(changes, key=changes.get)
    rows.below(f"{name}: largest change", changes[most], tolerance, f"of {most}; {why}")


def main() -> None:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", nargs="+", metavar="SCENE")
    options, sys.argv[1:] = parser.parse_known_args()
    rows = Rows("physics left out")
    listed = [(name, scene) for name, scene in scenes() if not options.only or name in options.only]
    begun = time.monotonic()
    for k, (name, scene) in enumerate(listed):
        asked = all_auto(scene)
        stream_rows(rows, name, asked)
        impact_rows(rows, name, asked)
        left = (time.monotonic() - begun) / (k + 1) * (len(listed) - k - 1)
        print(f"left out: {k + 1} of {len(listed)} scenes, about {left:.0f} s left", file=sys.stderr, flush=True)
    rows.finish()


if __name__ == "__main__":
    main()
