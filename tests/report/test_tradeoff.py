"""The trade table as text: what is hidden by scatter says so, the front leaves out what another beats."""

from __future__ import annotations

import csv
import io

from glue.report.tradeoff import csv_text, error_text, front, markdown, points_of


def quantity(error, se=0.0, hidden=False):
    return {"value": 2e-4, "error": error, "se": se, "hidden": hidden, "scatter": 0.01}


def row(level, cpu_s, found, factor="mesh", failed=None):
    return {
        "group": "dimple", "stage": "dimple", "factor": factor, "level": level, "physics": False, "seeds": 3, "wall_s": cpu_s,
        "cpu_s": cpu_s, "memory_bytes": 1e8, "failed": failed, "quantities": {} if found is None else {"dimple_radius": found},
    }  # fmt: skip


TABLE = {"scenes": {"made-up": {"scatter": {}, "patches": {}, "rows": [
    row("", 100.0, quantity(None), factor="reference"),
    row("a/3", 1.0, quantity(0.04)), row("a/4", 2.0, quantity(-0.05)), row("a/6", 4.0, quantity(0.001, 0.004, True)),
    row("a/8", None, None, failed="no memory"),
]}}}  # fmt: skip


def test_errors_in_words():
    assert error_text(quantity(0.0123)) == "+1.2 %"
    assert error_text(quantity(-0.0123), points=True) == "−1.2 pt"
    assert error_text(quantity(0.001, 0.004, True)) == "< 0.8 %"
    assert error_text(None) == error_text(quantity(None)) == ""


def test_the_table_has_a_row_for_every_rung_the_failed_one_too():
    text = markdown(TABLE, "made-up")
    assert "| mesh a/6 | 4 | 100 | < 0.8 % |" in text and "mesh a/8 **failed**" in text
    assert "**dimple: reference** (3 seeds) | 100 | 100 | 200.0 µm |" in text


def test_csv_keeps_error_and_scatter_apart():
    rows = {r["level"]: r for r in csv.DictReader(io.StringIO(csv_text(TABLE)))}
    assert rows["a/6"]["hidden_by_scatter"] == "1" and float(rows["a/6"]["standard_error"]) == 0.004
    assert float(rows["a/3"]["error"]) == 0.04 and float(rows["a/3"]["scatter_of_one_run"]) == 0.01
    assert rows["a/8"]["failed"] == "no memory"


def test_the_front_leaves_out_what_is_dearer_and_worse():
    kept = [p[0]["level"] for p in front(points_of(TABLE, "made-up", "dimple_radius"))]
    assert kept == ["a/3", "a/6"]
