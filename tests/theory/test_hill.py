"""Hill's sphere against values worked out independently (a = 1, b = 2, Y = 1)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.theory import hill


def test_limits_and_pressure():
    assert hill.pressure_for_radius(1.0, 2.0) == pytest.approx(0.583333, abs=1e-6)  # first yield
    assert hill.pressure_for_radius(2.0, 2.0) == pytest.approx(1.386294, abs=1e-6)  # collapse, 2 ln 2
    assert hill.pressure_for_radius(1.4, 2.0) == pytest.approx(1.110944, abs=1e-6)


@pytest.mark.parametrize(("r", "radial", "hoop"), [(1.2, -0.7463, 0.2537), (1.7, -0.14368, 0.41484)])
def test_loaded(r, radial, hoop):
    assert [float(s) for s in hill.loaded_stress(r, 1.4, 2.0)] == pytest.approx([radial, hoop], abs=5e-5)


@pytest.mark.parametrize(("r", "radial", "hoop"), [(1.0, 0.0, -0.90448), (1.4, -0.13401, 0.17194)])
def test_residual(r, radial, hoop):
    assert [float(s) for s in hill.residual_stress(r, 1.4, 2.0)] == pytest.approx([radial, hoop], abs=5e-6)


def test_equilibrium():
    """d(sigma_r)/dr = 2 (sigma_t - sigma_r)/r everywhere, loaded and residual."""
    r = np.linspace(1.01, 1.99, 99)
    for field in (hill.loaded_stress, hill.residual_stress):
        slope = (field(r + 1e-6, 1.4, 2.0)[0] - field(r - 1e-6, 1.4, 2.0)[0]) / 2e-6
        radial, hoop = field(r, 1.4, 2.0)
        keep = abs(r - 1.4) > 1e-3
        assert slope[keep] == pytest.approx((2 * (hoop - radial) / r)[keep], abs=1e-6)


def test_outer_displacement_follows_from_the_hoop_stress():
    """u(b)/b is the hoop strain (sigma_t (1 - nu))/E there, sigma_r being zero."""
    hoop = hill.loaded_stress(2.0, 1.4, 2.0)[1]
    assert hill.outer_displacement(1.4, 2.0, 100.0, 0.3) == pytest.approx(2.0 * float(hoop) * 0.7 / 100.0)
    assert math.isfinite(hill.outer_displacement(1.4, 2.0, 100.0, 0.3))
