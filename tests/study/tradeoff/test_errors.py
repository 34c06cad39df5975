"""Rows of the ladder from runs that are made up: error, scatter kept apart, failures."""

from __future__ import annotations

from pathlib import Path

import pytest

from glue.study.tradeoff.errors import bound, rows_of, scatter_of
from glue.study.tradeoff.jobs import Job
from glue.study.tradeoff.ladder import Group, Rung

RUNGS = (Rung("mesh", "coarse", {}), Rung("mesh", "fine", {}))


def group(paired=True, stage="dimple"):
    return Group("made-up", stage, {}, {}, RUNGS, seeds=3, paired=paired)


def run(value, failed=None):
    """What a run measured that found a dimple radius and a coverage of ``value``."""
    told = {} if failed else {"dimple_radius": value, "coverage": value}
    return {
        "values": told, "scales": {"dimple_radius": 2.0, "coverage": 1.0} if told else {}, "wall_s": {"dimple": 3.0},
        "cpu_s": {"dimple": 2.0, "flow": 5.0}, "memory_bytes": {"dimple": 10}, "work": {}, "failed": failed,
    }  # fmt: skip


def measured(reference, coarse, fine, **options):
    """Rows by level for runs of these values, seed by seed."""
    g = group(**options)
    jobs, found = [], []
    for rung, values in ((None, reference), (RUNGS[0], coarse), (RUNGS[1], fine)):
        for seed, value in enumerate(values):
            jobs.append(Job(Path("scene.toml"), g, rung, seed, b"", Path("x")))
            found.append(run(1.0, value) if isinstance(value, str) else run(value))
    return {row["level"]: row for row in rows_of(jobs, found)}


def test_what_seeds_share_drops_out_of_the_error():
    # seeds differ by 10, rung and reference by .2 (relative to 2: .1), with .01 of noise that is not shared
    rows = measured([0.0, 10.0, 20.0], [0.2, 10.21, 20.19], [0.0, 10.0, 20.0])
    radius = rows["coarse"]["quantities"]["dimple_radius"]
    assert radius["error"] == pytest.approx(0.1) and not radius["hidden"]
    assert radius["scatter"] == pytest.approx(5.0, rel=0.01)  # of the seeds themselves, kept apart
    assert rows["fine"]["quantities"]["dimple_radius"]["error"] == 0.0


def test_an_error_below_its_scatter_is_hidden_and_bounded_by_it():
    rows = measured([0.0, 0.0, 0.0], [0.5, -0.4, 0.0], [0.0, 0.0, 0.0])
    coverage = rows["coarse"]["quantities"]["coverage"]
    assert coverage["hidden"] and abs(coverage["error"]) < bound(coverage) == pytest.approx(2 * coverage["se"])


def test_groups_of_chance_are_compared_mean_with_mean():
    # paired by seed these would differ by nothing but their order
    rows = measured([1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [4.0, 5.0, 6.0], paired=False, stage="seeds")
    assert rows["coarse"]["quantities"]["coverage"]["error"] == 0.0
    fine = rows["fine"]["quantities"]["coverage"]
    assert fine["error"] == pytest.approx(3.0) and fine["se"] == pytest.approx((2 / 3) ** 0.5)


def test_a_rung_that_fails_is_a_row_with_its_reason():
    rows = measured([1.0, 1.0, 1.0], ["YADE broke"] * 3, [1.0, "YADE broke", 1.1])
    assert rows["coarse"]["failed"] == "YADE broke" and rows["coarse"]["quantities"] == {}
    assert rows["fine"]["seeds"] == 2 and rows["fine"]["quantities"]["coverage"]["error"] == pytest.approx(0.05)


def test_the_cost_is_that_of_the_stage_judged_and_of_all_for_chance():
    assert measured([1.0], [1.0], [1.0])["fine"]["cpu_s"] == 2.0
    assert measured([1.0], [1.0], [1.0], stage="seeds")["fine"]["cpu_s"] == 7.0


def test_scatter_counts_every_seed_of_the_uncut_window():
    g = Group("chance", "seeds", {}, {"seed_offset": 1000}, (Rung("window", "whole", {}), Rung("window", "half", {"window_scale": 0.5})))
    jobs = [Job(Path("s.toml"), g, rung, k, b"", Path("x")) for rung in (None, *g.rungs) for k in range(2)]
    found = [run(v) for v in (1.0, 2.0, 3.0, 4.0, 50.0, 90.0)]
    coverage = scatter_of(jobs, found, "chance")["coverage"]
    assert coverage["seeds"] == 4 and coverage["sd"] == pytest.approx((5 / 3) ** 0.5)
