"""Rolled-out windows: places, speeds and tilts on surfaces whose geometry is known in closed form."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.impacts import COLUMNS, normal_speed_m_s, tangential_velocity_m_s
from glue.scene.model import Surface
from glue.scene.reader import example_path, read_scene
from glue.surface.window import check_window, in_window_coordinates, surface_points, window_tilt_deg

R = 0.01


def impact_on_cylinder(angle, y, velocity, axis="y"):
    """One impact at ``angle`` round a cylinder along ``axis``, ``y`` along it."""
    rows = np.zeros(1, COLUMNS)
    round_, along = ("x", "y") if axis == "y" else ("y", "x")
    rows[f"{round_}_m"], rows["z_m"] = R * math.sin(angle), R * (math.cos(angle) - 1.0)
    rows[f"{along}_m"] = y
    rows[f"n{round_}"], rows["nz"] = math.sin(angle), math.cos(angle)
    for name, value in zip("xyz", velocity, strict=True):
        rows[f"v{name}_in_m_s"] = value
    return rows


@pytest.mark.parametrize("angle", [-1.2, 0.0, 0.3, 1.5])
def test_a_cylinder_is_rolled_out(angle):
    """Straight down at 60 m/s at angle a: arc R a, into the surface 60 cos a, downhill along it 60 sin a."""
    rows = impact_on_cylinder(angle, 2e-3, (0.0, 5.0, -60.0))
    flat = in_window_coordinates(rows, Surface("cylinder", R, "y"))
    assert flat["x_m"] == pytest.approx(R * angle, abs=1e-15) and flat["y_m"] == 2e-3 and flat["z_m"] == 0.0
    assert flat["vz_in_m_s"] == pytest.approx(-60.0 * math.cos(angle))
    assert flat["vx_in_m_s"] == pytest.approx(60.0 * math.sin(angle), abs=1e-12)
    assert flat["vy_in_m_s"] == pytest.approx(5.0)
    # the same parts as against the local normal before
    assert normal_speed_m_s(flat) == pytest.approx(normal_speed_m_s(rows), rel=1e-12)
    speed = np.linalg.norm(tangential_velocity_m_s(rows))
    assert np.linalg.norm(tangential_velocity_m_s(flat)) == pytest.approx(speed, rel=1e-12)
    assert rows["z_m"][0] == R * (math.cos(angle) - 1.0)  # the log itself is untouched


def test_along_x_the_curved_direction_is_y():
    flat = in_window_coordinates(impact_on_cylinder(0.5, 1e-3, (0.0, 0.0, -60.0), "x"), Surface("cylinder", R, "x"))
    assert flat["y_m"] == pytest.approx(0.5 * R) and flat["x_m"] == 1e-3
    assert flat["vy_in_m_s"] == pytest.approx(60.0 * math.sin(0.5)) and abs(flat["vx_in_m_s"]) < 1e-12


def test_turning_is_a_rotation_about_a_level_axis():
    """Any normal: lengths and angles stay, and a vector along the level axis of the turn stays what it was."""
    rng = np.random.default_rng(3)
    n = rng.normal(size=3)
    n[2] = abs(n[2])
    n /= np.linalg.norm(n)
    axis = np.array([-n[1], n[0], 0.0]) / math.hypot(n[0], n[1])
    a, b = rng.normal(size=(2, 3))
    rows = np.zeros(3, COLUMNS)
    rows["nx"], rows["ny"], rows["nz"] = n
    for k, vector in enumerate((axis, a, b)):
        for name, value in zip("xyz", vector, strict=True):
            rows[f"w{name}_out_rad_s"][k] = value
    flat = in_window_coordinates(rows, Surface("stl", file="part.stl"))
    turned = np.stack([flat[f"w{name}_out_rad_s"] for name in "xyz"], axis=-1)
    assert turned[0] == pytest.approx(axis, abs=1e-12)
    assert turned[1] @ turned[2] == pytest.approx(a @ b) and turned[1] @ turned[1] == pytest.approx(a @ a)
    assert turned[1][2] == pytest.approx(a @ n)


def test_a_plane_is_left_alone_and_the_underside_left_out():
    rows = impact_on_cylinder(0.0, 0.0, (0.0, 0.0, -60.0))
    assert in_window_coordinates(rows, Surface()) is rows
    below = impact_on_cylinder(2.0, 0.0, (0.0, 0.0, 60.0))
    assert len(in_window_coordinates(below, Surface("cylinder", R, "y"))) == 0


@pytest.mark.parametrize("axis", ["x", "y"])
def test_points_of_the_surface_come_back(axis):
    surface = Surface("cylinder", R, axis)
    x, y = np.meshgrid(np.linspace(-3e-3, 3e-3, 5), np.linspace(-2e-3, 2e-3, 3))
    point, normal = surface_points(surface, x.ravel(), y.ravel())
    rows = np.zeros(x.size, COLUMNS)
    for name, p, n in zip("xyz", point, normal, strict=True):
        rows[f"{name}_m"], rows[f"n{name}"] = p, n
    flat = in_window_coordinates(rows, surface)
    assert flat["x_m"] == pytest.approx(x.ravel(), abs=1e-15) and flat["y_m"] == pytest.approx(y.ravel(), abs=1e-15)


def roof(degrees):
    """Two triangles of a slope that rises with x, and two far away that stand upright."""
    rise = math.tan(math.radians(degrees))
    a, b, c, d = ([x, y, rise * x] for x, y in ((-5e-3, -5e-3), (5e-3, -5e-3), (5e-3, 5e-3), (-5e-3, 5e-3)))
    far = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]
    return np.array([[a, b, c], [a, c, d], far])


@pytest.mark.parametrize("degrees", [0.0, 10.0, 14.9, 15.1, 40.0])
def test_a_window_that_leans_is_refused(degrees):
    scene = read_scene(example_path("al2024-s390"))
    scene = dataclasses.replace(
        scene, target=dataclasses.replace(scene.target, surface=Surface("stl", file="part.stl"))
    )
    assert window_tilt_deg(roof(degrees), (4e-3, 4e-3)) == pytest.approx(degrees, abs=1e-6)
    if degrees < 15.0:
        check_window(scene, roof(degrees))
    else:
        with pytest.raises(InputError, match=rf"leans {degrees:.1f} degrees.*allowed up to 15"):
            check_window(scene, roof(degrees))


def test_a_window_beside_the_part_is_refused():
    scene = read_scene(example_path("al2024-s390"))
    scene = dataclasses.replace(
        scene, target=dataclasses.replace(scene.target, surface=Surface("stl", file="part.stl"))
    )
    with pytest.raises(InputError, match=r"nothing of the surface part\.stl lies under the window"):
        check_window(scene, roof(5.0) + [0.1, 0.0, 0.0])


def test_a_window_round_the_cylinder_is_refused():
    scene = read_scene(example_path("al2024-s390"))
    small = dataclasses.replace(scene.target, surface=Surface("cylinder", 1e-3, "y"))
    with pytest.raises(InputError, match="reaches below its middle; allowed up to 0.003142 m"):
        check_window(dataclasses.replace(scene, target=small), None)
