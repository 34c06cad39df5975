"""Synthetic results that the fast tests of the target stage read."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.flow.impacts import COLUMNS
from glue.target.dimple import Dimple
from glue.target.reduced_impact import ReducedImpact


def dimple(radius_m: float = 227e-6, speed_m_s: float = 60.0, exponent: float = 0.47) -> Dimple:
    """A dimple of round numbers; the arrays that no test reads hold one entry."""
    one = np.zeros(1)
    return Dimple(
        radius_m=radius_m, depth_m=52.4e-6, crest_radius_m=250e-6, restitution=0.34, peak_force_N=261.0,
        contact_time_s=2.1e-6, speed_m_s=speed_m_s, diameter_m=1e-3, density_kg_m3=7800.0, speed_exponent=exponent,
        restitution_exponent=0.25,
        edge_peeq=0.2, largest_peeq=0.4, energy_error=0.0, dofs=1, wall_s=0.0, profile_r_m=one, profile_z_m=one, layer_depth_m=one,
        layer_stress_Pa=one, points_m=np.zeros((3, 2)), triangles=np.zeros((1, 3), int), peeq=one, sigma_rr_Pa=one,
    )  # fmt: skip


def impacts(x_m, y_m, speed_m_s=60.0, diameter_m=1e-3) -> np.ndarray:
    """An impact log of normal impacts, one a millisecond."""
    x_m = np.asarray(x_m, float)
    log = np.zeros(x_m.size, dtype=COLUMNS)
    log["x_m"], log["y_m"], log["vz_in_m_s"] = x_m, y_m, -np.asarray(speed_m_s, float)
    log["nz"] = 1.0
    log["diameter_m"], log["density_kg_m3"], log["time_s"] = diameter_m, 7800.0, 1e-3 * np.arange(x_m.size)
    return log


def reduced(surface_r, surface_z, points: dict | None = None) -> ReducedImpact:
    """A reduced impact with this surface and these Gauss points."""
    empty = {
        k: np.empty(0) for k in ("r", "z", "u_r", "u_z", "volume", "s_rr", "s_zz", "s_tt", "s_rz", "peeq")
    }
    return ReducedImpact(
        restitution=0.3, peak_force=1000.0, duration=4e-3, energy_error=0.0, failures=0, dofs=10, wall_s=1.0,
        surface_r=np.asarray(surface_r, float), surface_z=np.asarray(surface_z, float), points=points or empty,
        triangles=np.empty((0, 3, 2)), log=Path("impact/freefem.log"),
    )  # fmt: skip
