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
        (dict(e=0.6, typo=1), "its keys are e, speed_m_s"),
        (dict(), "its keys are"),
    ],
)
def test_bad_laws_are_refused_in_words(values, says):
    with pytest.raises(InputError, match=says):
        RestitutionLaw.from_dict(values)
