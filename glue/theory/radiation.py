"""Energy that an impact sends into a half-space as elastic waves, in closed form but for one integral.

A force F(t) on a patch small against the wave length moves its place by F's own static give plus, out of phase,
kappa/(G c_s) dF/dt: what is done on that part never comes back.

    (1) W = kappa(nu) / (rho c_s^3) * integral of (dF/dt)^2 dt
    (2) kappa = 1/(2 pi) Im integral of x p / R(x) dx,  p = sqrt(x^2 - g^2),  g^2 = (1 - 2 nu) / (2 (1 - nu)),
        R = (2 x^2 - 1)^2 - 4 x^2 p sqrt(x^2 - 1)      over 0 < x < 1 (body waves) and at Rayleigh's pole R = 0

(2) is H. Lamb's (1904) surface response under the load; its shares are those of G. F. Miller & H. Pursey, Proc. R. Soc.
Lond. A 233 (1955) 55.  (1) in this use: S. C. Hunter, J. Mech. Phys. Solids 5 (1957) 162, who finds a share of the
kinetic energy ~ (v/c)^(3/5) for elastic impacts, and I. M. Hutchings, J. Phys. D 12 (1979) 1819, for plastic ones.
Standard library and numpy only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.errors import InputError


class Radiation(NamedTuple):
    """kappa of (1) in its parts."""

    pressure: float  # x < g: pressure waves and the shear waves that go with them
    shear: float
    rayleigh: float

    @property
    def kappa(self) -> float:
        return self.pressure + self.shear + self.rayleigh


def radiation(nu: float) -> Radiation:
    """The integral (2) for Poisson's ratio ``nu`` in [0, .49]; InputError outside."""
    if not 0.0 <= nu <= 0.49:
        raise InputError(f"Poisson's ratio {nu}: allowed 0 to 0.49")
    g = math.sqrt((1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)))
    points, weights = np.polynomial.legendre.leggauss(200)
    # x = g sin t and x^2 = g^2 + (1 - g^2) sin^2 t take the square roots' ends out of the integrands
    t, dt = 0.25 * math.pi * (points + 1.0), 0.25 * math.pi * weights
    x = g * np.sin(t)
    a, b = g * np.cos(t), np.sqrt(1.0 - x * x)
    slow = np.sum(dt * a * x * a / ((2.0 * x * x - 1.0) ** 2 + 4.0 * x * x * a * b))
    p, b = math.sqrt(1.0 - g * g) * np.sin(t), math.sqrt(1.0 - g * g) * np.cos(t)
    x = np.sqrt(g * g + p * p)
    fast = np.sum(dt * p * b / x * x * p * 4.0 * x * x * p * b / ((2.0 * x * x - 1.0) ** 4 + (4.0 * x * x * p * b) ** 2))
    pole = rayleigh_root(nu)
    p, s = math.sqrt(pole**2 - g * g), math.sqrt(pole**2 - 1.0)
    slope = 8.0 * pole * (2.0 * pole**2 - 1.0) - 8.0 * pole * p * s - 4.0 * pole**3 * (s / p + p / s)
    surface = math.pi * pole * p / abs(slope)
    return Radiation(*(float(v) / (2.0 * math.pi) for v in (slow, fast, surface)))


def rayleigh_root(nu: float) -> float:
    """c_s / c_Rayleigh (> 1): where R of (2) vanishes, by bisection."""
    g2 = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu))
    low, high = 1.0, 2.0
    for _ in range(60):
        x2 = (0.5 * (low + high)) ** 2
        if (2.0 * x2 - 1.0) ** 2 - 4.0 * x2 * math.sqrt((x2 - g2) * (x2 - 1.0)) > 0.0:
            low = 0.5 * (low + high)
        else:
            high = 0.5 * (low + high)
    return 0.5 * (low + high)


def radiated_J(time_s, force_N, E_Pa: float, nu: float, density_kg_m3: float) -> float:
    """(1) for a force given at times (n,), straight lines between; consistent units of any system will do."""
    shear = E_Pa / (2.0 * (1.0 + nu))
    rate2 = np.sum(np.diff(force_N) ** 2 / np.diff(time_s))
    return float(radiation(nu).kappa / (density_kg_m3 * (shear / density_kg_m3) ** 1.5) * rate2)


def expected_share(
    E_Pa: float, nu: float, density_kg_m3: float, *, shot_density_kg_m3: float, flow_stress_Pa: float, restitution: float,
) -> float:  # fmt: skip
    """Share of the shot's energy that goes into waves, before anything is solved: the target's E, nu, density first.

    Loading and unloading are quarter oscillations against the pressure 3 * flow stress (Tabor) of a fully plastic dent,
    m v omega sin(omega t) in, and out with the same force in ``restitution`` times the time.  Shot size and speed drop
    out: a plastic impact lasts as long at any speed.  Too much at speeds where a dent is not fully plastic (+40 % at
    10 m/s on 2024), and no use for elastic impacts.
    """
    mass, stiffness = 4.0 / 3.0 * math.pi * shot_density_kg_m3, 6.0 * math.pi * flow_stress_Pa
    omega = math.sqrt(stiffness / mass)
    rate2_over_speed2 = (mass * omega) ** 2 * omega * math.pi / 4.0 * (1.0 + 1.0 / restitution)
    wave = math.sqrt(E_Pa / (2.0 * (1.0 + nu)) / density_kg_m3)
    return radiation(nu).kappa / (density_kg_m3 * wave**3) * rate2_over_speed2 / (0.5 * mass)


# Waves sent while the shot goes in are mostly paid for by plastic work, those while it comes out by the rebound.
# Fitted to the solver: .53-.55 of (1) of the force's history, 10, 60, 120 m/s on 2024.  Grade: fitted here.
REBOUND_SHARE = 0.54


def restitution_with_waves(restitution: float, share: float) -> float:
    """Restitution of a plastic impact once ``share`` (expected_share or radiated_J over the energy) is radiated."""
    return math.sqrt(max(restitution**2 - REBOUND_SHARE * share, 0.0))
