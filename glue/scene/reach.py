"""Where a jet lands on z = 0 and how near its exit is to it: closed-form geometry of one nozzle.

A diverging jet is a cone with its apex behind the exit; it meets the plane in an ellipse whose middle lies
beyond the aim point.  Standard library only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from glue.scene.fields import show
from glue.scene.model import Nozzle

Point = tuple[float, float]


class Ellipse(NamedTuple):
    """A jet's footprint on z = 0: its middle from the aim point along the lean, and its semi-axes [m]."""

    beyond_m: float
    along_m: float
    across_m: float


def footprint(nozzle: Nozzle) -> Ellipse:
    """The exact footprint of a jet whose flattest shots still fly downwards (divergence < impact angle)."""
    a = math.radians(nozzle.impact_angle_deg)
    spread = math.radians(nozzle.divergence_half_angle_deg)
    radius, stand_off = 0.5 * nozzle.jet_diameter_m, nozzle.stand_off_m
    sine, cosine = math.sin(a), math.cos(a) if nozzle.impact_angle_deg != 90.0 else 0.0
    # where the shots of the exit's upper and lower edge land, in the plane of the lean
    far = -stand_off * cosine + radius * sine + (stand_off * sine + radius * cosine) / math.tan(a - spread)
    near = -stand_off * cosine - radius * sine + (stand_off * sine - radius * cosine) / math.tan(a + spread)
    beyond = 0.5 * (far + near) if spread else 0.0
    at_middle = radius + (stand_off + beyond * cosine) * math.tan(spread)
    return Ellipse(beyond, 0.5 * (far - near), math.sqrt(at_middle**2 - (beyond * sine) ** 2))


def half_width_m(nozzle: Nozzle, direction_deg: float) -> float:
    """Half of the footprint's extent [m] along a direction in the plane (from +x)."""
    ellipse, turn = footprint(nozzle), math.radians(direction_deg - nozzle.azimuth_deg)
    return math.hypot(ellipse.along_m * math.cos(turn), ellipse.across_m * math.sin(turn))


def middle_m(nozzle: Nozzle) -> Point:
    """Middle of the footprint on z = 0 [m]; of its path, with a feed."""
    p, beyond = math.radians(nozzle.azimuth_deg), footprint(nozzle).beyond_m
    return nozzle.aim_m[0] + beyond * math.cos(p), nozzle.aim_m[1] + beyond * math.sin(p)


def inlet_clearance_m(nozzle: Nozzle, largest_diameter_m: float) -> float:
    """How far [m] the lowest shot's centre leaves the exit above what it needs: one largest shot over z = 0.

    Nearer, a shot touches the target, or one that has just bounced, before it is wholly out of the exit.
    """
    angle = math.radians(nozzle.impact_angle_deg)
    lean = math.cos(angle) if nozzle.impact_angle_deg != 90.0 else 0.0
    return nozzle.stand_off_m * math.sin(angle) - 0.5 * nozzle.jet_diameter_m * lean - largest_diameter_m


def inlet_clearance_problem(nozzle: Nozzle, largest_diameter_m: float) -> str | None:
    """Why this stand-off is too short for shots of up to ``largest_diameter_m`` [m], or None."""
    clearance = inlet_clearance_m(nozzle, largest_diameter_m)
    if clearance > 0.0:
        return None
    least = nozzle.stand_off_m - clearance / math.sin(math.radians(nozzle.impact_angle_deg))
    return (
        f"{show(nozzle.stand_off_m)} m leaves the lower edge of the nozzle's exit less than one shot "
        f"({show(largest_diameter_m)} m) above the target at this angle, so that shots overlap there; "
        f"allowed above {show(least)} m"
    )


def needed_stroke_m(nozzle: Nozzle, window_m: Point, margin_m: float) -> float:
    """Stroke [m] that carries the whole footprint over the whole window and off it, both ways."""
    along = nozzle.feed.direction_deg
    c, s = math.cos(math.radians(along)), math.sin(math.radians(along))
    x, y = middle_m(nozzle)
    window = (0.5 * window_m[0] + margin_m) * abs(c) + (0.5 * window_m[1] + margin_m) * abs(s)
    return 2.0 * (window + half_width_m(nozzle, along) + abs(x * c + y * s))


def covers(nozzle: Nozzle, window_m: Point, margin_m: float) -> bool:
    """Whether the (swept) footprint holds the window, grown by ``margin_m`` all round; a long enough stroke taken."""
    if nozzle.feed is None:
        corners = _to_circle(nozzle, _corners(window_m, margin_m), middle_m(nozzle))
        return all(math.hypot(*corner) <= 1.0 for corner in corners)
    feed = nozzle.feed
    c, s = math.cos(math.radians(feed.direction_deg)), math.sin(math.radians(feed.direction_deg))
    x, y = middle_m(nozzle)
    window = (0.5 * window_m[0] + margin_m) * abs(s) + (0.5 * window_m[1] + margin_m) * abs(c)
    band = half_width_m(nozzle, feed.direction_deg + 90.0)
    reached = -window  # across the feed, from the window's one side to the other
    for number in range(feed.passes):
        middle = y * c - x * s + (number - 0.5 * (feed.passes - 1)) * feed.pitch_m
        if middle - band <= reached:
            reached = max(reached, middle + band)
    return reached >= window


def misses(nozzle: Nozzle, window_m: Point) -> bool:
    """Whether no shot of this nozzle, undisturbed, lands in the window."""
    x, y = middle_m(nozzle)
    ends = [((x, y), (x, y))]
    if feed := nozzle.feed:
        c, s = math.cos(math.radians(feed.direction_deg)), math.sin(math.radians(feed.direction_deg))
        ends = []
        for number in range(feed.passes):
            across = (number - 0.5 * (feed.passes - 1)) * feed.pitch_m
            ends.append(
                tuple(
                    (x + along * c - across * s, y + along * s + across * c)
                    for along in (-0.5 * feed.stroke_m, 0.5 * feed.stroke_m)
                )
            )
    window = _to_circle(nozzle, _corners(window_m, 0.0), (0.0, 0.0))
    paths = (_to_circle(nozzle, pair, (0.0, 0.0)) for pair in ends)
    return all(_gap(window, *path) >= 1.0 for path in paths)


def largest_square_m(nozzle: Nozzle, margin_m: float) -> float:
    """Side [m] of the largest square window that the (swept) footprint holds with its margin; 0: none."""
    low, high = (
        0.0,
        4.0
        * (footprint(nozzle).along_m + (nozzle.feed.passes * nozzle.feed.pitch_m if nozzle.feed else 0.0)),
    )
    for _ in range(60):
        side = 0.5 * (low + high)
        low, high = (side, high) if covers(nozzle, (side, side), margin_m) else (low, side)
    return low


def _corners(window_m: Point, margin_m: float) -> list[Point]:
    a, b = 0.5 * window_m[0] + margin_m, 0.5 * window_m[1] + margin_m
    return [(a, b), (-a, b), (-a, -b), (a, -b)]


def _to_circle(nozzle: Nozzle, points, middle: Point) -> list[Point]:
    """Points in the frame in which the footprint around ``middle`` is the unit circle."""
    ellipse, p = footprint(nozzle), math.radians(nozzle.azimuth_deg)
    c, s = math.cos(p), math.sin(p)
    moved = [(x - middle[0], y - middle[1]) for x, y in points]
    return [((x * c + y * s) / ellipse.along_m, (y * c - x * s) / ellipse.across_m) for x, y in moved]


def _gap(polygon: list[Point], a: Point, b: Point) -> float:
    """Distance from the segment a-b to a convex polygon (corners anticlockwise); 0 when they meet."""
    sides = list(zip(polygon, polygon[1:] + polygon[:1]))
    if all(_left(p, q, a) >= 0.0 for p, q in sides):
        return 0.0
    if any(_left(p, q, a) * _left(p, q, b) < 0.0 and _left(a, b, p) * _left(a, b, q) < 0.0 for p, q in sides):
        return 0.0
    return min(
        min(_to_segment(point, p, q) for p, q in sides for point in (a, b)),
        min(_to_segment(corner, a, b) for corner in polygon),
    )


def _left(p: Point, q: Point, r: Point) -> float:
    """Positive when r lies to the left of p-q."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def _to_segment(point: Point, p: Point, q: Point) -> float:
    dx, dy = q[0] - p[0], q[1] - p[1]
    length2 = dx * dx + dy * dy
    along = ((point[0] - p[0]) * dx + (point[1] - p[1]) * dy) / length2 if length2 else 0.0
    along = min(max(along, 0.0), 1.0)
    return math.hypot(point[0] - p[0] - along * dx, point[1] - p[1] - along * dy)
