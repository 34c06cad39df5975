"""Whole runs of event-driven and ballistic scenes through coverage and surface; only the dimple is a stand-in."""

from __future__ import annotations

import dataclasses
import json
import math
import struct

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.impacts import read_impacts
from glue.report.page import write_report
from glue.scene.reader import read_scene
from glue.study import pipeline
from glue.study.stage import Stage
from glue.study.stages import STAGES
from glue.target.dimple import Dimple

SCENE = """
schema = 1
name = "small"
seed = 3
exposure_time_s = 0.2
[shots]
grade = "S390"
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = {flow}
jet_diameter_m = 0.008
stand_off_m = 0.05
impact_angle_deg = 90.0
{nozzle}
[target]
material = "al2024-t351"
window_m = [0.003, 0.003]
{target}
[restitution]
shot_target = "from_dimple"
[models]
flow = "{model}"
[accuracy]
preset = "fast"
"""
FEED = "feed_speed_m_s = 0.06\nfeed_direction_deg = 0.0\nstroke_m = 0.013\npasses = 2\ndwell_s = 0.0\n"


def dimple() -> Dimple:
    """The reference impact in round numbers: a dent 50 um deep, .22 mm wide, with a small rim."""
    r = np.linspace(0.0, 1.2e-3, 200)
    one = np.zeros(1)
    z = np.where(r < 0.22e-3, -50e-6 * (1 - (r / 0.22e-3) ** 2), 8e-6 * np.exp(-r / 0.2e-3) * (r - 0.22e-3) / 0.1e-3)
    return Dimple(
        radius_m=0.22e-3, depth_m=50e-6, crest_radius_m=0.25e-3, restitution=0.34, peak_force_N=261.0,
        contact_time_s=2.1e-6, speed_m_s=60.0, diameter_m=1e-3, density_kg_m3=7800.0, speed_exponent=0.47,
        restitution_exponent=0.25, edge_peeq=0.2, largest_peeq=0.4, energy_error=0.0, dofs=1, wall_s=0.0,
        profile_r_m=r, profile_z_m=z, layer_depth_m=one, layer_stress_Pa=one,
        points_m=np.array([[0.0, 0.0], [2e-3, 0.0], [0.0, -2e-3]]), triangles=np.array([[0, 1, 2]]),
        peeq=np.array([0.1]), sigma_rr_Pa=one,
    )  # fmt: skip


@pytest.fixture
def go(tmp_path):
    """go(model, nozzle="", target="", flow=...): runs dimple (stand-in), flow, coverage, surface; (run, metrics)."""

    def stand_in(work):
        dimple().save(work.path / "dimple" / "dimple.npz")
        return {"dimple": {"radius_m": 0.22e-3}}, ["dimple/dimple.npz"]

    def run(model, nozzle="", target="", flow=0.01, name="run"):
        scene = SCENE.format(model=model, nozzle=nozzle, target=target, flow=flow)
        if "feed_speed" in nozzle:
            scene = scene.replace("exposure_time_s = 0.2\n", "")
        (tmp_path / "scene.toml").write_text(scene)
        chosen = {s.name: s for s in STAGES}
        stages = (
            Stage("dimple", (), (), ("dimple",), stand_in),
            *(dataclasses.replace(chosen[n], code=()) for n in ("flow", "coverage", "surface")),
        )
        out = pipeline.run(str(tmp_path / "scene.toml"), tmp_path / name, stages=stages)
        return out, json.loads((out / "metrics.json").read_text())

    return run


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


def box(size, top=0.0, tilt=0.0):
    """Triangles (12, 3, 3) of a box below z = ``top``, outwards, turned by ``tilt`` about y through the origin."""
    s = size / 2
    v = np.array([(x, y, z) for x in (-s, s) for y in (-s, s) for z in (top - size, top)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    c, n = math.cos(tilt), math.sin(tilt)
    turned = v @ np.array([[c, 0, n], [0, 1, 0], [-n, 0, c]])
    return np.array([turned[list(t)] for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))])


def write_stl(path, triangles):
    with open(path, "wb") as f:
        f.write(b"\0" * 80 + struct.pack("<I", len(triangles)))
        for t in triangles:
            n = np.cross(t[1] - t[0], t[2] - t[0])
            f.write(struct.pack("<12fH", *(n / np.linalg.norm(n)), *t.ravel(), 0))


STL = '[target.surface]\nkind = "stl"\nfile = "{}"'


def test_the_stl_goes_with_the_run(go, tmp_path):
    """A block with a flat top is a plane; its file is copied, so that the run directory is complete."""
    (tmp_path / "parts").mkdir()
    write_stl(tmp_path / "parts" / "block.stl", box(0.02))
    out, found = go("ballistic", target=STL.format("parts/block.stl"))
    plane = go("ballistic", name="plane")[1]
    assert (out / "block.stl").read_bytes() == (tmp_path / "parts" / "block.stl").read_bytes()
    assert found["flow"]["impacts"] == plane["flow"]["impacts"]
    assert found["coverage"]["final"] == pytest.approx(plane["coverage"]["final"], abs=1e-3)
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
