"""Does a proposed setting hold?  It is run again at a finer preset, with other seeds and the scene's own models."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from glue.study.design.evaluate import Evaluation, rerun
from glue.study.design.front import next_candidate
from glue.study.design.goals import Target
from glue.study.design.pool import News, Pool
from glue.study.design.problem import Problem
from glue.study.rundir import STAGE_ORDER

SEEDS = 3
FIRST_SEED = 7001  # added to the scene's own, which the search used
CANDIDATES = 3  # tried before giving up


@dataclass(frozen=True)
class Confirmation:
    """Re-runs of evaluation ``number``'s setting; their own numbers are their seeds."""

    number: int
    preset: str
    runs: tuple[Evaluation, ...]

    def shortfall(self, target: Target) -> float | None:
        """How far (scaled) the worst run's interval misses the target, 0 when all reach it; None: a run has no value."""
        readings = [run.reading(target.quantity) for run in self.runs]
        if None in readings:
            return None
        worst = min(target.sign * (r.value - target.limit) + r.margin for r in readings)
        return max(0.0, -target.scaled(worst))

    def outright(self, target: Target) -> int:
        """Runs whose value itself meets the target."""
        readings = [run.reading(target.quantity) for run in self.runs]
        return sum(r is not None and target.sign * (r.value - target.limit) >= 0.0 for r in readings)

    def mean(self, quantity) -> tuple[float, float | None] | None:
        """(mean value of the runs, mean half width of one, None where one is not known); None when one has no value."""
        readings = [run.reading(quantity) for run in self.runs]
        if None in readings:
            return None
        halves = [r.half for r in readings]
        return statistics.fmean(r.value for r in readings), None if None in halves else statistics.fmean(halves)

    def holds(self, targets: Sequence[Target]) -> bool:
        """Does every run meet every target within its own interval?"""
        return all(run.state == "done" for run in self.runs) and all(self.shortfall(t) == 0.0 for t in targets)


def confirm(
    pool: Pool, candidate: Evaluation, preset: str, base_seed: int, out: Path, progress
) -> Confirmation:
    """Re-run the setting with SEEDS other seeds; run directories ``out``/<number>-seed<seed>-<preset>."""
    seeds = tuple((base_seed + FIRST_SEED + k) % 2**32 for k in range(SEEDS))
    orders = [(dict(candidate.values), out / f"{candidate.number:04d}-seed{s}-{preset}", preset, s) for s in seeds]
    found: list[Evaluation] = []

    def within(running: list[News]) -> None:
        # by stage, so that it only rises; how long each takes is not known
        shares = [(_place(stage) + (fraction or 0.0)) / len(STAGE_ORDER) for stage, fraction, _ in running]
        words = "; ".join(f"{stage} {text}".strip() for stage, _, text in running)
        at = f"evaluation {candidate.number}, {len(found)} of {SEEDS} runs done; {words}"
        progress("confirm", min((len(found) + sum(shares)) / SEEDS, 0.999), at)

    pool.run(rerun, orders, found.append, within)
    return Confirmation(candidate.number, preset, tuple(sorted(found, key=lambda run: run.number)))


def _place(stage: str) -> int:
    return STAGE_ORDER.index(stage) if stage in STAGE_ORDER else 0  # an Almen strip comes before the stages


def confirm_first(
    problem: Problem, order: Sequence[Evaluation], once: Callable[[Evaluation], Confirmation]
) -> tuple[Evaluation | None, list[Confirmation]]:
    """The first candidate of ``order`` that holds, and all that were tried (CANDIDATES at most).

    After one that does not, the next is the best that is as much further on the safe side as it turned out short.
    """
    tried: list[Confirmation] = []
    while len(tried) < CANDIDATES:
        short = {
            c.number: {t: s for t in problem.goals.targets if (s := c.shortfall(t) or 0.0) > 0.0} for c in tried
        }
        candidate = next_candidate(order, problem.goals, short)
        if candidate is None:
            break
        tried.append(once(candidate))
        if tried[-1].holds(problem.goals.targets):
            return candidate, tried
    return None, tried
