"""What presets fast and balanced take on the built-in scenes: dimples in the cache, no figures.  PASS or FAIL rows (make bench-presets).

    python tests/benchmarks/bench_presets.py [--only SCENE ...] [--json FILE]

Each scene as it stands (a flow model that it asks for included) and, beside it, with its models left to "auto".  The dimple is
solved first, untimed, and numba's compiling done; the time is that of a new process from its start to metrics.json.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

from glue.checkrows import Rows
from glue.scene.derive import changed
from glue.scene.reader import example_path
from glue.solvers import repo_root, run_module
from glue.study import pipeline
from glue.study.manifest import read_manifest
from glue.study.tradeoff.ladder import BUILT_IN, STAGES

LIMITS_S = {"fast": 5.0, "balanced": 90.0}
STAGES_RUN = (*STAGES, "uncertainty")


def main() -> None:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", nargs="+", default=BUILT_IN, choices=BUILT_IN)
    args, rest = parser.parse_known_args()
    sys.argv[1:] = rest
    rows = Rows("presets: seconds a scene, warm dimples, no figures")
    warm_already = False
    for name in args.only:
        for preset, limit in LIMITS_S.items():
            content = example_path(name).read_bytes()
            for label, scene in (("models auto", changed(content, {"models": {}})), ("as it stands", content)):
                wall, told = measured(name, preset, label, scene, warm_already)
                warm_already = True
                rows.below(f"{name}, {preset}, {label} [s]", wall, limit, told)
    rows.finish()


def measured(name: str, preset: str, label: str, content: bytes, warm_already: bool) -> tuple[float, str]:
    """(wall time [s] of the run, what its stages took)."""
    out = repo_root() / "build" / "bench" / "presets" / f"{name}-{preset}-{label.replace(' ', '-')}"
    shutil.rmtree(out, ignore_errors=True)
    scene = out.with_suffix(".toml")
    scene.parent.mkdir(parents=True, exist_ok=True)
    scene.write_bytes(content)
    pipeline.run(str(scene), out.with_name(out.name + "-warm"), preset=preset, only=["dimple"] if warm_already else ["coverage", "surface"])
    begun = time.monotonic()
    done = run_module("glue", ["run", scene, "--out", out, "--accuracy", preset, "--only", *STAGES_RUN], log=out.with_suffix(".log"))
    wall = time.monotonic() - begun
    if done.exit_code != 0:
        return float("nan"), f"exit code {done.exit_code}; log {Path(done.log).name}"
    stages, flow = read_manifest(out)["stages"], json.loads((out / "metrics.json").read_text())["flow"]["model"]
    return wall, f"flow {flow}; " + ", ".join(f"{stage} {stages[stage]['wall_s']:.1f}" for stage in STAGES_RUN)


if __name__ == "__main__":
    main()
