"""The layers of elements of the periodic cell: finest at the top, thicker by the same factor from each to the next."""

from __future__ import annotations

import numpy as np

from glue.scene.presets import CELL_DEPTH_IN_RADII, Accuracy

_FIRST_LAYER_IN_RADII = 0.1


def layer_bounds_mm(accuracy: Accuracy, radius_m: float) -> np.ndarray:
    """Depths [mm] of the element layers' faces, (layers + 1,), 0 first; thickness grows geometrically."""
    depth, layers = CELL_DEPTH_IN_RADII * radius_m * 1e3, layer_count(accuracy)
    ratio = layer_ratio(layers)
    return depth * (ratio ** np.arange(layers + 1) - 1.0) / (ratio**layers - 1.0)


def layer_count(accuracy: Accuracy) -> int:
    return accuracy.cell_elements_per_side + 1


def layer_ratio(layers: int) -> float:
    """Growth that makes the first layer _FIRST_LAYER_IN_RADII thick: bisection of s (q^n - 1)/(q - 1) = depth."""
    lo, hi = 1.0 + 1e-9, 10.0
    for _ in range(80):
        q = 0.5 * (lo + hi)
        total = _FIRST_LAYER_IN_RADII * (q**layers - 1.0) / (q - 1.0)
        lo, hi = (q, hi) if total < CELL_DEPTH_IN_RADII else (lo, q)
    return 0.5 * (lo + hi)
