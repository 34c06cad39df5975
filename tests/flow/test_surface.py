"""Spheres that fly straight against planes, cylinders and triangles: hand geometry and exact distances.

The distance to a box, and to two of them, has a closed form of its own; it judges time and place of every
touch, whichever face, edge or corner it is.
"""

import itertools
import math
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from part_shapes import box, cylinder, step

from glue.errors import InputError
from glue.flow import surface as surfaces
from glue.flow.surface import TargetSurface
from glue.flow.triangles import check_triangles, normals, placement_problems
from glue.scene import model


def outside_box(p, low, high):
    """Distance of points (…, 3) from a box, 0 inside."""
    return np.linalg.norm(np.maximum(np.maximum(low - p, p - high), 0.0), axis=-1)


BOX = (np.array([-1.0, -1.0, -1.0]), np.array([1.0, 1.0, 0.0]))
UPPER = (np.array([-1.0, -1.0, 0.0]), np.array([0.0, 1.0, 1.0]))
DISTANCES = {
    "box": lambda p: outside_box(p, *BOX),
    "fine box": lambda p: outside_box(p, *BOX),
    "step": lambda p: np.minimum(outside_box(p, *BOX), outside_box(p, *UPPER)),
}
BODIES = {"box": box(), "fine box": box(n=4), "step": step()}


def test_plane():
    plane = TargetSurface()
    t, point, normal = plane.touch((1.0, 2.0, 3.0), (0.5, 0.0, -2.0), 1.0)
    assert (t, point, normal) == (1.0, (1.5, 2.0, 0.0), (0.0, 0.0, 1.0))
    assert plane.touch((0.0, 0.0, 3.0), (1.0, 0.0, 0.0), 1.0)[0] == math.inf
    assert plane.touch((0.0, 0.0, 1.0 - 1e-18), (0.0, 0.0, -1.0), 1.0)[0] == 0.0
    assert plane.touch((0.0, 0.0, 1.0 - 1e-18), (0.0, 0.0, 1.0), 1.0)[0] == math.inf
    assert plane.clearance((5.0, 0.0, -0.1)) == -0.1


@pytest.mark.parametrize("axis", ["x", "y"])
def test_cylinder_by_hand(axis):
    """A shot that falls beside the apex: centre at R + r from the axis line when it touches."""
    R, r, off = 0.02, 5e-4, 0.012
    p = (off, 0.003, 0.1) if axis == "y" else (0.003, off, 0.1)
    t, point, normal = TargetSurface("cylinder", R, axis).touch(p, (0.0, 0.0, -60.0), r)
    up = math.sqrt((R + r) ** 2 - off**2)
    assert t == pytest.approx((0.1 - up + R) / 60.0, rel=1e-14)
    across, along = (0, 1) if axis == "y" else (1, 0)
    assert normal[across] == pytest.approx(off / (R + r), rel=1e-12) and normal[along] == 0.0
    assert normal[2] == pytest.approx(up / (R + r), rel=1e-12)
    assert point[across] == pytest.approx(R * off / (R + r), rel=1e-12) and point[along] == 0.003
    assert point[2] == pytest.approx(R * (up / (R + r) - 1.0), rel=1e-12)


def test_cylinder_grazed_missed_and_left():
    c = TargetSurface("cylinder", 0.02)
    down = (0.0, 0.0, -60.0)
    assert c.touch((0.0205 * (1 - 1e-12), 0.0, 0.1), down, 5e-4)[0] < math.inf
    assert c.touch((0.0205 * (1 + 1e-12), 0.0, 0.1), down, 5e-4)[0] == math.inf
    assert c.touch((0.0, 0.0, 5e-4), (0.0, 1.0, 0.0), 5e-4)[0] == math.inf  # along the axis, touching
    assert c.touch((0.0, 0.0, 5e-4 - 1e-18), (3.0, 0.0, 1.0), 5e-4)[0] == math.inf
    assert c.clearance((0.03, 7.0, -0.02)) == pytest.approx(0.01)
    assert c.clearance((0.0, 7.0, -0.02)) == -0.02
    assert c.height(0.012, 0.0) == pytest.approx(0.016 - 0.02)
    assert c.height(0.03, 0.0) == -math.inf
    assert c.lowest_m == -0.04


def test_face_edge_and_corner_by_hand():
    cube, r = TargetSurface("triangles", triangles=BODIES["box"]), 0.25
    t, point, normal = cube.touch((0.3, -0.2, 2.0), (0.0, 0.0, -1.0), r)
    assert t == pytest.approx(1.75) and point == pytest.approx((0.3, -0.2, 0.0)) and normal == (0.0, 0.0, 1.0)
    # at 45 degrees onto the edge x = 1, z = 0
    s = math.sqrt(0.5)
    t, point, normal = cube.touch((2.0, 0.1, 1.0), (-1.0, 0.0, -1.0), r)
    assert t == pytest.approx(1.0 - r * s) and point == pytest.approx((1.0, 0.1, 0.0))
    assert normal == pytest.approx((s, 0.0, s))
    # past the edge by less than r: touched on its rounding, r^2 = off^2 + height^2
    t, point, normal = cube.touch((1.2, 0.1, 1.0), (0.0, 0.0, -2.0), r)
    assert t == pytest.approx((1.0 - 0.15) / 2.0) and normal == pytest.approx((0.8, 0.0, 0.6))
    # along the diagonal onto the corner
    d = math.sqrt(1.0 / 3.0)
    t, point, normal = cube.touch((2.0, 2.0, 1.0), (-d, -d, -d), r)
    assert t == pytest.approx(math.sqrt(3.0) - r) and point == pytest.approx((1.0, 1.0, 0.0))
    assert normal == pytest.approx((d, d, d))
    # past an edge's end: the corner's sphere, not the edge's endless cylinder
    t, point, _ = cube.touch((1.1, 1.2, 1.0), (0.0, 0.0, -1.0), r)
    assert point == pytest.approx((1.0, 1.0, 0.0))
    assert t == pytest.approx(1.0 - math.sqrt(r**2 - 0.1**2 - 0.2**2))
    assert cube.touch((1.2, 1.2, 1.0), (0.0, 0.0, -1.0), r)[0] == math.inf


@pytest.mark.parametrize("body", BODIES)
def test_random_flights_against_exact_distances(body):
    """At the touch the distance is r, before it never less, and flights without touch never come near."""
    target, distance = TargetSurface("triangles", triangles=BODIES[body]), DISTANCES[body]
    rng = np.random.default_rng(7)
    touched = 0
    for _ in range(1500):
        r = 10.0 ** rng.uniform(-2.0, -0.3)
        start = rng.normal(size=3)
        start = 3.0 * start / np.linalg.norm(start)
        v = rng.uniform(-1.2, 1.2, 3) - start
        if distance(start) <= r:
            continue
        t, point, normal = target.touch(tuple(start.tolist()), tuple(v.tolist()), float(r))
        way = np.linspace(0.0, min(t, 2.5), 400)[:, None] * v + start
        assert distance(way).min() >= r - 1e-9
        if t == math.inf:
            continue
        touched += 1
        centre = start + t * v
        assert distance(centre) == pytest.approx(r, abs=1e-9)
        assert np.linalg.norm(centre - point) == pytest.approx(r, abs=1e-9)
        assert np.array(normal) == pytest.approx((centre - point) / r, abs=1e-6)
        assert distance(np.array(point)) < 1e-12
    assert touched > 300


def test_nothing_slips_between_triangles_of_a_flat_face():
    """Shots aimed exactly at the joints of a subdivided face touch its plane."""
    target = TargetSurface("triangles", triangles=box(n=7))
    joints = np.linspace(-1.0, 1.0, 15)[1:-1]
    for x, y in itertools.product(joints, joints):
        t, _, normal = target.touch((x, y, 2.0), (0.0, 0.0, -1.0), 0.1)
        assert t == pytest.approx(1.9) and normal == (0.0, 0.0, 1.0)


def test_a_shot_in_a_concave_edge_touches_both_faces_in_turn():
    target = TargetSurface("triangles", triangles=BODIES["step"])
    p, r = (0.1, 0.0, 0.1), 0.1  # touches floor and wall
    assert target.touch(p, (-1.0, 0.0, 1.0), r)[::2] == (0.0, (1.0, 0.0, 0.0))
    assert target.touch(p, (1.0, 0.0, -1.0), r)[::2] == (0.0, (0.0, 0.0, 1.0))
    assert target.touch(p, (1.0, 0.0, 1.0), r)[0] == math.inf
    t, point, normal = target.touch(
        (0.5, 0.0, 0.1 - 1e-17), (-1.0, 0.0, 0.5), r
    )  # off the floor, to the wall
    assert t == pytest.approx(0.4) and normal == (1.0, 0.0, 0.0) and point == pytest.approx((0.0, 0.0, 0.3))


def test_a_shot_under_a_thin_plate_is_not_inside_it():
    plate = TargetSurface("triangles", triangles=box((-1.0, -1.0, -0.01), (1.0, 1.0, 0.0)))
    assert plate.touch((0.0, 0.0, -0.5), (0.0, 0.0, -1.0), 0.1)[0] == math.inf
    assert plate.touch((0.0, 0.0, -0.5), (0.0, 0.0, 1.0), 0.1)[2] == pytest.approx((0.0, 0.0, -1.0))


@pytest.mark.parametrize("body", BODIES)
def test_clearance_of_points(body):
    target, distance = TargetSurface("triangles", triangles=BODIES[body]), DISTANCES[body]
    for p in np.random.default_rng(3).uniform(-1.6, 1.6, (400, 3)):
        outside = distance(p)
        found = target.clearance(p)
        assert found == pytest.approx(outside, abs=1e-12) if outside > 0.0 else found <= 1e-12


def test_clearance_inside_is_the_depth():
    target = TargetSurface("triangles", triangles=BODIES["box"])
    assert target.clearance((0.9, 0.2, -0.5)) == pytest.approx(-0.1)
    assert target.clearance((0.3, 0.2, -0.05)) == pytest.approx(-0.05)


def test_triangles_of_a_cylinder_come_to_the_cylinder():
    """Inscribed with n sides the surface lies at most R (1 - cos(pi / n)) inside: error falls as n^-2."""
    exact, rng = TargetSurface("cylinder", 0.02), np.random.default_rng(5)
    flights = [(x, y, 0.05) for x, y in rng.uniform(-0.015, 0.015, (40, 2)).tolist()]
    worst = []
    for n in (24, 48, 96):
        target = TargetSurface("triangles", triangles=cylinder(n=n, rings=2))
        late = [
            target.touch(p, (0.0, 0.0, -1.0), 5e-4)[0] - exact.touch(p, (0.0, 0.0, -1.0), 5e-4)[0]
            for p in flights
        ]
        assert min(late) > -1e-15
        worst.append(max(late))
    assert np.polyfit(np.log([24, 48, 96]), np.log(worst), 1)[0] == pytest.approx(-2.0, abs=0.35)


@pytest.mark.parametrize("body", BODIES)
def test_nearest_point_and_normal(body):
    """The foot lies on the surface, at the distance, and from outside the normal points at the point."""
    target, distance = TargetSurface("triangles", triangles=BODIES[body]), DISTANCES[body]
    for p in np.random.default_rng(8).uniform(-1.6, 1.6, (200, 3)):
        away, foot, normal = target.nearest(p)
        assert distance(np.array(foot)) == pytest.approx(0.0, abs=1e-12)
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        assert np.array(foot) + away * np.array(normal) == pytest.approx(p, abs=1e-9)


def test_nearest_on_the_closed_forms():
    assert TargetSurface().nearest((1.0, 2.0, -0.5)) == (-0.5, (1.0, 2.0, 0.0), (0.0, 0.0, 1.0))
    away, foot, normal = TargetSurface("cylinder", 0.02, "x").nearest((7.0, 0.03, 0.02))
    assert away == pytest.approx(0.03) and foot == pytest.approx((7.0, 0.012, -0.004))
    assert normal == pytest.approx((0.0, 0.6, 0.8))


def test_height_seen_from_above():
    target = TargetSurface("triangles", triangles=BODIES["step"])
    assert [target.height(x, 0.3) for x in (-0.5, 0.5, 1.5)] == [1.0, 0.0, -math.inf]
    assert target.lowest_m == -1.0


def test_normals_face_outwards():
    n, area = normals(BODIES["box"])
    assert area.sum() == pytest.approx(16.0)  # 2 x 2 x 1
    middle = BODIES["box"].mean(axis=1) - [0.0, 0.0, -0.5]
    assert ((n * middle).sum(axis=1) > 0.0).all()


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda t: t[:-1], "open: 3 edges belong to one triangle only .first: from "),
        (lambda t: np.concatenate([t[:3], t[3:4, ::-1], t[4:]]), "inverted triangles: at 3 edges"),
        (lambda t: t[:, ::-1], "inside out: 1 of 1 closed shells"),
        (lambda t: np.concatenate([t, t[:, ::-1] + 5.0]), "inside out: 1 of 2 closed shells"),
        (lambda t: np.concatenate([t, t[:1]]), "3 edges belong to more than two"),
        (lambda t: np.concatenate([t, [[t[0, 0], t[0, 1], t[0, 0]]]]), "1 of 13 triangles are degenerate"),
        (lambda t: np.where(t == t.max(), np.nan, t), "not a finite number"),
        (lambda t: t[:3], "at least 4 triangles"),
        (lambda t: t.reshape(-1, 9), "at least 4 triangles of 3 corners"),
    ],
)
def test_unsound_surfaces_are_refused_in_words(spoil, says):
    bad = spoil(box())
    assert any(says.replace(" .first", " (first") in sentence for sentence in check_triangles(bad))
    with pytest.raises(InputError, match="target surface: "):
        TargetSurface("triangles", triangles=bad)


def test_corners_written_in_single_precision_still_meet():
    """STL files hold 32-bit numbers, and some writers compute each triangle's corners anew."""
    rough = cylinder().astype(np.float32).astype(float)
    rough += 1e-10 * np.random.default_rng(1).uniform(-1.0, 1.0, rough.shape)
    assert check_triangles(rough) == []


def test_the_part_must_touch_the_origin():
    assert placement_problems(box(), (0.004, 0.004)) == []
    assert placement_problems(box() + [0.0, 0.0, 3e-6], (0.004, 0.004)) == []
    (raised,) = placement_problems(box() + [0.0, 0.0, 0.01], (0.004, 0.004))
    assert "0.01 m high" in raised and "within 4e-06 m" in raised
    (beside,) = placement_problems(box() + [3.0, 0.0, 0.0], (0.004, 0.004))
    assert "no surface above or below" in beside
    (narrow,) = placement_problems(box() + [0.999, 0.0, 0.0], (0.004, 0.004))
    assert "reaches beyond the part" in narrow and "(-0.002, -0.002)" in narrow
    (millimetres,) = placement_problems(20.0 * box(), (0.004, 0.004))
    assert "40 m long; at most 10 m (coordinates must be in metres)" in millimetres


def test_surface_of_a_scene(make_scene):
    scene = make_scene()
    assert surfaces.from_scene(scene).kind == "plane"
    target = model.Target(scene.target.material, (0.004, 0.004), surface=model.Surface("cylinder", 0.02, "x"))
    shaft = surfaces.from_scene(make_scene(target=target))
    assert (shaft.kind, shaft.radius_m, shaft.axis_number) == ("cylinder", 0.02, 0)
    target = model.Target(scene.target.material, (0.004, 0.004), surface=model.Surface("stl", file="a.stl"))
    part = make_scene(target=target)
    assert surfaces.from_scene(part, 0.01 * box()).kind == "triangles"
    with pytest.raises(InputError, match="triangles of its STL file are needed"):
        surfaces.from_scene(part)
    with pytest.raises(InputError, match="must pass through the origin"):
        surfaces.from_scene(part, 0.01 * box() + [0.0, 0.0, 0.02])


@pytest.mark.parametrize(
    "made",
    [
        TargetSurface(),
        TargetSurface("cylinder", 0.0123, "x"),
        TargetSurface("triangles", triangles=step() / 3.0),
    ],
)
def test_saved_and_loaded(tmp_path, made):
    made.save(tmp_path / "surface.npz")
    read = surfaces.load(tmp_path / "surface.npz")
    assert (read.kind, read.radius_m, read.axis) == (made.kind, made.radius_m, made.axis)
    flight = ((0.01, 0.02, 2.0), (0.0, 0.0, -1.0), 0.001)
    assert read.touch(*flight) == made.touch(*flight)


def test_what_is_no_surface_file_is_refused(tmp_path):
    (tmp_path / "a.npz").write_text("no archive")
    np.savez(tmp_path / "b.npz", kind="plane")
    for name in ("a.npz", "b.npz", "missing.npz"):
        with pytest.raises(InputError, match=name):
            surfaces.load(tmp_path / name)


SHARED = """
import sys
sys.path[:0] = sys.argv[1:]
import random
from part_shapes import cylinder, step
from glue.flow import drag, jets, restitution, tangential, touch
from glue.flow.surface import TargetSurface, check_triangles
random.seed(1)
around = drag.Surroundings(1.2, 1.8e-5, 0.0, 0.0, -20.0, 0.0, 0.0, -9.81)
targets = [TargetSurface("triangles", triangles=cylinder()), TargetSurface("cylinder", 0.02)]
print(check_triangles(step()[:-1]))
for _ in range(200):
    p = random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.05
    v = random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0), -60.0
    print([t.touch(p, v, 5e-4) for t in targets])
    print(drag.slowed(*v, 1e-4, 1e-4, 2500.0, around), tangential.impulse_across(60.0, abs(v[0]), 0.5, 0.2))
"""


@pytest.mark.solver
def test_debians_python_gives_the_same_numbers(tmp_path):
    """YADE's interpreter, with its numpy: to the last digit, surface of triangles included."""
    folders = [Path(__file__).parents[2], Path(__file__).parent]
    outputs = [
        subprocess.run(
            [python, "-c", SHARED, *folders], capture_output=True, text=True, check=True, cwd=tmp_path
        ).stdout
        for python in (sys.executable, "/usr/bin/python3")
    ]
    assert len(outputs[0].splitlines()) == 401 and "open: 3 edges" in outputs[0]
    assert outputs[0] == outputs[1]


def test_a_part_of_two_thousand_triangles_answers_quickly():
    """YADE asks once per shot and flight, in plain Python: .06 ms on the machine of record."""
    target = TargetSurface("triangles", triangles=cylinder(n=64, rings=15))
    assert 2000 < len(target.triangles) < 2100
    rng = np.random.default_rng(2)
    flights = [(x, y, 0.1) for x, y in rng.uniform(-0.015, 0.015, (300, 2)).tolist()]
    best = math.inf
    for _ in range(3):
        begun = time.perf_counter()
        for p in flights:
            target.touch(p, (0.0, 3.0, -60.0), 5e-4)
        best = min(best, (time.perf_counter() - begun) / len(flights))
    assert best < 400e-6  # four times that: other work may share the machine
