"""What a single impact models beyond a rigid, frictionless shot on a quasi-static target; and what the shot can bear.

Everything is off by default.  Rate and heat belong to the target's law; the rest to ``freefem/single_impact.edp``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from glue.errors import InputError

MOST_HITS = 10


@dataclass(frozen=True)
class ImpactPhysics:
    """Optional physics of one impact.  Raises InputError for values outside the ranges stated here."""

    rate: bool = False  # strain rate term of Johnson-Cook; the result then belongs to one radius
    thermal: bool = False  # adiabatic heating and softening
    inertia: bool = False  # of the target, with boundaries that absorb waves
    friction: float = 0.0  # Coulomb, shot on target, 0 to 1
    elastic_shot: tuple[float, float] | None = None  # Young's modulus [Pa] and Poisson's ratio (0 to .49); None: rigid
    radius_m: float | None = None  # of the shot; needed with rate, ignored without
    small_strain: bool = False  # strains and stresses as if nothing had moved; contact on the deformed surface all the same
    hits: int = 1  # impacts one after the other at the same place, 1 to 10

    def __post_init__(self):
        problems = []
        if not 0.0 <= self.friction <= 1.0:
            problems.append(f"friction = {self.friction}: allowed 0 to 1")
        if self.elastic_shot is not None:
            modulus, ratio = self.elastic_shot
            if not (math.isfinite(modulus) and modulus > 0.0):
                problems.append(f"elastic_shot: Young's modulus {modulus} Pa must be positive and finite")
            if not 0.0 <= ratio <= 0.49:
                problems.append(f"elastic_shot: Poisson's ratio {ratio}: allowed 0 to 0.49")
        if self.rate and not (self.radius_m is not None and math.isfinite(self.radius_m) and self.radius_m > 0.0):
            problems.append(f"rate = True needs radius_m, positive and finite; it is {self.radius_m}")
        if not (isinstance(self.hits, int) and 1 <= self.hits <= MOST_HITS):
            problems.append(f"hits = {self.hits}: allowed 1 to {MOST_HITS}, whole")
        if problems:
            raise InputError(problems)


class ShotStrength(NamedTuple):
    """Yield stress of a kind of shot, with its origin."""

    yield_Pa: float
    source: str
    grade: str  # D derived, A read in a source, B quoted, C from memory or unverified


# A hardness of 40-51 HRC (usual cast steel shot) is 390-530 HV; yield about HV / 3 of a hardened steel, as stresses.
STEEL_SHOT = ShotStrength(1.3e9, "cast steel shot of 40-51 HRC, the softer end: HV 390-400 / 3", "C")

FIRST_YIELD = 1.60  # largest Hertz pressure over yield stress at first yield, nu = .3: K. L. Johnson (1985) section 6.1
FULL_PLASTICITY = 2.8  # mean pressure over yield stress where an indentation is fully plastic: ibid. section 6.3


def shot_yield_warning(centre_pressure_Pa: float, mean_pressure_Pa: float, yield_Pa: float) -> str | None:
    """What to say when these largest contact pressures would make the shot itself flow; None when it stays elastic.

    centre_pressure_Pa: of the inner half of the contact; mean_pressure_Pa: force over contact area, both at peak force.
    """
    if not (math.isfinite(yield_Pa) and yield_Pa > 0.0):
        raise InputError(f"the shot's yield stress must be positive and finite, got {yield_Pa}")
    told = f"contact pressure {centre_pressure_Pa * 1e-9:.2f} GPa (mean {mean_pressure_Pa * 1e-9:.2f}) against the shot's "
    told += f"yield stress {yield_Pa * 1e-9:.2f} GPa"
    if mean_pressure_Pa >= FULL_PLASTICITY * yield_Pa:
        return f"{told}: the shot is flattened; the dimple comes out smaller and shallower, e lower than computed"
    if centre_pressure_Pa >= FIRST_YIELD * yield_Pa:
        return f"{told}: the shot yields inside, beyond {FIRST_YIELD:g} times that; e comes out lower than computed"
    return None
