"""The stability map: an error planted on purpose turns its cell red; a short version of the map itself."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "target")]

import cells_contact
import cells_dent
import cells_stream
import cells_surface
import run
from grid import ORDINARY, Cell, cells
from helpers import reduced
from judges import REFUSED, RIGHT, WRONG, Verdict, at_most, judge, near

from glue.errors import InputError, NotConverged, SolverFailed
from glue.target import dimple

FEW = {"shots": 30}


def scaled(function, column: str, factor: float):
    """``function`` of the flow, its impacts' ``column`` off by ``factor``."""

    def planted(*arguments, **options):
        impacts, info = function(*arguments, **options)
        impacts[column] *= factor
        return impacts, info

    return planted


@pytest.mark.parametrize("column, factor", [("vz_out_m_s", 1.001), ("time_s", 1.0 + 1e-9), ("vz_in_m_s", 0.999), ("wy_out_rad_s", 1.5)])
@pytest.mark.parametrize("model", ["run_event", "run_ballistic"])
def test_an_error_planted_in_the_stream_is_red(monkeypatch, model, column, factor):
    oblique = FEW | {"angle_deg": 45.0, "flow_kg_min": 0.01, "e": 0.94}
    assert judge(lambda: cells_stream.stream(oblique)).verdict == RIGHT
    monkeypatch.setattr(cells_stream, model, scaled(getattr(cells_stream, model), column, factor))
    assert judge(lambda: cells_stream.stream(oblique)).verdict == WRONG


def test_a_lost_shot_is_red(monkeypatch):
    whole = cells_stream.run_ballistic
    monkeypatch.setattr(cells_stream, "run_ballistic", lambda *a: (whole(*a)[0][1:], whole(*a)[1]))
    assert judge(lambda: cells_stream.stream(FEW)).verdict == WRONG


def dented():
    """A parabolic dent of radius .45 R with a pile-up, on points that all carry the same stress."""
    r = np.linspace(0.0, 2.0, 81)
    z = np.where(r < 0.45, -0.1 * (1.0 - (r / 0.45) ** 2), 0.01 * np.exp(-(r - 0.45)))
    gr, gz = (v.ravel() for v in np.meshgrid(np.linspace(0.01, 2.0, 30), -np.linspace(0.01, 3.0, 30)))
    one = np.ones(gr.size)
    points = {"r": gr, "z": gz, "u_r": 0 * one, "u_z": 0 * one, "volume": one, **{k: -one for k in ("s_rr", "s_zz", "s_tt", "s_rz")},
              "peeq": 0.1 * one}  # fmt: skip
    return dataclasses.replace(reduced(r, z, points), triangles=np.zeros((gr.size // 3, 3, 2)))


def test_a_radius_misread_is_red(monkeypatch):
    assert judge(lambda: cells_dent.reading(dented(), 60.0, 1e-3)).verdict == RIGHT
    read = dimple.zero_height_radius
    monkeypatch.setattr(dimple, "zero_height_radius", lambda impact: 1.01 * read(impact))
    found = judge(lambda: cells_dent.reading(dented(), 60.0, 1e-3))
    assert found.verdict == WRONG and "height 0" in found.text


@pytest.mark.parametrize("case", ["one", "on the edge", "in the corner", "ten coincident", "ellipse", "random"])
def test_a_dimple_counted_too_large_is_red(monkeypatch, case):
    values = {"case": case, "radius": 0.03 if case == "random" else 0.1, "points": 20, "exposure": 1.0}
    assert judge(lambda: cells_surface.coverage(values)).verdict == RIGHT
    count = cells_surface.coverage_history
    monkeypatch.setattr(cells_surface, "coverage_history", lambda x, y, t, a, b, *rest: count(x, y, t, 1.25 * np.array(a), 1.25 * np.array(b), *rest))
    assert judge(lambda: cells_surface.coverage(values)).verdict == WRONG


@pytest.mark.parametrize("shape", ["step", "ramp", "wave"])
def test_a_plate_not_let_go_is_red(monkeypatch, shape):
    values = {"shape": shape, "thickness_m": 1e-3, "layer_m": 1e-4, "points": 50}
    assert judge(lambda: cells_surface.plate(values)).verdict == RIGHT
    monkeypatch.setattr(cells_surface, "released_stress", lambda z, s, h: s)
    assert judge(lambda: cells_surface.plate(values)).verdict == WRONG


def answer(e: float, force: float = 100.0) -> dict:
    pair = {"e": [e, e], "force_N": [force] * 2, "duration_s": [2e-6] * 2, "hertz_force_N": 100.0, "hertz_duration_s": 2e-6}
    return {"id": "a", "found": {"dt_s": 1e-8, "steps": 100.0, "target": pair, "shot": pair | {"e": [0.8, 0.8]}}}


def test_contacts_that_rebound_or_push_otherwise_are_red():
    assert cells_contact.judge_answer(answer(0.6), {"e": 0.6}).verdict == RIGHT
    assert cells_contact.judge_answer(answer(0.604), {"e": 0.6}).verdict == WRONG
    assert cells_contact.judge_answer(answer(1.0), {"e": 1.0}).verdict == RIGHT
    assert cells_contact.judge_answer(answer(1.0, 101.0), {"e": 1.0}).verdict == WRONG
    assert cells_contact.judge_answer({"id": "a", "error": "boom"}, {}).verdict == WRONG


def raising(problem: Exception):
    def solve():
        raise problem

    return solve


def test_what_counts_as_a_refusal():
    for problem in (InputError("speed_m_s: 900 is out of range; allowed 0.5..300 m/s"), NotConverged("x", advice="limit 0.5 %")):
        assert judge(raising(problem)).verdict == REFUSED
    for problem in (InputError("no"), InputError("not allowed"), SolverFailed("FreeFem++ failed, allowed 3"), ValueError("allowed 1")):
        assert judge(raising(problem)).verdict == WRONG


def test_nothing_judged_and_no_number_are_red():
    assert judge(lambda: []).verdict == WRONG
    assert judge(lambda: [at_most("a", float("nan"), 1.0)]).verdict == WRONG
    assert judge(lambda: [near("a", [1.0, float("nan")], 1.0, 1.0)]).verdict == WRONG


def test_a_refusal_inside_normal_use_is_red():
    refused = Verdict(REFUSED, "allowed 1 to 2", [])
    inside, outside = (Cell("stream", "p", "r", str(v), {"speed_m_s": v, "diameter_m": 1e-3}) for v in (60.0, 300.0))
    assert run.ordinary_is_not_refused(inside, refused).verdict == WRONG
    assert run.ordinary_is_not_refused(outside, refused).verdict == REFUSED


def test_the_grid_goes_as_far_as_promised():
    """The ranges of the map's task, past normal use on every axis."""
    everything = cells()
    assert len({c.name for c in everything}) == len(everything) >= run.LEAST_CELLS
    spans = {"diameter_m": (2e-5, 8e-3), "speed_m_s": (1.0, 300.0), "ratio": (1.0, 100.0), "flow_kg_min": (1e-4, 100.0),
             "angle_deg": (5.0, 90.0), "e": (0.05, 1.0), "dt_over_P": (0.01, 12.0), "stiffness": (1e-4, 1.0), "nu": (0.0, 0.49),
             "yield_Pa": (50e6, 3e9), "elements": (1, 4)}  # fmt: skip
    for key, span in spans.items():
        values = [c.values[key] for c in everything if key in c.values]
        assert (min(values), max(values)) == span, key
    cases = {c.values.get("case") for c in everything}
    assert {"none", "no impact", "one", "ten coincident", "on the edge", "in the corner"} <= cases
    assert sum(c.ordinary for c in everything) > 200
    assert ORDINARY["diameter_m"] == (0.1e-3, 5e-3) and ORDINARY["speed_m_s"] == (5.0, 120.0)
    assert ORDINARY["angle_deg"] == (30.0, 90.0) and ORDINARY["e"] == (0.2, 0.94)


def test_verdicts_are_kept_by_their_inputs(tmp_path):
    kept, cell = run.Kept(tmp_path), cells(short=True)[0]
    assert kept.get(cell) is None
    found = Verdict(RIGHT, "all well", [at_most("a", 1.0, 2.0)])
    kept.put(cell, found)
    assert kept.get(cell) == found
    assert kept.get(Cell(cell.family, cell.panel, cell.row, cell.column, cell.values | {"e": 0.7})) is None


@pytest.mark.solver
def test_short_map(tmp_path):
    done = subprocess.run([sys.executable, HERE / "run.py", "--short", "--json", tmp_path / "rows.json", "--picture", tmp_path / "map.png"],
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "map.png").stat().st_size > 5000
