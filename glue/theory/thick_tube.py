"""A thick tube in plane strain under internal pressure, Mises, perfectly plastic; stresses over the yield stress.

R. Hill, The Mathematical Theory of Plasticity (1950), chapter V.  Radii over the inner radius; the wall reaches from
1 to ``b``.  First yield is exact for every Poisson's ratio (Lame's stresses, axial stress nu times their sum).  So is the
collapse pressure, which no elastic constant enters.  In between the plastic solution is exact for nu -> 1/2 only, where
the axial stress is the mean of the other two and yield means that they differ by 2/sqrt(3).
"""

from __future__ import annotations

import numpy as np

K = 1.0 / np.sqrt(3.0)  # shear yield stress over yield stress


def first_yield(b: float, nu: float) -> float:
    """Pressure at which the inner surface yields."""
    return (b**2 - 1.0) / np.sqrt(3.0 * b**4 + (1.0 - 2.0 * nu) ** 2)


def collapse(b: float) -> float:
    """Pressure that no state of the whole wall can bear."""
    return 2.0 * K * np.log(b)


def pressure_for_radius(c: float, b: float) -> float:
    """Pressure that brings the elastic-plastic boundary to radius ``c`` (1 <= c <= b), nu -> 1/2."""
    return K * (2.0 * np.log(c) + 1.0 - (c / b) ** 2)


def elastic_stress(r, p: float, b: float, nu: float):
    """Radial, hoop and axial stress at ``r`` (array): Lame."""
    r = np.asarray(r, dtype=float)
    mean = p / (b**2 - 1.0)
    return mean * (1.0 - (b / r) ** 2), mean * (1.0 + (b / r) ** 2), np.full_like(r, 2.0 * nu * mean)


def loaded_stress(r, c: float, b: float):
    """Radial, hoop and axial stress at ``r`` (array) with the plastic zone grown to ``c``, nu -> 1/2."""
    r = np.asarray(r, dtype=float)
    inside = r < c
    radial = np.where(inside, K * (2.0 * np.log(r / c) - 1.0 + (c / b) ** 2), K * ((c / b) ** 2 - (c / r) ** 2))
    hoop = np.where(inside, radial + 2.0 * K, K * ((c / b) ** 2 + (c / r) ** 2))
    return radial, hoop, 0.5 * (radial + hoop)
