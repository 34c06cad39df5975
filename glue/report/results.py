"""What a run found, as HTML: headline tiles, and every metric with its interval and what the interval is made of."""

from __future__ import annotations

import math
from html import escape

from glue.report.markup import Cell, number, table
from glue.study.rows import CAUSES, ROWS, shown

_HEADLINES = (
    ("coverage", "final"), ("coverage", "time_98_s"), ("residual_stress", "max_compressive_Pa"),
    ("residual_stress", "compressive_depth_m"), ("roughness", "Sa_m"), ("dimple", "radius_m"),
)  # fmt: skip
_EXPLAINED = (
    "Intervals hold 95 %; causes are independent and add by squares. Statistical: other arrivals of the same stream;"
    " numerical: meshes, steps, rasters and models, as measured on the most similar scene; material law: other published"
    " sets of the alloy, with and without a bound on hardening; restitution and friction: through the collisions of the stream."
)


def tiles(metrics: dict) -> str:
    """The few numbers that a reader looks for first."""
    found = []
    for section, key in _HEADLINES:
        values = metrics.get(section, {})
        if key not in values:
            continue
        title, rows = ROWS[section]
        _, label, factor, unit, digits = next(row for row in rows if row[0] == key)
        value = shown(values, key, factor, unit, digits).replace("-", "−")
        half = _half(metrics, section, key)
        told = "" if half is None else f" ± {_half_text(half, factor, digits)} {unit}".rstrip()
        big = f"<b>{escape(value)}</b>" if values[key] is not None else f"<span>{escape(value)}</span>"
        found.append(f'<div class="tile"><small>{escape(title)}</small>{big}<small>{escape(label + told)}</small></div>')
    return f'<div class="tiles">{"".join(found)}</div>\n' if found else "<p>No stage has finished.</p>\n"


def warnings(metrics: dict) -> str:
    """The stages' warnings, which no reader should have to search for."""
    told = [
        (title, metrics[section]["warning"]) for section, (title, _) in ROWS.items() if metrics.get(section, {}).get("warning")
    ]  # fmt: skip
    table_told = metrics.get("uncertainty", {}).get("table", {}).get("warning")
    told += [("Uncertainty", table_told)] if table_told else []
    return "".join(f'<p class="warning">{escape(title)}: {escape(text)}</p>\n' for title, text in told)


def all_metrics(metrics: dict) -> str:
    """A table for each section of metrics.json: value, 95 % half width, and its part by cause, in printed units."""
    found = []
    for section, (title, rows) in ROWS.items():
        values = metrics.get(section)
        if not values:
            continue
        body = [_row(metrics, section, *row) for row in rows if row[0] in values and row[0] != "warning"]
        heads = ("", "value", "± 95 %", *(f"of it {cause}" for cause in CAUSES.values()), "unit")
        if all(row[2] == "" for row in body):  # nothing of the section has an interval
            heads, body = ("", "value", "unit"), [(row[0], row[1], row[-1]) for row in body]
        if body:
            found.append(f"<h3>{escape(title)}</h3>{table(heads, body, label=title, kind='numbers')}")
    note = f'<p class="note">{_EXPLAINED}</p>\n' if found and "uncertainty" in metrics else ""
    return note + "".join(found)


def _row(metrics: dict, section: str, key: str, label: str, factor: float | None, unit: str, digits: int) -> tuple:
    values = metrics[section]
    value = values[key]
    blank = [""] * (1 + len(CAUSES))
    if value is None:
        return (label, Cell(shown(values, key, factor, unit, digits), kind="missing long"), *blank, "")
    if factor is None:
        return (label, Cell(str(value), kind="number"), *blank, "")
    shown_value = number(shown(values, key, factor, "", digits), value * factor)
    found = metrics.get("uncertainty", {}).get(f"{section}.{key}")
    if not found:
        return (label, shown_value, *blank, unit)
    halves = [found["half_width_95"], *(found["by_cause"].get(cause) for cause in CAUSES)]
    cells = [Cell("unknown", "", "number") if h is None else number(_half_text(h, factor, digits), h * factor) for h in halves]
    return (label, shown_value, *cells, unit)


def _half(metrics: dict, section: str, key: str) -> float | None:
    found = metrics.get("uncertainty", {}).get(f"{section}.{key}")
    return None if not found or found["mostly"] is None else found["half_width_95"]


def _half_text(half: float, factor: float, digits: int) -> str:
    """A half width in its printed unit with one digit of it at least."""
    half *= factor
    return f"{half:.{max(digits, 0 if half == 0.0 else -math.floor(math.log10(half)))}f}" if half else "0"
