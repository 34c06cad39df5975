"""``evaluations.csv``: every setting that was tried, one a line; only what failed is run again."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.study.design.axes import Axis
from glue.study.design.evaluate import Evaluation
from glue.study.design.goals import Goals, Reading

FILE = "evaluations.csv"
STATES = ("done", "refused", "failed")
_HEAD = ("number", "state", "feasible", "worst_slack", "wall_s")


def write_history(path: Path, evaluations: Sequence[Evaluation], axes: Sequence[Axis], goals: Goals) -> None:
    """All ``evaluations`` by number: axes, quantities, half widths (re-run, all causes), cause of no result."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    columns = [c for q in goals.quantities for c in (q.path, f"{q.path} half_width_95_rerun", f"{q.path} half_width_95")]
    writer.writerow([*_HEAD, *(axis.key for axis in axes), *columns, "cause"])
    for e in sorted(evaluations, key=lambda e: e.number):
        readings = [e.readings.get(q.path) for q in goals.quantities]
        numbers = ["" if v is None else repr(float(v)) for r in readings for v in (r or (None,) * 3)]
        worst = min(e.slacks(goals), default=0.0)
        head = (e.number, e.state, int(e.feasible(goals)), repr(worst), f"{e.wall_s:.3f}")
        writer.writerow([*head, *(e.values[axis.key] for axis in axes), *numbers, e.cause])
    write_text_atomic(path, out.getvalue())


def read_history(path: Path, axes: Sequence[Axis], goals: Goals) -> list[Evaluation]:
    """What ``write_history`` wrote, [] for no file.  Raises InputError for one that cannot be read."""
    try:
        rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"), newline="")))
        return [_evaluation(row, axes, goals) for row in rows]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, KeyError, TypeError) as problem:
        raise InputError(f"{path}: cannot be read ({problem!r}); choose another --out, or remove the file to try anew") from None


def _evaluation(row: dict[str, str], axes: Sequence[Axis], goals: Goals) -> Evaluation:
    readings = {}
    for q in goals.quantities if row["state"] == "done" else ():
        cells = [row[name] for name in (q.path, f"{q.path} half_width_95_rerun", f"{q.path} half_width_95")]
        numbers = [float(cell) if cell else None for cell in cells]
        readings[q.path] = None if numbers[0] is None else Reading(*numbers)
    if row["state"] not in STATES:
        raise ValueError(f"state {row['state']}")
    values = {axis.key: _value(row[axis.key], axis) for axis in axes}
    return Evaluation(int(row["number"]), values, row["state"], readings, float(row["wall_s"]), row["cause"])


def _value(text: str, axis: Axis) -> object:
    if axis.kind == "choice":
        return next(choice for choice in axis.choices if str(choice) == text)
    return int(text) if axis.kind == "int" else float(text)
