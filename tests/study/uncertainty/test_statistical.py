"""Half widths by chance against what simulated windows, logs and surfaces really scatter by."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.study.uncertainty import statistical as chance
from glue.surface.roughness import areal

WINDOW = (1.0, 0.8)
RADII = np.array([0.1, 0.2])


def test_time_to_a_level_by_counting():
    # 300 windows of Poisson discs of two sizes, coverage at 20 x 16 points, time until .8 of them are covered.  The standard
    # deviation of 300 samples is known to 1/sqrt(600) = 4.1 %, the formula is the first order of the inverse: .15.
    rng, rate, level = np.random.default_rng(11), 60.0, 0.8
    x, y = (g.ravel() for g in np.meshgrid((np.arange(20) + 0.5) / 20 * WINDOW[0], (np.arange(16) + 0.5) / 16 * WINDOW[1]))
    margin, end, times = 0.2, 3.0, []
    area = (WINDOW[0] + 2 * margin) * (WINDOW[1] + 2 * margin)
    for _ in range(300):
        n = rng.poisson(rate * area * end)
        t = np.sort(rng.uniform(0.0, end, n))
        cx, cy = rng.uniform(-margin, WINDOW[0] + margin, n), rng.uniform(-margin, WINDOW[1] + margin, n)
        covers = (x[:, None] - cx) ** 2 + (y[:, None] - cy) ** 2 <= rng.choice(RADII, n) ** 2
        first = np.where(covers.any(axis=1), t[covers.argmax(axis=1)], np.inf)
        times.append(np.quantile(first, level, method="inverted_cdf"))
    expected = -math.log1p(-level) / (math.pi * rate * float((RADII**2).mean()))
    half = chance.time_half(expected, level, RADII, WINDOW)
    assert np.mean(times) == pytest.approx(expected, rel=0.05)
    assert chance.Z95 * np.std(times) == pytest.approx(half, rel=0.15)


def test_hits_per_point_by_counting():
    rng, mean = np.random.default_rng(5), 50.0
    sums = [float((rng.choice(RADII, rng.poisson(mean)) ** 2).sum()) for _ in range(4000)]
    half = chance.hits_relative_half(np.repeat(RADII, 1000), int(mean))
    assert chance.Z95 * np.std(sums) / np.mean(sums) == pytest.approx(half, rel=0.05)  # sd of 4000 samples: 1.1 %, 4 of them


def test_batch_means_see_that_neighbours_are_alike():
    rng = np.random.default_rng(2)
    alone = rng.normal(size=4000)
    bursts = np.repeat(rng.normal(size=400), 10)
    plain = chance.Z95 / math.sqrt(4000)
    # the scatter of 24 batch means is known to 1/sqrt(46) = 15 %; Student's factor is 2.07
    assert chance.batch_half(alone) == pytest.approx(plain, rel=0.45)
    assert chance.batch_half(bursts) == pytest.approx(plain * math.sqrt(10), rel=0.45)
    assert chance.batch_half(alone[:50]) is None


def test_roughness_of_surfaces_drawn_again_and_again():
    # white noise smoothed over a dimple: 60 surfaces; their scatter is known to 9 %, what the parts of each tell is averaged
    rng, radius, n = np.random.default_rng(7), 8, 160
    kernel = np.exp(-0.5 * (np.arange(-16, 17) / 4.0) ** 2)
    found, told = [], []
    for _ in range(60):
        z = rng.normal(size=(n, n))
        for axis in (0, 1):
            z = np.apply_along_axis(lambda v: np.convolve(v, kernel, "same"), axis, z)
        z = 1e-6 * z
        rough = areal(z, 1e-6, 1e-6)
        found.append(rough)
        told.append(chance.surface_halves(z, 1e-6, 1e-6, radius * 1e-6, rough))
    for key in ("Sa_m", "Sq_m", "Sz_m", "Ssk", "Sku"):
        real = chance.Z95 * np.std([f[key] for f in found], ddof=1)
        assert np.mean([t[key] for t in told]) == pytest.approx(real, rel=0.35), key
    assert chance.surface_halves(z[:40, :40], 1e-6, 1e-6, radius * 1e-6, rough) == {}  # no parts to compare


def test_no_interval_for_a_window_that_a_dimple_fills():
    assert chance.coverage_half(0.5, np.array([0.3, 0.6]), (1.0, 1.0)) is None
    assert chance.time_half(1.0, 0.5, np.array([0.6]), (1.0, 1.0)) is None
