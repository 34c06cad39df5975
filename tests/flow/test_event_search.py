"""Flights between touches in gas: kicks against the equation of motion, and shots that the gas presses together."""

import pytest
from event_cases import shots, smooth_scene
from scipy.integrate import solve_ivp

from glue.flow.drag import acceleration, speed_after_flight, surroundings
from glue.flow.event_driven import run_event
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.effects import AirDrag

PLANE, LAW = TargetSurface(), RestitutionLaw(0.6)
AIR = AirDrag(1.2, 1.8e-5)


@pytest.mark.parametrize("speed", [15.0, 60.0, 300.0])
@pytest.mark.parametrize(("diameter", "density"), [(0.1e-3, 7800.0), (0.3e-3, 2500.0), (5e-3, 7800.0)])
def test_shots_land_when_and_as_fast_as_the_ode_says(diameter, density, speed):
    """Time of flight within 1e-4, speed within 5e-4."""
    scene = smooth_scene(air_drag=AIR, diameter_m=diameter, density_kg_m3=density, speed_m_s=speed)
    arrivals = shots((0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -speed), diameter, density))
    impacts, _ = run_event(scene, arrivals, LAW, PLANE)
    around = surroundings(scene)

    def rate(_, y):
        return [y[1], acceleration(0.0, 0.0, y[1], diameter, density, around)[2]]

    def touch(_, y):
        return y[0] - 0.5 * diameter

    touch.terminal = True
    ode = solve_ivp(rate, (0.0, 1.0), [0.1, -speed], events=touch, rtol=1e-11, atol=1e-13)
    assert impacts["time_s"][0] == pytest.approx(ode.t_events[0][0], rel=1e-4)
    assert -impacts["vz_in_m_s"][0] == pytest.approx(-ode.y_events[0][0][1], rel=5e-4)


def test_slow_shots_are_kicked_less():
    """Per time of flight; one interval for all would kick both alike."""
    scene = smooth_scene(air_drag=AIR, diameter_m=0.1e-3, density_kg_m3=7800.0)
    there = shots((0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -60.0), 0.1e-3, 7800.0))
    slow = shots((0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -6.0), 0.1e-3, 7800.0))
    fast, crawl = (run_event(scene, arrivals, LAW, PLANE) for arrivals in (there, slow))
    share = crawl[1]["kicks"] / crawl[0]["time_s"][0] / (fast[1]["kicks"] / fast[0]["time_s"][0])
    assert share < 0.5


def test_a_light_shot_that_the_gas_presses_on_a_heavy_one_does_not_stop_time():
    """It leads, is slowed more, and bounces lower and lower: contacts without end in a finite time, were it exact."""
    scene = smooth_scene(air_drag=AIR, shot_shot=0.5)
    x = 0.02e-3  # off the line of centres: it also slips past
    arrivals = shots(
        (0.0, (x, 0.0, 0.1), (0.0, 0.0, -60.0), 0.1e-3, 2500.0),
        (0.56e-3 / 60.0, (0.0, 0.0, 0.1), (0.0, 0.0, -60.0), 1e-3, 7800.0),
    )
    impacts, info = run_event(scene, arrivals, LAW, PLANE)
    assert {0, 1} == set(impacts["shot_id"])
    assert info["shot_shot_collisions"] > 5
    assert info["events"] < 20_000
    first = impacts[impacts["shot_id"] == 0][0]
    alone = speed_after_flight(60.0, 0.1, 0.1e-3, 2500.0, surroundings(scene))
    assert alone + 1.0 < -first["vz_in_m_s"] < 60.0  # the heavy one has pushed it on
