"""From the log of a curved target to its window: the surface rolled out flat, every impact on it.

Window coordinates are x and y on a plane, arc length along the curved direction (and y or x along the axis)
on a cylinder, and the projection x and y on a triangulated surface, which must therefore be nearly level
there.  Velocities go with the surface: into the local normal and along the local tangent plane.
"""

from __future__ import annotations

import math

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import COLUMNS
from glue.scene.model import Scene, Surface

MAX_TILT_DEG = 15.0  # of a triangulated surface in the window: projection then shortens lengths by 3.4 % at most


def in_window_coordinates(impacts: np.ndarray, surface: Surface) -> np.ndarray:
    """``impacts`` (``COLUMNS``) as they lie on the rolled-out surface, z = 0 with the normal upwards.

    Impacts from below (normal pointing down) have no place on it and are left out.  Velocities and spins are
    turned by the shortest rotation of the local normal upwards, which on a cylinder is the rolling out.
    """
    if surface.kind == "plane":
        return impacts
    flat = np.array(impacts[impacts["nz"] > 0.0], COLUMNS)
    normal = np.stack([flat["nx"], flat["ny"], flat["nz"]])
    for quantity, when in (("v", "in"), ("v", "out"), ("w", "in"), ("w", "out")):
        names = [f"{quantity}{axis}_{when}_{'m_s' if quantity == 'v' else 'rad_s'}" for axis in "xyz"]
        turned = _turned_upright(np.stack([flat[name] for name in names]), normal)
        for name, column in zip(names, turned, strict=True):
            flat[name] = column
    if surface.kind == "cylinder":
        along = "y_m" if surface.axis == "x" else "x_m"
        flat[along] = surface.radius_m * np.arctan2(flat[along], flat["z_m"] + surface.radius_m)
    flat["z_m"], flat["nx"], flat["ny"], flat["nz"] = 0.0, 0.0, 0.0, 1.0
    return flat


def surface_points(surface: Surface, x_m, y_m) -> tuple[np.ndarray, np.ndarray]:
    """(points, outward normals), each (3, …), at window coordinates ``x_m``, ``y_m`` (arrays of one shape).

    A triangulated surface is taken as the plane that it nearly is.
    """
    x, y = np.broadcast_arrays(np.asarray(x_m, dtype=float), np.asarray(y_m, dtype=float))
    zero, one = np.zeros(x.shape), np.ones(x.shape)
    if surface.kind != "cylinder":
        return np.stack([x, y, zero]), np.stack([zero, zero, one])
    R = surface.radius_m
    angle = (y if surface.axis == "x" else x) / R
    across, height = R * np.sin(angle), R * (np.cos(angle) - 1.0)
    if surface.axis == "x":
        return np.stack([x, across, height]), np.stack([zero, np.sin(angle), np.cos(angle)])
    return np.stack([across, y, height]), np.stack([np.sin(angle), zero, np.cos(angle)])


def check_window(scene: Scene, triangles: np.ndarray | None) -> None:
    """Raise InputError where the window has no place on the target's surface, or is too tilted to be projected.

    ``triangles`` (m, 3, 3) [m], corners anticlockwise seen from outside, of a triangulated surface.
    """
    surface, window = scene.target.surface, scene.target.window_m
    if surface.kind == "cylinder":
        curved = window[1] if surface.axis == "x" else window[0]
        widest = math.pi * surface.radius_m
        if curved > widest:
            raise InputError(
                f"target.window_m: {curved:g} m around the cylinder reaches below its middle; allowed up to {widest:.4g} m"
            )
    if surface.kind != "stl":
        return
    tilt = window_tilt_deg(triangles, window)
    if tilt is None:
        raise InputError(
            f"target.window_m: nothing of the surface {surface.file} lies under the window of {window[0]:g} x {window[1]:g} m"
            " around the origin; move the surface there"
        )
    if tilt > MAX_TILT_DEG:
        raise InputError(
            f"target.window_m: the surface {surface.file} leans {tilt:.1f} degrees from the horizontal in the window of"
            f" {window[0]:g} x {window[1]:g} m; allowed up to {MAX_TILT_DEG:g}: a smaller window, or the part turned"
        )


def window_tilt_deg(triangles: np.ndarray, window_m: tuple[float, float]) -> float | None:
    """Largest angle [degrees] between z and the upward triangles that reach into the window; None when none does.

    ``triangles`` (m, 3, 3).  A triangle counts by its bounding box: beyond the window's edge at most by itself.
    """
    corner = np.asarray(triangles, dtype=float)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    cosine = normal[:, 2] / np.linalg.norm(normal, axis=1)
    low, high = corner.min(axis=1), corner.max(axis=1)
    half = 0.5 * np.asarray(window_m)
    inside = ((low[:, :2] < half) & (high[:, :2] > -half)).all(axis=1) & (cosine > 0.0)
    if not inside.any():
        return None
    return float(np.degrees(np.arccos(np.clip(cosine[inside].min(), -1.0, 1.0))))


def _turned_upright(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """``vectors`` (3, n) after the shortest rotation that takes ``normal`` (3, n) to z, as a product of mirrors."""
    to_z = normal.copy()
    to_z[2] += 1.0
    along = (vectors * normal).sum(axis=0)
    turned = vectors - to_z * (along + vectors[2]) / (1.0 + normal[2])
    turned[2] += 2.0 * along
    return turned
