"""Small plots as SVG, drawn here: points with bars against one quantity, some joined up; light enough to put many on a page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import NamedTuple

import numpy as np

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_WIDTH, _HEIGHT = 360, 250
_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 12, 14, 46  # margins
_TICKS = 7  # at most


class Series(NamedTuple):
    """Points of one kind: ``x``, ``y`` (n,), ``bar`` (n,) half widths, nan where there is none; ``joined`` in order of x."""

    label: str
    x: np.ndarray
    y: np.ndarray
    bar: np.ndarray
    joined: bool = False


def plot(series: Sequence[Series], x_label: str, y_label: str, words: Sequence[str] = (), log: bool = False) -> str:
    """SVG text.  ``words``: what stands at x = 0, 1, … where the axis is not of numbers; ``log``: of x, all above 0."""
    if log:
        series = [s._replace(x=np.log10(s.x)) for s in series]
    x = np.concatenate([s.x for s in series])
    low = np.concatenate([s.y - np.nan_to_num(s.bar) for s in series])
    high = np.concatenate([s.y + np.nan_to_num(s.bar) for s in series])
    x_scale, y_scale = _scale(x.min(), x.max()), _scale(low.min(), high.max())

    def across(values):
        return _LEFT + (np.asarray(values) - x_scale[0]) / (x_scale[1] - x_scale[0]) * (_WIDTH - _LEFT - _RIGHT)

    def up(values):
        return _HEIGHT - _BOTTOM - (np.asarray(values) - y_scale[0]) / (y_scale[1] - y_scale[0]) * (_HEIGHT - _TOP - _BOTTOM)

    if words:
        ticks = list(enumerate(words))
    elif log:
        ticks = [(math.log10(t), f"{t:.10g}") for t in _log_ticks(*x_scale)]
    else:
        ticks = [(t, f"{t:.10g}") for t in _ticks(*x_scale)]
    parts = [_text(across(v), _HEIGHT - _BOTTOM + 15, _short(w), "middle", "t") for v, w in ticks]
    for v in _ticks(*y_scale):
        parts.append(f'<path class="g" d="M{_LEFT} {up(v):.1f}H{_WIDTH - _RIGHT}"/>')
        parts.append(_text(_LEFT - 6, up(v) + 4, _short(f"{v:.10g}"), "end", "t"))
    for k, s in enumerate(series):
        parts.append(_drawn(s, across(s.x), up(s.y), up(s.y - s.bar) - up(s.y), COLOURS[k % len(COLOURS)]))
    base, label = _HEIGHT - _BOTTOM, escape(f"{y_label} against {x_label}")
    parts.append(f'<path d="M{_LEFT} {_TOP}V{base}H{_WIDTH - _RIGHT}" fill="none" stroke="#404040"/>')
    parts.append(_text(0.5 * (_LEFT + _WIDTH - _RIGHT), _HEIGHT - 10, escape(x_label), "middle", "l"))
    style = "text{font:12px system-ui,sans-serif;fill:#1d1d1d}.t{font-size:11px;fill:#444}.g{stroke:#e6e6e6}"
    return f'<svg role="img" aria-label="{label}" viewBox="0 0 {_WIDTH} {_HEIGHT}"><style>{style}</style>{"".join(parts)}</svg>'


def legend(labels: Sequence[str]) -> str:
    """HTML of the colours' meaning, in the order that ``plot`` takes them."""
    items = (
        f'<span><span class="swatch" style="background:{COLOURS[k % len(COLOURS)]}"></span>{escape(label)}</span> '
        for k, label in enumerate(labels)
    )
    return f'<p class="legend">{"".join(items)}</p>\n'


def _text(x: float, y: float, words: str, anchor: str, kind: str) -> str:
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'


def _drawn(series: Series, x, y, bars, colour: str) -> str:
    order = np.argsort(x, kind="stable")
    line = ""
    if series.joined and x.size > 1:
        way = "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x[order], y[order]))
        line = f'<path d="M{way}" fill="none" stroke="{colour}" stroke-width="1.5"/>'
    barred = "".join(f"M{a:.1f} {b - h:.1f}v{2 * h:.1f}" for a, b, h in zip(x, y, bars) if h > 0.0)
    dots = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(x, y))
    return (
        f'{line}<path d="{barred}" stroke="{colour}" stroke-opacity=".45" stroke-width="1.2"/>'
        f'<path d="{dots}" stroke="{colour}" stroke-width="5.5" stroke-linecap="round"/>'
    )


def _scale(low: float, high: float) -> tuple[float, float]:
    """Ends of an axis that shows ``low`` to ``high`` with a rim."""
    reach = (high - low) or abs(high) or 1.0
    return low - 0.06 * reach, high + 0.06 * reach


def _ticks(low: float, high: float) -> list[float]:
    """Some four to seven round numbers from ``low`` to ``high``."""
    raw = (high - low) / _TICKS
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(k * power for k in (1, 2, 5, 10) if k * power >= raw)
    first = math.ceil(low / step)
    return [k * step for k in range(first, math.floor(high / step) + 1)]


def _log_ticks(low: float, high: float) -> list[float]:
    """Round numbers from 10^low to 10^high: as many of each decade as give four, at most _TICKS."""
    found: list[float] = []
    for digits in ((1,), (1, 3), (1, 2, 5), (1, 1.5, 2, 3, 5, 7)):
        decades = range(math.floor(low), math.ceil(high) + 1)
        found = [d * 10.0**k for k in decades for d in digits if low <= math.log10(d * 10.0**k) <= high]
        if len(found) >= 4:
            break
    else:
        found = found if len(found) >= 3 else _ticks(10.0**low, 10.0**high)
    return found[:: max(1, math.ceil(len(found) / _TICKS))]


def _short(word: str) -> str:
    word = word.replace("-", "−") if word.lstrip("-")[:1].isdigit() else word
    return escape(word if len(word) <= 14 else word[:13] + "…")
