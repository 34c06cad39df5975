"""Closed-form dimples: the energy they spend, their exponents, and how they agree where they must."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.theory import dimple_formulas as formulas
from glue.theory import kirk

RHO, V, Y, B, E = 7800.0, 60.0, 369e6, 1.2e9, 0.34


def test_all_energy_is_work_of_the_pressure_on_the_dent():
    """m v^2 / 2 = p V with the shallow cap V = pi a^4 / (4 R), R = 1."""
    a = formulas.al_hassani_radius(RHO, V, Y)
    assert 3 * Y * math.pi * a**4 / 4 == pytest.approx(0.5 * RHO * 4 / 3 * math.pi * V**2, rel=1e-12)
    assert formulas.al_hassani_depth(RHO, V, Y) == pytest.approx(a**2 / 2, rel=1e-12)


def test_al_hassanis_depth_is_where_his_equation_of_motion_stops():
    """m dv/dt = -2 pi depth p (R = 1) by leap-frog steps."""
    mass, p, depth, v = 4 / 3 * math.pi * RHO, 3 * Y, 0.0, V
    dt = 1e-7
    while v > 0.0:
        depth += 0.5 * dt * v
        v -= dt * 2 * math.pi * depth * p / mass
        depth += 0.5 * dt * v
    assert depth == pytest.approx(float(formulas.al_hassani_depth(RHO, V, Y)), rel=1e-4)


def test_kirk_without_rebound_and_with_that_hardness_is_al_hassani():
    assert formulas.kirk_radius(RHO, V, 3 * Y, 0.0) == pytest.approx(formulas.al_hassani_radius(RHO, V, Y), rel=1e-12)
    d = kirk.dimple_diameter_m(1e-3, RHO, V, B, E)
    assert formulas.kirk_radius(RHO, V, B, E) == pytest.approx(d / 1e-3, rel=1e-12)
    ratio = formulas.shen_atluri_radius(RHO, V, Y) / formulas.al_hassani_radius(RHO, V, Y)
    assert ratio == pytest.approx(0.8**0.25, rel=1e-12)


def test_radius_goes_with_the_root_of_the_speed_and_the_fourth_root_of_density_over_pressure():
    for radius in (formulas.al_hassani_radius, formulas.shen_atluri_radius):
        speeds = np.array([1.0, 4.0, 100.0])
        assert radius(RHO, speeds, Y) == pytest.approx(radius(RHO, 1.0, Y) * speeds**0.5, rel=1e-12)
        assert radius(16 * RHO, V, Y) == pytest.approx(2 * radius(RHO, V, Y), rel=1e-12)
        assert radius(RHO, V, 16 * Y) == pytest.approx(0.5 * radius(RHO, V, Y), rel=1e-12)


def test_an_oblique_shot_leaves_the_dimple_of_its_normal_part_drawn_out():
    along, across = formulas.nguyen_semi_axes(RHO, V, 90.0, B, E)
    assert along == across == pytest.approx(formulas.kirk_radius(RHO, V, B, E), rel=1e-12)
    along, across = formulas.nguyen_semi_axes(RHO, V, 30.0, B, E)
    assert across == pytest.approx(formulas.kirk_radius(RHO, 0.5 * V, B, E), rel=1e-12)
    assert along == pytest.approx(2 * across, rel=1e-12)
    for angle in (0.0, -5.0, 91.0):
        with pytest.raises(InputError, match="above 0, up to 90"):
            formulas.nguyen_semi_axes(RHO, V, angle, B, E)
