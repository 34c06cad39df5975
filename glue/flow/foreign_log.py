"""Impact tables of other codes, read through a column map into a log like our own; and ours written as plain CSV."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path, write_text_atomic
from glue.errors import InputError
from glue.flow.column_map import OURS, UNITS, ColumnMap, quantity
from glue.flow.foreign_table import STEP, read_columns
from glue.flow.impacts import COLUMNS, normal_speed_m_s
from glue.scene.schema import NOZZLE, SHOTS


def read_foreign(path: Path, columns: ColumnMap) -> tuple[np.ndarray, dict]:
    """(impacts, header): rows of ``COLUMNS`` in order of time, and what their log should say of where they are from.

    Raises InputError with everything that is wrong: missing columns, words for numbers, values that are not finite,
    sizes, densities or speeds that no scene could have, impacts that do not move into the target.
    """
    try:
        raw = Path(path).read_bytes()
        text = raw.decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as problem:
        raise InputError(f"{path}: cannot be read ({problem})") from None
    values, lines = read_columns(path, text, columns)
    if not len(lines):
        raise InputError(f"{path}: holds no impact")
    theirs = {ours: values[column] * factor for ours, (column, factor) in columns.columns.items()}
    if columns.format == "dump" and "time_s" not in theirs:
        theirs["time_s"] = values[STEP] * columns.timestep_s
    impacts = _as_ours(theirs, len(lines), columns)
    problems = [f"{path}: {sentence}" for sentence in _problems(impacts, lines)]
    if problems:
        raise InputError(problems)
    impacts = impacts[np.argsort(impacts["time_s"], kind="stable")]
    if columns.same_impact_s > 0.0:
        impacts = impacts[_first_rows(impacts, columns.same_impact_s)]
    impacts["impact_id"] = np.arange(len(impacts))
    return impacts, {"model": "imported", "source": Path(path).name, "source_sha256": hashlib.sha256(raw).hexdigest()}


def write_plain(path: Path, impacts: np.ndarray, units: dict[str, str], map_path: Path | None = None) -> None:
    """Our log as CSV with one head line "name [unit]"; ``units``: {quantity: unit}, SI for the others (see column_map.UNITS).

    ``map_path``: where to write the map that reads the table back.
    """
    chosen = {name: units.get(quantity(name), next(iter(UNITS[quantity(name)]))) for name in OURS}
    heads = {name: _bare(name) + ("" if unit == "1" else f" [{unit}]") for name, unit in chosen.items()}
    table = np.column_stack([impacts[name] / UNITS[quantity(name)][chosen[name]] for name in OURS])
    with atomic_path(path) as part:
        np.savetxt(part, table, "%.17g", ",", header=",".join(heads.values()), comments="")
    if map_path is not None:
        lines = ["schema = 1", "[columns]"]
        lines += [f'{name} = {{column = "{heads[name]}", unit = "{unit}"}}' for name, unit in chosen.items()]
        write_text_atomic(map_path, "\n".join(lines) + "\n")


def _bare(name: str) -> str:
    """Our column's name without its unit."""
    for ending in ("_kg_m3", "_rad_s", "_m_s", "_N", "_s", "_m"):
        if name.endswith(ending):
            return name.removesuffix(ending)
    return name


def _as_ours(theirs: dict[str, np.ndarray], count: int, columns: ColumnMap) -> np.ndarray:
    """Rows of ``COLUMNS`` in our axes from the table's own columns in SI."""
    impacts = np.zeros(count, COLUMNS)
    impacts["nz"], impacts["peak_force_N"], impacts["shot_id"] = 1.0, np.nan, np.arange(count)
    told = {**{name: np.full(count, value) for name, value in columns.constants.items() if name != "restitution"}, **theirs}
    for name, values in told.items():
        impacts[name] = values if COLUMNS[name].kind == "f" else np.rint(np.nan_to_num(values, nan=-1.0))
    vectors = [("x_m", "y_m", "z_m"), *(tuple(f"v{a}_{when}_m_s" for a in "xyz") for when in ("in", "out")),
               *(tuple(f"w{a}_{when}_rad_s" for a in "xyz") for when in ("in", "out"))]  # fmt: skip
    if {"nx", "ny", "nz"} & set(told):
        vectors.append(("nx", "ny", "nz"))
    for three in vectors:
        own = np.stack([impacts[name] for name in three])
        if three[0] == "x_m":
            own -= np.array(columns.origin_m)[:, None]
        for name, row in zip(three, columns.axes, strict=True):
            k = int(np.abs(row).argmax())  # picked, not multiplied: a value that is not finite stays in its own column
            impacts[name] = row[k] * own[k] + 0.0  # + 0.0: no negative noughts
    normal = np.stack([impacts[name] for name in ("nx", "ny", "nz")])
    if columns.position == "centre":
        for name, part in zip(("x_m", "y_m", "z_m"), normal, strict=True):
            impacts[name] -= 0.5 * impacts["diameter_m"] * part
    if "restitution" in columns.constants:
        into = (1.0 + columns.constants["restitution"]) * normal_speed_m_s(impacts)
        for axis, part in zip("xyz", normal, strict=True):
            impacts[f"v{axis}_out_m_s"] = impacts[f"v{axis}_in_m_s"] + into * part
            impacts[f"w{axis}_out_rad_s"] = impacts[f"w{axis}_in_rad_s"]
    return impacts


def _problems(impacts: np.ndarray, lines: np.ndarray) -> list[str]:
    """What no log may hold, whatever the scene; the scene's own checks follow when it is used (``log_checks``).

    ``lines`` (n,): where in its file each row is from.
    """
    problems = []

    def refuse(rows: np.ndarray, sentence: str) -> None:
        if rows.any():
            problems.append(f"{sentence} (first: line {lines[np.argmax(rows)]})")

    for name in (n for n in impacts.dtype.names if n != "peak_force_N"):
        if impacts.dtype[name].kind == "f":
            refuse(~np.isfinite(impacts[name]), f"{name}: not finite")
        else:
            refuse(impacts[name] < 0, f"{name}: negative, or no whole number")
    for name in ("diameter_m", "density_kg_m3"):
        limits, bad = SHOTS[name], impacts[name] <= 0.0
        refuse(bad, f"{name}: not positive in {np.count_nonzero(bad)} rows")
        off = ~bad & ((impacts[name] < limits.low) | (impacts[name] > limits.high))
        if off.any():
            why = limits.problem(float(impacts[name][off][0]))
            refuse(off, f"{name}: {why}; so {np.count_nonzero(off)} rows: is its unit in the map right?")
    # The middle one: shots that come back after a rebound may be as slow as they like.
    speed = float(np.median(np.sqrt(sum(impacts[f"v{axis}_in_m_s"] ** 2 for axis in "xyz"))))
    if np.isfinite(speed) and (wrong := NOZZLE["speed_m_s"].problem(speed)):
        problems.append(f"v?_in_m_s: the middle speed {wrong}; is their unit in the map right?")
    length2 = sum(impacts[n] ** 2 for n in ("nx", "ny", "nz"))
    refuse(~(np.abs(length2 - 1.0) < 1e-6), "nx, ny, nz: no unit vectors")
    out = ~(normal_speed_m_s(impacts) > 0.0)
    refuse(
        out,
        f"{np.count_nonzero(out)} of {len(impacts)} impacts move out of the target instead of into it (v . n >= 0);"
        " are the axes right (axes = …), or is down positive (factor = -1)?",
    )
    return problems


def _first_rows(impacts: np.ndarray, within_s: float) -> np.ndarray:
    """Indices, in order of time, of rows that are no further row of an impact already there (same shot, within that time)."""
    order = np.lexsort((impacts["time_s"], impacts["shot_id"]))
    shot, time = impacts["shot_id"][order], impacts["time_s"][order]
    again = np.r_[False, (np.diff(shot) == 0) & (np.diff(time) <= within_s)]  # a contact of many snapshots is one chain
    return np.sort(order[~again])
