"""Hard-sphere contacts against closed forms: oblique, spinning, of unlike sizes; curved targets; gas and gravity."""

import dataclasses
import math

import numpy as np
import pytest
from event_cases import shots, smooth_scene
from numba import njit
from scenes import bare_scene

from glue.errors import NotConverged
from glue.flow import event_kernels, event_setup, event_surface
from glue.flow.arrivals import draw_arrivals
from glue.flow.drag import slowed, speed_after_flight, surroundings
from glue.flow.event_checks import check_run
from glue.flow.event_driven import run_event
from glue.flow.event_state import SHOT, empty_world
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.effects import AirDrag, Gravity

PLANE = TargetSurface()
LAW = RestitutionLaw(0.6)


@njit
def _collide(shots, e, mu):
    return event_kernels.collide(shots[0], shots[1], e, mu)


def _pair(a, b):
    """Two records from (position, velocity, spin, radius, density)."""
    records = np.zeros(2, SHOT)
    for record, (x, v, w, r, density) in zip(records, (a, b)):
        record["x"], record["y"], record["z"] = x
        record["vx"], record["vy"], record["vz"] = v
        record["wx"], record["wy"], record["wz"] = w
        record["radius"], record["mass"] = r, density * 4.0 / 3.0 * math.pi * r**3
    return records


def _vectors(record):
    return np.array([[record[q + axis] for axis in "xyz"] for q in ("v", "w")])


def test_a_sliding_collision_of_unlike_spinning_shots():
    """Coulomb's limit reached (mu .01): J = (1+e) m g_n along the normal, mu J against the slip, torque r x J."""
    e, mu = 0.7, 0.01
    r1, r2 = 0.5e-3, 0.3e-3
    n = np.array([2.0, -1.0, 2.0]) / 3.0  # from the second to the first
    v1, v2 = np.array([-30.0, 5.0, -20.0]), np.array([10.0, 0.0, 15.0])
    w1, w2 = np.array([1e4, -2e4, 5e3]), np.array([-3e4, 0.0, 4e4])
    records = _pair(((r1 + r2) * n, v1, w1, r1, 7800.0), (0 * n, v2, w2, r2, 2500.0))
    m1, m2 = records["mass"]
    m = m1 * m2 / (m1 + m2)
    slip = v1 + np.cross(w1, -r1 * n) - v2 - np.cross(w2, r2 * n)
    gn = slip @ n
    across = slip - gn * n
    impulse = -(1.0 + e) * m * gn * (n - mu * across / np.linalg.norm(across))

    gain, off = _collide(records, e, mu)

    np.testing.assert_allclose(_vectors(records[0])[0], v1 + impulse / m1, rtol=1e-12)
    np.testing.assert_allclose(_vectors(records[1])[0], v2 - impulse / m2, rtol=1e-12)
    inertia1, inertia2 = 0.4 * m1 * r1**2, 0.4 * m2 * r2**2
    np.testing.assert_allclose(
        _vectors(records[0])[1], w1 + np.cross(-r1 * n, impulse) / inertia1, rtol=1e-12
    )
    np.testing.assert_allclose(
        _vectors(records[1])[1], w2 + np.cross(r2 * n, -impulse) / inertia2, rtol=1e-12
    )
    assert gain < 0.0 and off < 1e-15


def test_a_central_collision_of_unlike_masses():
    """One dimension: v1' = (m1 v1 + m2 v2 - m2 e (v1 - v2)) / (m1 + m2), friction has nothing to do."""
    records = _pair(
        ((0.0, 0.0, 0.0), (0.0, 0.0, 20.0), (0.0,) * 3, 0.5e-3, 7800.0),
        ((0.0, 0.0, 0.8e-3), (0.0, 0.0, -60.0), (0.0,) * 3, 0.3e-3, 2500.0),
    )
    m1, m2 = records["mass"]
    _collide(records, 0.8, 0.5)
    common = (m1 * 20.0 - m2 * 60.0) / (m1 + m2)
    assert records["vz"][0] == pytest.approx(common - 0.8 * m2 * 80.0 / (m1 + m2), rel=1e-12)
    assert records["vz"][1] == pytest.approx(common + 0.8 * m1 * 80.0 / (m1 + m2), rel=1e-12)
    assert (records["wx"] == 0.0).all()


def test_no_collision_whatever_gains_energy_or_loses_momentum():
    rng = np.random.default_rng(1)
    for _ in range(2000):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        r = rng.uniform(0.1e-3, 1e-3, 2)
        records = _pair(
            (r.sum() * n, rng.normal(size=3) * 50.0 - 100.0 * n, rng.normal(size=3) * 5e4, r[0], 7800.0),
            (0.0 * n, rng.normal(size=3) * 50.0, rng.normal(size=3) * 5e4, r[1], 2500.0),
        )
        gain, off = _collide(records, rng.uniform(0.05, 1.0), rng.choice([0.0, 0.05, 0.3, 1.0]))
        assert gain < 1e-12 and off < 1e-14


def test_a_cylinder_reflects_about_its_normal():
    radius, r, y = 0.02, 0.5e-3, 0.3e-3
    scene = smooth_scene()
    cylinder = TargetSurface("cylinder", radius_m=radius, axis="y")
    offsets = [0.0, 4e-3, -9e-3, 15e-3]
    rows = [(0.01 * k, (x, y, 0.1), (0.0, 0.0, -60.0)) for k, x in enumerate(offsets)]
    impacts, _ = run_event(scene, shots(*rows), RestitutionLaw(1.0), cylinder)
    sine = np.array(offsets) / (radius + r)
    cosine = np.sqrt(1.0 - sine**2)
    np.testing.assert_allclose(impacts["nx"], sine, atol=1e-12)
    np.testing.assert_allclose(impacts["x_m"], radius * sine, atol=1e-15)
    np.testing.assert_allclose(impacts["z_m"], radius * (cosine - 1.0), atol=1e-15)
    np.testing.assert_allclose(impacts["y_m"], y)
    np.testing.assert_allclose(impacts["vx_out_m_s"], 120.0 * sine * cosine, atol=1e-10)
    np.testing.assert_allclose(impacts["vz_out_m_s"], 60.0 * (2.0 * cosine**2 - 1.0), atol=1e-10)


def test_a_large_block_of_triangles_is_a_plane():
    scene = bare_scene(mass_flow_kg_s=0.2, exposure_time_s=0.005)
    arrivals = draw_arrivals(scene)
    expected, _ = run_event(scene, arrivals, LAW, PLANE)
    impacts, _ = run_event(scene, arrivals, LAW, TargetSurface("triangles", triangles=_block(5.0, 6)))
    early = expected["time_s"] < 0.004
    assert early.sum() > 100 and expected["collisions_before"][early].max() > 0
    for name in ("time_s", "x_m", "vz_in_m_s", "vx_out_m_s"):
        np.testing.assert_allclose(impacts[name][: early.sum()], expected[name][early], rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(impacts["nz"][: early.sum()], 1.0)


def test_shots_that_miss_the_body_fly_past_and_are_dropped():
    scene = bare_scene(mass_flow_kg_s=0.02)
    body = TargetSurface("triangles", triangles=_block(4e-3, 1))
    impacts, info = run_event(scene, draw_arrivals(scene), LAW, body)
    assert info["dropped"]["past"] > 0.5 * info["arrived"]
    assert len(impacts) and (np.abs(impacts["x_m"]) <= 2e-3).all()


def test_drag_slows_every_shot_as_the_equation_of_motion_says():
    scene = smooth_scene(
        air_drag=AirDrag(1.2, 1.8e-5), diameter_m=0.2e-3, mass_flow_kg_s=1e-4, exposure_time_s=0.05
    )
    arrivals = draw_arrivals(scene)
    impacts, info = run_event(scene, arrivals, LAW, PLANE)
    assert info["kicks"] > 0 and len(impacts) > 50
    first = impacts[impacts["collisions_before"] == 0]
    expected = speed_after_flight(60.0, 0.1 - 0.1e-3, 0.2e-3, 7800.0, surroundings(scene))
    assert expected < 59.0
    np.testing.assert_allclose(-first["vz_in_m_s"], expected, rtol=2e-5)


def test_a_fine_shot_reaches_its_terminal_speed():
    """Weight against drag, k(v) v = g, by bisection on the drag law itself."""
    scene = smooth_scene(
        air_drag=AirDrag(1.2, 1.8e-5),
        gravity=Gravity(9.81),
        diameter_m=0.05e-3,
        density_kg_m3=2500.0,
        speed_m_s=0.5,
    )
    impacts, _ = run_event(
        scene, shots((0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -0.5), 0.05e-3, 2500.0)), LAW, PLANE
    )
    around = surroundings(scene)
    low, high = 0.01, 1.0
    for _ in range(60):
        v = 0.5 * (low + high)
        faster = slowed(0.0, 0.0, -v, 1e-6, 0.05e-3, 2500.0, around)[2] < -v
        low, high = (v, high) if faster else (low, v)
    assert -impacts["vz_in_m_s"][0] == pytest.approx(low, rel=1e-3)


def test_gravity_by_kicks_on_a_cylinder_as_in_closed_form():
    """On the apex line of a wide cylinder: the fall of a shot on a plane."""
    scene = smooth_scene(gravity=Gravity(9.81), speed_m_s=2.0)
    cylinder = TargetSurface("cylinder", radius_m=1.0, axis="y")
    impacts, info = run_event(
        scene, shots((0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -2.0))), RestitutionLaw(0.5), cylinder
    )
    speed = math.sqrt(4.0 + 2.0 * 9.81 * 0.0995)
    assert info["kicks"] > 50
    np.testing.assert_allclose(-impacts["vz_in_m_s"][:3], speed * 0.5 ** np.arange(3), rtol=1e-4)
    assert impacts["time_s"][0] == pytest.approx((speed - 2.0) / 9.81, rel=1e-5)


def test_mixed_media_keep_their_momentum():
    scene = bare_scene(mass_flow_kg_s=0.3)
    light = dataclasses.replace(scene.media[0], diameter_m=0.4e-3, density_kg_m3=2500.0, mass_fraction=0.1)
    heavy = dataclasses.replace(scene.media[0], mass_fraction=0.9)
    scene = dataclasses.replace(scene, media=(heavy, light))
    impacts, info = run_event(scene, draw_arrivals(scene), LAW, PLANE)
    assert info["shot_shot_collisions"] > 500 and set(impacts["medium"]) == {0, 1}
    assert (
        info["worst"]["momentum"] < 1e-12
        and info["worst"]["gain"] < 1e-12
        and info["worst"]["overlap"] < 1e-9
    )


@pytest.mark.parametrize(
    "name, value, words",
    [
        ("worst_gain", 1e-3, "gain of energy"),
        ("worst_momentum", 1e-3, "momentum"),
        ("worst_overlap", 1e-3, "overlap"),
        ("lowest", 0.5, "lowest shot"),
        ("fed", 4, "shots fed"),
        ("exit", 4, "unaccounted"),
        ("energy_out", 2.0, "energy left"),
    ],
)
def test_a_run_that_breaks_a_law_is_not_believed(name, value, words):
    world = empty_world(event_setup.ONE_CELL, 0.0)
    world.clock["fed"], world.clock["exit"], world.clock["energy_in"], world.clock["energy_out"] = (
        5,
        5,
        1.0,
        0.5,
    )
    check_run(world, 5, conserves=True)
    world.clock[name] = value
    with pytest.raises(NotConverged, match=words):
        check_run(world, 5, conserves=True)


def _block(size, n):
    """Triangles of a cube whose top face lies in z = 0, each side cut into n x n squares."""
    ticks = np.linspace(-0.5, 0.5, n + 1) * size
    triangles = []
    for axis in range(3):
        for side in (-0.5, 0.5):
            u, v = ((axis + 1) % 3, (axis + 2) % 3)
            for i in range(n):
                for j in range(n):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = np.zeros(3)
                        p[axis], p[u], p[v] = side * size, ticks[a], ticks[b]
                        corners.append(p)
                    if side < 0.0:
                        corners.reverse()
                    triangles += [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    return np.array(triangles) - [0.0, 0.0, 0.5 * size]


@njit
def _foresee(shape, shots):
    for i in range(len(shots)):
        event_surface.foresee_touch(shape, shots[i], (0.0, 0.0, 0.0))


def test_the_tree_of_boxes_finds_what_a_search_of_all_triangles_finds():
    """Spheres flying at, past and away from a block from everywhere, against ``TargetSurface.touch``."""
    surface = TargetSurface("triangles", triangles=_block(0.02, 5))
    rng = np.random.default_rng(5)
    shots = np.zeros(300, SHOT)
    outside = rng.normal(size=(300, 3))
    outside *= 0.04 / np.linalg.norm(outside, axis=1)[:, None]
    aims = rng.uniform(-0.015, 0.015, (300, 3)) - outside
    aims[::7, 0] = 0.0  # along a plane of boxes
    for record, p, v in zip(shots, outside, aims):
        record["x"], record["y"], record["z"] = p[0], p[1], p[2] - 0.01
        record["vx"], record["vy"], record["vz"] = v * 1e3
    shots["radius"] = rng.uniform(0.1e-3, 3e-3, 300)
    _foresee(event_surface.shape_of(surface), shots)
    for record in shots:
        t, _, n = surface.touch(*([record[q + a] for a in "xyz"] for q in ("", "v")), record["radius"])
        assert record["t_surface"] == t
        if t < math.inf:
            np.testing.assert_allclose([record["n" + a] for a in "xyz"], n, atol=1e-12)
    assert 150 < np.isfinite(shots["t_surface"]).sum() < 290
