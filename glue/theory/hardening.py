"""A bounded hardening law that follows a given monotonic curve: the rule for materials without cyclic data.

Where impacts overlap, the isotropic part of the hardening must be bounded: with an unbounded power law
the residual stress of a peened surface never levels off.  Few alloys have trustworthy cyclic parameters,
so this project keeps the *shape* of the law it chose for 2024-T351 (``TEMPLATE``) and fits only its two
sizes to the material's own monotonic curve.  Evidence grade C: a plausible default, not a measurement.

    Y(p) = T [r + x (1 - exp(-g1 p))] + S (1 - exp(-b p)),      0.005 <= p <= 0.10              (1)

T is the initial yield plus the fast backstress, S the slow hardening, shared between the isotropic part
(Q = q S) and the slow backstress (X2 = (1-q) S).  T, S >= 0 by least squares on 20 even points.

For the nine materials of the catalogue (1) stays within 6.1 % of the Johnson-Cook curve at p = 0.005 (where
the early yield of every such law tells) and within 2 % from p = 0.015 on.  For 2024-T351 the rule gives
R0 256, Q 89, X1 123, X2 67 MPa against 270, 80, 130, 60 chosen by hand, and nearly the same strength at full
coverage (R0 + Q + sum of gamma/(gamma + 190) X: 425 against 433 MPa).

Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

STRAINS = tuple(0.005 + i * 0.095 / 19 for i in range(20))  # the range in which tensile tests pin the curve


class Template(NamedTuple):
    """Shape of the bounded law, the part that is not fitted (dimensionless)."""

    yield_share: float  # r: share of T that is yield stress
    fast_share: float  # x = 1 - r: share of T that is the fast backstress
    fast_gamma: float  # g1
    isotropic_share: float  # q: share of S that is isotropic
    slow_rate: float  # b, also the slow backstress's gamma


# The law chosen for 2024-T351: R0 270, Q 80, b 12, X1 130 (gamma 300), X2 60 (gamma 12) MPa, so T 400, S 140.
TEMPLATE = Template(
    yield_share=0.675, fast_share=0.325, fast_gamma=300.0, isotropic_share=80.0 / 140.0, slow_rate=12.0
)


class BoundedLaw(NamedTuple):
    """R0 + Q (1 - exp(-b p)) and backstresses ((X_Pa, gamma), ...), every stress in Pa."""

    R0_Pa: float
    Q_Pa: float
    b: float
    backstresses: tuple[tuple[float, float], ...]


def bounded_law(flow_stress_Pa: Callable[[float], float], template: Template = TEMPLATE) -> BoundedLaw:
    """Fit (1) to the monotonic curve ``flow_stress_Pa(p)`` [Pa], p the equivalent plastic strain (a float).

    Least squares in two unknowns with both kept non-negative: the free minimum when it is admissible,
    else the better of the two edges (exact, since the problem is convex).
    """
    first = [
        template.yield_share + template.fast_share * -math.expm1(-template.fast_gamma * p) for p in STRAINS
    ]
    second = [-math.expm1(-template.slow_rate * p) for p in STRAINS]
    size_T, size_S = _non_negative_pair(first, second, [flow_stress_Pa(p) for p in STRAINS])
    q = template.isotropic_share
    return BoundedLaw(
        R0_Pa=template.yield_share * size_T,
        Q_Pa=q * size_S,
        b=template.slow_rate,
        backstresses=(
            (template.fast_share * size_T, template.fast_gamma),
            ((1.0 - q) * size_S, template.slow_rate),
        ),
    )


def _non_negative_pair(f: list[float], g: list[float], y: list[float]) -> tuple[float, float]:
    """(u, v) >= 0 with the least sum of (u f_i + v g_i - y_i)^2."""
    ff, gg, fg = _dot(f, f), _dot(g, g), _dot(f, g)
    fy, gy = _dot(f, y), _dot(g, y)
    determinant = ff * gg - fg * fg
    u, v = (gg * fy - fg * gy) / determinant, (ff * gy - fg * fy) / determinant
    if u >= 0.0 and v >= 0.0:
        return u, v
    only_f, only_g = max(0.0, fy / ff), max(0.0, gy / gg)
    # The decrease of the squared misfit along one axis is (f.y)^2 / (f.f).
    return (only_f, 0.0) if only_f * fy >= only_g * gy else (0.0, only_g)


def _dot(a: list[float], b: list[float]) -> float:
    return math.fsum(x * y for x, y in zip(a, b, strict=True))
