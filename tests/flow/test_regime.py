"""Regime numbers against measured contact and event-driven runs, and the choice of the flow model."""

import dataclasses
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow import regime
from glue.flow.regime import choose_flow, collision_number, resolve_physics
from glue.scene.effects import AirDrag, Gravity
from glue.scene.model import Choice, Models, Pulse
from glue.scene.presets import PRESETS

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))


# Collisions per shot in YADE: 1 mm steel, 60 m/s, 20 mm jet, 100 mm stand-off, e .6.
@pytest.mark.parametrize(
    "kg_min, pi, collisions, within",
    [
        (0.02, 0.0036, 0.0036, 0.05),
        (0.1, 0.018, 0.017, 0.06),
        (1.0, 0.18, 0.143, 0.06),
        (5.0, 0.907, 0.419, 0.06),
        (10.0, 1.8, 0.576, 0.08),
    ],
)
def test_normal_incidence(make_scene, kg_min, pi, collisions, within):
    got = collision_number(make_scene(mass_flow_kg_s=kg_min / 60), 0.6)
    assert got["pi"] == pytest.approx(pi, rel=0.015)  # two printed digits
    # the heights below a quarter of a diameter do not count, of 100 mm
    assert got["pi_eff"] == pytest.approx(got["pi"], rel=0.004)
    assert got["collisions_per_shot"] == pytest.approx(collisions, rel=within)


@pytest.mark.parametrize("half_angle, collisions", [(1.0, 0.335), (2.0, 0.261), (5.0, 0.144), (10.0, 0.068)])
def test_diverging_jets(make_scene, half_angle, collisions):
    """YADE at 5 kg/min; some thousand shots each, so 3-6 % of chance."""
    got = collision_number(make_scene(divergence_half_angle_deg=half_angle), 0.6)
    assert got["collisions_per_shot"] == pytest.approx(collisions, rel=0.12)


def test_scenes_that_were_in_no_fit():
    """The 10 % that ``collision_fit.py`` measures on 200 scenes, here on ten others and event-driven runs."""
    import collision_fit

    scenes = collision_fit.drawn_scenes(20_240_503, 10)
    assert max(s.nozzle.impact_angle_deg for s, _ in scenes) == 90.0
    samples = [collision_fit.measured(scene, e) for scene, e in scenes]
    assert collision_fit.errors(samples)["collisions_rms"] < 0.10


@pytest.mark.parametrize(
    "changes",
    [
        {"divergence_half_angle_deg": 5.0, "impact_angle_deg": 45.0, "mass_flow_kg_s": 0.4},
        {"profile": "gaussian", "impact_angle_deg": 60.0, "mass_flow_kg_s": 0.2},
        {"speed_cv": 0.1, "impact_angle_deg": 45.0},
        {"pulse": Pulse("pulsed", 10.0, duty=0.25), "mass_flow_kg_s": 1.0 / 60.0},
    ],
)
def test_beyond_the_fit(make_scene, changes):
    """What the sampled scenes have not: spreading, peaked, uneven and pulsed jets; 3 % of chance each."""
    import collision_fit

    scene = make_scene(seed=2, **changes)
    scene = dataclasses.replace(scene, exposure_time_s=16_000 / scene.shot_rate_1_s)
    assert collision_fit.errors([collision_fit.measured(scene, 0.6)])["collisions_worst"] < 0.15


def test_second_nozzle_adds_its_own_and_what_crosses(make_scene):
    one = make_scene(impact_angle_deg=60.0)
    far = dataclasses.replace(one.nozzle, aim_m=(0.5, 0.0))
    apart = dataclasses.replace(one, nozzles=(one.nozzle, far))
    alone = collision_number(one, 0.5)["pi_eff"]
    assert collision_number(apart, 0.5)["pi_eff"] == pytest.approx(alone, rel=1e-9)
    opposite = dataclasses.replace(one.nozzle, azimuth_deg=180.0)
    crossing = dataclasses.replace(one, nozzles=(one.nozzle, opposite))
    assert collision_number(crossing, 0.5)["pi_eff"] > 2.0 * alone


def test_restitution_out_of_range(make_scene):
    for e in (0.0, -0.1, 1.1, float("nan")):
        with pytest.raises(InputError, match="must lie in"):
            collision_number(make_scene(), e)


def test_overlap_number_is_contact_time_over_time_between_shots(make_scene):
    """Jet 1.083e6 shots/m3 at 60 m/s, rebounds 1.804e6 at 36 m/s, pi mm2: 408 per second.

    Contact: 40.1 um deep, .0802 R = R (5 pi rho v^2 / (4 E*))^.4 with E* = 60.5 GPa, so 2.943 depth / v = 1.97 us.
    """
    got = regime.overlap_number(make_scene(), 0.6)
    assert got == pytest.approx(408.0 * 1.97e-6, rel=0.01)
    assert regime.overlap_number(make_scene(mass_flow_kg_s=10.0 / 60.0), 0.6) == pytest.approx(2.0 * got)


def auto(scene, preset="balanced", model="auto"):
    choice = Choice(model, "test")
    return dataclasses.replace(scene, models=Models(choice, choice, choice), accuracy=PRESETS[preset])


def test_the_cheapest_model_within_the_tolerance(make_scene):
    thin, some, much = (make_scene(mass_flow_kg_s=f / 60.0) for f in (0.01, 0.3, 5.0))
    assert choose_flow(auto(thin, "reference"), 0.6).model == "ballistic"
    assert choose_flow(auto(some, "fast"), 0.6).model == "event"
    assert choose_flow(auto(much, "reference"), 0.6).model == "dem"
    for preset in PRESETS:  # more flow or a stricter preset never makes the model cheaper
        order = [regime.MODELS.index(choose_flow(auto(s, preset), 0.6).model) for s in (thin, some, much)]
        assert order == sorted(order)


def test_ballistic_needs_a_small_number_whatever_the_tolerance(make_scene):
    loose = auto(make_scene(mass_flow_kg_s=0.1 / 60.0), "fast")
    loose = dataclasses.replace(loose, accuracy=dataclasses.replace(loose.accuracy, flow_tolerance=0.5))
    assert collision_number(loose, 0.6)["pi_eff"] > regime.BALLISTIC_BELOW
    assert choose_flow(loose, 0.6).model == "event"


def test_why_names_the_numbers(make_scene):
    why = choose_flow(auto(make_scene()), 0.6).why
    for word in ("pi_eff 0.9", "ballistic", "event", "dem", "tolerance 0.005"):
        assert word in why


def test_a_model_asked_for_is_kept_and_warned_of(make_scene):
    dense = choose_flow(auto(make_scene(), model="ballistic"), 0.6)
    assert dense.model == "ballistic"
    (warning,) = dense.warnings
    assert "pi_eff = 0.9" in warning and "%" in warning
    # pi .9: YADE delivers 27-30 % less energy
    loss = regime.expected_errors(make_scene(), 0.6)["ballistic"]
    assert f"{loss:.1%}" in warning and 0.24 < loss < 0.33
    thin = make_scene(mass_flow_kg_s=0.01 / 60.0)
    assert choose_flow(auto(thin, model="ballistic"), 0.6).warnings == []
    assert choose_flow(auto(make_scene(), model="dem"), 0.6).warnings == []
    assert choose_flow(auto(make_scene(mass_flow_kg_s=1.0), "reference", "event"), 0.6).warnings


def test_auto_physics_by_its_number(make_scene):
    gravity = Gravity(9.81, auto=True)
    air = AirDrag(1.2, 1.8e-5, auto=True)
    fast = resolve_physics(make_scene(gravity=gravity, air_drag=air))
    # a sag of g H^2 / (2 v^2) = 14 um over 10 mm: below half of .005; so is 2 g H / v^2 = 5.5e-4
    assert regime.gravity_number(make_scene(gravity=gravity)) == pytest.approx(0.0013625)
    assert fast.scene.gravity is None and fast.choices["gravity"].model == "off"
    slow = resolve_physics(make_scene(gravity=gravity, speed_m_s=5.0))
    assert slow.scene.gravity == dataclasses.replace(gravity, auto=False)
    assert slow.choices["gravity"].model == "on" and "by 0.2 " in slow.choices["gravity"].why
    light = resolve_physics(make_scene(air_drag=air, diameter_m=0.1e-3, density_kg_m3=2500.0))
    assert light.scene.air_drag is not None and not light.scene.air_drag.auto
    asked = resolve_physics(make_scene(gravity=Gravity(9.81)))
    assert asked.scene.gravity is not None and asked.choices["gravity"].model == "on"
    assert resolve_physics(make_scene()).choices == {}


def test_sag_of_a_slow_shot_counts_against_the_jet(make_scene):
    scene = make_scene(gravity=Gravity(9.81), speed_m_s=10.0, stand_off_m=0.5, jet_diameter_m=0.01)
    sag = 0.5 * 9.81 * (0.5 / 10.0) ** 2
    assert regime.gravity_number(scene) == pytest.approx(sag / 0.005)


def test_numbers_are_plain_and_quick(make_scene):
    numbers = collision_number(make_scene(), 0.6)
    assert all(type(v) is float and math.isfinite(v) for v in numbers.values())
    assert not any(isinstance(v, np.generic) for v in regime.expected_errors(make_scene(), 0.6).values())
