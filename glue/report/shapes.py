"""The peened surface and its dimples as triangles: STL for CAD, VTU and PVD for ParaView."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from glue.atomic import write_text_atomic
from glue.meshes import write_points, write_sheet

FRAMES = 24  # of the series over time
_MOST_DRAWN = 400_000  # dimples over all frames: fewer frames where there are many
_CORNERS = 24  # of a dimple


def sheet(x_m, y_m, z_m, every: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """(points (n, 3) [m], triangles (m, 3)) of the heights ``z_m`` (ny, nx): an open sheet, normals upwards.

    ``every``: only each such row and column of the grid, from the first.
    """
    x, y, z = np.asarray(x_m)[::every], np.asarray(y_m)[::every], np.asarray(z_m)[::every, ::every]
    points = np.column_stack([np.tile(x, y.size), np.repeat(y, x.size), z.ravel()])
    corner = (np.arange(y.size - 1)[:, None] * x.size + np.arange(x.size - 1)).ravel()
    lower = np.column_stack([corner, corner + 1, corner + x.size])
    upper = np.column_stack([corner + 1, corner + x.size + 1, corner + x.size])
    return points, np.vstack([lower, upper])


def write_stl(path: Path, x_m, y_m, z_m, *, every: int = 1, scale: float = 1.0) -> None:
    """The height map as binary STL; ``scale``: 1 for metres, 1000 for millimetres (STL has no unit)."""
    points, triangles = sheet(x_m, y_m, z_m, every)
    write_sheet(path, scale * points, triangles, {})


def write_surface_vtu(path: Path, x_m, y_m, z_m, hits, every: int = 1) -> None:
    """The height map with fields ``height_m`` and ``hits`` (ny, nx), the number of dimples over each point."""
    points, triangles = sheet(x_m, y_m, z_m, every)
    fields = {"height_m": points[:, 2], "hits": np.asarray(hits)[::every, ::every].ravel()}
    write_sheet(path, points, triangles, fields)


def write_impacts_vtu(path: Path, impacts: np.ndarray, axes) -> None:
    """Every impact as a point with its time, velocity, size and dimple; ``axes``: semi_major, semi_minor, azimuth, each (n,)."""
    velocity = np.column_stack([impacts[f"v{c}_in_m_s"] for c in "xyz"])
    write_points(
        path, np.column_stack([impacts[f"{c}_m"] for c in "xyz"]),
        {"time_s": impacts["time_s"], "velocity_in_m_s": velocity, "diameter_m": impacts["diameter_m"],
         "collisions_before": impacts["collisions_before"], "dimple_semi_major_m": axes[0], "dimple_semi_minor_m": axes[1],
         "dimple_azimuth_rad": axes[2]},
    )  # fmt: skip


def write_dimple_series(folder: Path, dimples, end_s: float) -> list[Path]:
    """``dimples.pvd`` and its frames: the dimples struck so far (``slider.Dimples``), to scale, with their times.

    Frames are evenly spaced up to ``end_s``.  Returns the files written, the .pvd first.
    """
    count = len(dimples.x_m)
    frames = int(np.clip(2 * _MOST_DRAWN // max(count, 1), 2, FRAMES))
    points, triangles = _ellipses(dimples)
    times = np.linspace(0.0, end_s, frames + 1)[1:]
    written = []
    for k, time_s in enumerate(times):
        struck = int(np.searchsorted(dimples.time_s, time_s, side="right"))
        struck = max(struck, 1) if count else 0  # ParaView has no use for a frame of no cells
        path = folder / "dimples" / f"dimples_{k:03d}.vtu"
        own = slice(struck * (_CORNERS + 1))
        fields = {"time_s": dimples.time_s, "number": np.arange(count)}
        fields = {name: np.repeat(values, _CORNERS + 1)[own] for name, values in fields.items()}
        write_sheet(path, points[own], triangles[: struck * _CORNERS], fields)
        written.append(path)
    sets = "".join(
        f'    <DataSet timestep="{t:.9g}" file={quoteattr(p.relative_to(folder).as_posix())}/>\n' for t, p in zip(times, written)
    )
    pvd = folder / "dimples.pvd"
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n'
    write_text_atomic(pvd, f"{head}  <Collection>\n{sets}  </Collection>\n</VTKFile>\n")
    return [pvd, *written]


def _ellipses(dimples) -> tuple[np.ndarray, np.ndarray]:
    """Points (n * (corners + 1), 3) and triangles (n * corners, 3): a fan about each dimple's middle.

    Later dimples lie a hair higher, so that they hide what they struck.
    """
    count = len(dimples.x_m)
    angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    along, across = dimples.semi_major_m[:, None] * np.cos(angle), dimples.semi_minor_m[:, None] * np.sin(angle)
    cos, sin = np.cos(dimples.azimuth_rad)[:, None], np.sin(dimples.azimuth_rad)[:, None]
    x = dimples.x_m[:, None] + np.column_stack([np.zeros(count), along * cos - across * sin])
    y = dimples.y_m[:, None] + np.column_stack([np.zeros(count), along * sin + across * cos])
    height = 1e-3 * max(dimples.part_m) * np.linspace(0.0, 1.0, max(count, 1))[:count]
    points = np.stack([x, y, np.broadcast_to(height[:, None], x.shape)], axis=-1).reshape(-1, 3)
    first = (_CORNERS + 1) * np.arange(count)[:, None]
    k = np.arange(_CORNERS)
    fan = np.stack([np.broadcast_to(first, (count, _CORNERS)), first + 1 + k, first + 1 + (k + 1) % _CORNERS], axis=-1)
    return points, fan.reshape(-1, 3)
