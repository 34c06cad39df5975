"""The shipped study of 200 runs: its time, a kill in the middle, no run computed twice, the same table from Snakemake.

    python tests/benchmarks/bench_sweep.py [--json FILE] [--runs N] [--jobs N]

The study starts with an empty cache: the dimples and the compiled event loop are part of the time.  When half of the runs are done
its process group is killed (SIGKILL) and the same command goes on.  The journal then tells which stages started how often:
only those that the kill caught may have started twice, and none may have ended twice.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import csv
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from glue.checkrows import Rows
from glue.solvers import repo_root, run_module
from glue.study.sweep.records import JOURNAL

STUDY, MINUTES, RUNS = "coverage-lhs", 10.0, 200
PLACE = repo_root() / "build" / "sweep"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], add_help=False)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--snakemake-runs", type=int, metavar="N", help="only the first N through Snakemake, which starts a process a stage")
    args, rest = parser.parse_known_args()
    sys.argv[1:] = rest
    rows = Rows(f"{args.runs} runs of {STUDY}, {args.jobs} at a time")
    shutil.rmtree(PLACE, ignore_errors=True)
    os.environ["PEEN_CACHE"] = str(PLACE / "cache")
    options = ["--runs", str(args.runs), "--jobs", str(args.jobs)]
    out = PLACE / "local"
    begun = time.monotonic()
    killed_after = _killed_in_the_middle(out, options, args.runs // 2)
    rows.true("killed when half of the runs were done", killed_after > 0, f"{killed_after} done by then")
    known, restart = len(_journal(out)), time.time()
    ended = run_module("glue", ["sweep", STUDY, "--out", out, *options], log=PLACE / "again.log")
    took = time.monotonic() - begun
    later = _journal(out)[known:]
    rows.below("goes on after [s]", (float(later[0][0]) if later else time.time()) - restart, 60.0, "until its first stage starts")
    rows.true("the study ends well", ended.exit_code == 0, f"exit code {ended.exit_code}")
    done = sum(row["state"] == "done" for row in _rows(out / "table.csv"))
    rows.true("every run is done", done == args.runs, f"{done} of {args.runs}")
    rows.below("wall time of both together [s]", took, 60.0 * MINUTES, "dimples and compiling included")
    starts, ends = _counted(out)
    rows.below("stages of a run that ended twice", sum(n > 1 for n in ends.values()), 0)
    twice = sum(n - 1 for n in starts.values())
    rows.below("stages started twice: those that the kill caught", twice, args.jobs)
    costs = [float(row["cpu_s"]) for row in _rows(out / "costs.csv") if row["cpu_s"]]
    rows.below("processor time of a run, mean [s]", sum(costs) / max(len(costs), 1), 5.0)
    by_snakemake, local, few = PLACE / "snakemake", out, args.snakemake_runs or args.runs
    options = ["--runs", str(few), "--jobs", str(args.jobs)]
    if few < args.runs:
        local = PLACE / "local-few"
        run_module("glue", ["sweep", STUDY, "--out", local, *options], log=PLACE / "few.log")
    ended = run_module("glue", ["sweep", STUDY, "--out", by_snakemake, "--executor", "snakemake", *options], log=PLACE / "snakemake.log")
    same = (by_snakemake / "table.csv").is_file() and (by_snakemake / "table.csv").read_bytes() == (local / "table.csv").read_bytes()
    done = sum(row["state"] == "done" for row in _rows(by_snakemake / "table.csv"))
    rows.true(f"Snakemake's table is the same, {few} runs", same and done == few, f"{done} done, {ended.wall_s:.0f} s wall, exit code {ended.exit_code}")
    rows.finish()


def _killed_in_the_middle(out: Path, options: list[str], enough: int) -> int:
    """Start the study and kill its process group when ``enough`` runs are done; how many were.

    The workers are in groups of their own: the kernel kills them with the command that started them.
    """
    argv = [sys.executable, "-m", "glue", "sweep", STUDY, "--out", str(out), *options]
    PLACE.mkdir(parents=True)
    with open(PLACE / "killed.log", "wb") as log:
        child = subprocess.Popen(argv, stdout=log, stderr=log, stdin=subprocess.DEVNULL, start_new_session=True)
        while child.poll() is None and _runs_done(out) < enough:
            time.sleep(0.2)
        if child.poll() is not None:  # it ended before it could be killed
            return 0
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
    time.sleep(1.0)  # until the last worker is gone
    return _runs_done(out)


def _runs_done(out: Path) -> int:
    return sum(stage == "uncertainty" and event == "done" for _, _, stage, event in _journal(out))


def _journal(out: Path) -> list[list[str]]:
    with contextlib.suppress(FileNotFoundError):
        return [line.split(",") for line in (out / JOURNAL).read_text().splitlines() if line.count(",") == 3]
    return []


def _counted(out: Path) -> tuple[collections.Counter, collections.Counter]:
    """How often each (run, stage) started and ended."""
    starts, ends = collections.Counter(), collections.Counter()
    for _, run, stage, event in _journal(out):
        if event in ("starts", "goes on"):
            starts[run, stage] += 1
        elif event == "done":
            ends[run, stage] += 1
    return starts, ends


def _rows(file: Path) -> list[dict]:
    with contextlib.suppress(FileNotFoundError), open(file, newline="") as f:
        return list(csv.DictReader(f))
    return []


if __name__ == "__main__":
    main()
