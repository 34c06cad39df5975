"""Running a ladder: order of what is returned, failures, going on after a stop, a real run of the cheapest kind."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from glue.study.tradeoff.jobs import Job
from glue.study.tradeoff.ladder import Group, Rung
from glue.study.tradeoff.measure import measure

RUNG = Rung("mesh", "a/3", {})
GROUP = Group("coverage", "coverage", {}, {}, (RUNG,), seeds=3)


def jobs(count=6):
    return [Job(Path("scene.toml"), GROUP, RUNG if k % 2 else None, k % 3, b"", Path(str(k))) for k in range(count)]


@pytest.mark.parametrize("at_a_time", [1, 3])
def test_results_stand_in_the_order_of_the_jobs(at_a_time):
    def run(job):
        time.sleep(0.01 * (3 - int(str(job.folder)) % 3))
        return {"failed": None, "folder": job.folder}

    found = measure(jobs(), run=run, at_a_time=at_a_time)
    assert [f["folder"] for f in found] == [job.folder for job in jobs()]


def test_a_failed_run_is_told_and_the_rest_goes_on():
    lines = []
    found = measure(jobs(), lines.append, run=lambda job: {"failed": "no memory" if job.seed == 1 else None})
    assert [f["failed"] for f in found] == [None, "no memory", None] * 2
    assert sum("failed: no memory" in line for line in lines) == 2 and "6 of 6" in lines[-2]


def test_progress_tells_the_time_left():
    lines = []
    measure(jobs(), lines.append, run=lambda job: {"failed": None})
    assert all(" left: scene: coverage, " in line for line in lines[:-1]) and len(lines) == 7


def test_ctrl_c_starts_nothing_more():
    ran = []

    def run(job):
        ran.append(job)
        if len(ran) == 2:
            raise KeyboardInterrupt
        return {"failed": None}

    with pytest.raises(KeyboardInterrupt):
        measure(jobs(), run=run)
    assert len(ran) <= 3  # one may have been begun already
