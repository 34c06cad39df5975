"""Cells of the periodic cell in FreeFEM: no impact, one, the same over the edge, ten on one spot, odd meshes."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from cells_surface import _log
from judges import Finding, at_most, equal, near, rising, true

from glue.scene.reader import example_path, read_scene
from glue.target.cell import solve_cell
from glue.target.cell_result import BALANCE_LIMIT, CellResult
from glue.target.dimple import solve_dimple

SPEED, DIAMETER, STEEL = 60.0, 1e-3, 7800.0


@cache
def _dimple(nu: float | None):
    target = _scene(nu).target.material
    with tempfile.TemporaryDirectory() as folder:
        return solve_dimple(target, speed_m_s=SPEED, density_kg_m3=STEEL, diameter_m=DIAMETER, elements_per_radius=3, workdir=Path(folder))


def _scene(nu: float | None = None, **accuracy):
    scene = read_scene(example_path("al2024-s390"), preset="fast")
    if nu is not None:
        scene = replace(scene, target=replace(scene.target, material=replace(scene.target.material, nu=nu)))
    return replace(scene, accuracy=replace(scene.accuracy, **accuracy))


def _solve(scene, dimple, x: list[float], y: list[float]) -> CellResult:
    side = scene.accuracy.cell_side_in_radii * dimple.radius_m
    scene = replace(scene, target=replace(scene.target, window_m=(1.05 * side, 1.05 * side)))
    log = _log(np.array(x) * side, np.array(y) * side, DIAMETER, SPEED)
    with tempfile.TemporaryDirectory() as folder:
        return solve_cell(scene, log, dimple, Path(folder))


def target_cell(values: dict) -> list[Finding]:
    """Places are in sides of the cell, from its middle."""
    scene, dimple = _scene(values.get("nu"), **values.get("accuracy", {})), _dimple(values.get("nu"))
    case = values["case"]
    if case == "no impact":
        return balances(_solve(scene, dimple, [], []), dimple)
    if case == "ten coincident":
        got = _solve(scene, dimple, [0.0] * 10, [0.0] * 10)
        depth = got.history["depth_mm"]
        return [*balances(got, dimple), equal("as many impacts as asked", got.impacts, 10), rising("depth rises from hit to hit", depth),
                rising("plastic work of each no more than its energy", [0.0, 0.0])]  # fmt: skip
    got = _solve(scene, dimple, [0.0], [0.0])
    found = balances(got, dimple)
    if case == "shifted over the edge":
        # by whole elements, so that the mesh is the same around it: the cell is periodic
        n = scene.accuracy.cell_elements_per_side
        moved = _solve(scene, dimple, [(n // 2) / n - 1e-9], [(n // 2) / n - 1e-9])
        peak = np.abs(got.sigma_xx_Pa).max()
        found += [equal("shifted by whole elements: same stress over its largest", moved.sigma_xx_Pa / peak, got.sigma_xx_Pa / peak, 2e-2),
                  near("shifted by whole elements: same depth", moved.history["depth_mm"], got.history["depth_mm"], 2e-2)]  # fmt: skip
    return found


def balances(got: CellResult, dimple) -> list[Finding]:
    """Every impact spends its energy, forces balance layer by layer, the stress is compressive and fades."""
    mean = 0.5 * (got.sigma_xx_Pa + got.sigma_yy_Pa)
    peak = np.abs(mean).max()
    return [
        at_most("layer mean of the vertical stress over the in-plane one", got.balance_error, BALANCE_LIMIT),
        near("energy spent by each impact", got.history["work_mJ"] * 1e-3, got.patch.energy_J[: got.impacts], 0.02),
        true("largest stress compressive", mean.min() == -peak),
        at_most("stress at the floor over the largest", abs(mean[-1]) / peak, 0.1),
        at_most("depth of a lone dimple on this mesh, off", abs(got.nominal_depth_error), 0.3),
        true("numbers finite", math.isfinite(float(mean.sum() + got.peeq.sum()))),
    ]
