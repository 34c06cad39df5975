"""What no mesh mends: other published laws of the alloy, laws with and without a bound, restitution and friction."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from glue.flow.regime import ENERGY_LOSS, ENERGY_LOSS_ENDS, collision_number
from glue.scene.catalogue import material, material_keys
from glue.scene.laws import CombinedHardening, Material
from glue.scene.model import Scene
from glue.study.reference import reference_impact
from glue.target.layers import CONSTANTS
from glue.target.strength import full_strength_Pa
from glue.theory.impact_scale import REPRESENTATIVE_STRAIN, expected_impact

# Flow stress of an alloy without other sets in the catalogue: as much as the three sets of 2024 differ.
UNKNOWN_LAW = {"D": 0.0, "A": 0.05, "B": 0.1, "C": 0.14}
# Restitution of 1 mm steel at 60 m/s on 2024, .340 at a/6, with what the default leaves out: target inertia .303,
# elastic shot .379, both .348 (README, "What the single impact leaves out"); on a spot struck once before .42.
# Relative to .340:
LOWER, HIGHER, STRUCK = 0.11, 0.115, 0.24
FRICTION = 0.1  # of the coefficient: what dry steel on metal is known to


class LawSpread(NamedTuple):
    """Largest relative change over the laws that might as well be true."""

    flow_stress: float  # under one impact, at Tabor's strain
    radius: float  # of the dimple
    strength: float  # of the bounded law after full coverage: the layer model's stress is in proportion to it
    stresses: dict[str, float]  # by law: change of that stress; one without bound at the strain of most compression


def law_spread(scene: Scene, strain: float | None) -> LawSpread:
    """The catalogue's other sets of the same alloy, and the law of single impacts where impacts overlap.

    ``strain``: mean equivalent plastic strain where the compression is largest; None where no profile tells it.  The
    radius is that of ``impact_scale`` at each flow stress (within 1 % of the finite elements' ratios for the sets of
    2024).
    """
    own = scene.target.material
    nozzle, shots = reference_impact(scene)

    def impact(m: Material, stress_Pa: float) -> float:
        shot = shots.density_kg_m3 * 1e-6, nozzle.normal_speed_m_s
        return expected_impact(m.E_Pa * 1e-6, m.nu, stress_Pa * 1e-6, *shot).radius

    def single(m: Material) -> float:
        return m.single_law.flow_stress_Pa(REPRESENTATIVE_STRAIN)

    others = [m for m in map(material, material_keys()) if m.key != own.key and _alloy(m) == _alloy(own)]
    stresses = [single(m) for m in others] + [own.combined.flow_stress_Pa(REPRESENTATIVE_STRAIN)]
    strengths = {m.key: _strength(m.combined) / _strength(own.combined) - 1.0 for m in others}
    if not others:
        unsure = UNKNOWN_LAW.get(own.grade, UNKNOWN_LAW["C"])
        stresses += [single(own) * (1.0 - unsure), single(own) * (1.0 + unsure)]
        strengths[f"unsure flow stress (grade {own.grade})"] = unsure
    if strain is not None and strain > 0.0:
        unbounded = own.single_law.flow_stress_Pa(strain) / own.combined.flow_stress_Pa(strain) - 1.0
        strengths["law of single impacts, without bound"] = unbounded
    here = single(own)
    return LawSpread(
        flow_stress=_largest(s / here - 1.0 for s in stresses),
        radius=_largest(impact(own, s) / impact(own, here) - 1.0 for s in stresses),
        strength=_largest(strengths.values()), stresses=strengths,
    )  # fmt: skip


def energy_spread(scene: Scene, restitution: float) -> float:
    """Largest relative change of the impacts' mean normal energy over restitutions and frictions that might be true.

    Through the collisions per shot n, each taking c n/(1 + k n) of the energy (``glue.flow.regime``).
    """

    def kept(e: float, friction: float) -> float:
        coefficients = dataclasses.replace(scene.friction, shot_target=friction)
        n = collision_number(dataclasses.replace(scene, friction=coefficients), e)["collisions_per_shot"]
        return 1.0 - min(ENERGY_LOSS * n / (1.0 + ENERGY_LOSS_ENDS * n), 0.99)

    mu, here = scene.friction.shot_target, kept(restitution, scene.friction.shot_target)
    ends = [(restitution * (1.0 - LOWER), mu), (min(restitution * (1.0 + STRUCK), 1.0), mu)]
    ends += [(restitution, max(mu - FRICTION, 0.0)), (restitution, mu + FRICTION)]
    return _largest(kept(*end) / here - 1.0 for end in ends)


def strain_at(depth_m: np.ndarray, peeq: np.ndarray, at_m: float) -> float:
    """Mean plastic strain of the profile at a depth."""
    return float(np.interp(at_m, depth_m, peeq))


def _strength(law: CombinedHardening) -> float:
    return full_strength_Pa(law, CONSTANTS.g0, CONSTANTS.g1)


def _alloy(m: Material) -> str:
    """The alloy's name: what stands before the set's own in the catalogue."""
    return m.name.split(",")[0]


def _largest(changes) -> float:
    return float(max((abs(c) for c in changes), default=0.0))
