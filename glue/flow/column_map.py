"""How a table of impacts from elsewhere reads as ours: columns, units, axes, what the table does not say.

    schema = 1
    format = "csv"                  # csv, whitespace, or dump (LIGGGHTS: ITEM: TIMESTEP, ITEM: ENTRIES …)
    separator = ","                 # csv alone; or ";", "\\t", …
    decimal = "."                   # "," where numbers read 0,8
    skip_lines = 0                  # title lines above the line of column names
    position = "contact"            # the points are where the shot touches; "centre": where its centre is
    origin_m = [0, 0, 0]            # our origin (middle of the window, on the surface), in the table's axes
    axes = {x = "x", y = "-z", z = "y"}   # which of the table's axes ours are; here its y is up
    [columns]                       # our name = its name (SI), or with its unit; all in the table's own axes
    time_s = {column = "Time", unit = "ms"}
    x_m = {column = "Pos X", unit = "mm"}
    vz_in_m_s = {column = "Vel Z", unit = "mm/s", factor = -1}    # factor: here down is positive
    [constants]                     # our name = one value for every row, SI
    diameter_m = 1e-3
    density_kg_m3 = 7800
    restitution = 0.4               # of the normal speed, where the table has no velocities after the impact
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import COLUMNS

SCHEMA = 1
FORMATS, POSITIONS = ("csv", "whitespace", "dump"), ("contact", "centre")
UNITS = {
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "in": 0.0254},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1 / 3.6, "ft/s": 0.3048},
    "spin": {"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": math.pi / 30},
    "density": {"kg/m3": 1.0, "g/cm3": 1e3, "t/mm3": 1e12},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "number": {"1": 1.0},
}
_SUFFIXES = (("_kg_m3", "density"), ("_rad_s", "spin"), ("_m_s", "speed"), ("_N", "force"), ("_s", "time"), ("_m", "length"))
OURS = tuple(name for name in COLUMNS.names if name != "impact_id")
NEEDED = ("time_s", "x_m", "y_m", "vx_in_m_s", "vy_in_m_s", "vz_in_m_s", "diameter_m", "density_kg_m3")
_KEYS = {
    "schema", "format", "separator", "decimal", "skip_lines", "timestep_s", "position", "same_impact_s", "origin_m",
    "axes", "columns", "constants",
}  # fmt: skip


@dataclass(frozen=True)
class ColumnMap:
    """A map as read; ``columns``: {our name: (its name, factor to SI)}; ``axes``: (3, 3) rotation, ours = axes @ its own."""

    columns: dict[str, tuple[str, float]]
    constants: dict[str, float]
    axes: np.ndarray
    origin_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    format: str = "csv"
    separator: str = ","
    skip_lines: int = 0
    timestep_s: float | None = None
    position: str = "contact"
    same_impact_s: float = 0.0
    decimal: str = "."


def quantity(name: str) -> str:
    """What kind of quantity our column ``name`` is, by its ending: a key of UNITS."""
    return next((kind for ending, kind in _SUFFIXES if name.endswith(ending)), "number")


def read_map(path: Path) -> ColumnMap:
    """The map of a TOML file as in this module's head.  Raises InputError with everything that is wrong with it."""
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as problem:
        raise InputError(f"{path}: cannot be read as a TOML file ({problem})") from None
    problems: list[str] = []

    def refuse(key: str, sentence: str) -> None:
        problems.append(f"{path}: {key}: {sentence}")

    for key in sorted(set(data) - _KEYS):
        refuse(key, f"unknown key; allowed: {', '.join(sorted(_KEYS))}")
    if data.get("schema") != SCHEMA:
        refuse("schema", f"{data.get('schema')!r}; allowed: {SCHEMA}")
    given = {"format": data.get("format", "csv"), "position": data.get("position", "contact")}
    for key, allowed in (("format", FORMATS), ("position", POSITIONS)):
        if given[key] not in allowed:
            refuse(key, f"{given[key]!r}; allowed: {', '.join(allowed)}")
    numbers = {"skip_lines": 0, "same_impact_s": 0.0, "timestep_s": None}
    for key in numbers:
        value = data.get(key, numbers[key])
        if key == "skip_lines" and not (isinstance(value, int) and not isinstance(value, bool) and value >= 0):
            refuse(key, f"{value!r}; allowed: a whole number from 0 up")
        elif value is not None and not (_is_number(value) and value >= 0):
            refuse(key, f"{value!r}; allowed: a number from 0 up")
        numbers[key] = value
    if given["format"] == "dump" and not numbers["timestep_s"] and "time_s" not in data.get("columns", {}):
        refuse("timestep_s", "missing: a dump counts steps; allowed: the seconds of one, or a column for time_s")
    separator = data.get("separator", ",")
    if not (isinstance(separator, str) and len(separator) == 1) or separator.isalnum() or separator in '.+-"#\r\n':
        refuse("separator", f'{separator!r}; allowed: one character that no number holds, such as ";" or "\\t"')
    decimal = data.get("decimal", ".")
    if decimal not in (".", ","):
        refuse("decimal", f'{decimal!r}; allowed: ".", ","')
    elif given["format"] == "csv" and decimal == separator:
        refuse("decimal", 'is the separator too; allowed: with separator = ";" or another')
    origin = data.get("origin_m", [0.0, 0.0, 0.0])
    if not (isinstance(origin, list) and len(origin) == 3 and all(map(_is_number, origin))):
        refuse("origin_m", f"{origin!r}; allowed: three numbers")
    columns = _columns(data.get("columns", {}), refuse)
    constants = _constants(data.get("constants", {}), columns, refuse)
    implied = {"time_s"} if given["format"] == "dump" else set()
    for name in NEEDED:
        if name not in {*columns, *constants, *implied}:
            refuse(f"columns.{name}", "missing, and required; allowed: the table's column, or a value under [constants]")
    if numbers["same_impact_s"] and "shot_id" not in columns:
        refuse("same_impact_s", "tells rows of one shot apart, but no column is shot_id; allowed: with columns.shot_id")
    after = {f"v{axis}_out_m_s" for axis in "xyz"}
    named = sorted(after & {*columns, *constants})
    if "restitution" in constants and named:
        refuse("constants.restitution", f"beside {', '.join(named)}, which say the same; allowed: one of the two")
    elif "restitution" not in constants and len(named) < len(after):
        refuse(
            "constants.restitution",
            "missing: no velocity after the impact is named; allowed: 0 to 1, or columns v?_out_m_s",
        )
    axes = _axes(data.get("axes", {}), refuse)
    if problems:
        raise InputError(problems)
    return ColumnMap(
        columns, constants, axes, tuple(float(v) for v in origin), given["format"], separator, numbers["skip_lines"],
        numbers["timestep_s"], given["position"], float(numbers["same_impact_s"]), decimal,
    )  # fmt: skip


def _is_number(value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _columns(table, refuse) -> dict[str, tuple[str, float]]:
    found = {}
    for name, entry in table.items() if isinstance(table, dict) else ():
        key = f"columns.{name}"
        if name not in OURS:
            refuse(key, f"no column of the impact log; allowed: {', '.join(OURS)}")
            continue
        entry = {"column": entry} if isinstance(entry, str) else entry
        if not isinstance(entry, dict) or not isinstance(entry.get("column"), str) or set(entry) - {"column", "unit", "factor"}:
            refuse(key, "allowed: a column's name, or {column = name, unit = …, factor = …}")
            continue
        units, factor = UNITS[quantity(name)], entry.get("factor", 1.0)
        unit = entry.get("unit", next(iter(units)))
        if unit not in units:
            refuse(key, f"unit {unit!r} is none of a {quantity(name)}; allowed: {', '.join(units)}")
        elif not _is_number(factor) or factor == 0:
            refuse(key, f"factor {factor!r}; allowed: a number that is not 0")
        else:
            found[name] = (entry["column"], units[unit] * factor)
    return found


def _constants(table, columns, refuse) -> dict[str, float]:
    found = {}
    for name, value in table.items() if isinstance(table, dict) else ():
        key = f"constants.{name}"
        if name != "restitution" and name not in OURS:
            refuse(key, f"no column of the impact log; allowed: restitution, {', '.join(OURS)}")
        elif name in columns:
            refuse(key, "is among [columns] too; allowed: one of the two")
        elif not _is_number(value) or (name == "restitution" and not 0.0 <= value <= 1.0):
            refuse(key, f"{value!r}; allowed: {'0 to 1' if name == 'restitution' else 'a number'}")
        else:
            found[name] = float(value)
    return found


def _axes(table, refuse) -> np.ndarray:
    """Rows: our x, y, z in the table's axes."""
    rotation = np.zeros((3, 3))
    for row, ours in enumerate("xyz"):
        theirs = table.get(ours, ours) if isinstance(table, dict) else None
        if not (isinstance(theirs, str) and theirs.lstrip("+-") in ("x", "y", "z") and len(theirs) <= 2):
            refuse(f"axes.{ours}", f"{theirs!r}; allowed: x, y, z, -x, -y, -z")
            return rotation
        rotation[row, "xyz".index(theirs[-1])] = -1.0 if theirs.startswith("-") else 1.0
    turned = np.linalg.det(rotation)
    if abs(turned) < 0.5:
        refuse("axes", "name one axis twice; allowed: each of the table's x, y, z once")
    elif turned < 0.0:
        refuse("axes", "mirror the table instead of turning it; allowed: right-handed ones, such as x = x, y = -z, z = y")
    return rotation
