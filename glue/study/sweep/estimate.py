"""What a run's stages will roughly cost, for the time left, a dry run and the requests to a cluster."""

from __future__ import annotations

from typing import NamedTuple

from glue.flow.regime import choose_flow
from glue.scene.model import Scene
from glue.study.check import flow_cost_s
from glue.study.flow_stage import restitution_estimate
from glue.study.rundir import STAGE_ORDER
from glue.study.sweep.library import count
from glue.study.target_stage import expected_work

# Rough, from a few runs on one core: seconds of one solved speed over (elements per radius)^2, and of stages that cost
# about the same in every scene.
_SPEED_S = 0.22
_FLAT_S = {"dimple": 0.3, "coverage": 0.3, "surface": 3.0, "uncertainty": 0.3, "report": 8.0}
_MEMORY_MB = {"dimple": 500, "flow": 700, "coverage": 700, "target": 900, "surface": 900, "uncertainty": 500, "report": 1500}
_OTHER = 60.0, 900  # of a stage that is not listed
_BYTES_PER_SHOT = 2000  # arrivals, log and events in memory


class Cost(NamedTuple):
    """Of one stage: to a factor of two or so."""

    seconds: float
    memory_MB: int
    threads: int


def stage_costs(scene: Scene) -> dict[str, Cost]:
    """{stage: cost}; the dimples' own are the library's."""
    e = restitution_estimate(scene)[0]
    flow, work = choose_flow(scene, e), expected_work(scene)
    seconds = _FLAT_S | {"flow": flow_cost_s(scene, flow.model, e), "target": work["seconds"]}
    memory = dict(_MEMORY_MB)
    memory["flow"] += int(scene.expected_shots * _BYTES_PER_SHOT / 1e6)
    if work["memory_GB"]:
        memory["target"] += int(1e3 * work["memory_GB"])
    return {stage: Cost(seconds.get(stage, _OTHER[0]), memory.get(stage, _OTHER[1]), 1) for stage in STAGE_ORDER}


def library_cost_s(scene: Scene, library: dict) -> float:
    """Seconds to solve the impacts of ``library`` (``glue.study.sweep.library``), to which ``scene`` belongs, one by one."""
    return count([library]) * _SPEED_S * scene.accuracy.dimple_elements_per_radius**2
