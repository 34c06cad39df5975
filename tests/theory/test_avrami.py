"""Avrami: the paper's worked number, the equivalence of its two forms, and the scatter of one window."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.theory import avrami

PAPER = {
    "mass_flow_kg_s": 1 / 60,
    "area_m2": 0.01,
    "shot_radius3_mean_m3": 0.5e-3**3,
    "density_kg_m3": 7800.0,
}


def test_paper_time_to_full_coverage():
    # r .15 mm, R .5 mm, 7800 kg/m3, 1 kg/min over 100 x 100 mm: 98 % after 135.62 s
    assert avrami.mass_flow_form(0.15e-3**2, **PAPER, time_s=135.62) == pytest.approx(0.98, abs=2e-6)


def test_both_forms_agree():
    rate = PAPER["mass_flow_kg_s"] / (0.01 * 7800.0 * 4 / 3 * math.pi * 0.5e-3**3)
    t = np.array([0.0, 10.0, 100.0])
    by_rate = avrami.coverage_rate_form(0.15e-3**2, rate, t)
    assert by_rate == pytest.approx(avrami.mass_flow_form(0.15e-3**2, **PAPER, time_s=t), rel=1e-12)
    assert by_rate[0] == 0.0
    assert avrami.time_to_coverage(0.98, 0.15e-3**2, rate) == pytest.approx(135.62, abs=5e-3)


@pytest.mark.parametrize(
    "coverage, exposure", [(0.5, 0.693147), (0.9, 2.302585), (0.98, 3.912023), (0.99, 4.605170)]
)
def test_time_to_coverage_inverts(coverage, exposure):
    assert avrami.time_to_coverage(coverage, 1.0 / math.pi, 1.0) == pytest.approx(exposure, abs=5e-7)


@pytest.mark.parametrize("coverage", [1.0, -0.1, math.nan])
def test_full_coverage_is_never_reached(coverage):
    with pytest.raises(InputError):
        avrami.time_to_coverage(coverage, 1.0, 1.0)


def test_two_disc_union():
    union = 2 * math.pi * 0.15**2 - avrami.disc_overlap_m2(0.15, 0.15)
    assert union == pytest.approx(0.113733, abs=5e-7)
    assert avrami.disc_overlap_m2(0.15, 0.0) == pytest.approx(math.pi * 0.15**2, rel=1e-15)
    assert avrami.disc_overlap_m2(0.15, 0.3) == 0.0
    assert avrami.disc_overlap_m2(0.15, 5.0) == 0.0


@pytest.mark.parametrize(
    "coverage, on_10_mm, on_2_mm",
    [
        (0.2, 0.0103, 0.0516),
        (0.5, 0.0120, 0.0602),
        (0.9, 0.0056, 0.0277),
        (0.98, 0.0020, 0.0098),
    ],
)
def test_scatter_reference_numbers(coverage, on_10_mm, on_2_mm):
    # the reference neglects the window's edge, so its two columns are one number, sd * side: the limit of a
    # large window, here 1 m; the limit is one unit of its last printed digit
    times_side = avrami.coverage_sd(coverage, 0.15e-3, (1.0, 1.0))
    assert times_side / 10e-3 == pytest.approx(on_10_mm, abs=1e-4)
    assert times_side / 2e-3 == pytest.approx(on_2_mm, abs=1e-4)
    assert avrami.coverage_sd(coverage, 0.15e-3, (2e-3, 2e-3)) < times_side / 2e-3  # edge pairs are fewer


def test_scatter_of_mixed_sizes_by_counting():
    # 2000 windows of 1 x .8 mm under Poisson discs of two sizes, coverage at 12 x 10 points.  The standard
    # error of a standard deviation from n samples of a near-normal variable is sd/sqrt(2n) = 1.6 %: 4 sigma.
    rng = np.random.default_rng(3)
    radii, window = np.array([0.1, 0.2]), np.array([1.0, 0.8])
    exposure = math.log(2.0) / (math.pi * np.mean(radii**2))  # coverage .5
    x, y = np.meshgrid((np.arange(12) + 0.5) / 12 * 1.0, (np.arange(10) + 0.5) / 10 * 0.8)
    found = []
    for _ in range(2000):
        n = rng.poisson(exposure * np.prod(window + 0.4))
        centre = rng.uniform(-0.2, window + 0.2, (n, 2))
        r = rng.choice(radii, n)
        near = (x[..., None] - centre[:, 0]) ** 2 + (y[..., None] - centre[:, 1]) ** 2 <= r**2
        found.append(near.any(axis=-1).mean())
    sd = avrami.coverage_sd(0.5, radii, (1.0, 0.8))
    assert np.mean(found) == pytest.approx(0.5, abs=4 * sd / math.sqrt(2000))
    assert np.std(found) == pytest.approx(sd, rel=4 * 0.016)


def test_scatter_refuses_a_window_smaller_than_a_dimple():
    with pytest.raises(InputError, match="twice the largest radius"):
        avrami.coverage_sd(0.5, 1.0, (1.9, 5.0))
