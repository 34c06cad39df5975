from __future__ import annotations

import struct

import numpy as np
import pytest

from glue.errors import InputError
from glue.meshes import read_surface, read_triangles, write_tetrahedra, write_triangles

POINTS = np.array([[0.0, 0.0], [1e-3 / 3, 0.0], [0.0, -2e-300], [1.0, np.pi]])
TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]])


def test_round_trip_keeps_every_digit(tmp_path):
    fields = {"peeq": np.array([0.1, 1 / 3]), "sigma_rr_Pa": np.array([-472.1e6, 5e-324])}
    write_triangles(tmp_path / "a mesh.vtu", POINTS, TRIANGLES, fields)
    points, triangles, found = read_triangles(tmp_path / "a mesh.vtu")
    assert np.array_equal(points, np.column_stack([POINTS, np.zeros(4)]))
    assert np.array_equal(triangles, TRIANGLES)
    assert found.keys() == fields.keys()
    assert all(np.array_equal(found[name], fields[name]) for name in fields)
    assert [p.name for p in tmp_path.iterdir()] == ["a mesh.vtu"]


def test_the_same_mesh_gives_the_same_file(tmp_path):
    for name in ("a.vtu", "b.vtu"):
        write_triangles(tmp_path / name, POINTS, TRIANGLES, {"peeq": np.array([1.0, 2.0])})
    assert (tmp_path / "a.vtu").read_bytes() == (tmp_path / "b.vtu").read_bytes()


@pytest.mark.parametrize(
    ("points", "triangles", "peeq", "says"),
    [
        (POINTS[:, :1], TRIANGLES, [1.0, 2.0], "points .4, 1."),
        (POINTS, TRIANGLES + 1, [1.0, 2.0], r"1\.\.4 of 4"),
        (POINTS, TRIANGLES, [1.0], "peeq must have one value for each of 2"),
    ],
)
def test_shapes_that_do_not_fit_are_refused(tmp_path, points, triangles, peeq, says):
    with pytest.raises(InputError, match=says):
        write_triangles(tmp_path / "a.vtu", points, triangles, {"peeq": np.array(peeq)})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", ["", "<VTKFile", "<VTKFile type='ImageData'/>"])
def test_a_damaged_file_is_refused(tmp_path, content):
    (tmp_path / "a.vtu").write_text(content)
    with pytest.raises(InputError, match="cannot be read as a .vtu mesh"):
        read_triangles(tmp_path / "a.vtu")


# Two triangles of a bracket, millimetres of it: (m, corner, coordinate) in m.
SHEET = np.array(
    [
        [[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 2e-3, 0.0]],
        [[1e-3, 0.0, 0.0], [1e-3, 2e-3, 0.5e-3], [0.0, 2e-3, 0.0]],
    ]
)


def stl_text(triangles) -> bytes:
    lines = ["solid a part"]
    for corners in triangles:
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += ["vertex " + " ".join(f"{c:.9g}" for c in corner) for corner in corners]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid a part", ""]).encode()


def stl_binary(triangles) -> bytes:
    """80 bytes of anything, the count, then normal, three corners (32-bit) and two bytes for each triangle."""
    rows = b"".join(struct.pack("<12fH", 0.0, 0.0, 1.0, *corners.ravel(), 0) for corners in triangles)
    return b" " * 80 + struct.pack("<I", len(triangles)) + rows


@pytest.mark.parametrize("write", [stl_text, stl_binary])
def test_stl_gives_the_corners_in_their_order(tmp_path, write):
    (tmp_path / "a part.stl").write_bytes(write(SHEET))
    found = read_surface(tmp_path / "a part.stl")
    assert found.dtype == float and found.shape == (2, 3, 3)
    assert found == pytest.approx(SHEET, rel=1e-7)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "holds no triangles"),
        (b"PK\x03\x04 some archive", "cannot be read as an STL file"),
        (stl_binary(SHEET)[:-20], "holds no triangles: it is empty, cut short"),
        (stl_text([]), "holds no triangles"),
        (stl_binary([]), "holds no triangles"),
        (None, "cannot be read as an STL file"),
    ],
)
def test_what_is_no_surface_is_refused(tmp_path, content, says):
    if content is not None:
        (tmp_path / "a.stl").write_bytes(content)
    with pytest.raises(InputError, match=says):
        read_surface(tmp_path / "a.stl")


TETRAHEDRA = np.array([[0, 1, 2, 3]])
CORNERS = np.array([[0.0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0], [0, 0, -1e-3]])


def test_tetrahedra_and_their_tensors_are_read_back_by_another_program(tmp_path):
    """Single precision: seven digits."""
    pyvista = pytest.importorskip("pyvista")
    stress = np.array([[-3.1e8, -2.9e8, 1e6, 2e6, -3e6, 4e6]])
    moved = np.arange(12.0).reshape(4, 3) * 1e-6
    write_tetrahedra(tmp_path / "a.vtu", CORNERS, TETRAHEDRA, {"displacement_m": moved}, {"stress_Pa": stress, "peeq": np.array([0.3])})
    mesh = pyvista.read(tmp_path / "a.vtu")
    assert mesh.n_cells == 1 and mesh.points == pytest.approx(CORNERS)
    assert mesh["stress_Pa"] == pytest.approx(stress) and mesh["displacement_m"] == pytest.approx(moved)
    assert mesh["peeq"].dtype == np.float32


@pytest.mark.parametrize(
    ("cells", "peeq", "says"),
    [(TETRAHEDRA + 1, [0.1], r"1\.\.4 of 4"), (TETRAHEDRA, [0.1, 0.2], "one value for each tetrahedron of 1"),
     (TETRAHEDRA, [np.nan], "peeq is not finite"), (TRIANGLES, [0.1], r"expected .n, 3. and .m, 4.")],
)  # fmt: skip
def test_tetrahedra_that_cannot_be_are_refused(tmp_path, cells, peeq, says):
    with pytest.raises(InputError, match=says):
        write_tetrahedra(tmp_path / "a.vtu", CORNERS, cells, {}, {"peeq": np.array(peeq)})
    assert not list(tmp_path.iterdir())
