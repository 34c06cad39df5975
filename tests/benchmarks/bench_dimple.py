"""Dimple benchmark: the single impact against its finest mesh, CalculiX, extremes; PASS or FAIL rows (make bench-dimple).

    python tests/benchmarks/bench_dimple.py [--only NAME ...] [--json FILE]

Nothing comes from a cache; the limits were fixed before the runs.  Times are processor times of one-threaded processes
that run one after the other, which is the wall time on an idle machine; the wall time of this run stands beside.
The case `calculix` fails without CalculiX (apt-get install calculix-ccx).
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import calculix_impact
import dimple_cases as cases
import dimple_between
import dimple_library

from glue.checkrows import Rows
from glue.errors import InputError
from glue.scene.reader import example_path, read_scene
from glue.solvers import build_plugin, repo_root

WORK = repo_root() / "build" / "bench"
# Printed beside the series over meshes: changes below it say nothing.
STEP = "half the time step moves the radius by .08 %: smaller changes are not the mesh's"
STRESS_DISC = 0.44  # layer stresses are means over this part of the dimple radius


@cache
def reference(elements: int, steps: float = 90.0, newton: float = 1e-5) -> cases.Solved:
    """The reference impact at a/elements, solved once a benchmark."""
    return cases.solve(elements, steps_per_contact=steps, newton=newton)


def reference_impact(rows: Rows) -> None:
    """Balanced and fast against the finest mesh, and how long they take."""
    fine = reference(24).values()
    for preset, elements, limit_s, share in (("balanced", 6, 5.0, 0.01), ("fast", 3, 1.5, 0.04)):
        runs = [cases.solve(elements), cases.solve(elements), reference(elements)]
        rows.below(f"{preset} (a/{elements}): time [s]", statistics.median(g.processor_s for g in runs), limit_s,
                   f"median of {', '.join(f'{g.processor_s:.2f}' for g in runs)}; wall"
                   f" {statistics.median(g.wall_s for g in runs):.2f} s; {runs[0].impact.dofs} dofs")  # fmt: skip
        for name, value in reference(elements).values().items():
            if name == "e":
                band = 0.005 if preset == "balanced" else share * fine["e"]
                rows.within(f"{preset}: e against a/24", value, fine["e"], band)
            else:
                rows.near(f"{preset}: {name} against a/24", value, fine[name], share)
        rows.below(f"{preset}: energy balance at every step", reference(elements).impact.energy_error, 0.005)


def convergence(rows: Rows) -> None:
    """Meshes each twice as fine, with half the time step and a tight balance: what is left is the mesh's."""
    meshes = (3, 6, 12, 24)
    got = [reference(n, 180.0, 1e-7) for n in meshes]
    rows.true("a/24 finishes", got[-1].impact.restitution > 0,
              f"{got[-1].processor_s:.1f} s, {got[-1].impact.dofs} dofs; a/3, a/6, a/12: "
              + ", ".join(f"{g.processor_s:.1f}" for g in got[:-1]) + " s")  # fmt: skip
    for name in got[0].values():
        series = [g.values()[name] for g in got]
        steps = np.diff(series)
        rows.true(f"{name}: monotone over a/3, a/6, a/12, a/24", bool((steps > 0).all() or (steps < 0).all()),
                  f"{', '.join(f'{v:.5g}' for v in series)}; observed order {cases.order(series[:3]):.2f},"
                  f" {cases.order(series):.2f}; changes {', '.join(f'{abs(v / series[-1]):.2%}' for v in steps)}; {STEP}")  # fmt: skip
    for factor in (5.0, 80.0):
        other, base = cases.solve(12, penalty=factor).values(), reference(12).values()
        rows.below(f"contact of {factor:g} E/h instead of 20, a/12: change of e", abs(other["e"] - base["e"]), 0.005,
                   ", ".join(f"{name} {other[name] / base[name] - 1:+.2%}" for name in ("depth", "radius", "peak force")))


def calculix(rows: Rows) -> None:
    """An independent code at the penetration that the finest impact reached."""
    if calculix_impact.find() is None:
        rows.true("CalculiX is installed", False, "apt-get install calculix-ccx")
        return
    ours = {n: reference(n) for n in (3, 6, 12, 24)}
    fine = ours[24]
    radius_mm = fine.values()["radius"] * cases.R_MM
    table = cases.hardening_table(cases.AL2024.johnson_cook)
    theirs = {}
    with tempfile.TemporaryDirectory(prefix="peen-ccx-") as scratch:
        for n in (6, 12, 24):
            say(f"CalculiX at a/{n}")
            theirs[n] = calculix_impact.solve(
                Path(scratch) / str(n), 0.23 / n, E=73100.0, nu=0.33, table=table, R=cases.R_MM,
                penetration=fine.penetration * cases.R_MM, core=1.3 * 0.23, size=10 * cases.R_MM,
            )  # fmt: skip
    them = theirs[24]
    values = {"depth": (fine.values()["depth"] * cases.R_MM, "depth_mm"), "radius": (radius_mm, "radius_mm"),
              "peak force": (fine.values()["peak force"] * cases.R_MM**2, "peak_force_N")}  # fmt: skip
    coarser = {name: [getattr(theirs[n], attribute) for n in (6, 12)] for name, (_, attribute) in values.items()}
    for name, limit in (("radius", 0.015), ("peak force", 0.015), ("depth", 0.02)):
        value, attribute = values[name]
        rows.near(f"CalculiX a/24, same penetration: {name} [mm, N]", value, getattr(them, attribute), limit,
                  f"CalculiX at a/6, a/12: {', '.join(f'{v:.5g}' for v in coarser[name])}")  # fmt: skip
    layers(rows, ours, theirs, radius_mm)
    cost(rows, ours, theirs, values)


def layers(rows: Rows, ours: dict, theirs: dict, radius_mm: float) -> None:
    """Residual stress over depth of both codes, over a ring: CalculiX's first two elements at the axis are left out."""
    inner, outer = 2 * theirs[6].h_mm, 1.2 * radius_mm * STRESS_DISC + theirs[6].h_mm
    depths = np.linspace(0.1, 4.0, 160) * radius_mm

    def mine(n):
        p = ours[n].impact.points
        return cases.layer_means(p["r"] * cases.R_MM, p["z"] * cases.R_MM, p["s_rr"], depths, inner, outer)

    their = {n: cases.layer_means(t.r_mm, t.z_mm, t.s_rr_MPa, depths, inner, outer) for n, t in theirs.items()}
    my = {n: mine(n) for n in (6, 12, 24)}
    rows.near("CalculiX: depth where the stress turns tensile [mm]", cases.sign_change(depths, my[24]),
              cases.sign_change(depths, their[24]), 0.07)  # fmt: skip
    rows.near("CalculiX: largest compressive stress [MPa]", my[24].min(), their[24].min(), 0.05,
              f"at {depths[my[24].argmin()] * 1e3:.0f} and {depths[their[24].argmin()] * 1e3:.0f} um; a/6, a/12, a/24: "
              + ", ".join(f"{s.min():.0f}" for s in my.values()) + "; CalculiX a/6, a/12, a/24: "
              + ", ".join(f"{s.min():.0f}" for s in their.values())
              + ": CalculiX's linear elements still come down with the mesh, FreeFEM's no longer move")  # fmt: skip
    off = np.sqrt(np.mean((my[24] - their[24]) ** 2)) / abs(their[24]).max()
    rows.below("CalculiX: stress over depth, rms difference over largest", off, 0.05,
               f"ring {inner * 1e3:.0f}-{outer * 1e3:.0f} um, depths {depths[0] * 1e3:.0f}-{depths[-1] * 1e3:.0f} um")  # fmt: skip


def cost(rows: Rows, ours: dict, theirs: dict, values: dict) -> None:
    """Time at equal error (worst of depth, radius, force), each code against its own finest mesh, then crosswise."""

    def my_errors(n, aim):
        scale = {"depth": cases.R_MM, "radius": cases.R_MM, "peak force": cases.R_MM**2}
        return max(abs(ours[n].values()[name] * scale[name] / aim[name] - 1) for name in scale)

    def their_errors(n, aim):
        return max(abs(getattr(theirs[n], attribute) / aim[name] - 1) for name, (_, attribute) in values.items())

    my_finest = {name: value for name, (value, _) in values.items()}
    their_finest = {name: getattr(theirs[24], attribute) for name, (_, attribute) in values.items()}
    for label, my_aim, their_aim in (("own finest", my_finest, their_finest), ("FreeFEM's finest", my_finest, my_finest),
                                     ("CalculiX's finest", their_finest, their_finest)):  # fmt: skip
        ratios, notes = [], []
        for n in (6, 12):
            error = their_errors(n, their_aim)
            enough = [m for m in (3, 6, 12) if my_errors(m, my_aim) <= error]
            notes.append(f"CalculiX a/{n} {error:.2%} in {theirs[n].processor_s:.0f} s")
            if enough:
                ratios.append(theirs[n].processor_s / min(ours[m].processor_s for m in enough))
        notes += [f"FreeFEM a/{m} {my_errors(m, my_aim):.2%} in {ours[m].processor_s:.1f} s" for m in (3, 6, 12)]
        rows.below(f"time over CalculiX's at equal error, {label}", 1 / min(ratios) if len(ratios) == 2 else np.inf, 0.2,
                   "; ".join(notes))  # fmt: skip


def extremes(rows: Rows) -> None:
    """From the hardly yielding to the absurd: everything ends, or says why there is no dimple."""
    found: dict[str, list[dict]] = {}
    for k, got in enumerate(cases.extremes()):
        found.setdefault(got["target"], []).append(got)
        say(f"extremes {k + 1} of {len(cases.EXTREME_TARGETS) * len(cases.EXTREME_SPEEDS)}")
    for name, runs in found.items():
        failed = [f"{r['speed']:g} m/s: {r['failed']}" for r in runs if "failed" in r]
        refused = [r for r in runs if "refused" in r]
        rows.true(f"{name}: all end or are refused with the reason",
                  not failed and all(r["peeq"] == 0 and "yield speed" in r["refused"] for r in refused),
                  "; ".join(failed) or "; ".join(f"{r['speed']:g} m/s refused: {r['refused'][:80]}" for r in refused))
        runs = [r for r in runs if "failed" not in r]
        if not runs:
            continue
        dents = [r for r in runs if "radius" in r]
        rows.below(f"{name}: worst energy balance", max(r["energy"] for r in runs), 0.005)
        rows.true(f"{name}: e falls with speed", bool((np.diff([r["e"] for r in runs]) < 0).all()),
                  ", ".join(f"{r['e']:.3f}" for r in runs))
        rows.true(f"{name}: radius grows with speed", bool((np.diff([r["radius"] for r in dents]) > 0).all()),
                  ", ".join(f"{r['radius']:.4f}" for r in dents) + " R")
        v, a = (np.log([r[k] for r in dents]) for k in ("speed", "radius"))
        local = np.diff(a) / np.diff(v)
        note = "between the speeds " + ", ".join(f"{x:.3f}" for x in local)
        inside = (v > np.log(19)) & (v < np.log(101))
        exponent = float(np.polyfit(v[inside], a[inside], 1)[0])
        if cases.EXTREME_TARGETS[name][1].B_Pa > 0:
            rows.within(f"{name}: radius ~ speed^n, 20-100 m/s: n", exponent, 0.46, 0.04, note)
        else:
            rows.true(f"{name}: radius ~ speed^{exponent:.3f}, no hardening, no limit", exponent > 0, note)


def poisson(rows: Rows) -> None:
    """Towards the incompressible: surface stress and pressure converge, and beyond .49 the scene refuses."""
    meshes, ratios = (3, 6, 12), (0.30, 0.45, 0.49)
    got = cases.all_poisson(ratios, meshes)
    for nu in ratios:
        runs = [got[nu, n].impact for n in meshes]
        radius = got[nu, 12].values()["radius"]
        for share in (0.1, 0.2):
            near = [float(cases.layer_means(i.points["r"], i.points["z"], i.points["s_rr"], [share * radius], 0.0,
                                            STRESS_DISC * radius)[0]) for i in runs]  # fmt: skip
            rows.below(f"nu {nu:.2f}: stress {share:g} radii deep, a/6 to a/12 [MPa]", abs(near[2] - near[1]), 18.0,
                       f"5 % of the yield stress; {', '.join(f'{s:.0f}' for s in near)} at a/3, a/6, a/12")  # fmt: skip
        changes = [cases.field_difference(a, b, 1.2 * radius) for a, b in pairwise(runs)]
        rows.below(f"nu {nu:.2f}: mean stress of the elements, a/6 to a/12", changes[1], 0.6 * changes[0],
                   f"rms {changes[1]:.1%} after {changes[0]:.1%} from a/3 to a/6")  # fmt: skip
        rows.near(f"nu {nu:.2f}: depth at a/3 against a/12 (locking?)", got[nu, 3].values()["depth"],
                  got[nu, 12].values()["depth"], 0.01)  # fmt: skip
    rows.true("nu .495 is refused by the scene", _refused(0.495), "allowed 0 to .49")
    rows.true("nu .49 is taken by the scene", not _refused(0.49))


def _refused(nu: float) -> bool:
    """Whether the default scene, its target written out with ``nu``, is refused for it."""
    text = example_path("al2024-s390").read_text()
    head, _, tail = text.partition('material = "al2024-t351"')
    rest = tail.partition("\n")[2]
    own = ("material = { E_Pa = 73.1e9, nu = %g, density_kg_m3 = 2780.0, "
           "johnson_cook = { A_Pa = 369e6, B_Pa = 684e6, n = 0.73 } }\n")  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(head + own % nu + rest)
        try:
            read_scene(path)
        except InputError as problem:
            if "nu" in str(problem) and "0.49" in str(problem):
                return True
            raise
    return False


def scaling(rows: Rows) -> None:
    """A rate-free dimple in units of its shot does not know the shot's size."""
    with tempfile.TemporaryDirectory() as folder:
        small, large = (cases.scaled(Path(folder) / str(d), d) for d in (0.05e-3, 5e-3))
    off = np.max(abs(small - large) / np.maximum(abs(large), 1e-9 * abs(large).max()))
    rows.below(".05 and 5 mm shots: radius, depth, e, force, time, profile, stress", float(off), 1e-6,
               f"largest relative difference of {len(small)} numbers, each size solved anew")  # fmt: skip


# name: (case, seconds it takes on an idle machine of two cores)
CASES = {
    "reference": (reference_impact, 50),
    "convergence": (convergence, 100),
    "calculix": (calculix, 150),
    "extremes": (extremes, 50),
    "poisson": (poisson, 30),
    "scaling": (scaling, 5),
    "library": (dimple_library.rows, 70),
    "between": (dimple_between.rows, 60),
}


def say(text: str) -> None:
    """One line of progress, on a terminal only: it is written over."""
    if sys.stderr.isatty():
        print(f"\r{text:<78}", end="", file=sys.stderr, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append", choices=CASES, metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--json", type=Path, default=WORK / "dimple.json", metavar="FILE")
    args = parser.parse_args()
    args.json.parent.mkdir(parents=True, exist_ok=True)
    sys.argv[1:] = ["--json", str(args.json)]  # what Rows reads
    build_plugin()
    rows = Rows("dimple benchmark")
    names = args.only or list(CASES)
    begun, slower = time.monotonic(), 1.0
    for i, name in enumerate(names):
        left = slower * sum(CASES[n][1] for n in names[i:])
        print(f"--- {name} ({i + 1} of {len(names)}), about {left / 60:.1f} min left", file=sys.stderr, flush=True)
        CASES[name][0](rows)
        slower = (time.monotonic() - begun) / sum(CASES[n][1] for n in names[: i + 1])
    say("")
    rows.finish()


if __name__ == "__main__":
    main()
