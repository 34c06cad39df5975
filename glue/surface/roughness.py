"""Areal roughness of a height map by the definitions of ISO 25178-2 (Sa, Sq, Sz, Ssk, Sku).

No filter is applied ("none"): neither S- nor L-filter nor nesting index, so the values are those of the
levelled primary surface.  A patch of a few millimetres is shorter than five cut-offs of 2.5 mm and could not
be filtered to the standard.
"""

from __future__ import annotations

import math

import numpy as np

from glue.errors import InputError

LEVELLINGS = ("plane", "mean")


def areal(z, dx: float, dy: float, levelling: str = "plane") -> dict:
    """Roughness of heights ``z`` (ny, nx) [m] on an even grid of steps ``dx``, ``dy`` [m].

    levelling: "plane" takes the least-squares plane out, "mean" only the mean.  With h the levelled heights,
    Sa = mean |h|, Sq = rms h, Sz = max h - min h, Ssk = mean h^3 / Sq^3, Sku = mean h^4 / Sq^4.
    Returns Sa_m, Sq_m, Sz_m, Ssk, Sku, levelling, filter; on a flat surface Ssk and Sku are None with
    Ssk_reason and Sku_reason.  Raises InputError for a grid below 2 x 2 or heights that are not finite.
    """
    z = np.asarray(z, dtype=float)
    if levelling not in LEVELLINGS:
        raise InputError(f"levelling = {levelling!r}: must be one of {', '.join(LEVELLINGS)}")
    if z.ndim != 2 or min(z.shape) < 2:
        raise InputError(f"height map of shape {z.shape}: must be at least 2 x 2")
    if not np.isfinite(z).all():
        raise InputError(f"height map: {np.count_nonzero(~np.isfinite(z))} heights are not finite")
    h = level_plane(z, dx, dy) if levelling == "plane" else z - z.mean()
    square = h * h
    sq = math.sqrt(square.mean())
    result = {"Sa_m": float(np.abs(h).mean()), "Sq_m": sq, "Sz_m": float(np.ptp(h))}
    # what rounding leaves of the levelled heights is no surface
    if sq <= 1e-12 * max(float(np.abs(z).max()), 1e-30):
        reason = "the surface is flat: Sq is zero"
        result |= {"Ssk": None, "Ssk_reason": reason, "Sku": None, "Sku_reason": reason}
    else:
        result |= {"Ssk": float((square * h).mean() / sq**3), "Sku": float((square * square).mean() / sq**4)}
    return result | {"levelling": levelling, "filter": "none"}


def profile(z, dx: float, dy: float) -> dict:
    """Ra and Rz [m] of the lines of a height map ``z`` (ny, nx), in both directions, after levelling by a plane.

    Ra: mean |height| about the line's mean; Rz: mean over five equal parts of a line of highest less lowest; both are means over all lines.
    Unfiltered, on lines as long as the map: not to ISO 21920 when that is shorter than five cut-offs.
    """
    h = level_plane(np.asarray(z, dtype=float), dx, dy)
    ra, rz = [], []
    for lines in (h, h.T):
        lines = lines - lines.mean(axis=1, keepdims=True)
        ra.append(np.abs(lines).mean())
        rz.append(np.mean([np.ptp(part, axis=1).mean() for part in np.array_split(lines, min(5, lines.shape[1]), axis=1)]))
    return {"Ra_m": float(np.mean(ra)), "Rz_m": float(np.mean(rz))}


def random_surface(shape: tuple[int, int], dx: float, dy: float, Sa_m: float, wavelength_m: float, seed: int) -> np.ndarray:
    """Heights (ny, nx) [m] of a rough surface, the same in all directions: 200 waves of one length at random, scaled to Sa."""
    rng, waves = np.random.default_rng(seed), 200
    angle, phase = rng.uniform(0.0, 2.0 * math.pi, (2, waves))
    kx, ky = (2.0 * math.pi / wavelength_m * f(angle) for f in (np.cos, np.sin))
    x, y = np.arange(shape[1]) * dx, np.arange(shape[0]) * dy
    # cos(a + b) in two products, so that no (ny, nx, waves) is held
    z = np.cos(np.outer(y, ky)) @ np.cos(np.outer(x, kx) + phase).T - np.sin(np.outer(y, ky)) @ np.sin(np.outer(x, kx) + phase).T
    z -= z.mean()
    return z * (Sa_m / np.abs(z).mean())


def level_plane(z, dx: float, dy: float) -> np.ndarray:
    """Heights (ny, nx) less their least-squares plane; on an even grid its slopes are independent."""
    ny, nx = z.shape
    x = (np.arange(nx) - 0.5 * (nx - 1)) * dx
    y = (np.arange(ny) - 0.5 * (ny - 1)) * dy
    h = z - z.mean()
    slope_x = float((h @ x).sum()) / (ny * float(x @ x))
    slope_y = float((y @ h).sum()) / (nx * float(y @ y))
    return h - slope_x * x[None, :] - slope_y * y[:, None]
