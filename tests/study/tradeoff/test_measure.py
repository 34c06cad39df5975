"""Running a ladder: order of what is returned, failures, the time left, Ctrl-C."""

from __future__ import annotations

from pathlib import Path

import pytest

from glue.study.tradeoff.jobs import Job
from glue.study.tradeoff.ladder import Group, Rung
from glue.study.tradeoff.measure import measure

RUNG = Rung("mesh", "a/3", {})
GROUP = Group("whole", "whole", {}, {}, (RUNG,), seeds=3)  # guessed at a minute and more: a batch of its own each


def jobs(count=6):
    return [Job(Path("scene.toml"), GROUP, RUNG if k % 2 else None, k % 3, b"", Path(str(k))) for k in range(count)]


def all_well(batch, tell):
    for k, job in enumerate(batch):
        tell(k, {"failed": None, "folder": job.folder}, 1.0)


@pytest.mark.parametrize("at_a_time", [1, 3])
def test_results_stand_in_the_order_of_the_jobs(at_a_time):
    found = measure(jobs(), run=all_well, at_a_time=at_a_time)
    assert [f["folder"] for f in found] == [job.folder for job in jobs()]


def test_a_failed_run_is_told_and_the_rest_goes_on():
    def run(batch, tell):
        for k, job in enumerate(batch):
            tell(k, {"failed": "no memory" if job.seed == 1 else None}, 1.0)

    lines = []
    found = measure(jobs(), lines.append, run)
    assert [f["failed"] for f in found] == [None, "no memory", None] * 2
    assert sum("failed: no memory" in line for line in lines) == 2


def test_the_time_left_goes_by_how_long_runs_really_take():
    lines = []
    measure(jobs(), lines.append, lambda batch, tell: [tell(k, {"failed": None}, 600.0) for k in range(len(batch))])
    # three references guessed at 300 s and three rungs at 60 s, the first of either kind takes 600 s
    assert "1 of 6" in lines[0] and " min left: scene: whole, " in lines[0] and "6 of 6, 0 s left" in lines[5]


def test_what_stops_a_batch_stops_the_ladder():
    def run(batch, tell):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure(jobs(), run=run)
