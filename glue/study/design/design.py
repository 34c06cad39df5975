"""``peen design``: the setting of a scene that meets targets at the least cost, found by fast models, confirmed by finer ones."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.scene.presets import PRESETS
from glue.study.design import front
from glue.study.design.confirm import Confirmation, confirm, confirm_first
from glue.study.design.evaluate import Evaluation, evaluate
from glue.study.design.goals import Target
from glue.study.design.history import FILE, read_history, write_history
from glue.study.design.pool import News, Pool
from glue.study.design.problem import Problem, claim, default_out
from glue.study.design.search import search
from glue.study.design.shared import solve_window
from glue.study.target_surface import companions
from glue.target.speeds import cores

EVALUATIONS = 64
MOST_JOBS = 4  # a round of the search; more would wait
RESULT, WINNER = "design.json", "winner.toml"
# verdict: (does the command succeed, what it means)
VERDICTS = {
    "confirmed": (True, "the setting meets its targets in every re-run, within the stated uncertainty"),
    "not asked": (True, "the setting meets its targets by the fast models; it was not run by finer ones"),
    "not confirmed": (False, "no setting that was tried by finer models meets its targets within the stated uncertainty"),
    "infeasible": (False, "no setting of the window surely meets all targets"),
}


@dataclass(frozen=True)
class Design:
    """What came out, and where it lies."""

    problem: Problem
    out: Path
    evaluations: list[Evaluation]
    verdict: str
    winner: Evaluation | None  # of "not confirmed" the best by the fast models
    confirmations: list[Confirmation]
    dimples: str  # at which speeds they were solved
    wall_s: float

    @property
    def succeeded(self) -> bool:
        return VERDICTS[self.verdict][0]

    @property
    def at_ends(self) -> dict[str, str]:
        """{axis: "low" or "high"} where the winner lies at that end of the range: a wider one may hold a better setting."""
        values = {} if self.winner is None else self.winner.values
        found = {axis.key: axis.end_at(values[axis.key]) for axis in self.problem.axes if axis.key in values}
        return {key: end for key, end in found.items() if end}

    @property
    def without_interval(self) -> list[Target]:
        """Targets that the verdict judges by values alone: the winner's (else all evaluations') or a re-run's."""
        judged = list(self.evaluations) if self.winner is None else [self.winner]
        judged += [run for c in self.confirmations for run in c.runs]
        found = {t: [r for e in judged if (r := e.reading(t.quantity))] for t in self.problem.goals.targets}
        return [target for target, readings in found.items() if any(r.half is None for r in readings)]

    @property
    def front(self) -> list[Evaluation]:
        return front.trade_front(self.evaluations, self.problem.goals)


def design(
    problem: Problem,
    out: Path | None = None,
    *,
    evaluations: int = EVALUATIONS,
    preset: str | None = "balanced",
    jobs: int | None = None,
    progress: Callable[[str, float | None, str], None] = lambda *_: None,
) -> Design:
    """Search the window of ``problem``, confirm the winner at ``preset`` (None: not at all), write it all into ``out``.

    ``jobs`` settings are run at a time (default: one per core, MOST_JOBS at most; it does not change what is found).  The same
    call goes on where a stopped one was and tries those that failed again; more ``evaluations`` add to those that are
    there.  Raises InputError, SolverFailed; settings that are refused or fail alone are part of the result.
    """
    problems = []
    if preset is not None and preset not in PRESETS:
        problems.append(f"--confirm {preset}: allowed {', '.join(PRESETS)}, none")
    if not 1 <= evaluations <= 10_000:
        problems.append(f"--evaluations {evaluations}: allowed 1 to 10000")
    jobs = min(MOST_JOBS, cores()) if jobs is None else jobs
    if jobs < 1:
        problems.append(f"--jobs {jobs}: allowed from 1 up, such as the number of cores")
    if problems:
        raise InputError(problems)
    begun, goals, axes = time.monotonic(), problem.goals, problem.axes
    out = default_out(problem) if out is None else out
    claim(out, problem)
    known = read_history(out / FILE, axes, goals)
    told = "all evaluations were there"
    if sum(e.number < evaluations and e.state != "failed" for e in known) < evaluations:
        told = solve_window(problem, jobs, lambda share, text: progress("dimples", share, text))
        progress("dimples", 1.0, told)
    found = list(known)

    def run(settings, tell) -> None:
        orders = [(n, values, out / "evaluations" / f"{n:04d}") for n, values in settings]

        def within(running: list[News]) -> None:
            words = "; ".join(f"{stage} {text}".strip() for stage, _, text in running)
            so_far = f"{len(found)} of {evaluations}, {_best(found, problem)}"
            progress("search", min(len(found) / evaluations, 0.999), f"{so_far}; {words}")

        pool.run(_evaluate, orders, tell, within)

    def keep(all_of_them: list[Evaluation]) -> None:
        found[:] = all_of_them
        write_history(out / FILE, found, axes, goals)
        progress("search", min(len(found) / evaluations, 0.999), f"{len(found)} of {evaluations}, {_best(found, problem)}")

    seed, verdict, winner, tried = problem.scene({}).seed, "infeasible", None, []
    with Pool(jobs, (problem,)) as pool:
        found = search(axes, goals, found, evaluations, seed, run, keep)
        progress("search", 1.0, f"{len(found)} evaluations, {_best(found, problem)}")
        order = front.ranked(found, goals)
        if order:
            verdict, winner = "not asked", order[0]
        if order and preset is not None:
            held, tried = confirm_first(problem, order, lambda e: confirm(pool, e, preset, seed, out / "confirm", progress))
            progress("confirm", 1.0, "done")
            verdict, winner = ("not confirmed", order[0]) if held is None else ("confirmed", held)
    result = Design(problem, out, found, verdict, winner, tried, told, time.monotonic() - begun)
    _write(result)
    return result


def _evaluate(problem, number, values, folder, progress=lambda *_: None) -> Evaluation:
    return evaluate(problem, number, values, folder, progress)


def _best(found: list[Evaluation], problem: Problem) -> str:
    order = front.ranked(found, problem.goals)
    if not order:
        return "none meets all targets yet"
    first = problem.goals.objectives[0].quantity
    return f"best {first.short} {first.shown(order[0].reading(first).value)}"


def _write(result: Design) -> None:
    write_text_atomic(result.out / RESULT, json.dumps(as_dict(result), indent=1, ensure_ascii=False) + "\n")
    if result.winner is None:
        (result.out / WINNER).unlink(missing_ok=True)  # of a search that found one with fewer evaluations
        return
    problem, winner = result.problem, result.winner
    head = [f"Proposed by peen design from {problem.scene_file.name} (evaluation {winner.number}; {result.verdict}):"]
    head += [f"  {key} = {value}" for key, value in winner.values.items()]
    head += [f"  {target}" for target in problem.goals.targets] + [f"  {aim}" for aim in problem.goals.objectives]
    text = "".join(f"# {line}\n" for line in head) + problem.setting(winner.values).decode()
    write_text_atomic(result.out / WINNER, text)
    for name, content in companions(problem.scene(winner.values), problem.scene_file).items():
        (result.out / name).parent.mkdir(parents=True, exist_ok=True)
        (result.out / name).write_bytes(content)


def as_dict(result: Design) -> dict:
    """``design.json``: plain values, SI units."""
    problem, goals = result.problem, result.problem.goals
    states = [e.state for e in result.evaluations]
    near = front.nearest(result.evaluations, goals)
    return {
        "schema": 1,
        "kind": "design",
        "scene": problem.scene_file.name,
        "targets": [{"text": str(t), "key": t.quantity.path, "limit": t.limit} for t in goals.targets],
        "objectives": [{"text": str(o), "key": o.quantity.path} for o in goals.objectives],
        "axes": [str(axis) for axis in problem.axes],
        "verdict": result.verdict,
        "meaning": VERDICTS[result.verdict][1],
        "judged_without_interval": [str(target) for target in result.without_interval],
        "evaluations": {"count": len(result.evaluations), "refused": states.count("refused"),
                        "failed": states.count("failed"),
                        "meet_all_targets": len(front.ranked(result.evaluations, goals)),
                        "seconds": sum(e.wall_s for e in result.evaluations), "file": FILE},
        "dimples": result.dimples,
        "wall_s": result.wall_s,
        "winner": None if result.winner is None else _entry(result.winner, goals),
        "winner_at_range_ends": result.at_ends,
        "confirmations": [_confirmed(c, goals) for c in result.confirmations],
        "cannot_be_met": front.unmet(result.evaluations, goals),
        "nearest": None if near is None or result.winner is not None else _entry(near, goals),
        "front": [_entry(e, goals) for e in result.front],
    }  # fmt: skip


def _entry(e: Evaluation, goals) -> dict:
    readings = {path: None if r is None else r._asdict() for path, r in e.readings.items()}
    return {"number": e.number, "values": dict(e.values), "meets_all_targets": e.feasible(goals), "metrics": readings}


def _confirmed(c: Confirmation, goals) -> dict:
    targets = {str(t): {"shortfall": c.shortfall(t), "met_outright": c.outright(t), "runs": len(c.runs)} for t in goals.targets}
    runs = [
        {"seed": run.number, "state": run.state, "cause": run.cause, "wall_s": run.wall_s,
         "metrics": {path: None if r is None else r._asdict() for path, r in run.readings.items()}}
        for run in c.runs
    ]  # fmt: skip
    return {"evaluation": c.number, "preset": c.preset, "holds": c.holds(goals.targets), "targets": targets, "runs": runs}
