"""The mesh of the contact model's block, in numbers: grid lines, layers, size, memory; lengths in mm.

The top's grid is even where spheres strike and for the reach of their contact beyond, then a few wide columns; below,
the grid coarsens twice.  Everything is scaled by the representative dimple's radius a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.errors import InputError

# Thickness over a, from the top; True: under this layer the grid is twice as coarse.  The first is .026 mm of the
# reference impact, whose stress turns within the top .03; the block ends 15 a below, and 7 a outside the even grid.
_LAYERS = ((0.1145, False), (0.22, False), (0.374, False), (0.529, True), (0.661, False), (0.969, True),
           (1.762, False), (3.524, False), (7.048, False))  # fmt: skip
_OUTER = (3, 6, 14)  # widths of the columns outside the even grid, over its spacing
_CONTACT_REACH = 1.5  # a: how far beyond the outermost impact the surface may be touched; 1.25 a by a second hit
_STEP = 2 ** sum(coarser for _, coarser in _LAYERS)

# Measured at 49 and 123 thousand unknowns: 27 and 94 million entries of the factor, .50 and 1.54 GB at most.
_ENTRIES, _POWER, _BYTES = 27e6 / 49.2e3**1.37, 1.37, 18.0


@dataclass(frozen=True)
class Block:
    """A block for impacts inside a square of side ``side`` around the origin."""

    side: float  # mm
    spacing: float  # mm, of the top's even grid
    columns: np.ndarray  # mm, grid lines, the same along x and y
    thickness: np.ndarray  # mm, of the layers from the top
    coarser: np.ndarray  # int, 1: under this layer the grid is twice as coarse
    contact_half: float  # mm, half side of the square whose nodes may be touched

    @property
    def bounds(self) -> np.ndarray:
        """Depths [mm] of the layers' faces, 0 first."""
        return np.r_[0.0, np.cumsum(self.thickness)]

    @property
    def unknowns(self) -> int:
        """Of the P2 mesh, exactly: three a vertex and an edge."""
        level = np.r_[0, np.cumsum(self.coarser)]
        cells = [(len(self.columns) - 1) // 2**k for k in level]
        nodes = sum((2 * n + 1) ** 2 for n in cells)  # in the planes between layers: vertices and edges
        for above, below, coarser in zip(cells, cells[1:], self.coarser, strict=False):
            if coarser:  # the middle vertex and its edges to 13 others; two edges in a side face; upright edges
                nodes += 14 * below**2 + 2 * 2 * below * (below + 1) + (below + 1) ** 2
            else:
                nodes += (2 * above + 1) ** 2
        return 3 * nodes

    @property
    def memory_GB(self) -> float:
        """Largest resident memory of a run, estimated."""
        contact = 3 * 3 * (2 * self.contact_half / self.spacing) ** 2
        return (_BYTES * _ENTRIES * self.unknowns**_POWER + 4.0 * contact**2) * 1e-9


def make_block(radius_mm: float, side_mm: float, elements_per_radius: float) -> Block:
    """The block for a dimple radius a and impacts in a square of ``side_mm``; a over the top's spacing."""
    spacing = radius_mm / elements_per_radius
    reach = 0.5 * side_mm + _CONTACT_REACH * radius_mm
    half = math.ceil(reach / spacing)
    while (half + len(_OUTER)) % (_STEP // 2):  # twice that many columns must halve at every transition
        half += 1
    outer = half * spacing + spacing * np.cumsum(_OUTER)
    right = np.r_[spacing * np.arange(1, half + 1), outer]
    return Block(
        side=side_mm, spacing=spacing, columns=np.r_[-right[::-1], 0.0, right],
        thickness=radius_mm * np.array([t for t, _ in _LAYERS]), coarser=np.array([int(c) for _, c in _LAYERS]),
        contact_half=(half + 0.01) * spacing,
    )  # fmt: skip


def refuse_too_large(radius_mm: float, block: Block, elements_per_radius: float, limit_GB: float) -> None:
    """Raises InputError when the block needs more memory than ``limit_GB``, and says which would fit."""
    if block.memory_GB <= limit_GB:
        return
    sides = np.arange(block.side, 0.0, -0.25 * radius_mm)
    fits = [s for s in sides if make_block(radius_mm, float(s), elements_per_radius).memory_GB <= limit_GB]
    advice = f"a patch of {fits[0]:.2f} mm would fit" if fits else "no patch fits at this spacing; a coarser one may"
    raise InputError(
        f"the contact model's block of a {block.side:.2f} mm patch has {block.unknowns} unknowns and needs about "
        f"{block.memory_GB:.1f} GB; allowed: {limit_GB:.1f} GB. {advice}"
    )


def available_GB() -> float:
    """Memory that new processes may take; infinite where the system does not tell."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return float(line.split()[1]) * 1024e-9
    except OSError:
        pass
    return math.inf
