"""Panels of the figures of studies: each draws on given axes what a study's points say.

Points are those of ``glue.study.sweep.points``; bars are plus and minus one standard deviation over the replicates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.report.figures import BLUE, FIELD_MAP, GREEN, GREY, ORANGE, RED
from glue.study.sweep.points import Point, Value, power

TIME_98 = "coverage.time_98_s"
RATE_FORM, FLOW_FORM = "coverage.avrami_time_98_s", "coverage.avrami_mass_flow_time_98_s"
UNDISTURBED = "coverage.avrami_undisturbed_time_98_s"
COLLISIONS = "flow.collision_number"
FULL = -math.log1p(-0.98)  # hits per point at which random impacts cover 98 %
DASHED, DOTTED = (0, (6, 2)), (0, (1, 1.5))


class Quantity(NamedTuple):
    """A column as people read it: multiplied by ``factor`` to the printed unit."""

    column: str
    label: str
    factor: float = 1.0
    unit: str = ""

    def title(self) -> str:
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def of(self, point: Point) -> float:
        return self.factor * point.mean(self.column)

    def word(self, point: Point) -> str:
        return f"{self.of(point):g} {self.unit}".strip().replace(" °", "°")


MASS_FLOW = Quantity("nozzle.mass_flow_kg_s", "mass flow", 1e3, "g/s")
SPEED = Quantity("nozzle.speed_m_s", "shot speed", 1.0, "m/s")
DIAMETER = Quantity("shots.diameter_m", "shot diameter", 1e3, "mm")
ANGLE = Quantity("nozzle.impact_angle_deg", "impact angle", 1.0, "°")
FEED = Quantity("nozzle.feed_speed_m_s", "feed speed", 1e3, "mm/s")
PASSES = Quantity("nozzle.passes", "passes")
PERCENT = Quantity("coverage.percent", "coverage as the trade counts", 1.0, "%")
IMPACTS = Quantity("coverage.impacts_in_window", "shots that struck the window")
LARGEST = Quantity("residual_stress.max_compressive_Pa", "largest compressive stress", 1e-6, "MPa")
SURFACE = Quantity("residual_stress.surface_Pa", "stress at the surface", 1e-6, "MPa")
TENTH = Quantity("residual_stress.tenth_depth_m", "depth with a tenth of it left", 1e6, "µm")
SA = Quantity("roughness.Sa_m", "Sa", 1e6, "µm")


Curve = tuple[str, np.ndarray, np.ndarray, np.ndarray]  # name, time or passes, coverage counted, Avrami's


def curves_panel(axes, curves: Sequence[Curve], *, log: bool = False, by: str = "exposure time [s]") -> None:
    """Coverage against time, or passes, a colour for each value, Avrami dashed; ``log``: of the time."""
    from matplotlib import colormaps

    for (name, x, counted, expected), share in zip(curves, np.linspace(0.0, 0.85, len(curves)), strict=True):
        colour, start = colormaps[FIELD_MAP](share), int(log)  # a logarithmic axis has no zero
        x, counted, expected = x[start:], counted[start:], expected[start:]
        axes.plot(x, 100 * counted, color=colour, label=name)
        axes.plot(x, 100 * expected, color=colour, ls=DASHED, lw=1.2)
    axes.axhline(98, color=GREY, lw=1.0)
    axes.text(1.01, 98, "98 %", transform=axes.get_yaxis_transform(), va="center", color=GREY)
    axes.set(xlabel=by, ylabel="coverage [%]", ylim=(0, 103))
    if log:
        axes.set(xscale="log", xlim=(min(x[1] for _, x, _, _ in curves), max(x[-1] for _, x, _, _ in curves)))
        axes.xaxis.set_major_formatter("{x:g}")
    else:
        axes.set_xlim(0, max(x[-1] for _, x, _, _ in curves))
    place = {"loc": "lower right"} if by.endswith("[s]") else {"loc": "upper left", "bbox_to_anchor": (0.01, 0.93)}
    axes.legend(fontsize=9, title="Avrami dashed", title_fontsize=9, frameon=True, edgecolor="none", framealpha=0.85, **place)


def time_panel(axes, points: Sequence[Point], x: Quantity) -> None:
    """Time to 98 % against an axis, both logarithmic, beside Avrami's two forms."""
    at = [x.of(p) for p in points]
    _bars(axes, at, [p.value(TIME_98) for p in points], 1.0, BLUE, "o", "counted")
    known = ((RATE_FORM, ORANGE, DASHED, "(2.1), from the impacts"), (FLOW_FORM, GREEN, DOTTED, "(2.2), from the mass flow"))
    for column, colour, line, label in known:
        axes.plot(at, [p.mean(column) for p in points], color=colour, ls=line, label=label)
    axes.set(xscale="log", yscale="log", xlabel=x.title(), ylabel="time to 98 % [s]")
    plain_log(axes, at)
    axes.legend(fontsize=9)


def deviation_panel(axes, studies: dict[str, Sequence[Point]]) -> None:
    """How much later than undisturbed shots (2.2) the stream covers 98 %, against the collision number; a mark a study."""
    for (name, points), colour, mark in zip(studies.items(), (BLUE, RED, GREEN, ORANGE), "osD^", strict=False):
        found = [(p.mean(COLLISIONS), late(p)) for p in points]
        known = [(pi, value) for pi, value in found if value]
        _bars(axes, [pi for pi, _ in known], [value for _, value in known], 100.0, colour, mark, name)
    axes.axhline(0, color="#404040", lw=1.0)
    axes.set(xscale="log", xlabel="collision number", ylabel="time to 98 % above (2.2) [%]")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("")
    if len(studies) > 1:
        axes.legend(fontsize=9)


def late(point: Point) -> Value | None:
    """Time to 98 % over that of shots that meet no other, less one: mean and scatter over the replicates."""
    counted, undisturbed = point.each(TIME_98), point.each(UNDISTURBED)
    if counted is None or undisturbed is None:
        return None
    off = np.array(counted) / np.array(undisturbed) - 1.0
    return Value(float(off.mean()), float(off.std(ddof=1)) if off.size > 1 else math.nan, off.size)


def passes_panel(axes, points: Sequence[Point]) -> None:
    """Passes to 98 % against feed speed: counted where it was reached, else carried on from the hits so far; Avrami's."""
    for carried, colour, mark, label in ((False, BLUE, "o", "counted"), (True, ORANGE, "s", "carried on by hits")):
        some = [(FEED.of(p), passes_to_full(p)) for p in points if (p.each(TIME_98) is None) == carried]
        if some:
            _bars(axes, [x for x, _ in some], [v for _, v in some], 1.0, colour, mark, label)
    by_flow = sorted((FEED.of(p), passes_of(p, "coverage.avrami_mass_flow_final")) for p in points if p.mean(PASSES.column) == 4)
    axes.plot([x for x, _ in by_flow], [n for _, n in by_flow], color=GREEN, ls=DOTTED, label="(2.2), from the mass flow")
    axes.set(xscale="log", yscale="log", xlabel=FEED.title(), ylabel="passes to 98 %")
    plain_log(axes, [x for x, _ in by_flow])
    axes.legend(fontsize=9)


def passes_of(point: Point, column: str) -> float:
    """Passes to 98 % by the mean coverage in ``column`` at the end: hits add up, ln 50 of them are needed."""
    return FULL * point.mean(PASSES.column) / -math.log1p(-point.mean(column))


def passes_to_full(point: Point) -> Value:
    """Passes to 98 %: mean and scatter over the replicates.

    Where all reached it, the number of the pass that did; else carried on from the coverage at the end,
    C = 1 - exp(-hits), by hits in proportion to passes.
    """
    number, reached = point.mean(PASSES.column), point.each(TIME_98)
    if reached is not None:
        each = [math.ceil(number * time / all_s) for time, all_s in zip(reached, _exposures(point), strict=True)]
    else:
        most = 1.0 - 1e-6  # some replicates may be full, others not
        each = [FULL * number / -math.log1p(-min(final, most)) for final in point.each("coverage.final")]
    return Value(float(np.mean(each)), float(np.std(each, ddof=1)) if len(each) > 1 else math.nan, len(each))


def _exposures(point: Point) -> list[float]:
    """Exposure times of replicates that reached 98 %: full coverage counts on by time."""
    return [0.01 * percent * time for percent, time in zip(point.each("coverage.percent"), point.each(TIME_98), strict=True)]


def value_panel(
    axes, points: Sequence[Point], x: Quantity, shown: Sequence[Quantity], *, log_x: bool = False, title: str = ""
) -> None:
    """One or two quantities against another, from zero up (stresses down)."""
    at = [x.of(p) for p in points]
    for quantity, colour, mark, line in zip(shown, (BLUE, RED), "os", ("-", DASHED), strict=False):
        _bars(axes, at, [p.value(quantity.column) for p in points], quantity.factor, colour, mark, quantity.label, line)
    axes.set(xlabel=x.title(), ylabel=shown[0].title() if len(shown) == 1 else f"stress [{shown[0].unit}]", title=title)
    if log_x:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    low, high = axes.get_ylim()
    axes.set_ylim((1.05 * low, 0.0) if high <= 0.0 or low < 0.0 else (0.0, 1.05 * high))
    if len(shown) > 1:
        axes.legend(fontsize=9)


def exponent_text(points: Sequence[Point], x: str, y: str, symbol: str = "x") -> str:
    """"x^-0.95 ± 0.02" of the power law through all runs; empty where there is none."""
    try:
        found = power(points, x, y)
    except InputError:
        return ""
    return f"{symbol}^({found.exponent:.2f} ± {found.standard_error:.2f})".replace("-", "−")


def plain_log(axes, at: Sequence[float]) -> None:
    """Ticks of a logarithmic x axis at the study's own values; plain numbers on both."""
    from matplotlib.ticker import FixedLocator, NullLocator

    axes.xaxis.set_major_locator(FixedLocator(sorted(set(at))))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter("{x:g}")
    low, high = axes.get_ylim()
    axes.yaxis.set_minor_formatter("{x:g}" if math.log10(high / low) < 1.3 else "")
    axes.tick_params(axis="y", which="minor", labelsize=9)


def _bars(axes, x, values: Sequence[Value | None], factor: float, colour: str, mark: str, label: str, line="") -> None:
    known = [(a, v) for a, v in zip(x, values, strict=True) if v is not None]
    sd = [0.0 if math.isnan(v.sd) else abs(factor) * v.sd for _, v in known]
    axes.errorbar(
        [a for a, _ in known], [factor * v.mean for _, v in known], yerr=sd, color=colour, fmt=mark, ls=line or "none", ms=6.5,
        mec="white", capsize=3, elinewidth=1.4, lw=1.6, label=label, zorder=4,
    )  # fmt: skip


def relative_panel(axes, studies: dict[Quantity, Sequence[Point]]) -> None:
    """Time to 98 % over that at 60 m/s, 1 mm, 90 degrees, against the axis over its value there: power laws are straight."""
    own = {SPEED.column: 60.0, DIAMETER.column: 1.0, ANGLE.column: 90.0}
    for (x, points), colour, mark in zip(studies.items(), (RED, GREEN, BLUE), "sDo", strict=False):
        known = [p for p in points if p.value(TIME_98)]
        base = min(known, key=lambda p: abs(x.of(p) - own[x.column]))
        ratio = [(math.sin(math.radians(x.of(p))) if x is ANGLE else x.of(p) / x.of(base)) for p in known]
        scale = base.mean(TIME_98)
        label = f"{x.label}{' (its sine)' if x is ANGLE else ''}"
        _bars(axes, ratio, [p.value(TIME_98) for p in known], 1.0 / scale, colour, mark, label)
        axes.plot(ratio, [p.mean(FLOW_FORM) / base.mean(FLOW_FORM) for p in known], color=colour, ls=DASHED, lw=1.2)
    axes.set(xscale="log", yscale="log", xlabel="value / value at 60 m/s, 1 mm, 90°", ylabel="time / time there")
    plain_log(axes, (0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.4))
    axes.legend(fontsize=9, title="(2.2) dashed", title_fontsize=9)


def depth_panel(axes, studies: dict[Quantity, Sequence[Point]]) -> None:
    """Depth of the compression and Sa over those at 60 m/s and 1 mm, against speed and diameter over theirs."""
    own = {SPEED.column: 60.0, DIAMETER.column: 1.0}
    for (x, points), colour in zip(studies.items(), (RED, GREEN), strict=False):
        base = min(points, key=lambda p: abs(x.of(p) - own[x.column]))
        at = [x.of(p) / x.of(base) for p in points]
        for q, mark, line, word in ((TENTH, "o", "-", "depth"), (SA, "s", DASHED, "Sa")):
            scale, label = 1.0 / base.mean(q.column), f"{word} by {x.label}"
            _bars(axes, at, [p.value(q.column) for p in points], scale, colour, mark, label, line)
    axes.set(xscale="log", yscale="log", xlabel="value / value at 60 m/s, 1 mm", ylabel="result / result there")
    plain_log(axes, (0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.4))
    axes.legend(fontsize=9)
