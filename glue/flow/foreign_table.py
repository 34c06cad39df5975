"""Tables of other codes as text: their names and the numbers of the columns that a map names, with each row's line.

Columns that the map does not name may hold anything.  Lines are counted from 1, as editors do.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.flow.column_map import ColumnMap

STEP = "#time"  # the column of a dump's time steps
_DUMP_ROWS = ("ITEM: ENTRIES", "ITEM: ATOMS")
_SEPARATORS = (",", ";", "\t", "|", None)  # tried where the map's own finds no names; None: blanks
_TITLES = 100  # lines from the top among which names are sought then

Lines = list[tuple[int, str]]  # number of the line in its file, its text


def read_columns(path: Path, text: str, columns: ColumnMap) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """({its name: values (n,)}, line of each row (n,)) of the columns that the map names; STEP too of a dump.

    Raises InputError for columns that are missing, before any number is read, rows of more or fewer columns than names,
    and what is no number.
    """
    lines = list(enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), 1))
    return (_dump if columns.format == "dump" else _table)(path, lines, columns)


def _table(path: Path, lines: Lines, columns: ColumnMap):
    """A table with one line of names; lines that begin with # are left out."""
    rows = [(n, line) for n, line in lines[columns.skip_lines :] if line.strip() and not line.startswith("#")]
    separator = None if columns.format == "whitespace" else columns.separator
    if not rows:
        raise InputError(f"{path}: is empty after {columns.skip_lines} lines")
    names = _fields(rows[0][1], separator)
    _refuse_absent(f"{path}:{rows[0][0]}", names, columns, lines)
    return _numbers(path, rows[1:], names, separator, columns)


def _dump(path: Path, lines: Lines, columns: ColumnMap):
    """All snapshots of a LIGGGHTS dump."""
    names, found, step, at = None, [], None, 0
    while at < len(lines):
        number, line = lines[at][0], lines[at][1].strip()
        at += 1
        if line == "ITEM: TIMESTEP" and at < len(lines):
            step = _step(path, *lines[at])
        elif line.startswith(_DUMP_ROWS):
            mine = next(line.removeprefix(head) for head in _DUMP_ROWS if line.startswith(head)).split()
            if step is None or (names is not None and mine != names):
                raise InputError(f"{path}:{number}: snapshot without a step, or of other columns than the first")
            if names is None:
                _refuse_absent(f"{path}:{number}", mine, columns, [])
            names, end = mine, at
            while end < len(lines) and not lines[end][1].startswith("ITEM:"):
                end += 1
            values, own = _numbers(path, [row for row in lines[at:end] if row[1].strip()], names, None, columns)
            found.append((values | {STEP: np.full(len(own), step)}, own))
            at = end
    if names is None:
        raise InputError(f"{path}: is no dump: no line {' or '.join(_DUMP_ROWS)}")
    together = {name: np.concatenate([values[name] for values, _ in found]) for name in found[0][0]}
    return together, np.concatenate([own for _, own in found])


def _wanted(columns: ColumnMap) -> list[str]:
    return list(dict.fromkeys(theirs for theirs, _ in columns.columns.values()))


def _refuse_absent(place: str, names: list[str], columns: ColumnMap, lines: Lines) -> None:
    wanted = _wanted(columns)
    absent = [name for name in wanted if name not in names]
    if not absent:
        return
    had = f"it has {', '.join(names)}"
    if lines and (hint := _elsewhere(set(wanted), lines, columns) or _generally(absent, wanted)):
        raise InputError(f"{place}: has no column {', '.join(map(repr, absent))}; {had}; {hint}")
    raise InputError([f"{place}: has no column {name!r}; {had}" for name in absent])


def _elsewhere(wanted: set[str], lines: Lines, columns: ColumnMap) -> str:
    """Where, and separated by what, the names stand instead; empty when nowhere."""
    for number, line in lines[:_TITLES]:
        for separator in _SEPARATORS:
            if not line.startswith("#") and wanted <= set(_fields(line, separator)):
                told = 'format = "whitespace"'
                if separator is not None:
                    told = 'format = "csv", ' * (columns.format != "csv")
                    told += f'separator = "{separator}"'.replace("\t", "\\t")
                return f"line {number} has them all; in the map: skip_lines = {number - 1}, {told}"
    return ""


def _generally(absent: list[str], wanted: list[str]) -> str:
    if len(absent) < len(wanted):
        return ""
    return "are separator and skip_lines (title lines above the names) right in the map?"


def _fields(line: str, separator: str | None) -> list[str]:
    """A line's fields without blanks and quotes around them; a separator within quotes is none."""
    if separator is None or '"' not in line:
        return [field.strip().strip('"') for field in line.split(separator)]
    return [field.strip() for field in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _width(line: str, separator: str | None) -> int:
    """Number of fields of a line, quickly: a log may have a million."""
    if separator is None:
        return len(line.split())
    return len(_fields(line, separator)) if '"' in line else line.count(separator) + 1


def _numbers(path: Path, rows: Lines, names: list[str], separator: str | None, columns: ColumnMap):
    """({name: values (n,)}, lines (n,)) of the columns that the map names."""
    wanted = _wanted(columns)
    if not rows:
        return {name: np.empty(0) for name in wanted}, np.empty(0, int)
    for number, line in rows:
        if (width := _width(line, separator)) != len(names):
            raise InputError(
                f"{path}:{number}: has {width} columns, the line of names has {len(names)};"
                f" they are split at {'blanks' if separator is None else repr(separator)}"
            )
    own = np.array([number for number, _ in rows])
    if not wanted:
        return {}, own
    point = columns.decimal != "."
    texts: Iterable[str] = (line.replace(columns.decimal, ".") if point else line for _, line in rows)
    use, quote = [names.index(name) for name in wanted], None if separator is None else '"'
    try:
        values = np.loadtxt(texts, delimiter=separator, usecols=use, ndmin=2, comments=None, quotechar=quote)
    except ValueError as problem:
        raise InputError(_first_word(path, rows, names, separator, columns) or f"{path}: {problem}") from None
    if len(values) != len(rows):
        raise InputError(f"{path}: {len(rows)} lines read as {len(values)} rows: is there a quotation mark too many?")
    return dict(zip(wanted, values.T, strict=True)), own


def _first_word(path: Path, rows: Lines, names: list[str], separator: str | None, columns: ColumnMap) -> str:
    """The sentence about the first field that is no number; empty when Python takes them all."""
    wanted = _wanted(columns)
    for number, line in rows:
        fields = _fields(line, separator)
        for name in wanted:
            field = fields[names.index(name)]
            try:
                float(field.replace(columns.decimal, "."))
            except ValueError:
                comma = columns.decimal == "." and "," in field
                hint = '; is decimal = "," in the map missing?' if comma else ""
                return f"{path}:{number}: a row cannot be read: {field[:40]!r} in column {name!r} is no number{hint}"
    return ""


def _step(path: Path, number: int, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{path}:{number}: {text[:40]!r} is no time step") from None
