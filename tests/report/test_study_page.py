"""The report of a study: means over replicates, lines, failures, and what is refused."""

from __future__ import annotations

import csv
import json
import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from study_case import FLOWS, SPEEDS, write_study  # noqa: E402

from glue.errors import InputError  # noqa: E402
from glue.report.plots import Series, _log_ticks, plot  # noqa: E402
from glue.report.study_page import _plots, _series, write_study_report  # noqa: E402


def rows_and_axes(folder):
    rows = list(csv.DictReader(open(folder / "table.csv")))
    return [r for r in rows if r["state"] == "done"], json.loads((folder / "study.json").read_text())["axes"]


def test_replicates_are_averaged_with_students_interval(tmp_path):
    rows, axes = rows_and_axes(write_study(tmp_path))
    series, words = _series(axes[0], axes, rows, "coverage.final", 100.0)
    assert words == [] and [s.label for s in series] == ["40", "60", "80"] and all(s.joined for s in series)
    assert [len(s.x) for s in series] == [4, 4, 3]  # the last setting of 80 m/s was refused
    first = 100.0 * (1.0 - math.exp(-300.0 * FLOWS[0] * SPEEDS[0] / 60.0))
    assert series[0].y[0] == pytest.approx(1.005 * first)
    # two values 1 % apart: s/sqrt(2) is half the difference, Student's t of one degree of freedom 12.706
    assert series[0].bar[0] == pytest.approx(12.706 * 0.005 * first, rel=1e-4)


def test_a_single_run_has_its_own_interval(tmp_path):
    rows, axes = rows_and_axes(write_study(tmp_path))
    series, _ = _series(axes[1], axes, [r for r in rows if r["replicate"] == "0"], "roughness.Sa_m", 1e6)
    assert series[0].bar.tolist() == pytest.approx([1.0] * 3)
    assert series[0].y.tolist() == pytest.approx([20 * s / 60 for s in SPEEDS])


def test_settings_that_differ_in_everything_are_points(tmp_path):
    rows, axes = rows_and_axes(write_study(tmp_path))
    for k, row in enumerate(rows):
        row["nozzle.speed_m_s"] = str(40.0 + k)
    (series,), _ = _series(axes[0], axes, rows, "coverage.final", 1.0)
    assert not series.joined and len(series.x) == len(rows)


def test_an_axis_of_words_gets_places(tmp_path):
    rows, axes = rows_and_axes(write_study(tmp_path))
    for row in rows:
        row["nozzle.speed_m_s"] = {"40.0": "S110", "60.0": "S230", "80.0": "S390"}[row["nozzle.speed_m_s"]]
    series, words = _series(axes[1], axes, rows, "coverage.final", 1.0)
    assert words == ["S110", "S230", "S390"] and series[0].x.tolist() == [0.0, 1.0, 2.0]


def test_the_page_has_all_runs_failures_and_axes(tmp_path):
    html = write_study_report(write_study(tmp_path)).read_text(encoding="utf-8")
    assert "<title>mass flow &amp; speed</title>" in html
    assert "24 runs: 22 done, 1 failed, 1 refused" in html
    assert "shot stream too dense: &lt;20 %" in html and "YADE ended with code 1" in html
    assert html.count("<tr><td class=\"short\">00") == 24 + 2  # once among the runs, once among the failures
    assert "0.005, 0.01, 0.02, 0.04" in html and "mass flow [kg/s]" in html
    assert len(re.findall(r"<svg ", html)) == 4 * 2  # four headline metrics, two axes
    assert "33.0 s" in html  # 22 runs of 1.5 s in the flow


def test_a_study_whose_runs_all_failed_has_a_page(tmp_path):
    folder = write_study(tmp_path)
    rows = list(csv.reader(open(folder / "table.csv")))
    (folder / "table.csv").write_text("run,state,cause\n" + "".join(f"{r[0]},failed,no disk\n" for r in rows[1:]))
    html = write_study_report(folder).read_text(encoding="utf-8")
    assert "24 failed" in html and "<svg " not in html


@pytest.mark.parametrize(("name", "text"), [("study.json", "{"), ("table.csv", "a,b\n1,2\n"), ("table.csv", None)])
def test_a_damaged_folder_is_refused_by_file(tmp_path, name, text):
    folder = write_study(tmp_path)
    (folder / name).unlink() if text is None else (folder / name).write_text(text)
    with pytest.raises(InputError, match=name):
        write_study_report(folder)


def test_points_stand_where_their_numbers_are():
    """Three even points: the middle one halfway between the others in both directions."""
    svg = plot([Series("", np.array([0.0, 1.0, 2.0]), np.array([5.0, 6.0, 7.0]), np.array([np.nan] * 3))], "x", "y")
    dots = re.search(r'd="((?:M[\d.]+ [\d.]+h0)+)"', svg).group(1)
    x, y = np.array([[float(v) for v in dot.split("h")[0].split(" ")] for dot in dots.split("M")[1:]]).T
    assert x[1] == pytest.approx(0.5 * (x[0] + x[2]), abs=0.11) and y[1] == pytest.approx(0.5 * (y[0] + y[2]), abs=0.11)
    assert x[2] > x[0] and y[2] < y[0]  # up is up


def test_one_value_everywhere_still_has_an_axis():
    assert "<svg" in plot([Series("", np.array([1.0, 2.0]), np.array([0.0, 0.0]), np.array([0.0, 0.0]))], "x", "y")


def test_a_logarithmic_axis_spaces_equal_ratios_equally():
    at = Series("", np.array([0.005, 0.01, 0.02]), np.array([5.0, 6.0, 7.0]), np.array([np.nan] * 3))
    svg = plot([at], "x", "y", log=True)
    places = [float(found) for found in re.findall(r"M([\d.]+) [\d.]+h0", svg)]
    assert places[1] - places[0] == pytest.approx(places[2] - places[1], abs=0.2)
    ticks = re.findall(r'text-anchor="middle">([\d.]+)<', svg)
    assert {"0.005", "0.01", "0.02"} <= set(ticks) and len(ticks) <= 8


@pytest.mark.parametrize(("low", "high"), [(0.005, 0.03), (1.0, 1000.0), (59.0, 61.0), (1e-6, 1e3)])
def test_a_logarithmic_axis_has_some_ticks_within_it(low, high):
    ticks = _log_ticks(np.log10(low), np.log10(high))
    assert 3 <= len(ticks) <= 7 and all(low * 0.999 <= t <= high * 1.001 for t in ticks) and len(set(ticks)) == len(ticks)


def test_runs_without_a_value_are_told_and_points_of_another_key_are_not_joined(tmp_path):
    folder = write_study(tmp_path)
    rows, axes = rows_and_axes(folder)
    name = next(column for column in rows[0] if column == "coverage.final")
    together = [{"keys": [key for axis in axes for key in axis["keys"]], "name": "both"}]
    series, _ = _series(together[0], together, rows, name, 1.0)
    assert not any(s.joined for s in series)  # the first key has each value several times
    rows[0] = rows[0] | {name: ""}
    assert f"(of {len(rows) - 1} of {len(rows)} runs, which have it)" in _plots(axes, rows, [name])
