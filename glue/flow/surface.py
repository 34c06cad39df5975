"""The target's surface as the shots meet it: a plane, a convex cylinder, or a closed surface of triangles.

Axes as in ``glue.scene.model``: every surface passes through the origin with its outward normal up, the body
below.  Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError
from glue.flow import touch
from glue.flow.triangles import check_triangles, features, height, nearest, placement_problems

__all__ = ["TargetSurface", "check_triangles", "from_scene", "load", "placement_problems"]

PLANE, CYLINDER, TRIANGLES = "plane", "cylinder", "triangles"


class TargetSurface:
    """``kind`` "plane", "cylinder" (``radius_m``, ``axis`` "x" or "y") or "triangles" ((m, 3, 3) [m]).

    Raises InputError for triangles that make no closed, outward surface.
    """

    def __init__(self, kind: str = PLANE, radius_m: float = 0.0, axis: str = "y", triangles=None):
        if kind not in (PLANE, CYLINDER, TRIANGLES) or axis not in ("x", "y"):
            raise InputError(f"target surface: kind {kind!r}, axis {axis!r} are not known")
        if kind == CYLINDER and not 0.0 < radius_m < math.inf:
            raise InputError(f"target surface: radius_m = {radius_m}: must be positive and finite")
        self.kind, self.radius_m, self.axis = kind, float(radius_m), axis
        self.axis_number = "xy".index(axis)  # for touch_cylinder
        self.triangles = None
        if kind == TRIANGLES:
            self.triangles = np.ascontiguousarray(triangles, float)
            problems = check_triangles(self.triangles)
            if problems:
                raise InputError([f"target surface: {sentence}" for sentence in problems])
            self.features = features(self.triangles)
            self._prepare()

    def touch(self, p, v, r: float):
        """First touch of a sphere of radius ``r`` [m] flying straight from ``p`` [m] at ``v`` [m/s].

        Returns (t, (x, y, z), (nx, ny, nz)): time [s] (inf: never), touched point, outward normal there; see
        ``touch.py``.
        """
        if self.kind == PLANE:
            hit = touch.touch_plane(*p, *v, r)
        elif self.kind == CYLINDER:
            hit = touch.touch_cylinder(*p, *v, r, self.radius_m, self.axis_number)
        else:
            hit = self._touch_triangles(*p, *v, r)
        return hit[0], hit[1:4], hit[4:7]

    def clearance(self, point) -> float:
        """Distance [m] of a point from the surface, negative inside the body."""
        return self.nearest(point)[0]

    def nearest(self, point):
        """(distance [m], foot (x, y, z), normal (nx, ny, nz)): the surface point nearest to a point.

        The distance is negative inside the body; the normal points outwards.
        """
        x, y, z = (float(c) for c in point)
        if self.kind == PLANE:
            return z, (x, y, 0.0), (0.0, 0.0, 1.0)
        if self.kind == CYLINDER:
            across, up = (y if self.axis == "x" else x), z + self.radius_m
            size = math.hypot(across, up)
            a, u = (across / size, up / size) if size > 0.0 else (0.0, 1.0)
            foot, height = self.radius_m * a, self.radius_m * (u - 1.0)
            if self.axis == "x":
                return size - self.radius_m, (x, foot, height), (0.0, a, u)
            return size - self.radius_m, (foot, y, height), (a, 0.0, u)
        p = np.array([x, y, z])
        square = self._middle2 - 2.0 * (self._middle @ p) + (x * x + y * y + z * z)
        middle = np.sqrt(np.maximum(square, 0.0))
        some = np.flatnonzero(middle - self._reach <= (middle + self._reach).min() * (1.0 + 1e-9))
        distance, foot, normal = nearest(self.triangles[some], self.features.faces[some, :3], p)
        return distance, tuple(foot.tolist()), tuple(normal.tolist())

    def height(self, x: float, y: float) -> float:
        """z [m] of the surface seen from above at (x, y) [m]; -inf beside the body."""
        if self.kind == PLANE:
            return 0.0
        if self.kind == CYLINDER:
            across = y if self.axis == "x" else x
            inside = self.radius_m**2 - across**2
            return math.sqrt(inside) - self.radius_m if inside >= 0.0 else -math.inf
        return height(self.triangles, x, y)

    @property
    def lowest_m(self) -> float:
        """z of the body's lowest point: what falls below it has missed the target. -inf for a plane."""
        if self.kind == PLANE:
            return -math.inf
        return -2.0 * self.radius_m if self.kind == CYLINDER else float(self.triangles[:, :, 2].min())

    def save(self, path: Path) -> None:
        """Write to ``path`` (.npz), for ``load``."""
        triangles = np.empty((0, 3, 3)) if self.triangles is None else self.triangles
        with atomic_path(Path(path)) as part, open(part, "wb") as f:
            np.savez(f, kind=self.kind, radius_m=self.radius_m, axis=self.axis, triangles=triangles)

    def _prepare(self) -> None:
        """Bounding spheres of the triangles, and rows as lists: faster to index one by one."""
        middle = 0.5 * (self.triangles.min(axis=1) + self.triangles.max(axis=1))
        self._reach = np.sqrt(((self.triangles - middle[:, None]) ** 2).sum(axis=2).max(axis=1))
        self._middle, self._middle2 = middle, (middle**2).sum(axis=1)
        f = self.features
        self._rows = f.faces.tolist(), f.edges.tolist(), f.corners.tolist()

    def _touch_triangles(self, px, py, pz, vx, vy, vz, r):
        never = (math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        speed = math.sqrt(vx * vx + vy * vy + vz * vz)
        if speed == 0.0:
            return never
        ray = np.array([[px, vx / speed], [py, vy / speed], [pz, vz / speed]])
        dot = self._middle @ ray
        along = dot[:, 1] - float(ray[:, 0] @ ray[:, 1])
        off2 = self._middle2 - 2.0 * dot[:, 0] + (px * px + py * py + pz * pz) - along * along
        reach = self._reach + r * (1.0 + 1e-9)
        near = np.flatnonzero((off2 <= reach * reach) & (along >= -reach))
        soonest = ((along[near] - reach[near]) / speed).tolist()  # no touch of the triangle before
        faces, edges, corners = self._rows
        parts = (
            (self.features.face_edges, edges, touch.touch_edge, set()),
            (self.features.face_corners, corners, touch.touch_corner, set()),
        )
        best = never
        for earliest, i in sorted(zip(soonest, near.tolist())):
            if earliest > best[0]:
                break
            hit = touch.touch_face(px, py, pz, vx, vy, vz, r, faces[i])
            if hit[0] < best[0]:
                best = hit
            for of_face, rows, touch_part, seen in parts:
                for k in of_face[i]:
                    if k not in seen:
                        seen.add(k)
                        hit = touch_part(px, py, pz, vx, vy, vz, r, rows[k])
                        if hit[0] < best[0]:
                            best = hit
        return best


def from_scene(scene, triangles=None) -> TargetSurface:
    """The target's surface of ``scene``; an "stl" one needs its ``triangles`` (m, 3, 3) [m].

    Raises InputError when they are missing, unsound, or do not pass through the origin.
    """
    surface = scene.target.surface
    if surface.kind != "stl":
        return TargetSurface(surface.kind, surface.radius_m or 0.0, surface.axis)
    if triangles is None:
        raise InputError("target.surface: the triangles of its STL file are needed here")
    made = TargetSurface(TRIANGLES, triangles=triangles)
    problems = placement_problems(made.triangles, scene.target.window_m)
    if problems:
        raise InputError([f"target.surface: {sentence}" for sentence in problems])
    return made


def load(path: Path) -> TargetSurface:
    """The surface that ``save`` wrote. Raises InputError for a file that is missing or of another kind."""
    try:
        with np.load(path, allow_pickle=False) as data:
            values = {name: data[name] for name in ("kind", "radius_m", "axis", "triangles")}
    except (OSError, ValueError, KeyError, EOFError) as e:
        raise InputError(f"{path}: cannot be read as a target surface ({e})") from None
    return TargetSurface(
        str(values["kind"]), float(values["radius_m"]), str(values["axis"]), values["triangles"]
    )
