"""Figures and summary of the shipped studies, from their tables and the runs' coverage curves alone.

    python -m glue.report.study_figures build/studies [--docs docs/studies.png]

reads the folders named like the studies, draws ``<study>.png`` beside each and writes ``summary.md``.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.errors import PeenError
from glue.report import study_panels as panels
from glue.report.figures import styled_figure
from glue.report.study_panels import Quantity
from glue.study.sweep.points import Point, Value, mean_curve, read_points

# What each study varies; the first five are about coverage, the others about stress and roughness.
COVERAGE = {
    "coverage-mass-flow": panels.MASS_FLOW, "coverage-speed": panels.SPEED, "coverage-diameter": panels.DIAMETER,
    "coverage-angle": panels.ANGLE, "coverage-feed": panels.FEED,
}  # fmt: skip
STRESS = {
    "stress-coverage": panels.PERCENT, "stress-speed": panels.SPEED, "stress-diameter": panels.DIAMETER,
    "stress-shots": panels.IMPACTS,
}  # fmt: skip
STUDIES = COVERAGE | STRESS
_LOG_TIME = ("coverage-mass-flow",)
_LOG_X = ("stress-shots",)
_COLLIDING = ("coverage-mass-flow",)  # over a wide range of the collision number
_MEASURED_X = ("stress-coverage", "stress-shots")  # their axis is a result of the runs
SINE = "sine of the angle"


def draw_study(name: str, folder: Path, path: Path) -> Path:
    """The figure of the study ``name`` whose results are in ``folder``.  Raises InputError for tables that cannot be read."""
    points, x = read_points(folder), STUDIES[name]
    if name in STRESS:
        with styled_figure(path, (13.0, 4.2)) as figure:
            left, middle, right = figure.subplots(1, 3)
            log = name in _LOG_X
            panels.value_panel(left, points, x, (panels.LARGEST, panels.SURFACE), log_x=log, title="Residual stress")
            panels.value_panel(middle, points, x, (panels.TENTH,), log_x=log, title="How deep it reaches")
            panels.value_panel(right, points, x, (panels.SA,), log_x=log, title="Roughness")
        return path
    width = 17.0 if name in _COLLIDING else 12.0
    with styled_figure(path, (width, 4.6)) as figure:
        left, right, *others = figure.subplots(1, 3 if name in _COLLIDING else 2)
        if name == "coverage-feed":
            panels.curves_panel(left, pass_curves(folder, points), by="passes")
            left.set_title("Coverage, mean over replicates")
            panels.passes_panel(right, points)
            right.set_title("Passes to 98 %")
            return path
        panels.curves_panel(left, time_curves(folder, points, x), log=name in _LOG_TIME)
        left.set_title("Coverage, mean over replicates")
        panels.time_panel(right, points, x)
        right.set_title(_exponent_title(name, points, x))
        for axes in others:
            panels.deviation_panel(axes, {x.label: points})
            axes.set_title("Later than shots that meet no other")
    return path


def time_curves(folder: Path, points: Sequence[Point], x: Quantity) -> list[tuple]:
    """(name, time [s], coverage, Avrami's) of each point, for ``curves_panel``."""
    return [(x.word(p), *mean_curve(folder, p)) for p in points]


def pass_curves(folder: Path, points: Sequence[Point]) -> list[tuple]:
    """The same over passes, of the points with the number of passes that most of them have, slowest feed first."""
    numbers = [p.mean(panels.PASSES.column) for p in points]
    usual = max(numbers, key=numbers.count)
    curves = []
    for p in sorted((p for p in points if p.mean(panels.PASSES.column) == usual), key=panels.FEED.of):
        times, *coverages = mean_curve(folder, p)
        curves.append((panels.FEED.word(p), usual * times / times[-1], *coverages))
    return curves


def draw_overview(folder: Path, path: Path) -> Path:
    """One figure of all studies under ``folder``: curves, times against axes, deviation, stress and roughness."""
    found = {name: read_points(folder / name) for name in STUDIES}
    with styled_figure(path, (16.0, 9.0)) as figure:
        grid = figure.subplots(2, 3)
        flow_name = "coverage-mass-flow"
        flow = found[flow_name]
        panels.curves_panel(grid[0, 0], time_curves(folder / flow_name, flow, panels.MASS_FLOW), log=True)
        grid[0, 0].set_title("Coverage for five mass flows")
        panels.time_panel(grid[0, 1], flow, panels.MASS_FLOW)
        grid[0, 1].set_title("Time to 98 %: shots that meet take longer")
        normal = ("coverage-mass-flow", "coverage-speed", "coverage-diameter")  # jets straight down
        panels.deviation_panel(grid[0, 2], {COVERAGE[name].label: found[name] for name in normal})
        grid[0, 2].set_title("Later than shots that meet no other")
        one_flow = ("coverage-speed", "coverage-diameter", "coverage-angle")
        panels.relative_panel(grid[1, 0], {COVERAGE[name]: found[name] for name in one_flow})
        grid[1, 0].set_title("Time to 98 % against speed, diameter, angle")
        panels.value_panel(grid[1, 1], found["stress-coverage"], panels.PERCENT, (panels.LARGEST, panels.SURFACE))
        grid[1, 1].set_title("Residual stress against coverage")
        panels.depth_panel(grid[1, 2], {STRESS[name]: found[name] for name in ("stress-speed", "stress-diameter")})
        grid[1, 2].set_title("Depth and roughness against speed, diameter")
    return path


def summary(found: dict[str, Sequence[Point]]) -> str:
    """Markdown: a table for each study, a row for each point; quantities that a study has not are left out."""
    how = "Means over replicates, ± the standard deviation of one run. 100 % is the time to 98 %, 200 % twice that."
    parts = ["# The shipped studies", "", how]
    for name, points in found.items():
        columns = _columns(name, points)
        head, rule = " | ".join(title for title, _ in columns), "|---" + "|---:" * (len(columns) - 1) + "|"
        parts += ["", f"## {name}", "", f"| {head} |", rule]
        parts += ["| " + " | ".join(cells[k] for _, cells in columns) + " |" for k in range(len(points))]
    return "\n".join(parts) + "\n"


def _columns(name: str, points: Sequence[Point]) -> list[tuple[str, list[str]]]:
    """(title, cells) of the columns that have a value at any point."""
    x = STUDIES[name]
    first = [x.word(p) if name not in _MEASURED_X else f"{x.of(p):.0f} {x.unit}".strip() for p in points]
    columns = [(x.label, first)]
    if name == "coverage-feed":
        columns.append((panels.PASSES.label, [f"{panels.PASSES.of(p):g}" for p in points]))
        columns.append(("passes to 98 %", [_with_sd(panels.passes_to_full(p), 1) for p in points]))
    twice = [None if (v := p.value(panels.TIME_98)) is None else Value(2 * v.mean, math.nan, v.number) for p in points]
    columns += [
        ("coverage at the end, %", [_with_sd(p.value("coverage.final"), 1, 100) for p in points]),
        ("t98 = 100 %, s", [_with_sd(p.value(panels.TIME_98), 2) for p in points]),
        ("200 %, s", [_with_sd(v, 2) for v in twice]),
        ("Avrami (2.1), s", [_with_sd(p.value(panels.RATE_FORM), 2, sd=False) for p in points]),
        ("Avrami (2.2), s", [_with_sd(p.value(panels.FLOW_FORM), 2, sd=False) for p in points]),
        ("undisturbed, s", [_with_sd(p.value(panels.UNDISTURBED), 2, sd=False) for p in points]),
        ("collision number", [_with_sd(p.value(panels.COLLISIONS), 3, sd=False) for p in points]),
    ]
    for q, digits in ((panels.LARGEST, 0), (panels.SURFACE, 0), (panels.TENTH, 0), (panels.SA, 2)):
        columns.append((f"{q.label}, {q.unit}", [_with_sd(p.value(q.column), digits, q.factor) for p in points]))
    return columns[:1] + [column for column in columns[1:] if any(column[1])]


def _with_sd(value: Value | None, digits: int, factor: float = 1.0, sd: bool = True) -> str:
    if value is None:
        return ""
    text = f"{factor * value.mean:.{digits}f}"
    if sd and not math.isnan(value.sd):
        text += f" ± {abs(factor) * value.sd:.{digits}f}"
    return text.replace("-", "−")


def _exponent_title(name: str, points: Sequence[Point], x: Quantity) -> str:
    if name == "coverage-mass-flow":
        return "Time to 98 %"
    if name == "coverage-angle":
        return f"Time to 98 %: {panels.exponent_text(with_sines(points), SINE, panels.TIME_98, 'sin(angle)')}"
    return f"Time to 98 %: {panels.exponent_text(points, x.column, panels.TIME_98, x.label.split()[-1])}"


def with_sines(points: Sequence[Point]) -> list[Point]:
    """The points with a column SINE of their impact angle."""
    angle = panels.ANGLE.column
    return [Point(p.names, p.columns | {SINE: tuple(math.sin(math.radians(a)) for a in p.columns[angle])}) for p in points]


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="holds a folder for each study, by peen sweep STUDY --out FOLDER/STUDY")
    parser.add_argument("--docs", type=Path, metavar="PNG", help="also draw the one figure of all studies")
    args = parser.parse_args(arguments)
    try:
        there = [name for name in STUDIES if (args.folder / name / "table.csv").exists()]
        for name in there:
            print(draw_study(name, args.folder / name, args.folder / f"{name}.png"))
        write_text_atomic(args.folder / "summary.md", summary({name: read_points(args.folder / name) for name in there}))
        print(args.folder / "summary.md")
        if args.docs:
            print(draw_overview(args.folder, args.docs))
    except PeenError as problem:
        print(problem, file=sys.stderr)
        return problem.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
