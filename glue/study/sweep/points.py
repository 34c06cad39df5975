"""The points of a finished study: mean and scatter over the replicates of each, power laws along an axis.

Figures and checks of studies read these, from ``table.csv`` and the runs' ``coverage.csv`` alone.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.study.sweep.table import TABLE

_TEXTS = ("run", "state", "cause", "flow.model", "target.model")


class Value(NamedTuple):
    """A quantity over the replicates of a point; ``sd`` of one run about the mean, nan of a single one."""

    mean: float
    sd: float
    number: int

    @property
    def standard_error(self) -> float:
        return self.sd / math.sqrt(self.number)


@dataclass(frozen=True)
class Point:
    """The finished runs at one point of the design: their names, and what each column of the table says of them."""

    names: tuple[str, ...]
    columns: dict[str, tuple[float | None, ...]]

    def each(self, column: str) -> tuple[float, ...] | None:
        """The replicates' values; None where any of them has none: the mean of the others would be another quantity."""
        values = self.columns.get(column, (None,))
        return None if None in values else values

    def value(self, column: str) -> Value | None:
        """Mean and scatter of a column, None as in ``each``."""
        values = self.each(column)
        if values is None:
            return None
        return Value(float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else math.nan, len(values))

    def mean(self, column: str) -> float:
        """Mean of a column, nan where there is none."""
        value = self.value(column)
        return math.nan if value is None else value.mean


class Power(NamedTuple):
    """y = constant x^exponent, fitted to single runs."""

    exponent: float
    standard_error: float
    constant: float


def read_points(folder: Path) -> list[Point]:
    """The points of the study in ``folder`` that have finished runs, in the design's order.

    Raises InputError when there is no table, or no finished run in it.
    """
    try:
        with open(folder / TABLE, encoding="utf-8", newline="") as f:
            rows = [row for row in csv.DictReader(f) if row["state"] == "done"]
    except (OSError, UnicodeDecodeError, csv.Error, KeyError) as problem:
        raise InputError(f"{folder / TABLE}: cannot be read ({problem!r}); peen sweep writes it") from None
    if not rows:
        raise InputError(f"{folder / TABLE}: no run of the study is done; peen sweep goes on with it")
    together: dict[str, list[dict]] = {}
    for row in rows:
        together.setdefault(row["point"], []).append(row)
    columns = [column for column in rows[0] if column not in _TEXTS]
    return [
        Point(tuple(row["run"] for row in group), {c: tuple(_number(row[c]) for row in group) for c in columns})
        for group in together.values()
    ]


def mean_curve(folder: Path, point: Point, steps: int = 200) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(time [s], coverage, Avrami's), each (steps + 1,): means over the replicates' coverage.csv.

    Raises InputError when one of the files cannot be read.
    """
    curves = [_curve(folder / "runs" / name / "coverage.csv") for name in point.names]
    times = np.linspace(0.0, min(curve[-1, 0] for curve in curves), steps + 1)
    counted, expected = (np.mean([np.interp(times, c[:, 0], c[:, k]) for c in curves], axis=0) for k in (1, 2))
    return times, counted, expected


def power(points: Sequence[Point], x: str, y: str) -> Power:
    """The power law of column ``y`` in column ``x``: a straight line through the logarithms of all runs, least squares.

    Its standard error comes from the runs' scatter about the line, whether by chance or because it is none.  A point
    without ``y`` (see ``Point.each``) is left out.  Raises InputError for fewer than three runs or one value of x.
    """
    pairs = [p for point in points if point.each(y) and point.each(x) for p in zip(point.each(x), point.each(y), strict=True)]
    if len(pairs) < 3 or len({first for first, _ in pairs}) < 2:
        raise InputError(f"{y} against {x}: a power law needs three runs at two values or more")
    logs = np.log(np.abs(np.array(pairs)))
    u, v = logs[:, 0] - logs[:, 0].mean(), logs[:, 1]
    exponent = float(u @ v / (u @ u))
    constant = float(v.mean() - exponent * logs[:, 0].mean())
    off = v - constant - exponent * logs[:, 0]
    return Power(exponent, math.sqrt(float(off @ off) / (len(pairs) - 2) / float(u @ u)), math.exp(constant))


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _curve(path: Path) -> np.ndarray:
    try:
        return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2, usecols=(0, 1, 2))
    except (OSError, ValueError) as problem:
        raise InputError(f"{path}: cannot be read ({problem})") from None
