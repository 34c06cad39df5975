"""From the clamped cell to the part: layer means over the whole depth, with stretch and bending let go."""

from __future__ import annotations

import numpy as np

from glue.target.cell import CellResult
from glue.theory.plate import released_stress

_BELOW = 8  # points between the cell's floor and the part's back


def part_profile(cell: CellResult, thickness_m: float | None) -> dict[str, np.ndarray]:
    """Columns of the stress profile by name, each (rows,), depth rising.

    No thickness: the cell's layers as they are, a part too thick to stretch or bend.  With one: a plate peened
    on one side and free to do both; the profile then reaches from the surface (extrapolated) to the back, and its
    force and moment vanish.  The cell's floor, where the stress has faded, is taken as stress-free before release.
    """
    columns = {name: getattr(cell, name) for name in (
        "depth_m", "sigma_xx_Pa", "sigma_yy_Pa", "peeq", "sigma_xx_std_Pa", "sigma_yy_std_Pa", "peeq_std",
    )}  # fmt: skip
    if thickness_m is None:
        return columns
    below = np.linspace(cell.floor_m, thickness_m, _BELOW)
    depth = np.r_[0.0, cell.depth_m, below]
    share = cell.depth_m[0] / (cell.depth_m[1] - cell.depth_m[0])

    def extended(values: np.ndarray, surface: float) -> np.ndarray:
        return np.r_[surface, values, np.zeros(_BELOW)]

    result = {"depth_m": depth}
    for name, values in list(columns.items())[1:]:
        if name in ("sigma_xx_Pa", "sigma_yy_Pa"):
            surface = values[0] - share * (values[1] - values[0])
            result[name] = released_stress(depth, extended(values, surface), thickness_m)
        else:
            result[name] = extended(values, values[0])
    return result
