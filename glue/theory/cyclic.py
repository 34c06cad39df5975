"""Exact uniaxial response of combined hardening: isotropic part plus Armstrong-Frederick backstresses.

Within one half cycle the flow direction nu is constant, so with accumulated plastic strain p
    X_i(p) = nu X_i + (X_i(p0) - nu X_i) exp(-gamma_i (p - p0)),   sigma = nu R(p) + sum X_i(p),
and the total strain is sigma/E plus the plastic strain (Lemaitre and Chaboche, Mechanics of Solid Materials, ch. 5).
"""

from __future__ import annotations

import math

from glue.scene.model import CombinedHardening


def uniaxial_stress_Pa(E_Pa: float, law: CombinedHardening, strains) -> list[float]:
    """Stress [Pa] at each of ``strains``, a path of total strain from the virgin state.

    Between two entries the strain runs monotonically.
    """

    def isotropic(p: float) -> float:
        return law.R0_Pa + law.Q_Pa * (1.0 - math.exp(-law.b * p))

    p, plastic, back = 0.0, 0.0, [0.0] * len(law.backstresses)
    out = []
    for strain in strains:
        elastic = E_Pa * (strain - plastic)
        direction = 1.0 if elastic > sum(back) else -1.0
        if direction * (elastic - sum(back)) > isotropic(p):

            def moved(dp: float) -> list[float]:
                pairs = zip(law.backstresses, back, strict=True)
                return [direction * x + (a - direction * x) * math.exp(-g * dp) for (x, g), a in pairs]

            def miss(dp: float) -> float:
                stress = direction * isotropic(p + dp) + sum(moved(dp))
                return direction * (E_Pa * (strain - plastic - direction * dp) - stress)

            dp = _root(miss, abs(elastic) / E_Pa + 2.0 * sum(x for x, _ in law.backstresses) / E_Pa)
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
