"""Exact uniaxial response of a hardening law: isotropic part plus Armstrong-Frederick backstresses.

Within one half cycle the flow direction nu is constant, so with accumulated plastic strain p
    X_i(p) = nu X_i + (X_i(p0) - nu X_i) exp(-gamma_i (p - p0)),   sigma = nu R(p) + sum X_i(p),
and the total strain is sigma/E plus the plastic strain (Lemaitre and Chaboche, Mechanics of Solid Materials, ch. 5).
"""

from __future__ import annotations

import math

from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook


def uniaxial_stress_Pa(E_Pa: float, law: CombinedHardening | JohnsonCook | HardeningTable, strains) -> list[float]:
    """Quasi-static stress [Pa] at each of ``strains``, a path of total strain from the virgin state.

    Between two entries the strain runs monotonically.  A law without backstresses hardens isotropically.
    """
    backstresses = law.backstresses if isinstance(law, CombinedHardening) else ()

    def isotropic(p: float) -> float:
        if isinstance(law, CombinedHardening):
            return law.R0_Pa + law.Q_Pa * (1.0 - math.exp(-law.b * p))
        return law.flow_stress_Pa(p)

    p, plastic, back = 0.0, 0.0, [0.0] * len(backstresses)
    out = []
    for strain in strains:
        elastic = E_Pa * (strain - plastic)
        direction = 1.0 if elastic > sum(back) else -1.0
        if direction * (elastic - sum(back)) > isotropic(p):

            def moved(dp: float) -> list[float]:
                pairs = zip(backstresses, back, strict=True)
                return [direction * x + (a - direction * x) * math.exp(-g * dp) for (x, g), a in pairs]

            def miss(dp: float) -> float:
                stress = direction * isotropic(p + dp) + sum(moved(dp))
                return direction * (E_Pa * (strain - plastic - direction * dp) - stress)

            dp = _root(miss, abs(elastic) / E_Pa + 2.0 * sum(x for x, _ in backstresses) / E_Pa)
            back = moved(dp)
            p += dp
            plastic += direction * dp
        out.append(E_Pa * (strain - plastic))
    return out


def _root(falling, upper: float) -> float:
    """Root of a function that falls through zero between 0 and ``upper``: bisection to the last bit."""
    lower = 0.0
    for _ in range(200):
        middle = 0.5 * (lower + upper)
        if middle in (lower, upper):
            break
        lower, upper = (middle, upper) if falling(middle) > 0.0 else (lower, middle)
    return 0.5 * (lower + upper)
