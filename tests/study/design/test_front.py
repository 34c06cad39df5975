"""Winner, next candidate, front, and what is said when targets cannot be met."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import pytest  # noqa: E402
from made_up import GOALS, at, refused  # noqa: E402

from glue.study.design.confirm import Confirmation, confirm_first  # noqa: E402
from glue.study.design.front import nearest, next_candidate, ranked, trade_front, unmet  # noqa: E402

COVERAGE, STRESS = GOALS.targets
SOME = [
    at(0, 0.99, -270, 12),  # meets both with .005 and 10 MPa to spare
    at(1, 0.984, -270, 9),  # within .005 of the limit: not surely
    at(2, 0.999, -255, 8),  # within 10 MPa
    at(3, 0.9995, -275, 15),
    at(4, 0.995, -265, 13),
    refused(5),
]


def test_the_winner_meets_every_target_with_the_bad_end_of_its_interval():
    assert [e.number for e in ranked(SOME, GOALS)] == [0, 4, 3]
    assert ranked(SOME[1:3], GOALS) == []


def test_the_next_candidate_is_as_much_safer_as_the_last_fell_short():
    order = ranked(SOME, GOALS)
    assert next_candidate(order, GOALS, {}).number == 0
    # evaluation 0 has .005/.98 to spare on coverage; .003/.98 short means .008/.98: 4 has .01
    assert next_candidate(order, GOALS, {0: {COVERAGE: 0.003 / 0.98}}).number == 4
    assert next_candidate(order, GOALS, {0: {COVERAGE: 0.006 / 0.98}}).number == 3
    assert next_candidate(order, GOALS, {0: {STRESS: 12e6 / 250e6}}) is None  # 22 MPa to spare: none has it
    assert next_candidate(order, GOALS, {0: {}}).number == 4  # failed for another reason


def test_front_is_what_nothing_beats_in_objective_and_margin():
    assert [e.number for e in trade_front(SOME, GOALS)] == [2, 1, 0, 4, 3]


def test_unmet_targets_are_named_with_the_nearest():
    assert unmet(SOME, GOALS) == []
    told = unmet([at(1, 0.984, -200, 9), at(2, 0.999, -230, 8), refused(5)], GOALS)
    assert told == ["max_compressive <= -250 MPa: cannot be met in this window; nearest -230 MPa ± 10 MPa, evaluation 2"]
    assert "each target can be met alone" in unmet([at(1, 0.9, -300, 9), at(2, 0.999, -230, 8)], GOALS)[0]
    assert nearest([at(1, 0.97, -270, 9), at(2, 0.999, -100, 8), refused(5)], GOALS).number == 1
    assert nearest([refused(5)], GOALS) is None


def again(number, *runs):
    return Confirmation(number, "balanced", tuple(at(7001 + k, *run) for k, run in enumerate(runs)))


def test_a_rerun_counts_by_its_own_interval():
    found = again(0, (0.978, -270, 12), (0.99, -244, 12), (0.985, -256, 12))
    assert found.holds(GOALS.targets) and found.outright(COVERAGE) == 2 and found.outright(STRESS) == 2
    short = again(0, (0.97, -270, 12), (0.99, -270, 12), (0.99, -230, 12))
    assert not short.holds(GOALS.targets)
    assert short.shortfall(COVERAGE) == pytest.approx(0.005 / 0.98) and short.shortfall(STRESS) == pytest.approx(10 / 250)
    assert short.mean(COVERAGE.quantity) == pytest.approx((0.98 + 0.01 / 3, 0.005))
    broken = Confirmation(0, "balanced", (refused(7001),))
    assert not broken.holds(GOALS.targets) and broken.shortfall(COVERAGE) is None


def test_candidates_are_tried_until_one_holds():
    class Problem:
        goals = GOALS

    good, bad = ((0.99, -270, 12),) * 3, ((0.9716, -270, 12),) * 3
    winner, tried = confirm_first(Problem, ranked(SOME, GOALS), lambda e: again(e.number, *(bad if e.number == 0 else good)))
    assert (winner.number, [c.number for c in tried]) == (4, [0, 4])
    winner, tried = confirm_first(Problem, ranked(SOME, GOALS), lambda e: again(e.number, *bad))
    assert winner is None and len(tried) <= 3
