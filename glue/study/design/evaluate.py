"""One setting run by the fast models, or at a preset with another seed: an ordinary run directory, and what it tells."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from glue.errors import InputError, PeenError
from glue.scene.reader import read_scene
from glue.study import pipeline
from glue.study.design.goals import Goals, Quantity, Reading
from glue.study.design.problem import Problem
from glue.study.rundir import METRICS

NEVER = -10.0  # scaled slack of a quantity that could not be determined, or of a setting that could not be run


@dataclass(frozen=True)
class Evaluation:
    """``state``: "done"; with its ``cause`` "refused" (never a run) or "failed" (a solver, which may do it yet).

    ``readings`` by key path, None for what has no value.
    """

    number: int
    values: Mapping[str, object]
    state: str
    readings: Mapping[str, Reading | None] = field(default_factory=dict)
    wall_s: float = 0.0
    cause: str = ""

    def reading(self, quantity: Quantity) -> Reading | None:
        return self.readings.get(quantity.path)

    def slacks(self, goals: Goals) -> list[float]:
        """Scaled slack of each target; below 0: not surely met."""
        found = [(target, self.reading(target.quantity)) for target in goals.targets]
        return [NEVER if reading is None else target.scaled(target.slack(reading)) for target, reading in found]

    def costs(self, goals: Goals) -> list[float] | None:
        """The objectives' values, signed so that less is better; None where one is missing."""
        found = [(objective, self.reading(objective.quantity)) for objective in goals.objectives]
        return None if any(r is None for _, r in found) else [o.sign * r.value for o, r in found]

    def feasible(self, goals: Goals) -> bool:
        """Does every target hold with the unfavourable end of its interval, and has every objective a value?"""
        return self.state == "done" and self.costs(goals) is not None and all(s >= 0.0 for s in self.slacks(goals))


def evaluate(
    problem: Problem,
    number: int,
    values: Mapping[str, object],
    folder: Path,
    progress: Callable[[str, float | None, str], None] = lambda *_: None,
) -> Evaluation:
    """Run a setting by the fast models into ``folder``; a setting that is refused or fails is a result, not an end."""
    return _run(problem, number, values, folder, problem.search, True, progress)


def rerun(
    problem: Problem, values: Mapping[str, object], folder: Path, preset: str, seed: int, progress=lambda *_: None
) -> Evaluation:
    """Run a setting at ``preset`` with another seed, which is its number, and the scene's own models."""
    return _run(problem, seed, values, folder, {"accuracy.preset": preset, "seed": seed}, False, progress)


def _run(problem, number, values, folder, changes, expected, progress) -> Evaluation:
    begun = time.monotonic()
    content = problem.setting(values, changes)
    try:
        path = pipeline.run(
            str(problem.scene_file), folder, only=problem.goals.stages, progress=progress, content=content
        )
        metrics = json.loads((path / METRICS).read_text(encoding="utf-8"))
        scene = read_scene(path / "scene.toml", content=content)
    except PeenError as error:
        cause = " ".join(str(error).split("\n  log:")[0].split())[:300]
        state = "refused" if isinstance(error, InputError) else "failed"
        return Evaluation(number, values, state, wall_s=time.monotonic() - begun, cause=cause)
    readings = {q.path: q.read(metrics, scene, expected) for q in problem.goals.quantities}
    return Evaluation(number, values, "done", readings, time.monotonic() - begun)
