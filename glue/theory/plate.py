"""A plate let go: what becomes of a peened layer's stress when the plate may stretch and bend.

Both in-plane directions strain alike and the plate is elastic in the release, so each stress component loses its
own mean force and mean moment: sigma = s - N/h - 12 M (z - h/2)/h^3, N = int s dz, M = int s (z - h/2) dz
(Timoshenko, Theory of Plates and Shells).  Then int sigma dz = 0 and int sigma z dz = 0.
"""

from __future__ import annotations

import numpy as np

from glue.theory.almen import gauge_reading_m


def released_stress(depth, constrained, thickness: float):
    """Stress of a free plate from that of a clamped one; (n,) arrays in, (n,) array out.

    depth: rising from 0 to ``thickness``; constrained: stress there with the plate held flat and unstretched, linear
    between the entries.  Force and moment are those of the broken line, exactly.
    """
    z, s = np.asarray(depth, dtype=float), np.asarray(constrained, dtype=float)
    if z[0] != 0.0 or not np.isclose(z[-1], thickness, rtol=1e-12) or (np.diff(z) <= 0).any():
        raise ValueError("depth must rise from 0 to the thickness")
    force, moment = force_and_moment(z, s, 0.5 * thickness)
    return s - force / thickness - 12.0 * moment * (z - 0.5 * thickness) / thickness**3


def clamped_stress(depth, released, faded: int):
    """Stress of the clamped plate from that of the free one, (n,) arrays: what ``released_stress`` took away put back.

    faded: number of the last entries where the clamped plate bears no stress (3 or more), so that what is there is the
    straight line of the release.  Raises ValueError when they do not lie on one.
    """
    z, s = np.asarray(depth, dtype=float), np.asarray(released, dtype=float)
    if not 3 <= faded <= z.size:
        raise ValueError(f"{faded} entries of {z.size} do not tell a line; 3 or more are needed")
    line = np.polynomial.Polynomial.fit(z[-faded:], s[-faded:], 1)(z)
    if np.abs(s - line)[-faded:].max() > 1e-6 * np.abs(s).max():
        raise ValueError("the stress towards the back is no straight line")
    return s - line


def curvature_1_m(depth, constrained, thickness: float, E_Pa: float, nu: float) -> float:
    """Curvature [1/m] that a plate takes when it is let go; positive: bulging towards the peened side (depth 0).

    kappa = 12 M (1 - nu)/(E h^3), M = int s (z - h/2) dz of the clamped stress, positive for compression on top; of an eigenstrain eps down to d it is
    6 eps d (h - d)/h^3.  Arguments as for ``released_stress``.
    """
    moment = force_and_moment(depth, constrained, 0.5 * thickness)[1]
    return 12.0 * moment * (1.0 - nu) / (E_Pa * thickness**3)


def arc_height_m(curvature: float) -> float:
    """What an Almen gauge (SAE J442: four balls, 31.75 by 15.875 mm) reads over a strip of this curvature [1/m].

    The dial stands in the middle of the rectangle, so both directions count: kappa (31.75^2 + 15.875^2)/8 mm.
    """
    return gauge_reading_m(curvature)


def force_and_moment(depth, stress, centre: float) -> tuple[float, float]:
    """int s dz and int s (z - centre) dz of the broken line through (depth, stress)."""
    z, s = np.asarray(depth, dtype=float), np.asarray(stress, dtype=float)
    h, arm = np.diff(z), z - centre
    force = float(np.sum(0.5 * h * (s[1:] + s[:-1])))
    # Simpson's rule is exact for the product of two straight lines.
    middle = 0.25 * (s[1:] + s[:-1]) * (arm[1:] + arm[:-1])
    return force, float(np.sum(h / 6.0 * (s[1:] * arm[1:] + 4.0 * middle + s[:-1] * arm[:-1])))
