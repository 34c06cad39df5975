"""Restitution as a law of the normal speed and of what struck before."""

import json
import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.restitution import RestitutionLaw
from glue.scene.model import SpotHardening

HARDENING = SpotHardening(saturated=0.8, hits=3.0)


def test_a_constant_is_the_same_at_every_speed():
    law = RestitutionLaw(0.6)
    assert [law.at(v) for v in (0.0, 1e-9, 60.0, 300.0)] == [0.6] * 4


def test_power_law_through_its_reference_and_under_its_cap():
    law = RestitutionLaw(0.4, speed_m_s=60.0, exponent=0.25)
    assert law.at(60.0) == 0.4
    assert law.at(960.0) == pytest.approx(0.2)  # 16 times faster: 16^-.25 = 1/2
    assert law.at(3.75) == pytest.approx(0.8)
    assert law.at(60.0 * (0.4 / 0.94) ** 4) == pytest.approx(0.94)  # where it meets the cap
    assert law.at(1.0) == law.at(0.0) == 0.94
    speeds = np.array([0.1, 3.75, 60.0, 960.0])
    assert law.at_speeds(speeds) == pytest.approx([law.at(v) for v in speeds])


TABLE = ((1.0, 0.8), (10.0, 0.5), (100.0, 0.25))


def test_a_table_is_straight_between_its_points_in_logarithms_and_goes_on_beyond():
    law = RestitutionLaw(0.25, 100.0, points=TABLE)
    for v, e in TABLE:
        assert law.at(v) == pytest.approx(e, rel=1e-14)
    assert law.at(math.sqrt(10.0)) == pytest.approx(math.sqrt(0.8 * 0.5))
    assert law.at(1000.0) == pytest.approx(0.125) and law.at(0.0) == law.at(1e-3) == 0.94
    speeds = np.array([1e-3, 0.5, 1.0, 3.0, 10.0, 42.0, 100.0, 300.0])
    assert law.at_speeds(speeds) == pytest.approx([law.at(v) for v in speeds], rel=1e-14)


def test_a_table_of_a_power_law_is_the_power_law():
    power = RestitutionLaw(0.4, 60.0, 0.25)
    table = RestitutionLaw(0.4, 60.0, points=tuple((v, power.at(v)) for v in (5.0, 20.0, 60.0)))
    assert [table.at(v) for v in (2.0, 7.0, 200.0)] == pytest.approx([power.at(v) for v in (2.0, 7.0, 200.0)])


def test_only_density_times_speed_squared_counts():
    law = RestitutionLaw(0.25, 100.0, points=TABLE, density_kg_m3=7800.0)
    assert law.at(40.0, 7800.0 / 4) == pytest.approx(law.at(20.0))
    assert law.at(40.0, 7800.0) == law.at(40.0)
    assert RestitutionLaw(0.4, 60.0, 0.25).at(40.0, 2500.0) == RestitutionLaw(0.4, 60.0, 0.25).at(40.0)
    glass = np.array([2500.0, 7800.0])
    assert law.at_speeds(np.array([40.0, 40.0]), glass) == pytest.approx([law.at(40.0, d) for d in glass])


def test_nothing_lost_is_its_own_cap():
    law = RestitutionLaw(1.0)
    assert law.at(60.0) == law.at(0.0) == 1.0


def test_hardening_rises_from_e_to_its_end_and_never_lowers():
    law = RestitutionLaw(0.5, hardening=HARDENING, spot_radius_m=1e-4)
    assert law.at_spot(0.5, 0) == 0.5
    assert law.at_spot(0.5, 3) == pytest.approx(0.8 - 0.3 * math.exp(-1.0))
    assert law.at_spot(0.5, 1000) == pytest.approx(0.8)
    assert law.at_spot(0.9, 5) == 0.9  # a slow impact is above the end already
    assert RestitutionLaw(0.5).at_spot(0.5, 100) == 0.5


@pytest.mark.parametrize(
    "law",
    [
        RestitutionLaw(0.1 + 0.2),
        RestitutionLaw(1.0),
        RestitutionLaw(0.4, 60.0, 0.25, 0.9, HARDENING, 1.2345e-4),
        RestitutionLaw(0.25, 100.0, points=((0.1, 0.3), (100.0, 0.25)), density_kg_m3=7800.0),
    ],
)
def test_json_keeps_every_digit(law):
    assert RestitutionLaw.from_dict(json.loads(json.dumps(law.as_dict()))) == law


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (dict(e=0.0), r"e = 0.0: must lie in \(0, 0.94\]"),
        (dict(e=0.97), r"or be exactly 1"),
        (dict(e=-0.5), "e = -0.5"),
        (dict(e=math.nan), "e = nan: must be a finite number"),
        (dict(e="0.6"), "must be a finite number"),
        (dict(e=0.6, exponent=0.25), "speed_m_s = 0.0: must be above 0"),
        (dict(e=0.6, speed_m_s=60.0, exponent=-0.1), r"exponent = -0.1: must lie in \[0, 1\)"),
        (dict(e=1.0, speed_m_s=60.0, exponent=0.25), "e = 1 loses nothing"),
        (dict(e=0.6, hardening=dict(saturated=0.8, hits=3.0)), "needs the radius of the spot"),
        (dict(e=0.6, hardening=dict(saturated=0.8, hits=0.0), spot_radius_m=1e-4), "hits = 0.0"),
        (dict(e=0.6, hardening=dict(saturated=0.99, hits=1.0), spot_radius_m=1e-4), "saturated = 0.99"),
        (dict(e=0.6, points=[(1.0, 0.6)]), "two or more"),
        (dict(e=0.6, points=[(1.0, 0.6), (2.0, 0.7)]), "e falling"),
        (dict(e=0.6, points=[(2.0, 0.6), (1.0, 0.5)]), "rising speeds"),
        (dict(e=0.6, points=[(1.0, 0.6), (2.0, math.nan)]), "must be a finite number"),
        (dict(e=0.6, typo=1), "its keys are e, speed_m_s"),
        (dict(), "its keys are"),
    ],
)
def test_bad_laws_are_refused_in_words(values, says):
    with pytest.raises(InputError, match=says):
        RestitutionLaw.from_dict(values)
