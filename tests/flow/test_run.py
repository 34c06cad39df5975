"""run_flow: the model that was chosen runs, on arrivals drawn once, and what cannot be is refused."""

from __future__ import annotations

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import bare_scene

from glue.errors import InputError, NotConverged
from glue.flow import run as flow_run
from glue.flow.arrivals import draw_arrivals, read_arrivals, scene_hash
from glue.flow.impacts import COLUMNS, normal_speed_m_s, read_impacts
from glue.flow.log_checks import log_problems
from glue.flow.restitution import RestitutionLaw
from glue.flow.run import check_law, run_flow
from glue.flow.surface import TargetSurface
from glue.scene.effects import Gravity
from glue.scene.model import Choice, Models, SpotHardening, Surface

LAW = RestitutionLaw(0.6, 60.0, 0.25)


def scene_of(flow, **changes):
    """The reference scene with models.flow as asked; 20 ms of it are 400 shots."""
    scene = bare_scene(**changes)
    other = Choice("auto", "test")
    return dataclasses.replace(scene, models=Models(Choice(flow, "test"), other, other))


def go(scene, out, law=LAW, **options):
    return run_flow(scene, out / "scene.toml", out, law=law, **options)


def test_a_ballistic_run_leaves_arrivals_log_and_record(tmp_path):
    scene = scene_of("ballistic", mass_flow_kg_s=0.001, exposure_time_s=0.1)
    found = go(scene, tmp_path)
    arrivals, header = read_arrivals(found.arrivals_path)
    assert header["scene_hash"] == scene_hash(scene) and len(arrivals) > 15
    log, header = read_impacts(found.impacts_path)
    assert log.tobytes() == found.impacts.tobytes() and len(log) == len(arrivals)
    assert header["scene_hash"] == scene_hash(scene) and header["model"] == "ballistic"
    assert RestitutionLaw.from_dict(header["restitution"]) == LAW
    info = json.loads((tmp_path / "flow.json").read_text())
    assert info == json.loads(json.dumps(found.info))
    for key in ("model", "why", "warnings", "collision_number", "impacts", "mean_normal_speed_m_s",
                "collided_fraction", "mean_normal_energy_fraction", "wall_s", "arrived", "dropped",
                "shot_shot_collisions", "mass_fed_kg"):  # fmt: skip
        assert key in info, key
    assert (info["mean_normal_speed_m_s"], info["collided_fraction"]) == (pytest.approx(60.0, rel=1e-12), 0.0)
    assert info["mean_normal_energy_fraction"] == pytest.approx(1.0, rel=1e-12)


def test_ballistic_where_shots_meet_warns(tmp_path):
    """5 kg/min: Pi .907 by the formula in regime.py."""
    found = go(scene_of("ballistic"), tmp_path)
    assert found.info["collision_number"] == pytest.approx(0.907, rel=0.01)
    assert "ballistic" in found.info["warnings"][0] and "event" in found.info["warnings"][0]


def test_event_and_ballistic_run_on_the_same_shots(tmp_path):
    """At 2 kg/min 14 % of the shots meet another (YADE); shots that met none strike where they were aimed."""
    scene = scene_of("event", mass_flow_kg_s=2 / 60, exposure_time_s=0.05)
    event = go(scene, tmp_path / "event")
    ballistic = go(dataclasses.replace(scene, models=scene_of("ballistic").models), tmp_path / "ballistic")
    assert event.info["model"] == "event" and event.info["shot_shot_collisions"] > 0
    alone = event.impacts[event.impacts["collisions_before"] == 0]
    first = alone[np.unique(alone["shot_id"], return_index=True)[1]]
    straight = ballistic.impacts[np.argsort(ballistic.impacts["shot_id"])][first["shot_id"]]
    assert 0.7 < len(first) / len(ballistic.impacts) < 0.97
    assert np.abs(first["x_m"] - straight["x_m"]).max() < 1e-9
    assert np.abs(first["time_s"] - straight["time_s"]).max() < 1e-10
    assert event.info["arrived"] == ballistic.info["arrived"] == len(draw_arrivals(scene))


def test_auto_takes_what_the_preset_accepts(tmp_path):
    sparse = scene_of("auto", mass_flow_kg_s=2e-5, exposure_time_s=0.5)
    assert go(sparse, tmp_path / "a").info["model"] == "ballistic"
    dense = dataclasses.replace(
        scene_of("auto", exposure_time_s=0.01), accuracy=dataclasses.replace(sparse.accuracy, flow_tolerance=0.02)
    )
    found = go(dense, tmp_path / "b").info
    assert found["model"] == "event" and "tolerance 0.02" in found["why"]


def test_gravity_on_auto_is_decided_by_its_number(tmp_path):
    """2 g H / v^2 = 5e-4 at 60 m/s and 100 mm, over half the tolerance of 5e-3 only at 10 m/s (.02)."""
    for speed, on in ((60.0, "off"), (10.0, "on")):
        scene = scene_of(
            "ballistic", mass_flow_kg_s=0.001, exposure_time_s=0.05, speed_m_s=speed, gravity=Gravity(9.81, auto=True)
        )
        found = go(scene, tmp_path / on)
        assert found.info["physics"]["gravity"]["model"] == on
        faster = math.sqrt(speed**2 + 2 * 9.81 * 0.1 * (on == "on"))  # less its radius of fall
        assert found.info["mean_normal_speed_m_s"] == pytest.approx(faster, rel=1e-4)


def test_a_cylinder_has_its_own_normals(tmp_path):
    scene = scene_of("ballistic", mass_flow_kg_s=0.005, exposure_time_s=0.05)
    round_target = dataclasses.replace(scene.target, surface=Surface("cylinder", 0.015, "y"))
    impacts = go(dataclasses.replace(scene, target=round_target), tmp_path).impacts
    # a shot that falls at x touches where the normal leans by asin(x/(R + r)): v n = v cos
    lean = impacts["nx"]
    assert impacts["x_m"] == pytest.approx(0.015 * lean, abs=1e-12)
    assert normal_speed_m_s(impacts) == pytest.approx(60.0 * np.sqrt(1 - lean**2), rel=1e-9)
    assert lean.max() > 0.5


def test_arrivals_of_a_stopped_run_are_used_again(tmp_path):
    scene = scene_of("ballistic", mass_flow_kg_s=0.001, exposure_time_s=0.05)
    first = go(scene, tmp_path)
    first.arrivals_path.touch()
    before = first.arrivals_path.stat().st_mtime_ns
    again = go(scene, tmp_path, go_on=True)
    assert first.arrivals_path.stat().st_mtime_ns == before
    assert again.impacts.tobytes() == first.impacts.tobytes()
    text = first.arrivals_path.read_text()
    first.arrivals_path.write_text(text[: len(text) // 2])  # stopped in writing
    assert go(scene, tmp_path, go_on=True).impacts.tobytes() == first.impacts.tobytes()
    assert first.arrivals_path.read_text() == text


def test_a_stopped_event_run_goes_on_to_the_same_log(tmp_path, monkeypatch):
    """Stopped at a third: the log so far stays; gone on with, it ends as if it had never been stopped, bit for bit."""
    scene = scene_of("event", exposure_time_s=0.3)
    whole = go(scene, tmp_path / "whole")

    import glue.flow.event_driven as event

    calls, clock = [], SimpleNamespace(monotonic=lambda: 2.0 * len(calls))  # so that it tells its progress each time

    def check():
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt

    monkeypatch.setattr(event, "stopping", SimpleNamespace(check=check))
    monkeypatch.setattr(event, "time", clock)
    with pytest.raises(KeyboardInterrupt):
        go(scene, tmp_path / "stopped")
    part, _ = read_impacts(tmp_path / "stopped" / "impacts.csv.part", allow_truncated=True)
    assert 0 < len(part) < len(whole.impacts) and part.tobytes() == whole.impacts[: len(part)].tobytes()
    told = []
    again = go(scene, tmp_path / "stopped", go_on=True, progress=lambda share, text: told.append(share))
    assert again.impacts.tobytes() == whole.impacts.tobytes()
    assert (tmp_path / "stopped" / "impacts.csv").read_bytes() == (tmp_path / "whole" / "impacts.csv").read_bytes()
    first = json.loads((tmp_path / "whole" / "flow.json").read_text())
    assert again.info["shot_shot_collisions"] == first["shot_shot_collisions"]
    assert told[0] > len(part) / len(whole.impacts) * 0.9  # not from the beginning
    assert sorted(p.name for p in (tmp_path / "stopped").iterdir()) == ["arrivals.csv", "flow.json", "impacts.csv"]


@pytest.mark.parametrize("law", [RestitutionLaw(0.97, largest=1.0),
                                 RestitutionLaw(0.6, largest=1.0, hardening=SpotHardening(0.97, 3.0), spot_radius_m=1e-4)])  # fmt: skip
def test_only_contacts_have_a_highest_restitution(law):
    with pytest.raises(InputError, match="0.970: models.flow = dem"):
        check_law(law, "dem")
    check_law(law, "event")
    check_law(RestitutionLaw(1.0), "dem")


def test_bad_input_needs_no_solver(tmp_path, stub):
    stub("PEEN_YADE", "raise SystemExit('must not run')")
    with pytest.raises(InputError, match="too dense"):
        go(scene_of("dem", jet_diameter_m=1e-3, mass_flow_kg_s=0.5), tmp_path)


def test_a_log_that_cannot_be_is_not_written(tmp_path, monkeypatch):
    def broken(model, checkpoint, progress, go_on):
        def run(scene, arrivals, law, shape, on_impacts):
            from glue.flow.ballistic import run_ballistic

            impacts, info = run_ballistic(scene, arrivals, law, shape)
            impacts["vz_out_m_s"] *= 2.0
            on_impacts(impacts)
            return impacts, info

        return run

    monkeypatch.setattr(flow_run, "_compiled", broken)
    with pytest.raises(NotConverged, match="with more energy after than before"):
        go(scene_of("ballistic", exposure_time_s=0.005), tmp_path)
    assert not (tmp_path / "impacts.csv").exists() and not (tmp_path / "flow.json").exists()
    assert len(read_impacts(tmp_path / "impacts.csv.part", allow_truncated=True)[0]) > 50  # kept, to look into


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda i: i["time_s"].sort(), None),
        (lambda i: i["time_s"].__setitem__(3, np.nan), "time_s: not finite"),
        (lambda i: i["time_s"].__setitem__(3, 9.0), "earlier than the one before"),
        (lambda i: i["time_s"].__setitem__(0, 0.0), "before the shot left"),
        (lambda i: i["shot_id"].__setitem__(0, 10**6), "never left a nozzle"),
        (lambda i: i["diameter_m"].__setitem__(0, 2e-3), "another size"),
        (lambda i: i["vz_in_m_s"].__setitem__(0, 1.0), "out of the target"),
        (lambda i: i["vz_in_m_s"].__setitem__(0, -121.0), "faster than"),
        (lambda i: i["z_m"].__setitem__(0, 1e-6), "away from the target"),
        (lambda i: i["wx_out_rad_s"].__setitem__(0, 1e6), "more energy"),
    ],
)
def test_each_check_of_the_log_can_fail(change, says):
    from glue.flow.ballistic import run_ballistic

    scene = scene_of("ballistic", exposure_time_s=0.002)
    arrivals = draw_arrivals(scene)
    impacts = run_ballistic(scene, arrivals, LAW, TargetSurface())[0]
    assert log_problems(scene, arrivals, impacts, TargetSurface()) == []
    change(impacts)
    problems = log_problems(scene, arrivals, impacts, TargetSurface())
    assert any(says in p for p in problems) if says else problems == []


def test_shots_that_are_thrown_back_again_and_again_are_told():
    log = np.zeros(70, COLUMNS)
    log["shot_id"] = np.arange(70) % 20
    assert "3.5 impacts per shot" in flow_run._warnings(log)[0]
    assert flow_run._warnings(log[:60]) == [] == flow_run._warnings(log[:0])
