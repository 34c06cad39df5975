"""Which physics of a single impact matters: numbers for the blocks that a scene leaves to "auto".

Each number is the relative change of the restitution, which all of them move more than the dimple's radius, by closed
forms of elastoplastic impact with the target's flow stress Y at Tabor's representative strain:

    e ~ 3.8 sqrt(Y/E*) (m v^2 / (2 Y R^3))^(-1/8)                            (1)   K. L. Johnson (1985), eq. 11.47
    rate:     Y grows by 1 + C ln(rate/rate_ref), rate = .08 / loading time,
              e by that to the power 5/8                                     (2)   from (1)
    inertia:  e by the waves that the rebound pays for (``glue.theory.radiation``)   (3)
    shot:     E* of both instead of the target's alone, e by (E*'/E*)^(-1/2) (4)   from (1)

For steel on 2024 at 60 m/s the numbers are .08 for inertia, .06 for the rate (Lesuer's C) and .16 for an elastic shot;
this project's finite elements find .11, .025 and .11: good to a factor of 2.5, enough for a choice.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from glue.scene.model import Choice, Material, Scene, Shots
from glue.target.physics import ImpactPhysics
from glue.theory import hertz
from glue.theory.impact_scale import CONTACT_OVER_LOADING, REPRESENTATIVE_STRAIN, expected_impact
from glue.theory.radiation import expected_share, restitution_with_waves

# Numbers up to which a piece changes e by no more than TOLERANCE, as swept (make thresholds): they are off by what the
# closed forms are off.
THRESHOLDS = {"strain_rate": 0.05, "target_inertia": 0.012, "elastic_shot": 0.02}
TABOR = 0.2  # representative strain of an indentation over a/R
TOLERANCE = 0.02  # relative change of e beyond which "auto" is on: physics, so the same for every preset


class ImpactChoices(NamedTuple):
    """What the dimple stage models, and a sentence for each block that the scene names."""

    physics: ImpactPhysics
    choices: dict[str, Choice]  # by block: "on" or "off", and why


def restitution_estimate(material: Material, shots: Shots, normal_speed_m_s: float) -> float:
    """Equation (1) for a rigid shot; at most 1.  FE values on 2024 at 5-100 m/s lie within 20 %."""
    flow_stress = material.single_law.flow_stress_Pa(REPRESENTATIVE_STRAIN)
    modulus = hertz.effective_modulus_Pa(material.E_Pa, material.nu)
    energy = 2.0 / 3.0 * math.pi * shots.density_kg_m3 * normal_speed_m_s**2  # m v^2 / 2 over R^3
    return min(1.0, 3.8 * math.sqrt(flow_stress / modulus) * (energy / flow_stress) ** -0.125)


def rate_number(material: Material, shots: Shots, normal_speed_m_s: float) -> float:
    """Relative rise of e by the rate of strain, (2); 0 for a law without a rate term."""
    law = material.single_law
    if not getattr(law, "C", 0.0):
        return 0.0
    loading_s = _contact_time(material, shots, normal_speed_m_s) * 0.5 * shots.diameter_m / CONTACT_OVER_LOADING
    faster = max(1.0, REPRESENTATIVE_STRAIN / loading_s / law.rate_ref_1_s)
    return (1.0 + law.C * math.log(faster)) ** 0.625 - 1.0


def inertia_number(material: Material, shots: Shots, normal_speed_m_s: float) -> float:
    """Relative fall of e by waves that leave into the target, (3)."""
    flow_stress = material.single_law.flow_stress_Pa(REPRESENTATIVE_STRAIN)
    e = restitution_estimate(material, shots, normal_speed_m_s)
    share = expected_share(
        material.E_Pa, material.nu, material.density_kg_m3,
        shot_density_kg_m3=shots.density_kg_m3, flow_stress_Pa=flow_stress, restitution=e,
    )  # fmt: skip
    return 1.0 - restitution_with_waves(e, share) / e


def elastic_shot_number(material: Material, shots: Shots) -> float:
    """Relative rise of e by a shot that gives elastically too, (4)."""
    both = hertz.effective_modulus_Pa(shots.E_Pa, shots.nu, material.E_Pa, material.nu)
    return math.sqrt(hertz.effective_modulus_Pa(material.E_Pa, material.nu) / both) - 1.0


def heat_number(material: Material, shots: Shots, normal_speed_m_s: float) -> float:
    """Relative fall of e by plastic heating at Tabor's strain .2 a/R: Y falls by ((T - T0)/(Tm - T0))^m, e by (2).

    The temperature is that of the plastic work up to that strain, kept where it was made; 0 where the material's law has
    no melting point, specific heat or exponent.
    """
    law = material.single_law
    if not all(getattr(law, key, None) for key in ("m", "melting_K", "specific_heat_J_kg_K")):
        return 0.0
    flow_stress = law.flow_stress_Pa(REPRESENTATIVE_STRAIN)
    scale = expected_impact(material.E_Pa * 1e-6, material.nu, flow_stress * 1e-6, shots.density_kg_m3 * 1e-6, normal_speed_m_s)
    heat = law.taylor_quinney * flow_stress * TABOR * scale.radius
    warmer = heat / (material.density_kg_m3 * law.specific_heat_J_kg_K * (law.melting_K - law.reference_K))
    return 1.0 - (1.0 - min(warmer**law.m, 1.0)) ** 0.625


def impact_physics(scene: Scene, shots: Shots, normal_speed_m_s: float) -> ImpactChoices:
    """The scene's blocks of impact physics decided for the mean shot of ``shots`` at ``normal_speed_m_s``.

    "auto" is on where its number exceeds THRESHOLDS; a block that the scene states stays.
    """
    material = scene.target.material
    numbers = {
        "strain_rate": lambda: rate_number(material, shots, normal_speed_m_s),
        "target_inertia": lambda: inertia_number(material, shots, normal_speed_m_s),
        "elastic_shot": lambda: elastic_shot_number(material, shots),
    }
    on, choices = {}, {}
    for block, number in numbers.items():
        asked = getattr(scene, block)
        on[block] = False
        if asked is None:
            continue
        value = number()
        limit = THRESHOLDS[block]
        on[block] = value > limit if asked.auto else True
        rule = f"{'above' if on[block] else 'within'} {limit:g}" if asked.auto else "the scene asks for it"
        choices[block] = Choice(
            "on" if on[block] else "off", f"changes the restitution by about {value:.2g} of itself ({rule})"
        )
    has_rate = bool(getattr(material.single_law, "C", 0.0))
    friction = scene.friction.shot_target if scene.friction.in_dimple else 0.0
    if friction:
        choices["friction_in_dimple"] = Choice("on", f"coefficient {friction:g} (the scene asks for it)")
    physics = ImpactPhysics(
        rate=on["strain_rate"] and has_rate,
        thermal=on["strain_rate"] and scene.strain_rate.thermal,
        inertia=on["target_inertia"],
        friction=friction,
        small_strain=scene.models.dimple.model == "small_strain",
        elastic_shot=(shots.E_Pa, shots.nu) if on["elastic_shot"] else None,
        radius_m=0.5 * shots.diameter_m if on["strain_rate"] and has_rate else None,
    )
    return ImpactChoices(physics, choices)


def _contact_time(material: Material, shots: Shots, normal_speed_m_s: float) -> float:
    """Expected contact time [R/(1 m/s)]."""
    flow_stress = material.single_law.flow_stress_Pa(REPRESENTATIVE_STRAIN)
    return expected_impact(
        material.E_Pa * 1e-6, material.nu, flow_stress * 1e-6, shots.density_kg_m3 * 1e-6, normal_speed_m_s
    ).duration
