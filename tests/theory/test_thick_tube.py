"""The thick tube: reference numbers, equilibrium, and its limits."""

from __future__ import annotations

import numpy as np
import pytest

from glue.theory import thick_tube as tube


def test_reference_numbers():
    assert tube.first_yield(2.0, 0.5) == pytest.approx(0.433013, abs=1e-6)
    assert tube.collapse(2.0) == pytest.approx(0.800377, abs=1e-6)
    assert tube.pressure_for_radius(1.4, 2.0) == pytest.approx(0.682973, abs=1e-6)
    assert tube.pressure_for_radius(1.0, 2.0) == pytest.approx(tube.first_yield(2.0, 0.5), rel=1e-14)
    assert tube.pressure_for_radius(2.0, 2.0) == pytest.approx(tube.collapse(2.0), rel=1e-14)


def test_first_yield_is_mises_on_lames_stresses():
    radial, hoop, axial = tube.elastic_stress(np.array([1.0]), tube.first_yield(2.0, 0.3), 2.0, 0.3)
    mises = np.sqrt(0.5 * ((radial - hoop) ** 2 + (hoop - axial) ** 2 + (axial - radial) ** 2))
    assert mises == pytest.approx([1.0], rel=1e-14)


def test_stresses_balance_and_carry_the_pressure():
    """d(r s_r)/dr = s_theta through the wall, s_r = -p inside and 0 outside, continuous at c."""
    r, h = np.linspace(1.02, 1.98, 33), 1e-5
    assert np.abs(r - 1.4).min() > 2 * h
    _, hoop, _ = tube.loaded_stress(r, 1.4, 2.0)
    above, below = (tube.loaded_stress(r + s, 1.4, 2.0)[0] * (r + s) for s in (h, -h))
    np.testing.assert_allclose((above - below) / (2 * h), hoop, atol=1e-9)
    assert tube.loaded_stress(1.0, 1.4, 2.0)[0] == pytest.approx(-tube.pressure_for_radius(1.4, 2.0), rel=1e-14)
    assert tube.loaded_stress(2.0, 1.4, 2.0)[0] == pytest.approx(0.0, abs=1e-15)
    sides = [tube.loaded_stress(1.4 + s, 1.4, 2.0) for s in (-1e-9, 1e-9)]
    np.testing.assert_allclose(sides[0], sides[1], atol=1e-8)
