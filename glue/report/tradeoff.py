"""The measured trade of speed against accuracy as Markdown, CSV and one plot per quantity."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

from glue.study.tradeoff.errors import bound
from glue.study.tradeoff.ladder import STAGES
from glue.study.tradeoff.quantities import BY_NAME, QUANTITIES

_STAGE_COLOURS = {
    "dimple": "#0072b2", "flow": "#d55e00", "coverage": "#009e73", "target": "#cc79a7", "surface": "#e69f00",
    "whole": "#1d1d1d",
}  # fmt: skip
_FEWEST_POINTS = 4
Points = list[tuple[dict, float, float]]  # (row, cost [s], error bound)


def csv_text(table: dict) -> str:
    """A line for each scene, rung and quantity, errors relative (see quantities.py) and as they are."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(
        ("scene", "group", "stage", "factor", "level", "physics", "seeds", "wall_s", "cpu_s", "peak_memory_MB",
         "quantity", "value", "error", "standard_error", "hidden_by_scatter", "scatter_of_one_run", "failed")
    )  # fmt: skip
    for scene, entry in table["scenes"].items():
        for row in entry["rows"]:
            memory = "" if row["memory_bytes"] is None else f"{row['memory_bytes'] / 1e6:.0f}"
            head = (scene, row["group"], row["stage"], row["factor"], row["level"], int(row["physics"]), row["seeds"],
                    _number(row["wall_s"]), _number(row["cpu_s"]), memory)  # fmt: skip
            if row["failed"] and not row["quantities"]:
                writer.writerow((*head, "", "", "", "", "", "", row["failed"].replace("\n", " ")))
            for name, found in row["quantities"].items():
                numbers = [_number(found[key]) for key in ("value", "error", "se")]
                writer.writerow((*head, name, *numbers, int(found["hidden"]), _number(found["scatter"]), ""))
    return out.getvalue()


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def markdown(table: dict, scene: str) -> str:
    """The ladder of one scene: a row a rung, a column a quantity that any rung moves."""
    rows = table["scenes"][scene]["rows"]
    shown = [q for q in QUANTITIES if any(r["quantities"].get(q.name, {}).get("error") is not None for r in rows)]
    lines = [
        "| | time, s | MB | " + " | ".join(q.label for q in shown) + " |",
        "|---|---:|---:|" + "---:|" * len(shown),
    ]
    for row in rows:
        if row["factor"] == "reference":
            title = f"**{row['group']}: reference** ({row['seeds']} seeds)"
            cells = [_value(row, q) for q in shown]
        else:
            title = f"{row['factor']} {row['level']}" + (" (added)" if row["physics"] else "")
            cells = [_error(row, q) if _bears(row, q) else "" for q in shown]
        if row["failed"]:
            title += " **failed**"
        cost = "–" if row["cpu_s"] is None else f"{row['cpu_s']:.3g}"
        memory = "–" if row["memory_bytes"] is None else f"{row['memory_bytes'] / 1e6:.0f}"
        lines.append(_line([title, cost, memory, *cells]))
    return "\n".join(lines)


def _line(cells: list[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _error(row: dict, q) -> str:
    return error_text(row["quantities"].get(q.name), q.scale == "one")


def _value(row: dict, q) -> str:
    found = row["quantities"].get(q.name)
    return "" if found is None else f"{found['value'] * q.factor:.{q.digits}f} {q.unit}".strip().replace("-", "−")


def _bears(row: dict, q) -> bool:
    """Can the stage that the row judges change the quantity at all?"""
    if row["stage"] == "seeds":
        return q.stage != "dimple"
    return row["stage"] == "whole" or STAGES.index(q.stage) >= STAGES.index(row["stage"])


def error_text(found: dict | None, points: bool = False) -> str:
    """"+1.2 %", or "< 0.8 %" of one that scatter hides; ``points``: in hundredths of the quantity itself (coverage)."""
    if found is None or found["error"] is None:
        return ""
    unit = " pt" if points else " %"
    if found["hidden"]:
        return f"< {100 * bound(found):.2g}{unit}"
    return f"{100 * found['error']:+.2g}{unit}".replace("-", "−")


def scatter_markdown(scatter: dict) -> str:
    """What chance alone does to one run, by quantity."""
    lines = ["| quantity | mean | one run scatters by | seeds |", "|---|---:|---:|---:|"]
    for name, found in scatter.items():
        q = BY_NAME[name]
        if found["sd"] == 0.0:
            continue
        unit = "pt" if q.scale == "one" else "%"
        value = f"{found['value'] * q.factor:.{q.digits}f} {q.unit}".strip().replace("-", "−")
        lines.append(f"| {q.label} | {value} | {100 * found['sd']:.2g} {unit} | {found['seeds']} |")
    return "\n".join(lines)


def presets_markdown(table: dict) -> str:
    """Whole presets: cost and error on every scene measured."""
    names = [q for q in QUANTITIES if q.headline]
    head = ["scene", "preset", "time, s", "MB", *(q.label for q in names)]
    lines = [_line(head), "|---|---|---:|---:|" + "---:|" * len(names)]
    for scene, entry in table["scenes"].items():
        for row in entry["rows"]:
            if row["factor"] == "preset" and row["cpu_s"] is not None:
                cost = [f"{row['cpu_s']:.0f}", f"{row['memory_bytes'] / 1e6:.0f}"]
                lines.append(_line([scene, row["level"], *cost, *(_error(row, q) for q in names)]))
    return "\n".join(lines)


def write_report(table: dict, out: Path) -> list[Path]:
    """``tradeoff.csv``, ``tradeoff.md`` and a plot per quantity and scene into ``out``; the files."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "tradeoff.csv").write_text(csv_text(table), encoding="utf-8")
    parts = ["# Speed against accuracy, measured", "", _heading(table), "", "## Presets", "", presets_markdown(table)]
    for scene, entry in table["scenes"].items():
        parts += ["", f"## {scene}", "", markdown(table, scene), ""]
        parts += ["The cheapest that keeps a promised error, stage by stage:", ""]
        parts += [f"- {share}: {what}" for share, what in entry.get("recommended", {}).items()]
        chances = {"Chance alone": entry["scatter"]} | {f"Chance alone, {g}": s for g, s in entry["patches"].items()}
        for title, scatter in chances.items():
            parts += ["", f"{title}:", "", scatter_markdown(scatter)]
    (out / "tradeoff.md").write_text("\n".join(parts) + "\n", encoding="utf-8")
    files = [out / "tradeoff.csv", out / "tradeoff.md"]
    for scene in table["scenes"]:
        plotted = [q for q in QUANTITIES if len(points_of(table, scene, q.name)) >= _FEWEST_POINTS]
        files += [pareto_plot(table, scene, q, out) for q in plotted]
    return files


def _heading(table: dict) -> str:
    p = table["provenance"]
    return (
        f"Measured {p['date']} on {p['machine']} ({p['cores']} cores, load {p['load_1_min']:.1f}) by `{p['command']}`."
        " Times are processor seconds of the stage that is judged (of all stages for presets and seeds)."
        " An error is the mean difference from the group's reference with the same seeds;"
        " “<” marks one that scatter hides, with the bound that is known."
        " Rungs marked (added) add physics that the reference has not: what they show is its effect."
        + (f" Note: {p['note']}." if "note" in p else "")
    )


def points_of(table: dict, scene: str, quantity: str) -> Points:
    """The rungs that say something about ``quantity``, zero errors left out."""
    found = []
    for row in table["scenes"][scene]["rows"]:
        told = row["quantities"].get(quantity)
        if told is None or told["error"] is None or row["physics"] or row["cpu_s"] is None or row["group"] == "block":
            continue
        if row["stage"] not in ("whole", BY_NAME[quantity].stage):
            continue
        if (size := bound(told)) and size > 0.0:
            found.append((row, row["cpu_s"], size))
    return found


def named(points: Points, edge: Points) -> Points:
    """The points that get their name in a plot: front, presets, and others whose names do not run into each other."""
    if len(points) < 2:
        return points
    (x0, x1), (y0, y1) = ((min(v), max(v)) for v in ([math.log(p[k]) for p in points] for k in (1, 2)))

    def near(a, b) -> bool:
        dx, dy = abs(math.log(a[1] / b[1])) / max(x1 - x0, 1e-9), abs(math.log(a[2] / b[2])) / max(y1 - y0, 1e-9)
        return dx < 0.35 and dy < 0.06

    found = [p for p in points if p in edge or p[0]["stage"] == "whole"]
    for point in points:
        if point not in found and not any(near(point, other) for other in found):
            found.append(point)
    return found


def _decades(axis) -> float:
    low, high = axis.get_data_interval()
    return math.log10(high / low)


def one_run_scatters(table: dict, scene: str, quantity: str) -> float | None:
    """Standard deviation over seeds of one run at the scene's own window, or of one patch of the cell.

    None: unknown, or none.
    """
    entry = table["scenes"][scene]
    of_patches = (p[quantity] for p in entry["patches"].values() if quantity in p)
    found = entry["scatter"].get(quantity) or next(of_patches, None)
    return found["sd"] if found and found["sd"] > 0.0 else None


def front(points: Points) -> Points:
    """Those that no other beats in both cost and error, by rising cost."""
    best, kept = float("inf"), []
    for point in sorted(points, key=lambda p: (p[1], p[2])):
        if point[2] < best:
            best = point[2]
            kept.append(point)
    return kept


def pareto_plot(table: dict, scene: str, q, out: Path) -> Path:
    """Error against cost of the rungs that bear on ``q``; the front is joined up, hidden errors are hollow."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    points = points_of(table, scene, q.name)
    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for stage, colour in _STAGE_COLOURS.items():
        mine = [p for p in points if p[0]["stage"] == stage]
        for hidden in (False, True):
            some = [p for p in mine if p[0]["quantities"][q.name]["hidden"] == hidden]
            if some:
                label = "whole preset" if stage == "whole" else f"one factor of {stage}"
                label += ", bound only" if hidden else ""
                axes.scatter([p[1] for p in some], [100 * p[2] for p in some], s=38, zorder=3, edgecolors=colour,
                             linewidths=1.4, facecolors="none" if hidden else colour, label=label)  # fmt: skip
    edge = front(points)
    axes.plot([p[1] for p in edge], [100 * p[2] for p in edge], color="#8a8a8a", lw=1, zorder=1)
    middle = math.sqrt(min(p[1] for p in points) * max(p[1] for p in points))
    best = [p[0] for p in edge]
    for row, cost, size in named(points, edge):
        up = -10 if row in best else 6
        side = "right" if cost > middle else "left"  # towards the middle, so that no label runs out of the picture
        axes.annotate(f"{row['factor']} {row['level']}", (cost, 100 * size), xytext=(-5 if side == "right" else 5, up),
                      ha=side, textcoords="offset points", fontsize=7, color="#444")  # fmt: skip
    if scatter := one_run_scatters(table, scene, q.name):
        label = "standard deviation of one run over seeds"
        axes.axhline(100 * scatter, color="#8a8a8a", ls="--", lw=1, zorder=1, label=label)
    axes.set(xscale="log", yscale="log", xlabel="processor time [s]", title=f"{scene}: {q.label}",
             ylabel="error [points]" if q.scale == "one" else "error [%]")  # fmt: skip
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("{x:g}" if _decades(axis) < 1.5 else "")
        axis.set_tick_params(which="both", labelsize=8)
    axes.margins(0.18)
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8, frameon=False, loc="best")
    file = out / f"{scene}-{q.name}.png"
    figure.savefig(file, dpi=130)
    return file
