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
_NARROW = "\u00a0"  # keeps a number and its unit on one line
_EXPLAINED = (
    "Intervals hold 95 %, and the columns after them say what they are made of; causes are independent and add by squares."
    " Statistical: other arrivals of the same stream; numerical: meshes, steps, rasters and models, as measured on the most"
    " similar scene; material law: other published sets of the alloy, with and without a bound on"
    " hardening; restitution and friction: through the collisions of the stream."
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
        told = "" if half is None else f" ±{_NARROW}{_half_text(half, factor, digits)}{_NARROW}{unit}".rstrip()
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
        known = any(f"{section}.{row[0]}" in metrics.get("uncertainty", {}) for row in rows)
        body = [_row(metrics, section, known, *row) for row in rows if row[0] in values and row[0] != "warning"]
        heads = ("", "value", "± 95 %", "unit", *CAUSES.values()) if known else ("", "value", "unit")
        if body:
            kind = "numbers" if known else "numbers few"
            found.append(table(heads, body, label=title, titled=True, kind=kind))
    note = f'<p class="note">{_EXPLAINED}</p>\n' if found and "uncertainty" in metrics else ""
    return note + "".join(found)


def _row(
    metrics: dict, section: str, intervals: bool, key: str, label: str, factor: float | None, unit: str, digits: int
) -> tuple:
    """A metric as cells: label, value, half width, unit, causes; without ``intervals`` label, value, unit."""
    values = metrics[section]
    value = values[key]
    if value is None or factor is None:
        text = shown(values, key, factor, unit, digits)
        return (label, Cell(text, kind="missing" if value is None else "words", span=3 + len(CAUSES) if intervals else 2))
    first = (label, number(shown(values, key, factor, "", digits), value * factor))
    found = metrics.get("uncertainty", {}).get(f"{section}.{key}")
    if not intervals:
        return (*first, unit)
    if not found:
        return (*first, "", unit, *[""] * len(CAUSES))
    halves = [found["half_width_95"], *(found["by_cause"].get(cause) for cause in CAUSES)]
    cells = [Cell("unknown", "", "number") if h is None else number(_half_text(h, factor, digits), h * factor) for h in halves]
    return (*first, cells[0], unit, *cells[1:])


def _half(metrics: dict, section: str, key: str) -> float | None:
    found = metrics.get("uncertainty", {}).get(f"{section}.{key}")
    return None if not found or found["mostly"] is None else found["half_width_95"]


def _half_text(half: float, factor: float, digits: int) -> str:
    """A half width in its printed unit with one digit of it at least."""
    half *= factor
    return f"{half:.{max(digits, 0 if half == 0.0 else -math.floor(math.log10(half)))}f}" if half else "0"
