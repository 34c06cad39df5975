"""The target's surface for the event loop: when and where does a flying shot touch it next?

``glue.flow.touch`` has the shapes; here the plane also knows a gravity that bends the flight.  Other shapes
see straight flight only (gravity then comes as kicks).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.flow import touch
from glue.flow.event_compile import part
from glue.flow.surface import CYLINDER, PLANE, TargetSurface

touch_cylinder = part(touch.touch_cylinder)
touch_face = part(touch.touch_face)
touch_edge = part(touch.touch_edge)
touch_corner = part(touch.touch_corner)


LEAF = 4  # triangles in the innermost boxes


class Shape(NamedTuple):
    """A ``TargetSurface`` as plain arrays."""

    kind: int  # 0 plane, 1 cylinder, 2 triangles
    radius_m: float
    axis: int
    boxes: (
        np.ndarray
    )  # (k, 6) tree of boxes around triangles: lower, upper corner [m]; children follow parents
    beyond: np.ndarray  # (k,) the next box that is not inside this one
    leaves: (
        np.ndarray
    )  # (k, 2) first and last + 1 of the box's own rows below; empty but in the innermost boxes
    faces: np.ndarray  # as in triangles.features
    edges: np.ndarray
    corners: np.ndarray
    face_edges: np.ndarray  # (m, 3), -1: none
    face_corners: np.ndarray  # (m, 3), -1: none


def shape_of(surface: TargetSurface) -> Shape:
    """The arrays of ``surface``."""
    if surface.kind in (PLANE, CYLINDER):
        kind = 0 if surface.kind == PLANE else 1
        rows, numbers, index = np.zeros((0, 1)), np.zeros(0, np.int64), np.zeros((0, 2), np.int64)
        return Shape(
            *(
                kind,
                surface.radius_m,
                surface.axis_number,
                rows,
                numbers,
                index,
                rows,
                rows,
                rows,
                index,
                index,
            )
        )
    f = surface.features
    boxes, beyond, leaves, order = _tree(surface.triangles)
    return Shape(
        2,
        0.0,
        0,
        boxes,
        beyond,
        leaves,
        np.ascontiguousarray(f.faces[order], float),
        np.ascontiguousarray(f.edges, float).reshape(-1, 7),
        np.ascontiguousarray(f.corners, float).reshape(-1, 3),
        _padded(f.face_edges)[order],
        _padded(f.face_corners)[order],
    )


def _tree(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(boxes, beyond, leaves) of ``Shape`` and the order of the triangles in it: halves of halves, widest side."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    boxes, beyond, leaves, order = [], [], [], []

    def grow(some: np.ndarray) -> None:
        k = len(boxes)
        boxes.append([*low[some].min(axis=0), *high[some].max(axis=0)])
        beyond.append(0)
        leaves.append([0, 0])
        if len(some) <= LEAF:
            leaves[k] = [len(order), len(order) + len(some)]
            order.extend(some.tolist())
        else:
            middle = (low + high)[some]
            some = some[np.argsort(middle[:, np.ptp(middle, axis=0).argmax()], kind="stable")]
            grow(some[: len(some) // 2])
            grow(some[len(some) // 2 :])
        beyond[k] = len(boxes)

    grow(np.arange(len(triangles)))
    return np.array(boxes), np.array(beyond), np.array(leaves), np.array(order)


def _padded(lists) -> np.ndarray:
    out = np.full((len(lists), 3), -1, np.int64)
    for row, some in zip(out, lists):
        row[: len(some)] = some
    return out


@part
def foresee_touch(shape, shot, gravity):
    """Set the time at which ``shot`` touches the target next (inf: never) and the outward normal there."""
    if shape.kind == 0:
        shot.t_surface = plane_time(shot, gravity)
        shot.nx, shot.ny, shot.nz = 0.0, 0.0, 1.0
        return
    if shape.kind == 1:
        hit = touch_cylinder(
            shot.x, shot.y, shot.z, shot.vx, shot.vy, shot.vz, shot.radius, shape.radius_m, shape.axis
        )
    else:
        hit = _touch_triangles(shape, shot)
    shot.t_surface = shot.since + hit[0]
    shot.nx, shot.ny, shot.nz = hit[4], hit[5], hit[6]


@part
def plane_time(shot, gravity):
    """Time at which the shot touches the plane z = 0 from above, inf if it never does."""
    gap, v, g = max(shot.z - shot.radius, 0.0), shot.vz, gravity[2]
    if g == 0.0:
        return shot.since + gap / -v if v < 0.0 else math.inf
    root2 = v * v - 2.0 * g * gap
    if v < 0.0:
        return shot.since + 2.0 * gap / (math.sqrt(root2) - v) if root2 >= 0.0 else math.inf
    return shot.since + (v + math.sqrt(root2)) / -g if g < 0.0 else math.inf


@part
def _touch_triangles(shape, shot):
    px, py, pz, vx, vy, vz, r = shot.x, shot.y, shot.z, shot.vx, shot.vy, shot.vz, shot.radius
    best = (math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    k = 0
    while k < len(shape.boxes):
        if not _passes(shape.boxes[k], px, py, pz, vx, vy, vz, r, best[0]):
            k = shape.beyond[k]
            continue
        for row in range(shape.leaves[k, 0], shape.leaves[k, 1]):
            hit = touch_face(px, py, pz, vx, vy, vz, r, shape.faces[row])
            if hit[0] < best[0]:
                best = hit
            for e in shape.face_edges[row]:
                if e >= 0:
                    hit = touch_edge(px, py, pz, vx, vy, vz, r, shape.edges[e])
                    if hit[0] < best[0]:
                        best = hit
            for c in shape.face_corners[row]:
                if c >= 0:
                    hit = touch_corner(px, py, pz, vx, vy, vz, r, shape.corners[c])
                    if hit[0] < best[0]:
                        best = hit
        k += 1
    return best


@part
def _passes(box, px, py, pz, vx, vy, vz, r, latest):
    """Whether a sphere's centre comes within ``r`` of the box (as seen along each axis) before ``latest``."""
    reach = r * (1.0 + 1e-9)
    begin, end = _span(box[0] - reach - px, box[3] + reach - px, vx, 0.0, latest)
    begin, end = _span(box[1] - reach - py, box[4] + reach - py, vy, begin, end)
    begin, end = _span(box[2] - reach - pz, box[5] + reach - pz, vz, begin, end)
    return begin <= end


@part
def _span(low, high, v, begin, end):
    """The part of [begin, end] in which v t lies in [low, high]; empty (begin > end) if there is none."""
    if v == 0.0:
        return (begin, end) if low <= 0.0 <= high else (math.inf, -math.inf)
    if v < 0.0:
        low, high = high, low
    return max(begin, low / v), min(end, high / v)
