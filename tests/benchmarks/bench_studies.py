"""Do the shipped studies show the trends that they are there to show?  From their tables in build/studies.

    python tests/benchmarks/bench_studies.py [--json FILE]

Expected exponents follow from counting dimples: t98 = ln 50 S / (n pi a^2), n = mdot / (rho pi d^3/6) shots a second on
the jet's footprint S, and dimples of radius a ~ d v^p, where p is that of the single impacts that the studies solved.
A fitted exponent may be off by three of its own standard errors (chance), plus COLLISIONS: these studies run at
collision numbers of .004 to .011, where shots that meet cost below 1 % of the time (15 % at .22, make bench-trends, in
proportion), so that over an axis they move an exponent by less than that.
"""

from __future__ import annotations

import math

import numpy as np

from glue.checkrows import Rows
from glue.report import study_panels as panels
from glue.report.study_figures import SINE, with_sines
from glue.solvers import repo_root
from glue.study.sweep.points import Point, Power, power, read_points

FOLDER = repo_root() / "build" / "studies"
COLLISIONS = 0.01
T98, HITS = panels.TIME_98, "hits"
RADIUS, RADIUS_SPEED = "dimple.radius_m", "dimple.speed_m_s"
# Length over width of oblique dimples at 90, 45 and 30 degrees, see glue.surface.coverage.dimple_semi_axes
STRETCH = ((0.5, 1.15), (math.sqrt(0.5), 1.07), (1.0, 1.0))


def main() -> None:
    rows = Rows("Trends of the shipped studies")
    mass_flow(rows)
    p = speed(rows)
    diameter(rows)
    angle(rows, p)
    feed(rows)
    stress_by_coverage(rows)
    stress_by_shots(rows)
    stress_by_diameter(rows)
    stress_by_speed(rows, p)
    rows.finish()


def mass_flow(rows: Rows) -> None:
    """Dilute: t98 ~ 1/mdot.  Dense: shots that meet strike softly or elsewhere, so it falls more slowly."""
    points = _reached(rows, "coverage-mass-flow")
    flow = panels.MASS_FLOW.column
    _exponent(rows, "t98 against mass flow, two leanest", power(points[:2], flow, T98), -1.0, 0.02)
    dense = power(points[-2:], flow, T98)
    rows.true("t98 against mass flow, two densest: sub-linear", dense.exponent - dense.standard_error > -1.0, _told(dense))
    late = [panels.late(point) for point in points]
    most, error = late[-1], late[-1].standard_error
    rows.true("densest: later than shots that meet no other", most.mean > 3.0 * error, f"{most.mean:+.1%} ± {error:.1%}")
    told = ", ".join(f"{value.mean:+.1%}" for value in late)
    rows.true("lateness greatest where the collision number is", max(late, key=lambda v: v.mean) is most, told)


def speed(rows: Rows) -> float:
    """t98 ~ 1/a^2 ~ v^-2p at a fixed mass flow; returns p of the single impacts."""
    points = _reached(rows, "coverage-speed")
    p = power(points, RADIUS_SPEED, RADIUS).exponent
    rows.within("dimple radius against speed: Kirk's and the rate's range", p, 0.46, 0.04, "0.42 to 0.5")
    _exponent(rows, "t98 against speed: -2 p", power(points, panels.SPEED.column, T98), -2.0 * p, COLLISIONS)
    return p


def diameter(rows: Rows) -> None:
    """t98 ~ d^3/d^2: a kilogram has 1/d^3 shots, each covers d^2."""
    found = power(_reached(rows, "coverage-diameter"), panels.DIAMETER.column, T98)
    _exponent(rows, "t98 against diameter: 3 - 2", found, 1.0, COLLISIONS)


def angle(rows: Rows, p: float) -> None:
    """Fixed jet: footprint ~ 1/sin, dimple area ~ (v sin)^2p times its lengthening by friction."""
    points = with_sines(_reached(rows, "coverage-angle"))
    sines = np.array([point.mean(SINE) for point in points])
    expected = sines ** -(1.0 + 2.0 * p) / np.interp(sines, *zip(*STRETCH, strict=True))
    slope = float(np.polyfit(np.log(sines), np.log(expected), 1)[0])
    found = power(points, SINE, T98)
    note = f"1 + 2 p = {1 + 2 * p:.2f}, less the dimples' lengthening"
    _exponent(rows, "t98 against sin(angle), fixed jet", found, slope, COLLISIONS, note)
    rows.true("steeper than 1/sin, that of a fixed peened area", found.exponent + 3.0 * found.standard_error < -1.0, _told(found))


def feed(rows: Rows) -> None:
    """Hits per point ~ passes / feed speed, so passes to 98 % ~ feed speed."""
    points = [_with_hits(point) for point in read_points(FOLDER / "coverage-feed")]
    at_four = [point for point in points if point.mean(panels.PASSES.column) == 4]
    _exponent(rows, "hits of four passes against feed speed", power(at_four, panels.FEED.column, HITS), -1.0, COLLISIONS)
    full = [point for point in points if point.each(T98) is not None]
    rows.true("98 % is reached within the passes made", bool(full), f"{len(full)} points")
    slowest_feed = min(p.mean(panels.FEED.column) for p in full) if full else math.nan
    at_one_feed = [p for p in points if p.mean(panels.FEED.column) == 0.016 and p.each(T98) is None]
    _exponent(rows, "hits against passes at one feed speed", power(at_one_feed, panels.PASSES.column, HITS), 1.0, COLLISIONS)
    for point in (p for p in full if p.mean(panels.FEED.column) == slowest_feed):
        carried = float(np.mean([panels.passes_to_full(p).mean for p in at_one_feed]))
        # the pass that completes 98 % is the next whole one, on average half a pass later
        number = panels.passes_to_full(point).mean
        rows.within("pass that reaches 98 %, carried on from fewer", number, carried + 0.5, 0.15 * carried)


def stress_by_coverage(rows: Rows) -> None:
    points = read_points(FOLDER / "stress-coverage")
    largest = [-panels.LARGEST.of(point) for point in points]
    told = f"{[round(panels.PERCENT.of(p)) for p in points]} %"
    rows.true("100 % and 200 % are among the exposures", _has(points, 100.0) and _has(points, 200.0), told)
    change, told = abs(largest[-1] / largest[-2] - 1.0), f"{[round(v) for v in largest]} MPa"
    rows.below("largest stress, change from 100 % to 200 %", change, 0.1, told)
    rows.true("the last doubling adds less than the first", largest[-1] - largest[-2] < largest[1] - largest[0], told)
    rough = [panels.SA.of(point) for point in points]
    told = f"{rough[-2]:.2f} to {rough[-1]:.2f} um"
    rows.below("Sa, change from 100 % to 200 %", abs(rough[-1] / rough[-2] - 1.0), 0.15, told)


def stress_by_shots(rows: Rows) -> None:
    """Few impacts add up, what many leave is bounded: both are in the layer model's equations (5) and (9), at exposures
    below those of its calibration.  What is looked at is that counts, sizes and the part's balance do not spoil it."""
    points = read_points(FOLDER / "stress-shots")
    few, many = (power(some, panels.IMPACTS.column, panels.LARGEST.column) for some in (points[:2], points[-2:]))
    _exponent(rows, "largest stress against number of shots, few (built in)", few, 1.0, 0.1)
    rows.true("and grows less with many", many.exponent + many.standard_error < few.exponent, _told(many))


def stress_by_diameter(rows: Rows) -> None:
    """Similarity: at one speed lengths are in proportion to the diameter.  The layer model has it built in; what is looked at
    is that collisions, counts and the stamp do not spoil it."""
    points, d = read_points(FOLDER / "stress-diameter"), panels.DIAMETER.column
    _exponent(rows, "depth of a tenth against diameter", power(points, d, panels.TENTH.column), 1.0, 0.05)
    _exponent(rows, "largest stress against diameter", power(points, d, panels.LARGEST.column), 0.0, 0.05)
    _exponent(rows, "Sa against diameter", power(points, d, panels.SA.column), 1.0, 0.05)


def stress_by_speed(rows: Rows, p: float) -> None:
    """The plastic zone goes with the dimple's radius, v^p; its depth a^2/d, and Sa with it, as v^2p."""
    points, v = read_points(FOLDER / "stress-speed"), panels.SPEED.column
    _exponent(rows, "depth of a tenth against speed: p", power(points, v, panels.TENTH.column), p, 0.1)
    _exponent(rows, "Sa against speed: 2 p", power(points, v, panels.SA.column), 2.0 * p, 0.2)


def _reached(rows: Rows, name: str) -> list[Point]:
    """The study's points, each of which must have reached 98 %."""
    points = read_points(FOLDER / name)
    known = [point for point in points if point.each(T98) is not None]
    rows.true(f"{name}: every run reaches 98 %", len(known) == len(points), f"{len(known)} of {len(points)} points")
    return known


def _with_hits(point: Point) -> Point:
    """With a column of hits per point, from the coverage at the end."""
    hits = tuple(-math.log1p(-min(c, 1.0 - 1e-6)) for c in point.columns["coverage.final"])  # a window may be full
    return Point(point.names, point.columns | {HITS: hits})


def _has(points: list[Point], percent: float) -> bool:
    return any(abs(panels.PERCENT.of(point) / percent - 1.0) < 0.15 for point in points)


def _exponent(rows: Rows, name: str, found: Power, expected: float, known: float, note: str = "") -> None:
    rows.within(name, found.exponent, expected, 3.0 * found.standard_error + known, f"{_told(found)} {note}".strip())


def _told(found: Power) -> str:
    return f"{found.exponent:.3f} ± {found.standard_error:.3f}"


if __name__ == "__main__":
    main()
