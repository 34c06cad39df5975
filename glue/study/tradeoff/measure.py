"""Runs a ladder's jobs, those that are done already for nothing, and tells how long the rest will take."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from glue import stopping
from glue.study.tradeoff.jobs import Job, run_job

# Seconds a run takes, for the time left until enough was measured; references by REFERENCE_TIMES.
_GUESS_S = {"coverage": 3, "chance": 4, "surface": 3, "patches": 5, "patches-full": 15, "flow": 8, "dimple": 12, "target": 15, "block": 40, "whole": 60}
_REFERENCE_TIMES = {"flow": 4.0, "dimple": 12.0, "target": 4.0, "block": 4.0, "whole": 5.0}


def guess_s(job: Job) -> float:
    """Rough wall time [s] of a run."""
    return _GUESS_S[job.group.name] * (_REFERENCE_TIMES.get(job.group.name, 1.0) if job.rung is None else 1.0)


def measure(
    jobs: Sequence[Job], progress: Callable[[str], None] = lambda line: None, run: Callable[[Job], dict] = run_job
) -> list[dict]:
    """What each job measured, in their order.  Ctrl-C stops; the same call again goes on where it was."""
    weights = [guess_s(job) for job in jobs]
    begun, found, done, spent = time.monotonic(), [], 0.0, 0.0
    for number, (job, weight) in enumerate(zip(jobs, weights, strict=True), 1):
        stopping.check()
        left = sum(weights[number - 1 :]) * (spent / done if done > 0.0 else 1.0)
        progress(f"{number} of {len(jobs)}, {_minutes(left)} left: {job.name}")
        at = time.monotonic()
        found.append(run(job))
        took = time.monotonic() - at
        if took > 0.2 * weight:  # else it was there already, and tells nothing of those that are not
            done, spent = done + weight, spent + took
        if found[-1]["failed"]:
            progress(f"   failed: {found[-1]['failed']}")
    progress(f"{len(jobs)} runs in {_minutes(time.monotonic() - begun)}")
    return found


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
