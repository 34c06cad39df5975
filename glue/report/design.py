"""The trade front of a design as a picture: the objective against each target's quantity."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.study.design.design import Design
from glue.study.design.evaluate import Evaluation
from glue.study.design.goals import Quantity, Target

FIGURE = "front.png"
_MET, _NOT, _WINNER = "#0072b2", "#9a9a9a", "#d55e00"


def front_plot(result: Design) -> Path:
    """``front.png``: a panel for each target, and for each further objective, with the first objective upwards.

    Filled: surely meets every target; hollow: not.  The line joins what no other beats in the two quantities among
    those that meet the other targets.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    goals = result.problem.goals
    first = goals.objectives[0]
    panels: list[tuple[Quantity, int, Target | None]] = [(t.quantity, t.sign, t) for t in goals.targets]
    panels += [(o.quantity, -o.sign, None) for o in goals.objectives[1:]]
    panels = [p for p in panels if p[0] != first.quantity] or [(first.quantity, -first.sign, None)]
    figure = Figure(figsize=(4.6 * len(panels), 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    for k, (quantity, sign, target) in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), k + 1)
        shown = [e for e in result.evaluations if e.reading(quantity) and e.reading(first.quantity)]
        for met in (False, True):
            some = [e for e in shown if e.feasible(goals) == met]
            x, y = [_in_unit(e, quantity) for e in some], [_in_unit(e, first.quantity) for e in some]
            axes.scatter(x, y, s=26, edgecolors=_MET if met else _NOT, facecolors=_MET if met else "none", zorder=3 if met else 2,
                         label="surely meets all targets" if met else "does not")  # fmt: skip
        edge = front_of(result, quantity, sign, target)
        x, y = [_in_unit(e, quantity) for e in edge], [_in_unit(e, first.quantity) for e in edge]
        axes.plot(x, y, color="#444", lw=1, zorder=1, label="front, other targets met")
        if target is not None:
            axes.axvline(target.limit / next(iter(quantity.units.values())), color="#444", ls="--", lw=1, label=str(target))
        if result.winner is not None and result.winner in shown:
            axes.scatter([_in_unit(result.winner, quantity)], [_in_unit(result.winner, first.quantity)], marker="*", s=170,
                         color=_WINNER, zorder=4, label="proposed")  # fmt: skip
        axes.set(xlabel=_label(quantity), ylabel=_label(first.quantity))
        if quantity.path == "coverage.final":
            _coverage_scale(axes)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7, loc="best")
    file = result.out / FIGURE
    figure.savefig(file, dpi=130)
    return file


def front_of(result: Design, quantity: Quantity, sign: int, target: Target | None) -> list[Evaluation]:
    """Of the evaluations that meet all targets but ``target``: those best in the first objective for their value of
    ``quantity`` (more is better for sign +1), by that value."""
    goals = result.problem.goals
    first = goals.objectives[0]
    others = [k for k, t in enumerate(goals.targets) if t != target]
    able = [
        e for e in result.evaluations
        if e.reading(quantity) and e.reading(first.quantity) and all(e.slacks(goals)[k] >= 0.0 for k in others)
    ]  # fmt: skip
    kept, best = [], float("inf")
    for e in sorted(able, key=lambda e: (-sign * e.reading(quantity).value, first.sign * e.reading(first.quantity).value)):
        cost = first.sign * e.reading(first.quantity).value
        if cost < best:
            best = cost
            kept.append(e)
    return kept


def _coverage_scale(axes) -> None:
    """Per cent evenly by the hits per point that they mean, -ln(1 - C): else all that matters lies on one line."""
    full = 100.0 * (1.0 - 1e-5)

    def hits(percent):
        return -np.log1p(-np.clip(percent, 0.0, full) / 100.0)

    axes.set_xscale("function", functions=(hits, lambda h: -100.0 * np.expm1(-h)))
    axes.set_xticks([50, 90, 98, 99.8, 99.99], ["50", "90", "98", "99.8", "99.99"])


def _in_unit(e: Evaluation, quantity: Quantity) -> float:
    return e.reading(quantity).value / next(iter(quantity.units.values()))


def _label(quantity: Quantity) -> str:
    unit = next(iter(quantity.units))
    return f"{quantity.short.replace('_', ' ')}{f' [{unit}]' if unit else ''}"
