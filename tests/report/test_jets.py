"""Outlines of jets against the ellipse of a parallel jet and rays traced by hand; ways of a feed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.report.jets import footprint, way
from glue.scene.model import Feed, Nozzle


def test_a_parallel_oblique_jet_is_an_ellipse_along_its_lean():
    nozzle = Nozzle(60.0, 0.01, 0.02, 0.1, 30.0, azimuth_deg=90.0, aim_m=(1e-3, 2e-3))
    x, y = (footprint(nozzle) - [1e-3, 2e-3]).T
    # 10 mm across, 10/sin 30 = 20 mm along y, whither it leans
    assert (x / 0.01) ** 2 + (y / 0.02) ** 2 == pytest.approx(np.ones(x.size))


def test_a_diverging_jet_reaches_further_on_the_far_side():
    """At 45 degrees and half-angle 5: edge rays at 40 and 50 degrees from the surface, from the exit's edge."""
    nozzle = Nozzle(60.0, 0.01, 0.02, 0.1, 45.0, divergence_half_angle_deg=5.0)
    x = footprint(nozzle)[:, 0]
    c = math.sqrt(0.5)
    high, low = 0.1 * c + 0.01 * c, 0.1 * c - 0.01 * c  # heights of the exit's upper and lower edge
    exit_high, exit_low = -0.1 * c + 0.01 * c, -0.1 * c - 0.01 * c
    assert x.max() == pytest.approx(exit_high + high / math.tan(math.radians(40.0)), rel=1e-12)
    assert x.min() == pytest.approx(exit_low + low / math.tan(math.radians(50.0)), rel=1e-3)


def test_the_way_of_three_passes():
    nozzle = Nozzle(60.0, 0.01, 0.02, 0.1, 90.0, feed=Feed(0.02, 0.02, passes=3, pitch_m=0.003, dwell_s=0.1))
    expected = [(-10, -3), (10, -3), (10, 0), (-10, 0), (-10, 3), (10, 3)]
    found = way(nozzle, nozzle.feed.duration_s)
    assert found[:5] * 1e3 == pytest.approx(np.array(expected[:5]), abs=1e-9)
    assert found[-1] * 1e3 == pytest.approx(np.array(expected[5]), abs=1e-9)
    cut = way(nozzle, 0.5)  # half of the first stroke
    assert cut * 1e3 == pytest.approx(np.array([(-10, -3), (0, -3)]), abs=1e-9)
