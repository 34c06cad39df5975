"""A closed surface of triangles: is it sound, its faces, edges and corners, its distance from a point.

Triangles are an array (m, 3, 3) [m]: corner, coordinate; counter-clockwise seen from outside.  Standard
library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

WELD = 1e-6  # corners closer than this times the part's size are one
LARGEST_PART_M = 10.0  # STL files know no unit: a larger one is more likely in millimetres
SLIVER = 1e-9  # a triangle lower than this times its longest edge has no area


class Features(NamedTuple):
    """What a sphere can touch. Not flat and concave edges: the faces beside them are touched first."""

    faces: (
        np.ndarray
    )  # (m, 12): normal n, n.x on the plane, then two rows (g, g0): g.x + g0 = barycentric 2nd, 3rd
    edges: np.ndarray  # (ne, 7): begin, unit direction, length
    corners: np.ndarray  # (nc, 3)
    face_edges: list[list[int]]  # edges (rows of ``edges``) around each face
    face_corners: list[list[int]]  # corners (rows of ``corners``) around each face


def normals(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(unit outward normals (m, 3), areas (m,) [m^2])."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    cross = np.cross(b - a, c - a)
    twice = np.sqrt((cross**2).sum(axis=1))
    return cross / np.where(twice > 0.0, twice, 1.0)[:, None], 0.5 * twice


def welded(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(points (n, 3), triangles as indices (m, 3)): corners within ``WELD`` of the part's size made one."""
    corners = triangles.reshape(-1, 3)
    gap = WELD * float(np.ptp(corners, axis=0).max())
    # per coordinate, values are one where no gap parts them (rounding would part neighbours at its limits)
    group = np.empty(corners.shape, np.int64)
    for axis in range(3):
        order = np.argsort(corners[:, axis])
        group[order, axis] = np.concatenate([[0], np.cumsum(np.diff(corners[order, axis]) > gap)])
    _, first, index = np.unique(group, axis=0, return_index=True, return_inverse=True)
    return corners[first], index.reshape(-1, 3)


def features(triangles: np.ndarray) -> Features:
    """Faces, convex edges and their end points of a sound surface (``check_triangles``)."""
    n, _ = normals(triangles)
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    g11, g12, g22 = (e1 * e1).sum(1), (e1 * e2).sum(1), (e2 * e2).sum(1)
    det = (g11 * g22 - g12 * g12)[:, None]
    second = (g22[:, None] * e1 - g12[:, None] * e2) / det
    third = (g11[:, None] * e2 - g12[:, None] * e1) / det
    faces = np.column_stack([n, (n * a).sum(1), second, -(second * a).sum(1), third, -(third * a).sum(1)])

    points, index = welded(triangles)
    beside: dict[tuple[int, int], list[tuple[int, int]]] = {}  # edge: (face, its corner off the edge)
    for face, (i, j, k) in enumerate(index.tolist()):
        for p, q, off in ((i, j, k), (j, k, i), (k, i, j)):
            beside.setdefault((min(p, q), max(p, q)), []).append((face, off))
    edges, ends, edge_of = [], {}, {}
    for (p, q), faces_beside in beside.items():
        way = points[q] - points[p]
        length = float(np.sqrt((way**2).sum()))
        if len(faces_beside) == 2:
            (face, _), (_, off) = faces_beside
            if not np.dot(points[off] - points[p], n[face]) < -1e-12 * length:
                continue  # flat or concave
        edge_of[p, q] = len(edges)
        edges.append([*points[p], *(way / length), length])
        for end in (p, q):
            ends.setdefault(end, len(ends))
    face_edges = [
        [
            edge_of[pair]
            for pair in {(min(p, q), max(p, q)) for p, q in ((i, j), (j, k), (k, i))}
            if pair in edge_of
        ]
        for i, j, k in index.tolist()
    ]
    face_corners = [[ends[i] for i in row if i in ends] for row in index.tolist()]
    corners = points[list(ends)] if ends else np.empty((0, 3))
    return Features(faces, np.array(edges).reshape(-1, 7), corners, face_edges, face_corners)


def check_triangles(triangles) -> list[str]:
    """What is wrong with a surface, as sentences; empty when it is closed, outward and without slivers.

    Self-intersection is not looked for.
    """
    triangles = np.asarray(triangles, float)
    if triangles.ndim != 3 or triangles.shape[1:] != (3, 3) or len(triangles) < 4:
        return [
            f"a closed surface takes at least 4 triangles of 3 corners; this has the shape {triangles.shape}"
        ]
    if not np.isfinite(triangles).all():
        return ["a corner is not a finite number"]
    problems = []
    points, index = welded(triangles)
    _, area = normals(triangles)
    longest = np.sqrt(((triangles - np.roll(triangles, 1, axis=1)) ** 2).sum(axis=2).max(axis=1))
    flat = np.flatnonzero(
        (2.0 * area <= SLIVER * longest**2)
        | (index[:, 0] == index[:, 1])
        | (index[:, 1] == index[:, 2])
        | (index[:, 2] == index[:, 0])
    )
    if flat.size:
        problems.append(
            f"{flat.size} of {len(area)} triangles are degenerate: no area (first: number {flat[0]})"
        )

    directed = np.concatenate([index[:, [0, 1]], index[:, [1, 2]], index[:, [2, 0]]])
    forward = directed[:, 0] < directed[:, 1]
    edges, which, uses = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    ahead = np.bincount(which.ravel(), weights=forward, minlength=len(edges))
    for bad, what in (
        (uses == 1, "the surface is open: {} edges belong to one triangle only"),
        (uses > 2, "{} edges belong to more than two triangles"),
        (
            (uses == 2) & (ahead != 1),
            "inverted triangles: at {} edges the neighbours are oriented against each other",
        ),
    ):
        if bad.any():
            p, q = points[edges[np.flatnonzero(bad)[0]]]
            problems.append(what.format(int(bad.sum())) + f" (first: from {_place(p)} to {_place(q)})")
    if not problems:
        volume = _volumes(triangles, index)
        if (volume < 0.0).any():
            problems.append(
                f"inside out: {int((volume < 0.0).sum())} of {len(volume)} closed shells have their triangles"
                " facing inwards (corners must run counter-clockwise seen from outside; no cavities)"
            )
    return problems


def placement_problems(triangles: np.ndarray, window_m) -> list[str]:
    """What is wrong with where the part lies: the origin must be on its surface, the window over it."""
    tolerance = 1e-3 * min(window_m)
    size = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    problems = []
    if size > LARGEST_PART_M:
        problems.append(
            f"the part is {size:.4g} m long; at most {LARGEST_PART_M:g} m (coordinates must be in metres)"
        )
    top = height(triangles, 0.0, 0.0)
    if not abs(top) <= tolerance:
        where = f"is {top:.4g} m high there" if np.isfinite(top) else "has no surface above or below it"
        problems.append(
            f"the surface must pass through the origin, where the jet aims, within {tolerance:.2g} m (a"
            f" thousandth of the window), its outside towards +z; it {where}"
        )
    else:
        corners = [(sx * window_m[0] / 2, sy * window_m[1] / 2) for sx in (-1, 1) for sy in (-1, 1)]
        beside = [corner for corner in corners if not np.isfinite(height(triangles, *corner))]
        if beside:
            problems.append(
                f"the window of {window_m[0]:g} x {window_m[1]:g} m reaches beyond the part: nothing lies"
                f" below its corner at {_place(beside[0])} m"
            )
    return problems


def height(triangles: np.ndarray, x: float, y: float) -> float:
    """z [m] of the uppermost surface over (x, y) [m]; -inf where there is none."""
    a, e1, e2 = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    det = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    safe = np.where(det == 0.0, 1.0, det)  # upright triangles have no height
    qx, qy = x - a[:, 0], y - a[:, 1]
    second, third = (qx * e2[:, 1] - qy * e2[:, 0]) / safe, (qy * e1[:, 0] - qx * e1[:, 1]) / safe
    over = (det != 0.0) & (np.minimum(second, third) >= -1e-9) & (second + third <= 1.0 + 1e-9)
    return float((a[:, 2] + second * e1[:, 2] + third * e2[:, 2])[over].max(initial=-np.inf))


def nearest(triangles: np.ndarray, n: np.ndarray, point) -> tuple[float, np.ndarray, np.ndarray]:
    """(distance [m], negative inside; foot (3,); unit normal (3,)) of a point and a closed surface.

    ``n``: the triangles' ``normals``.  The normal is the outward one at the foot.
    The sign comes from that one of the nearest triangles whose plane is farthest from the point: at an edge
    or corner the others may face away.
    """
    p = np.asarray(point, float)
    above = ((p - triangles[:, 0]) * n).sum(axis=1)
    foot = p - above[:, None] * n
    begin, way = triangles, np.roll(triangles, -1, axis=1) - triangles  # (m, 3 edges, 3)
    over = foot[:, None] - begin
    # the foot is inside where it lies left of all three edges
    left = (
        (way[:, :, 1] * over[:, :, 2] - way[:, :, 2] * over[:, :, 1]) * n[:, None, 0]
        + (way[:, :, 2] * over[:, :, 0] - way[:, :, 0] * over[:, :, 2]) * n[:, None, 1]
        + (way[:, :, 0] * over[:, :, 1] - way[:, :, 1] * over[:, :, 0]) * n[:, None, 2]
    )
    share = np.clip(((p - begin) * way).sum(axis=2) / (way * way).sum(axis=2), 0.0, 1.0)
    on_edge = begin + share[:, :, None] * way
    away2 = ((p - on_edge) ** 2).sum(axis=2)
    edge = away2.argmin(axis=1)
    rows = np.arange(len(triangles))
    inside = left.min(axis=1) >= 0.0
    foot = np.where(inside[:, None], foot, on_edge[rows, edge])
    distance = np.where(inside, np.abs(above), np.sqrt(away2[rows, edge]))
    least = distance.min()
    close = np.flatnonzero(distance <= least + 1e-9 * (least + np.sqrt((way[0, 0] ** 2).sum())))
    decides = close[np.abs(above[close]).argmax()]
    sign = 1.0 if above[decides] >= 0.0 else -1.0
    normal = n[decides]
    if not inside[decides] and least > 0.0:
        normal = sign * (p - foot[decides]) / least
    return float(sign * least), foot[decides], normal


def _volumes(triangles: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Signed volume of every connected shell [m^3]."""
    label = np.arange(index.max() + 1)
    while True:  # the smallest point of every triangle spreads over its corners
        least = label[index].min(axis=1)
        new = label.copy()
        for i in range(3):
            np.minimum.at(new, index[:, i], least)
        if (new == label).all():
            break
        label = new
    t = triangles - triangles.reshape(-1, 3).mean(axis=0)
    volume = (t[:, 0] * np.cross(t[:, 1], t[:, 2])).sum(axis=1) / 6.0
    _, shell = np.unique(label[index[:, 0]], return_inverse=True)
    return np.bincount(shell.ravel(), weights=volume)


def _place(point) -> str:
    return "(" + ", ".join(f"{c:.4g}" for c in point) + ")"
