"""Profile metrics on profiles whose answers are known, and on those that lack what is asked."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.surface.stress import plate_balance, profile_metrics


def parabola(z):
    """-400 MPa at .1 mm, zero at .3 mm, -300 MPa at the surface."""
    return (-400.0 + 100.0 * ((z - 0.1e-3) / 0.1e-3) ** 2) * 1e6


@pytest.mark.parametrize(
    "z", [np.linspace(0.0, 0.4e-3, 14), np.array([0.0, 0.02, 0.05, 0.13, 0.2, 0.29, 0.31, 0.4]) * 1e-3]
)
def test_parabola_is_found_exactly_on_any_grid(z):
    got = profile_metrics(z, parabola(z))
    assert got["surface_Pa"] == pytest.approx(-300e6, rel=1e-12)
    assert got["max_compressive_Pa"] == pytest.approx(-400e6, rel=1e-12)
    assert got["max_compressive_depth_m"] == pytest.approx(0.1e-3, rel=1e-9)
    assert got["compressive_depth_m"] == pytest.approx(
        0.3e-3, rel=0.01
    )  # linear between the points around it


def test_sign_change_is_linear_and_below_the_minimum():
    got = profile_metrics([0.0, 1.0, 2.0, 4.0, 5.0], [10.0, -100.0, -30.0, 10.0, -5.0])
    assert got["compressive_depth_m"] == pytest.approx(3.5)
    assert profile_metrics([0.0, 1.0, 2.0, 3.0], [-1.0, -1.0, 0.0, 1.0])["compressive_depth_m"] == 2.0


def test_surface_is_extrapolated_when_the_first_point_lies_deeper():
    assert profile_metrics([0.5, 1.5, 2.5], [-100.0, -140.0, 0.0])["surface_Pa"] == pytest.approx(-80.0)


@pytest.mark.parametrize(
    "sigma, depth, value", [([-5.0, -3.0, 1.0], 0.0, -5.0), ([1.0, -3.0, -9.0], 2.0, -9.0)]
)
def test_minimum_at_an_end_is_that_point(sigma, depth, value):
    got = profile_metrics([0.0, 1.0, 2.0], sigma)
    assert (got["max_compressive_depth_m"], got["max_compressive_Pa"]) == (depth, value)


def test_plateau_has_its_first_point():
    got = profile_metrics([0.0, 1.0, 2.0, 3.0], [-7.0, -7.0, -7.0, -7.0])
    assert (got["max_compressive_depth_m"], got["max_compressive_Pa"]) == (0.0, -7.0)


def test_never_tensile_is_null_with_its_reason():
    got = profile_metrics([0.0, 1e-3], [-300e6, -20e6])
    assert got["compressive_depth_m"] is None
    assert got["compressive_depth_m_reason"] == "still compressive (-20 MPa) at the profile's end, 1.000 mm"


def test_all_tension_is_null_throughout():
    got = profile_metrics([0.0, 1.0], [0.0, 3.0])
    for key in ("max_compressive_Pa", "max_compressive_depth_m", "compressive_depth_m"):
        assert got[key] is None
        assert "no compressive" in got[f"{key}_reason"]


def test_force_balance():
    # a layer eigenstrain in a free plate of 1 mm: -300 MPa over .2 mm against +75 MPa over .8 mm
    z = np.array([0.0, 0.2e-3 - 1e-12, 0.2e-3, 1e-3])
    sigma = np.array([-300e6, -300e6, 75e6, 75e6])
    got = profile_metrics(z, sigma)
    assert got["force_balance_N_m"] == pytest.approx(0.0, abs=1e-3)
    assert got["force_balance_relative"] == pytest.approx(0.0, abs=1e-8)
    # triangle through zero: integral -1 + 1/4 of halves 1 and 1/4
    got = profile_metrics([0.0, 3.0], [-2.0, 1.0])
    assert got["force_balance_N_m"] == pytest.approx(-1.5)
    assert got["force_balance_relative"] == pytest.approx(-1.5 / 2.5)
    assert profile_metrics([0.0, 1.0], [0.0, 0.0])["force_balance_relative"] == 0.0


@pytest.mark.parametrize(
    "z, sigma, text",
    [
        ([0.0], [1.0], "at least 2 rows"),
        ([0.0, 1.0], [1.0, math.nan], "not finite"),
        ([0.0, 0.0], [1.0, 1.0], "rise"),
        ([-1.0, 0.0], [1.0, 1.0], "depths"),
    ],
)
def test_bad_profiles(z, sigma, text):
    with pytest.raises(InputError, match=text):
        profile_metrics(z, sigma)


def test_a_stress_that_only_fades_has_no_sign_change():
    """A half-space's layer means end in rounding of either sign: no depth at which it turns to tension."""
    for tail in (1e3, -1e3):
        got = profile_metrics([0.0, 1e-4, 2e-4, 3e-4], [-300e6, -400e6, -20e6, tail])
        assert got["compressive_depth_m"] is None
        assert "fades" in got["compressive_depth_m_reason"]


def test_depth_at_a_tenth_of_the_largest_compression():
    got = profile_metrics([0.0, 1.0, 2.0, 3.0], [-50.0, -100.0, -20.0, 0.0])
    assert got["tenth_depth_m"] == pytest.approx(2.5)


def test_an_extrapolated_surface_may_be_the_most_compressed():
    # the line through (1, -120) and (2, -89) meets the surface at -151; a tenth of it at 2 + (89 - 15.1) / 89
    found = profile_metrics([1.0, 2.0, 3.0, 4.0], [-120.0, -89.0, 0.0, 10.0])
    assert found["surface_Pa"] == found["max_compressive_Pa"] == pytest.approx(-151.0, rel=1e-12)
    assert found["max_compressive_depth_m"] == 0.0
    assert found["tenth_depth_m"] == pytest.approx(2.0 + (89.0 - 15.1) / 89.0, rel=1e-12)
    assert found["compressive_depth_m"] == 3.0
    # the balance is that of the rows: -104.5 - 44.5 + 5, over the same with its signs turned
    assert found["force_balance_N_m"] == pytest.approx(-144.0, rel=1e-12)
    assert found["force_balance_relative"] == pytest.approx(-144.0 / 154.0, rel=1e-12)


def test_compression_at_the_extrapolated_surface_alone_is_compression():
    found = profile_metrics([1.0, 2.0, 3.0], [1.0, 5.0, 0.0])
    assert (found["max_compressive_Pa"], found["max_compressive_depth_m"]) == (-3.0, 0.0)
    assert found["compressive_depth_m"] == pytest.approx(0.75, rel=1e-12)


def test_a_deeper_minimum_between_the_rows_stays_the_largest():
    found = profile_metrics([1.0, 2.0, 3.0], [-10.0, -10.5, 0.0])
    assert found["surface_Pa"] == -9.5 > found["max_compressive_Pa"]
    assert found["max_compressive_depth_m"] > 1.0


def test_force_and_moment_over_a_plate():
    """Constant stress: 1 and 1/2; a triangle from 1 at the top to 0: 1/2 and 1/6; an unpeened plate: 0."""
    z = np.linspace(0.0, 4e-3, 9)
    assert plate_balance(z, np.full(9, -2e8)) == pytest.approx((-1.0, -0.5))
    assert plate_balance(z, 2e8 * (1 - z / 4e-3)) == pytest.approx((0.5, 1 / 6))
    assert plate_balance(z, np.zeros(9)) == (0.0, 0.0)
