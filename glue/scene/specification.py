"""What a shop says instead of a speed and a time: Almen intensity, machine setting, coverage in per cent.

The scene file may hold ``nozzle.intensity``, ``nozzle.air_pressure_Pa`` or ``nozzle.wheel_speed_m_s`` in place of
``nozzle.speed_m_s``, ``coverage_percent`` in place of ``exposure_time_s``, and ``[machine]``, which says what speed a
setting gives.  Reading finds no speeds: ``glue.study.specify`` does, and writes them down beside the scene file
(``INFERRED``), for whoever reads it next, YADE's interpreter included.  Standard library only.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

from glue.scene import schema
from glue.scene.asked import Machine, MachineCurve, MachineLaw, Specification
from glue.scene.fields import kind, quoted, show
from glue.scene.table import Table
from glue.scene.measured import beside
from glue.theory.almen import STRIPS

INFERRED = "inferred.json"
# Stand in until the true ones are found; never in a finished scene.
PROVISIONAL_SPEED_m_s, PROVISIONAL_TIME_s = 30.0, 1.0
_SPEED = "speed_m_s"
_INSTEAD = (*schema.SPECIFIED, *schema.SETTINGS)


def speed_key(table: Table) -> str | None:
    """The one key by which a nozzle says its speed; None, with a problem in the log, when it is not one."""
    given = [key for key in (_SPEED, *_INSTEAD) if key in table]
    if len(given) == 1:
        return given[0]
    every = ", ".join(_INSTEAD)
    if not given:
        table.problem(_SPEED, f"missing, and required; {schema.NOZZLE[_SPEED].allowed}, or in its place one of {every}")
        return None
    clash = "contradicts" if _SPEED in given else "says the same as"
    table.problem(given[1], f"{clash} {given[0]}, from which the speed follows; allowed one of {_SPEED}, {every}")
    for key in given:  # what else is wrong with them, at once
        field = (schema.NOZZLE | schema.SPECIFIED | schema.SETTINGS)[key]
        if problem := field.problem(table.data[key]):
            table.problem(key, problem)
    return None


def read_specification(top: Table, scene_file: Path) -> Specification | None:
    """What the file says in a shop's words; None when it says speeds and a time (or when that is refused)."""
    machine = _read_machine(top, scene_file) if "machine" in top else None
    nozzles = top.data.get("nozzle")
    nozzles = [n for n in (nozzles if isinstance(nozzles, list) else [nozzles]) if isinstance(n, Mapping)]
    percent = None
    if "coverage_percent" in top:
        percent = _read_percent(top, nozzles)
    settings = {key for n in nozzles for key in schema.SETTINGS if key in n}
    for key in sorted(settings):
        if "machine" not in top:
            top.problem(f"nozzle.{key}", f"needs a [machine] that says what speed it gives; {_MACHINE_ALLOWED}")
        elif machine is not None and machine.setting != key:
            top.problem(f"nozzle.{key}", f"but [machine] is calibrated over {machine.setting}; allowed that one")
    if machine is not None:
        low, high = machine.range
        for n in nozzles:
            value = n.get(machine.setting)
            if isinstance(value, int | float) and not low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
                top.problem(
                    f"nozzle.{machine.setting}", f"{show(value)} is beyond the calibration; allowed {show(low)}..{show(high)}"
                )
    said = tuple(n.get("intensity") for n in nozzles)
    at = tuple(n.get(machine.setting) if machine else None for n in nozzles)
    if percent is None and machine is None and not any(said):
        return None
    if machine is not None and not any(said) and not settings:
        top.problem("machine", f"has no effect: no nozzle says intensity or {machine.setting}; allowed with one that does")
    return Specification(said, at, percent, machine)


def _read_percent(top: Table, nozzles: list) -> float | None:
    percent = top.get("coverage_percent", schema.COVERAGE_PERCENT)
    if "exposure_time_s" in top:
        top.problem("coverage_percent", "contradicts exposure_time_s, which says how long too; allowed one of them")
    for n in nozzles:
        if n.get("feed_speed_m_s", 0) in (0, 0.0):
            continue
        wrong = [key for key in ("passes", "pitch_m") if n.get(key, 0) != 0] + [key for key in ("stroke_m",) if key not in n]
        if wrong:
            top.problem(
                "coverage_percent",
                f"of a nozzle that travels it finds the number of passes along one line: {wrong[0]} is in the way or missing;"
                " allowed with stroke_m, without passes and pitch_m",
            )
            break
    if percent is not None and 98.0 < percent < 100.0:
        said = "98 % covered is called full, 100 %"
        top.problem("coverage_percent", f"{show(percent)}: {said}; allowed up to 98, or 100 and more")
    return percent


_MACHINE_ALLOWED = (
    "allowed: [machine] with one of table, law, curves, each by air_pressure_Pa or wheel_speed_m_s, such as"
    " table = [{ air_pressure_Pa = 2e5, speed_m_s = 35.0 }, ...],"
    " law = { air_pressure_Pa = 2e5, speed_m_s = 40.0, exponent = 0.6 },"
    ' curves = [{ air_pressure_Pa = 2e5, file = "curve.csv", strip = "A" }, ...]'
)


def _read_machine(top: Table, scene_file: Path) -> Machine | None:
    table = top.optional_table("machine")
    if table is None:
        return None
    table.refuse_others(("table", "law", "curves"), elsewhere=schema.BELONGS_IN)
    given = [key for key in ("table", "law", "curves") if key in table]
    if len(given) != 1:
        wrong = "is empty" if not given else f"{' and '.join(given)} say the same"
        top.problem("machine", f"{wrong}; {_MACHINE_ALLOWED}")
        return None
    before = len(table.log.problems)
    fields = {"table": schema.MACHINE_ROW, "law": schema.MACHINE_LAW, "curves": schema.MACHINE_CURVE}[given[0]]
    rows = _rows(table, given[0])
    if rows is None:
        return None
    names, found = set(), []
    for row in rows:
        row.refuse_others((*schema.SETTINGS, *fields))
        keys = [key for key in schema.SETTINGS if key in row]
        if len(keys) != 1:
            every = ", ".join(schema.SETTINGS)
            row.problem(keys[0] if keys else "air_pressure_Pa", f"one setting is required; allowed one of {every}")
            continue
        names.add(keys[0])
        found.append((row.get(keys[0], schema.SETTINGS[keys[0]]), row.get_all(fields), row))
    if len(names) > 1:
        table.problem(given[0], f"mixes {' and '.join(sorted(names))}; allowed one of them throughout")
    if len(table.log.problems) > before:
        return None
    (setting,) = names
    if given[0] == "law":
        at, law, _ = found[0]
        return Machine(setting, law=MachineLaw(at, law["speed_m_s"], law["exponent"], law["relative_sd"], law["factor"]))
    found.sort(key=lambda row: row[0])
    if any(a[0] >= b[0] for a, b in pairwise(found)):
        table.problem(given[0], "a setting stands twice; allowed once each")
        return None
    if given[0] == "table":
        return _speeds(table, setting, found)
    curves = [_curve(row, at, values, scene_file) for at, values, row in found]
    return None if None in curves else Machine(setting, curves=tuple(curves))


def _rows(table: Table, key: str) -> list[Table] | None:
    value = table.data[key]
    if key == "law":
        row = table.optional_table("law")
        return None if row is None else [row]
    if not isinstance(value, list) or not value or not all(isinstance(item, Mapping) for item in value):
        table.problem(key, f"must be an array of tables, not {kind(value)}; {_MACHINE_ALLOWED}")
        return None
    if key == "table" and not 2 <= len(value) <= schema.MAX_MACHINE_ROWS or len(value) > schema.MAX_MACHINE_ROWS:
        table.problem(key, f"must have 2 to {schema.MAX_MACHINE_ROWS} rows, not {len(value)}; {_MACHINE_ALLOWED}")
        return None
    return [Table(item, f"{table.at(key)}[{n}]", table.log) for n, item in enumerate(value, 1)]


def _speeds(table: Table, setting: str, found: list) -> Machine | None:
    pairs = tuple((at, values["speed_m_s"]) for at, values, _ in found)
    if any(a[1] >= b[1] for a, b in pairwise(pairs)):
        table.problem("table", "the speed must rise with the setting; allowed rising speeds")
        return None
    return Machine(setting, table=pairs)


def _curve(row: Table, at: float, values: dict, scene_file: Path) -> MachineCurve | None:
    strip = values["strip"].upper()
    if strip not in STRIPS:
        row.problem("strip", f"unknown strip {quoted(values['strip'])}; allowed {', '.join(STRIPS)}")
        return None
    path = beside(scene_file, values["file"])
    if path is None:
        where = f"no file {quoted(values['file'])} in {scene_file.parent or '.'}"
        row.problem("file", f"{where}; allowed: a saturation curve (CSV)")
        return None
    return MachineCurve(at, values["file"], strip, hashlib.sha256(path.read_bytes()).hexdigest())


def inferred_beside(path: Path, content: bytes) -> dict | None:
    """What ``glue.study.specify`` found for exactly this scene file and left beside it, None when there is nothing."""
    try:
        found = json.loads(path.with_name(INFERRED).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    same = isinstance(found, dict) and found.get("scene_sha256") == hashlib.sha256(content).hexdigest()
    return found if same and found.get("schema") == 1 else None
