"""The trend benchmark's own parts on few seeds, and the dilute limit's: exponents within four standard errors."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import bench_dilute  # noqa: E402
import bench_trends  # noqa: E402

from glue.theory.avrami import coverage_covariance, coverage_sd  # noqa: E402

FEW = range(501, 509)


def test_slope_and_its_error_of_made_up_values():
    x, rng = [1.0, 2.0, 4.0], np.random.default_rng(1)
    times = [2.0 * v**-1.5 * np.exp(0.05 * rng.standard_normal(400)) for v in x]
    value, error = bench_trends.slope(x, times)
    # the slope's standard error is .05 / sqrt(sum of (ln x - mean)^2) = .05 / (ln 2 sqrt(800))
    assert error == pytest.approx(0.05 / (np.log(2.0) * 800**0.5), rel=0.1)
    assert abs(value + 1.5) < 4 * error


def test_time_to_full_coverage_goes_as_one_over_the_flow():
    value, error = bench_trends.dilute_flow(FEW, (1.0, 8.0))
    assert abs(value + 1.0) < 4 * error < 0.3


@pytest.mark.parametrize(("kind", "expected"), [("dimple fixed", -1.0), ("area fixed", -1.0), ("jet fixed", -2.0)])
def test_time_to_full_coverage_over_the_angle(kind, expected):
    value, error = bench_trends.angles(kind, FEW, (30.0, 90.0))
    assert abs(value - expected) < 4 * error < 0.7


def test_mean_and_scatter_of_coverage_in_the_dilute_limit():
    scene, times = bench_dilute.dilute_scene()
    found = np.array([bench_dilute.counted(dataclasses.replace(scene, seed=seed), times) for seed in range(2001, 2041)])
    expected = -np.expm1(-bench_dilute.EXPOSURES)
    sd = np.sqrt(np.diag(coverage_covariance(expected, bench_dilute.RADIUS_m, bench_dilute.WINDOW_m)))
    assert (abs(found.mean(axis=0) - expected) < 4.0 * sd / 40**0.5).all()
    assert found.std(axis=0, ddof=1) == pytest.approx(sd, rel=4.0 / 78**0.5)  # standard error 1/sqrt(2 (n - 1))


def test_covariance_of_coverage_at_two_times_by_counting():
    # 4000 windows of 1 x .8 under discs of radius .2; ten by eight sample points; covariance known to about 4 %
    rng, radius, window = np.random.default_rng(5), 0.2, np.array([1.0, 0.8])
    per_area = np.array([0.5, 1.5]) / (np.pi * radius**2)
    x, y = (g.ravel() for g in np.meshgrid((np.arange(10) + 0.5) / 10, (np.arange(8) + 0.5) / 10))
    found = []
    for _ in range(4000):
        count = rng.poisson(per_area[1] * 1.4 * 1.2)
        at = rng.random((count, 2)) * (1.4, 1.2) - 0.2
        hit = np.hypot(at[:, :1] - x, at[:, 1:] - y) < radius
        early = rng.random(count) < per_area[0] / per_area[1]
        found.append((hit[early].any(axis=0).mean(), hit.any(axis=0).mean()))
    expected = -np.expm1(-np.array([0.5, 1.5]))
    exact = coverage_covariance(expected, radius, window)
    assert np.cov(np.array(found).T) == pytest.approx(exact, rel=0.16)  # four standard errors
    assert coverage_sd(expected[1], radius, window) == pytest.approx(exact[1, 1] ** 0.5, rel=1e-12)


def test_simultaneous_band_lies_between_one_time_and_bonferroni():
    one, ten = np.eye(1), np.eye(10)
    assert bench_dilute.simultaneous(ten, 0.01) == pytest.approx(3.289, abs=0.01)  # independent: P(one) = .99^(1/10)
    assert bench_dilute.simultaneous(one, 0.01) == pytest.approx(2.576, abs=0.01)
    same = np.full((3, 3), 0.999) + 0.001 * np.eye(3)
    assert bench_dilute.simultaneous(same, 0.01) < 2.65
