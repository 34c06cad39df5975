"""Rows of the dimple benchmark on dimples between shared speeds (sweeps, designs), against impacts solved at those speeds.

At the middles between the shared speeds, in logarithms, where it errs most; on the mesh of preset fast, which searches
use, and on one twice as fine, which tells what of a difference is the coarse mesh's scatter from speed to speed.  Both
sides have the mesh in common; its own error is in the other rows.
"""

from __future__ import annotations

import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np

from glue.checkrows import Rows
from glue.scene import catalogue
from glue.target.between import RATIO, grid, layer_shape_between, solve_dimple_between
from glue.target.dimple import solve_dimple
from glue.target.layers import layer_shape
from glue.target.reduced_impact import solve_reduced

CASES = (("al2024-t351", 3), ("steel4340", 3), ("al2024-t351", 6))  # material, elements per radius
SPEEDS = [v * RATIO**0.5 for v in grid(16.0, 90.0)[:-1]]
DENSITY_KG_M3 = 7800.0
DIAMETER_M = 1e-3
# Fixed before the first run: a preset's own error of these is 1 to 4 %.
LIMITS = {"radius": 0.01, "depth": 0.01, "restitution": 0.03, "peak force": 0.02, "largest layer stress": 0.01}


def rows(rows: Rows) -> None:
    """Largest difference of each quantity over the speeds, each material."""
    with tempfile.TemporaryDirectory(prefix="peen-bench-") as scratch:
        for key, elements in CASES:
            found = _differences(catalogue.material(key), elements, Path(scratch))
            for name, limit in LIMITS.items():
                rows.below(f"between shared speeds, {key}, a/{elements}: {name}", max(map(abs, found[name])), limit,
                           ", ".join(f"{v:.0f} m/s {off:+.2%}" for v, off in zip(SPEEDS, found[name], strict=True)))  # fmt: skip


def _differences(material, elements: int, scratch: Path) -> dict[str, list[float]]:
    """{quantity: relative difference at each speed}."""
    found, numbers = defaultdict(list), {"density_kg_m3": DENSITY_KG_M3, "elements_per_radius": elements}
    for v in SPEEDS:
        between = solve_dimple_between(
            material, speed_m_s=v, slowest_m_s=v / 16, fastest_m_s=v, diameter_m=DIAMETER_M, workdir=scratch, **numbers
        )
        own = solve_dimple(material, speed_m_s=v, diameter_m=DIAMETER_M, workdir=scratch, **numbers)
        for name, key in (("radius", "radius_m"), ("depth", "depth_m"), ("restitution", "restitution"),
                          ("peak force", "peak_force_N")):  # fmt: skip
            found[name].append(getattr(between, key) / getattr(own, key) - 1.0)
        impact = solve_reduced(material, material.combined, speed_m_s=v, **numbers)
        shape = layer_shape(impact, material.combined, own.radius_m / (0.5 * DIAMETER_M))
        mixed = layer_shape_between(material, between, elements_per_radius=elements)
        found["largest layer stress"].append(float(np.max(mixed.s_Pa) / np.max(shape.s_Pa)) - 1.0)
    return found
