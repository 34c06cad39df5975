"""The benchmarks' own parts: the LIGGGHTS case is the same stream, samples obey their rules, cheap cases pass."""

import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "flow")]

import collision_fit
import liggghts_case
from scenes import bare_scene

from glue.flow import regime
from glue.flow.arrivals import draw_arrivals

DT_S = 1e-7


def test_liggghts_gets_every_shot_where_its_flight_has_it():
    scene = bare_scene(exposure_time_s=0.004)
    arrivals = draw_arrivals(scene)
    text = liggghts_case.script(scene, arrivals, dt_s=DT_S, window_s=0.003, skin_m=0.003)
    placed = np.array(re.findall(r"create_atoms 1 single (\S+) (\S+) (\S+)", text), float)
    due = arrivals[arrivals["time_s"] < 0.003]
    assert len(placed) == len(due) > 40
    late = due["time_s"] % 0.5e-3  # a batch is half a millisecond: so long before the exit plane
    assert placed[:, 2] == pytest.approx(0.1 + 60.0 * late)
    assert placed[:, 0] == pytest.approx(due["x_m"], abs=1e-12)
    assert text.count("\nrun 5000") == 6
    assert "coefficientRestitution peratomtypepair 2 0.8 0.6 0.6 0.6" in text  # shot-shot, then on the target


def test_liggghts_case_refuses_what_it_does_not_write():
    with pytest.raises(ValueError, match="straight nozzle"):
        liggghts_case.script(bare_scene(impact_angle_deg=45.0), None, dt_s=DT_S, window_s=0.01, skin_m=0.003)


def stand_in(monkeypatch, tmp_path, code):
    program = tmp_path / "liggghts"
    program.write_text(f"#!{sys.executable}\n{code}\n")
    program.chmod(0o755)
    monkeypatch.setattr(liggghts_case, "available", lambda: str(program))


def test_cost_counts_the_steady_part_only(monkeypatch, tmp_path):
    lines = [
        f"Loop time of {s} on 1 procs for 100 steps with {n} atoms" for s, n in ((9, 1), (1, 50), (3, 70))
    ]
    stand_in(monkeypatch, tmp_path, "\n".join(f"print({line!r})" for line in lines))
    cost = liggghts_case.run(tmp_path / "out", "x\nrun 1\nrun 1\nrun 1\n", dt_s=DT_S, skip=1)
    assert cost.step_s == pytest.approx(4.0 / 200)
    assert cost.live_shots == 60.0
    assert cost.per_peening_s == pytest.approx(cost.step_s / DT_S)


def test_a_run_that_stops_early_is_an_error(monkeypatch, tmp_path):
    stand_in(
        monkeypatch, tmp_path, "print('Loop time of 1 on 1 procs for 100 steps with 5 atoms\\nERROR: lost')"
    )
    with pytest.raises(RuntimeError, match="ERROR: lost"):
        liggghts_case.run(tmp_path / "out", "x\nrun 1\nrun 1\n", dt_s=DT_S, skip=0)


def test_sampled_scenes_obey_their_rules():
    scenes = collision_fit.drawn_scenes(5, 12)
    angles = {s.nozzle.impact_angle_deg for s, _ in scenes}
    assert 90.0 in angles and min(angles) >= 30.0 and len(angles) > 6
    for scene, e in scenes:
        pi_eff = regime.first_order_collisions(scene, e)
        assert collision_fit.PI_RANGE[0] <= pi_eff <= collision_fit.PI_RANGE[1]
        assert scene.expected_shots <= collision_fit.MAX_SHOTS * (1.0 + 1e-9)
        assert scene.exposure_time_s >= 49.9 * collision_fit.transit_s(scene.nozzle, e)


def test_the_fit_finds_the_constants_of_made_up_samples():
    wanted = {
        "CASCADE": 3.0,
        "CASCADE_POWER": 0.7,
        "THINNING": 1.5,
        "ENERGY_LOSS": 0.8,
        "ENERGY_LOSS_ENDS": 0.6,
    }
    samples = []
    for scene, e in collision_fit.drawn_scenes(6, 30):
        pi = regime.first_order_collisions(scene, e)
        sine = math.sin(math.radians(scene.nozzle.impact_angle_deg))
        again = 3.0 * regime.crossing_number(scene) ** 0.7 * sine**2 / math.sqrt(e)
        n = pi * (1.0 + again) / (1.0 + 1.5 * pi * sine**4)
        samples.append(collision_fit.Sample(scene, e, pi, n, 0.8 * n / (1.0 + 0.6 * n), 0.0))
    assert collision_fit.fit(samples) == pytest.approx(wanted, rel=1e-4)


def test_mixed_media_case_passes(tmp_path):
    done = subprocess.run(
        [sys.executable, HERE / "bench_flow.py", "--only", "mixed", "--json", tmp_path / "flow.json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("PASS") == 5
    assert (tmp_path / "flow.json").exists()
