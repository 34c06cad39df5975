"""Almen strips by the periodic cell: the layer model's intensity confirmed, in minutes instead of milliseconds.

A cell holds few impacts at the exposures that matter, so arc heights are means over PATCHES cells whose impacts fall
at random; what is left of their scatter goes with the curve.  The exposure is that of the impacts really pressed in.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.scene.presets import Accuracy
from glue.target.cell import run_cell
from glue.target.dimple import solve_dimple
from glue.target.driver import law_table
from glue.target.part import strip_arc_height_m
from glue.target.patch import Patch
from glue.target.strip import StripLibrary, Stream
from glue.theory.almen import Strip

PATCHES = 4
MULTIPLES = (0.5, 1.0, 2.0, 3.0)  # of the layer model's saturation exposure


class CellCurve(NamedTuple):
    """Arc heights (n,) after exposures of ``hits`` (n,) dimple areas per area, and the standard errors of these means."""

    hits: np.ndarray
    arc_height_m: np.ndarray
    standard_error_m: np.ndarray


def cell_curve(
    library: StripLibrary, strip: Strip, stream: Stream, accuracy: Accuracy, *, seed: int,
    progress: Callable[[float, str], None] | None = None,
) -> CellCurve:  # fmt: skip
    """The saturation curve of a strip by cells of the preset's mesh.  Raises SolverFailed, NotConverged, InputError."""
    steel, rng = library.material, np.random.default_rng(seed)
    mass = stream.density_kg_m3 * math.pi / 6.0 * stream.diameter_m**3
    energy = 0.5 * mass * stream.normal_speed_m_s**2
    radii = library.dimple_radii_m(stream)
    largest = int(np.argmax(radii))
    saturation, _ = library.saturation(strip, stream)
    law = law_table(steel.E_Pa, steel.nu, steel.combined)
    with tempfile.TemporaryDirectory(prefix="peen-strip-") as scratch:
        dimple = solve_dimple(
            steel, speed_m_s=float(stream.normal_speed_m_s[largest]), density_kg_m3=float(stream.density_kg_m3[largest]),
            diameter_m=float(stream.diameter_m[largest]), elements_per_radius=accuracy.dimple_elements_per_radius,
            workdir=Path(scratch) / "dimple",
        )  # fmt: skip
        side = accuracy.cell_side_in_radii * dimple.radius_m
        mean_area = float(np.mean(math.pi * radii**2))
        counts = np.unique(np.maximum(1, np.round(saturation * np.array(MULTIPLES) * side**2 / mean_area).astype(int)))
        heights, hits = [], []
        for k in range(PATCHES):
            which = rng.integers(len(energy), size=counts[-1])
            patch = Patch(
                *(rng.uniform(0.0, side, (2, counts[-1]))), energy[which], 0.5 * stream.diameter_m[which], (0.0, 0.0),
                0.0, 0.0, 0, 0.0, np.arange(counts[-1]),
            )  # fmt: skip
            cells = run_cell(
                "almen", law, accuracy, dimple, patch, side, Path(scratch) / f"cell-{k}", snapshots=[int(c) for c in counts],
                progress=_teller(progress, k),
            )  # fmt: skip
            heights.append([strip_arc_height_m(cell, strip.thickness_m, steel.E_Pa, steel.nu) for cell in cells])
            hits.append(np.cumsum(math.pi * radii[which] ** 2)[counts - 1] / side**2)
    heights, hits = np.array(heights), np.array(hits)
    error = heights.std(axis=0, ddof=1) / math.sqrt(PATCHES)
    return CellCurve(hits.mean(axis=0), heights.mean(axis=0), error)


def _teller(progress, k: int):
    """Progress of cell ``k`` as a share of all."""
    if progress is None:
        return None
    return lambda share, text="": progress((k + share) / PATCHES, f"cell {k + 1} of {PATCHES} {text}")
