"""Waves that an impact sends out: against published shares, Hunter's exponent and the exact Rayleigh speed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.theory import hertz
from glue.theory.radiation import (
    expected_share,
    radiated_J,
    radiation,
    rayleigh_root,
    restitution_with_waves,
)


def test_shares_of_miller_and_pursey():
    """nu = 1/4: two thirds leave as Rayleigh waves (67.4 %); their body waves, 6.9 and 25.8 %, together 32.6 %."""
    parts = radiation(0.25)
    assert parts.rayleigh / parts.kappa == pytest.approx(0.674, abs=5e-4)
    assert (parts.pressure + parts.shear) / parts.kappa == pytest.approx(0.326, abs=5e-4)


def test_rayleigh_speed():
    """nu = 1/4: (c_R / c_s)^2 = 2 - 2/sqrt(3), exact."""
    assert 1.0 / rayleigh_root(0.25) ** 2 == pytest.approx(2.0 - 2.0 / math.sqrt(3.0), rel=1e-12)


def hertz_share(speed: float) -> float:
    """Share radiated by a steel sphere on a steel half-space, its Hertz force stepped through."""
    E, nu, density, radius = 210e9, 0.29, 7800.0, 0.5e-3
    modulus = hertz.effective_modulus_Pa(E, nu, E, nu)
    exact = hertz.impact(radius, density, speed, modulus)
    mass, stiff = density * 4.0 / 3.0 * math.pi * radius**3, 4.0 / 3.0 * modulus * math.sqrt(radius)
    step, depth, velocity, force = exact.contact_time_s / 4000, 0.0, speed, [0.0]
    for _ in range(4000):
        velocity -= 0.5 * step * force[-1] / mass
        depth += step * velocity
        force.append(stiff * max(depth, 0.0) ** 1.5)
        velocity -= 0.5 * step * force[-1] / mass
    return radiated_J(step * np.arange(4001), np.array(force), E, nu, density) / (0.5 * mass * speed**2)


def test_hunters_law_for_elastic_impacts():
    """Share ~ (v/c)^(3/5), c = sqrt(E/rho); Hunter's own factor, 1.04 (quoted, B), used a half sine for the force."""
    slow, fast = hertz_share(1.0), hertz_share(10.0)
    assert math.log10(fast / slow) == pytest.approx(0.6, abs=1e-6)
    assert slow / (1.0 / math.sqrt(210e9 / 7800.0)) ** 0.6 == pytest.approx(1.04, rel=0.1)


def test_a_lighter_shot_rebounds_sooner_and_radiates_more():
    """Dent resistance alone sets the force, so the share goes with the contact time, 1/sqrt(density of the shot)."""
    steel, glass = (
        expected_share(73.1e9, 0.33, 2780.0, shot_density_kg_m3=d, flow_stress_Pa=480e6, restitution=0.34)
        for d in (7800.0, 2500.0)
    )
    assert glass / steel == pytest.approx(math.sqrt(7800.0 / 2500.0), rel=1e-12)
    assert 0.0 < steel < 0.1
    assert restitution_with_waves(0.34, glass) < restitution_with_waves(0.34, steel) < 0.34
    assert restitution_with_waves(0.1, 0.9) == 0.0


@pytest.mark.parametrize("nu", [-0.1, 0.5, math.nan])
def test_poissons_ratio_outside_is_refused(nu):
    with pytest.raises(InputError, match="allowed"):
        radiation(nu)
