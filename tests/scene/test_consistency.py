"""Checks between keys that are each fine alone."""

from __future__ import annotations

import math

import pytest

from glue.scene.catalogue import material, shot
from glue.scene.consistency import estimated_dimple_radius_m, largest_diameter_m, volume_fraction
from glue.scene.model import Nozzle
from glue.scene.reader import read_scene


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


def test_largest_shot_of_a_spread():
    assert largest_diameter_m(shot("S390")) == 1e-3
    assert largest_diameter_m(shot("S390", "distribution")) == pytest.approx(1.1e-3 * 1.27)


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
    """45 degrees, jet 20 mm, shot 1 mm: H sin a > 10 cos a + .5 mm, H > 10.7071 mm."""
    leaning = {"nozzle.impact_angle_deg": "45"}
    read_scene(write_scene(leaning | {"nozzle.stand_off_m": "0.010708"}))
    assert problems_of(leaning | {"nozzle.stand_off_m": "0.010706"}) == [
        "nozzle.stand_off_m: 0.010706 m puts the edge of the nozzle's exit into the target at this angle; "
        "allowed above 0.0107071 m"
    ]
    # Straight down only the shot itself needs room.
    read_scene(write_scene({"nozzle.stand_off_m": "0.001"}))


def test_a_jet_narrower_than_its_shot(problems_of):
    (problem, _) = problems_of({"nozzle.jet_diameter_m": "0.0009"})
    assert problem == "nozzle.jet_diameter_m: 0.0009 m is narrower than one shot; allowed from 0.001 m up"


def test_a_jet_denser_than_a_stream(write_scene, problems_of):
    """1 m/s and 8 mm: 30 % of the volume are .3 x 7800 x 5.02655e-5 x 1 = .117621 kg/s."""
    slow = {"nozzle.speed_m_s": "1", "nozzle.jet_diameter_m": "0.008", "target.window_m": "[0.002, 0.002]"}
    read_scene(write_scene(slow | {"nozzle.mass_flow_kg_s": "0.1176"}))
    (problem,) = problems_of(slow | {"nozzle.mass_flow_kg_s": "0.1177"})
    assert problem == (
        "nozzle.mass_flow_kg_s: shots would fill 30.0201 % of the jet's volume, more than a stream of "
        "separate shots can; allowed up to 0.117621 kg/s with this jet_diameter_m and speed_m_s"
    )


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
