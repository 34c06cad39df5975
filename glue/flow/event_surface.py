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


class Shape(NamedTuple):
    """A ``TargetSurface`` as plain arrays."""

    kind: int  # 0 plane, 1 cylinder, 2 triangles
    radius_m: float
    axis: int
    balls: np.ndarray  # (m, 4) bounding spheres of the triangles: middle, radius [m]
    faces: np.ndarray  # as in triangles.features
    edges: np.ndarray
    corners: np.ndarray
    face_edges: np.ndarray  # (m, 3), -1: none
    face_corners: np.ndarray  # (m, 3), -1: none


def shape_of(surface: TargetSurface) -> Shape:
    """The arrays of ``surface``."""
    if surface.kind in (PLANE, CYLINDER):
        no_rows, no_index = np.zeros((0, 1)), np.zeros((0, 3), np.int64)
        kind = 0 if surface.kind == PLANE else 1
        return Shape(
            kind,
            surface.radius_m,
            surface.axis_number,
            no_rows,
            no_rows,
            no_rows,
            no_rows,
            no_index,
            no_index,
        )
    f = surface.features
    low, high = surface.triangles.min(axis=1), surface.triangles.max(axis=1)
    middle = 0.5 * (low + high)
    reach = np.sqrt(((surface.triangles - middle[:, None]) ** 2).sum(axis=2).max(axis=1))
    return Shape(
        2,
        0.0,
        0,
        np.column_stack([middle, reach]),
        np.ascontiguousarray(f.faces, float),
        np.ascontiguousarray(f.edges, float).reshape(-1, 7),
        np.ascontiguousarray(f.corners, float).reshape(-1, 3),
        _padded(f.face_edges),
        _padded(f.face_corners),
    )


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
    speed2 = vx * vx + vy * vy + vz * vz
    if speed2 == 0.0:
        return best
    for k in range(len(shape.balls)):
        qx, qy, qz = shape.balls[k, 0] - px, shape.balls[k, 1] - py, shape.balls[k, 2] - pz
        reach = shape.balls[k, 3] + r * (1.0 + 1e-9)
        along = (qx * vx + qy * vy + qz * vz) / speed2  # time of passing the middle
        apart2 = qx * qx + qy * qy + qz * qz
        if apart2 - along * along * speed2 > reach * reach or along < 0.0 and apart2 > reach * reach:
            continue
        hit = touch_face(px, py, pz, vx, vy, vz, r, shape.faces[k])
        if hit[0] < best[0]:
            best = hit
        for e in shape.face_edges[k]:
            if e >= 0:
                hit = touch_edge(px, py, pz, vx, vy, vz, r, shape.edges[e])
                if hit[0] < best[0]:
                    best = hit
        for c in shape.face_corners[k]:
            if c >= 0:
                hit = touch_corner(px, py, pz, vx, vy, vz, r, shape.corners[c])
                if hit[0] < best[0]:
                    best = hit
    return best
