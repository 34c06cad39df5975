"""The stages of an evaluation: the usual ones, with dimples and layer shapes taken between speeds solved once for all."""

from __future__ import annotations

import dataclasses
import functools
import math

from glue.study import stages as usual
from glue.study.dimple_stage import SLOWEST, dimple_metrics, dimple_stage, other_speeds, ready_kernels, scene_physics
from glue.study.design.problem import Problem
from glue.study.reference import reference_impact
from glue.study.stage import Stage, Work
from glue.study.target_stage import layers, target_stage
from glue.target.between import Between, solve_between
from glue.target.physics import ImpactPhysics


def share_dimples(problem: Problem, jobs: int, progress) -> tuple[Between | None, str]:
    """(impacts for every speed of the window, what was done); None where every setting has the same, or its own."""
    corners = problem.corners()
    if not corners:
        return None, "no corner of the window is a scene: each setting solves its own dimple"
    if any(scene.specification is not None for scene in corners):
        return None, "the scene says what is to come out: each setting solves its own dimple"
    if len({scene.target.material for scene in corners}) > 1:
        return None, "several materials: each setting solves its own dimple"
    physics = {scene_physics(scene)[0] for scene in corners}
    if len(physics) > 1 or not _free(next(iter(physics))):
        return None, "strain rate, target inertia or an elastic shot tie a dimple to one shot: each setting solves its own"
    density = corners[0].shots.density_kg_m3
    nominal, fastest = [], []
    for scene in corners:
        nozzle, shots = reference_impact(scene)
        heavier = math.sqrt(shots.density_kg_m3 / density)
        nominal.append(heavier * nozzle.normal_speed_m_s)
        fastest.append(heavier * max(nozzle.normal_speed_m_s, *other_speeds(scene)))
    low, high = min(nominal), max(nominal)
    if high <= low * (1.0 + 1e-9):
        return None, "one speed: every setting shares its dimple"
    ready_kernels()
    accuracy = corners[0].accuracy
    found = solve_between(
        corners[0].target.material, SLOWEST * low, (low, high), max(fastest), density_kg_m3=density,
        elements_per_radius=accuracy.dimple_elements_per_radius, steps_per_contact=accuracy.dimple_steps_per_contact,
        physics=next(iter(physics)), layers=any(q.stage == "target" for q in problem.goals.quantities), jobs=jobs,
        progress=progress,
    )  # fmt: skip
    speeds = found.library.speeds_m_s
    return found, f"dimples between {len(speeds)} speeds solved once, {speeds[0]:.3g} to {speeds[-1]:.4g} m/s"


def search_stages(shared: Between | None) -> tuple[Stage, ...]:
    """The stages of one evaluation."""
    if shared is None:
        return usual.STAGES
    own = {"dimple": functools.partial(_dimple, shared), "target": functools.partial(_target, shared)}
    code = ("glue/target/between.py", "glue/study/design/shared.py")
    return tuple(
        dataclasses.replace(stage, run=own[stage.name], code=(*stage.code, *code)) if stage.name in own else stage
        for stage in usual.STAGES
    )


def _free(physics: ImpactPhysics) -> bool:
    return not (physics.rate or physics.inertia or physics.elastic_shot is not None)


def _dimple(shared: Between, work: Work) -> tuple[dict, list[str]]:
    nozzle, shots = reference_impact(work.scene)
    physics, choices = scene_physics(work.scene)
    if not shared.serves(physics):  # an "auto" that decides otherwise here than at the corners
        return dimple_stage(work)
    dimple = shared.dimple(nozzle.normal_speed_m_s, shots.diameter_m, shots.density_kg_m3)
    dimple.save(work.path / "dimple" / "dimple.npz")
    metrics = dimple_metrics(dimple, shots.medium) | {"between_solved_speeds": True}
    if choices:
        metrics["physics"] = {block: vars(choice) for block, choice in choices.items()}
    return {"dimple": metrics}, ["dimple/dimple.npz"]


def _target(shared: Between, work: Work) -> tuple[dict, list[str]]:
    def between(work: Work, impacts, dimple):
        return layers(work, impacts, dimple, shared.layer_shape(dimple.speed_m_s, dimple.density_kg_m3))

    return target_stage(work, {"layers": between})
