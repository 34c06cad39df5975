"""``report.html`` of a study: what was varied, headline metrics against every axis, all runs and what they warn of.

Then failures, cost and provenance.
"""

from __future__ import annotations

import csv
import json
import math
from html import escape
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.report.markup import Cell, Section, document, number, table
from glue.report.plots import Series, legend, plot
from glue.study.rows import ROWS
from glue.study.sweep.warned import distinct

HEADLINES = (
    "coverage.final", "coverage.time_98_s", "residual_stress.surface_Pa", "residual_stress.max_compressive_Pa",
    "residual_stress.compressive_depth_m", "roughness.Sa_m", "flow.mean_normal_energy_fraction", "flow.collision_number",
)  # fmt: skip
MOST_ROWS = 3000  # of the table of runs on the page; table.csv has all
_MOST_SERIES = 6  # colours that can be told apart


class Shown(NamedTuple):
    """How a column is shown: label, factor to the printed unit, unit, digits."""

    label: str
    factor: float
    unit: str
    digits: int


def write_study_report(folder: Path) -> Path:
    """Write ``report.html`` into the study's ``folder`` from its table.csv, costs.csv and study.json; its path.

    Raises InputError when table.csv or study.json is missing or cannot be read.
    """
    rows, costs = _table(folder / "table.csv"), []
    if (folder / "costs.csv").exists():
        costs = _table(folder / "costs.csv")
    try:
        study = json.loads((folder / "study.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        raise InputError(f"{folder / 'study.json'}: cannot be read ({problem}); peen sweep writes it") from None
    write_text_atomic(folder / "report.html", study_page(study, rows, costs))
    return folder / "report.html"


def _table(path: Path) -> list[dict[str, str]]:
    try:
        with open(path, encoding="utf-8", newline="") as f:
            rows = list(csv.DictReader(f))
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise InputError(f"{path}: cannot be read ({problem}); peen sweep writes it") from None
    lacking = [name for name in ("run", "state") if rows and name not in rows[0]]
    if lacking:
        raise InputError(f"{path}: has no column {', '.join(lacking)}; is it a study's table?")
    return rows


def study_page(study: dict, rows: list[dict[str, str]], costs: list[dict[str, str]]) -> str:
    """The HTML text.  study: content of study.json; rows, costs: of table.csv and costs.csv, cells as text."""
    axes = study.get("axes", [])
    metrics = [name for name in HEADLINES if any(_value(row, name) is not None for row in rows)]
    counts = {state: sum(row["state"] == state for row in rows) for state in ("done", "failed", "refused", "waiting")}
    told = ", ".join(f"{count} {state}" for state, count in counts.items() if count)
    return document(
        str(study.get("name", "study")),
        f"Parametric study of {study.get('scene', 'a scene')} · {len(rows)} runs: {told or 'none'}",
        [
            Section("studied", "What was studied", _studied(study, axes)),
            Section("plots", "What it shows", _plots(axes, rows, metrics)),
            Section("runs", "All runs", _runs(axes, rows, metrics)),
            Section("warnings", "Warnings", _warnings(rows)),
            Section("failures", "Runs that failed or were refused", _failures(rows)),
            Section("cost", "Cost", _cost(costs)),
            Section("provenance", "Provenance", _provenance(study)),
        ],
    )


def _studied(study: dict, axes: list[dict]) -> str:
    design = study.get("design", {})
    facts = [("scene", study.get("scene")), ("stages", ", ".join(study.get("stages", []))), ("accuracy", study.get("accuracy")),
             ("design", ", ".join(f"{k} {v}" for k, v in design.items() if v is not None)),
             ("changed for all runs", ", ".join(f"no {k}" if v is None else f"{k} = {v}" for k, v in (study.get("set") or {}).items()))]  # fmt: skip
    cells = [(Cell(what, kind="short"), Cell(str(value), kind="long")) for what, value in facts if value]
    spans = [(_name(axis), ", ".join(axis.get("keys", [])), _span(axis), axis.get("unit") or "") for axis in axes]
    heads = ("axis", "key of the scene", "values", "unit")
    return table(("", ""), cells, label="Study") + table(heads, spans, label="Axes", titled=True)


def _name(axis: dict) -> str:
    return str(axis.get("name") or axis.get("label") or axis["keys"][0])


def _span(axis: dict) -> str:
    if "values" in axis:
        return ", ".join(f"{v:g}" if isinstance(v, int | float) and not isinstance(v, bool) else str(v) for v in axis["values"])
    low, high = axis.get("range", ("?", "?"))
    return f"{low:g} to {high:g}, {axis.get('spacing', 'linear')}" if isinstance(low, int | float) else "?"


def _plots(axes: list[dict], rows: list[dict], metrics: list[str]) -> str:
    """For each headline metric a row of plots, one an axis."""
    done = [row for row in rows if row["state"] == "done"]
    parts = []
    for name in metrics:
        shown, drawn, key = _shown(name), [], ""
        for axis in axes:
            found = _series(axis, axes, done, name, shown.factor)
            if found is None:
                continue
            series, places = found
            log = axis.get("spacing") == "log" and not places
            drawn.append(plot(series, _name(axis) + _unit(axis), _titled(shown), places, log))
            if len(series) > 1:
                words = escape(f"Against {_name(axis)}, by {_others(axis, axes)}:")
                key += f'<p class="note">{words}</p>' + legend([s.label for s in series])
        if drawn:
            known = sum(_value(row, name) is not None for row in done)
            some = "" if known == len(done) else f" (of {known} of {len(done)} runs, which have it)"
            parts.append(f'<figure><h3>{escape(_titled(shown) + some)}</h3><div class="plots">{"".join(drawn)}</div>{key}</figure>\n')
    note = (
        '<p class="note">Each point is a setting, its bar 95 %: over replicates where there are several, else as the run itself'
        " states. Settings that differ in the axis shown alone are joined up.</p>\n"
    )
    return note + "".join(parts) if parts else ""


def _others(axis: dict, axes: list[dict]) -> str:
    return ", ".join(_name(other) + _unit(other) for other in axes if other is not axis)


def _unit(axis: dict) -> str:
    return f" [{axis['unit']}]" if axis.get("unit") else ""


def _series(axis: dict, axes: list[dict], rows: list[dict], name: str, factor: float) -> tuple[list[Series], list[str]] | None:
    """(series, words on the x axis) of a metric against an axis; None without two different places on it."""
    settings: dict[tuple, list[dict]] = {}
    for row in rows:
        if _value(row, name) is not None:
            settings.setdefault(tuple(row.get(key, "") for a in axes for key in a["keys"]), []).append(row)
    places = {point: group[0].get(axis["keys"][0], "") for point, group in settings.items()}
    if len(set(places.values())) < 2:
        return None
    numeric = all(_float(text) is not None for text in places.values())
    words = [] if numeric else list(dict.fromkeys(places.values()))
    lines: dict[tuple, list[tuple[float, float, float]]] = {}
    for point, group in settings.items():
        x = _float(places[point]) if numeric else float(words.index(places[point]))
        others = tuple(group[0].get(key, "") for other in axes if other is not axis for key in other["keys"])
        lines.setdefault(others, []).append((x, *_mean(group, name, factor)))
    single = all(len({x for x, _, _ in points}) == len(points) for points in lines.values())  # by another key of the axis
    joined = single and len(lines) <= _MOST_SERIES and all(len(points) > 1 for points in lines.values())
    if not joined:
        lines = {(): [point for points in lines.values() for point in points]}
    found = []
    for others, points in lines.items():
        x, y, bar = (np.array(column) for column in zip(*points, strict=True))
        found.append(Series(", ".join(_word(o) for o in others), x, y, bar, joined))
    return found, words


def _word(text: str) -> str:
    value = _float(text)
    return text if value is None else f"{value:g}"


def _mean(group: list[dict], name: str, factor: float) -> tuple[float, float]:
    """Mean over replicates and its 95 % half width: Student's, or the one run's own."""
    values = factor * np.array([_value(row, name) for row in group])
    if values.size > 1:
        from scipy.stats import t  # here: only replicates need it

        return float(values.mean()), float(t.ppf(0.975, values.size - 1) * values.std(ddof=1) / math.sqrt(values.size))
    own = _value(group[0], f"{name}.u95")
    return float(values[0]), math.nan if own is None else abs(factor) * own


def _runs(axes: list[dict], rows: list[dict], metrics: list[str]) -> str:
    keys = [key for axis in axes for key in axis["keys"]]
    heads = ["run", "state", *keys]
    for name in metrics:
        shown = _shown(name)
        heads += [_titled(shown), "± 95 %"]
    body = [_run(row, keys, metrics) for row in rows[:MOST_ROWS]]
    note = "A click on a head sorts by it. What each run found beside this is in table.csv."
    if len(rows) > MOST_ROWS:
        note += f" The first {MOST_ROWS} of {len(rows)} runs."
    return table(heads, body, label="Runs", note=note, sortable=True)


def _run(row: dict, keys: list[str], metrics: list[str]) -> list:
    cells: list = [Cell(row["run"], kind="short"), row["state"]]
    for key in keys:
        value = _float(row.get(key, ""))
        cells.append(row.get(key, "") if value is None else number(f"{value:.5g}", value))
    for name in metrics:
        shown = _shown(name)
        for column in (name, f"{name}.u95"):
            value = _value(row, column)
            told = None if value is None else value * shown.factor
            cells.append(Cell("", kind="number") if told is None else number(f"{told:.{shown.digits}f}", told))
    return cells


def _failures(rows: list[dict]) -> str:
    found = [
        (Cell(row["run"], kind="short"), row["state"], Cell(row.get("cause", ""), kind="why"))
        for row in rows
        if row["state"] in ("failed", "refused")
    ]
    return table(("run", "state", "cause"), found, label="Failures")


def _warnings(rows: list[dict]) -> str:
    """Each warning once, with the number of runs that have it."""
    told = distinct(row.get("warnings") or "" for row in rows)
    cells = [(Cell(text, kind="why"), number(str(count), count)) for text, count in told]
    note = "Warnings that differ in numbers alone are one, shown as the first run has it; table.csv has each run's."
    return table(("warning", "runs"), cells, label="Warnings", note=note) if cells else ""


def _cost(costs: list[dict]) -> str:
    """Sums over all runs, stage by stage."""
    stages = list(dict.fromkeys(column.split(".")[0] for row in costs for column in row if column.endswith(".wall_s")))
    times = ("wall_s", "cpu_s")
    sums = {stage: [sum(_value(row, f"{stage}.{key}") or 0.0 for row in costs) for key in times] for stage in stages}
    longest = max((wall for wall, _ in sums.values()), default=0.0) or 1.0
    rows = [
        (stage, number(f"{wall:.1f} s", wall), Cell("", bar=wall / longest), number(f"{cpu:.1f} s", cpu))
        for stage, (wall, cpu) in sums.items()
    ]
    total = sum(wall for wall, _ in sums.values())
    note = f"Sums over {len(costs)} runs, {total:.0f} s in all; what runs share is solved once."
    return table(("stage", "wall time", "", "processor time"), rows, label="Cost", note=note)


def _provenance(study: dict) -> str:
    named = {"file": "study file", "inputs_sha256": "sha256 of the inputs"}
    facts = [(named.get(key, key), study.get(key)) for key in ("file", "begun", "ended", "executor", "inputs_sha256")]
    for code, version in (study.get("versions") or {}).items():
        facts.append((code, ", ".join(f"{k} {v}" for k, v in version.items()) if isinstance(version, dict) else version))
    cells = [(Cell(what, kind="short"), Cell(str(value), kind="long")) for what, value in facts if value]
    return table(("what", "value"), cells, label="Provenance")


def _shown(name: str) -> Shown:
    section, key = name.split(".")
    title, rows = ROWS[section]
    _, label, factor, unit, digits = next(row for row in rows if row[0] == key)
    return Shown(f"{title}: {label}", factor, unit, digits)


def _titled(shown: Shown) -> str:
    return shown.label + (f" [{shown.unit}]" if shown.unit else "")


def _value(row: dict, column: str) -> float | None:
    return _float(row.get(column, ""))


def _float(text: str | None) -> float | None:
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if math.isfinite(value) else None
