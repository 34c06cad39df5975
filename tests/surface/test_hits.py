"""Hits per point against shapes counted by hand, and against the coverage of the same dimples."""

from __future__ import annotations

import numpy as np
import pytest

from glue.surface.coverage import coverage_history
from glue.surface.hits import hit_counts


def test_two_overlapping_circles_and_one_outside():
    x = y = np.arange(-4.0, 5.0)
    counts = hit_counts(x, y, [0.0, 1.0, 20.0], [0.0, 0.0, 0.0], [2.0] * 3, [2.0] * 3, [0.0] * 3)
    assert counts[4].tolist() == [0, 0, 1, 2, 2, 2, 2, 1, 0]  # along y = 0
    assert counts[4 + 2].tolist() == [0, 0, 0, 0, 1, 1, 0, 0, 0]  # y = 2: the tops alone


def test_an_ellipse_lies_along_its_azimuth():
    x = y = np.linspace(-3.0, 3.0, 61)
    counts = hit_counts(x, y, [0.0], [0.0], [2.0], [0.5], [np.pi / 4])
    at = lambda a, b: counts[np.argmin(abs(y - b)), np.argmin(abs(x - a))]  # noqa: E731
    assert at(1.2, 1.2) == 1 and at(1.2, -1.2) == 0


def test_points_struck_are_the_covered_share():
    rng = np.random.default_rng(5)
    n, side = 200, 4.0
    x, y, major = rng.uniform(-2.2, 2.2, n), rng.uniform(-2.2, 2.2, n), rng.uniform(0.1, 0.3, n)
    minor, azimuth = 0.7 * major, rng.uniform(0.0, np.pi, n)
    grid = (np.arange(400) + 0.5) * side / 400 - side / 2
    counts = hit_counts(grid, grid, x, y, major, minor, azimuth)
    history = coverage_history(x, y, np.arange(n), major, minor, azimuth, (side, side), side / 400)
    assert (counts > 0).mean() == pytest.approx(history.coverage[-1], abs=2e-5)
