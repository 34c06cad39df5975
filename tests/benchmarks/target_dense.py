"""Blocks and cells under many impacts that overlap: cell and stamp against the block, what both cost, what the cell saves."""

from __future__ import annotations

import json
import resource
import statistics
from dataclasses import replace
from functools import cache

import dimple_cases
import numpy as np
import target_cases as cases
from scipy.interpolate import griddata
from target_cases import BLOCK_SIDE, WORK, block

from glue.checkrows import Rows
from glue.errors import NotConverged, PeenError
from glue.surface.roughness import areal
from glue.surface.stamp import height_map
from glue.target.contact import ContactNumerics
from glue.target.reduced_impact import solve_reduced

SEEDS = (1, 2, 3)
COVERAGES = tuple(cases.EXPOSURES)
FINITE_COVERAGES = COVERAGES[:2]  # of the block at finite strain; all of them at small strain, one seed
CELL_EXPOSURES = (0.2, 0.33, 0.5, 0.8, 1.0, 1.2, 1.5, 2.0, 2.7, 3.3, 3.9)
DENSE = ContactNumerics(load_steps=8)  # see the convergence rows


@cache
def dense() -> dict:
    """The block at finite strain at two exposures and the cell at many, three seeds each; the block at small strain, one.

    Impacts by chance.  A block is looked at when the square that it is measured over has the exposure wanted, at the lowest
    once its surroundings have been struck, too.
    """
    found = {"failed": [], "finite": {}, "small": {}, "cells": [], "logs": {}, "exposure": {}, "seeds": {}, "finite_s": [], "cell_s": []}
    side = BLOCK_SIDE * cases.dimple().radius_m
    measured = side - 2 * DENSE.margin_in_radii * cases.dimple().radius_m
    for seed in SEEDS:
        log = cases.chance_log(side, 80, seed)
        inside = cases.exposures_in(log, measured)
        counts = [max(3, int(np.argmax(inside > 0.85 * cases.EXPOSURES[COVERAGES[0]])) + 1)]
        counts += [int(np.argmin(abs(inside - cases.EXPOSURES[c]))) + 1 for c in COVERAGES[1:]]
        found["logs"][seed] = log
        for strain, reach in (("finite", FINITE_COVERAGES), ("small", COVERAGES)):
            if strain == "small" and seed != SEEDS[0]:
                continue
            numerics = replace(DENSE, finite_strain=strain == "finite")
            try:
                results = block(log[: counts[len(reach) - 1]], WORK / "target" / f"{strain}-{seed}", snapshots=counts, numerics=numerics)
            except NotConverged as problem:
                found["failed"].append(f"seed {seed}: {problem.cause}")
                continue
            found[f"{strain}_s"] = found.get(f"{strain}_s", []) + list(results[-1].history["wall_s"])
            for c, count, result in zip(reach, counts, results, strict=False):
                found[strain].setdefault(c, []).append(result)
                found["exposure"].setdefault((strain, c), []).append(inside[count - 1])
                found["seeds"].setdefault((strain, c), []).append(seed)
            found["setup"] = max(found.get("setup", 0.0), results[-1].setup_s)
        found["cells"].append(cases.cell(WORK / "target" / f"cell-{seed}", seed, CELL_EXPOSURES))
        found["cell_s"].append(found["cells"][-1][-1].wall_s)
    found["memory_GB"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024e-9
    return found


def overlap(rows: Rows) -> None:
    """The cell against the block at the same exposure, the block at small strain against finite; what they cost."""
    depth, got = cases.depths(), dense()
    reached = [cases.exposure_of(r.impacts, cases.cell_side()) for r in got["cells"][0]]
    cells = np.array([[cases.at_depths(r, depth) for r in run] for run in got["cells"]])  # seeds, exposures, depths

    for strain, c in [("finite", c) for c in FINITE_COVERAGES] + [("small", c) for c in COVERAGES]:
        blocks = np.array([cases.at_depths(r, depth) for r in got[strain][c]])
        exposures = got["exposure"][strain, c]
        at = np.array([[np.interp(exposures, reached, run[:, k]) for k in range(len(depth))] for run in cells])  # seeds, depths, blocks
        most, rms = cases.deviation(at.mean(axis=(0, 2)), blocks.mean(axis=0))
        scatter = [np.std(x, axis=0).max() / np.abs(x).max() for x in (blocks, at.mean(axis=2))]
        rows.below(f"cell against block ({strain} strain), {c:.0%} coverage: layer means off", most, 0.10,
                   f"rms {rms:.1%}; {len(blocks)} blocks at exposures {', '.join(f'{e:.2f}' for e in exposures)}, scatter {scatter[0]:.1%};"
                   f" {len(cells)} cells, scatter {scatter[1]:.1%}")  # fmt: skip
    for c in FINITE_COVERAGES:
        most, rms = cases.deviation(*(cases.at_depths(got[s][c][0], depth) for s in ("small", "finite")))
        force = [r.history["peak_force_N"].mean() for r in (got["small"][c][0], got["finite"][c][0])]
        rows.below(f"block, small strain against finite, {c:.0%} coverage: layer means off", most, 0.20,
                   f"rms {rms:.1%}; mean peak force {force[0]:.0f} against {force[1]:.0f} N")  # fmt: skip
    rows.below("cell: time to 98 % coverage [s]", statistics.median(got["cell_s"]), 15.0,
               f"{', '.join(f'{s:.1f}' for s in got['cell_s'])} s, {got['cells'][0][-1].impacts} impacts")  # fmt: skip
    for strain in ("small", "finite"):
        seconds = got[f"{strain}_s"]
        rows.below(f"block, {strain} strain: seconds per impact, median", statistics.median(seconds), 8.0,
                   f"largest {max(seconds):.1f}, {len(seconds)} impacts, {got['small'][COVERAGES[-1]][0].dofs} unknowns")  # fmt: skip
    rows.true("block: finite strain comes to 69 % coverage with every seed", not got["failed"], "; ".join(got["failed"]))
    rows.below("block: set-up [s]", got["setup"], 30.0)
    rows.below("block: peak memory [GB]", got["memory_GB"], 3.0)


def many(rows: Rows) -> None:
    """Sixty impacts that overlap, in one run."""
    side = 4.4 * cases.dimple().radius_m
    try:
        result = block(cases.chance_log(side, 60, 7), WORK / "target" / "sixty", side_m=side, numerics=DENSE)[-1]
    except PeenError as problem:
        rows.true("block: 60 overlapping impacts in one run", False, " ".join(str(problem).split())[:200])
        return
    rows.true("block: 60 overlapping impacts in one run", result.impacts == 60,
              f"median {np.median(result.history['wall_s']):.1f} s an impact, exposure {result.patch.exposure:.1f},"
              f" {'finite' if result.finite_strain else 'small'} strain")  # fmt: skip


def surface(rows: Rows) -> None:
    """The stamp against the block's own surface, over the same square; its speed."""
    got, dimple = dense(), cases.dimple()
    law = cases.AL2024.combined
    for c in COVERAGES:
        strain = "finite" if c in FINITE_COVERAGES else "small"
        pairs = []
        for seed, result in zip(got["seeds"][strain, c], got[strain][c], strict=True):
            half = 0.5 * result.measured_side_m
            grid = np.linspace(-half, half, 80)
            log = got["logs"][seed][: result.impacts]
            x, y, z = height_map(log, dimple, (2.2 * half, 2.2 * half), dimple.radius_m / 20, flow_stress_Pa=law.flow_stress_Pa)
            at = np.meshgrid(grid, grid)
            own = griddata((result.surface_x_m, result.surface_y_m), result.surface_z_m, tuple(at), "linear")
            stamped = griddata(tuple(a.ravel() for a in np.meshgrid(x, y)), z.ravel(), tuple(at), "linear")
            hole = ~np.isfinite(own)
            own[hole] = griddata((result.surface_x_m, result.surface_y_m), result.surface_z_m, tuple(at), "nearest")[hole]
            step = grid[1] - grid[0]
            pairs.append((areal(stamped, step, step), areal(own, step, step)))
        where = f"stamp against block ({strain} strain), {c:.0%} coverage"
        for name, limit in (("Sa_m", 0.05), ("Sq_m", 0.05), ("Sz_m", 0.12)):
            mine, theirs = (np.mean([p[i][name] for p in pairs]) for i in (0, 1))
            rows.near(f"{where}: {name[:2]} [um]", 1e6 * mine, 1e6 * theirs, limit, f"{len(pairs)} squares of {2e3 * half:.2f} mm")
        mine, theirs = (np.mean([p[i]["Ssk"] for p in pairs]) for i in (0, 1))
        rows.within(f"{where}: Ssk", mine, theirs, 0.1)
    height_map(cases.chance_log(3e-3, 10, 1), dimple, (3e-3, 3e-3), dimple.radius_m / 16, flow_stress_Pa=law.flow_stress_Pa)
    clock = cases.Clock()
    height_map(cases.chance_log(3e-3, 10_000, 1), dimple, (3e-3, 3e-3), dimple.radius_m / 16, flow_stress_Pa=law.flow_stress_Pa)
    rows.below("stamp: 10 000 impacts on 3 x 3 mm [s]", clock.s, 5.0)


def saving(rows: Rows) -> None:
    """Time saved against impact-by-impact contact, the way to the impacts and the dimple counted on both sides."""
    got = dense()
    per_impact, setup = statistics.median(got["small_s"]), got["setup"]  # small strain: the faster rival
    if not (WORK / "flow.json").exists():
        rows.true("saving: the flow's cost is known (make bench-flow has not been run)", False)
        return
    flow = json.loads((WORK / "flow.json").read_text())["rows"]
    stream = next(r["value"] for r in flow if r["name"].startswith("event-driven, 5 kg/min, wall"))
    clock = cases.Clock()
    with dimple_cases.no_cache():
        solve_reduced(cases.AL2024, cases.AL2024.johnson_cook, speed_m_s=60.0, density_kg_m3=7800.0, elements_per_radius=6)
    dimple_s, cell_s, layers_s = clock.s, statistics.median(got["cell_s"]), 0.01
    print(f"{'impacts':>8} {'contact s':>11} {'cell s':>8} {'saved':>8} {'layers s':>8} {'saved':>8}")
    saved = {}
    for n in (1, 5, 20, 60, 220, 1000, 10_000):
        before = stream * n / 20405.0 + dimple_s
        contact, cell, layers = before + setup + n * per_impact, before + cell_s, before + layers_s
        saved[n] = 1 - cell / contact, 1 - layers / contact
        print(f"{n:>8} {contact:>11.1f} {cell:>8.1f} {saved[n][0]:>8.2%} {layers:>8.1f} {saved[n][1]:>8.2%}")
    print(f"break-even of the cell: {max(0.0, (cell_s - setup) / per_impact):.1f} impacts")
    note = f"{per_impact:.1f} s an impact, set-up {setup:.0f} s, cell {cell_s:.0f} s, dimple {dimple_s:.1f} s, flow {stream:.2f} s per peening s"
    rows.true("cell: saves at least 98 % at 220 impacts", saved[220][0] >= 0.98, f"{saved[220][0]:.2%}; {note}")
    rows.true("cell: saves at least 99.9 % at 10 000", saved[10_000][0] >= 0.999, f"{saved[10_000][0]:.3%}")
    rows.true("layers: save at least 99.9 % at 10 000", saved[10_000][1] >= 0.999, f"{saved[10_000][1]:.3%}; at 220 {saved[220][1]:.2%}")
