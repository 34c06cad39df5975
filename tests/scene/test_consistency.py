"""Checks between keys that are each fine alone."""

from __future__ import annotations

import dataclasses
import math

import pytest

from glue.scene.catalogue import material, shot
from glue.scene.consistency import estimated_dimple_radius_m, mixture_volume_fraction, volume_fraction
from glue.scene.contact_checks import elastic_overlap, shot_overlap, steps_per_contact
from glue.scene.effects import AirDrag
from glue.scene.jet_checks import driven
from glue.scene.model import Nozzle
from glue.scene.reader import read_scene
from glue.theory import hertz


@pytest.mark.parametrize(
    "speed_m_s, radius_m, within",
    [
        (60.0, 227.0e-6, 2e-3),  # the anchor
        (20.0, 135.4e-6, 0.05),  # computed dimples at other speeds
        (100.0, 287.0e-6, 0.05),
    ],
)
def test_dimple_estimate_against_computed_dimples(speed_m_s, radius_m, within):
    estimate = estimated_dimple_radius_m(shot("S390"), speed_m_s, material("al2024-t351"))
    assert estimate == pytest.approx(radius_m, rel=within)


def test_volume_fraction_by_hand():
    """1 kg/min at 60 m/s through 20 mm: .01667 / (7800 x 3.14159e-4 x 60) = 1.1338e-4."""
    assert volume_fraction(shot("S390"), Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0)) == pytest.approx(
        1.1338e-4, rel=1e-4
    )


def test_volume_fraction_of_a_mixture_by_hand():
    """Half steel, half glass by mass: (.5 / 7800 + .5 / 2500) x .01667 / (3.14159e-4 x 60)."""
    steel, glass = (dataclasses.replace(shot(grade), mass_fraction=0.5) for grade in ("S390", "GLASS500"))
    nozzle = Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0)
    by_hand = (0.5 / 7800.0 + 0.5 / 2500.0) * 0.01667 / (math.pi * 1e-4 * 60.0)
    assert mixture_volume_fraction((steel, glass), nozzle) == pytest.approx(by_hand, rel=1e-12)


def test_corners_of_the_window_against_the_jet(write_scene, problems_of):
    """A square of side s fits a circle of radius R with margin m if (s/2 + m) sqrt 2 <= R: 13.142 mm."""
    limit = math.sqrt(2.0) * 0.010 - 0.001
    inside, outside = f"{limit - 1e-6:.9f}", f"{limit + 1e-6:.9f}"
    read_scene(write_scene({"target.window_m": f"[{inside}, {inside}]"}))
    assert problems_of({"target.window_m": f"[{outside}, {outside}]"}) == [
        "target.window_m: 0.0131431 x 0.0131431 m does not lie inside the jet's footprint (ellipse of "
        "0.02 x 0.02 m) with half a shot diameter to spare; allowed: a square window up to 0.0131421 m"
    ]


def test_the_footprint_of_a_leaning_jet_is_longer_along_the_jet(write_scene, problems_of):
    leaning = {"nozzle.impact_angle_deg": "30"}  # an ellipse of 40 x 20 mm
    long_x, long_y = {"target.window_m": "[0.030, 0.008]"}, {"target.window_m": "[0.008, 0.030]"}
    read_scene(write_scene(leaning | long_x))
    (problem,) = problems_of(leaning | long_y)
    assert "ellipse of 0.04 x 0.02 m" in problem
    (problem,) = problems_of(long_x)
    assert "ellipse of 0.02 x 0.02 m" in problem


def test_a_jet_too_narrow_for_any_window(problems_of):
    problems = problems_of({"nozzle.jet_diameter_m": "0.00101"})
    assert problems[-1].endswith("allowed: no window, the jet is too narrow")


def test_nozzle_exit_above_the_target(write_scene, problems_of):
    """45 degrees, jet 20 mm, shot 1 mm: H sin a > 10 cos a + 1 mm, H > 11.4142 mm."""
    leaning = {"nozzle.impact_angle_deg": "45"}
    read_scene(write_scene(leaning | {"nozzle.stand_off_m": "0.011415"}))
    assert problems_of(leaning | {"nozzle.stand_off_m": "0.011414"}) == [
        "nozzle.stand_off_m: 0.011414 m leaves the lower edge of the nozzle's exit less than one shot (0.001 m) above "
        "the target at this angle, so that shots overlap there; allowed above 0.0114142 m"
    ]
    # Straight down only the shot itself needs room.
    read_scene(write_scene({"nozzle.stand_off_m": "0.0010001"}))
    assert problems_of({"nozzle.stand_off_m": "0.001"})
    # At the flattest angle: (10 cos 10 + 1) / sin 10 = 62.472 mm.
    flat = {"nozzle.impact_angle_deg": "10"}
    (problem,) = problems_of(flat | {"nozzle.stand_off_m": "0.06247"})
    assert problem.endswith("allowed above 0.0624716 m")
    read_scene(write_scene(flat | {"nozzle.stand_off_m": "0.06248"}))
    # The largest shot counts: S390 spreads to 1.1 x 1.225 = 1.3475 mm.
    (problem,) = problems_of({"nozzle.stand_off_m": "0.00134", "shots.size": '"distribution"'})
    assert problem.endswith("allowed above 0.0013475 m")


def test_a_jet_narrower_than_its_shot(problems_of):
    (problem,) = problems_of({"nozzle.jet_diameter_m": "0.0009"})
    assert problem == "nozzle.jet_diameter_m: 0.0009 m is narrower than one shot; allowed from 0.001 m up"


def test_a_jet_denser_than_a_stream(write_scene, problems_of):
    """1 m/s and 8 mm: 15 % of the volume are .15 x 7800 x 5.02655e-5 x 1 = .0588106 kg/s."""
    slow = {"nozzle.speed_m_s": "1", "nozzle.jet_diameter_m": "0.008", "target.window_m": "[0.002, 0.002]"}
    read_scene(write_scene(slow | {"nozzle.mass_flow_kg_s": "0.0588"}))
    (problem,) = problems_of(slow | {"nozzle.mass_flow_kg_s": "0.0589"})
    assert problem == (
        "nozzle.mass_flow_kg_s: shots would fill 15.0228 % of the jet's volume, more than a stream of "
        "separate shots can; allowed up to 0.0588106 kg/s with this jet_diameter_m and speed_m_s"
    )


@pytest.mark.parametrize("speed_m_s", [0.5, 60.0, 300.0])
def test_contacts_are_those_of_hertz(speed_m_s):
    shots, target, nozzle = shot("S390"), material("al2024-t351"), Nozzle(speed_m_s, 0.01667, 0.02, 0.1, 90.0)
    both = hertz.effective_modulus_Pa(shots.E_Pa, shots.nu, target.E_Pa, target.nu)
    steel = hertz.effective_modulus_Pa(shots.E_Pa, shots.nu, shots.E_Pa, shots.nu)
    on_target = hertz.impact(0.5e-3, shots.density_kg_m3, speed_m_s, both)
    # half the mass on half the radius: a sphere of R/2 and four times the density
    on_shot = hertz.impact(0.25e-3, 4.0 * shots.density_kg_m3, 2.0 * speed_m_s, steel)
    step = 0.3 * 0.5e-3 * math.sqrt(shots.density_kg_m3 / shots.E_Pa)
    shortest = min(on_target.contact_time_s, on_shot.contact_time_s)
    assert steps_per_contact((shots,), (nozzle,), target, 0.3) == pytest.approx(shortest / step, rel=1e-12)
    assert elastic_overlap((shots,), (nozzle,), target) == pytest.approx(on_target.depth_m / 0.5e-3, rel=1e-12)


def test_the_smallest_shot_sets_the_step_and_meets_in_it_too():
    nozzle, target = Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0), material("al2024-t351")
    # both times scale with the diameter, so that a spread of sizes leaves the number of steps as it is
    spread, sieved, mono = (
        steps_per_contact((shot("S390", size),), (nozzle,), target, 1.0)
        for size in ("distribution", "sieve", "mono")
    )
    assert spread == pytest.approx(mono, rel=1e-12)
    assert sieved == pytest.approx(mono, rel=1e-12)


def meeting(a, a_m, b, b_m, speed_m_s):
    """Two spheres as one on a plane: the reduced radius, and the density that makes it the reduced mass."""
    radius = 0.5 * a_m * b_m / (a_m + b_m)
    masses = [shots.density_kg_m3 * math.pi / 6.0 * size**3 for shots, size in ((a, a_m), (b, b_m))]
    density = masses[0] * masses[1] / sum(masses) / (4.0 / 3.0 * math.pi * radius**3)
    modulus = hertz.effective_modulus_Pa(a.E_Pa, a.nu, b.E_Pa, b.nu)
    return hertz.impact(radius, density, speed_m_s, modulus)


def test_two_media_can_meet_in_the_shortest_contact():
    """Glass of .1 mm turns faster on stiff, heavy steel than on its like: 12.11 against 12.22 steps."""
    target, nozzle = material("al2024-t351"), (Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0),)
    steel, glass = shot("S390"), shot("GLASS100")
    step = 0.05e-3 * math.sqrt(glass.density_kg_m3 / glass.E_Pa)  # the glass's is the shorter
    alike = meeting(glass, 1e-4, glass, 1e-4, 120.0).contact_time_s
    unlike = meeting(glass, 1e-4, steel, 1e-3, 120.0).contact_time_s
    assert unlike < 0.995 * alike
    assert steps_per_contact((glass,), nozzle, target, 1.0) == pytest.approx(alike / step, rel=1e-12)
    for media in ((glass, steel), (steel, glass)):
        assert steps_per_contact(media, nozzle, target, 1.0) == pytest.approx(unlike / step, rel=1e-12)


def test_a_small_shot_is_pressed_deepest_into_a_big_one():
    """As a share of the smaller radius, at the speed of one coming against one thrown back with e = .5."""
    nozzle, small = (Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0),), shot("S70")
    big = shot("S930")
    alike = meeting(small, 0.18e-3, small, 0.18e-3, 90.0).depth_m / 0.09e-3
    unlike = meeting(small, 0.18e-3, big, 2.36e-3, 90.0).depth_m / 0.09e-3
    assert shot_overlap((small,), nozzle, 0.5) == pytest.approx(alike, rel=1e-9)
    assert shot_overlap((small, big), nozzle, 0.5) == pytest.approx(unlike, rel=1e-9)
    assert unlike > 1.1 * alike


def test_shots_of_two_nozzles_meet_head_on_however_little_they_rebound():
    """At 30 degrees from both sides shots meet at 2 x 60 cos 30 = 104 m/s, more than the (1 + e) 60 of one jet."""
    steel = (shot("S390"),)
    a = Nozzle(60.0, 0.01667, 0.02, 0.1, 30.0)
    b = dataclasses.replace(a, azimuth_deg=180.0)
    modulus = hertz.effective_modulus_Pa(210e9, 0.3, 210e9, 0.3)
    # coming against going: flat 104 m/s, upright (1 + .1) 30 m/s
    fastest = math.hypot(120.0 * math.cos(math.radians(30.0)), 33.0)
    depth = hertz.impact(0.25e-3, 4.0 * 7800.0, fastest, modulus).depth_m
    assert shot_overlap(steel, (a, b), 0.1) == pytest.approx(depth / 0.5e-3, rel=1e-9)
    assert shot_overlap(steel, (a,), 0.1) < 0.5 * shot_overlap(steel, (a, b), 0.1)


def test_the_fastest_shot_of_a_spread_of_speeds_counts():
    target, even = material("al2024-t351"), Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0)
    spread, fast = dataclasses.replace(even, speed_cv=0.1), dataclasses.replace(even, speed_m_s=75.0)
    for check in (lambda n: steps_per_contact((shot("S390"),), (n,), target, 1.0), lambda n: elastic_overlap((shot("S390"),), (n,), target)):
        assert check(spread) == pytest.approx(check(fast), rel=1e-12) != check(even)


@pytest.mark.parametrize("preset", ["fast", "balanced"])
def test_a_speed_that_the_presets_step_cannot_follow(write_scene, problems_of, preset):
    """Steel on steel at 300 m/s: 8.6628 steps of 1 P, 9 at 300 (8.6628 / 9)^5 = 247.9 m/s."""
    fast = {"nozzle.speed_m_s": "300.0", "target.window_m": "[0.006, 0.006]"}
    assert problems_of(fast, preset=preset) == [
        "nozzle.speed_m_s: 300 m/s makes the shortest contact 8.7 time steps long at preset "
        f'"{preset}", fewer than 9; allowed up to 247.86 m/s, or --accuracy reference'
    ]
    read_scene(write_scene(fast), preset="reference")
    read_scene(write_scene(fast | {"nozzle.speed_m_s": "247.8"}), preset=preset)


def test_a_shot_pressed_too_deep(write_scene, problems_of):
    """Depth over radius at 300 m/s on 2024 is .29067 for steel of 7800 kg/m3, .3457 at 12000: ~ (rho v^2)^.4."""
    heavy = {
        "shots.grade": None, "shots.diameter_m": "0.001", "shots.density_kg_m3": "12000.0",
        "nozzle.speed_m_s": "300.0", "target.window_m": "[0.008, 0.008]",
    }  # fmt: skip
    (problem,) = problems_of(heavy, preset="reference")
    assert "300 m/s presses a shot 0.345" in problem and "too deep" in problem
    limit = 300.0 * math.sqrt((0.3 / 0.29066948881530763) ** 2.5 * 7800.0 / 12000.0)
    read_scene(write_scene(heavy | {"nozzle.speed_m_s": f"{limit - 0.01}"}), preset="reference")
    assert problems_of(heavy | {"nozzle.speed_m_s": f"{limit + 0.01}"}, preset="reference")


def test_expected_number_of_shots(write_scene, problems_of):
    """A shot of 4.08407 mg takes 4.08407e-6 / .01667 = 2.44995e-4 s, two million take 489.990 s."""
    read_scene(write_scene({"exposure_time_s": "2.46e-4"}))
    read_scene(write_scene({"exposure_time_s": "489"}))
    assert problems_of({"exposure_time_s": "2.4e-4"}) == [
        "exposure_time_s: only 0.979611 shots are expected; allowed 0.000244995..489.99 s with this mass "
        "flow and shot"
    ]
    (problem,) = problems_of({"exposure_time_s": "600"})
    assert problem == (
        "exposure_time_s: 2.4e+06 shots are expected, more than a run holds; allowed 0.000244995..489.99 s "
        "with this mass flow and shot"
    )


def test_window_against_the_dimple(write_scene, problems_of):
    """1.05 x 4.8 radii of .22678 mm are 1.14296 mm; 1e4 x 1e4 points at .22678 / 20 mm (balanced) are 113.4 mm."""
    read_scene(write_scene({"target.window_m": "[0.00115, 0.00115]"}))
    assert problems_of({"target.window_m": "[0.00090, 0.004]"}) == [
        "target.window_m: 0.0009 m is too narrow for dimples of about 0.000226778 m radius (estimate): "
        "the target's cell wants 4.8 radii; allowed from 0.00114296 m up"
    ]
    wide = {"nozzle.jet_diameter_m": "0.2"}
    read_scene(write_scene(wide | {"target.window_m": "[0.113, 0.113]"}))
    (problem,) = problems_of(wide | {"target.window_m": "[0.114, 0.114]"})
    assert problem == (
        "target.window_m: 0.114 x 0.114 m needs a raster of 1.0e+08 points for dimples of about 0.000226778 "
        'm radius (estimate); allowed: a square window up to 0.113389 m at preset "balanced"'
    )


def test_every_medium_and_nozzle_counts(write_scene, problems_of):
    """The widest dimple needs the widest window, the finest the finest raster; shots of all nozzles are counted."""
    mixed = {"shots": '[{grade = "S930", mass_fraction = 0.999}, {grade = "S70", mass_fraction = 0.001}]'}
    (problem,) = problems_of(mixed | {"target.window_m": "[0.002, 0.002]"})
    assert "0.002 m is too narrow for dimples of about 0.000535197 m radius" in problem  # .226778 x 2.36
    wide = {"nozzle.jet_diameter_m": "0.1", "nozzle.mass_flow_kg_s": "0.001", "target.window_m": "[0.021, 0.021]"}
    (problem,) = problems_of(mixed | wide)
    assert "dimples of about 4.08201e-5 m radius (estimate); allowed: a square window up to 0.02041 m" in problem
    read_scene(write_scene(mixed | wide | {"target.window_m": "[0.020, 0.020]"}))
    jet = "speed_m_s = 60, mass_flow_kg_s = 0.01, jet_diameter_m = 0.02, stand_off_m = 0.1, impact_angle_deg = 90"
    (problem,) = problems_of({"nozzle": f"[{{{jet}}}, {{{jet}}}]", "exposure_time_s": "410"})
    assert problem.startswith("exposure_time_s: 2e+06 shots are expected, more than a run holds; allowed")
    read_scene(write_scene({"nozzle": f"[{{{jet}}}, {{{jet}}}]", "exposure_time_s": "408"}))  # 2e6 x 4.08407e-6 / .02


@pytest.mark.parametrize("word, refused", [("auto", True), ("dem", True), ("event", False), ("ballistic", False)])
def test_contact_times_matter_where_yade_may_run(word, refused, write_scene, problems_of):
    fast = {"nozzle.speed_m_s": "300.0", "target.window_m": "[0.006, 0.006]", "models.flow": f'"{word}"'}
    if refused:
        (problem,) = problems_of(fast)
        assert "makes the shortest contact 8.7 time steps long" in problem
    else:
        read_scene(write_scene(fast))


def test_a_hardened_rebound_presses_shots_deeper(write_scene, problems_of):
    """Steel at 275 m/s: into 2024 .2711 of a radius; two shots at 1.5 x 275 m/s less, at 1.94 x 275 m/s .3047."""
    fast = {"nozzle.speed_m_s": "275", "target.window_m": "[0.006, 0.006]"}
    read_scene(write_scene(fast), preset="reference")
    for e in ({"restitution.hardening": "{saturated = 0.94}"}, {"restitution.shot_target": "0.94"}):
        (problem,) = problems_of(fast | e, preset="reference")
        assert problem.startswith("nozzle.speed_m_s: 275 m/s presses two shots 0.30")


def test_a_gas_faster_than_the_shots_drives_them_at_most_as_far_as_it_can():
    """Against the flight itself, in 10 000 steps of the distance: a bound, and near where the shots stay slow."""
    air = AirDrag(1.204, 1.81e-5, 300.0)
    for grade, near in (("S390", 0.02), ("GLASS100", 0.5)):
        shots, nozzle = shot(grade), Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0)
        v, step = nozzle.speed_m_s, nozzle.stand_off_m / 10_000
        for _ in range(10_000):
            reynolds = air.gas_density_kg_m3 * (300.0 - v) * shots.diameter_m / air.gas_viscosity_Pa_s
            drag = 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687) if reynolds < 1000.0 else 0.44
            push = 0.75 * drag * air.gas_density_kg_m3 * (300.0 - v) ** 2 / (shots.density_kg_m3 * shots.diameter_m)
            v += step * push / v
        bound = driven(nozzle, (shots,), air).speed_m_s
        assert v < bound < v * (1.0 + near)
        assert bound <= 300.0
    slower = dataclasses.replace(air, gas_speed_m_s=50.0)
    assert driven(nozzle, (shots,), slower) == nozzle == driven(nozzle, (shots,), None)


def test_shots_driven_too_fast_for_the_step_are_refused(write_scene, problems_of):
    """Glass of .1 mm leaves slowly, and arrives too fast."""
    blown = {"shots.grade": '"GLASS100"', "nozzle.mass_flow_kg_s": "1e-4", "nozzle.stand_off_m": "0.5"}
    read_scene(write_scene(blown | {"air_drag": "{gas_speed_m_s = 150}"}))
    (problem,) = problems_of(blown | {"air_drag": "{gas_speed_m_s = 500}"}, preset="reference")
    assert problem.startswith("air_drag.gas_speed_m_s: driving shots to ") and "m/s presses two shots" in problem
    assert "allowed: a gas that drives shots below " in problem
