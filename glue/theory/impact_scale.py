"""Rough size and duration of an impact before it is solved: they set mesh, domain and time step, no result.

Lengths in shot radii R, time in R/(1 m/s), stress in MPa, density in MPa s2/m2 = 1e6 kg/m3.
"""

from __future__ import annotations

import math
from typing import NamedTuple

MEAN_PRESSURE_OVER_FLOW_STRESS = 3.0  # Tabor's constraint factor of full plasticity
REPRESENTATIVE_STRAIN = 0.08  # Tabor: about 8 % under a spherical indenter
CONTACT_OVER_LOADING = 1.35  # contact time over loading time of plastic impacts; .34-.43 of the speed comes back


class Scale(NamedTuple):
    radius: float  # dimple radius [R]
    duration: float  # contact time [R/(1 m/s)]
    penetration: float  # [R]


def expected_impact(E: float, nu: float, flow_stress: float, density: float, speed: float) -> Scale:
    """Scale of a rigid sphere's normal impact: the larger of Tabor's rigid-plastic and Hertz's elastic one.

    E, flow_stress [MPa] (at REPRESENTATIVE_STRAIN), density of the shot [1e6 kg/m3], speed [m/s].
    Plastic: force 2 pi p delta, a half oscillation; elastic: Hertz with E/(1 - nu^2).
    """
    mass = 4.0 / 3.0 * math.pi * density
    stiffness = 2.0 * math.pi * MEAN_PRESSURE_OVER_FLOW_STRESS * flow_stress
    plastic = speed * math.sqrt(mass / stiffness)
    elastic = (15.0 * mass * speed**2 / (16.0 * E / (1.0 - nu**2))) ** 0.4
    return Scale(
        radius=min(
            max(
                math.sqrt(max(2.0 * plastic - plastic**2, 0.0)) if plastic < 1.0 else 1.0, math.sqrt(elastic)
            ),
            1.0,
        ),
        duration=max(CONTACT_OVER_LOADING * 0.5 * math.pi * math.sqrt(mass / stiffness), 2.9432 * elastic / speed),
        penetration=max(plastic, elastic),
    )
