"""Saturation curves: exact curves give their own exact intensity, real ones theirs, and bad ones a reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.surface.saturation import FORMS, fit_saturation

INCH = 0.0254


def test_data_set_1_of_sae_j2597():
    """4, 6, 8, 12 min; .0060 .0069 .0070 .0070 in: .0064 in +- .001."""
    found = fit_saturation([4, 6, 8, 12], INCH * np.array([0.0060, 0.0069, 0.0070, 0.0070]))
    assert found.problem is None
    assert found.intensity_m / INCH == pytest.approx(0.0064, abs=0.001)
    assert abs(0.0064 - found.intensity_m / INCH) < found.intensity_half_width_m / INCH < 0.001
    assert 4.0 < found.best.saturation < 6.0  # between the point below and the point above .0064


def test_an_exponential_is_found_again():
    """T = ln 10 b, I = .9 a."""
    t = np.array([1.0, 2, 4, 8, 16])
    found = fit_saturation(t, 2e-4 * -np.expm1(-t / 2.5))
    assert found.best.form.name == "exponential"
    assert found.intensity_m == pytest.approx(0.9 * 2e-4, rel=1e-6)
    assert found.best.saturation == pytest.approx(2.5 * math.log(10), rel=1e-6)


def test_a_hyperbola_is_found_again():
    """2T/(b + 2T) = 1.1 T/(b + T) at T = 4.5 b, I = 4.5/5.5 a."""
    t = np.array([1.0, 2, 4, 8, 16])
    found = fit_saturation(t, 2e-4 * t / (1.5 + t))
    assert found.best.form.name == "hyperbola"
    assert found.intensity_m == pytest.approx(4.5 / 5.5 * 2e-4, rel=1e-6)
    assert found.best.saturation == pytest.approx(6.75, rel=1e-6)


def test_a_third_parameter_takes_part_from_six_points_on():
    t = np.array([1.0, 2, 4, 6, 8, 12, 16])
    h = 2e-4 * -np.expm1(-((t / 4.0) ** 0.7))
    found = fit_saturation(t, h)
    assert found.best.form.parameters == 3
    a, T = 2e-4, found.best.saturation
    assert a * -math.expm1(-((2 * T / 4.0) ** 0.7)) == pytest.approx(1.1 * found.intensity_m, rel=1e-6)
    assert fit_saturation(t[:5], h[:5]).best.form.parameters == 2


@pytest.mark.parametrize("form", FORMS[:2], ids=lambda form: form.name)
def test_twice_the_saturation_exposure_brings_a_tenth(form):
    T = form.saturation(1.0)
    assert form.shape(2 * T, 1.0) == pytest.approx(1.1 * form.shape(T, 1.0), rel=1e-9)


def test_units_of_exposure_and_height_only_scale():
    t, h = np.array([4.0, 6, 8, 12]), np.array([0.0060, 0.0069, 0.0070, 0.0070])
    one, other = fit_saturation(t, h), fit_saturation(60 * t, 1e-3 * h)
    assert other.intensity_m == pytest.approx(1e-3 * one.intensity_m, rel=1e-6)
    assert other.best.saturation == pytest.approx(60 * one.best.saturation, rel=1e-6)
    assert other.intensity_half_width_m == pytest.approx(1e-3 * one.intensity_half_width_m, rel=1e-4)


def test_the_interval_holds_the_intensity_as_often_as_it_says():
    """Noisy exponentials, 5 points, scatter 1 %; 95 % stated, three binomial standard deviations allowed."""
    rng, t, trials = np.random.default_rng(1), np.array([1.0, 2, 4, 8, 12]), 100
    held = 0
    for _ in range(trials):
        found = fit_saturation(t, 2e-4 * (-np.expm1(-t / 1.5) + 0.01 * rng.normal(size=5)))
        held += abs(found.intensity_m - 1.8e-4) <= found.intensity_half_width_m
    assert held / trials > 0.95 - 3 * math.sqrt(0.95 * 0.05 / trials)


@pytest.mark.parametrize(
    ("t", "h", "says"),
    [
        ([4, 6, 8], [6, 6.9, 7], "only 3 points"),
        ([1, 2, 3, 4], [1, 2, 3, 4], "no saturation within the data"),
        ([1, 2, 3, 4], [1, 1.9, 2.7, 3.4], "no saturation within the data"),
        ([1, 2, 3, 4], [5, 7, 6, 8], "not monotone"),
        ([1, 2, 3, 4], [7, 7, 7, 7.01], "measure shorter"),
    ],
)
def test_points_that_allow_no_intensity(t, h, says):
    assert says in fit_saturation(t, 1e-5 * np.array(h)).problem


def test_a_short_curve_is_used_with_a_warning():
    t = np.array([1.0, 2, 3, 4])
    found = fit_saturation(t, 2e-4 * -np.expm1(-t / 1.3))
    assert found.problem is None and "below twice" in found.warnings[0]


@pytest.mark.parametrize(
    ("t", "h", "says"),
    [
        ([1, 2, 2, 3], [1, 2, 3, 4], "rise"),
        ([0, 1, 2, 3], [1, 2, 3, 4], "above 0"),
        ([1, 2, 3, 4], [1, 2, math.nan, 4], "finite"),
        ([1, 2, 3, 4], [1, 2, 3], "two equal columns"),
        ([1, 2, 3, 4], [0, 2, 3, 4], "arc heights must be above 0"),
    ],
)
def test_what_is_no_measurement(t, h, says):
    with pytest.raises(InputError, match=says):
        fit_saturation(t, h)
