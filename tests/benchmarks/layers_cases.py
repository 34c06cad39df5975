"""Truth for the layer model: periodic cells under random impacts, each run once and kept in build/bench/layers.

    python tests/benchmarks/layers_cases.py        (make fit-layers runs it first)

One case is a material and a speed (layers_held_out.toml); its cell is read after every exposure of the file.
A finished case is a file, and is run again when its lines in the plan or its dimple change.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
import time
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.atomic import atomic_path
from glue.scene.catalogue import material
from glue.scene.laws import CombinedHardening, Material
from glue.scene.presets import PRESETS
from glue.target.cell import run_cell
from glue.target.cell_mesh import layer_bounds_mm
from glue.target.dimple import Dimple, tabulated, to_si
from glue.target.driver import law_table
from glue.target.patch import Patch
from glue.target.reduced_impact import ReducedImpact, solve_reduced
from glue.target.speeds import spaced

HERE = Path(__file__).resolve().parent
PLAN = tomllib.loads((HERE / "layers_held_out.toml").read_text(encoding="utf-8"))
FOLDER = HERE.parents[1] / "build" / "bench" / "layers"
ACCURACY = PRESETS["balanced"]
EXPOSURES = sorted(PLAN["fit_exposures"] + PLAN["held_out_exposures"])


class Profile(NamedTuple):
    """Layer means of a cell after ``impacts`` impacts, depths in dimple radii."""

    wanted: float  # exposure of the plan
    exposure: float  # what the whole number of impacts made of it
    impacts: int
    sigma_Pa: np.ndarray  # (layers,) equi-biaxial mean, negative in compression
    peeq: np.ndarray


@dataclass(frozen=True)
class Case:
    """One material and its shots with the impact solved, the dimple that sizes the cell, and what the cell gave."""

    name: str
    training: bool
    material: Material
    impact: ReducedImpact
    dimple: Dimple
    side_m: float
    shots: Shots
    bounds: np.ndarray  # (layers + 1,) faces of the element layers in dimple radii
    profiles: list[Profile]
    wall_s: float


class Shots(NamedTuple):
    """The impacts of a case in order, (n,) each, and how many of them make each exposure."""

    diameter_m: np.ndarray
    speed_m_s: np.ndarray
    radius_m: np.ndarray  # of their dimples
    counts: list[int]


def metal_of(entry: dict) -> Material:
    """The material of a case, with a bounded law of the case's own when it has one."""
    metal, law = material(entry["material"]), entry.get("law")
    if law is None:
        return metal
    pairs = tuple((x, g) for x, g in law["backstresses"])
    return replace(metal, combined=CombinedHardening(law["R0_Pa"], law["Q_Pa"], law["b"], pairs))


def solve_impact(metal: Material, speed_m_s: float) -> ReducedImpact:
    """The impact of the bounded law."""
    return solve_reduced(metal, metal.combined, speed_m_s=speed_m_s, density_kg_m3=PLAN["shot_density_kg_m3"],
                         elements_per_radius=int(PLAN["elements_per_radius"]))  # fmt: skip


def dimple_of(entry: dict, metal: Material) -> Dimple:
    """The dimple that sizes the cell, with a table down to the slowest shot where speeds are mixed."""
    speed, density, diameter = entry["speed_m_s"], PLAN["shot_density_kg_m3"], PLAN["shot_diameter_m"]
    impact, slowest = solve_impact(metal, speed), entry.get("speeds_from_m_s")
    if slowest is None:
        return to_si(impact, speed, density, diameter, (math.nan, math.nan), impact.wall_s)
    runs = {v: solve_impact(metal, v) for v in spaced(slowest, speed, 3)}
    return tabulated(runs, metal, speed, density, diameter)


def shots_of(entry: dict, dimple: Dimple, side_m: float) -> Shots:
    """Equal shots, or sizes and speeds drawn evenly between the ends that ``entry`` gives."""
    exposures, area = np.array(entry.get("exposures", EXPOSURES)), side_m**2
    if "speeds_from_m_s" not in entry:
        counts = [round(x * area / (math.pi * dimple.radius_m**2)) for x in exposures]
        same = np.ones(counts[-1])
        return Shots(same * dimple.diameter_m, same * dimple.speed_m_s, same * dimple.radius_m, counts)
    rng, most = np.random.default_rng([entry["seed"], 1]), 1000
    diameter = rng.uniform(*entry["diameters_m"], most)
    speed = rng.uniform(entry["speeds_from_m_s"], entry["speed_m_s"], most)
    radius = dimple.radius_for(diameter, speed)
    reached = np.cumsum(math.pi * radius**2) / area
    counts = [int(np.abs(reached - x).argmin()) + 1 for x in exposures]
    return Shots(diameter[: counts[-1]], speed[: counts[-1]], radius[: counts[-1]], counts)


def random_patch(dimple: Dimple, shots: Shots, side_m: float, seed: int) -> Patch:
    """The shots anywhere on the cell."""
    x_m, y_m = np.random.default_rng(seed).uniform(0.0, side_m, (2, shots.speed_m_s.size))
    energy_J = 0.5 * dimple.density_kg_m3 * math.pi / 6.0 * shots.diameter_m**3 * shots.speed_m_s**2
    exposure = float(math.pi * (shots.radius_m**2).sum() / side_m**2)
    return Patch(x_m, y_m, energy_J, 0.5 * shots.diameter_m, (0.0, 0.0), exposure, exposure, 0, 0.0)


def case(entry: dict, training: bool) -> Case:
    """Run the cell of ``entry``, or read it when the very same was run before."""
    metal, speed = metal_of(entry), entry["speed_m_s"]
    name = entry.get("name", f"{metal.key}-{speed:g}")
    impact, dimple = solve_impact(metal, speed), dimple_of(entry, metal)
    side = ACCURACY.cell_side_in_radii * dimple.radius_m
    shots = shots_of(entry, dimple, side)
    path, inputs = FOLDER / f"{name}.json", {"entry": entry, "radius_m": f"{dimple.radius_m:.6e}"}
    kept = json.loads(path.read_text()) if path.exists() else {}
    if kept.get("inputs") != inputs:
        kept = _run(name, metal, dimple, shots, side, entry, inputs, path)
    profiles = [
        Profile(p["wanted"], p["exposure"], p["impacts"], np.array(p["sigma_Pa"]), np.array(p["peeq"])) for p in kept["profiles"]
    ]  # fmt: skip
    bounds = layer_bounds_mm(ACCURACY, dimple.radius_m) * 1e-3 / dimple.radius_m
    return Case(name, training, metal, impact, dimple, side, shots, bounds, profiles, kept["wall_s"])


def _run(
    name: str, metal: Material, dimple: Dimple, shots: Shots, side_m: float, entry: dict, inputs: dict, path: Path
) -> dict:
    workdir, begun = FOLDER / f"{name}.run", time.monotonic()
    shutil.rmtree(workdir, ignore_errors=True)
    patch, law = random_patch(dimple, shots, side_m, entry["seed"]), law_table(metal.E_Pa, metal.nu, metal.combined)
    results = run_cell(name, law, ACCURACY, dimple, patch, side_m, workdir, snapshots=shots.counts)
    exposures = np.cumsum(math.pi * shots.radius_m**2) / side_m**2
    profiles = [
        {"wanted": wanted, "exposure": float(exposures[n - 1]), "impacts": n,
         "sigma_Pa": (0.5 * (r.sigma_xx_Pa + r.sigma_yy_Pa)).tolist(), "peeq": r.peeq.tolist()}
        for wanted, n, r in zip(entry.get("exposures", EXPOSURES), shots.counts, results, strict=True)
    ]  # fmt: skip
    record = {"inputs": inputs, "wall_s": time.monotonic() - begun, "profiles": profiles}
    with atomic_path(path) as part:
        part.write_text(json.dumps(record, indent=1) + "\n")
    shutil.rmtree(workdir)
    return record


def all_cases() -> list[Case]:
    """Training cases, then those held out; progress on stderr."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    found = []
    for entry, training in [(e, True) for e in PLAN["training"]] + [(e, False) for e in PLAN["held_out"]]:
        found.append(case(entry, training))
        print(f"{found[-1].name}: cell {found[-1].wall_s:.0f} s", file=sys.stderr, flush=True)
    return found


if __name__ == "__main__":
    all_cases()
