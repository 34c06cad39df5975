"""A study through Snakemake (the optional extra ``cluster``): on this machine, or by a profile on a cluster."""

from __future__ import annotations

import importlib.util
import re
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from glue import stopping
from glue.errors import InputError, SolverFailed
from glue.solvers import run_module
from glue.solvers.process import tail
from glue.study.sweep.plan import Run
from glue.study.sweep.records import BUSY, DONE, failure_file, record_failure

SNAKEFILE = Path(__file__).resolve().parent / "Snakefile"
_CANCEL_S = 30.0  # to call off the jobs of a cluster
_STEPS = re.compile(r"(\d+) of (\d+) steps")


def refuse_snakemake(profile: Path | None) -> None:
    """Raise InputError when Snakemake is not installed or the profile is none."""
    problems = []
    if importlib.util.find_spec("snakemake") is None:
        problems.append("--executor snakemake: Snakemake is not installed; allowed: after .venv/bin/pip install -e '.[cluster]'")
    if profile is not None and not any((profile / name).is_file() for name in ("config.yaml", "config.v8+.yaml")):
        shipped = SNAKEFILE.parent / "profiles" / "slurm"
        problems.append(f"--profile {profile}: holds no config.yaml; allowed: a folder of Snakemake's settings, such as {shipped}")
    if problems:
        raise InputError(problems)


def run_snakemake(
    out: Path,
    runs: Sequence[Run],
    last_stage: str,
    jobs: int | None,
    profile: Path | None,
    tell: Callable[[float, str], None],
) -> None:
    """Do the runs of plan.json in ``out`` up to ``last_stage``; failures are recorded, not raised.

    ``jobs``: cores of this machine; with a profile jobs at a time, or None for the profile's own number.
    Raises SolverFailed when Snakemake ran none of them.
    """
    for run in runs:  # the manifests know what is complete; a mark of older inputs must not
        shutil.rmtree(out / DONE / run.name, ignore_errors=True)
    for mark in (out / DONE).glob("library-*"):
        mark.unlink()
    args: list[str | Path] = [
        "--snakefile", SNAKEFILE, "--directory", out.resolve(), "--nolock", "--rerun-incomplete", "--rerun-triggers", "mtime",
        "--keep-going", "--scheduler", "greedy",
    ]  # fmt: skip
    if profile is None:
        # All jobs are alike: to weigh every ready one whenever one ends, or to count starts, only takes time.
        args += ["--scheduler-subsample", str(2 * jobs), "--max-jobs-per-timespan", "100000/2s"]
        args += ["--jobs", str(jobs), "--cores", str(jobs)]
    else:  # --jobs takes the place of the profile's own number: only when asked
        args += ["--profile", profile.resolve()] + (["--jobs", str(jobs)] if jobs else [])

    def on_line(line: str) -> None:
        stopping.check()
        if found := _STEPS.search(line):
            number, count = map(int, found.groups())
            tell(number / count, f"{number} of {count} stages of runs")

    log = out / "logs" / "snakemake.log"
    # It cancels a cluster's jobs on SIGINT alone; told to end by SIGTERM it waits for them.
    interrupt_s = None if profile is None else _CANCEL_S
    ended = run_module("snakemake", args, log=log, on_line=on_line, interrupt_s=interrupt_s)
    stopping.check()
    if ended.exit_code == 0:
        return
    cause = f"Snakemake ended with exit code {ended.exit_code}"
    known = [run for run in runs if failure_file(out, run.name).exists() or (out / BUSY / run.name).exists()]
    lost = [run for run in runs if run not in known and not (out / DONE / run.name / last_stage).exists()]
    if len(lost) == len(runs):
        raise SolverFailed("Snakemake did none of the study's runs", cause=cause, log=log, tail=tail(log))
    for run in lost:
        record_failure(out, run.name, SolverFailed.exit_code, "", f"its job ended without a word; log {log}")
