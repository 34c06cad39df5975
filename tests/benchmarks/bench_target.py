"""Target benchmark: contact block, periodic cell, layer model and stamp against each other; PASS or FAIL rows (make bench-target).

    python tests/benchmarks/bench_target.py [--only NAME ...] [--json FILE]

The limits were fixed before the runs.  Reference runs share neither mesh nor code path with what they judge: the block
is judged by the axisymmetric solver, the cell by the block, layers by cells (make fit-layers), the stamp by the block's
own surface.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import statistics
import sys
import tempfile
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from scipy.interpolate import griddata

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import target_cases as cases
from target_extremes import extremes

from glue.checkrows import Rows
from glue.errors import InputError, NotConverged, PeenError
from glue.scene.laws import CombinedHardening, JohnsonCook
from glue.solvers import build_plugin, repo_root
from glue.surface.roughness import areal
from glue.surface.stamp import height_map
from glue.surface.stress import plate_balance
from glue.target.contact import ContactNumerics, solve_contact
from glue.target.dimple import zero_height_radius
from glue.target.part import part_profile, strip_arc_height_m
from glue.target.reduced_impact import solve_hits, solve_reduced
from glue.target.tables import read_table

WORK = repo_root() / "build" / "bench"
SEEDS = (1, 2, 3)
COVERAGES = tuple(cases.EXPOSURES)
FINITE_COVERAGES = COVERAGES[:2]  # of the block at finite strain; all of them at small strain, one seed
CELL_EXPOSURES = (0.2, 0.33, 0.5, 0.8, 1.0, 1.2, 1.5, 2.0, 2.7, 3.3, 3.9)
DENSE = ContactNumerics(load_steps=8)  # see the convergence rows
EDGES_MM = np.array([0, 0.015, 0.03, 0.06, 0.1, 0.15, 0.2, 0.26, 0.33, 0.42])
BLOCK_SIDE = 5.5  # dimple radii, of the patch whose impacts the block solves; the inner 2.5 are measured


def block(log: np.ndarray, folder: Path, *, law=None, numerics=ContactNumerics(), snapshots=(), side_m=None):  # noqa: B008 - frozen
    """The contact model under ``log``, all of it."""
    side = side_m or BLOCK_SIDE * cases.dimple().radius_m
    numerics = replace(numerics, side_in_radii=side / cases.dimple().radius_m)
    return solve_contact(cases.AL2024, log, cases.dimple(), (side * 1.0001, side * 1.0001), folder, law=law,
                         numerics=numerics, snapshots=snapshots, title="benchmark", resume=True)  # fmt: skip


@cache
def hits_at_one_spot() -> tuple:
    """Two impacts at the origin with the single impact's law, kept for the rows that need them."""
    folder = WORK / "target" / "spot"
    log = cases.chance_log(1e-3, 2, 0)
    log["x_m"] = log["y_m"] = 0.0
    results = block(log, folder, law=cases.AL2024.johnson_cook, snapshots=(1,))
    return results, read_table(folder / "points-1.csv"), read_table(folder / "surface-1.csv"), read_table(folder / "surface-2.csv")


def crater(surface: dict[str, np.ndarray]) -> tuple[float, float]:
    """(depth, zero-height radius) [mm] of a dimple around the origin: a parabola through its bottom, rays outwards."""
    x, y, z = surface["x_mm"] + surface["u_x"], surface["y_mm"] + surface["u_y"], surface["u_z"]
    r, a = np.hypot(x, y), 1e3 * cases.dimple().radius_m
    bottom = np.polyfit(r[r < 0.6 * a] ** 2, z[r < 0.6 * a], 1)
    angles = np.linspace(0, 2 * math.pi, 72, endpoint=False)
    radii = np.linspace(0.5 * a, 1.6 * a, 200)
    near = r < 2.2 * a
    height = griddata((x[near], y[near]), z[near], (radii * np.cos(angles)[:, None], radii * np.sin(angles)[:, None]), "cubic")
    return -float(bottom[1]), float(np.mean([radii[np.argmax(row >= 0)] for row in height]))


def single(rows: Rows) -> None:
    """One impact and a second at the same spot, against the axisymmetric solver."""
    fine = solve_reduced(cases.AL2024, cases.AL2024.johnson_cook, speed_m_s=cases.SPEED, density_kg_m3=cases.STEEL,
                         elements_per_radius=24)  # fmt: skip
    R = 0.5e3 * cases.DIAMETER
    results, points, first, second = hits_at_one_spot()
    history = results[-1].history
    depth, radius = crater(first)
    rows.near("one impact: peak force [N]", history["peak_force_N"][0], fine.peak_force * R**2, 0.015)
    rows.near("one impact: radius [mm]", radius, zero_height_radius(fine) * R, 0.015)
    rows.near("one impact: depth [mm]", depth, -fine.surface_z[0] * R, 0.03, f"deepest node {history['depth_mm'][0]:.4f}")
    rows.within("one impact: e", history["restitution"][0], fine.restitution, 0.02)
    ours, theirs = cases.bins_of_points(points, EDGES_MM, 0.1), cases.bins_of(fine, EDGES_MM, 0.1)
    for k, off in enumerate(ours / theirs - 1.0):
        limit = 0.10 if EDGES_MM[k] >= 0.03 else 0.15
        rows.below(f"one impact: stress at {1e3 * EDGES_MM[k]:.0f}-{1e3 * EDGES_MM[k + 1]:.0f} um, off", abs(off), limit,
                   f"{ours[k]:.0f} against {theirs[k]:.0f} MPa, r < .1 mm")  # fmt: skip
    hits = solve_hits(cases.AL2024, cases.AL2024.johnson_cook, hits=2, speed_m_s=cases.SPEED, density_kg_m3=cases.STEEL,
                      elements_per_radius=12)  # fmt: skip
    depth, radius = crater(second)
    rows.near("second hit: peak force [N]", history["peak_force_N"][1], hits.peak_force[1] * R**2, 0.01)
    rows.near("second hit: depth [mm]", depth, hits.depth[1] * R, 0.05)
    rows.near("second hit: radius [mm]", radius, hits.radius[1] * R, 0.05)
    rows.within("second hit: e", history["restitution"][1], hits.restitution[1], 0.02)
    given = float(history["work_mJ"].sum())
    account = float(history["work_inside_mJ"].sum() + history["back_mJ"].sum())
    rows.near("two impacts: work of internal forces + energy returned [mJ]", account, given, 0.01)


def convergence(rows: Rows) -> None:
    """A set of five impacts on finer meshes and with smaller steps: layer means come together.

    At small strain: at finite strain meshes of 2.0 and 2.6 elements a radius fold at the fourth.
    """
    side = 4.2 * cases.dimple().radius_m
    log = cases.chance_log(2.4 * cases.dimple().radius_m, 5, 5)
    depth = cases.depths()

    def run(name, **numbers):
        folder = WORK / "target" / f"five-{name}"
        return cases.at_depths(block(log, folder, numerics=ContactNumerics(finite_strain=False, **numbers), side_m=side)[-1], depth)

    try:
        mesh = [run(f"mesh{n}", elements_per_radius=n, load_steps=8) for n in (2.0, 2.6, 3.24)]
        steps = [run(f"steps{n}", elements_per_radius=2.6, load_steps=n) for n in (4, 8, 16)]
    except NotConverged as problem:
        rows.true("five impacts: solved on every mesh, with every step", False, problem.cause)
        return
    off = [cases.deviation(a, mesh[-1])[1] for a in mesh[:-1]]
    rows.true("five impacts: stress nearer with each mesh", off[1] < off[0], f"rms off the finest {off[0]:.1%}, {off[1]:.1%}")
    off = [cases.deviation(a, steps[-1])[1] for a in steps[:-1]]
    rows.true("five impacts: stress nearer with more steps", off[1] < off[0], f"rms off the most {off[0]:.1%}, {off[1]:.1%}")


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


def layers(rows: Rows) -> None:
    """The layer model against cells of materials, laws, speeds and exposures that it was not fitted to."""
    file = WORK / "layers_fit.json"
    if not file.exists():
        rows.true("layers against cells (make fit-layers has not been run)", False)
        return
    found = json.loads(file.read_text())["rows"]
    for label in ("held-out case", "held-out exposure"):
        here = [r for r in found if r["name"].startswith(f"{label}: ") and ", exposure " in r["name"]]
        worst = max(here, key=lambda r: r["value"])
        rows.below(f"layers against cell, {label}s, .17-1.3 radii deep: worst rms", worst["value"], 0.12,
                   f"{worst['name'].partition(': ')[2]}; {len(here)} profiles, rms of all {np.sqrt(np.mean([r['value'] ** 2 for r in here])):.1%}")  # fmt: skip
    slowest = max(r["value"] for r in found if r["name"].startswith("seconds of one evaluation"))
    rows.below("layers: one evaluation [s]", slowest, 0.01)


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
    with tempfile.TemporaryDirectory() as folder:
        import dimple_cases

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


def balance(rows: Rows) -> None:
    """Force and moment of plates let go: 10 mm, and Almen strips."""
    cell = cases.cell(WORK / "target" / "balance", 1, [1.0])[-1]
    for h in (10e-3, 2.39e-3, 1.29e-3, 0.79e-3):
        try:
            profile = part_profile(cell, h)
        except InputError as problem:
            rows.true(f"plate of {1e3 * h:g} mm: refused with the reason", "inside the peened layer" in str(problem))
            continue
        force, moment = plate_balance(profile["depth_m"], 0.5 * (profile["sigma_xx_Pa"] + profile["sigma_yy_Pa"]))
        arc = strip_arc_height_m(cell, h, cases.AL2024.E_Pa, cases.AL2024.nu)
        rows.below(f"plate of {1e3 * h:g} mm: |force| over max|s| h", abs(force), 1e-3)
        rows.below(f"plate of {1e3 * h:g} mm: |moment| over max|s| h2", abs(moment), 1e-3, f"arc height {1e6 * arc:.1f} um")


LAWS = {
    "isotropic, unbounded (Johnson-Cook)": cases.AL2024.johnson_cook,
    "isotropic, bounded (Voce, 369 to 569 MPa)": CombinedHardening(369e6, 200e6, 12.0, ()),
    "kinematic (R 270, X 210 MPa)": CombinedHardening(270e6, 0.0, 1.0, ((150e6, 300.0), (60e6, 12.0))),
    "combined (default)": cases.AL2024.combined,
}


def laws(rows: Rows) -> None:
    """Stress at .35 dimple radii against exposure: which laws level off."""
    exposures = [0.33, 1.2, 4.0, 8.0, 12.0, 20.0]
    levels = {}
    for name, law in LAWS.items():
        results = cases.cell(WORK / "target" / f"law-{len(levels)}", 1, exposures, law=law)
        stress = [float(cases.at_depths(r, np.array([80e-6]))[0]) / 1e6 for r in results]
        levels[name] = stress
        grown = stress[-1] / stress[2] - 1.0
        bounded = not isinstance(law, JohnsonCook)
        note = ", ".join(f"{s:.0f}" for s in stress) + f" MPa at 80 um, exposures {', '.join(f'{e:g}' for e in exposures)}"
        rows.true(f"{name}: {'levels off' if bounded else 'does not level off'}", (abs(grown) < 0.08) == bounded,
                  f"{grown:+.0%} from exposure 4 to 20; {note}")  # fmt: skip
    plateau = -np.mean(levels["combined (default)"][3:])
    combined = cases.AL2024.combined
    effective = (combined.R0_Pa + combined.Q_Pa + sum(x * g / (g + 190.0) for x, g in combined.backstresses)) / 1e6
    rows.within("combined: plateau at 80 um over R_eff", plateau / effective, 0.79, 0.05, f"{plateau:.0f} over {effective:.0f} MPa")
    band = -350.0 <= -plateau <= -270.0
    print(f"plausibility (grade C, no test): largest compressive of peened 2024 is -270 to -350 MPa; here {-plateau:.0f}"
          f" MPa at 80 um: {'inside' if band else 'outside'}")  # fmt: skip
    (WORK / "target_laws.json").write_text(json.dumps({"exposure": exposures, "stress_MPa": levels}, indent=1) + "\n")


# name: (case, minutes it takes on an idle machine of two cores)
CASES = {"single": (single, 2), "balance": (balance, 0.2), "laws": (laws, 5), "layers": (layers, 0.01), "overlap": (overlap, 20), "surface": (surface, 0.2),
         "saving": (saving, 0.1), "convergence": (convergence, 5), "many": (many, 6), "extremes": (extremes, 8)}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append", choices=CASES, metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--json", type=Path, default=WORK / "target.json", metavar="FILE")
    args = parser.parse_args()
    args.json.parent.mkdir(parents=True, exist_ok=True)
    (WORK / "target").mkdir(exist_ok=True)
    sys.argv[1:] = ["--json", str(args.json)]  # what Rows reads
    build_plugin()
    rows = Rows("target benchmark")
    names = args.only or list(CASES)
    begun, slower = time.monotonic(), 1.0
    for i, name in enumerate(names):
        left = slower * sum(CASES[n][1] for n in names[i:])
        print(f"--- {name} ({i + 1} of {len(names)}), about {left:.0f} min left", file=sys.stderr, flush=True)
        CASES[name][0](rows)
        slower = max(1.0, (time.monotonic() - begun) / 60 / sum(CASES[n][1] for n in names[: i + 1]))
    rows.finish()


if __name__ == "__main__":
    main()
