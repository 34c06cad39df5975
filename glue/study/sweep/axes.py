"""The axes of a study: which keys of the scene change together, and the values that they take."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

from glue.scene.fields import Integer, Number, Text, Vector, Word, kind, quoted
from glue.scene.schema import ACCURACY, FEED
from glue.scene.table import Table

DIGITS = 9  # of a value between two ends: readable in a scene, and the same from every machine
KEY_PATH = Text(r"[A-Za-z0-9_]+(\.[A-Za-z0-9_]+)*", 'allowed: the path of a key of the scene, such as "nozzle.speed_m_s"')
_LABEL = Text(r".{1,60}", "allowed: 1 to 60 characters", "", "the key's own name")
_RANGE = Vector("ab", Number(-1e300, 1e300))
_POINTS = Integer(2, 1000)
_SPACING = Word(("linear", "log"), "linear", "even steps; choice of this project")
# Keys that hold whole numbers: what a range gives is rounded for them.
_WHOLE = {
    f"{table}.{key}" for table, fields in (("nozzle", FEED), ("accuracy", ACCURACY)) for key, field in fields.items()
    if isinstance(field, Integer)
}  # fmt: skip
_KEYS = ("name", "key", "keys", "factors", "values", "range", "points", "spacing")
# Ends of a key's name that are a unit, longest first.
_UNITS = {
    "_kg_m3": "kg/m3", "_kg_s": "kg/s", "_m_s2": "m/s2", "_Pa_s": "Pa s", "_m_s": "m/s", "_deg": "deg", "_percent": "%",
    "_Pa": "Pa", "_Hz": "Hz", "_K": "K", "_m": "m", "_s": "s",
}  # fmt: skip


@dataclass(frozen=True)
class Axis:
    """Keys that change together: through ``values``, or between ``low`` and ``high``."""

    name: str
    keys: tuple[str, ...]
    values: tuple | None = None  # one for all keys, or a list with one for each
    each: bool = False  # values hold one for each key
    low: float = math.nan
    high: float = math.nan
    log: bool = False
    points: int | None = None
    factors: tuple[float, ...] | None = None

    @property
    def unit(self) -> str:
        """Unit of the first key, from its name; empty for a plain number or a word."""
        return next((unit for end, unit in _UNITS.items() if self.keys[0].endswith(end)), "")

    def steps(self) -> list:
        """All values of a grid's axis."""
        if self.values is not None:
            return list(self.values)
        return [self.at(k / (self.points - 1)) for k in range(self.points)]

    def at(self, share: float):
        """The value at ``share`` (0-1) of the way; of listed values the one whose equal part of the way it is."""
        if self.values is not None:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        if self.log:
            value = self.low * (self.high / self.low) ** share
        else:
            value = self.low + (self.high - self.low) * share
        return float(f"{value:.{DIGITS}g}")

    def changes(self, value) -> dict[str, object]:
        """{key path: value} of the scene where the axis stands at ``value``."""
        if self.each:
            return dict(zip(self.keys, value, strict=True))
        found = dict.fromkeys(self.keys, value)
        if self.factors is not None:
            found = {k: float(f"{f * value:.{DIGITS}g}") for k, f in zip(self.keys, self.factors, strict=True)}
        rounded = _WHOLE.intersection(self.keys) if self.values is None else ()
        return {key: math.floor(v + 0.5) if key in rounded else v for key, v in found.items()}


def read_axes(top: Table, design: str | None) -> tuple[Axis, ...]:
    """The tables [[axis]] of a study with this kind of design; problems go to the table's log."""
    tables = top.several("axis", "key and values or range", 50)
    axes = [_axis(table, design) for table in tables or ()]
    seen: dict[str, str] = {}
    for table, axis in zip(tables or (), axes, strict=True):
        for key in axis.keys if axis else ():
            if key in seen:
                table.problem("key", f'"{key}" is changed by {seen[key]} already; allowed: a key on one axis')
            seen.setdefault(key, table.path)
    return tuple(axis for axis in axes if axis)


def _axis(table: Table, design: str | None) -> Axis | None:
    before = len(table.log.problems)
    table.refuse_others(_KEYS)
    keys = _axis_keys(table)
    label = table.get("name", _LABEL) or ""
    values, ends = table.data.get("values"), table.data.get("range")
    if (values is None) == (ends is None):
        table.problem("values", "an axis has either values = [...] or range = [from, to]; allowed: one of them")
        return None
    each = False
    if values is not None:
        for key in ("points", "spacing"):
            if key in table:
                table.problem(key, "belongs to a range; allowed: beside range = [from, to]")
        each = _check_values(table, keys, values)
    else:
        ends, log, points = _range(table, design)
    factors = _factors(table, keys, values)
    if len(table.log.problems) > before:
        return None
    label = label or keys[0]
    if values is not None:
        return Axis(label, keys, tuple(values), each, factors=factors)
    axis = Axis(label, keys, low=ends[0], high=ends[1], log=log, points=points, factors=factors)
    changes = [axis.changes(value) for value in axis.steps()] if points else []
    if any(one == next_one for one, next_one in itertools.pairwise(changes)):
        table.problem("points", f"{points} steps give a whole number twice; allowed: fewer, or values = [...]")
        return None
    return axis


def _axis_keys(table: Table) -> tuple[str, ...]:
    if ("key" in table) == ("keys" in table):
        table.problem("key", 'an axis has either key = "..." or keys = ["...", "..."]; allowed: one of them')
        return ()
    given = table.data["keys"] if "keys" in table else [table.data["key"]]
    where = "keys" if "keys" in table else "key"
    if not isinstance(given, list) or not given:
        table.problem(where, f"must be an array of key paths, not {kind(given)}; {KEY_PATH.allowed}")
        return ()
    for key in given:
        problem = KEY_PATH.problem(key)
        if problem is None and key == "seed":
            problem = "seeds are the replicates'; allowed: replicates = N in [design]"
        if problem is None and key in ("schema", "name"):
            problem = f'"{key}" is no parameter; {KEY_PATH.allowed}'
        if problem:
            table.problem(where, problem)
    return tuple(str(key) for key in given)


def _check_values(table: Table, keys: tuple[str, ...], values: object) -> bool:
    """Are the values arrays with one entry for each key?  Complains of what cannot be a list of values."""
    if not isinstance(values, list) or not values:
        given = "an empty one" if values == [] else kind(values)
        table.problem("values", f"must be an array of values, not {given}; allowed: such as [1.0, 2.0]")
        return False
    bad = [v for v in values if not _is_plain(v)]
    if bad:
        allowed = "allowed: finite numbers, texts, booleans, arrays of them"
        table.problem("values", f"{quoted(bad[0])} is no value of a scene's key; {allowed}")
    arrays = [isinstance(v, list) for v in values]
    each = "keys" in table and any(arrays)
    if each and not all(a and len(v) == len(keys) for a, v in zip(arrays, values, strict=True)):
        both = f"with keys = [...] either plain values or arrays of {len(keys)}, one for each key"
        table.problem("values", f"{both}; allowed: one of them")
    return each


def _is_plain(value: object) -> bool:
    if isinstance(value, list):
        return bool(value) and all(_is_plain(item) for item in value)
    if isinstance(value, Mapping):
        return all(_is_plain(item) for item in value.values())
    return isinstance(value, str | bool | int) or isinstance(value, float) and math.isfinite(value)


def _range(table: Table, design: str | None) -> tuple[tuple[float, float] | None, bool, int | None]:
    ends = table.get("range", _RANGE)
    log = table.get("spacing", _SPACING) == "log"
    if ends and not ends[0] < ends[1]:
        table.problem("range", f"must rise, not {quoted(list(ends))}; allowed: [from, to] with from < to")
    elif ends and log and ends[0] <= 0.0:
        table.problem("range", 'spacing = "log" needs numbers above 0; allowed: [from, to] with 0 < from < to')
    points = None
    if design == "grid":
        points = table.get("points", _POINTS)
    elif design and "points" in table:
        table.problem("points", f'the number of points of a design "{design}" is its samples; allowed: with kind = "grid"')
    return ends, log, points


def _factors(table: Table, keys: tuple[str, ...], values: object) -> tuple[float, ...] | None:
    if "factors" not in table:
        return None
    factors = table.data["factors"]
    number = Number(-1e9, 1e9)
    if "keys" not in table or not isinstance(factors, list) or len(factors) != len(keys):
        table.problem("factors", f"must be an array of {len(keys)} numbers beside keys = [...]; allowed: one for each key")
    elif problems := [p for f in factors if (p := number.problem(f))]:
        table.problem("factors", problems[0])
    elif isinstance(values, list) and not all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        table.problem("factors", "need values that are numbers; allowed: numbers, or no factors")
    else:
        return tuple(float(f) for f in factors)
    return None


