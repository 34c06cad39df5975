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


OWN_TESTS = ("cylinder-s230", "glass-drag", "mixed-s230-s390-traverse", "two-nozzles-pulsed")
SPECIFIED = {"al2024-s230-8a": ("8A", 200.0), "al2024-s230-6-8a": ("6-8A", 200.0), "steel4340-s230-12a": ("12A", 100.0)}


def test_every_example_has_its_promise():
    assert example_names() == sorted((*PROMISES, *OWN_TESTS, *SPECIFIED))


@pytest.mark.parametrize("name", SPECIFIED)
def test_an_example_that_says_what_is_to_come_out(name):
    """What it leads to needs solved impacts: make bench-intensity."""
    scene = read_scene(example_path(name), provisional=True)
    said = scene.specification
    assert (scene.name, said.intensities[0], said.coverage_percent) == (name, *SPECIFIED[name])


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


def hits(scene, per_m2):
    """Hits per point from impacts per area [1/m2] of the whole mixture, by estimated dimples at the normal speed."""
    areas = [
        shots.mass_fraction / shots.mean_mass_kg / scene.shots_per_kg
        * math.pi * estimated_dimple_radius_m(shots, scene.nozzle.normal_speed_m_s, scene.target.material) ** 2
        for shots in scene.media
    ]  # fmt: skip
    return per_m2 * sum(areas)


def test_the_traverse_keeps_its_promise():
    scene = read_scene(example_path("mixed-s230-s390-traverse"))
    small, feed = scene.media[0], scene.nozzle.feed
    assert (scene.exposure_time_s, scene.arrivals) == (pytest.approx(3.2), "exact_mass")
    assert scene.shot_rate_1_s == pytest.approx(4523, abs=0.5)
    assert scene.expected_shots == pytest.approx(14473, abs=0.5)
    assert 0.5 / small.mean_mass_kg / scene.shots_per_kg == pytest.approx(0.82, abs=0.005)
    radii = [estimated_dimple_radius_m(s, scene.nozzle.normal_speed_m_s, scene.target.material) for s in scene.media]
    assert radii == [pytest.approx(0.129e-3, abs=5e-7), pytest.approx(0.213e-3, abs=5e-7)]
    # followed in time: one pass over the middle of the window, the jet's section an ellipse of even flow
    a, b = 0.004 / math.sin(math.radians(45.0)), 0.004
    steps = 200_001
    passing = [i * feed.stroke_m / (steps - 1) - 0.5 * feed.stroke_m for i in range(steps)]
    flux = scene.shot_rate_1_s / (math.pi * a * b)
    step_s = feed.stroke_m / feed.speed_m_s / (steps - 1)
    per_pass = [flux * step_s * sum((x / a) ** 2 + (y / b) ** 2 < 1.0 for y in passing) for x in (-0.003, 0.0, 0.003)]
    assert per_pass[1] == pytest.approx(25e6, abs=0.5e6)
    assert per_pass[0] / per_pass[1] == pytest.approx(0.85, abs=0.005)
    assert sum(per_pass) == pytest.approx(69e6, abs=0.5e6)
    assert hits(scene, sum(per_pass)) == pytest.approx(4.7, abs=0.05)


def test_the_beads_are_slowed_as_promised():
    """Schiller-Naumann by a midpoint rule of 10 000 steps in the distance flown."""
    scene = read_scene(example_path("glass-drag"))
    nozzle, bead, air = scene.nozzle, scene.shots, scene.air_drag
    assert not air.auto and scene.gravity.auto

    def slowing(v):
        reynolds = air.gas_density_kg_m3 * v * bead.diameter_m / air.gas_viscosity_Pa_s
        drag = 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687)
        return -0.75 * drag * air.gas_density_kg_m3 * v / (bead.density_kg_m3 * bead.diameter_m)

    v, step = nozzle.speed_m_s, nozzle.stand_off_m / 10_000
    for _ in range(10_000):
        v += step * slowing(v + 0.5 * step * slowing(v))
    assert v == pytest.approx(58, abs=0.5)
    per_m2 = scene.expected_shots / nozzle.footprint_area_m2
    assert scene.expected_shots == pytest.approx(15300, abs=50)
    for speed, radius, per_point in ((80.0, 20e-6, 5.9), (v, 17e-6, 4.3)):
        estimate = estimated_dimple_radius_m(bead, speed, scene.target.material)
        assert estimate == pytest.approx(radius, abs=0.5e-6)
        assert math.pi * estimate**2 * per_m2 == pytest.approx(per_point, abs=0.05)


def test_the_two_nozzles_keep_their_promise():
    scene = read_scene(example_path("two-nozzles-pulsed"))
    assert scene.shot_rate_1_s / 2.0 == pytest.approx(2267, abs=0.5)
    assert scene.expected_shots == pytest.approx(9069, abs=0.5)
    assert [n.pulse.peak for n in scene.nozzles] == [2.0, 1.8]
    shots, sine = scene.expected_shots / 2.0, math.sin(math.radians(60.0))
    # a Gaussian of sd 2.5 mm cut at 5 mm; an even disc that grew from 5 mm radius
    dense = shots * sine / (2.0 * math.pi * 0.0025**2 * (1.0 - math.exp(-2.0)))
    wide = 0.005 + 0.1 * math.tan(math.radians(2.0))
    thin = shots * sine / (math.pi * wide**2)
    assert (dense, thin) == (pytest.approx(116e6, abs=0.5e6), pytest.approx(17e6, abs=0.5e6))
    assert hits(scene, dense + thin) == pytest.approx(6.7, abs=0.05)


def test_the_shaft_keeps_its_promise():
    scene = read_scene(example_path("cylinder-s230"))
    per_m2 = scene.expected_shots / scene.nozzle.footprint_area_m2
    assert (scene.expected_shots, per_m2) == (pytest.approx(6801, abs=0.5), pytest.approx(87e6, abs=0.5e6))
    assert hits(scene, per_m2) == pytest.approx(5.0, abs=0.05)
    lean = math.asin(0.0015 / scene.target.surface.radius_m)
    assert math.degrees(lean) == pytest.approx(8.6, abs=0.05)
    assert 1.0 - math.cos(lean) == pytest.approx(0.011, abs=5e-4)


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
