"""Figures: they are drawn whole from plain arrays, show the numbers given, and cost nothing to import."""

from __future__ import annotations

import struct
import subprocess
import sys

import numpy as np
import pytest

from glue.report import figures, section


def png_size(path):
    """(width, height) in pixels from the PNG's own header."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert data[-8:-4] == b"IEND"  # written to its end
    return struct.unpack(">II", data[16:24])


def test_importing_figures_imports_no_drawing_library():
    code = (
        "import sys; from glue.report import figures, section, page; "
        "print([m for m in ('matplotlib', 'pyvista', 'vtk') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_plain_figure_is_written_whole(tmp_path):
    rng = np.random.default_rng(0)
    n = 30
    x, y, t = rng.uniform(-5e-3, 5e-3, n), rng.uniform(-5e-3, 5e-3, n), np.sort(rng.uniform(0, 3, n))
    axes = np.full(n, 0.2e-3)
    ring = 5e-3 * np.column_stack([np.cos(np.linspace(0, 7, 30)), np.sin(np.linspace(0, 7, 30))])
    depth, time = np.linspace(0.0, 0.8e-3, 12), np.linspace(0.0, 3.0, 20)
    sigma = -300e6 * np.cos(depth / 0.3e-3)
    z = 1e-5 * rng.normal(size=(20, 30))
    expected = 1 - np.exp(-time)
    marks = {"max_compressive_Pa": -300e6, "max_compressive_depth_m": 0.0, "compressive_depth_m": None}
    grid = np.arange(30) * 1e-4, np.arange(20) * 1e-4
    roughness = {"Sa_m": 1e-5, "Sz_m": 1e-4, "Ssk": None}
    spread = {"sigma_xx_std_Pa": np.abs(sigma) / 9, "peeq": depth}
    drawn = [
        figures.impact_map(tmp_path / "a.png", x, y, 2 * axes, axes, t, t, (4e-3, 3e-3), [(ring, None), (ring, ring[:9])]),
        figures.coverage_plot(
            tmp_path / "b.png", time, expected, expected, avrami_sd=0.1 * time, time_98_s=2.5
        ),
        figures.stress_plot(tmp_path / "c.png", depth, sigma, sigma, marks=marks, **spread),
        figures.height_map_plot(tmp_path / "d.png", *grid, z, roughness=roughness),
    ]
    for path in drawn:
        assert min(png_size(path)) > 500
    assert not list(tmp_path.glob("*.part"))


def test_no_impacts_still_draws(tmp_path):
    none = np.zeros(0)
    path = figures.impact_map(tmp_path / "none.png", *[none] * 6, (4e-3, 4e-3), [])
    assert min(png_size(path)) > 500


def test_a_failing_figure_leaves_no_file(tmp_path):
    with pytest.raises(ValueError):
        figures.coverage_plot(tmp_path / "x.png", [0.0, 1.0], [0.0], [0.0, 1.0])
    assert not list(tmp_path.iterdir())


def test_drawing_does_not_touch_global_settings(tmp_path):
    import matplotlib

    before = dict(matplotlib.rcParams)
    figures.coverage_plot(tmp_path / "x.png", [0.0, 1.0], [0.0, 0.5], [0.0, 0.6])
    assert dict(matplotlib.rcParams) == before


@pytest.fixture
def block():
    """Section of a 2 x 2 mm block in 800 triangles with strain around the origin and no dent."""
    n = 20
    r, z = np.meshgrid(np.linspace(0.0, 2e-3, n + 1), -np.linspace(0.0, 2e-3, n + 1))
    points = np.column_stack([r.ravel(), z.ravel()])
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)[None, :]).ravel()
    lower = np.column_stack([corner, corner + 1, corner + n + 1])
    upper = np.column_stack([corner + 1, corner + n + 2, corner + n + 1])
    triangles = np.vstack([lower, upper])
    centre = points[triangles].mean(axis=1)
    return points, triangles, np.exp(-np.hypot(*centre.T) / 0.3e-3)


def test_section_image_fills_its_rectangle_and_is_mirrored(block):
    from matplotlib.colors import Normalize

    image = section._render_section(*block, Normalize(0.0, 1.0), (0.6e-3, 0.5e-3, 0.1e-3)).astype(float)
    height, width = image.shape[:2]
    assert width / height == pytest.approx(1.2 / 0.6, rel=2e-3)
    white = (image > 250).all(axis=2)
    # .1 of .6 mm above the surface is empty, everything below is drawn: two pixels for the edge
    assert np.flatnonzero(~white[:, width // 4])[0] == pytest.approx(height / 6, abs=2)
    assert not white[height // 6 + 3 :].any()
    assert np.abs(image - image[:, ::-1]).mean() < 1.0  # of 255 levels
