"""Meshes with fields on them, as files that ParaView and its kin open; the only module that knows meshio."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError


def write_triangles(path: Path, points_m, triangles, cell_fields: Mapping[str, np.ndarray]) -> None:
    """Write a triangle mesh to ``path`` (.vtu, binary, every digit kept).

    points_m: (n, 2) or (n, 3) [m], a plane mesh is put at z = 0; triangles: (m, 3) indices;
    cell_fields: {name with unit: (m,) values}. Raises InputError when the shapes do not fit together.
    """
    points, cells = np.asarray(points_m, dtype=float), np.asarray(triangles, dtype=np.int64)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or cells.ndim != 2 or cells.shape[1] != 3:
        raise InputError(
            f"mesh: points {points.shape}, triangles {cells.shape}; expected (n, 2 or 3) and (m, 3)"
        )
    if cells.size and not (0 <= cells.min() and cells.max() < len(points)):
        raise InputError(f"mesh: triangles name points {cells.min()}..{cells.max()} of {len(points)}")
    odd = [name for name, values in cell_fields.items() if np.shape(values) != (len(cells),)]
    if odd:
        raise InputError(f"mesh: {', '.join(odd)} must have one value for each of {len(cells)} triangles")
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    fields = {name: [np.asarray(values, dtype=float)] for name, values in cell_fields.items()}
    with atomic_path(path) as part:
        meshio.write(part, meshio.Mesh(points, [("triangle", cells)], cell_data=fields), file_format="vtu")


def write_tetrahedra(
    path: Path, points_m, tetrahedra, point_fields: Mapping[str, np.ndarray], cell_fields: Mapping[str, np.ndarray]
) -> None:
    """Write a tetrahedral mesh to ``path`` (.vtu, single precision, compressed).

    points_m: (n, 3) [m]; tetrahedra: (m, 4) indices; point_fields, cell_fields: {name with unit: values (n, …) or
    (m, …)}.  Raises InputError when the shapes do not fit together or a value is not finite.
    """
    points, cells = np.asarray(points_m, dtype=np.float32), np.asarray(tetrahedra, dtype=np.int32)
    if points.ndim != 2 or points.shape[1] != 3 or cells.ndim != 2 or cells.shape[1] != 4:
        raise InputError(f"mesh: points {points.shape}, tetrahedra {cells.shape}; expected (n, 3) and (m, 4)")
    if cells.size and not (0 <= cells.min() and cells.max() < len(points)):
        raise InputError(f"mesh: tetrahedra name points {cells.min()}..{cells.max()} of {len(points)}")
    fields = [("point", points, point_fields), ("tetrahedron", cells, cell_fields)]
    for what, of, named in fields:
        odd = [name for name, values in named.items() if np.shape(values)[:1] != (len(of),)]
        if odd:
            raise InputError(f"mesh: {', '.join(odd)} must have one value for each {what} of {len(of)}")
        poor = [name for name, values in named.items() if not np.isfinite(values).all()]
        if poor:
            raise InputError(f"mesh: {', '.join(poor)} is not finite everywhere")
    at_points = {name: np.asarray(values, np.float32) for name, values in point_fields.items()}
    at_cells = {name: [np.asarray(values, np.float32)] for name, values in cell_fields.items()}
    mesh = meshio.Mesh(points, [("tetra", cells)], point_data=at_points, cell_data=at_cells)
    with atomic_path(path) as part:
        meshio.write(part, mesh, file_format="vtu", compression="zlib")


def write_sheet(path: Path, points_m, triangles, point_fields: Mapping[str, np.ndarray]) -> None:
    """Write triangles with values at their corners: to .vtu (every field) or binary .stl (shape alone, single precision).

    points_m: (n, 3) [m]; triangles: (m, 3) indices, corners anticlockwise as seen from outside; point_fields:
    {name with unit: (n,)}.  Raises InputError when the shapes do not fit together.
    """
    points, cells = np.asarray(points_m, dtype=float), np.asarray(triangles, dtype=np.int64)
    odd = [name for name, values in point_fields.items() if np.shape(values) != (len(points),)]
    if odd:
        raise InputError(f"mesh: {', '.join(odd)} must have one value for each of {len(points)} points")
    fields = {name: np.asarray(values) for name, values in point_fields.items()}
    with atomic_path(path) as part:
        if path.suffix == ".stl":
            meshio.write(part, meshio.Mesh(points, [("triangle", cells)]), file_format="stl", binary=True)
        else:
            mesh = meshio.Mesh(points, [("triangle", cells)], point_data=fields)
            meshio.write(part, mesh, file_format="vtu", compression="zlib")


def write_points(path: Path, points_m, fields: Mapping[str, np.ndarray]) -> None:
    """Write points (n, 3) [m] with fields {name with unit: (n,)} as .vtu, each point a cell of its own."""
    points = np.asarray(points_m, dtype=float)
    cells = [("vertex", np.arange(len(points))[:, None])]
    data = {name: np.asarray(values) for name, values in fields.items()}
    with atomic_path(path) as part:
        meshio.write(part, meshio.Mesh(points, cells, point_data=data), file_format="vtu", compression="zlib")


def read_solids(path: Path) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Solid elements of a mesh file that meshio knows (.vtu, .msh, …), block by block: (meshio's type, numbers (m,)
    counted from 1 over the file, nodes (m, k, 3)).

    Raises InputError for a missing or damaged file.
    """
    try:
        mesh = meshio.read(path)
    # meshio tells a damaged file by whatever its parser meets, or by leaving the interpreter.
    except (Exception, SystemExit) as problem:
        raise InputError(f"{path}: cannot be read as a mesh ({problem})") from None
    found, first = [], 1
    for block in mesh.cells:
        numbers = np.arange(first, first + len(block.data))
        first += len(block.data)
        found.append((block.type, numbers, np.asarray(mesh.points, dtype=float)[block.data]))
    return found


def read_triangles(path: Path) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """(points (n, 3) [m], triangles (m, 3), {field: (m,)}) as :func:`write_triangles` takes them.

    Raises InputError for a missing or damaged file.
    """
    try:
        mesh = meshio.read(path, file_format="vtu")
    # meshio tells a damaged file by whatever its parser meets, or by leaving the interpreter.
    except (Exception, SystemExit) as problem:
        raise InputError(f"{path}: cannot be read as a .vtu mesh ({problem})") from None
    return (
        mesh.points,
        mesh.get_cells_type("triangle"),
        {name: mesh.get_cell_data(name, "triangle") for name in mesh.cell_data},
    )


def read_surface(path: Path) -> np.ndarray:
    """Triangles (m, 3, 3) [m] of an STL file (text or binary), corners as its author ordered them.

    Raises InputError for a missing or damaged file, or one without triangles; whether they make a closed
    surface is for ``glue.flow.triangles`` to say.
    """
    try:
        with np.errstate(over="ignore"):  # meshio takes four letters of a text file for a number of triangles
            mesh = meshio.read(path, file_format="stl")
        triangles = np.asarray(mesh.points, dtype=float)[mesh.get_cells_type("triangle")]
    # meshio tells a damaged file by whatever its parser meets, or by leaving the interpreter.
    except (Exception, SystemExit) as problem:
        raise InputError(f"{path}: cannot be read as an STL file ({problem})") from None
    if not len(triangles):
        raise InputError(f"{path}: holds no triangles: it is empty, cut short, or no STL file")
    return triangles
