"""What a solved cell tells: layer means and coverage by plastic strain from its tables, and whether to trust them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.errors import NotConverged
from glue.scene.presets import Accuracy
from glue.target.cell_mesh import layer_bounds_mm
from glue.target.dimple import Dimple
from glue.target.patch import Patch, unresolved
from glue.target.tables import read_table

LITERATURE_THRESHOLD = 0.027  # equivalent plastic strain that finite-element studies often count as covered
NOMINAL_DEPTH_LIMIT = 0.3  # nominal dimple of this mesh against the representative one: +7 % balanced, +16 % at 300 m/s
BALANCE_LIMIT = 0.05  # layer mean of the vertical stress (exactly 0) over the largest in-plane one
# In-plane stress of the lowest layer over the largest: below 2 % as a rule; 30 % where a shot's force over the cell's
# area makes its whole height yield (ten on one spot, or a cell of 2.6 radii).
FLOOR_LIMIT = 0.1


@dataclass(frozen=True)
class CellResult:
    """Layer means over the cell (n layers, top first) and the cell's own surface."""

    depth_m: np.ndarray  # (n,) middle of each layer
    sigma_xx_Pa: np.ndarray  # (n,)
    sigma_yy_Pa: np.ndarray
    sigma_xx_std_Pa: np.ndarray  # standard deviation over position inside the layer, of blocks an element wide
    sigma_yy_std_Pa: np.ndarray
    peeq: np.ndarray
    peeq_std: np.ndarray
    balance_error: float  # see BALANCE_LIMIT
    coverage_peeq: float  # share of the top layer above edge_threshold; nan when one impact hardly yields the layer
    coverage_peeq_027: float  # and above LITERATURE_THRESHOLD
    edge_threshold: float  # plastic strain at the edge of the nominal dimple on this very mesh
    nominal_depth_error: float  # depth of the nominal dimple on this mesh over the representative dimple's, minus 1
    nominal_force_error: float
    history: dict[str, np.ndarray]  # (impacts,) each: columns of impacts_done.csv
    surface_x_m: np.ndarray  # (m,) nodes of the cell's surface
    surface_y_m: np.ndarray
    surface_z_m: np.ndarray
    patch: Patch
    side_m: float
    floor_m: float  # depth of the cell
    impacts: int
    dofs: int
    wall_s: float
    unresolved_impacts: int = 0  # whose dimples are finer than the elements, see glue.target.patch.unresolved
    unresolved_energy_share: float = 0.0


def read_cell(
    workdir: Path, accuracy: Accuracy, dimple: Dimple, patch: Patch, side_m: float, count: int
) -> CellResult:
    """Read the tables of a finished cell after ``count`` impacts and reduce them to layer means."""
    points, surface = read_table(workdir / f"points-{count}.csv"), read_table(workdir / f"surface-{count}.csv")
    result = {k: v[0] for k, v in read_table(workdir / "result.csv").items()}
    done = read_table(workdir / "impacts_done.csv")
    nominal = {k: v[0] for k, v in done.items()}
    bounds = layer_bounds_mm(accuracy, dimple.radius_m)
    layer = np.clip(np.searchsorted(bounds, -points["z_mm"]) - 1, 0, len(bounds) - 2)
    volume = np.bincount(layer, points["volume_mm3"])

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(layer, points["volume_mm3"] * values) / volume

    # Scatter is that of means over blocks of six tetrahedra: inside one element plastic flow at constant volume lets
    # the pressure oscillate from Gauss point to Gauss point (twice the scatter, no physics; layer means have none).
    n, size = accuracy.cell_elements_per_side, side_m * 1e3 / accuracy.cell_elements_per_side
    column = np.minimum(points["x_mm"] // size, n - 1) * n + np.minimum(points["y_mm"] // size, n - 1)
    block = layer * n * n + column.astype(int)
    block_volume = np.bincount(block, points["volume_mm3"])

    def spread(values: np.ndarray) -> np.ndarray:
        return (
            (np.bincount(block, points["volume_mm3"] * values) / block_volume).reshape(-1, n * n).std(axis=1)
        )

    vertical, in_plane = mean(points["s_zz"]), mean(0.5 * (points["s_xx"] + points["s_yy"]))
    top, fresh = read_table(workdir / "final_top.csv"), read_table(workdir / "nominal_top.csv")
    threshold = edge_threshold(fresh["peeq"], fresh["volume_mm3"], math.pi * dimple.radius_m**2 / side_m**2)
    faint = unresolved(patch, dimple, side_m / n)[:count]
    return CellResult(
        depth_m=0.5e-3 * (bounds[:-1] + bounds[1:]),
        sigma_xx_Pa=mean(points["s_xx"]) * 1e6, sigma_yy_Pa=mean(points["s_yy"]) * 1e6,
        sigma_xx_std_Pa=spread(points["s_xx"]) * 1e6, sigma_yy_std_Pa=spread(points["s_yy"]) * 1e6,
        peeq=mean(points["peeq"]), peeq_std=spread(points["peeq"]),
        balance_error=float(np.abs(vertical).max() / np.abs(in_plane).max()),
        coverage_peeq=_share(top, threshold) if threshold > 0.0 else math.nan,
        coverage_peeq_027=_share(top, LITERATURE_THRESHOLD), edge_threshold=threshold,
        nominal_depth_error=float(nominal["depth_mm"] * 1e-3 / dimple.depth_m - 1.0),
        nominal_force_error=float(nominal["peak_force_N"] / dimple.peak_force_N - 1.0),
        history={k: v[1 : count + 1] for k, v in done.items()},
        surface_x_m=surface["x_mm"] * 1e-3, surface_y_m=surface["y_mm"] * 1e-3, surface_z_m=surface["u_z"] * 1e-3,
        patch=patch, side_m=side_m, floor_m=1e-3 * bounds[-1], impacts=count,
        dofs=int(result["dofs"]), wall_s=float(result["wall_s"]),
        unresolved_impacts=int(faint.sum()),
        unresolved_energy_share=float(patch.energy_J[:count][faint].sum() / patch.energy_J[:count].sum()),
    )  # fmt: skip


def edge_threshold(peeq: np.ndarray, volume: np.ndarray, share: float) -> float:
    """Plastic strain that is exceeded on ``share`` of the layer: after one impact, that at its dimple's edge.

    The same mesh and the same kinematics then judge one impact and many alike.  0 when less than ``share`` yielded.
    """
    order = np.argsort(peeq)[::-1]
    covered = np.cumsum(volume[order]) / volume.sum()
    return float(np.interp(share, covered, peeq[order]))


def _share(table: dict[str, np.ndarray], threshold: float) -> float:
    return float(table["volume_mm3"][table["peeq"] >= threshold].sum() / table["volume_mm3"].sum())


def check(result: CellResult, log: Path) -> None:
    """Refuse a result that its mesh or its balance does not bear out (NotConverged)."""
    problems = []
    if not abs(result.nominal_depth_error) <= NOMINAL_DEPTH_LIMIT:
        problems.append(
            f"the nominal dimple comes out {result.nominal_depth_error:+.0%} deep against the representative one"
            f" (limit {NOMINAL_DEPTH_LIMIT:.0%})"
        )
    if not result.balance_error <= BALANCE_LIMIT:
        problems.append(
            f"mean vertical stress is {result.balance_error:.1%} of the in-plane one (limit {BALANCE_LIMIT:.0%})"
        )
    mean = np.abs(0.5 * (result.sigma_xx_Pa + result.sigma_yy_Pa))
    if not mean[-1] <= FLOOR_LIMIT * mean.max():
        problems.append(
            f"stress at the cell's floor is {mean[-1] / mean.max():.0%} of the largest (limit {FLOOR_LIMIT:.0%}):"
            " the plastic zone reaches it"
        )
    if problems:
        raise NotConverged("the target cell is not to be trusted", cause="; ".join(problems), log=log,
                           advice="a finer preset (--accuracy reference)")  # fmt: skip
