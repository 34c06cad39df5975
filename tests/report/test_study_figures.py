"""Figures and summary of studies on made-up tables: all are drawn, and say what the tables say."""

from __future__ import annotations

import csv
import math
import struct

import numpy as np
import pytest

from glue.report import study_figures, study_panels
from glue.study.sweep.points import Point, read_points

# axis: (column, values, exponent of the time to 98 %)
AXES = {
    "coverage-mass-flow": ("nozzle.mass_flow_kg_s", (0.001, 0.01), -1.0),
    "coverage-speed": ("nozzle.speed_m_s", (30.0, 60.0), -1.0),
    "coverage-diameter": ("shots.diameter_m", (0.5e-3, 1e-3), 1.0),
    "coverage-angle": ("nozzle.impact_angle_deg", (30.0, 90.0), -1.0),
    "coverage-feed": ("nozzle.feed_speed_m_s", (0.01, 0.02), 0.0), "stress-coverage": ("exposure_time_s", (2.0, 4.0), 0.0),
    "stress-speed": ("nozzle.speed_m_s", (30.0, 60.0), -1.0), "stress-diameter": ("shots.diameter_m", (0.5e-3, 1e-3), 1.0),
    "stress-shots": ("exposure_time_s", (2.0, 4.0), 0.0),
}  # fmt: skip


def make(folder, name, reached=True):
    """A study of two points with two replicates each, whose time to 98 % is a power of the axis, 4 s at the second point."""
    key, values, exponent = AXES[name]
    rows = []
    for point, value in enumerate(values):
        for replicate in (0, 1):
            run, t98 = f"{point}{replicate}", 4.0 * (value / values[1]) ** exponent * (0.95, 1.05)[replicate]
            rows.append({
                "run": run, "state": "done", "point": point, key: value, "nozzle.passes": 4,
                "coverage.final": 0.99 if reached else 0.9,
                "coverage.time_98_s": t98 if reached else "", "coverage.percent": 125.0 if reached else 90.0,
                "coverage.avrami_time_98_s": 0.9 * t98, "coverage.avrami_mass_flow_time_98_s": 0.8 * t98,
                "coverage.avrami_undisturbed_time_98_s": 0.5 * t98, "coverage.avrami_mass_flow_final": 0.95,
                "coverage.impacts_in_window": 100 * (point + 1), "flow.collision_number": 0.1 * (point + 1),
                "residual_stress.max_compressive_Pa": -3e8, "residual_stress.surface_Pa": -2e8,
                "residual_stress.tenth_depth_m": 4e-4, "roughness.Sa_m": 5e-6,
            })  # fmt: skip
            (folder / "runs" / run).mkdir(parents=True)
            t = np.linspace(0.0, 5.0, 20)
            curve = np.c_[t, 1 - np.exp(-t), 1 - np.exp(-1.1 * t)]
            np.savetxt(folder / "runs" / run / "coverage.csv", curve, delimiter=",", header="time_s,coverage,avrami")
    with open(folder / "table.csv", "w", newline="") as f:
        writer = csv.DictWriter(f, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return folder


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studies")
    for name in AXES:
        make(folder / name, name)
    return folder


def test_every_study_gets_its_figure_and_all_of_them_one(studies, capsys):
    assert study_figures.main([str(studies), "--docs", str(studies / "all.png")]) == 0
    told = capsys.readouterr().out.split()
    assert told == [str(studies / name) for name in (*(f"{n}.png" for n in AXES), "summary.md", "all.png")]
    for path in studies.glob("*.png"):
        width, height = struct.unpack(">II", path.read_bytes()[16:24])
        assert width > 1200 and height > 500


def test_the_summary_has_a_row_for_each_point_with_its_scatter(studies):
    text = study_figures.summary({name: read_points(studies / name) for name in ("coverage-mass-flow", "coverage-feed")})
    sd = 0.2 * math.sqrt(2.0)  # of 3.8 and 4.2
    (row,) = [line for line in text.splitlines() if line.startswith("| 10 g/s")]
    assert f"| 4.00 ± {sd:.2f} | 8.00 | 3.60 | 3.20 | 2.00 | 0.200 |" in row and "−300" in row
    assert "| 10 mm/s | 4 |" in text and "passes to 98 %" in text


def test_a_study_that_never_reaches_98_percent_is_drawn_and_has_empty_cells(tmp_path):
    for name in ("coverage-speed", "coverage-feed", "stress-coverage"):
        folder = make(tmp_path / name, name, reached=False)
        assert study_figures.draw_study(name, folder, tmp_path / f"{name}.png").exists()
    text = study_figures.summary({"coverage-speed": read_points(tmp_path / "coverage-speed")})
    assert "t98" not in text and "90.0" in text


def test_passes_are_counted_or_carried_on_by_hits():
    columns = {"nozzle.passes": (4.0,), "coverage.final": (0.8,), "coverage.percent": (80.0,), "coverage.time_98_s": (None,)}
    # 1 - exp(-h) = .8 after 4 passes: ln 50 / ln 5 times as many for 98 %
    assert study_panels.passes_to_full(Point(("a",), columns)).mean == pytest.approx(4 * math.log(50) / math.log(5))
    # 98 % at 8 s of 10 s, of 16 passes: in the 13th
    reached = {"nozzle.passes": (16.0,), "coverage.final": (1.0,), "coverage.percent": (125.0,), "coverage.time_98_s": (8.0,)}
    assert study_panels.passes_to_full(Point(("a",), reached)).mean == 13


def test_lateness_is_over_shots_that_meet_no_other():
    late = study_panels.late(Point(("a", "b"), {study_panels.TIME_98: (2.2, 2.4), study_panels.UNDISTURBED: (2.0, 2.0)}))
    assert late.mean == pytest.approx(0.15) and late.sd == pytest.approx(0.1 / math.sqrt(2.0))


def test_without_tables_the_command_tells(tmp_path, capsys):
    assert study_figures.main([str(tmp_path), "--docs", str(tmp_path / "all.png")]) == 2
    assert "peen sweep" in capsys.readouterr().err
