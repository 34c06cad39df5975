"""From what runs measured to rows: error of each quantity on each rung, with chance kept apart.

A rung and its reference are run with the same seeds, so what their arrivals share drops out of the difference; the mean of
the differences is the error, their standard deviation over the root of their number its standard error.  An error below
twice its standard error is *hidden*: only that bound is known.  Groups whose reference has other seeds ("chance",
"patches") are compared mean with mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from glue.study.tradeoff.jobs import Job
from glue.study.tradeoff.ladder import STAGES, Group, Rung
from glue.study.tradeoff.quantities import BY_NAME

HIDDEN = 2.0  # standard errors


def rows_of(jobs: Sequence[Job], found: Sequence[dict]) -> list[dict]:
    """A row for each rung of one scene; ``found``: what each of ``jobs`` measured, in their order.

    {"group", "stage", "factor", "level", "physics", "changes", "seeds", "wall_s", "cpu_s", "memory_bytes", "stage_cpu_s",
    "work", "failed",
    "quantities": {name: {"value", "error", "se", "hidden", "scatter"}}}; se and scatter are None for a single seed.  A
    reference is a row too, without errors.
    """
    groups = {job.group.name: job.group for job in jobs}
    runs: dict[tuple, dict[int, dict]] = {}
    for job, result in zip(jobs, found, strict=True):
        number = None if job.rung is None else job.group.rungs.index(job.rung)
        runs.setdefault((job.group.name, number), {})[job.seed] = result
    rows = []
    for (name, number), results in runs.items():
        rung = None if number is None else groups[name].rungs[number]
        rows.append(_row(groups[name], rung, results, runs[(name, None)]))
    return rows


def scatter_of(jobs: Sequence[Job], found: Sequence[dict], group: str) -> dict[str, dict]:
    """Standard deviation of one run over seeds, relative to the scale: {quantity: {"sd", "seeds", "value"}}.

    Over all seeds of ``group``, whose runs have nothing but chance between them, its reference's too; windows that are cut
    apart.
    """
    values: dict[str, list[float]] = {}
    scale: dict[str, list[float]] = {}
    for job, result in zip(jobs, found, strict=True):
        if job.group.name == group and (job.rung is None or not job.rung.changes):
            for name, value in result["values"].items():
                if name in result["scales"]:
                    values.setdefault(name, []).append(value)
                    scale.setdefault(name, []).append(result["scales"][name])
    return {
        name: {"sd": float(np.std(v, ddof=1) / np.mean(scale[name])), "seeds": len(v), "value": float(np.mean(v))}
        for name, v in values.items() if len(v) >= 3
    }  # fmt: skip


def _row(group: Group, rung: Rung | None, results: dict[int, dict], reference: dict[int, dict]) -> dict:
    good = {seed: r for seed, r in results.items() if not r["failed"]}
    failed = next((r["failed"] for r in results.values() if r["failed"]), None)
    right = {seed: r for seed, r in reference.items() if not r["failed"]}
    judged = {
        "group": group.name, "stage": group.stage, "factor": rung.factor if rung else "reference",
        "level": rung.level if rung else "", "physics": bool(rung and rung.physics),
        "changes": group.base | (rung.changes if rung else group.reference), "seeds": len(good), "failed": failed,
        **{key: _cost(group, good.values(), key) for key in ("wall_s", "cpu_s", "memory_bytes")},
    }  # fmt: skip
    judged["stage_cpu_s"] = {
        s: float(np.median([r["cpu_s"][s] for r in good.values() if s in r["cpu_s"]]))
        for s in STAGES if any(s in r["cpu_s"] for r in good.values())
    }  # fmt: skip
    judged["work"] = {
        name: float(np.mean([r["work"][name] for r in good.values() if name in r["work"]]))
        for name in ("flow", "target", "window") if any(name in r["work"] for r in good.values())
    }  # fmt: skip
    names = [n for n in BY_NAME if any(n in r["values"] for r in good.values())]
    judged["quantities"] = {n: _error(group, n, good, right, rung is None) for n in names}
    return judged


def _error(group: Group, name: str, good: dict, right: dict, is_reference: bool) -> dict:
    own = {seed: r["values"][name] for seed, r in good.items() if name in r["values"]}
    told = {"value": float(np.mean(list(own.values()))), "error": None, "se": None, "hidden": False, "scatter": None}
    true = {seed: r["values"][name] for seed, r in right.items() if name in r["values"]}
    scales = [r["scales"][name] for r in right.values() if name in r["scales"]]
    if not scales:
        return told
    scale = float(np.mean(scales))
    if len(own) > 1:
        told["scatter"] = float(np.std(list(own.values()), ddof=1) / scale)
    if is_reference:
        return told
    if group.paired:
        pairs = [(own[seed] - true[seed]) / scale for seed in own if seed in true]
        if not pairs:
            return told
        error, se = np.mean(pairs), np.std(pairs, ddof=1) / math.sqrt(len(pairs)) if len(pairs) > 1 else None
    else:
        if len(own) < 2 or len(true) < 2:
            return told
        a, b = (np.array(list(v.values())) / scale for v in (own, true))
        error, se = a.mean() - b.mean(), math.hypot(a.std(ddof=1) / math.sqrt(a.size), b.std(ddof=1) / math.sqrt(b.size))
    told |= {"error": float(error), "se": None if se is None else float(se)}
    told["hidden"] = bool(se is not None and abs(error) < HIDDEN * se)
    return told


def bound(quantity: dict) -> float | None:
    """Largest error that a row's quantity leaves open: |error|, or what hides it."""
    if quantity["error"] is None:
        return None
    return max(abs(quantity["error"]), HIDDEN * (quantity["se"] or 0.0))


def _cost(group: Group, results, key: str) -> float | None:
    """Median over seeds (the first run of all compiles), of the stage that is judged; of a whole preset and of chance the sum
    over stages (memory: the largest)."""
    stages = STAGES if group.stage in ("whole", "seeds") else (group.stage,)
    costs = [[r[key][s] for s in stages if s in r[key]] for r in results]
    costs = [c for c in costs if c]
    if not costs:
        return None
    return float(np.median([max(c) if key == "memory_bytes" else sum(c) for c in costs]))
