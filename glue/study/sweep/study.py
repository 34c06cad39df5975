"""Reads a study file strictly: every problem at once, each with file, key path and what is allowed.

    schema = 1
    name = "coverage-lhs"          # names the folder of the study
    scene = "al2024-s390"          # a scene file beside this one, or a shipped example
    stages = ["coverage", "uncertainty"]   # as peen run --only; what they need runs too
    accuracy = "fast"              # instead of the scene's own
    library = "auto"               # shared: dimples between impacts at common speeds; own: each run's at its very speed;
                                   # auto: whichever solves fewer impacts

    remove = ["shots.grade"]       # keys of the scene that the runs do without

    [set]                          # changes of the scene that all runs share
    models.flow = "auto"

    [design]
    kind = "lhs"                   # grid: every combination; lhs: Latin hypercube; sobol: Sobol's points
    samples = 200                  # of lhs and sobol
    seed = 1                       # of the design
    replicates = 1                 # runs of every point, each with other shots
    seeds = "own"                  # other shots at every point; "shared": replicate k has the same at all points

    [[axis]]
    key = "nozzle.mass_flow_kg_s"  # key path in the scene
    range = [0.005, 0.05]          # or values = [...]
    spacing = "log"                # or "linear"; with kind = "grid" also points = N
    name = "mass flow"             # for tables and figures

An axis may change several keys: ``keys = ["a", "b"]`` with values for both alike, ``factors = [1, 10]`` that multiply
them, or values that are arrays with one entry for each key.  Of a key that holds a whole number, such as
``nozzle.passes``, what a range gives is rounded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from glue.errors import InputError
from glue.scene.catalogue import closest
from glue.scene.fields import Integer, Text, Word, kind, quoted
from glue.scene.presets import PRESETS
from glue.scene.reader import example_names, example_path, parse, read_bytes
from glue.scene.schema import TOP as SCENE_TOP
from glue.scene.table import Log, Table
from glue.study.rundir import STAGE_ORDER
from glue.study.sweep.axes import KEY_PATH, Axis, read_axes

SCHEMA = 1
MAX_RUNS = 100_000
EXAMPLES = Path(__file__).resolve().parent / "examples"
_HERE = "choice of this project"
_TOP = {
    "schema": Integer(SCHEMA, SCHEMA),
    "name": SCENE_TOP["name"],
    "scene": Text(r"[^\0]{1,1000}", "allowed: a scene file, from this file's folder, or the name of a shipped example"),
    "accuracy": Word(tuple(PRESETS), "", "the scene's own"),
    "library": Word(("auto", "shared", "own"), "auto", f"fewer impacts to solve; {_HERE}"),
}
_DESIGN = {
    "kind": Word(("grid", "lhs", "sobol")),
    "seed": Integer(0, 2**32 - 1, 1, _HERE),
    "replicates": Integer(1, 10_000, 1, f"every point once; {_HERE}"),
    "seeds": Word(("own", "shared"), "own", f"other shots at every point; {_HERE}"),
}
_SAMPLES = Integer(1, MAX_RUNS)
DEFAULT_STAGES = ("coverage", "uncertainty")


@dataclass(frozen=True)
class Study:
    """A study as its file says it; ``content`` and ``scene_content`` are the files' own bytes."""

    name: str
    file: Path
    content: bytes
    scene: str
    scene_file: Path
    scene_content: bytes
    stages: tuple[str, ...]
    accuracy: str | None
    library: str
    kind: str
    samples: int | None  # of lhs and sobol
    seed: int
    replicates: int
    seeds: str
    changes: dict[str, object]  # {key path of the scene: value, None for a key to be removed}, for all runs
    axes: tuple[Axis, ...]


def example_studies() -> list[str]:
    """Names of the studies shipped with the project."""
    return sorted(file.stem for file in EXAMPLES.glob("*.toml"))


def find_study(argument: str | Path) -> Path:
    """Path of a study given as a file or as the name of a shipped one.  Raises InputError."""
    path = Path(argument)
    if path.is_file():
        return path
    if str(argument) in example_studies():
        return EXAMPLES / f"{argument}.toml"
    raise InputError(f"{argument}: no such study file, nor a shipped one ({', '.join(example_studies())})")


def read_study(argument: str | Path) -> Study:
    """The study in a file or of a shipped name.  Raises InputError with all problems found."""
    file = find_study(argument)
    content = read_bytes(file)
    log = Log(file)
    top = Table(parse(file, content), "", log)
    homes = dict.fromkeys((*_DESIGN, "samples"), "[design]")
    top.refuse_others((*_TOP, "stages", "remove", "set", "design", "axis"), elsewhere=homes)
    head = top.get_all(_TOP)
    stages = _stages(top)
    scene_file, scene_content = _scene(top, head["scene"], file)
    design, samples = _design(top)
    axes = read_axes(top, design["kind"])
    changes = _changes(top, axes, None if log.problems else parse(scene_file, scene_content))
    runs = design["replicates"] or 1
    for axis in axes if design["kind"] == "grid" else ():
        runs *= len(axis.values) if axis.values is not None else axis.points
    runs *= samples or 1
    if runs > MAX_RUNS:
        top.problem("design", f"makes {runs} runs; allowed up to {MAX_RUNS}")
    if log.problems:
        raise InputError(log.problems)
    return Study(
        head["name"], file, content, head["scene"], scene_file, scene_content, stages, head["accuracy"] or None,
        head["library"], design["kind"], samples, design["seed"], design["replicates"], design["seeds"], changes, axes,
    )  # fmt: skip


def _stages(top: Table) -> tuple[str, ...]:
    given = top.data.get("stages", list(DEFAULT_STAGES))
    word = Word(STAGE_ORDER)
    if not isinstance(given, list) or not given:
        top.problem("stages", f"must be an array of stages, not {kind(given)}; {word.allowed}")
        return ()
    for name in given:
        if problem := word.problem(name):
            top.problem("stages", problem)
    return tuple(name for name in STAGE_ORDER if name in given)


def _scene(top: Table, given: object, file: Path) -> tuple[Path, bytes]:
    """File and content of the base scene: beside the study first, then a shipped one."""
    if not isinstance(given, str):
        return file, b""
    beside = file.parent / given
    path = beside if beside.is_file() else example_path(given)
    if path is None:
        top.problem("scene", f"{quoted(given)}: no such file in {file.parent}; allowed also: {', '.join(example_names())}")
        return file, b""
    content = read_bytes(path)
    try:
        parse(path, content)
    except InputError as problem:
        top.log.problems += problem.problems
    return path, content


def _design(top: Table) -> tuple[dict, int | None]:
    table = top.table("design", "kind, samples, seed, replicates")
    if table is None:
        return dict.fromkeys(_DESIGN), None
    table.refuse_others((*_DESIGN, "samples"))
    design = table.get_all(_DESIGN)
    samples = None
    if design["kind"] == "grid" and "samples" in table:
        table.problem("samples", 'a grid has as many points as its axes make; allowed: with kind = "lhs" or "sobol"')
    elif design["kind"] in ("lhs", "sobol"):
        samples = table.get("samples", _SAMPLES)
    return design, samples


def _changes(top: Table, axes: tuple[Axis, ...], scene: Mapping | None) -> dict[str, object]:
    """The leaves of [set] by key path, and None for each path of remove, which a known ``scene`` must have."""
    table = top.optional_table("set")
    found = dict(_leaves(table.data)) if table else {}
    removed = top.data.get("remove", [])
    if not isinstance(removed, list) or any(KEY_PATH.problem(key) for key in removed):
        top.problem("remove", f"must be an array of key paths, not {quoted(removed)}; {KEY_PATH.allowed}")
        removed = []
    there = dict.fromkeys(_paths(scene)) if scene is not None else removed
    for key in removed:
        if key not in there:
            guess = closest(key, there)
            hint = f'did you mean "{guess}"? ' if guess else ""
            top.problem("remove", f"the scene has no {quoted(key)}; {hint}allowed: keys that it has")
    for key in found if table else ():
        if key in ("seed", "schema", "name"):
            table.problem(key, f'"{key}" is the scene\'s own; allowed: other keys of the scene (seeds: [design])')
        elif any(key in axis.keys for axis in axes):
            table.problem(key, "is changed by an axis too; allowed: one of the two")
    return dict.fromkeys(removed) | found


def _paths(data: Mapping, path: str = ""):
    """Path of every key and table, also of those in arrays of tables."""
    for key, value in data.items():
        where = f"{path}.{key}" if path else key
        yield where
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, Mapping):
                yield from _paths(item, where)


def _leaves(data: Mapping, path: str = ""):
    for key, value in data.items():
        where = f"{path}.{key}" if path else key
        if isinstance(value, Mapping):
            yield from _leaves(value, where)
        else:
            yield where, value
