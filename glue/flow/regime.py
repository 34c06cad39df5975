"""Which physics of the shot stream matters: dimensionless numbers and what was measured about them."""

from __future__ import annotations

import math

from glue.errors import InputError
from glue.scene.model import Scene

BALLISTIC_BELOW = 0.01  # pi_eff below which shots that never meet are right to 1 % in number and energy
_OBLIQUE = 0.23  # fit over 30-75 degrees, within 13 %


def collision_number(scene: Scene, restitution: float) -> dict[str, float]:
    """How often a shot meets the cloud of rebounding ones: {"pi", "pi_eff", "collisions_per_shot"}.

    Cloud density x pi d^2 x relative speed x flight time:

        pi = 6 m H (1 + e) / (rho d A v e),   A = pi W^2 / 4

    (m mass flow, H stand-off, W jet width, e restitution on the target).  Oblique jets leave their own
    rebounds behind: pi_eff = pi min(1, 0.23 W / (H cos angle)).  Collisions per shot ~ pi_eff / (1 + 1.3
    pi_eff), within 9 % up to pi_eff = 2 at normal incidence; source: contact simulations of this project.

    Raises InputError for a restitution outside (0, 1].
    """
    if not 0.0 < restitution <= 1.0:
        raise InputError(f"restitution {restitution}: must lie in (0, 1]")
    nozzle, shots = scene.nozzle, scene.shots
    area = math.pi / 4.0 * nozzle.jet_diameter_m**2
    pi = (
        6.0
        * nozzle.mass_flow_kg_s
        * nozzle.stand_off_m
        * (1.0 + restitution)
        / (shots.density_kg_m3 * shots.diameter_m * area * nozzle.speed_m_s * restitution)
    )
    cosine = abs(nozzle.direction[0])
    away = _OBLIQUE * nozzle.jet_diameter_m / (nozzle.stand_off_m * cosine) if cosine > 0.0 else math.inf
    pi_eff = pi * min(1.0, away)
    return {"pi": pi, "pi_eff": pi_eff, "collisions_per_shot": pi_eff / (1.0 + 1.3 * pi_eff)}
