"""A free plate from a layer eigenstrain, against values worked out independently."""

from __future__ import annotations

import numpy as np
import pytest

from glue.theory.plate import arc_height_m, curvature_1_m, force_and_moment, released_stress


def layer(h, d, stress, edge=1e-9):
    """Stress in the top ``d`` of a plate ``h``, none below: a step as steep as ``edge``."""
    return np.array([0.0, d - edge, d + edge, h]), np.array([stress, stress, 0.0, 0.0])


def test_the_almen_strip_of_the_reference():
    """h 1.29, d .2 mm, eigenstrain 2e-3, E 205, nu .29: top -261.0, bottom -137.4 MPa."""
    z, s = layer(1.29e-3, 0.2e-3, -205e9 / 0.71 * 2e-3, 1e-12)
    freed = released_stress(z, s, 1.29e-3)
    assert freed[[0, -1]] == pytest.approx([-261.0e6, -137.4e6], abs=0.05e6)


@pytest.mark.parametrize(("strain", "curvature", "arc"), [(1e-3, 0.60931, 0.09597e-3), (2e-3, 1.21862, 0.19194e-3)])
def test_curvature_and_arc_height_of_an_almen_strip(strain, curvature, arc):
    """h 1.29, d .2 mm: 6 eps d (h - d)/h^3, and the gauge's reading; E and nu drop out."""
    z, s = layer(1.29e-3, 0.2e-3, -205e9 / 0.71 * strain, 1e-12)
    found = curvature_1_m(z, s, 1.29e-3, 205e9, 0.29)
    assert found == pytest.approx(curvature, rel=1e-5)
    assert arc_height_m(found) == pytest.approx(arc, rel=1e-4)


def test_no_force_and_no_moment_are_left():
    rng = np.random.default_rng(5)
    z = np.r_[0.0, np.sort(rng.uniform(0, 5e-3, 20)), 5e-3]
    freed = released_stress(z, rng.normal(0, 1e8, 22), 5e-3)
    force, moment = force_and_moment(z, freed, 2.5e-3)
    assert abs(force) < 1e-6 * 1e8 * 5e-3
    assert abs(moment) < 1e-6 * 1e8 * 5e-3**2


def test_uniform_and_linear_stress_are_released_whole():
    z = np.linspace(0.0, 2e-3, 7)
    assert released_stress(z, 3e8 - 1e11 * z, 2e-3) == pytest.approx(np.zeros(7), abs=1e-3)


@pytest.mark.parametrize("z", [[1e-4, 2e-3], [0.0, 1e-3], [0.0, 2e-3, 1e-3, 2e-3]])
def test_depths_that_do_not_span_the_plate_are_refused(z):
    with pytest.raises(ValueError, match="thickness"):
        released_stress(z, np.zeros(len(z)), 2e-3)
