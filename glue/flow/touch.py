"""When and where a sphere that flies straight first touches a surface: exact, scalar, one function per shape.

Every function takes the sphere's centre p [m], velocity v [m/s] and radius r [m] as floats, then the shape,
and returns ``(t, x, y, z, nx, ny, nz)``: time to the first touch [s], the touched point of the surface [m]
and the unit normal there, pointing at the sphere's centre.  t is inf (and the rest 0) when the sphere never
touches; it is 0 when it already does and still approaches.  A sphere that moves away touches nothing, so one
that has just rebounded does not touch again.

The sphere is assumed to start outside the body.  The functions call only ``math``: plain Python (YADE's) and
numba run the same text.
"""

from __future__ import annotations

import math

EDGE_MARGIN = 1e-9  # of a triangle's size: neighbours overlap by this, so that nothing slips between two


def touch_plane(px, py, pz, vx, vy, vz, r):
    """The plane z = 0, body below."""
    if not vz < 0.0:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    t = max(pz - r, 0.0) / -vz
    return t, px + t * vx, py + t * vy, 0.0, 0.0, 0.0, 1.0


def touch_cylinder(px, py, pz, vx, vy, vz, r, radius, axis):
    """A cylinder of ``radius`` along x (``axis`` 0) or y (1), body inside; its apex line passes through 0."""
    across, side = (py, vy) if axis == 0 else (px, vx)
    up = pz + radius
    a = side * side + vz * vz
    b = across * side + up * vz
    c = across * across + up * up - (radius + r) ** 2
    square = b * b - a * c
    if not b < 0.0 or square < 0.0:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    t = max(c / (math.sqrt(square) - b), 0.0)  # the earlier root, without cancellation
    across, up = across + t * side, up + t * vz
    size = math.sqrt(across * across + up * up)
    across, up = across / size, up / size
    if axis == 0:
        return t, px + t * vx, radius * across, radius * (up - 1.0), 0.0, across, up
    return t, radius * across, py + t * vy, radius * (up - 1.0), across, 0.0, up


def touch_face(px, py, pz, vx, vy, vz, r, face):
    """The inside of a triangle, from its front; ``face`` is a row of ``triangles.features``."""
    nx, ny, nz = face[0], face[1], face[2]
    approach = nx * vx + ny * vy + nz * vz
    height = nx * px + ny * py + nz * pz - face[3]
    if not approach < 0.0 or height < 0.0:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    t = max(height - r, 0.0) / -approach
    above = height + t * approach
    x, y, z = px + t * vx - above * nx, py + t * vy - above * ny, pz + t * vz - above * nz
    first = face[4] * x + face[5] * y + face[6] * z + face[7]
    second = face[8] * x + face[9] * y + face[10] * z + face[11]
    if min(first, second) < -EDGE_MARGIN or first + second > 1.0 + EDGE_MARGIN:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return t, x, y, z, nx, ny, nz


def touch_edge(px, py, pz, vx, vy, vz, r, edge):
    """A straight edge without its ends; ``edge`` is a row of ``triangles.features``."""
    ux, uy, uz = edge[3], edge[4], edge[5]
    qx, qy, qz = px - edge[0], py - edge[1], pz - edge[2]
    along, drift = qx * ux + qy * uy + qz * uz, vx * ux + vy * uy + vz * uz
    qx, qy, qz = qx - along * ux, qy - along * uy, qz - along * uz
    wx, wy, wz = vx - drift * ux, vy - drift * uy, vz - drift * uz
    a = wx * wx + wy * wy + wz * wz
    b = qx * wx + qy * wy + qz * wz
    c = qx * qx + qy * qy + qz * qz - r * r
    square = b * b - a * c
    if not b < 0.0 or square < 0.0:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    t = max(c / (math.sqrt(square) - b), 0.0)
    along += t * drift
    if along < 0.0 or along > edge[6]:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    nx, ny, nz = qx + t * wx, qy + t * wy, qz + t * wz
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    return (
        t,
        edge[0] + along * ux,
        edge[1] + along * uy,
        edge[2] + along * uz,
        nx / size,
        ny / size,
        nz / size,
    )


def touch_corner(px, py, pz, vx, vy, vz, r, corner):
    """A point; ``corner`` is (x, y, z)."""
    qx, qy, qz = px - corner[0], py - corner[1], pz - corner[2]
    a = vx * vx + vy * vy + vz * vz
    b = qx * vx + qy * vy + qz * vz
    c = qx * qx + qy * qy + qz * qz - r * r
    square = b * b - a * c
    if not b < 0.0 or square < 0.0:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    t = max(c / (math.sqrt(square) - b), 0.0)
    nx, ny, nz = qx + t * vx, qy + t * vy, qz + t * vz
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    return t, corner[0], corner[1], corner[2], nx / size, ny / size, nz / size
