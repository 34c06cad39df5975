"""Closed bodies of triangles for tests, counter-clockwise from outside; Debian's Python imports them too."""

from __future__ import annotations

import math

import numpy as np


def box(low=(-1.0, -1.0, -1.0), high=(1.0, 1.0, 0.0), n: int = 1) -> np.ndarray:
    """A box, each face of n x n squares of two triangles: (12 n^2, 3, 3)."""
    low, high = np.array(low), np.array(high)
    triangles = []
    for axis in range(3):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for side in (0.0, 1.0):
            for i in range(n):
                for j in range(n):
                    corner = np.eye(3)[axis] * side
                    a, b = corner + u * i / n + v * j / n, corner + u * (i + 1) / n + v * j / n
                    c, d = corner + u * (i + 1) / n + v * (j + 1) / n, corner + u * i / n + v * (j + 1) / n
                    pair = [(a, b, c), (a, c, d)] if side else [(a, c, b), (a, d, c)]
                    triangles += pair
    return low + np.array(triangles) * (high - low)


def prism(polygon, caps, y0: float, y1: float) -> np.ndarray:
    """The polygon [(x, z), …], counter-clockwise from -y, between y0 and y1; ``caps``: its triangles."""
    at = [np.array([(x, y, z) for x, z in polygon]) for y in (y0, y1)]
    triangles = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        triangles += [(at[0][i], at[1][j], at[0][j]), (at[0][i], at[1][i], at[1][j])]
    for i, j, k in caps:
        triangles += [(at[0][i], at[0][j], at[0][k]), (at[1][i], at[1][k], at[1][j])]
    return np.array(triangles)


def step() -> np.ndarray:
    """Two boxes in one: x in -1..1, z in -1..0, and on it x in -1..0, z to 1; y in -1..1. A concave edge."""
    polygon = [(-1.0, -1.0), (1.0, -1.0), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (-1.0, 1.0)]
    return prism(polygon, [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)], -1.0, 1.0)


def cylinder(radius: float = 0.02, length: float = 0.04, n: int = 60, rings: int = 10) -> np.ndarray:
    """Inscribed in the cylinder along y with its apex line through the origin, an edge along that line."""
    angles = 2.0 * np.pi * np.arange(n) / n + 0.5 * np.pi
    ys = np.linspace(-0.5 * length, 0.5 * length, rings + 1)

    def at(i, j):
        return radius * math.cos(angles[i % n]), ys[j], radius * (math.sin(angles[i % n]) - 1.0)

    triangles = []
    for i in range(n):
        for j in range(rings):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            triangles += [(a, c, b), (a, d, c)]
        triangles.append((at(i, 0), at(i + 1, 0), (0.0, ys[0], -radius)))
        triangles.append((at(i + 1, rings), at(i, rings), (0.0, ys[-1], -radius)))
    return np.array(triangles)
