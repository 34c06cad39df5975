"""Do the stated intervals hold?  Fresh seeds against the mean of others at finer numbers; PASS or FAIL rows (make bench-uncertainty).

    python tests/benchmarks/bench_uncertainty.py [--scene NAME] [--seeds N] [--json FILE]

Each of N runs states its own 95 % interval from its own log and surface (statistical and numerical causes only: law and
restitution are the same in both).  The reference is the mean of as many runs with other seeds, a finer mesh, raster and stamp.
Neither set of seeds went into the measured table.  The share of intervals that hold the reference must lie in 85-100 %, which
was fixed before the runs: of 40 true 95 % intervals, 35 and more hold in 98 % of all cases.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path

import numpy as np

from glue.checkrows import Rows
from glue.scene.derive import changed
from glue.scene.reader import example_path
from glue.solvers import repo_root
from glue.study import pipeline
from glue.study.rundir import METRICS

CHEAP = {"models": {}, "models.target": "layers", "models.flow": "event", "accuracy": {}, "accuracy.preset": "fast"}
FINER = {"accuracy.dimple_elements_per_radius": 6, "accuracy.coverage_points_per_radius": 40.0, "accuracy.stamp_points_per_radius": 24.0}
STATED, REFERENCE = 60_000, 90_000  # the measured table has seeds 1-8 and 1001-1008
JUDGED = (
    "flow.mean_normal_energy_fraction", "flow.collided_fraction", "coverage.final", "coverage.time_98_s",
    "coverage.avrami_final", "coverage.avrami_time_98_s", "coverage.impacts_in_window", "residual_stress.max_compressive_Pa",
    "roughness.Sa_m", "roughness.Sq_m", "roughness.Sz_m",
)  # fmt: skip
STAGES = ("dimple", "flow", "coverage", "target", "surface", "uncertainty")


def runs(scene: str, first: int, count: int, changes: dict, out: Path) -> list[dict]:
    """metrics.json of ``count`` seeds from ``first``; those done before are read."""
    content, found = example_path(scene).read_bytes(), []
    for seed in range(first, first + count):
        path = pipeline.run(
            scene, out / f"{scene}-{seed}", only=STAGES, content=changed(content, CHEAP | changes | {"seed": seed})
        )
        found.append(json.loads((path / METRICS).read_text()))
        print(f"{scene}, seed {seed}: {len(found)} of {count}", file=sys.stderr, flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="al2024-s390")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    sys.argv[1:] = ["--json", str(given.json)] if given.json else []
    rows = Rows(f"stated 95 % intervals on {given.seeds} fresh seeds of {given.scene}")
    out = repo_root() / "build" / "bench" / "uncertainty"
    stated = runs(given.scene, STATED, given.seeds, {}, out)
    right = runs(given.scene, REFERENCE, given.seeds, FINER, out)
    for name in JUDGED:
        section, key = name.split(".")
        truth = [m[section][key] for m in right if m[section][key] is not None]
        told = [m["uncertainty"][name] for m in stated if name in m["uncertainty"]]
        if len(truth) < given.seeds or len(told) < given.seeds:
            rows.true(f"{name}: every run states it", False, f"{len(told)} of {given.seeds} stated, {len(truth)} references")
            continue
        mean = float(np.mean(truth))
        halves = [math.hypot(t["by_cause"]["statistical"] or 0.0, t["by_cause"]["numerical"] or 0.0) for t in told]
        held = float(np.mean([abs(t["value"] - mean) <= half for t, half in zip(told, halves, strict=True)]))
        scatter = float(np.std([t["value"] for t in told], ddof=1))
        note = f"mean half width {np.mean(halves):.3g}, 1.96 sd of the seeds {1.96 * scatter:.3g}, reference {mean:.5g}"
        rows.within(f"{name}: share of intervals that hold", held, 0.925, 0.075 + 1e-9, note)
    rows.finish()


if __name__ == "__main__":
    main()
