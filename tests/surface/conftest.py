"""A dimple in closed form, near the reference impact (1 mm steel at 60 m/s on 2024), and impacts of it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from glue.flow.impacts import COLUMNS


@pytest.fixture(scope="session")
def dimple():
    """A cap 52.4 um deep that meets z = 0 at 227 um, with the solved dimple's pile-up (within 1 um)."""
    a, depth, crest = 227e-6, 52.4e-6, 8.2e-6
    sphere = (a**2 + depth**2) / (2 * depth)
    r = np.linspace(0.0, 5 * a, 2001)
    dent = sphere - depth - np.sqrt(sphere**2 - np.minimum(r, a) ** 2)
    rise = np.sin(0.5 * np.pi * np.clip((r / a - 1.0) / 0.13, 0.0, 1.0))
    fall = np.exp(-np.maximum(r / a - 1.13, 0.0) / 0.55)
    return SimpleNamespace(
        radius_m=a,
        depth_m=depth,
        restitution=0.34,
        contact_time_s=2e-6,
        speed_m_s=60.0,
        diameter_m=1e-3,
        density_kg_m3=7800.0,
        speed_exponent=0.5,
        profile_r_m=r,
        profile_z_m=np.where(r < a, dent, crest * rise * fall),
        radius_for=lambda d, v, rho=7800.0: (
            a * np.asarray(d) / 1e-3 * (np.asarray(v) / 60.0 * np.sqrt(np.asarray(rho) / 7800.0)) ** 0.5
        ),
    )


@pytest.fixture(scope="session")
def make_impacts():
    """make_impacts(x_m, y_m, speed_m_s=60, diameter_m=1e-3, time_s=0, 1, 2, ..., density_kg_m3=7800) -> impact rows (n,)."""

    def make(x_m, y_m, speed_m_s=60.0, diameter_m=1e-3, time_s=None, density_kg_m3=7800.0):
        rows = np.zeros(len(x_m), COLUMNS)
        rows["x_m"], rows["y_m"] = x_m, y_m
        rows["time_s"] = np.arange(len(x_m)) if time_s is None else time_s
        rows["vz_in_m_s"], rows["nz"] = -speed_m_s, 1.0
        rows["diameter_m"], rows["density_kg_m3"] = diameter_m, density_kg_m3
        return rows

    return make
