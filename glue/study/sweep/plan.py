"""From a study to its runs: the scene of each, checked before anything starts, and ``plan.json`` that workers read.

``plan.json``: {"study", "scene_file", "stages", "cache", "library": [{"run", "runs",
"speeds_m_s", "layer_speeds_m_s", "seconds"}], "all_stages", "todo": [run], "jobs", "runs": [{"run", "state", "cause", "point",
"replicate", "seed", "axes": {key path: value}, "scene": TOML, "scene_sha256", "inputs_sha256", "costs": {stage: [s, MB,
threads]}}]}; "jobs" is null where other machines do them; state is "waiting", or "refused" with the cause.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from glue import stopping
from glue.errors import InputError
from glue.scene.derive import changed
from glue.scene.model import Scene
from glue.scene.reader import parse, read_scene, resolved_dict
from glue.study.rundir import digest
from glue.study.sweep.design import points, run_seed
from glue.study.sweep.library import count, libraries
from glue.study.sweep.study import Study
from glue.target.between import RATIO

PLAN = "plan.json"


@dataclass
class Run:
    """One run of a study; ``scene`` is None where its scene was refused, for the ``cause``."""

    name: str
    point: int
    replicate: int
    seed: int
    axes: dict[str, object]
    content: bytes
    scene: Scene | None
    cause: str = ""
    inputs_sha256: str | None = None  # of the resolved scene; None where that is found by the run itself
    costs: dict[str, tuple] = field(default_factory=dict)

    @property
    def scene_sha256(self) -> str:
        return hashlib.sha256(self.content).hexdigest()


def make_runs(study: Study) -> list[Run]:
    """All runs of the study; those of an invalid scene have a cause.  Raises InputError when every scene is invalid.

    With ``library = "auto"`` they share impacts at common speeds when those are fewer than at the runs' own.
    """
    base = dict(study.changes)
    if study.accuracy:
        base["accuracy.preset"] = study.accuracy
    own = parse(study.scene_file, study.scene_content)
    shared = {"accuracy.dimple_speed_ratio": RATIO} | base
    if study.library == "own" or "dimple_speed_ratio" in own.get("accuracy", {}):
        return _all_runs(study, own, base)
    runs = _all_runs(study, own, shared)
    if study.library == "shared" or any(run.scene.specification is not None for run in runs if run.scene):
        return runs
    alone = _all_runs(study, own, base)
    return alone if _impacts(study, alone) <= _impacts(study, runs) else runs


def _impacts(study: Study, runs: list[Run]) -> int:
    """How many impacts the runs would have solved."""
    return count(libraries([(run.name, run.scene) for run in runs if run.scene], "target" in study.stages))


def _all_runs(study: Study, own: dict, base: dict) -> list[Run]:
    seed = own["seed"] if isinstance(own.get("seed"), int) else 0
    runs = []
    for point, axes in enumerate(points(study)):
        for replicate in range(study.replicates):
            stopping.check()
            runs.append(_run(study, len(runs), point, replicate, base, axes, run_seed(study, seed, point, replicate)))
    if all(run.cause for run in runs):
        sentences = dict.fromkeys(line for run in runs for line in run.cause.split("\n"))
        raise InputError([f"{study.file}: no run of the study has a valid scene", *list(sentences)[:10]])
    return runs


def _run(study: Study, number: int, point: int, replicate: int, base: dict, axes: dict, seed: int) -> Run:
    content, scene, cause, inputs = b"", None, "", None
    try:
        content = changed(study.scene_content, base | axes | {"seed": seed})
        scene = read_scene(study.scene_file, content=content, provisional=True)
        if scene.specification is None:
            inputs = digest(resolved_dict(scene))
    except InputError as problem:
        scene, cause = None, _blamed(study, problem)
    except (KeyError, TypeError, AttributeError) as problem:
        cause = f"{study.file}: {problem}: is a path through something else than a table of the scene; allowed: a key's own path"
    name = f"{number:04d}-{(inputs or hashlib.sha256(content + repr(axes).encode()).hexdigest())[:8]}"
    return Run(name, point, replicate, seed, axes, content, scene, cause, inputs)


def _blamed(study: Study, problem: InputError) -> str:
    """The problems of a run's scene; those of a key that the study sets name the study, and where in it."""
    sources = {"accuracy.preset": "accuracy"} if study.accuracy else {}
    sources |= {key: "remove" if value is None else "[set]" for key, value in study.changes.items()}
    sources |= {key: f'axis "{axis.name}"' for axis in study.axes for key in axis.keys}
    found = []
    for line in problem.problems:
        place, _, words = line.removeprefix(f"{study.scene_file}: ").partition(": ")
        plain = re.sub(r"\[\d+\]", "", place)  # of several nozzles a study sets the key in each
        source = next((s for key, s in sources.items() if plain == key or plain.startswith(f"{key}.")), None)
        found.append(line if source is None else f"{study.file}: {place}: {words} (by {source})")
    return "\n".join(found)


def refuse_runs(study: Study, runs: list[Run], stages, skip: Callable[[Run], bool]) -> None:
    """Ask the stages what they would refuse; such runs get that as their cause.  Those to ``skip`` are not asked."""
    for run in runs:
        stopping.check()
        if run.scene is None or run.scene.specification is not None or skip(run):
            continue
        for stage in stages:
            try:
                stage.refuse(run.scene, study.scene_file)
            except InputError as problem:
                run.cause = _blamed(study, problem)
                break


def study_sha256(study: Study, runs: list[Run]) -> str:
    """Hash of all that the study computes: its runs' inputs and the stages wanted."""
    return digest([study.name, list(study.stages), [[run.inputs_sha256 or run.scene_sha256, run.axes] for run in runs]])


def default_out(study: Study, runs: list[Run]) -> Path:
    """``studies/<name>-<8 hex of the inputs>``."""
    return Path("studies") / f"{study.name}-{study_sha256(study, runs)[:8]}"


def plan_dict(study: Study, runs: list[Run], library: list[dict], cache: Path, sha256: str) -> dict:
    """Content of plan.json."""
    return {
        "schema": 1, "study": study.name, "inputs_sha256": sha256, "scene_file": str(study.scene_file.resolve()),
        "stages": list(study.stages), "cache": str(cache.resolve()), "library": library,
        "runs": [
            {"run": run.name, "state": "refused" if run.cause else "waiting", "cause": run.cause, "point": run.point,
             "replicate": run.replicate, "seed": run.seed, "axes": run.axes, "scene": run.content.decode(),
             "scene_sha256": run.scene_sha256, "inputs_sha256": run.inputs_sha256, "costs": run.costs}
            for run in runs
        ],
    }  # fmt: skip
