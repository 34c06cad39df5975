"""The impact map with a time slider: dimples to scale as an SVG picture, which a few lines of script hide and show.

The picture itself is the data: its marks stand in order of time, and beside it is only how many of them each time has.  So
it shows the last state on paper and where scripts do not run.
"""

from __future__ import annotations

import json
import math
from html import escape
from typing import NamedTuple

import numpy as np

MOST_DIMPLES = 4000  # some 250 kB of page; more of them are cut down to a smaller square in the middle
_STEPS = 200  # of the slider where no coverage curve gives its times
_ROUND = 1.01  # a dimple less long than this is drawn as a circle


class Dimples(NamedTuple):
    """Dimples that reach into the part of the window shown, in order of time; columns (n,)."""

    x_m: np.ndarray
    y_m: np.ndarray
    semi_major_m: np.ndarray
    semi_minor_m: np.ndarray
    azimuth_rad: np.ndarray
    time_s: np.ndarray
    part_m: tuple[float, float]  # sides of the part shown, in the middle of the window


def in_part(x_m, y_m, semi_major_m, semi_minor_m, azimuth_rad, time_s, window_m, most: int = MOST_DIMPLES) -> Dimples:
    """Dimples that reach into the window, or into the largest part of it (same shape, same middle) that ``most`` reach.

    All columns (n,); window_m: (width, height).
    """
    columns = [np.asarray(c, dtype=float) for c in (x_m, y_m, semi_major_m, semi_minor_m, azimuth_rad, time_s)]
    x, y, major, minor = columns[:4]
    # the share of the window at which each is first seen, by the square that holds its ellipse
    share = np.maximum((np.abs(x) - major) / (0.5 * window_m[0]), (np.abs(y) - major) / (0.5 * window_m[1]))
    share[minor <= 0.0] = np.inf
    inside = share < 1.0
    factor = 1.0
    if np.count_nonzero(inside) > most:
        factor = float(np.partition(share, most)[most])
        inside = share < factor
    kept = np.flatnonzero(inside)
    kept = kept[np.argsort(columns[5][kept], kind="stable")]
    return Dimples(*(column[kept] for column in columns), (factor * window_m[0], factor * window_m[1]))


def impact_slider(dimples: Dimples, window_m, end_s: float, curve: tuple[np.ndarray, np.ndarray] | None) -> str:
    """HTML of the map.  ``curve``: (time_s, coverage), each (k,), as coverage.csv has them, or None; ``end_s``: last time."""
    times = np.linspace(0.0, end_s, _STEPS + 1) if curve is None else np.asarray(curve[0], dtype=float)
    shown = np.searchsorted(dimples.time_s, times, side="right")
    shown[-1] = len(dimples.time_s)  # whatever the last digit of the last time
    data = {"time_s": [float(f"{t:.6g}") for t in times], "shown": shown.tolist()}
    if curve is not None:
        data["coverage"] = [float(f"{c:.6g}") for c in curve[1]]
    part = tuple(1e3 * side for side in dimples.part_m)
    whole = part[0] >= 0.9999e3 * window_m[0]
    title = "Impacts in the window" if whole else "Impacts in the middle of the window"
    caption = f"{part[0]:.3g} × {part[1]:.3g} mm. Dimples to scale; the darker, the more often struck; white: bare."
    if not whole:
        all_of_it = f"{1e3 * window_m[0]:g} × {1e3 * window_m[1]:g} mm"
        caption += f" All {all_of_it} hold too many dimples to draw; coverage is of all of them."
    final = f"{times[-1]:.3f} s: " + (f"coverage {100 * curve[1][-1]:.1f} %, " if curve else "") + f"{shown[-1]} dimples"
    return (
        f'<figure class="dimples"><h3>{escape(title)}</h3>\n{_picture(dimples, title)}\n'
        f'<div class="controls"><output id="dimples-now">{final}</output>'
        '<input type="range" min="0" step="1" hidden aria-label="exposure time" aria-describedby="dimples-now">'
        "<small hidden>Drag the slider or use the arrow keys; orange: struck since its step before.</small></div>"
        f"<figcaption>{escape(caption)}</figcaption>"
        f'<script type="application/json">{json.dumps(data, separators=(",", ":"))}</script></figure>\n'
    )


def _picture(dimples: Dimples, title: str) -> str:
    """SVG in whole micrometres, y upwards; the frame is the part shown, with a scale bar below."""
    width, height = (1e6 * side for side in dimples.part_m)
    bar = _round_length(0.3 * width)
    size = 0.035 * max(width, height)
    marks = "".join(_mark(*row) for row in zip(*dimples[:5], strict=True))
    left, top = -0.5 * width, -0.5 * height
    rim = 0.01 * width
    text = f"{bar / 1e3:g} mm" if bar >= 100 else f"{bar:g} µm"
    base = 0.5 * height + 1.1 * size
    return (
        f'<svg role="img" aria-label="{escape(title)}: the last state of {len(dimples.x_m)} dimples"'
        f' viewBox="{left - rim:.0f} {top - rim:.0f} {width + 2 * rim:.0f} {height + 2 * rim + 2.0 * size:.0f}">'
        f'<clipPath id="window"><rect x="{left:.0f}" y="{top:.0f}" width="{width:.0f}" height="{height:.0f}"/></clipPath>'
        f'<g clip-path="url(#window)"><g class="marks">{marks}</g></g>'
        f'<rect x="{left:.0f}" y="{top:.0f}" width="{width:.0f}" height="{height:.0f}" fill="none" stroke="#d55e00"'
        f' stroke-width="{0.004 * width:.1f}"/>'
        f'<path d="M{left:.0f} {base:.0f}h{bar:.0f}" stroke="#1d1d1d" stroke-width="{0.2 * size:.1f}"/>'
        f'<text x="{left + bar + 0.4 * size:.0f}" y="{base + 0.35 * size:.0f}" font-size="{size:.0f}" fill="#1d1d1d">'
        f"{text}</text></svg>"
    )


def _mark(x, y, major, minor, azimuth) -> str:
    x, y, major, minor = (f"{1e6 * v:.0f}" for v in (x, -y, major, minor))
    if float(major) < _ROUND * float(minor) + 1.0:
        return f'<circle cx="{x}" cy="{y}" r="{minor}"/>'
    turn = f' transform="rotate({-math.degrees(azimuth):.1f} {x} {y})"'
    return f'<ellipse cx="{x}" cy="{y}" rx="{major}" ry="{minor}"{turn}/>'


def _round_length(most: float) -> float:
    """The largest of 1, 2, 5 times a power of ten not above ``most``."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(k * power for k in (1, 2, 5) if k * power <= most)
