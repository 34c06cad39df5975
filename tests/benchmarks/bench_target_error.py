"""Is the promised error kept on scenes that are not in the measured table?  PASS or FAIL rows (make bench-target-error).

    python tests/benchmarks/bench_target_error.py [--only NAME ...] [--error 5%] [--json FILE]

Each scene is run as ``peen run --target-error`` would choose it, and once more with the ladder's whole reference (another mesh,
step, raster, contact flow), same seed, exposure shortened to 1.5 hits per point.  A row is the largest error of the headline
quantities that both runs tell; the limit is the promise.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from glue.checkrows import Rows
from glue.errors import PeenError
from glue.scene.derive import changed
from glue.scene.reader import example_path, read_scene
from glue.solvers import repo_root
from glue.study import pipeline
from glue.study.check import mean_hits_estimate
from glue.study.rundir import METRICS
from glue.study.tradeoff.choose import choose, sentence
from glue.study.tradeoff.jobs import shorter
from glue.study.tradeoff.ladder import STAGES, WHOLE
from glue.study.tradeoff.quantities import QUANTITIES, scales, values
from glue.study.tradeoff.wishes import parse_error

# None in ladder.BUILT_IN.  glass-drag too would be one: its reference, .1 mm beads in YADE with drag, takes half an hour.
SCENES = ("al2024-s390-45deg", "cylinder-s230", "own-material", "two-nozzles-pulsed")
HITS = 1.5


def measured(name: str, what: str, content: bytes, out: Path, stages) -> dict:
    def tell(stage, fraction, text):
        if fraction in (0.0, 1.0):
            print(f"{name}, {what}: {stage} {text}", file=sys.stderr, flush=True)

    path = pipeline.run(str(example_path(name)), out / f"{name}-{what}", only=stages, content=content, progress=tell)
    return json.loads((path / METRICS).read_text())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=SCENES)
    parser.add_argument("--error", default="15%")
    parser.add_argument("--without", nargs="+", default=[], metavar="STAGE", help="leave out dear stages")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    sys.argv[1:] = ["--json", str(given.json)] if given.json else []
    promise, out = parse_error(given.error), repo_root() / "build" / "bench" / "target-error"
    stages = [s for s in STAGES if s not in given.without]
    rows = Rows(f"error promised, {given.error}, and kept")
    for name in given.only:
        content = example_path(name).read_bytes()
        share = min(1.0, HITS / mean_hits_estimate(read_scene(example_path(name))))
        content = changed(content, {"models": {}, "accuracy": {}} | shorter(content, share))
        try:
            best = choose(read_scene(example_path(name), content=content), target_error=promise, stages=stages)
            found = measured(name, f"chosen-{promise:g}-{len(stages)}", changed(content, best.changes), out, stages)
            right = measured(name, "reference", changed(content, WHOLE.reference), out, stages)
        except PeenError as problem:
            rows.true(f"{name}: runs", False, str(problem).splitlines()[0])
            continue
        own, true, scale = values(found), values(right), scales(right)
        errors = {q.name: abs(own[q.name] - true[q.name]) / scale[q.name] for q in QUANTITIES if q.headline and q.name in own and q.name in scale}
        worst = max(errors, key=errors.get)
        told = ", ".join(f"{n} {100 * e:.2g} %" for n, e in errors.items())
        rows.below(f"{name}: largest error, of {worst}", errors[worst], promise, f"{told}; promised {100 * best.worst[1]:.2g} %: {sentence(best)}")
    rows.finish()


if __name__ == "__main__":
    main()
