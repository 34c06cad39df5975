"""Integrals of an axisymmetric solution over whole planes of one depth, smooth in the depth."""

from __future__ import annotations

import math

import numpy as np


def plane_integrals(r: np.ndarray, z: np.ndarray, values: np.ndarray, at_z: np.ndarray) -> np.ndarray:
    """Integrals of axisymmetric fields over planes z = const: int f 2 pi r dr, (fields, planes).

    r, z: (3 k,) Gauss points, three a triangle at the barycentric (1/6, 1/6, 2/3) and its turns; values: (fields,
    3 k); at_z: (planes,).  Each field goes linearly through the three values of a triangle; a plane cuts it along a
    segment, on which r f is a parabola: Simpson's rule is exact.
    """

    def corners(v: np.ndarray) -> np.ndarray:  # g_i = c_i/2 + mean/2, so c_i = 2 g_i - mean, in any order
        three = v.reshape(*v.shape[:-1], -1, 3)
        return 2.0 * three - three.mean(axis=-1, keepdims=True)

    # Corners shared by triangles come out equal but for rounding, and a plane through them is to cut either side once.
    grain = 1e-12 * np.ptp(z)
    cz = np.round(corners(z) / grain) * grain
    order = np.argsort(cz, axis=1)
    cz = np.take_along_axis(cz, order, 1)
    everything = np.concatenate([r[None], values])  # the radius is cut like any field
    c = np.take_along_axis(corners(everything), order[None], 2)
    result = np.empty((len(values), len(at_z)))
    for j, level in enumerate(at_z):
        cut = (cz[:, 0] <= level) & (level < cz[:, 2])
        low, mid, high = cz[cut].T
        one = _between(c[:, cut, 0], c[:, cut, 2], level, low, high)
        upper = level >= mid
        other = np.where(upper, _between(c[:, cut, 1], c[:, cut, 2], level, mid, high),
                         _between(c[:, cut, 0], c[:, cut, 1], level, low, mid))  # fmt: skip
        middle = 0.5 * (one + other)
        simpson = (one[0] * one[1:] + 4.0 * middle[0] * middle[1:] + other[0] * other[1:]) / 6.0
        result[:, j] = 2.0 * math.pi * (simpson * np.abs(one[0] - other[0])).sum(axis=1)
    return result


def _between(a, b, level, low, high):
    """Value at ``level`` on the edge from a (at ``low``) to b (at ``high``); an edge of no height is never used."""
    rise = high - low
    return a + (b - a) * (level - low) / np.where(rise > 0.0, rise, 1.0)
