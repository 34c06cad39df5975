"""Every shipped scene reads, and does what its comment promises (by the closed-form estimates)."""

from __future__ import annotations

import math

import pytest

from glue.scene.consistency import estimated_dimple_radius_m
from glue.scene.model import Nozzle, Restitution
from glue.scene.reader import example_names, example_path, read_scene

# What each scene's comment says: shots, dimple radius [m], hits per point, time to 98 % [s].
PROMISES = {
    "al2024-s110": (6983, 0.068e-3, 5.2, 0.75),
    "al2024-s390": (12245, 0.227e-3, 6.3, 1.9),
    "al2024-s390-45deg": (18368, 0.19e-3, 4.7, 3.7),
    "own-material": (11898, 0.071e-3, 2.4, 1.65),
    "steel4340-s390": (12245, 0.209e-3, 5.4, 2.2),
}


def test_every_example_has_its_promise():
    assert example_names() == sorted(PROMISES)


@pytest.mark.parametrize("name", PROMISES)
def test_an_example_is_named_after_its_file_and_keeps_its_promise(name):
    scene = read_scene(example_path(name))
    assert scene.name == name
    shots, radius, hits, time_98 = PROMISES[name]
    estimate = estimated_dimple_radius_m(scene.shots, scene.nozzle.normal_speed_m_s, scene.target.material)
    per_point = math.pi * estimate**2 * scene.expected_shots / scene.nozzle.footprint_area_m2
    # Tolerances are those of the rounding in the comments.
    assert scene.expected_shots == pytest.approx(shots, abs=0.5)
    assert estimate == pytest.approx(radius, rel=0.01)
    assert per_point == pytest.approx(hits, abs=0.05)
    assert scene.exposure_time_s * math.log(50.0) / per_point == pytest.approx(time_98, abs=0.05)


@pytest.mark.parametrize("name", ["al2024-s110", "al2024-s390", "al2024-s390-45deg", "steel4340-s390"])
def test_the_main_examples_reach_full_coverage_in_minutes(name):
    """Measured flow cost: 1.1 + .055 N microseconds a step of one P, N the shots in flight (both ways)."""
    scene = read_scene(example_path(name))
    radius = estimated_dimple_radius_m(scene.shots, scene.nozzle.normal_speed_m_s, scene.target.material)
    per_point = math.pi * radius**2 * scene.expected_shots / scene.nozzle.footprint_area_m2
    assert per_point > math.log(50.0) * 1.15  # 98 %, with something in hand for shots slowed by others
    step_s = 0.5 * scene.shots.diameter_m * math.sqrt(scene.shots.density_kg_m3 / scene.shots.E_Pa)
    flight_s = scene.nozzle.stand_off_m / scene.nozzle.speed_m_s * (1.0 + 1.0 / 0.3)  # rebound at e = .3
    cost_s = scene.exposure_time_s / step_s * (1.1e-6 + 0.055e-6 * scene.shot_rate_1_s * flight_s)
    assert cost_s < 240.0


def test_the_default_scene_holds_the_design_values():
    scene = read_scene(example_path("al2024-s390"))
    assert scene.nozzle == Nozzle(60.0, 0.01667, 0.020, 0.10, 90.0)
    assert (scene.seed, scene.exposure_time_s, scene.shots.grade) == (1, 3.0, "S390")
    assert (scene.target.material.key, scene.target.window_m) == ("al2024-t351", (0.004, 0.004))
    assert scene.restitution == Restitution("from_dimple", 0.8)
    assert scene.accuracy.preset == "balanced"


@pytest.mark.parametrize("name", ["", "nothing", "../examples/al2024-s390", "al2024-s390.toml"])
def test_a_name_that_is_no_example(name):
    assert example_path(name) is None
