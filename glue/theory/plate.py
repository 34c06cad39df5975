"""A plate let go: what becomes of a peened layer's stress when the plate may stretch and bend.

Both in-plane directions strain alike and the plate is elastic in the release, so each stress component loses its
own mean force and mean moment: sigma = s - N/h - 12 M (z - h/2)/h^3, N = int s dz, M = int s (z - h/2) dz
(Timoshenko, Theory of Plates and Shells).  Then int sigma dz = 0 and int sigma z dz = 0.
"""

from __future__ import annotations

import numpy as np


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


def force_and_moment(depth, stress, centre: float) -> tuple[float, float]:
    """int s dz and int s (z - centre) dz of the broken line through (depth, stress)."""
    z, s = np.asarray(depth, dtype=float), np.asarray(stress, dtype=float)
    h, arm = np.diff(z), z - centre
    force = float(np.sum(0.5 * h * (s[1:] + s[:-1])))
    # Simpson's rule is exact for the product of two straight lines.
    middle = 0.25 * (s[1:] + s[:-1]) * (arm[1:] + arm[:-1])
    return force, float(np.sum(h / 6.0 * (s[1:] * arm[1:] + 4.0 * middle + s[:-1] * arm[:-1])))
