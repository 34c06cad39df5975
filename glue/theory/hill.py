"""Hill's thick spherical shell, elastic-perfectly plastic, under internal pressure; loaded and after unloading.

R. Hill, The Mathematical Theory of Plasticity (1950), chapter V.  Stresses over the yield stress, radii over the
inner radius; the shell reaches from 1 to ``b``.
"""

from __future__ import annotations

import numpy as np


def pressure_for_radius(c: float, b: float) -> float:
    """Pressure over yield stress that brings the elastic-plastic boundary to radius ``c`` (1 <= c <= b)."""
    return 2.0 * np.log(c) + 2.0 / 3.0 * (1.0 - (c / b) ** 3)


def elastic_stress(r, p: float, b: float):
    """Lamé's radial and hoop stress at ``r`` (array) for pressure ``p``: two arrays."""
    r = np.asarray(r, dtype=float)
    k = p / (b**3 - 1.0)
    return k * (1.0 - (b / r) ** 3), k * (1.0 + 0.5 * (b / r) ** 3)


def loaded_stress(r, c: float, b: float):
    """Radial and hoop stress over yield stress at ``r`` with the plastic zone grown to ``c``: two arrays."""
    r = np.asarray(r, dtype=float)
    radial = np.where(r < c, 2.0 * np.log(r / c) - 2.0 / 3.0 * (1.0 - (c / b) ** 3),
                      -2.0 / 3.0 * ((c / r) ** 3 - (c / b) ** 3))  # fmt: skip
    hoop = np.where(r < c, radial + 1.0, 2.0 / 3.0 * (0.5 * (c / r) ** 3 + (c / b) ** 3))
    return radial, hoop


def residual_stress(r, c: float, b: float):
    """Radial and hoop stress over yield stress at ``r`` after elastic unloading: two arrays."""
    loaded, springback = loaded_stress(r, c, b), elastic_stress(r, pressure_for_radius(c, b), b)
    return loaded[0] - springback[0], loaded[1] - springback[1]


def outer_displacement(c: float, b: float, E_over_Y: float, nu: float) -> float:
    """Radial displacement of the outer surface over the inner radius, with the plastic zone at ``c``."""
    return (1.0 - nu) * c**3 / (E_over_Y * b**2)
