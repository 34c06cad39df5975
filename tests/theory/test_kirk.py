"""Kirk's dimple: its factor, its scaling, and the energy balance it stands for."""

from __future__ import annotations

import math

import pytest

from glue.theory import kirk

CASE = {"density_kg_m3": 7800.0, "hardness_Pa": 1.2e9, "restitution": 0.34}


def test_factor():
    assert kirk.FACTOR == pytest.approx(1.27789, abs=5e-6)


def test_energy_lost_is_hardness_times_dent_volume():
    diameter, speed = 1e-3, 60.0
    d = kirk.dimple_diameter_m(diameter, normal_speed_m_s=speed, **CASE)
    lost = 0.5 * (1 - 0.34**2) * 7800.0 * math.pi / 6 * diameter**3 * speed**2
    assert 1.2e9 * math.pi * d**4 / (32 * diameter) == pytest.approx(lost, rel=1e-12)
    assert kirk.dimple_depth_m(d, diameter) == pytest.approx(d**2 / 4e-3, rel=1e-15)


def test_scaling_with_size_and_speed():
    d = kirk.dimple_diameter_m(1e-3, normal_speed_m_s=60.0, **CASE)
    assert kirk.dimple_diameter_m(2e-3, normal_speed_m_s=60.0, **CASE) == pytest.approx(2 * d, rel=1e-12)
    assert kirk.dimple_diameter_m(1e-3, normal_speed_m_s=240.0, **CASE) == pytest.approx(2 * d, rel=1e-12)
