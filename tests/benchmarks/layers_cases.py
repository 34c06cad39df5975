"""Truth for the layer model: periodic cells under random impacts, each run once and kept in build/bench/layers.

    python tests/benchmarks/layers_cases.py        (make fit-layers runs it first)

One case is a material and a speed (layers_held_out.toml); its cell is read after every exposure of the file.
A finished case is a file; delete it to run the case again.
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
from glue.target.cell import layer_bounds_mm, run_cell
from glue.target.dimple import Dimple, to_si
from glue.target.driver import law_table
from glue.target.patch import Patch
from glue.target.reduced_impact import ReducedImpact, solve_reduced

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
    """One material and speed with its impact, its dimple and what the cell gave."""

    name: str
    training: bool
    material: Material
    speed_m_s: float
    impact: ReducedImpact
    dimple: Dimple
    bounds: np.ndarray  # (layers + 1,) faces of the element layers in dimple radii
    profiles: list[Profile]
    wall_s: float
    nominal_depth_error: float


def metal_of(entry: dict) -> Material:
    """The material of a case, with a bounded law of the case's own when it has one."""
    metal, law = material(entry["material"]), entry.get("law")
    if law is None:
        return metal
    pairs = tuple((x, g) for x, g in law["backstresses"])
    return replace(metal, combined=CombinedHardening(law["R0_Pa"], law["Q_Pa"], law["b"], pairs))


def solve_impact(metal: Material, speed_m_s: float) -> tuple[ReducedImpact, Dimple]:
    """The impact of the bounded law, and the dimple that sizes the cell."""
    density = PLAN["shot_density_kg_m3"]
    impact = solve_reduced(metal, metal.combined, speed_m_s=speed_m_s, density_kg_m3=density,
                           elements_per_radius=int(PLAN["elements_per_radius"]))  # fmt: skip
    exponents = (math.nan, math.nan)  # one speed: nothing is scaled over it
    return impact, to_si(impact, speed_m_s, density, PLAN["shot_diameter_m"], exponents, impact.wall_s)


def random_patch(dimple: Dimple, side_m: float, count: int, seed: int) -> Patch:
    """``count`` equal impacts anywhere on the cell."""
    places = np.random.default_rng(seed).uniform(0.0, side_m, (2, count))
    mass = dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3
    exposure = count * math.pi * dimple.radius_m**2 / side_m**2
    return Patch(places[0], places[1], np.full(count, 0.5 * mass * dimple.speed_m_s**2),
                 np.full(count, 0.5 * dimple.diameter_m), (0.0, 0.0), exposure, exposure, 0, 0.0)  # fmt: skip


def case(entry: dict, training: bool) -> Case:
    """Run the cell of ``entry``, or read it when it was run before."""
    metal, speed = metal_of(entry), entry["speed_m_s"]
    name = entry.get("name", f"{metal.key}-{speed:g}")
    impact, dimple = solve_impact(metal, speed)
    path = FOLDER / f"{name}.json"
    if not path.exists():
        _run(name, metal, dimple, entry["seed"], entry.get("exposures", EXPOSURES), path)
    kept = json.loads(path.read_text())
    profiles = [Profile(p["wanted"], p["exposure"], p["impacts"], *(np.array(p[k]) for k in Profile._fields[3:]))
                for p in kept["profiles"]]  # fmt: skip
    bounds = layer_bounds_mm(ACCURACY, dimple.radius_m) * 1e-3 / dimple.radius_m
    return Case(name, training, metal, speed, impact, dimple, bounds, profiles, kept["wall_s"],
                kept["nominal_depth_error"])  # fmt: skip


def _run(name: str, metal: Material, dimple: Dimple, seed: int, exposures: list[float], path: Path) -> None:
    side = ACCURACY.cell_side_in_radii * dimple.radius_m
    per_impact = math.pi * dimple.radius_m**2 / side**2
    counts = [round(exposure / per_impact) for exposure in exposures]
    patch = random_patch(dimple, side, counts[-1], seed)
    workdir, begun = FOLDER / f"{name}.run", time.monotonic()
    shutil.rmtree(workdir, ignore_errors=True)
    results = run_cell(name, law_table(metal.E_Pa, metal.nu, metal.combined), ACCURACY, dimple, patch, side, workdir,
                       snapshots=counts)  # fmt: skip
    profiles = [
        Profile(wanted, n * per_impact, n, 0.5 * (r.sigma_xx_Pa + r.sigma_yy_Pa), r.peeq)
        for wanted, n, r in zip(exposures, counts, results, strict=True)
    ]  # fmt: skip
    record = {
        "case": name, "seed": seed, "radius_m": dimple.radius_m, "wall_s": time.monotonic() - begun,
        "nominal_depth_error": results[-1].nominal_depth_error,
        "profiles": [{k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in p._asdict().items()} for p in profiles],
    }  # fmt: skip
    with atomic_path(path) as part:
        part.write_text(json.dumps(record, indent=1) + "\n")
    shutil.rmtree(workdir)


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
