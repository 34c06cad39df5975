"""Whole runs of event-driven and ballistic scenes through coverage and surface; only the dimple is a stand-in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flow_runs import FEED, STL, box, write_stl

from glue.errors import InputError
from glue.flow.impacts import read_impacts
from glue.report.page import write_report
from glue.scene.reader import read_scene
from glue.study.stages import STAGES


def test_an_event_driven_run_needs_no_yade(go, monkeypatch):
    """10 g/s is Pi 1 and more: shots meet; the log, coverage and surface are there, and the report draws them."""
    monkeypatch.setenv("PEEN_YADE", "/nonexistent")
    out, found = go("event")
    flow, coverage = found["flow"], found["coverage"]
    assert flow["model"] == "event" and "the scene asks for it" in flow["why"]
    assert flow["impacts"] > 400 and flow["collided_fraction"] > 0.05 and flow["collision_number"] > 0.5
    assert 30.0 < flow["mean_normal_speed_m_s"] < 60.0
    # Poisson, so the count in the window has the scatter of its root; rebounds come on top
    assert coverage["impacts_in_window"] > 0.7 * 0.2 * 0.01 / 4.084e-6 * 9 / (math.pi * 16)
    assert coverage["final"] == pytest.approx(coverage["avrami_final"], abs=0.05)
    assert found["roughness"]["Sa_m"] > 0.0
    header = read_impacts(out / "flow" / "impacts.csv")[1]
    assert header["model"] == "event" and header["restitution"]["exponent"] == 0.25
    scene = read_scene(out / "scene.toml")
    written = write_report(out, scene, frozenset({"dimple", "flow", "coverage", "surface"}))
    assert "figures/impact_map.png" in written
    assert flow["why"] in (out / "report.html").read_text()


def test_a_ballistic_run_where_shots_meet_warns(go):
    out, found = go("ballistic")
    assert found["flow"]["model"] == "ballistic" and "mean normal energy" in found["flow"]["warning"]
    assert found["flow"]["mean_normal_speed_m_s"] == pytest.approx(60.0)
    assert found["flow"]["mean_normal_energy_fraction"] == pytest.approx(1.0)
    sparse = go("auto", flow=1e-4, name="sparse")[1]["flow"]
    assert sparse["model"] == "ballistic" and "warning" not in sparse


def test_a_traverse_covers_in_steps(go):
    """Two passes over the window: its coverage rises twice, as Avrami with the analytic footprint does."""
    out, found = go("ballistic", nozzle=FEED)
    table = np.genfromtxt(out / "coverage.csv", delimiter=",", names=True)
    passes = 0.013 / 0.06
    between = table["avrami"][np.abs(table["time_s"] - passes) < 0.01]
    assert np.ptp(between) < 0.01  # the jet is off the window when it turns
    first, last = between[0], found["coverage"]["avrami_final"]
    assert 0.2 < first < last and last == pytest.approx(1 - (1 - first) ** 2, abs=0.02)  # equal passes
    gap = np.abs(table["coverage"] - table["avrami"]).max()
    assert gap < 0.08  # one window's scatter
    assert found["coverage"]["avrami_mass_flow_final"] == pytest.approx(last, abs=0.05)


def test_a_cylinder_is_peened_round_its_flank(go):
    out, found = go("ballistic", target='[target.surface]\nkind = "cylinder"\nradius_m = 0.004\naxis = "y"')
    impacts = read_impacts(out / "flow" / "impacts.csv")[0]
    assert np.abs(impacts["nx"]).max() > 0.5
    # v n = v cos a over a jet twice as wide as the cylinder's... a uniform in x/(R + r): mean of the root
    assert found["flow"]["mean_normal_speed_m_s"] == pytest.approx(60.0 * np.sqrt(1 - impacts["nx"] ** 2).mean())
    assert found["coverage"]["final"] == pytest.approx(found["coverage"]["avrami_final"], abs=0.08)


def test_the_stl_goes_with_the_run(go, tmp_path):
    """A block with a flat top is a plane; its file is copied, so that the run directory is complete."""
    (tmp_path / "parts").mkdir()
    write_stl(tmp_path / "parts" / "block.stl", box(0.02))
    out, found = go("ballistic", target=STL.format("parts/block.stl"))
    plane = go("ballistic", name="plane")[1]
    assert (out / "block.stl").read_bytes() == (tmp_path / "parts" / "block.stl").read_bytes()
    assert found["flow"]["impacts"] == plane["flow"]["impacts"]
    assert found["coverage"]["final"] == pytest.approx(plane["coverage"]["final"], abs=1e-3)
    (out / "block.stl").write_bytes(b"damaged")
    assert go("ballistic", target=STL.format("parts/block.stl"))[1] == found  # nothing new, but the copy is whole again
    assert (out / "block.stl").read_bytes() == (tmp_path / "parts" / "block.stl").read_bytes()
    (tmp_path / "parts" / "block.stl").unlink()
    (tmp_path / "parts").rmdir()
    stages = tuple(s for s in STAGES if s.name == "coverage")
    assert stages[0].refuse(read_scene(out / "scene.toml"), out / "scene.toml") is None  # it still finds it


@pytest.mark.parametrize(
    ("triangles", "says"),
    [
        (box(0.02)[:-1], "open"),
        (np.concatenate([box(0.02)[:1, ::-1], box(0.02)[1:]]), "inverted"),
        (box(0.02)[:, ::-1], "inside out"),
        (box(0.02, tilt=math.radians(20.0)), "leans 20.0 degrees"),
    ],
)
def test_a_surface_that_cannot_be_peened_is_refused_before_anything_runs(go, tmp_path, triangles, says):
    write_stl(tmp_path / "bad.stl", triangles)
    with pytest.raises(InputError, match=says):
        go("ballistic", target=STL.format("bad.stl"))
    assert not (tmp_path / "run" / "dimple").exists()
