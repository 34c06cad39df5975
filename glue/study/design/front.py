"""What the evaluations show: the winner, what may stand in for it, the trade front, what cannot be met."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from glue.study.design.evaluate import NEVER, Evaluation
from glue.study.design.goals import Goals, Target


def ranked(evaluations: Sequence[Evaluation], goals: Goals) -> list[Evaluation]:
    """Those that surely meet every target, best first.

    By the objective; of several by the distance to the best value of each, over the range found.
    """
    met = [e for e in evaluations if e.feasible(goals)]
    if not met:
        return []
    costs = [e.costs(goals) for e in met]
    low = [min(column) for column in zip(*costs, strict=True)]
    span = [max(column) - least or 1.0 for column, least in zip(zip(*costs, strict=True), low, strict=True)]
    far = [sum(((c - b) / s) ** 2 for c, b, s in zip(cost, low, span, strict=True)) for cost in costs]
    return [e for _, e in sorted(zip(far, met, strict=True), key=lambda pair: (pair[0], pair[1].number))]


def next_candidate(order: Sequence[Evaluation], goals: Goals, tried: Mapping[int, Mapping[Target, float]]) -> Evaluation | None:
    """The best of ``order`` that is as much further on the safe side as those tried turned out short.

    tried: {number: {target: shortfall, scaled}}, shortfalls of targets that were met left out.
    """
    needed: dict[Target, float] = {}
    by_number = {e.number: e for e in order}
    for number, short in tried.items():
        own = dict(zip(goals.targets, by_number[number].slacks(goals), strict=True))
        for target, missing in short.items():
            needed[target] = max(needed.get(target, 0.0), own[target] + missing)
    for e in order:
        own = dict(zip(goals.targets, e.slacks(goals), strict=True))
        if e.number not in tried and all(own[target] >= least for target, least in needed.items()):
            return e
    return None


def trade_front(evaluations: Sequence[Evaluation], goals: Goals) -> list[Evaluation]:
    """Those that no other beats in every objective and in the margin to the targets (the worst scaled slack), by objective."""
    points = []
    for e in evaluations:
        costs = e.costs(goals)
        if e.state == "done" and costs is not None:
            points.append((e, [*costs, -min(e.slacks(goals), default=0.0)]))
    kept = [e for e, own in points if not any(_beats(other, own) for _, other in points)]
    return sorted(kept, key=lambda e: (e.costs(goals), e.number))


def _beats(a: Sequence[float], b: Sequence[float]) -> bool:
    return all(x <= y for x, y in zip(a, b, strict=True)) and any(x < y for x, y in zip(a, b, strict=True))


def nearest(evaluations: Sequence[Evaluation], goals: Goals) -> Evaluation | None:
    """The one that misses its targets by least in all (scaled); None when nothing could be run."""
    done = [e for e in evaluations if e.state == "done" and e.costs(goals) is not None]
    return min(done, key=lambda e: (sum(-s for s in e.slacks(goals) if s < 0.0), e.number), default=None)


def unmet(evaluations: Sequence[Evaluation], goals: Goals) -> list[str]:
    """Sentences: which targets no evaluation surely meets, with the nearest found; [] when some meet all."""
    done = [e for e in evaluations if e.state == "done"]
    if any(e.feasible(goals) for e in done):
        return []
    told = []
    for k, target in enumerate(goals.targets):
        best = max(done, key=lambda e: e.slacks(goals)[k], default=None)
        slack = NEVER if best is None else best.slacks(goals)[k]
        if slack >= 0.0:
            continue
        reading, q = None if best is None else best.reading(target.quantity), target.quantity
        near = "it has no value anywhere"
        if reading is not None:
            near = f"nearest {q.told(reading)}, evaluation {best.number}"
        told.append(f"{target}: cannot be met in this window; {near}")
    return told or ["each target can be met alone, no evaluation meets all of them together"]
