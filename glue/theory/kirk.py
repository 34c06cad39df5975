"""Dimple size from an energy balance (D. Kirk's formula): what the shot loses, hardness spends on the dent.

(1 - e^2) m v^2 / 2 = B * V with the shallow cap's volume V = pi d^4 / (32 D) gives the dimple diameter
d = (8/3)^(1/4) D ((1 - e^2) rho v^2 / B)^(1/4).  Hardness B and restitution e are inputs, not predictions.
Standard library and numpy only.
"""

from __future__ import annotations

import numpy as np

FACTOR = (8.0 / 3.0) ** 0.25  # 1.27789


def dimple_diameter_m(diameter_m, density_kg_m3, normal_speed_m_s, hardness_Pa, restitution):
    """Dimple diameter [m] of a shot of ``diameter_m`` at ``normal_speed_m_s`` (floats or arrays, broadcast).

    hardness_Pa: indentation hardness as a pressure (Brinell number in kgf/mm^2 times 9.80665e6).
    """
    lost = (1.0 - np.square(restitution)) * density_kg_m3 * np.square(normal_speed_m_s)
    return FACTOR * diameter_m * (lost / hardness_Pa) ** 0.25


def dimple_depth_m(dimple_diameter_m, diameter_m):
    """Depth [m] of the shallow cap d^2 / (4 D) that a sphere of diameter D leaves with dimple diameter d."""
    return np.square(dimple_diameter_m) / (4.0 * diameter_m)
