"""From "5%" and "60s" to the scene file that keeps them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from glue.errors import InputError
from glue.scene.derive import changed
from glue.scene.reader import read_bytes, read_scene
from glue.study.pipeline import find_scene
from glue.study.tradeoff.choose import choose, text
from glue.study.tradeoff.ladder import STAGES

_SECONDS = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0}
_NEEDS = {"dimple": (), "flow": ("dimple",), "coverage": ("dimple", "flow"), "target": ("dimple", "flow"), "surface": ("dimple", "flow")}


def chosen_scene(
    scene_argument: str, target_error: str | None, budget: str | None, accuracy: str | None, only: Sequence[str] = ()
) -> tuple[bytes, str]:
    """(content of the scene file with the choice written in, what was chosen and why).

    Raises InputError for wishes that cannot be read, or that nothing measured fulfils.
    """
    problems = [] if accuracy is None else ["--accuracy: is what --target-error and --budget choose; allowed: without them"]
    error, seconds = _read(parse_error, target_error, problems), _read(parse_seconds, budget, problems)
    if problems:
        raise InputError(problems)
    scene_file = find_scene(scene_argument)
    content = read_bytes(scene_file)
    scene = read_scene(scene_file, content=content, provisional=True)
    stages = [s for s in STAGES if not only or s in only or any(s in _NEEDS.get(o, ()) for o in only)]
    best = choose(scene, target_error=error, budget_s=seconds, stages=stages or STAGES)
    return changed(content, best.changes), text(best)


def parse_error(value: str) -> float:
    """"5%" or ".05" as .05.  Raises InputError."""
    found = re.fullmatch(r"\s*(\d*\.?\d+)\s*(%?)\s*", value)
    share = float(found[1]) * (0.01 if found[2] else 1.0) if found else 0.0
    if not 1e-4 <= share <= 1.0:
        raise InputError(f"--target-error {value}: must be a share such as 5% or 0.05; allowed 0.01% to 100%")
    return share


def parse_seconds(value: str) -> float:
    """"60s", "5min" or "1h" in seconds.  Raises InputError."""
    found = re.fullmatch(r"\s*(\d*\.?\d+)\s*(s|min|h|)\s*", value)
    if not found or not 0.0 < float(found[1]) * _SECONDS[found[2]] <= 1e7:
        raise InputError(f"--budget {value}: must be a time such as 60s, 5min or 2h; allowed above 0")
    return float(found[1]) * _SECONDS[found[2]]


def _read(parse, value: str | None, problems: list[str]) -> float | None:
    if value is None:
        return None
    try:
        return parse(value)
    except InputError as problem:
        problems += problem.problems
        return None
