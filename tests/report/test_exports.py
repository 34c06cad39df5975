"""Exports of a run: shapes as they are, what is missing told, nothing half-written."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

import meshio
import numpy as np
import pytest

from glue.errors import InputError
from glue.meshes import read_surface
from glue.report.exports import ALWAYS, KINDS, Options, write_exports
from glue.report.shapes import sheet, write_dimple_series, write_stl, write_surface_vtu
from glue.report.slider import in_part

X, Y = np.linspace(-2e-3, 2e-3, 9), np.linspace(-1e-3, 1e-3, 5)
Z = 1e-5 * np.sin(1e3 * X)[None, :] * np.cos(1e3 * Y)[:, None]


def test_the_sheet_passes_through_every_height_with_its_normals_up():
    points, triangles = sheet(X, Y, Z)
    assert points.shape == (45, 3) and triangles.shape == (2 * 8 * 4, 3)
    assert points[2 * 9 + 3].tolist() == [X[3], Y[2], Z[2, 3]]
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normal[:, 2] > 0.0).all()
    assert 0.5 * normal[:, 2].sum() == pytest.approx(4e-3 * 2e-3)  # the window, each part of it once


@pytest.mark.parametrize(("every", "scale", "count"), [(1, 1.0, 64), (2, 1e3, 16)])
def test_stl_reads_back(tmp_path, every, scale, count):
    write_stl(tmp_path / "s.stl", X, Y, Z, every=every, scale=scale)
    triangles = read_surface(tmp_path / "s.stl")
    assert triangles.shape == (count, 3, 3)
    largest = scale * np.array([2e-3, 1e-3, Z[::every, ::every].max()])
    assert triangles.reshape(-1, 3).max(axis=0) == pytest.approx(largest, rel=1e-6)
    assert (tmp_path / "s.stl").stat().st_size == 84 + 50 * count  # binary


def test_vtu_has_height_and_hits(tmp_path):
    hits = np.arange(45).reshape(5, 9)
    write_surface_vtu(tmp_path / "s.vtu", X, Y, Z, hits)
    mesh = meshio.read(tmp_path / "s.vtu")
    assert np.array_equal(mesh.point_data["hits"], hits.ravel()) and np.array_equal(mesh.point_data["height_m"], Z.ravel())


def test_the_series_grows_with_time_and_keeps_areas(tmp_path):
    n = 6
    major, minor, azimuth = np.full(n, 2e-4), np.full(n, 1e-4), np.full(n, 0.3)
    dimples = in_part(np.linspace(-1e-3, 1e-3, n), np.zeros(n), major, minor, azimuth, np.arange(n) + 0.5, (4e-3, 2e-3))
    written = write_dimple_series(tmp_path, dimples, float(n))
    sets = ET.parse(tmp_path / "dimples.pvd").getroot().findall(".//DataSet")
    assert [tmp_path / s.get("file") for s in sets] == written[1:]
    times = [float(s.get("timestep")) for s in sets]
    struck = [len(np.unique(meshio.read(path).point_data["number"])) for path in written[1:]]
    assert times[-1] == n and struck == [max(1, sum(t0 <= t for t0 in dimples.time_s)) for t in times]
    last = meshio.read(written[-1])
    corners = last.points[last.get_cells_type("triangle")]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2].sum()
    # 24 corners: the polygon has 12/pi sin(pi/12) = .9886 of the ellipse's area
    assert area == pytest.approx(n * np.pi * 2e-4 * 1e-4 * 12 / np.pi * np.sin(np.pi / 12), rel=1e-6)


def a_run(path, complete):
    record = {"state": "complete", "input_sha256": "", "outputs": {}, "metrics": {}}
    manifest = {"schema": 1, "scene": "s", "seed": 1, "choices": {}, "defaults_used": [], "preset_argument": None, "inputs": {}}
    manifest |= {"inputs_sha256": "", "scene_sha256": "", "stages": dict.fromkeys(complete, record)}
    (path / "manifest.json").write_text(json.dumps(manifest))
    return path


def test_everything_that_stands_against_an_export_is_told_at_once(tmp_path):
    run = a_run(tmp_path, ["dimple", "flow"])
    with pytest.raises(InputError) as caught:
        write_exports(run, ("stl", "inp", "step"), Options(every=0, unit="inch"))
    told = "\n".join(caught.value.problems)
    for words in (
        "--what step: allowed: stl", "--what stl: needs the stage surface", "--what inp: needs the stage target", "--mesh",
        "--every 0", "--unit inch",
    ):  # fmt: skip
        assert words in told, words
    assert not (run / "export").exists()
    with pytest.raises(InputError, match="no run directory"):
        write_exports(tmp_path / "none")


def test_every_kind_has_a_writer_and_inp_is_not_written_unasked():
    from glue.report.exports import _WRITERS

    assert set(_WRITERS) == set(KINDS) and set(ALWAYS) == set(KINDS) - {"inp"}
