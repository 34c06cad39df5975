"""Dimples by closed forms, to be compared with the computed library: radius over the shot's, in SI.

All spend the shot's kinetic energy of normal motion on pushing material away at a constant mean pressure p, so that

    a/R = (8 s rho v^2 / (3 p))^(1/4)                                                                  (1)

up to the share s of the energy that is spent: shot density rho, shallow cap a^2 = 2 R depth.  They differ in s and p:

    Kirk             s = 1 - e^2, p = B, the Brinell hardness          glue.theory.kirk                 grade D given B
    Al-Hassani       s = 1, p = 3 Y, Y the yield stress; depth/R = sqrt(2 rho v^2 / (3 p)),
                     the solution of m dv/dt = -pi a^2 p                                                grade C
    Shen and Atluri  s = .8, the share they call efficiency; p = 3 Y    CMC 4(2), 75-85 (2006)           grade C
    after Nguyen     Kirk's form with the normal part v sin(angle) of an oblique shot, s = 1 - e^2; the dimple longer by
                     1/sin(angle) along the flight.  Nguyen, Poh and Zhang (2014), Powder Technology 256, 100-112
                                                                                                        grade C
Grades: D derived, C from memory or unverified.  That the titles and pages exist was looked up, the equations of the
last three were not; each follows from (1) as written here.  Standard library and numpy only.
"""

from __future__ import annotations

import math

import numpy as np

from glue.errors import InputError
from glue.theory import kirk

TABOR = 3.0  # mean pressure over yield stress in full plasticity
EFFICIENCY = 0.8  # Shen and Atluri
GRADES = {"kirk": "D given B and e", "al-hassani": "C", "shen-atluri": "C", "nguyen": "C"}


def energy_radius(density_kg_m3, normal_speed_m_s, pressure_Pa, share=1.0):
    """Dimple radius over shot radius, equation (1) (floats or arrays, broadcast)."""
    return (8.0 * share * density_kg_m3 * np.square(normal_speed_m_s) / (3.0 * pressure_Pa)) ** 0.25


def al_hassani_radius(density_kg_m3, normal_speed_m_s, yield_Pa):
    """Dimple radius over shot radius with all energy spent at three times the yield stress."""
    return energy_radius(density_kg_m3, normal_speed_m_s, TABOR * yield_Pa)


def al_hassani_depth(density_kg_m3, normal_speed_m_s, yield_Pa):
    """Dimple depth over shot radius: sqrt(2 rho v^2 / (9 Y))."""
    return np.sqrt(2.0 * density_kg_m3 * np.square(normal_speed_m_s) / (3.0 * TABOR * yield_Pa))


def shen_atluri_radius(density_kg_m3, normal_speed_m_s, yield_Pa):
    """Dimple radius over shot radius with EFFICIENCY of the energy spent at three times the yield stress."""
    return energy_radius(density_kg_m3, normal_speed_m_s, TABOR * yield_Pa, EFFICIENCY)


def kirk_radius(density_kg_m3, normal_speed_m_s, hardness_Pa, restitution):
    """Dimple radius over shot radius after Kirk."""
    return kirk.dimple_diameter_m(1.0, density_kg_m3, normal_speed_m_s, hardness_Pa, restitution)


def nguyen_semi_axes(density_kg_m3, speed_m_s, angle_deg, hardness_Pa, restitution):
    """Semi-axes over shot radius of an oblique shot's dimple: (along the flight, across).

    ``angle_deg`` from the surface, above 0 to 90 (InputError); ``speed_m_s`` the whole speed.
    """
    if not (np.all(np.asarray(angle_deg) > 0.0) and np.all(np.asarray(angle_deg) <= 90.0)):
        raise InputError(f"angle_deg = {angle_deg}: must lie above 0, up to 90 degrees from the surface")
    sine = np.sin(np.asarray(angle_deg) * math.pi / 180.0)
    across = kirk_radius(density_kg_m3, speed_m_s * sine, hardness_Pa, restitution)
    return across / sine, across


def hardness_Pa(flow_stress_Pa: float) -> float:
    """Indentation hardness of a material whose flow stress at Tabor's representative strain (.08) is this."""
    return TABOR * flow_stress_Pa
