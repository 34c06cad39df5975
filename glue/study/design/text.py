"""A design on one page of text."""

from __future__ import annotations

from collections.abc import Sequence

from glue.study.design import front
from glue.study.design.confirm import Confirmation
from glue.study.design.design import RESULT, VERDICTS, WINNER, Design
from glue.study.design.evaluate import Evaluation
from glue.study.design.goals import Quantity
from glue.study.design.history import FILE

_FRONT_ROWS = 12


def design_text(result: Design) -> str:
    """What was asked, what came out and why, the trade front, the files."""
    problem, goals = result.problem, result.problem.goals
    states = [e.state for e in result.evaluations]
    met = front.ranked(result.evaluations, goals)
    lines = [f"{problem.scene_file.stem}: {', '.join(str(o) for o in goals.objectives)}"]
    lines += [f"  with  {target}" for target in goals.targets] + [f"  over  {axis}" for axis in problem.axes]
    others = f", {states.count('refused')} refused" if "refused" in states else ""
    if "failed" in states:
        others += f", {states.count('failed')} failed (the same command tries them again)"
    lines += ["", f"{len(result.evaluations)} settings tried by the fast models, {len(met)} surely meet every target"
                  f"{others}; {result.dimples}"]  # fmt: skip
    if result.winner is not None:
        lines += ["", f"Proposed setting (evaluation {result.winner.number})"]
        lines += [f"  {key:<34}{_plain(value)}" for key, value in result.winner.values.items()]
        lines += [f"  {q.short:<34}{_reading(result.winner, q)}" for q in goals.quantities]
        lines += ["  ± is the 95 % interval of a re-run (chance and numerics); other laws of the alloy move all settings alike."]
        lines += [f"  {key} is at the {end} end of its range: a wider one may hold a better setting."
                  for key, end in result.at_ends.items()]  # fmt: skip
    for confirmation in result.confirmations:
        lines += ["", *_confirmed(confirmation, result)]
    told = front.unmet(result.evaluations, goals)
    if told:
        lines += ["", *told]
        near = front.nearest(result.evaluations, goals)
        if near is not None:
            setting = ", ".join(f"{k} {_plain(v)}" for k, v in near.values.items())
            found = ", ".join(f"{q.short} {_reading(near, q)}" for q in goals.quantities)
            lines += [f"Nearest to all targets (evaluation {near.number}): {setting}", f"  {found}"]
    lines += ["", f"Verdict: {result.verdict}: {VERDICTS[result.verdict][1]}"]
    lines += [f"  {target} was judged without an interval: none is known" for target in result.without_interval]
    lines += ["", *front_table(result)]
    files = [RESULT, FILE, *([WINNER] if result.winner is not None else [])]
    return "\n".join([*lines, "", "Files", *(f"  {result.out / name}" for name in files)])


def front_table(result: Design) -> list[str]:
    """The settings that no other beats in the objectives and in the margin to the targets, one a line."""
    goals, shown = result.problem.goals, result.front
    if not shown:
        return []
    step = max(1.0, len(shown) / _FRONT_ROWS)
    rows = [shown[int(k * step)] for k in range(min(len(shown), _FRONT_ROWS))]
    keys = [axis.key.split(".")[-1] for axis in result.problem.axes]
    heads = ["number", *keys, *(q.short for q in goals.quantities), "targets"]
    cells = [
        [str(e.number), *map(_plain, e.values.values()),
         *(_reading(e, q) for q in goals.quantities), "met" if e.feasible(goals) else "not surely"]
        for e in rows
    ]  # fmt: skip
    widths = [max(len(row[k]) for row in [heads, *cells]) for k in range(len(heads))]
    title = "Trade front: no other setting is better in the objective and in the margin to the targets"
    more = f" ({len(rows)} of {len(shown)})" if len(shown) > len(rows) else ""
    table = ["  " + "  ".join(c.rjust(w) for c, w in zip(row, widths, strict=True)) for row in [heads, *cells]]
    return [title + more, *table]


def _plain(value: object) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _reading(e: Evaluation, q: Quantity) -> str:
    return q.told(e.reading(q))


def _confirmed(c: Confirmation, result: Design) -> Sequence[str]:
    goals = result.problem.goals
    seeds, word = ", ".join(str(run.number) for run in c.runs), "holds" if c.holds(goals.targets) else "does not hold"
    lines = [f"Re-run of evaluation {c.number} at {c.preset}, seeds {seeds}: {word}"]
    for run in c.runs:
        if run.state != "done":
            lines.append(f"  seed {run.number} {run.state}: {run.cause}")
    for q in goals.quantities:
        mean = c.mean(q)
        if mean is None:
            lines.append(f"  {q.short:<34}no value in a run")
            continue
        half = "no interval known" if mean[1] is None else f"one run ± {q.shown(mean[1], 2)}"
        lines.append(f"  {q.short:<34}mean {q.shown(mean[0])}, {half}")
    for target in goals.targets:
        short = c.shortfall(target)
        if short is None:
            word = "no value"
        elif short > 0.0:
            word = f"missed, beyond the interval by {target.quantity.shown(short * (abs(target.limit) or 1.0), 2)}"
        else:
            count = c.outright(target)
            word = f"met by {count} of {len(c.runs)} runs" + ("" if count == len(c.runs) else ", by the rest within their interval")
        lines.append(f"  {str(target):<34}{word}")
    return lines
