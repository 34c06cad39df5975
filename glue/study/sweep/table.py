"""What a study found: ``table.csv``, ``costs.csv`` and ``study.json``, written again whenever the study is run.

``table.csv`` has a row for each run, in the order of the design:
    run          name of its folder under ``runs/``
    state        done, failed, refused (its scene is not valid) or waiting (not run, or stopped)
    cause        of failed and refused: the first line of what was wrong
    warnings     of metrics.json: "<section>: <text>", several with " | " between them
    point, replicate   number of the point of the design, and of its repetition, from 0
    seed         of the scene
    <key path>   a column for each key of each axis, such as ``nozzle.speed_m_s``
    <section>.<key>    every number of metrics.json, such as ``coverage.final``, ``dimple.radius_m``; also ``flow.model`` and
                 ``target.model``
    <section>.<key>.u95   half width of its 95 % interval, where the stage ``uncertainty`` gives one
An empty cell is a value that the run does not have.  Nothing in it depends on when, where or how fast the runs were made:
the same study gives the same bytes.  ``table.parquet`` is the same table, where pyarrow is installed.

``costs.csv`` has the same rows: run, state, then ``<stage>.wall_s``, ``<stage>.cpu_s``, ``<stage>.peak_memory_bytes`` by stage,
and ``wall_s``, ``cpu_s`` of all.  A dimple that another run or the study's library had solved costs next to nothing.

``study.json``: {"schema", "name", "file", "scene", "stages", "accuracy", "library", "set", "design": {"kind", "samples", "seed",
"replicates", "seeds"}, "axes": [{"name", "keys", "unit", "values" or "range" and "spacing", "factors"}], "runs": {"all", "done",
"failed", "refused", "waiting"}, "exit_code", "inputs_sha256", "executor", "versions", "begun", "ended"}.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path

from glue.atomic import atomic_path, write_text_atomic
from glue.errors import InputError
from glue.study.manifest import read_manifest
from glue.study.rundir import METRICS, STAGE_ORDER
from glue.study.sweep.plan import Run
from glue.study.sweep.study import Study
from glue.study.sweep.records import failure_file
from glue.study.sweep.warned import warnings_of

TABLE, COSTS, STUDY = "table.csv", "costs.csv", "study.json"
_TIMES = ("wall_s", "cpu_s")
_COST_KEYS = (*_TIMES, "peak_memory_bytes")
_WORDS = ("flow.model", "target.model")  # the texts of metrics.json that are results, not remarks


def write_tables(out: Path, study: Study, runs: Sequence[Run], done: set[str]) -> dict[str, int]:
    """Write the tables of the study in ``out``; {"all", "done", "failed", "refused", "waiting", "exit_code"}.

    ``done`` holds the names of the runs that are finished.
    """
    rows, costs, exit_code = [], [], 0
    counts = {"all": len(runs), "done": 0, "failed": 0, "refused": 0, "waiting": 0}
    for run in runs:
        state, cause, code = _state(out, run, done)
        for file in (study.file, study.scene_file):
            cause = cause.replace(f"{file}: ", "")  # the same for every run
        counts[state] += 1
        exit_code = exit_code or code
        head = {"run": run.name, "state": state, "cause": cause}
        row = head | {"point": run.point, "replicate": run.replicate, "seed": run.seed} | run.axes
        metrics = _read_metrics(out / "runs" / run.name) if state in ("done", "failed") else {}
        rows.append(row | {"warnings": warnings_of(metrics)} | _metrics(metrics))
        costs.append({"run": run.name, "state": state} | _costs(out / "runs" / run.name))
    keys = [key for axis in study.axes for key in axis.keys]
    first = ["run", "state", "cause", "warnings", "point", "replicate", "seed", *keys]
    columns = first + sorted({key for row in rows for key in row} - set(first), key=_section)
    stages = [f"{stage}.{key}" for stage in STAGE_ORDER for key in _COST_KEYS]
    cost_columns = ["run", "state", *(c for c in stages if any(c in row for row in costs)), *_TIMES]
    write_text_atomic(out / TABLE, _csv(columns, rows))
    write_text_atomic(out / COSTS, _csv(cost_columns, costs))
    _write_parquet(out / "table.parquet", columns, rows)
    return counts | {"exit_code": exit_code}


def has_parquet() -> bool:
    """Is pyarrow, which writes Parquet, installed?"""
    import importlib.util

    return importlib.util.find_spec("pyarrow") is not None


def study_dict(study: Study, counts: dict, **facts) -> dict:
    """Content of study.json; ``facts``: inputs_sha256, executor, versions, begun, ended."""
    counts = dict(counts)
    return {
        "schema": 1, "name": study.name, "file": study.file.name, "scene": study.scene, "stages": list(study.stages),
        "accuracy": study.accuracy, "library": study.library, "set": study.changes,
        "design": {key: getattr(study, key) for key in ("kind", "samples", "seed", "replicates", "seeds")},
        "axes": [_axis(axis) for axis in study.axes],
        "exit_code": counts.pop("exit_code"), "runs": counts, **facts,
    }  # fmt: skip


def _axis(axis) -> dict:
    found = {"name": axis.name, "keys": list(axis.keys), "unit": axis.unit}
    if axis.values is not None:
        found["values"] = list(axis.values)
    else:
        found |= {"range": [axis.low, axis.high], "spacing": "log" if axis.log else "linear"}
        found |= {} if axis.points is None else {"points": axis.points}
    return found | ({"factors": list(axis.factors)} if axis.factors else {})


def _state(out: Path, run: Run, done: set[str]) -> tuple[str, str, int]:
    """(state, cause, exit code) of a run."""
    if run.cause:
        return "refused", run.cause.split("\n")[0], 0
    if run.name in done:
        return "done", "", 0
    try:
        record = json.loads(failure_file(out, run.name).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return "waiting", "", 0
    return "failed", record["cause"].split("\n")[0], record["exit_code"]


def _read_metrics(path: Path) -> dict:
    """A run's metrics.json, empty where there is none."""
    try:
        return json.loads((path / METRICS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def _metrics(metrics: dict) -> dict[str, object]:
    """{column: value} of metrics.json; times are costs."""
    metrics, found = dict(metrics), {}
    for name, interval in metrics.pop("uncertainty", {}).items():
        if isinstance(interval, dict) and _is_number(interval.get("half_width_95")):
            found[f"{name}.u95"] = interval["half_width_95"]
    for section, values in metrics.items():
        for key, value in values.items() if isinstance(values, dict) else ():
            name = f"{section}.{key}"
            if key not in _TIMES and (value is None or isinstance(value, bool) or _is_number(value) or name in _WORDS):
                found[name] = value
    return found


def _costs(path: Path) -> dict[str, float]:
    try:
        stages = read_manifest(path)["stages"]
    except InputError:
        return {}
    found = {f"{s}.{k}": record[k] for s, record in stages.items() for k in _COST_KEYS if k in record}
    return found | {k: sum(record.get(k, 0.0) for record in stages.values()) for k in _TIMES}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _section(column: str) -> tuple:
    """Sections in the order of the stages, a quantity's interval right behind it."""
    section = column.split(".")[0]
    order = {"dimple": 0, "flow": 1, "coverage": 2, "target": 3, "residual_stress": 4, "roughness": 5}
    return order.get(section, 9), section, column


def _csv(columns: list[str], rows: list[dict]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(row.get(column)) for column in columns] for row in rows)
    return text.getvalue()


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    return repr(value) if isinstance(value, float) else json.dumps(value)


def _write_parquet(path: Path, columns: list[str], rows: list[dict]) -> None:
    if not has_parquet():
        return
    import pyarrow  # here: an optional package
    import pyarrow.parquet

    data = {c: [_plain(row.get(c)) for row in rows] for c in columns}
    table = pyarrow.table({c: _column(values) for c, values in data.items()})
    with atomic_path(path) as part:
        pyarrow.parquet.write_table(table, part)


def _plain(value: object) -> object:
    """A value that a column holds: arrays and tables of a scene as their text."""
    return json.dumps(value) if isinstance(value, list | dict) else value


def _column(values: list) -> list:
    """Values of one kind: all texts where any is a text."""
    if any(isinstance(v, str) for v in values):
        return [None if v is None else v if isinstance(v, str) else _cell(v) for v in values]
    if any(isinstance(v, float) for v in values):
        return [None if v is None else float(v) for v in values]
    return values
