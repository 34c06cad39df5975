"""What a solved block tells: layer means over the measured square from its tables, and whether to trust them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.errors import NotConverged
from glue.target.block import Block
from glue.target.dimple import Dimple
from glue.target.patch import Patch, unresolved
from glue.target.tables import read_table

WORK_LIMIT = 0.01  # work of an impact over the shot's normal kinetic energy, minus 1
# Work of the internal forces over energy spent and not returned, minus 1.  Both are parabolas along the path; what is
# out of balance within the force tolerance has a sign and adds up: 1 % with 12 penetration steps (make bench-target).
ACCOUNT_LIMIT = 0.04
UNBALANCED_LIMIT = 0.01  # forces left in the unloaded block over the impact's peak force
# Mean of the vertical stress over a layer of the block over the largest in-plane one, down to BALANCE_DEPTH dimple
# radii: 0 in a free block; further down the clamped sides carry some of it.
BALANCE_LIMIT, BALANCE_DEPTH = 0.05, 4.0


@dataclass(frozen=True)
class ContactResult:
    """Layer means over the measured square (n layers, top first), its surface, and what each impact did."""

    depth_m: np.ndarray  # (n,) middle of each layer
    sigma_xx_Pa: np.ndarray  # (n,)
    sigma_yy_Pa: np.ndarray
    sigma_xx_std_Pa: np.ndarray  # standard deviation over position, of blocks two grid spacings wide
    sigma_yy_std_Pa: np.ndarray
    peeq: np.ndarray
    peeq_std: np.ndarray
    balance_error: float  # see BALANCE_LIMIT
    surface_x_m: np.ndarray  # (m,) nodes of the measured square where they lie now, origin in its middle
    surface_y_m: np.ndarray
    surface_z_m: np.ndarray
    history: dict[str, np.ndarray]  # (impacts,) each: columns of impacts_done.csv
    patch: Patch
    measured_side_m: float
    floor_m: float
    impacts: int
    finite_strain: bool
    dofs: int
    setup_s: float
    wall_s: float
    unresolved_impacts: int = 0  # whose dimples are finer than the mesh, see glue.target.patch.unresolved
    unresolved_energy_share: float = 0.0


def read_contact(
    workdir: Path, block: Block, dimple: Dimple, patch: Patch, margin_in_radii: float, finite_strain: bool, count: int
) -> ContactResult:
    """Reduce a finished run's tables after ``count`` impacts to layer means over the square inside the margin."""
    points, surface = read_table(workdir / f"points-{count}.csv"), read_table(workdir / f"surface-{count}.csv")
    result = {k: v[0] for k, v in read_table(workdir / "result.csv").items()}
    done = read_table(workdir / "impacts_done.csv")
    radius_mm = dimple.radius_m * 1e3
    half = 0.5 * block.side - margin_in_radii * radius_mm
    layers = len(block.thickness)
    layer = np.clip(np.searchsorted(block.bounds, -points["z_mm"]) - 1, 0, layers - 1)
    volume = points["volume_mm3"]

    # Forces through each layer of the whole block, over those along it.
    def total(values: np.ndarray) -> np.ndarray:
        return np.bincount(layer, volume * values, minlength=layers) / block.thickness

    vertical, along = total(points["s_zz"]), total(0.5 * (points["s_xx"] + points["s_yy"]))
    inside = (abs(points["x_mm"]) < half) & (abs(points["y_mm"]) < half)
    layer, volume = layer[inside], volume[inside]
    inner = {name: values[inside] for name, values in points.items()}
    weight = np.bincount(layer, volume, minlength=layers)
    blocks = max(1, int(half / block.spacing))
    row, place = (np.minimum((inner[f"{a}_mm"] + half) * blocks // (2 * half), blocks - 1).astype(int) for a in "xy")
    column = (layer * blocks + row) * blocks + place
    column_weight = np.bincount(column, volume, minlength=layers * blocks**2)

    def mean(name: str) -> np.ndarray:
        return np.bincount(layer, volume * inner[name], minlength=layers) / weight

    def spread(name: str) -> np.ndarray:
        sums = np.bincount(column, volume * inner[name], minlength=layers * blocks**2)
        with np.errstate(invalid="ignore"):
            return np.nanstd((sums / column_weight).reshape(layers, -1), axis=1)

    x, y, z = (surface[f"{axis}_mm"] + surface[f"u_{axis}"] if axis != "z" else surface["u_z"] for axis in "xyz")
    seen = (abs(x) < half) & (abs(y) < half)
    shallow = block.bounds[:-1] < BALANCE_DEPTH * radius_mm
    faint, energy = unresolved(patch, dimple, 1e-3 * block.spacing)[:count], patch.energy_J[:count]
    return ContactResult(
        depth_m=0.5e-3 * (block.bounds[:-1] + block.bounds[1:]),
        sigma_xx_Pa=mean("s_xx") * 1e6, sigma_yy_Pa=mean("s_yy") * 1e6,
        sigma_xx_std_Pa=spread("s_xx") * 1e6, sigma_yy_std_Pa=spread("s_yy") * 1e6,
        peeq=mean("peeq"), peeq_std=spread("peeq"),
        balance_error=float(np.abs(vertical[shallow]).max() / np.abs(along).max()),
        surface_x_m=x[seen] * 1e-3, surface_y_m=y[seen] * 1e-3, surface_z_m=z[seen] * 1e-3,
        history={k: v[:count] for k, v in done.items()}, patch=patch,
        measured_side_m=2e-3 * half, floor_m=1e-3 * float(block.bounds[-1]),
        impacts=count, finite_strain=finite_strain,
        dofs=int(result["dofs"]), setup_s=float(result["setup_s"]), wall_s=float(result["wall_s"]),
        unresolved_impacts=int(faint.sum()), unresolved_energy_share=float(energy[faint].sum() / energy.sum()),
    )  # fmt: skip


def check(result: ContactResult, log: Path) -> None:
    """Refuse a result whose energies or forces do not balance (NotConverged)."""
    h, problems = result.history, []

    def worst(what: str, off: np.ndarray, limit: float) -> None:
        if not off.max() <= limit:
            problems.append(f"impact {int(h['impact'][off.argmax()])}: {what} {off.max():.1%} (limit {limit:.0%})")

    if len(h["impact"]) != result.impacts:
        problems.append(f"{len(h['impact'])} of {result.impacts} impacts done")
    worst("work off the shot's energy by", abs(h["work_mJ"] / h["energy_mJ"] - 1.0), WORK_LIMIT)
    spent = h["work_mJ"] - h["back_mJ"]
    worst("work of the internal forces off by", abs(h["work_inside_mJ"] / spent - 1.0), ACCOUNT_LIMIT)
    worst("forces of the unloaded block over the peak force", h["unbalanced_N"] / h["peak_force_N"], UNBALANCED_LIMIT)
    if not result.balance_error <= BALANCE_LIMIT:
        off = result.balance_error
        problems.append(f"mean vertical stress is {off:.1%} of the in-plane one (limit {BALANCE_LIMIT:.0%})")
    if problems:
        raise NotConverged("the contact model is not to be trusted", cause="; ".join(problems), log=log,
                           advice="more elements per radius, or a tighter force tolerance")  # fmt: skip
