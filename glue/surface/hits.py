"""How often each point of the window was struck."""

from __future__ import annotations

import numpy as np


def hit_counts(x_m, y_m, impact_x_m, impact_y_m, semi_major_m, semi_minor_m, azimuth_rad) -> np.ndarray:
    """Number of dimples over each point, (ny, nx) int: ellipses (n,) on the grid of rising ``x_m`` (nx,) and ``y_m`` (ny,).

    A dimple covers the points inside its ellipse, as coverage counts them.
    """
    x, y = np.asarray(x_m, dtype=float), np.asarray(y_m, dtype=float)
    counts = np.zeros((y.size, x.size), dtype=np.int32)
    for cx, cy, major, minor, azimuth in zip(impact_x_m, impact_y_m, semi_major_m, semi_minor_m, azimuth_rad, strict=True):
        if not (major > 0.0 and minor > 0.0):
            continue
        columns = slice(np.searchsorted(x, cx - major), np.searchsorted(x, cx + major, side="right"))
        rows = slice(np.searchsorted(y, cy - major), np.searchsorted(y, cy + major, side="right"))
        u, v = x[None, columns] - cx, y[rows, None] - cy
        along, across = u * np.cos(azimuth) + v * np.sin(azimuth), v * np.cos(azimuth) - u * np.sin(azimuth)
        counts[rows, columns] += (along / major) ** 2 + (across / minor) ** 2 <= 1.0
    return counts
