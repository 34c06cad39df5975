"""A design's whole question: scene, goals and axes; the scene that a setting means; what was answered before."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.scene.derive import changed
from glue.scene.model import Scene
from glue.scene.reader import read_bytes, read_scene
from glue.solvers import versions
from glue.study.design.axes import Axis
from glue.study.design.goals import Goals
from glue.study.manifest import differences
from glue.study.pipeline import find_scene
from glue.study.reference import reference_impact
from glue.study.rundir import digest
from glue.target.between import RATIO
from glue.target.cache import content_key

# The fast models: shots that meet but never overlap (milliseconds a thousand), layers fed by one impact.
SEARCH = {"accuracy": {"preset": "fast"}, "models.flow": "event", "models.target": "layers"}
RECORD = "problem.json"
MAX_AXES = 8  # corners of the window are looked at one by one
# What the search and the re-runs set themselves: an axis of these would undo the confirmation.
_OWN = {
    "seed": "every re-run has another, so that chance is in the verdict",
    "schema": "it says how the scene file is read", "name": "it changes nothing of a run",
    "accuracy": "the search runs at fast, the re-runs at --confirm",
    "models": "the search runs the fast ones, the re-runs the scene's own",
}  # fmt: skip


@dataclass(frozen=True)
class Problem:
    """``content`` is the scene file's, whatever becomes of the file meanwhile."""

    scene_file: Path
    content: bytes
    goals: Goals
    axes: tuple[Axis, ...]

    @cached_property
    def search(self) -> dict[str, object]:
        """Changes of the scene for the search: the fast models; dimples between common speeds where the window has several."""
        impacts = [reference_impact(scene) for _, scene in self._corners(SEARCH)]
        speeds = {float(f"{nozzle.normal_speed_m_s * math.sqrt(shots.density_kg_m3):.9g}") for nozzle, shots in impacts}
        return SEARCH | {"accuracy": SEARCH["accuracy"] | {"dimple_speed_ratio": RATIO}} if len(speeds) > 1 else SEARCH

    def setting(self, values: Mapping[str, object], changes: Mapping[str, object] | None = None) -> bytes:
        """The scene's content with a setting, and further ``changes``, written in."""
        return changed(self.content, {**(changes or {}), **values})

    def scene(self, values: Mapping[str, object], changes: Mapping[str, object] | None = None) -> Scene:
        """The scene of a setting.  Raises InputError where it is none."""
        return read_scene(self.scene_file, content=self.setting(values, changes), provisional=True)

    def corners(self) -> list[Scene]:
        """Scenes of the search at the ends of all axes together, those that are none left out."""
        return [scene for _, scene in self._corners(self.search)]

    def _corners(self, changes: Mapping[str, object]) -> Iterator[tuple[dict[str, object], Scene]]:
        keys = [axis.key for axis in self.axes]
        for ends in itertools.product(*(axis.ends for axis in self.axes)):
            values = dict(zip(keys, ends, strict=True))
            with contextlib.suppress(InputError, KeyError):
                yield values, self.scene(values, changes)

    def misfits(self) -> list[str]:
        """Ends of axes that no scene can have, whatever the other axes say: sentences with what is allowed."""
        told, possible = [], [values for values, _ in self._corners({})]
        for axis in self.axes:
            for value in axis.ends:
                if not any(values[axis.key] == value for values in possible):
                    told += self._refusal(axis, value)
        return told

    def _refusal(self, axis: Axis, value: object) -> list[str]:
        try:
            self.scene({axis.key: value})
        except KeyError:
            return [f"--vary {axis.key}: no such table; allowed: a key of the scene file, such as nozzle.speed_m_s"]
        except InputError as error:
            mark = f": {axis.key}: "
            own = [s for s in (re.sub(r"\[\d+\]", "", s) for s in error.problems) if mark in s]
            return [f"--vary {axis.key} = {value}: {s.split(mark)[-1]}" for s in own or error.problems]
        return []  # possible with the scene's own other values

    def record(self) -> dict:
        """All that the evaluations depend on."""
        from glue.study.stages import STAGES  # here: it loads every model

        code = {pattern for stage in STAGES for pattern in stage.code} | {"glue/study/design/*.py"}
        return {
            "schema": 1, "scene": self.scene_file.name, "scene_content": digest(self.content.decode("utf-8-sig")),
            "targets": [str(t) for t in self.goals.targets], "objectives": [str(o) for o in self.goals.objectives],
            "axes": [str(axis) for axis in self.axes],
            "code": content_key({"freefem": versions()["freefem"]["package"]}, tuple(sorted(code))),
        }  # fmt: skip


def read_problem(scene_argument: str, goals: Goals, axes: tuple[Axis, ...]) -> Problem:
    """Raises InputError with every axis that does not fit the scene, each with the allowed range."""
    scene_file = find_scene(scene_argument)
    problem = Problem(scene_file, read_bytes(scene_file), goals, axes)
    base = problem.scene({})  # a scene at fault is told before its axes
    problems = [] if len(axes) <= MAX_AXES else [f"--vary: {len(axes)} axes; allowed up to {MAX_AXES}"]
    own = {axis: _OWN[table] for axis in axes if (table := axis.key.partition(".")[0].strip()) in _OWN}
    others = replace(problem, axes=tuple(axis for axis in axes if axis not in own))
    problems += others.misfits() if not problems else []
    problems += [
        f"--vary {axis.key}: cannot be varied: {why}; allowed: other keys of the scene, such as nozzle.speed_m_s"
        for axis, why in own.items()
    ]
    if base.specification is not None and any(axis.key.endswith("speed_m_s") for axis in axes):
        problems.append("--vary nozzle.speed_m_s: the scene says an intensity; allowed: a scene that says a speed")
    if problems:
        raise InputError(dict.fromkeys(problems))
    return problem


def claim(out: Path, problem: Problem) -> None:
    """Make ``out`` this problem's folder.  Raises InputError where it is another's, or holds strange files."""
    record, file = problem.record(), out / RECORD
    if file.exists():
        try:
            known = json.loads(file.read_text(encoding="utf-8"))
        except ValueError:
            known = None
        others = list(differences(known, record)) if isinstance(known, dict) else ["the record cannot be read"]
        if others:
            told = [f"{out}: holds another design, or one of another version; choose another --out"]
            raise InputError(told + [f"  {d}" for d in others])
        return
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"{out}: is not empty and no design; choose another --out")
    try:
        out.mkdir(parents=True, exist_ok=True)
        write_text_atomic(file, json.dumps(record, indent=1, ensure_ascii=False) + "\n")
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror}); choose another --out") from None


def default_out(problem: Problem) -> Path:
    """``runs/design-<scene file>-<8 hex of the problem>``."""
    return Path("runs") / f"design-{problem.scene_file.stem}-{digest(problem.record())[:8]}"
