"""No shot starts inside another: looked for pair by pair, by means that do not come from the generator."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.stats import kstest

from glue.errors import InputError
from glue.flow import arrivals, inlet
from glue.flow.inlet import Leaving, Wait, overlapping
from glue.scene import model

DENSE = 100.0 / 60.0  # kg/s: 408 000 shots/s of 1 mm, 1.1 % of the volume of a 20 mm jet at 60 m/s


def least_clearance(shots, lags):
    """Distance over touching distance when the later shot leaves: the least over pairs up to ``lags`` apart."""
    place = np.stack([shots[f"{c}_m"] for c in "xyz"])
    velocity = np.stack([shots[f"v{c}_m_s"] for c in "xyz"])
    least = math.inf
    for lag in range(1, min(lags, len(shots) - 1) + 1):
        wait = shots["time_s"][lag:] - shots["time_s"][:-lag]
        gap = place[:, lag:] - place[:, :-lag] - velocity[:, :-lag] * wait
        reach = 0.5 * (shots["diameter_m"][lag:] + shots["diameter_m"][:-lag])
        least = min(least, (np.sqrt((gap**2).sum(axis=0)) / reach).min())
    return least


def test_100_kg_a_minute_for_half_a_second_has_no_overlapping_pair(make_scene):
    scene = make_scene(mass_flow_kg_s=DENSE, exposure_time_s=0.5)
    shots = arrivals.draw_arrivals(scene)
    assert len(shots) == pytest.approx(204_045, abs=3 * math.sqrt(204_045))
    tree = cKDTree(np.stack([60.0 * shots["time_s"], shots["x_m"], shots["y_m"]], axis=1))
    assert not tree.query_pairs(1e-3)  # parallel flight at one speed: distances stay
    assert len(tree.query_pairs(1.1e-3)) > 1000  # and the jet is dense


def test_nor_with_divergence_speed_and_size_spread(make_scene):
    scene = make_scene(
        mass_flow_kg_s=DENSE,
        exposure_time_s=0.1,
        divergence_half_angle_deg=8.0,
        speed_cv=0.1,
        size="distribution",
        size_cv=0.1,
        impact_angle_deg=40.0,
        profile="gaussian",
    )
    # a shot of 45 m/s needs 28 us for the largest diameter: 11 shots on average
    assert 1.0 < least_clearance(arrivals.draw_arrivals(scene), 60) < 1.05


def test_a_dense_gaussian_jet_keeps_its_profile(make_scene):
    """Places drawn anew without regard to where the shot was would thin the crowded axis by 4 %."""
    scene = make_scene(mass_flow_kg_s=DENSE, exposure_time_s=0.3, profile="gaussian")
    shots = arrivals.draw_arrivals(scene)
    square = (shots["x_m"] ** 2 + shots["y_m"] ** 2) / 0.010**2
    assert kstest(square, lambda q: np.expm1(-2.0 * q) / math.expm1(-2.0)).pvalue > 0.01


def nozzles(scene, *changes):
    return dataclasses.replace(scene, nozzles=tuple(dataclasses.replace(scene.nozzle, **c) for c in changes))


@pytest.mark.parametrize(
    "second",
    [
        {},  # both leave through one exit
        {"aim_m": (0.012, 0.0)},  # exits overlap in part
        {"stand_off_m": 0.06, "speed_m_s": 40.0},  # the second sits 40 mm down the first's jet
        # its leaning exit reaches into the first's jet from one side
        {"impact_angle_deg": 70.0, "stand_off_m": 0.04, "azimuth_deg": 90.0},
        # starts over the first and travels away
        {"aim_m": (0.06, 0.0), "feed": model.Feed(speed_m_s=2.0, stroke_m=0.12)},
    ],
)
def test_nor_between_nozzles(make_scene, second):
    scene = make_scene(mass_flow_kg_s=DENSE / 4, exposure_time_s=0.05, divergence_half_angle_deg=3.0)
    scene = nozzles(scene, {}, second)
    shots = arrivals.draw_arrivals(scene)
    # 60 mm of flight at 60 m/s are 1 ms: 204 shots of both nozzles
    assert 1.0 < least_clearance(shots, 400) < 1.1


def test_nor_when_the_nozzle_steps_to_the_next_pass(make_scene):
    """Along an oblique jet's lean the pitch carries the exit down the jet, among shots on their way."""
    feed = model.Feed(speed_m_s=1.0, stroke_m=0.002, passes=10, pitch_m=0.004, direction_deg=-90.0)
    scene = make_scene(mass_flow_kg_s=DENSE, exposure_time_s=0.02, impact_angle_deg=30.0, feed=feed)
    shots = arrivals.draw_arrivals(scene)
    assert set(shots["pass_id"]) == set(range(10))
    assert 1.0 < least_clearance(shots, 200) < 1.1


def one(time_s, x_m, vx_m_s, vz_m_s, diameter_m=1e-3):
    column = [np.array([[c]]) for c in (x_m, 0.0, 0.1)]
    velocity = [np.array([[c]]) for c in (vx_m_s, 0.0, vz_m_s)]
    return Leaving(
        np.array([time_s]), np.concatenate(column), np.concatenate(velocity), np.array([diameter_m])
    )


@pytest.mark.parametrize(
    ("wait_s", "x_m", "vx_m_s", "speed_m_s", "touch"),
    [
        (20e-6, 0.0, 0.0, 40.0, True),  # 0.8 mm down the jet
        (
            20e-6,
            0.0,
            0.0,
            60.0,
            False,
        ),  # 1.2 mm: a faster one behind it may catch up later, and does not start in it
        (20e-6, -0.9e-3, 50.0, 10.0, True),  # was 0.9 mm beside, has drifted to 0.1 mm and is 0.2 mm down
        (20e-6, 0.0, 60.0, 10.0, False),  # was in the way, has drifted 1.2 mm off
    ],
)
def test_overlap_is_judged_when_the_later_one_leaves(wait_s, x_m, vx_m_s, speed_m_s, touch):
    earlier, later = one(0.0, x_m, vx_m_s, -speed_m_s), one(wait_s, 0.0, 0.0, -300.0)
    for ids in ({"later_ids": np.array([0])}, {"earlier_ids": np.array([0])}):
        assert len(overlapping(earlier, later, Wait(0.0, 1e-3), **ids)) == touch


def test_streams_that_fill_one_exit_are_refused_though_each_alone_is_not(make_scene, monkeypatch):
    share = 0.14  # of the jet's volume is shot; two together are more than can be drawn
    flow_kg_s = share * 7800.0 * math.pi / 4.0 * 0.005**2 * 60.0
    scene = make_scene(mass_flow_kg_s=flow_kg_s, jet_diameter_m=0.005, exposure_time_s=0.002)
    arrivals.check_stream(scene)
    monkeypatch.setattr(
        inlet, "MAX_ROUNDS", 100
    )  # none of the rounds finds room for all; a hundred tell as much
    with pytest.raises(InputError, match="too dense.*after 100 draws"):
        arrivals.check_stream(nozzles(scene, {}, {}))
