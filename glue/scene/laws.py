"""Hardening laws and the material that carries them: plain data in SI units and their monotonic curves.

The laws' equations as the solver has them stand in freefem/plugin/hardening.hpp.  Standard library only.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass


@dataclass(frozen=True)
class JohnsonCook:
    """Flow stress min(A + B p^n, saturation) (1 + C ln(rate/rate_ref)) (1 - ((T - T0)/(Tm - T0))^m).

    The last two factors act only where a scene asks for them (``[strain_rate]``).  T rises adiabatically, by
    ``taylor_quinney`` times the plastic work over the heat capacity.  ``m`` = 0 or no ``melting_K``: none is known.
    """

    A_Pa: float
    B_Pa: float
    n: float
    C: float = 0.0
    rate_ref_1_s: float = 1.0
    m: float = 0.0
    melting_K: float | None = None
    reference_K: float = 293.0  # T0, also the temperature before an impact
    specific_heat_J_kg_K: float | None = None
    taylor_quinney: float = 0.9
    saturation_Pa: float | None = None  # A + B p^n has no ceiling of its own

    def flow_stress_Pa(self, p: float) -> float:
        """Quasi-static flow stress [Pa] at the reference temperature, equivalent plastic strain ``p``."""
        plain = self.A_Pa + self.B_Pa * p**self.n
        return plain if self.saturation_Pa is None else min(plain, self.saturation_Pa)


@dataclass(frozen=True)
class HardeningTable:
    """Flow stress by points: linear between them, constant beyond the last; the first stands at strain 0."""

    strain: tuple[float, ...]  # equivalent plastic strain, rising
    stress_Pa: tuple[float, ...]

    def flow_stress_Pa(self, p: float) -> float:
        """Flow stress [Pa] at equivalent plastic strain ``p``."""
        k = bisect.bisect_right(self.strain, p)
        if k == len(self.strain):
            return self.stress_Pa[-1]
        (p0, p1), (s0, s1) = self.strain[k - 1 : k + 1], self.stress_Pa[k - 1 : k + 1]
        return s0 + (s1 - s0) * (p - p0) / (p1 - p0)


@dataclass(frozen=True)
class CombinedHardening:
    """Bounded isotropic part R0 + Q(1-exp(-b p)) plus Armstrong-Frederick backstresses, each (X_Pa, gamma).

    A backstress saturates at X = C/gamma in uniaxial tension; monotonic curve:
    R0 + Q(1-exp(-b p)) + sum X_i (1-exp(-gamma_i p)).  Without backstresses it is Voce's law.
    """

    R0_Pa: float
    Q_Pa: float
    b: float
    backstresses: tuple[tuple[float, float], ...]

    def flow_stress_Pa(self, p: float) -> float:
        """Monotonic uniaxial flow stress [Pa] at equivalent plastic strain ``p``."""
        iso = self.R0_Pa + self.Q_Pa * (1.0 - math.exp(-self.b * p))
        return iso + sum(x * (1.0 - math.exp(-g * p)) for x, g in self.backstresses)


@dataclass(frozen=True)
class Material:
    """Target material: ``single_law`` serves single impacts, ``combined`` every run where impacts overlap.

    Exactly one of ``johnson_cook``, ``voce`` and ``table`` is given: the monotonic curve.
    """

    key: str
    name: str
    E_Pa: float
    nu: float
    density_kg_m3: float
    johnson_cook: JohnsonCook | None
    combined: CombinedHardening
    combined_source: str
    source: str
    grade: str  # D derived, A read in a source, B quoted, C from memory or unverified
    voce: CombinedHardening | None = None  # without backstresses
    table: HardeningTable | None = None

    @property
    def single_law(self) -> JohnsonCook | CombinedHardening | HardeningTable:
        """The monotonic curve, the law of single impacts."""
        return self.table or self.voce or self.johnson_cook
