"""Contact-aware stepping against plain stepping on the same arrivals: the same impacts, for how much less?

The reference scene: 1 mm steel, 60 m/s, 5 kg/min, 20 mm jet, 100 mm stand-off, e .6.  Both make the same steps
in contact; plain stepping makes all others too, at its best settings (a question for contacts every .6 of the
shortest one, the collider's best sweep).  Rounding differs, each collision magnifies that a hundred times, so
single shots part after some collisions; until then they must agree, and their statistics after.

    yade -n -x yade_scripts/checks/stepping.py [--json FILE] [--seeds 1-10] [--exposure S] [--runs FILE]

``--runs`` writes the numbers of every seed as JSON.  The exit code tells, as of all checks.
"""

import argparse
import json
import statistics
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import Rows

import numpy as np

import shot_flow
from glue.flow.arrivals import read_arrivals
from glue.flow.impacts import read_impacts, stream_numbers

SCENE = """
schema = 1
name = "stepping"
seed = {seed}
exposure_time_s = {exposure}
[shots]
grade = "S390"
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = 0.083333
jet_diameter_m = 0.020
stand_off_m = 0.1
impact_angle_deg = 90.0
[target]
material = "al2024-t351"
window_m = [0.004, 0.004]
"""
FIRST_S = 0.02  # until here at least SAME of the shots must have met others as often in both runs
SAME = 0.9


def simulate(folder: Path, *options: str):
    """Run the case; returns (report, impacts)."""
    report = {}
    args = [str(folder / "scene.toml"), str(folder), "--restitution", "0.6", *options]
    shot_flow.run(shot_flow.parse(args), report)
    return report, read_impacts(folder / "impacts.csv")[0]


def collisions_by_shot(impacts) -> dict[int, list[int]]:
    """For every shot that struck in the first ``FIRST_S``: its collisions before each impact."""
    met: dict[int, list[int]] = {}
    for row in impacts[impacts["time_s"] < FIRST_S]:
        met.setdefault(int(row["shot_id"]), []).append(int(row["collisions_before"]))
    return met


def compare(seed: int, exposure_s: float) -> dict:
    """Both ways of stepping on the arrivals of one seed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "scene.toml").write_text(SCENE.format(seed=seed, exposure=exposure_s))
        leaps, hits = simulate(folder)
        arrivals = folder / "arrivals.csv"
        plain, plain_hits = simulate(folder, "--plain", "--arrivals", str(arrivals))
        came = read_arrivals(arrivals)[0]
    hits = hits[hits["time_s"] < plain["simulated_s"]]  # plain stepping waits less long for stragglers
    free = hits[hits["collisions_before"] == 0]
    born = came[np.searchsorted(came["shot_id"], free["shot_id"])]
    twin = plain_hits[plain_hits["collisions_before"] == 0]
    _, i, j = np.intersect1d(
        free["shot_id"][np.unique(free["shot_id"], return_index=True)[1]],
        twin["shot_id"][np.unique(twin["shot_id"], return_index=True)[1]],
        return_indices=True,
    )
    a = free[np.unique(free["shot_id"], return_index=True)[1]][i]
    b = twin[np.unique(twin["shot_id"], return_index=True)[1]][j]
    met, plain_met = collisions_by_shot(hits), collisions_by_shot(plain_hits)
    shots = met.keys() | plain_met.keys()
    ours, theirs = stream_numbers(hits, [60.0]), stream_numbers(plain_hits, [60.0])
    return {
        "seed": seed,
        "shots": len(came),
        "uncollided": len(a),
        "uncollided_place_off_m": float(np.hypot(a["x_m"] - b["x_m"], a["y_m"] - b["y_m"]).max()),
        "uncollided_speed_exact": all(
            (a[f"v{c}_in_m_s"] == b[f"v{c}_in_m_s"]).all()
            and (free[f"v{c}_in_m_s"] == born[f"v{c}_m_s"]).all()
            for c in "xyz"
        ),
        "same_collisions": sum(met.get(s) == plain_met.get(s) for s in shots) / len(shots),
        "collided_fraction": [ours["collided_fraction"], theirs["collided_fraction"]],
        "mean_normal_energy_fraction": [
            ours["mean_normal_energy_fraction"],
            theirs["mean_normal_energy_fraction"],
        ],
        "impacts": [len(hits), len(plain_hits)],
        "executed_steps": [leaps["executed_steps"], plain["executed_steps"]],
        "wall_s": [leaps["stepping_wall_s"], plain["stepping_wall_s"]],
        "cpu_s": [leaps["stepping_cpu_s"], plain["stepping_cpu_s"]],
        "grazes_between_questions": plain["grazes_between_questions"],
    }


def off(runs: list[dict], name: str) -> float:
    """Difference of the means over all seeds, ours less plain."""
    return statistics.fmean(r[name][0] for r in runs) - statistics.fmean(r[name][1] for r in runs)


def seeds_of(text: str) -> range:
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


parser = argparse.ArgumentParser(add_help=False)
parser.add_argument("--seeds", type=seeds_of, default=range(1, 4))
parser.add_argument("--exposure", type=float, default=FIRST_S)
parser.add_argument("--runs", type=Path)
options, sys.argv[1:] = parser.parse_known_args(sys.argv[1:])

rows = Rows(f"contact-aware against plain stepping, 5 kg/min, {options.exposure:g} s")
runs = [compare(seed, options.exposure) for seed in options.seeds]
if options.runs:
    options.runs.write_text(json.dumps(runs, indent=1) + "\n")
for run in runs:
    seed = f"seed {run['seed']}"
    rows.below(
        f"{seed}: uncollided shots, place off [m]",
        run["uncollided_place_off_m"],
        1e-6,
        f"{run['uncollided']}",
    )
    rows.true(f"{seed}: uncollided shots, velocity exact", run["uncollided_speed_exact"])
    rows.below(f"{seed}: shots with other collisions, first 20 ms", 1.0 - run["same_collisions"], 1.0 - SAME)
count = sum(r["shots"] for r in runs)
rows.within("collided share, off plain", off(runs, "collided_fraction"), 0.0, 0.01, f"{count} shots")
rows.within("mean normal energy, off plain", off(runs, "mean_normal_energy_fraction"), 0.0, 0.015)
for kind in ("wall", "cpu"):
    ours, plain = (sum(r[f"{kind}_s"][k] for r in runs) for k in (0, 1))
    rows.below(
        f"{kind} time over that of plain stepping", ours / plain, 1.0 / 6.0, f"{plain / ours:.1f} x less"
    )
rows.finish()
