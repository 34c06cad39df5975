"""The model's own surface on a grid, and fields by element, from tables written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from glue.errors import NotConverged, SolverFailed
from glue.target.fields import read_fields
from glue.target.own_surface import own_surface


def table(path, **columns) -> None:
    np.savetxt(path, np.column_stack(list(columns.values())), "%.17g", ",", header=",".join(columns), comments="")


def test_a_cells_nodes_are_its_grid(tmp_path):
    """4 x 4 nodes of a period of 1 mm in any order, one of them on the far edge instead of the near one."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(4) / 4, np.arange(4) / 4))
    z = 10 * x + y
    x = np.where((x == 0) & (y == 0.5), 1.0, x)
    order = np.random.default_rng(1).permutation(16)
    zero = np.zeros(16)
    table(tmp_path / "surface-3.csv", x_mm=x[order], y_mm=y[order], u_x=zero, u_y=zero, u_z=z[order])
    at, heights = own_surface(tmp_path, 3, 1e-3, period_m=1e-3)
    assert at == pytest.approx([0, 0.25e-3, 0.5e-3, 0.75e-3])
    assert heights == pytest.approx(1e-3 * (10 * np.arange(4)[None, :] / 4 + np.arange(4)[:, None] / 4))


def test_a_blocks_surface_is_taken_where_its_nodes_lie_now(tmp_path):
    """A plane of slopes 1 and 2 whose nodes slid along it by .03 mm; a square that they do not cover is refused."""
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21)))
    slid = np.full(x.size, 0.03)
    table(tmp_path / "surface-1.csv", x_mm=x, y_mm=y, u_x=slid, u_y=0 * slid, u_z=(x + 0.03) + 2 * y, contact=0 * slid)
    at, heights = own_surface(tmp_path, 1, 1.6e-3)
    assert at[0] == -0.8e-3 and at[-1] == 0.8e-3
    assert heights == pytest.approx(at[None, :] + 2 * at[:, None], abs=1e-12)
    with pytest.raises(NotConverged, match="holes"):
        own_surface(tmp_path, 1, 2e-3)


def tetrahedron(folder, volume_mm3: float) -> None:
    table(folder / "vertices-1.csv", x_mm=[0, 1, 0, 0], y_mm=[0, 0, 1, 0], z_mm=[0, 0, 0, -1], u_x=[0] * 4, u_y=[0] * 4,
          u_z=[-0.1, 0, 0, 0])  # fmt: skip
    (folder / "elements.csv").write_text("a,b,c,d\n0,1,2,3\n")
    values = {name: [100.0, 200.0, 300.0, 400.0] for name in ("s_xx", "s_yy", "s_zz", "s_xy", "s_yz", "s_zx", "peeq")}
    table(folder / "points-1.csv", x_mm=[0] * 4, y_mm=[0] * 4, z_mm=[0] * 4, volume_mm3=[volume_mm3 / 4] * 4, **values)


def test_fields_are_means_by_volume_in_metres_and_pascals(tmp_path):
    tetrahedron(tmp_path, 1 / 6)
    fields = read_fields(tmp_path, 1, (0.01, 0.02))
    assert fields.points_m[1] == pytest.approx([0.011, 0.02, 0.0])
    assert fields.displacement_m[0] == pytest.approx([0, 0, -1e-4])
    assert fields.stress_Pa[0] == pytest.approx([250e6] * 6) and fields.peeq[0] == 250.0


def test_points_of_another_mesh_are_refused(tmp_path):
    tetrahedron(tmp_path, 0.2)
    with pytest.raises(SolverFailed, match="not of one mesh"):
        read_fields(tmp_path, 1)
