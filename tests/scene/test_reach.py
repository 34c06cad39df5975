"""Where jets land: the closed form against shots followed one by one, and the windows that it refuses."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from glue.scene import reach
from glue.scene.model import Feed, Nozzle
from glue.scene.reader import read_scene

STRAIGHT = Nozzle(60.0, 0.01667, 0.02, 0.1, 90.0)
JETS = {
    "straight": STRAIGHT,
    "leaning": dataclasses.replace(STRAIGHT, impact_angle_deg=30.0),
    "spreading": dataclasses.replace(STRAIGHT, divergence_half_angle_deg=5.0),
    "both, turned": dataclasses.replace(
        STRAIGHT, impact_angle_deg=40.0, divergence_half_angle_deg=8.0, azimuth_deg=130.0, aim_m=(0.01, -0.03)
    ),
    "flat": dataclasses.replace(
        STRAIGHT, impact_angle_deg=10.0, divergence_half_angle_deg=7.0, jet_diameter_m=0.008
    ),
}


def landings(nozzle, inside=1.0, n=2000):
    """Where shots from a ring of the exit (``inside`` times its radius) meet z = 0, shape (n, 2): rays, no ellipse."""
    turn = np.linspace(0.0, 2.0 * math.pi, n, endpoint=False)
    up, level = (np.array(axis) for axis in nozzle.exit_axes)
    axis = np.array(nozzle.direction)
    outward = np.outer(np.cos(turn), up) + np.outer(np.sin(turn), level)
    start = (
        np.array([*nozzle.aim_m, 0.0])
        - nozzle.stand_off_m * axis
        + 0.5 * inside * nozzle.jet_diameter_m * outward
    )
    tilt = inside * math.tan(math.radians(nozzle.divergence_half_angle_deg))
    flight = axis + tilt * outward
    return (start - flight * (start[:, 2] / flight[:, 2])[:, None])[:, :2]


@pytest.fixture(params=JETS)
def jet(request):
    return JETS[request.param]


def test_the_edge_of_the_jet_lands_on_the_ellipse(jet):
    ellipse, p = reach.footprint(jet), math.radians(jet.azimuth_deg)
    x, y = (landings(jet) - reach.middle_m(jet)).T
    along, across = x * math.cos(p) + y * math.sin(p), y * math.cos(p) - x * math.sin(p)
    np.testing.assert_allclose(
        (along / ellipse.along_m) ** 2 + (across / ellipse.across_m) ** 2, 1.0, rtol=1e-9
    )


@pytest.mark.parametrize("direction", [0.0, 37.0, 90.0, 200.0])
def test_the_width_of_the_footprint_along_any_line(jet, direction):
    line = np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])
    widest = np.ptp(landings(jet) @ line)
    assert 2.0 * reach.half_width_m(jet, direction) == pytest.approx(widest, rel=1e-5)  # 2000 rays


def test_the_lowest_shot_leaves_above_the_target(jet):
    """The lowest centre of the exit's ring, less one shot of 1 mm."""
    up, _ = jet.exit_axes
    lowest = -jet.stand_off_m * jet.direction[2] - 0.5 * jet.jet_diameter_m * up[2]
    assert reach.inlet_clearance_m(jet, 1e-3) == pytest.approx(lowest - 1e-3, rel=1e-12)


def test_windows_inside_across_and_outside_the_footprint(jet):
    """A window shrunk to a point is covered or missed as the point is in or out."""
    inner, outer = landings(jet, 0.98), landings(jet, 1.02)
    for points, inside in ((inner, True), (outer, False)):
        for x, y in points[::250]:
            moved = dataclasses.replace(jet, aim_m=(jet.aim_m[0] - x, jet.aim_m[1] - y))
            assert reach.covers(moved, (1e-9, 1e-9), 0.0) is inside
            assert reach.misses(moved, (1e-9, 1e-9)) is not inside


def swept(nozzle, n=4000):
    """Points of the exit's edge landing at instants of the whole feed: shape (n * 360, 2)."""
    edge = landings(nozzle, n=360)
    path = np.array([nozzle.feed.at(t)[:2] for t in np.linspace(0.0, nozzle.feed.duration_s, n)])
    return (edge[None] + path[:, None]).reshape(-1, 2)


@pytest.mark.parametrize("direction", [0.0, 25.0, 90.0])
def test_the_needed_stroke_just_clears_the_window(direction):
    """At both ends of the stroke the footprint stands beside the window, touching it."""
    window, jet = (0.004, 0.002), JETS["both, turned"]
    at_middle = dataclasses.replace(jet, aim_m=tuple(a - m for a, m in zip(jet.aim_m, reach.middle_m(jet))))
    moving = dataclasses.replace(at_middle, feed=Feed(0.02, 1.0, direction_deg=direction))
    stroke = reach.needed_stroke_m(moving, window, 0.0)
    line = np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])
    beginning = (landings(at_middle, n=4000) @ line).max() - 0.5 * stroke
    corners = np.array([(sx * window[0] / 2, sy * window[1] / 2) for sx in (-1, 1) for sy in (-1, 1)])
    assert beginning == pytest.approx((corners @ line).min(), abs=1e-7)


def test_passes_side_by_side_cover_what_one_does_not():
    """A jet 8 mm wide covers a band of 8 mm; three passes 6 mm apart one of 20 mm, 10 mm apart none without gaps."""
    jet = dataclasses.replace(STRAIGHT, jet_diameter_m=0.008)

    def moving(passes, pitch):
        return dataclasses.replace(jet, feed=Feed(0.02, 0.1, passes, pitch))

    assert reach.covers(moving(1, 0.0), (0.05, 0.0079), 0.0) and not reach.covers(
        moving(1, 0.0), (0.05, 0.0081), 0.0
    )
    assert reach.covers(moving(3, 0.006), (0.05, 0.0199), 0.0)
    assert not reach.covers(moving(3, 0.006), (0.05, 0.0201), 0.0)
    assert not reach.covers(moving(3, 0.010), (0.05, 0.0199), 0.0)
    assert reach.covers(moving(3, 0.010), (0.05, 0.0079), 0.0)  # the middle pass alone


def test_a_path_beside_the_window_misses_it():
    jet = dataclasses.replace(STRAIGHT, jet_diameter_m=0.008, feed=Feed(0.02, 0.03))
    for y, missed in ((0.0059, False), (0.0061, True)):  # half the jet, half the window
        assert reach.misses(dataclasses.replace(jet, aim_m=(0.0, y)), (0.004, 0.004)) is missed
    for x, missed in ((0.0209, False), (0.0211, True)):  # half the stroke more
        assert reach.misses(dataclasses.replace(jet, aim_m=(x, 0.0)), (0.004, 0.004)) is missed
    # two passes straddle the window without touching it
    straddling = dataclasses.replace(jet, feed=Feed(0.02, 0.03, 2, 0.0121))
    assert reach.misses(straddling, (0.004, 0.004))
    assert not reach.misses(dataclasses.replace(jet, feed=Feed(0.02, 0.03, 3, 0.0121)), (0.004, 0.004))


# What the reader makes of it.
MOVING = {"exposure_time_s": None, "nozzle.feed_speed_m_s": "0.02", "nozzle.stroke_m": "0.0251"}


def test_a_jet_that_misses_the_window(problems_of):
    assert problems_of({"nozzle.aim_m": "[0.0, 0.0121]"}) == [
        "nozzle.aim_m: the jet's footprint, 0.02 x 0.02 m about (0, 0.0121), misses the window of 0.004 x 0.004 m about "
        "(0, 0) altogether; allowed: an aim_m, or feed, that brings them together"
    ]
    (problem,) = problems_of({"nozzle.aim_m": "[0.0, 0.0119]"})
    assert problem.startswith("target.window_m: 0.004 x 0.004 m does not lie inside the jet's footprint")


def test_a_stroke_too_short_for_the_window(write_scene, problems_of):
    """Window 4 mm, half a shot on each side, the jet 20 mm: 25 mm."""
    read_scene(write_scene(MOVING))
    assert problems_of(MOVING | {"nozzle.stroke_m": "0.0249"}) == [
        "nozzle.stroke_m: 0.0249 m does not carry the whole footprint over the window and off it, so that its ends get "
        "more than its middle; allowed from 0.025 m up (stroke_m, or what exposure_time_s and feed_speed_m_s make of it)"
    ]
    (problem,) = problems_of(MOVING | {"nozzle.stroke_m": None, "exposure_time_s": "1.2"})  # 24 mm
    assert problem.startswith("nozzle.stroke_m: 0.024 m does not carry")


def test_passes_with_a_gap_in_the_window(write_scene, problems_of):
    """Two passes of a jet 20 mm wide leave a gap when they lie more than that apart."""
    two = MOVING | {"nozzle.passes": "2"}
    read_scene(write_scene(two | {"nozzle.pitch_m": "0.0199"}))
    assert problems_of(two | {"nozzle.pitch_m": "0.0201"}) == [
        "target.window_m: 0.004 x 0.004 m does not lie inside what the passes sweep, side by side without a gap, with "
        "half a shot diameter to spare; allowed: no window, the jet is too narrow"
    ]


def test_one_of_two_nozzles_must_cover_the_window_and_none_may_miss_it(write_scene, problems_of):
    jet = "speed_m_s = 60, mass_flow_kg_s = 0.01, jet_diameter_m = 0.02, stand_off_m = 0.1, impact_angle_deg = 90"

    def both(x, y):
        return {"nozzle": f"[{{{jet}, aim_m = [{x}, 0]}}, {{{jet}, aim_m = [{y}, 0]}}]"}

    read_scene(write_scene(both("0.001", "0.011")))
    (problem,) = problems_of(both("0.010", "-0.010"))  # they share the window, and each takes half of it
    assert problem == (
        "target.window_m: 0.004 x 0.004 m does not lie inside the (swept) footprint of any one nozzle with half a shot "
        "diameter to spare; allowed: no window, the jet is too narrow"
    )
    (problem,) = problems_of(both("0.001", "0.013"))
    assert problem.startswith("nozzle[2].aim_m: the jet's footprint, 0.02 x 0.02 m about (0.013, 0), misses")
