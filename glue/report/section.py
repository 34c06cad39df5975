"""The single dimple in section with its plastic strain: triangles by pyvista, axes by matplotlib.

Both are imported when the figure is drawn.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.report.figures import BLUE, GREY, styled_figure

PIXELS_PER_RADIUS = 360
STRAIN_MAP = "YlOrRd"  # light where nothing happened: the body must not look black under a lamp


def dimple_section(
    path: Path,
    points_m,
    triangles,
    peeq,
    *,
    radius_m: float,
    shot_diameter_m: float,
    profile_r_m,
    profile_z_m,
) -> Path:
    """Section through a dimple, mirrored at the axis, and a cut-away view of the same.

    points_m: (n, 2) deformed (r, z), z up and 0 at the untouched surface; triangles: (m, 3) indices; peeq:
    (m,) equivalent plastic strain; profile_r_m, profile_z_m: (k,) deformed surface.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    wide, deep, above = 2.6 * radius_m, 2.2 * radius_m, 0.45 * radius_m
    points, triangles, strain = _cut(points_m, triangles, peeq, 1.2 * wide, 1.3 * deep)
    scale = Normalize(0.0, float(strain.max()))
    section = _render_section(points, triangles, strain, scale, (wide, deep, above))
    solid = _render_cutaway(points, triangles, strain, scale, radius_m)
    with styled_figure(path, (12.5, 4.4)) as figure:
        view, axes = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
        view.imshow(solid)
        view.set_axis_off()
        view.set_title("Cut-away")
        um = 1e6
        axes.imshow(section, extent=(-wide * um, wide * um, -deep * um, above * um), interpolation="bilinear")
        r, z = um * np.asarray(profile_r_m), um * np.asarray(profile_z_m)
        axes.plot(np.r_[-r[::-1], r], np.r_[z[::-1], z], color="#202020", lw=1.2)
        axes.axhline(0, color=GREY, lw=0.9, ls=(0, (5, 3)))
        shot = 0.5 * shot_diameter_m
        angle = np.linspace(-0.35 * np.pi, 0.35 * np.pi, 400)
        bottom = float(np.interp(0.0, profile_r_m, profile_z_m))
        axes.plot(um * shot * np.sin(angle), um * (bottom + shot * (1 - np.cos(angle))), color=BLUE, lw=1.4)
        axes.annotate(
            "shot",
            (0.0, um * above),
            xytext=(0, -6),
            textcoords="offset points",
            va="top",
            ha="center",
            color=BLUE,
        )
        axes.set(
            xlim=(-wide * um, wide * um),
            ylim=(-deep * um, above * um),
            aspect="equal",
            xlabel="r [µm]",
            ylabel="z [µm]",
        )
        axes.grid(False)
        axes.set_title(
            f"Depth {-um * bottom:.1f} µm, radius at the untouched surface (dashed) {um * radius_m:.0f} µm"
        )
        colours = ScalarMappable(scale, colormaps[STRAIN_MAP])
        figure.colorbar(colours, ax=axes, label="equivalent plastic strain [-]", pad=0.015, shrink=0.75)
    return path


def _cut(points_m, triangles, peeq, wide, deep):
    """The triangles that reach within ``wide`` of the axis and ``deep`` of the surface."""
    points, triangles, strain = np.asarray(points_m, float), np.asarray(triangles), np.asarray(peeq, float)
    corners = points[triangles]
    near = (corners[:, :, 0].min(axis=1) < wide) & (corners[:, :, 1].max(axis=1) > -deep)
    return points, triangles[near], strain[near]


def _plotter(size):
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    # a machine without a display is the normal case, not worth a warning in the middle of a run
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    return plotter


def _mesh(points, triangles, strain, mirror=1.0):
    """Section in the x-z plane, in units that keep the renderer's tolerances away (micrometres)."""
    import pyvista

    xyz = np.column_stack([mirror * points[:, 0], np.zeros(len(points)), points[:, 1]]) * 1e6
    cells = np.column_stack([np.full(len(triangles), 3), triangles])
    mesh = pyvista.PolyData(xyz, cells.ravel())
    mesh.cell_data["peeq"] = strain
    return mesh


def _smooth(mesh):
    """Values at the corners, shared between triangles that meet: the eye should not follow the mesh."""
    return mesh.clean().cell_data_to_point_data()


def _colours(scale):
    return {"scalars": "peeq", "cmap": STRAIN_MAP, "clim": (scale.vmin, scale.vmax), "show_scalar_bar": False}


def _render_section(points, triangles, strain, scale, box):
    """Image of the mirrored section that fills exactly the rectangle ``box`` = (half width, depth, above)."""
    wide, deep, above = (1e6 * side for side in box)
    width = int(2 * PIXELS_PER_RADIUS * 2.6)
    plotter = _plotter((width, round(width * (deep + above) / (2 * wide))))
    for mirror in (1.0, -1.0):
        plotter.add_mesh(_smooth(_mesh(points, triangles, strain, mirror)), lighting=False, **_colours(scale))
    middle = (0.0, 0.0, 0.5 * (above - deep))
    plotter.camera_position = [(0.0, -10 * wide, middle[2]), middle, (0.0, 0.0, 1.0)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * (deep + above)
    return _shot(plotter)


def _render_cutaway(points, triangles, strain, scale, radius_m):
    """Three quarters of the body of revolution, seen from above the missing quarter."""
    section = _smooth(_mesh(points, triangles, strain))
    section = section.clip("x", origin=(2.3e6 * radius_m, 0.0, 0.0)).clip(
        "-z", origin=(0.0, 0.0, -1.5e6 * radius_m)
    )
    solid = section.extrude_rotate(resolution=120, angle=270.0, capping=True)
    plotter = _plotter((1100, 900))
    plotter.add_mesh(solid, smooth_shading=False, ambient=0.5, diffuse=0.55, specular=0.05, **_colours(scale))
    return _trim(_shot(plotter, reach=1e6 * radius_m))


def _shot(plotter, reach=None):
    if reach is not None:
        plotter.camera_position = [
            (6 * reach, -6 * reach, 5 * reach),
            (0.0, 0.0, -0.75 * reach),
            (0.0, 0.0, 1.0),
        ]
        plotter.camera.zoom(1.25)
    plotter.enable_anti_aliasing("ssaa")
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return np.asarray(image)


def _trim(image):
    """``image`` without its white border."""
    drawn = (image < 250).any(axis=2)
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    return image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] if rows.size else image
