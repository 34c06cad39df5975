"""Extremes of the target: each through the contact block and the cell, right by named invariants or refused with the reason.

A row FAILS when a result is returned that breaks an invariant, or when a run ends in any other way than with a result or
an InputError or NotConverged that says why.  The blocks are coarse: what is asked is whether a number that comes out can be
believed within the stated limits, not how near it is to the last per cent.  Limits were fixed before the first run.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import target_cases as cases

from glue.checkrows import Rows
from glue.errors import InputError, NotConverged
from glue.scene.laws import CombinedHardening, Material
from glue.scene.presets import PRESETS
from glue.solvers import repo_root
from glue.target.cell import run_cell
from glue.target.contact import ContactNumerics, solve_contact
from glue.target.dimple import Dimple, solve_dimple
from glue.target.driver import law_table
from glue.target.patch import normal_energy_J
from glue.target.reduced_impact import solve_hits

WORK = repo_root() / "build" / "bench" / "target"
COARSE = ContactNumerics(side_in_radii=3.2, margin_in_radii=1.0, elements_per_radius=2.0, load_steps=8)
FINE = replace(COARSE, side_in_radii=1.4, margin_in_radii=0.19, elements_per_radius=5.0)  # 1.5 a radius of a .3 mm shot's dimple; 1.3 GB

ENERGY = 0.01  # work given to the target over the shot's own m v^2 / 2, minus 1, every impact
ACCOUNT = 0.04  # work of the internal forces over energy given and not returned, minus 1 (block: it knows both)
FORCES = 0.05  # mean vertical stress of a layer over the largest in-plane one
SAME = 1e-6  # energy of the impacts solved over that of the log, minus 1: none lost, none changed
DEPTH = {"block": 0.10, "cell": 0.20}  # deepest point against the axisymmetric solver's: 2 and 1.5 elements a radius
DEPTH_AGAIN = {True: 0.10, False: 0.30}  # after ten hits, at finite strain; at small strain, as in the cell
DEPTH_SMALL = 0.15  # of the .3 mm shot
PERIODIC = 0.01  # an impact on the edge of a periodic cell against one that many whole elements further in


@dataclass(frozen=True)
class Extreme:
    """``log``: (side [m], dimple) -> impacts; depth: expected depth [m] of the last one, given the dimple."""

    name: str
    material: Material
    speed_m_s: float
    log: Callable[[float, Dimple, float], np.ndarray]
    numerics: ContactNumerics = COARSE
    hits: int = 1
    models: tuple[str, ...] = ("block", "cell")


def same_law(law: CombinedHardening, nu: float = cases.AL2024.nu) -> Material:
    """A material whose single impacts and whose overlapping ones obey ``law``."""
    return replace(cases.AL2024, nu=nu, johnson_cook=None, voce=law, combined=law)


def at(places, speed: float, diameters=None) -> np.ndarray:
    log = cases.chance_log(1e-3, len(places), 0, speed)
    log["x_m"], log["y_m"] = np.array(places).T
    if diameters is not None:
        log["diameter_m"] = diameters
    return log


def middle(side_m: float, dimple: Dimple, speed: float) -> np.ndarray:
    return at([(0.0, 0.0)], speed)


def ten(side_m: float, dimple: Dimple, speed: float) -> np.ndarray:
    return at([(0.0, 0.0)] * 10, speed)


def edge(side_m: float, dimple: Dimple, speed: float) -> np.ndarray:
    return at([(0.5 * side_m, 0.0)], speed)


def mixed(side_m: float, dimple: Dimple, speed: float) -> np.ndarray:
    """A .3 mm shot, then a 1 mm shot so far beside it that their dimples just do not meet."""
    return at([(-0.7 * dimple.radius_m, 0.0), (0.7 * dimple.radius_m, 0.0)], speed, [0.3e-3, 1e-3])


DEFAULT = same_law(cases.AL2024.combined)
EXTREMES = (
    Extreme("300 m/s", DEFAULT, 300.0, middle),
    Extreme("1 m/s", DEFAULT, 1.0, middle),
    Extreme("nu .49", same_law(cases.AL2024.combined, 0.49), 60.0, middle),
    Extreme("perfectly plastic, 300 MPa", same_law(CombinedHardening(300e6, 0.0, 1.0, ())), 60.0, middle),
    Extreme("A = 2500 MPa", same_law(CombinedHardening(2500e6, 0.0, 1.0, ())), 60.0, middle),
    Extreme("mixed, .3 and 1 mm", DEFAULT, 60.0, mixed, FINE),
    Extreme("on the window's edge", DEFAULT, 60.0, edge),
    Extreme("10 at one spot", DEFAULT, 60.0, ten, hits=10),
    Extreme("10 at one spot, finite strain", DEFAULT, 60.0, ten, replace(COARSE, finite_strain=True), hits=10, models=("block",)),
)


def extremes(rows: Rows) -> None:
    for case in EXTREMES:
        for model in case.models:
            judge(rows, f"extreme: {case.name}, {model}", lambda case=case, model=model: {"block": block, "cell": cell}[model](case))


def judge(rows: Rows, name: str, run: Callable[[], dict[str, tuple[float, float]]]) -> None:
    """``run`` gives {invariant: (value, limit)}; the row's value is the worst of value over limit."""
    try:
        found = run()
    except (InputError, NotConverged) as refusal:
        text = " ".join((getattr(refusal, "cause", "") or str(refusal)).split())  # the cause: logs lie elsewhere each time
        rows.true(f"{name}: refused with the reason", len(text) > 20, text[:240])
        return
    except Exception as crash:  # whatever it is: the row tells it and the next one runs
        rows.true(f"{name}: right or refused", False, f"{type(crash).__name__}: {' '.join(str(crash).split())[:240]}")
        return
    worst = max((value / limit if math.isfinite(value) else math.inf) for value, limit in found.values())
    rows.below(f"{name}: worst of value over limit", worst, 1.0,
               "; ".join(f"{key} {value:.2g} (limit {limit:g})" for key, (value, limit) in found.items()))  # fmt: skip


def the_dimple(case: Extreme) -> Dimple:
    return solve_dimple(case.material, speed_m_s=case.speed_m_s, density_kg_m3=cases.STEEL, diameter_m=cases.DIAMETER,
                        elements_per_radius=6, workdir=WORK / "extreme-dimple")  # fmt: skip


def expected_depth_m(case: Extreme, dimple: Dimple) -> float:
    if case.hits == 1:
        return dimple.depth_m
    hits = solve_hits(case.material, case.material.combined, hits=case.hits, speed_m_s=case.speed_m_s,
                      density_kg_m3=cases.STEEL, elements_per_radius=6)  # fmt: skip
    return float(hits.depth[-1]) * 0.5 * cases.DIAMETER


def account(history: dict, log: np.ndarray) -> dict[str, tuple[float, float]]:
    """What every result owes: all impacts, their own energy, spent on the target."""
    given, own = history["energy_mJ"] * 1e-3, normal_energy_J(log)
    lost = abs(given / own - 1.0).max() if len(given) == len(own) else math.inf
    return {
        "impacts' own energy": (float(lost), SAME),
        "work given": (float(abs(history["work_mJ"] / history["energy_mJ"] - 1.0).max()), ENERGY),
    }


def off(value: float, expected: float) -> float:
    return float(abs(value / expected - 1.0))


def block(case: Extreme) -> dict[str, tuple[float, float]]:
    dimple = the_dimple(case)
    side = case.numerics.side_in_radii * dimple.radius_m
    log = case.log(side, dimple, case.speed_m_s)
    result = solve_contact(case.material, log, dimple, (side, side), _folder(case, "block"), numerics=case.numerics)[-1]
    h = result.history
    limit = DEPTH_AGAIN[result.finite_strain] if case.hits > 1 else DEPTH["block"]
    found = account(h, log) | {
        "internal work": (float(abs(h["work_inside_mJ"] / (h["work_mJ"] - h["back_mJ"]) - 1.0).max()), ACCOUNT),
        "vertical force": (result.balance_error, FORCES),
        "depth": (off(1e-3 * h["depth_mm"][-1], expected_depth_m(case, dimple)), limit),
    }
    if case.log is mixed:
        found["depth of the .3 mm"] = off(1e-3 * h["depth_mm"][0], 0.3 * dimple.depth_m), DEPTH_SMALL
    return found


def cell(case: Extreme) -> dict[str, tuple[float, float]]:
    dimple, accuracy = the_dimple(case), PRESETS["balanced"]
    side = accuracy.cell_side_in_radii * dimple.radius_m
    log = case.log(side, dimple, case.speed_m_s)
    table = law_table(case.material.E_Pa, case.material.nu, case.material.combined)

    def run(log: np.ndarray):
        return run_cell(case.name, table, accuracy, dimple, cases.patch_of(log, side, 1.0), side, _folder(case, "cell"))[-1]

    result = run(log)
    h = result.history
    found = account(h, log) | {
        "vertical force": (result.balance_error, FORCES),
        "depth": (off(1e-3 * h["depth_mm"][-1], expected_depth_m(case, dimple)), DEPTH_AGAIN[False] if case.hits > 1 else DEPTH["cell"]),
    }
    if case.log is edge:
        log["x_m"] -= 3 * side / accuracy.cell_elements_per_side
        found["depth against three elements further in"] = off(h["depth_mm"][-1], run(log).history["depth_mm"][-1]), PERIODIC
    if case.log is mixed:  # .3 mm dimples are finer than the cell's elements: it has to say so
        found["finer than the elements, not told"] = float(result.unresolved_impacts != 1), 0.5
    return found


def _folder(case: Extreme, model: str) -> Path:
    folder = WORK / f"extreme-{EXTREMES.index(case)}-{model}"
    shutil.rmtree(folder, ignore_errors=True)  # what an earlier benchmark left may be of other numbers
    return folder

