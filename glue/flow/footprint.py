"""Where the shots strike if none meets another: expected impacts per area of the plane z = 0, in closed form.

A point of the plane is mapped back along its ray to the exit.  With k = tan(half angle) / R the ray through
the exit at (a, b) flies along w = d + k (a e1 + b e2), so a point at s along the axis from the exit and
(alpha, beta) across came from (a, b) = (alpha, beta) / (1 + k s), and per area of the plane arrive

    n(a, b) |w_z| / (1 + k s)^2

shots where n leave per area of the exit (n: the nozzle's profile).  Feeds and pulses are integrals of this
over time.  The edge of the footprint is a conic, so its chords along a path are exact; only the density
between is summed.  Time is when a shot leaves: the flight (stand-off over speed) is left out, as are gravity,
drag and collisions.  Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow.nozzle_draws import GAUSSIAN_SD_RADII, rates_1_s
from glue.flow.pulse import fed_time_s
from glue.scene.model import Nozzle, Scene

# Along a chord the density is summed at Gauss points.  Where a pulse goes with it, it is taken as even on pieces,
# and what is fed in each is exact: right to 1e-4 across a Gaussian jet.  An even parallel jet needs neither.
CHORD_NODES = 16
CHORD_PIECES = 96
NODES_PER_RADIUS = 24  # rows, and steps of a feed, per half width of the footprint


class Stretch(NamedTuple):
    """A time in which the nozzle stands still or travels straight."""

    begin_s: float
    end_s: float
    aim_m: tuple[float, float]  # at its beginning
    velocity_m_s: tuple[float, float]
    pass_id: int


def fluence_1_m2(
    scene: Scene,
    x_m,
    y_m,
    t_end: float | None = None,
    nozzle: int | None = None,
    pass_id: int | None = None,
    medium: int | None = None,
) -> np.ndarray:
    """Expected impacts per area [1/m^2] at the points (x, y), of shots that leave before ``t_end`` [s].

    ``t_end`` None: the whole exposure.  ``nozzle``, ``pass_id``, ``medium``: only that one's shots (as numbered
    in the arrivals).  ``x_m``, ``y_m`` broadcast; the result has their shape.
    Raises InputError for a jet that spreads above the horizon, whose footprint has no end.
    """
    x, y = np.broadcast_arrays(np.asarray(x_m, float), np.asarray(y_m, float))
    total = np.zeros(x.shape)
    for jet, rate, stretch in _parts(scene, t_end, nozzle, pass_id, medium):
        total += rate * _stretch_fluence_s_m2(jet, stretch, x, y)
    return total


def expected_impacts(
    scene: Scene,
    x0_m: float,
    x1_m: float,
    y0_m: float,
    y1_m: float,
    t_end: float | None = None,
    nozzle: int | None = None,
    pass_id: int | None = None,
    medium: int | None = None,
) -> float:
    """Expected number of impacts in the rectangle x0..x1, y0..y1 [m]; selection as ``fluence_1_m2``.

    Quadrature to about 3e-4 where sides cut the footprint; sides may be infinite.
    """
    total = 0.0
    for jet, rate, stretch in _parts(scene, t_end, nozzle, pass_id, medium):
        (cx, cy), half = _ellipse(jet)
        first, last = 0.0, stretch.end_s - stretch.begin_s  # while the footprint touches the rectangle
        for axis, (low, high) in enumerate(((x0_m, x1_m), (y0_m, y1_m))):
            start, speed = stretch.aim_m[axis] + (cx, cy)[axis], stretch.velocity_m_s[axis]
            low, high = low - half[axis] - start, high + half[axis] - start
            if speed:
                first, last = (
                    max(first, min(low / speed, high / speed)),
                    min(last, max(low / speed, high / speed)),
                )
            elif not low < 0.0 < high:
                last = first
        if last <= first:
            continue
        way = (last - first) * math.hypot(*stretch.velocity_m_s)
        edges = np.linspace(first, last, 1 + max(1, math.ceil(NODES_PER_RADIUS * way / min(half))))
        fed = np.diff(fed_time_s(jet.pulse, stretch.begin_s + edges))
        middle = 0.5 * (edges[1:] + edges[:-1])
        aim_x, aim_y = (stretch.aim_m[k] + stretch.velocity_m_s[k] * middle for k in (0, 1))
        y, weights = _nodes(
            *(np.clip(side - aim_y, cy - half[1], cy + half[1]) for side in (y0_m, y1_m)), half[1]
        )
        rows = _along(jet, 0.0, y, (1.0, 0.0), (x0_m - aim_x)[:, None], (x1_m - aim_x)[:, None])
        total += rate * float(fed @ (weights * rows).sum(axis=1))
    return total


def _parts(scene, t_end, nozzle, pass_id, medium) -> Iterator[tuple[Nozzle, float, Stretch]]:
    """(nozzle, its shots per second, stretch) for all that the selection takes."""
    t_end = scene.exposure_time_s if t_end is None else min(t_end, scene.exposure_time_s)
    for number, jet in enumerate(scene.nozzles):
        if nozzle not in (None, number):
            continue
        if not jet.divergence_half_angle_deg < jet.impact_angle_deg:
            raise InputError(
                f"nozzle.divergence_half_angle_deg = {jet.divergence_half_angle_deg}: the jet spreads above the"
                f" horizon; must be below the impact angle ({jet.impact_angle_deg} degrees)"
            )
        rates = rates_1_s(scene, jet)
        rate = sum(rates) if medium is None else rates[medium]
        for stretch in _stretches(jet, t_end):
            if pass_id in (None, stretch.pass_id):
                yield jet, rate, stretch


def _stretches(nozzle: Nozzle, t_end: float) -> Iterator[Stretch]:
    """Strokes and stays of the feed until ``t_end``, in order; after the last stroke the nozzle stays."""
    feed = nozzle.feed
    if feed is None:
        yield Stretch(0.0, t_end, nozzle.aim_m, (0.0, 0.0), 0)
        return
    stroke_s = feed.stroke_m / feed.speed_m_s
    for number in range(feed.passes):
        begin = number * (stroke_s + feed.dwell_s)
        (x1, y1, _), (x3, y3, _) = (nozzle.aim_at(begin + share * stroke_s) for share in (0.25, 0.75))
        velocity = ((x3 - x1) / (0.5 * stroke_s), (y3 - y1) / (0.5 * stroke_s))
        start, end = (1.5 * x1 - 0.5 * x3, 1.5 * y1 - 0.5 * y3), (1.5 * x3 - 0.5 * x1, 1.5 * y3 - 0.5 * y1)
        if begin < t_end:
            yield Stretch(begin, min(begin + stroke_s, t_end), start, velocity, number)
        stay_s = feed.dwell_s if number < feed.passes - 1 else math.inf
        if begin + stroke_s < t_end and stay_s > 0.0:
            yield Stretch(begin + stroke_s, min(begin + stroke_s + stay_s, t_end), end, (0.0, 0.0), number)


def _stretch_fluence_s_m2(jet: Nozzle, stretch: Stretch, x, y) -> np.ndarray:
    """Integral over the stretch of p(t) times the share of the shots per area at (x, y) [s/m^2]."""
    qx, qy = x - stretch.aim_m[0], y - stretch.aim_m[1]
    if stretch.velocity_m_s == (0.0, 0.0):
        fed = fed_time_s(jet.pulse, stretch.end_s) - fed_time_s(jet.pulse, stretch.begin_s)
        return fed * _density_1_m2(jet, qx, qy)
    back = (-stretch.velocity_m_s[0], -stretch.velocity_m_s[1])  # the point moves as seen from the nozzle
    lasts = stretch.end_s - stretch.begin_s
    fed = (lambda t: fed_time_s(jet.pulse, stretch.begin_s + t)) if jet.pulse else None
    return _along(jet, qx, qy, back, 0.0, lasts, fed)


def _along(jet: Nozzle, x, y, step: tuple[float, float], low, high, fed=None) -> np.ndarray:
    """Integral of the density at (x, y) + u ``step`` over u, or over d fed(u), for u from ``low`` to ``high``."""
    first, last = _chord(jet, x, y, step)
    first, last = np.clip(first, low, high), np.clip(last, low, high)
    even = jet.profile == "uniform" and jet.divergence_half_angle_deg == 0.0
    total = np.zeros(np.shape(first))
    if fed is None:
        for node, weight in zip(*np.polynomial.legendre.leggauss(1 if even else CHORD_NODES)):
            u = first + 0.5 * (1.0 + node) * (last - first)
            total += 0.5 * weight * _density_1_m2(jet, x + u * step[0], y + u * step[1])
        return total * (last - first)
    pieces = 1 if even else CHORD_PIECES
    piece = (last - first) / pieces
    before = fed(first)
    for number in range(pieces):
        middle, after = first + (number + 0.5) * piece, fed(first + (number + 1) * piece)
        total += (after - before) * _density_1_m2(jet, x + middle * step[0], y + middle * step[1])
        before = after
    return total


def _tangent_1_m(jet: Nozzle) -> float:
    """k: tangent of a ray's tilt over its distance from the axis at the exit [1/m]."""
    return math.tan(math.radians(jet.divergence_half_angle_deg)) / (0.5 * jet.jet_diameter_m)


def _density_1_m2(jet: Nozzle, x, y) -> np.ndarray:
    """Share of the shots per area of z = 0 [1/m^2] at (x, y) from the aim point."""
    radius, k, d, (up, level) = 0.5 * jet.jet_diameter_m, _tangent_1_m(jet), jet.direction, jet.exit_axes
    grown = 1.0 + k * (x * d[0] + y * d[1] + jet.stand_off_m)
    a, b = (x * up[0] + y * up[1]) / grown, (x * level[0] + y * level[1]) / grown
    square = (a * a + b * b) / radius**2
    if jet.profile == "uniform":
        leave = np.where(square < 1.0, 1.0 / (math.pi * radius**2), 0.0)
    else:
        half = 0.5 / GAUSSIAN_SD_RADII**2
        leave = np.where(square < 1.0, np.exp(-half * square), 0.0)
        leave *= half / (math.pi * radius**2 * (1.0 - math.exp(-half)))
    return leave * -(d[2] + k * a * up[2]) / grown**2


def _conic(jet: Nozzle) -> tuple[np.ndarray, np.ndarray, float]:
    """M (2, 2), g (2,), c with q M q + 2 g q + c <= 0 in the footprint, q from the aim point.

    From alpha^2 + beta^2 <= R^2 (1 + k s)^2.
    """
    radius, k = 0.5 * jet.jet_diameter_m, _tangent_1_m(jet)
    d = np.array(jet.direction[:2])
    up, level = (np.array(axis[:2]) for axis in jet.exit_axes)
    at_aim = 1.0 + k * jet.stand_off_m
    M = np.outer(up, up) + np.outer(level, level) - (radius * k) ** 2 * np.outer(d, d)
    return M, -(radius**2) * k * at_aim * d, -((radius * at_aim) ** 2)


def _ellipse(jet: Nozzle) -> tuple[np.ndarray, np.ndarray]:
    """Centre and half widths in x and y [m] of the footprint, from the aim point, each (2,)."""
    M, g, c = _conic(jet)
    inverse = np.linalg.inv(M)
    centre = -inverse @ g
    return centre, np.sqrt((g @ inverse @ g - c) * np.diag(inverse))


def _chord(jet: Nozzle, x, y, step: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """The u between which (x, y) + u ``step`` lies in the footprint; equal where it never does."""
    M, g, c = _conic(jet)
    u = np.array(step)
    Mu = M @ u
    curve, slope = u @ Mu, x * Mu[0] + y * Mu[1] + g @ u
    value = M[0, 0] * x * x + 2.0 * M[0, 1] * x * y + M[1, 1] * y * y + 2.0 * (g[0] * x + g[1] * y) + c
    half = np.sqrt(np.maximum(slope * slope - curve * value, 0.0))
    return (-slope - half) / curve, (-slope + half) / curve


def _nodes(low: np.ndarray, high: np.ndarray, half_width: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (n, m) on n ranges; denser at the ends, where a chord's length falls as a square root."""
    widest = float((high - low).max()) / half_width
    angle, weight = np.polynomial.legendre.leggauss(max(math.ceil(NODES_PER_RADIUS * widest), 12))
    angle, weight = 0.5 * math.pi * angle, 0.5 * math.pi * weight
    middle, half = 0.5 * (low + high)[:, None], 0.5 * (high - low)[:, None]
    return middle + half * np.sin(angle), half * np.cos(angle) * weight
