"""What a laboratory measured, from CSV files: saturation curves and residual stress over depth.

The first line that is no comment (#) names the columns with their units; every problem of a file is told at once.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.scene.catalogue import closest
from glue.theory.almen import INCH_m

# column: (quantity, size of its unit in SI); exposures are kept in the unit they were written in
CURVE = {
    "exposure_min": ("exposure", 1.0),
    "exposure_s": ("exposure", 1.0),
    "exposure_passes": ("exposure", 1.0),
    "arc_height_in": ("arc_height_m", INCH_m),
    "arc_height_mm": ("arc_height_m", 1e-3),
    "arc_height_m": ("arc_height_m", 1.0),
}
PROFILE = {
    "depth_um": ("depth_m", 1e-6),
    "depth_mm": ("depth_m", 1e-3),
    "depth_m": ("depth_m", 1.0),
    "stress_MPa": ("stress_Pa", 1e6),
    "stress_Pa": ("stress_Pa", 1.0),
    "stress_sd_MPa": ("stress_sd_Pa", 1e6),
    "stress_sd_Pa": ("stress_sd_Pa", 1.0),
}
HIGHEST_ARC_m = 5e-3  # beyond any strip: a height in another unit
DEEPEST_m, STRONGEST_Pa = 0.05, 5e9


class MeasuredCurve(NamedTuple):
    """A saturation curve; exposures (n,) rise, in ``unit`` ("min", "s" or "passes")."""

    exposure: np.ndarray
    arc_height_m: np.ndarray
    unit: str
    file: str


class MeasuredProfile(NamedTuple):
    """Residual stress over depth, (n,) each; ``stress_sd_Pa`` None where it is not given."""

    depth_m: np.ndarray
    stress_Pa: np.ndarray
    stress_sd_Pa: np.ndarray | None
    file: str


def read_curve(path: Path, content: bytes | None = None) -> MeasuredCurve:
    """A saturation curve from CSV: one ``exposure_*`` and one ``arc_height_*`` column, in any order of rows.

    Raises InputError with all problems: unknown or missing units, gaps, what is no number, exposures twice.
    """
    table, names, lines, problems = _read(path, CURVE, ("exposure", "arc_height_m"), content)
    if not problems:
        problems += [
            f"{path}: line {n}: exposure {t:g} must be above 0" for n, t in zip(lines, table["exposure"]) if t <= 0.0
        ]
        first: dict[float, int] = {}
        for n, t in zip(lines, table["exposure"]):
            if t in first:
                problems.append(f"{path}: line {n}: exposure {t:g} stands in line {first[t]} too; allowed once each")
            first.setdefault(t, n)
        column = next(name for name in names if name.startswith("arc_height"))
        for n, h in zip(lines, table["arc_height_m"]):
            if not 0.0 < h <= HIGHEST_ARC_m:
                size = CURVE[column][1]
                problems.append(
                    f"{path}: line {n}: {column} {h / size:g} is {h * 1e3:.4g} mm; allowed above 0 up to"
                    f" {HIGHEST_ARC_m / size:g} (is the unit right?)"
                )
    if problems:
        raise InputError(problems)
    order = np.argsort(table["exposure"])
    unit = next(name for name in names if name.startswith("exposure")).removeprefix("exposure_")
    return MeasuredCurve(table["exposure"][order], table["arc_height_m"][order], unit, str(path))


def read_profile(path: Path, content: bytes | None = None) -> MeasuredProfile:
    """A stress profile from CSV: ``depth_*``, ``stress_*`` and perhaps ``stress_sd_*``.  Raises InputError."""
    table, names, lines, problems = _read(path, PROFILE, ("depth_m", "stress_Pa"), content)
    if not problems:
        for n, z, s in zip(lines, table["depth_m"], table["stress_Pa"]):
            if not 0.0 <= z <= DEEPEST_m:
                problems.append(f"{path}: line {n}: depth {z:g} m; allowed 0..{DEEPEST_m:g} m (is the unit right?)")
            if abs(s) > STRONGEST_Pa:
                problems.append(f"{path}: line {n}: stress {s:g} Pa; allowed up to {STRONGEST_Pa:g} Pa (is the unit right?)")
        if len(set(table["depth_m"])) < len(table["depth_m"]):
            problems.append(f"{path}: a depth stands twice; allowed once each")
        if (table.get("stress_sd_Pa", np.zeros(1)) < 0.0).any():
            problems.append(f"{path}: a standard deviation is below 0")
    if problems:
        raise InputError(problems)
    order = np.argsort(table["depth_m"])
    spread = table.get("stress_sd_Pa")
    return MeasuredProfile(
        table["depth_m"][order], table["stress_Pa"][order], None if spread is None else spread[order], str(path)
    )


def _read(path: Path, columns: dict[str, tuple[str, float]], required: tuple[str, ...], content: bytes | None):
    """({quantity: values in SI}, column names, line numbers, problems)."""
    try:
        text = (path.read_bytes() if content is None else content).decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; allowed: a CSV file with columns {', '.join(columns)}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as text: {getattr(error, 'strerror', None) or error}") from None
    rows = [
        (n, next(csv.reader([line])))
        for n, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        return {}, [], [], [f"{path}: is empty; allowed: a header line with columns {', '.join(columns)}, then numbers"]
    (first, header), *body = rows
    names = [name.strip() for name in header]
    problems = list(_header_problems(f"{path}: line {first}", names, columns, required))
    if problems:
        return {}, names, [], problems
    values, lines = [], []
    for n, cells in body:
        if len(cells) != len(names):
            problems.append(f"{path}: line {n}: {len(cells)} values; allowed {len(names)}, one for each column")
            continue
        row = [_number(f"{path}: line {n}: {name}", cell.strip(), problems) for name, cell in zip(names, cells)]
        if None not in row:
            values.append(row)
            lines.append(n)
    if not body:
        problems.append(f"{path}: no line of numbers follows the header")
    if problems:
        return {}, names, lines, problems
    array = np.array(values)
    return {columns[name][0]: array[:, k] * columns[name][1] for k, name in enumerate(names)}, names, lines, []


def _header_problems(where: str, names: list[str], columns: dict, required: tuple[str, ...]):
    known = [name for name in names if name in columns]
    for name in names:
        if name not in columns:
            guess = closest(name, columns)
            hint = f'did you mean "{guess}"? ' if guess else ""
            yield f'{where}: unknown column or unit "{name}"; {hint}allowed: {", ".join(columns)}'
    for quantity in dict.fromkeys(q for q, _ in columns.values()):
        found = [name for name in known if columns[name][0] == quantity]
        choices = ", ".join(name for name, (q, _) in columns.items() if q == quantity)
        if len(found) > 1:
            yield f"{where}: {' and '.join(found)} say the same; allowed one of {choices}"
        if not found and quantity in required:
            yield f"{where}: no column for it; allowed one of {choices}"


def _number(where: str, cell: str, problems: list[str]) -> float | None:
    if not cell:
        problems.append(f"{where}: is empty; allowed a number in every column")
        return None
    try:
        value = float(cell)
    except ValueError:
        problems.append(f'{where}: "{cell}" is no number; allowed a decimal number with a point')
        return None
    if not math.isfinite(value):
        problems.append(f"{where}: {cell} is not finite")
        return None
    return value
