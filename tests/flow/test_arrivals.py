"""Arrivals: Poisson in count, uniform over the jet, the same bits everywhere, refused when they cannot be drawn."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow import arrivals
from glue.scene import model

REPO = Path(__file__).parents[2]


def radius_of(shots, scene):
    """Distance of each shot from the jet's axis at its own crossing of the exit plane."""
    d = np.array(scene.nozzle.direction)
    p = np.stack([shots["x_m"], shots["y_m"], shots["z_m"]], axis=1) + scene.nozzle.stand_off_m * d
    assert np.abs(p @ d).max() < 1e-16, "not on the exit plane"
    return np.linalg.norm(p, axis=1)


def test_counts_are_poisson(make_scene):
    scenes = [make_scene(seed=s, exposure_time_s=0.005) for s in range(400)]
    counts = np.array([len(arrivals.draw_arrivals(s)) for s in scenes])
    expected = scenes[0].expected_shots
    assert expected == pytest.approx(102.0, rel=1e-3)  # 5 kg/min over 4.084e-6 kg, for 5 ms
    assert abs(counts.mean() - expected) < 3 * math.sqrt(expected / 400)
    # variance over mean is 1 with standard deviation sqrt(2/399) = .071; regular arrivals would give .0004
    assert abs(counts.var(ddof=1) / counts.mean() - 1.0) < 3 * 0.071


def test_times_are_uniform_over_the_fixed_horizon(make_scene):
    scene = make_scene(exposure_time_s=0.5)
    times = arrivals.draw_arrivals(scene)["time_s"]
    assert np.all(np.diff(times) > 0) and 0 <= times[0] and times[-1] < 0.5
    grid = np.arange(1, len(times) + 1) / len(times)
    assert np.abs(times / 0.5 - grid).max() < 1.63 / math.sqrt(len(times))  # Kolmogorov, 1 %


def test_uniform_over_the_disc_means_two_thirds_of_the_radius(make_scene):
    scene = make_scene(exposure_time_s=1.0)
    r = radius_of(arrivals.draw_arrivals(scene), scene) / 0.010
    assert len(r) > 20_000 and r.max() < 1.0
    assert r.mean() == pytest.approx(2.0 / 3.0, abs=3 * 0.2357 / math.sqrt(len(r)))  # sd of r/R is 1/sqrt(18)
    assert (r**2).mean() == pytest.approx(0.5, abs=3 * 0.2887 / math.sqrt(len(r)))


def test_oblique_jet_leaves_a_tilted_disc_towards_the_origin(make_scene):
    scene = make_scene(impact_angle_deg=30.0)
    shots = arrivals.draw_arrivals(scene)
    assert radius_of(shots, scene).max() < 0.010
    assert set(shots["vx_m_s"]) == {60.0 * scene.nozzle.direction[0]}
    assert set(shots["vz_m_s"]) == {60.0 * scene.nozzle.direction[2]} and set(shots["vy_m_s"]) == {0.0}
    assert shots["z_m"].mean() == pytest.approx(0.05, abs=0.001) and shots["x_m"].mean() < 0


def test_size_distribution(make_scene):
    scene = make_scene(size="distribution", size_cv=0.1, exposure_time_s=1.0)
    d = arrivals.draw_arrivals(scene)["diameter_m"]
    assert d.min() >= 0.75e-3 and d.max() <= 1.25e-3
    assert scene.smallest_diameter_m == pytest.approx(0.75e-3)
    assert d.mean() == pytest.approx(1e-3, abs=3 * 1e-4 / math.sqrt(len(d)))
    assert d.std() == pytest.approx(1e-4 * math.sqrt(0.91125), rel=0.02)  # variance left by the cut at 2.5 sd


def test_seed_decides_and_sizes_do_not_move_the_times(make_scene):
    one = arrivals.draw_arrivals(make_scene())
    assert one.tobytes() == arrivals.draw_arrivals(make_scene()).tobytes()
    assert one.tobytes() != arrivals.draw_arrivals(make_scene(seed=2)).tobytes()
    # denser places need redraws: the arrival process itself must stay
    narrow = arrivals.draw_arrivals(make_scene(jet_diameter_m=0.003))
    assert narrow["time_s"].tobytes() == one["time_s"].tobytes()


def test_a_stream_that_cannot_be_placed_is_refused_with_the_reason(make_scene):
    with pytest.raises(InputError, match="too dense.*lower mass_flow_kg_s"):
        arrivals.draw_arrivals(make_scene(jet_diameter_m=1e-3, mass_flow_kg_s=0.5))
    with pytest.raises(InputError, match="shorten exposure_time_s"):
        arrivals.draw_arrivals(make_scene(exposure_time_s=1e6))


def test_file_gives_back_the_same_bits(make_scene, tmp_path):
    scene = make_scene(size="distribution", size_cv=0.1)
    shots = arrivals.draw_arrivals(scene)
    arrivals.write_arrivals(tmp_path / "a.csv", shots, arrivals.scene_hash(scene))
    back, header = arrivals.read_arrivals(tmp_path / "a.csv")
    assert back.tobytes() == shots.tobytes()
    assert header["scene_hash"] == arrivals.scene_hash(scene) != arrivals.scene_hash(make_scene())


DRAW = """
import dataclasses, hashlib
from glue.flow import arrivals
from glue.scene import model
from scenes import bare_scene
scenes = [bare_scene(), bare_scene(size="distribution", size_cv=0.1, mass_flow_kg_s=1.6667, impact_angle_deg=40.0)]
sieve = ((5e-4, 0.0), (6e-4, 0.1), (7.1e-4, 0.4), (8.5e-4, 0.9), (1e-3, 1.0))
for count, pulse in (
    ("poisson", model.Pulse("sinusoidal", 130.0, amplitude=1.0)),
    ("exact_mass", model.Pulse("pulsed", 130.0, duty=0.3)),
):
    scene = bare_scene(
        arrivals=count, pulse=pulse, profile="gaussian", divergence_half_angle_deg=7.0, speed_cv=0.1,
        azimuth_deg=33.0, impact_angle_deg=50.0, aim_m=(0.01, 0.003), exposure_time_s=0.06,
        feed=model.Feed(1.0, 0.013, passes=4, pitch_m=0.002, dwell_s=0.001, direction_deg=20.0),
    )
    media = [
        dataclasses.replace(scene.shots, mass_fraction=0.3, size="distribution", size_cv=0.09),
        dataclasses.replace(scene.shots, mass_fraction=0.5, size="sieve", sieve=sieve),
        dataclasses.replace(scene.shots, mass_fraction=0.2, diameter_m=4e-4),
    ]
    nozzles = (scene.nozzle, dataclasses.replace(scene.nozzle, profile="uniform", azimuth_deg=-120.0, feed=None))
    scenes.append(dataclasses.replace(scene, media=tuple(media), nozzles=nozzles))
for scene in scenes:
    print(hashlib.sha256(arrivals.draw_arrivals(scene).tobytes()).hexdigest(), arrivals.scene_hash(scene))
"""


def test_same_bits_under_debian_python(tmp_path):
    """YADE's interpreter (numpy 1.24) and the virtual environment (numpy 2) draw identical shots."""
    out = set()
    for python in ("/usr/bin/python3", sys.executable):
        env = {
            **os.environ,
            "PYTHONPATH": f"{REPO}:{REPO / 'tests' / 'flow'}",
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        done = subprocess.run([python, "-c", DRAW], env=env, capture_output=True, text=True)
        if python == "/usr/bin/python3" and "No module named 'numpy'" in done.stderr:
            pytest.skip("Debian's python3-numpy is not installed")
        assert done.returncode == 0, done.stderr
        out.add(done.stdout)
    assert len(out) == 1 and len(set(out.pop().split())) == 8


def test_known_first_arrival_of_seed_one(make_scene):
    """First exponential gap from its definition, so that a change of generator cannot pass unseen."""
    shots = arrivals.draw_arrivals(make_scene())
    u = np.random.Generator(np.random.PCG64(np.random.SeedSequence(1).spawn(3)[0])).random()
    scene = make_scene()
    assert shots["time_s"][0] == -math.log1p(-u) / (scene.nozzle.mass_flow_kg_s / scene.shots.mean_mass_kg)


def test_a_stream_that_cannot_be_drawn_is_told_beforehand(make_scene):
    arrivals.check_stream(make_scene())
    with pytest.raises(InputError, match="too dense"):  # one shot wide: Poisson gaps below a diameter happen
        arrivals.check_stream(make_scene(jet_diameter_m=1e-3, mass_flow_kg_s=0.02))
    with pytest.raises(InputError, match="no shot leaves the nozzle: 1e-06 expected, none drawn with seed 1"):
        arrivals.check_stream(make_scene(exposure_time_s=1e-6 * 4.084070449666731e-6 / (5.0 / 60.0)))


def test_the_peak_of_a_pulse_counts(make_scene):
    """5 kg/min fill 0.057 % of the jet's volume, in 1/500 of the time 28 %."""
    assert arrivals.solids_share(make_scene(), 0) == pytest.approx(5 / 60 / (7800 * math.pi * 1e-4 * 60))
    arrivals.check_stream(make_scene(pulse=model.Pulse("pulsed", 10.0, duty=0.02)))
    with pytest.raises(InputError, match="too dense: shots fill 28.3% of the jet of nozzle 1 at its densest"):
        arrivals.check_stream(make_scene(pulse=model.Pulse("pulsed", 10.0, duty=0.002)))


def test_a_large_stream_is_tried_in_part(make_scene, monkeypatch):
    drawn, draw = [], arrivals.draw_arrivals
    monkeypatch.setattr(arrivals, "draw_arrivals", lambda scene: drawn.append(draw(scene)) or drawn[-1])
    pulse = model.Pulse("sinusoidal", 0.01, amplitude=1.0)  # begins at its mean and takes 25 s to its peak
    arrivals.check_stream(make_scene(exposure_time_s=90.0, pulse=pulse, arrivals="exact_mass"))
    (trial,) = drawn
    assert 5_000 < len(trial) < 20_000
    rate_1_s = len(trial) / trial["time_s"][-1]
    assert rate_1_s == pytest.approx(2 * 20_404.5, rel=0.05)  # at the peak, twice the mean
    with pytest.raises(InputError, match="shorten exposure_time_s"):
        arrivals.check_stream(make_scene(exposure_time_s=3600.0))


def test_a_large_narrow_stream_is_refused_by_its_trial(make_scene):
    """Shots 0.72 of the jet's width pass each other nowhere; their solids share is only 3 %."""
    scene = make_scene(jet_diameter_m=1.1e-3, diameter_m=0.8e-3, mass_flow_kg_s=0.013, exposure_time_s=100.0)
    assert arrivals.solids_share(scene, 0) < 0.05
    with pytest.raises(InputError, match="too dense.*after .* draws"):
        arrivals.check_stream(scene)
