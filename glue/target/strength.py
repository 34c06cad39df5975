"""What a bounded hardening law holds against flow to and fro, and the plastic work of its isotropic part.

    Y(p) = R0 + Q (1 - exp(-b p)) + sum phi_j X_j (1 - exp(-g_j p)),    phi_j = (g_j - g1)/(g_j + g0)          (1)
    W(p) = R0 p + Q (p - (1 - exp(-b p))/b)                                                                    (2)

A backstress holds a mean stress up the more the faster it turns with the flow; one that turns slowly still points
where the last shot pushed it and even takes off a little.  (2): backstresses give back what they took.
"""

from __future__ import annotations

import numpy as np

from glue.errors import InputError
from glue.scene.laws import CombinedHardening


def refuse_unbounded(law) -> None:
    """Raises InputError for a law that grows without end."""
    known = isinstance(law, CombinedHardening)
    if not known or (law.Q_Pa and law.b < 0.0) or any(g < 0.0 for _, g in law.backstresses):
        raise InputError("target = layers: a hardening law without bound never lets the stress level off; allowed: "
                         "target.material.combined with rates of 0 and more")  # fmt: skip


def held(law: CombinedHardening, g0: float, g1: float) -> list[tuple[float, float]]:
    """(phi X [Pa], g) of each backstress of (1)."""
    return [(x * (g - g1) / (g + g0), g) for x, g in law.backstresses]


def full_strength_Pa(law: CombinedHardening, g0: float, g1: float) -> float:
    """(1) after endless strain [Pa]."""
    return law.R0_Pa + (law.Q_Pa if law.b > 0.0 else 0.0) + sum(x for x, g in held(law, g0, g1))


def plastic_work_Pa(law: CombinedHardening, p: np.ndarray) -> np.ndarray:
    """(2) [J/m3] at equivalent plastic strains ``p`` (any shape)."""
    return law.R0_Pa * p + (law.Q_Pa * (p + np.expm1(-law.b * p) / law.b) if law.b > 0.0 else 0.0)


def strain_of_work(law: CombinedHardening, work_Pa: np.ndarray) -> np.ndarray:
    """Inverse of (2): Newton from W/R0; the curve bends one way, so every step is on the same side."""
    p = work_Pa / law.R0_Pa
    for _ in range(50):
        step = (plastic_work_Pa(law, p) - work_Pa) / (law.R0_Pa - law.Q_Pa * np.expm1(-law.b * p))
        p = np.maximum(p - step, 0.0)
        if np.abs(step).max(initial=0.0) <= 1e-12 * (1.0 + p.max(initial=0.0)):
            break
    return p
