"""Elastic impact of a sphere on a half-space, and the stress under it.

Sources: H. Hertz (1882); formulas as in K. L. Johnson, *Contact Mechanics* (1985), eqs. 3.42-3.49 and 11.2.
Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.errors import InputError

# t_c v / depth = 2 * integral of dx / sqrt(1 - x^2.5) over 0..1, a Beta function: 2.9432...
CONTACT_TIME_FACTOR = 0.8 * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)


class Impact(NamedTuple):
    """What the elastic impact reaches at its deepest point, and how long it lasts."""

    depth_m: float
    force_N: float
    contact_radius_m: float
    peak_pressure_Pa: float
    contact_time_s: float


def effective_modulus_Pa(E1_Pa: float, nu1: float, E2_Pa: float = math.inf, nu2: float = 0.0) -> float:
    """Contact modulus E* [Pa], 1/E* = (1-nu1^2)/E1 + (1-nu2^2)/E2; an infinite E is a rigid body."""
    return 1.0 / ((1.0 - nu1**2) / E1_Pa + (1.0 - nu2**2) / E2_Pa)


def impact(radius_m: float, density_kg_m3: float, speed_m_s: float, modulus_Pa: float) -> Impact:
    """Normal elastic impact of a sphere on a fixed half-space with contact modulus ``modulus_Pa`` (E*).

    depth = (15 m v^2 / (16 sqrt(R) E*))^(2/5), F = 4/3 E* sqrt(R) depth^1.5, a = sqrt(R depth),
    p0 = 2 E* a / (pi R), t = 2.9432 depth / v.  All arguments must be positive and finite (InputError).
    """
    values = {
        "radius_m": radius_m,
        "density_kg_m3": density_kg_m3,
        "speed_m_s": speed_m_s,
        "modulus_Pa": modulus_Pa,
    }
    bad = [
        f"{name} = {value}: must be positive and finite"
        for name, value in values.items()
        if not (value > 0.0 and math.isfinite(value))
    ]
    if bad:
        raise InputError(bad)
    mass = density_kg_m3 * 4.0 / 3.0 * math.pi * radius_m**3
    depth = (15.0 * mass * speed_m_s**2 / (16.0 * math.sqrt(radius_m) * modulus_Pa)) ** 0.4
    contact_radius = math.sqrt(radius_m * depth)
    return Impact(
        depth_m=depth,
        force_N=4.0 / 3.0 * modulus_Pa * math.sqrt(radius_m) * depth**1.5,
        contact_radius_m=contact_radius,
        peak_pressure_Pa=2.0 * modulus_Pa * contact_radius / (math.pi * radius_m),
        contact_time_s=CONTACT_TIME_FACTOR * depth / speed_m_s,
    )


def axis_stress(depth_over_a, nu: float):
    """(sigma_r, sigma_z) / p0 on the axis at depth z/a >= 0 (float or array; Johnson 3.45).

    The hoop stress equals sigma_r there, so the largest shear is |sigma_z - sigma_r| / 2.
    """
    s = np.asarray(depth_over_a, dtype=float)
    decay = 1.0 / (1.0 + s**2)
    # arctan2 keeps the limit s -> 0, where s * arctan(1/s) -> 0
    sigma_r = -(1.0 + nu) * (1.0 - s * np.arctan2(1.0, s)) + 0.5 * decay
    return sigma_r, -decay


def surface_stress(r_over_a, nu: float):
    """(sigma_r, sigma_theta) / p0 on the surface at radius r/a >= 0 (float or array; Johnson 3.42-3.43)."""
    r = np.asarray(r_over_a, dtype=float)
    q = np.maximum(r * r, 1e-12)  # the centre is a limit; 1e-12 keeps it to nine digits
    root = np.sqrt(np.maximum(1.0 - q, 0.0))
    # (1 - (1-q)^1.5)/q without cancellation for small q: 1-c^3 = (1-c)(1+c+c^2) and q = (1-c)(1+c), c = root
    inside = (1.0 + root + root**2) / (1.0 + root)
    ring = (1.0 - 2.0 * nu) / 3.0 * np.where(q < 1.0, inside, 1.0 / q)
    return ring - root, -ring - 2.0 * nu * root
