"""The search of the window: a Sobol design, then Optuna's tree-structured Parzen estimator, constraints told apart.

Why Optuna: few, noisy evaluations of mixed numbers and words under constraints, some of them impossible.  On a closed-form
stand-in of this problem (speed, flow, time, three grades; 64 evaluations, 3 % noise, ten seeds) the median best value was
3.14; scipy's differential evolution found 3.65, no better than Sobol points alone (3.66).

Proposals are made in rounds of ROUND from the evaluations of earlier rounds alone, each with a seed of its own: the same
settings are tried however many run at a time and however often the search was stopped.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence

from scipy.stats import qmc

from glue.errors import InputError, SolverFailed
from glue.study.design.axes import Axis
from glue.study.design.evaluate import NEVER, Evaluation
from glue.study.design.goals import Goals

ROUND = 4
_TRIES = 20  # at a setting that was not tried before; then the window holds no more of them


def first_points(axes: Sequence[Axis]) -> int:
    """Evaluations that spread over the window before any are aimed: four an axis and four, in whole rounds."""
    return ROUND * (len(axes) + 1)


def settings_of_round(
    axes: Sequence[Axis], goals: Goals, known: Sequence[Evaluation], start: int, seed: int
) -> list[dict[str, object]]:
    """The ROUND settings numbered from ``start``, by the evaluations ``known`` below it; fewer when no others are left."""
    earlier = sorted((e for e in known if e.number < start), key=lambda e: e.number)  # not as they happened to end
    tried = {_key(e.values) for e in earlier}
    found: list[dict[str, object]] = []
    for number in range(start, start + ROUND):
        for attempt in range(_TRIES):
            values = _proposal(axes, goals, earlier, number, attempt, seed)
            if _key(values) not in tried:
                tried.add(_key(values))
                found.append(values)
                break
    return found


def _key(values: dict[str, object]) -> tuple:
    return tuple(sorted(values.items()))


def _proposal(axes, goals, earlier: Sequence[Evaluation], number: int, attempt: int, seed: int) -> dict[str, object]:
    if number < first_points(axes) or not any(e.state == "done" for e in earlier):
        points = qmc.Sobol(len(axes), seed=seed + attempt).random_base2(6)  # 64, more than any window's first points
        return {axis.key: axis.at(float(share)) for axis, share in zip(axes, points[number % len(points)], strict=True)}
    return _aimed(axes, goals, earlier, (seed * 1_000_003 + number * 101 + attempt) % 2**32)


def _aimed(axes: Sequence[Axis], goals: Goals, earlier: Sequence[Evaluation], seed: int) -> dict[str, object]:
    """A setting by the estimator, which ranks what breaks a target behind all that does not, by how far."""
    import optuna  # here: half a second

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)  # several numbers considered together
        sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=0, multivariate=True)
    study = optuna.create_study(directions=["minimize"] * len(goals.objectives), sampler=sampler)
    spaces = {axis.key: _space(axis) for axis in axes}
    for e in earlier:
        slacks, costs = e.slacks(goals) or [0.0], e.costs(goals)
        if e.state != "done" or costs is None:
            slacks, costs = [NEVER], [0.0] * len(goals.objectives)
        constraints = {str(k): -slack for k, slack in enumerate(slacks)}
        trial = optuna.trial.create_trial(params=dict(e.values), distributions=spaces, values=costs, constraints=constraints)
        study.add_trial(trial)
    asked = study.ask(spaces).params
    return {axis.key: axis.rounded(asked[axis.key]) for axis in axes}


def _space(axis: Axis):
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    if axis.kind == "choice":
        return CategoricalDistribution(axis.choices)
    if axis.kind == "int":
        return IntDistribution(int(axis.low), int(axis.high))
    return FloatDistribution(axis.low, axis.high, log=axis.kind == "log")


def search(
    axes: Sequence[Axis],
    goals: Goals,
    known: Sequence[Evaluation],
    count: int,
    seed: int,
    run: Callable[[list[tuple[int, dict[str, object]]], Callable[[Evaluation], None]], None],
    keep: Callable[[list[Evaluation]], None],
) -> list[Evaluation]:
    """``count`` evaluations in all, ``known`` among them, by number; the failed are run again as they were.

    run(settings, tell): evaluates [(number, values), …] and tells each when it is done; keep(evaluations): called after
    each.  Raises InputError when every one of the first settings is refused, SolverFailed when some of them failed.
    """
    found = {e.number: e for e in known}
    again = {e.number: dict(e.values) for e in known if e.state == "failed"}  # not proposed anew

    def tell(evaluation: Evaluation) -> None:
        found[evaluation.number] = evaluation
        keep(list(found.values()))

    for start in range(0, count, ROUND):
        numbers = range(start, min(start + ROUND, count))
        todo = {n: again[n] for n in numbers if n in again}
        missing = [n for n in numbers if n not in found]
        if missing:
            settings = settings_of_round(axes, goals, list(found.values()), start, seed)
            todo |= {n: settings[n - start] for n in missing if n - start < len(settings)}
        if todo:
            run(sorted(todo.items()), tell)
        elif missing:
            break
        if start + ROUND >= first_points(axes) and all(e.state != "done" for e in found.values()):
            _none_could_be_run(list(found.values()))
    return [found[n] for n in sorted(found)]


def _none_could_be_run(found: Sequence[Evaluation]) -> None:
    causes = [f"  {cause}" for cause in list(dict.fromkeys(e.cause for e in found))[:5]]
    if all(e.state == "refused" for e in found):
        raise InputError(["no setting of the window can be run; the causes:", *causes])
    raise SolverFailed(
        "no setting of the window could be run; the causes:\n" + "\n".join(causes),
        advice="the same command once more: it tries again what failed",
    )
