"""The surface that a cell or block has after its impacts, on an even grid, for its roughness."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.errors import NotConverged
from glue.target.tables import read_table


def own_surface(folder: Path, count: int, side_m: float, *, period_m: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """(places (n,) along x and y alike [m], heights (n, n) [m], rows along y) after ``count`` impacts, in the model's coordinates.

    period_m: of a periodic cell, whose grid is that of its nodes on [0, period); else the square of ``side_m`` around the
    origin, half the nodes' spacing apart, heights linear between the nodes where they lie now.
    Raises NotConverged when the surface folds away from a part of the square.
    """
    from scipy.interpolate import griddata  # here: half a second that other stages do without

    table = read_table(folder / f"surface-{count}.csv")
    x, y = 1e-3 * table["x_mm"], 1e-3 * table["y_mm"]
    z = 1e-3 * table["u_z"]
    spacing = float(np.diff(np.unique(np.round(x[abs(x) < 0.5 * side_m] if period_m is None else x, 12))).min())
    if period_m is not None:
        count_side = round(period_m / spacing)
        heights = np.full((count_side, count_side), np.nan)
        heights[np.round(y / spacing).astype(int) % count_side, np.round(x / spacing).astype(int) % count_side] = z
        at = spacing * np.arange(count_side)
    else:
        steps = max(2, int(2.0 * side_m / spacing))
        at = side_m * (np.arange(steps + 1) / steps - 0.5)
        now = x + 1e-3 * table["u_x"], y + 1e-3 * table["u_y"]
        heights = griddata(now, z, tuple(np.meshgrid(at, at)), "linear")
    if not np.isfinite(heights).all():
        raise NotConverged("the model's own surface has holes", log=folder / f"surface-{count}.csv",
                           advice="a finer preset (--accuracy reference)")  # fmt: skip
    return at, heights
