"""Shots that never meet: closed forms of flight and impact, and the ODE where there is none."""

import dataclasses
import math
import time

import numpy as np
import pytest
from part_shapes import box
from scipy.integrate import solve_ivp

from glue.flow.arrivals import COLUMNS, draw_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.impacts import read_impacts, write_impacts
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene import model

PLANE = TargetSurface()
LAW = RestitutionLaw(0.6)


def shots(*rows):
    """Arrivals by hand: (time, position, velocity, diameter)."""
    made = np.zeros(len(rows), COLUMNS)
    for i, (t, p, v, d) in enumerate(rows):
        made[i] = (i, t, *p, *v, d, 7800.0, 0, 0, 0)
    return made


def column(impacts, *names):
    return np.stack([impacts[name] for name in names], axis=1)


POINT, IN, OUT = (
    ("x_m", "y_m", "z_m"),
    ("vx_in_m_s", "vy_in_m_s", "vz_in_m_s"),
    ("vx_out_m_s", "vy_out_m_s", "vz_out_m_s"),
)


@pytest.mark.parametrize("angle", [90.0, 45.0])
def test_straight_flight_onto_a_plane(make_scene, tmp_path, angle):
    scene = make_scene(impact_angle_deg=angle, size="distribution", size_cv=0.1, speed_cv=0.05)
    arrivals = draw_arrivals(scene)
    impacts, info = run_ballistic(scene, arrivals, LAW, PLANE)
    came = arrivals[impacts["shot_id"]]
    flight = (came["z_m"] - 0.5 * came["diameter_m"]) / -came["vz_m_s"]
    assert len(impacts) == len(arrivals) == info["impacts"] == info["arrived"] > 300
    assert impacts["time_s"] == pytest.approx(came["time_s"] + flight, rel=1e-14)
    assert (np.diff(impacts["time_s"]) > 0.0).all() and (
        impacts["impact_id"] == np.arange(len(impacts))
    ).all()
    for axis in "xy":
        assert impacts[f"{axis}_m"] == pytest.approx(
            came[f"{axis}_m"] + flight * came[f"v{axis}_m_s"], abs=1e-16
        )
        assert (impacts[f"v{axis}_in_m_s"] == came[f"v{axis}_m_s"]).all()
    assert (impacts["z_m"] == 0.0).all()
    assert (impacts["vz_in_m_s"] == came["vz_m_s"]).all()
    assert impacts["vz_out_m_s"] == pytest.approx(-0.6 * came["vz_m_s"])
    assert (impacts["collisions_before"] == 0).all() and np.isnan(impacts["peak_force_N"]).all()
    assert info["collided_fraction"] == 0.0 and info["dropped"] == {"missed": 0}
    assert info["mass_fed_kg"] == pytest.approx((7800.0 * math.pi / 6.0 * arrivals["diameter_m"] ** 3).sum())
    write_impacts(tmp_path / "impacts.csv", impacts, {"scene_hash": "0", "model": "ballistic"})
    assert len(read_impacts(tmp_path / "impacts.csv")[0]) == len(impacts)


def test_friction_turns_sideways_speed_into_spin(make_scene):
    """A grazing impact slides throughout: across mu times the normal impulse, spin 5/2 of it over r."""
    scene = make_scene(shot_target=0.6)
    scene = dataclasses.replace(scene, friction=model.Friction(shot_target=0.05, shot_shot=0.0))
    (impact,), _ = run_ballistic(scene, shots((0.0, (0.0, 0.0, 0.1), (60.0, 0.0, -10.0), 1e-3)), LAW, PLANE)
    lost = 0.05 * 1.6 * 10.0
    assert impact["vx_out_m_s"] == pytest.approx(60.0 - lost)
    assert impact["wy_out_rad_s"] == pytest.approx(2.5 * lost / 0.5e-3)
    assert impact["wx_out_rad_s"] == impact["wz_out_rad_s"] == impact["wy_in_rad_s"] == 0.0


def test_gravity_throws_a_parabola(make_scene):
    g = (3.0, -2.0, -9.0)
    size = math.hypot(*g)
    scene = make_scene(gravity=model.Gravity(size, tuple(c / size for c in g)), speed_m_s=5.0)
    p, v, r = (0.01, 0.02, 0.3), (1.0, 0.5, -2.0), 0.5e-3
    (impact,), _ = run_ballistic(scene, shots((0.5, p, v, 2 * r)), LAW, PLANE)
    t = (-2.0 + math.sqrt(4.0 + 2.0 * 9.0 * (0.3 - r))) / 9.0
    assert impact["time_s"] == pytest.approx(0.5 + t, rel=1e-12)
    for i, axis in enumerate("xy"):
        assert impact[f"{axis}_m"] == pytest.approx(p[i] + v[i] * t + 0.5 * g[i] * t * t, rel=1e-11)
    assert [impact[name] for name in IN] == pytest.approx([a + b * t for a, b in zip(v, g)], rel=1e-11)


@pytest.mark.parametrize(("diameter", "speed"), [(0.05e-3, 60.0), (0.3e-3, 15.0), (1e-3, 300.0)])
@pytest.mark.parametrize("surface", [PLANE, TargetSurface("cylinder", 0.03)], ids=["plane", "cylinder"])
def test_drag_and_gravity_against_the_ode(make_scene, diameter, speed, surface):
    """Moment, place and velocity of the touch; oblique, against gas that blows down. scipy to 1e-12."""
    scene = make_scene(
        diameter_m=diameter,
        speed_m_s=speed,
        gravity=model.Gravity(9.81),
        air_drag=model.AirDrag(1.2, 1.8e-5, gas_speed_m_s=20.0),
    )
    p, v, r = np.array([0.004, -0.01, 0.1]), speed * np.array([0.1, 0.2, -0.97]), 0.5 * diameter

    def rate(_, y):
        u = y[3:] + [0.0, 0.0, 20.0]
        w = np.linalg.norm(u)
        re = 1.2 * w * diameter / 1.8e-5
        cd = 24.0 / re * (1.0 + 0.15 * re**0.687) if re < 1000.0 else 0.44
        k = 0.75 * cd * 1.2 * w / (7800.0 * diameter)
        return np.concatenate([y[3:], -k * u - [0.0, 0.0, 9.81]])

    def gap(_, y):
        return surface.clearance(y[:3]) - r

    gap.terminal = True
    end = solve_ivp(rate, (0.0, 1.0), [*p, *v], events=gap, rtol=1e-12, atol=1e-14, max_step=1e-4)
    moment, state = end.t_events[0][0], end.y_events[0][0]
    (impact,), _ = run_ballistic(scene, shots((0.0, p, v, diameter)), LAW, surface)
    assert impact["time_s"] == pytest.approx(moment, rel=1e-6)
    centre = np.array([impact[a] + r * impact["n" + a[0]] for a in POINT])
    assert centre == pytest.approx(state[:3], abs=1e-7)
    assert [impact[name] for name in IN] == pytest.approx(state[3:], rel=1e-5, abs=1e-5 * speed)


def test_shots_that_miss_a_cylinder_are_counted(make_scene):
    """A 20 mm jet on a shaft of 8 mm radius: those within R + r of its axis strike, at its own normal."""
    scene, shaft = make_scene(), TargetSurface("cylinder", 0.008, "x")
    arrivals = draw_arrivals(scene)
    impacts, info = run_ballistic(scene, arrivals, LAW, shaft)
    strikes = np.abs(arrivals["y_m"]) < 0.008 + 0.0005
    assert set(impacts["shot_id"]) == set(arrivals["shot_id"][strikes])
    assert info["dropped"] == {"missed": int((~strikes).sum())} and 0 < (~strikes).sum() < len(arrivals)
    off = arrivals["y_m"][impacts["shot_id"]]
    assert impacts["ny"] == pytest.approx(off / 0.0085, rel=1e-9, abs=1e-15)
    n, before, after = column(impacts, "nx", "ny", "nz"), column(impacts, *IN), column(impacts, *OUT)
    assert np.linalg.norm(n, axis=1) == pytest.approx(1.0)
    assert (after * n).sum(1) == pytest.approx(-0.6 * (before * n).sum(1), abs=1e-12)


def test_a_flat_part_of_triangles_is_a_plane(make_scene):
    scene = make_scene(impact_angle_deg=60.0, exposure_time_s=0.005)
    arrivals = draw_arrivals(scene)
    plate = TargetSurface("triangles", triangles=box((-0.05, -0.05, -0.01), (0.05, 0.05, 0.0), n=5))
    (plain, _), (part, _) = (run_ballistic(scene, arrivals, LAW, s) for s in (PLANE, plate))
    for name in plain.dtype.names:
        assert part[name] == pytest.approx(plain[name], rel=1e-9, abs=1e-9, nan_ok=True), name


def test_restitution_follows_the_normal_speed(make_scene):
    law = RestitutionLaw(0.5, speed_m_s=60.0, exponent=0.25)
    rows = [(1e-3 * i, (0.0, 0.0, 0.1), (20.0, 0.0, -v), 1e-3) for i, v in enumerate((60.0, 30.0, 3.75))]
    impacts, _ = run_ballistic(make_scene(), shots(*rows), law, PLANE)
    by_shot = impacts[np.argsort(impacts["shot_id"])]
    assert by_shot["vz_out_m_s"] == pytest.approx([30.0, 30.0 * 0.5 * 2**0.25, 3.75 * 0.94])


def test_hardening_counts_earlier_impacts_within_the_spot(make_scene):
    hardening = model.SpotHardening(saturated=0.9, hits=2.0)
    law = RestitutionLaw(0.5, hardening=hardening, spot_radius_m=1e-3)
    scene = make_scene()
    impacts, _ = run_ballistic(scene, draw_arrivals(scene), law, PLANE)
    place = column(impacts, "x_m", "y_m")
    earlier = [int((np.linalg.norm(place[:k] - place[k], axis=1) <= 1e-3).sum()) for k in range(len(place))]
    assert max(earlier) >= 5 and min(earlier) == 0
    expected = 0.9 - 0.4 * np.exp(-np.array(earlier) / 2.0)
    assert impacts["vz_out_m_s"] / 60.0 == pytest.approx(expected)


def test_shots_that_the_gas_stops_never_arrive(make_scene):
    """Glass of 20 um at 15 m/s goes some centimetres in still air."""
    scene = make_scene(
        diameter_m=20e-6, density_kg_m3=2500.0, speed_m_s=15.0, air_drag=model.AirDrag(1.2, 1.8e-5)
    )
    arrivals = shots(
        (0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -15.0), 20e-6), (0.0, (0.0, 0.0, 0.002), (0.0, 0.0, -15.0), 20e-6)
    )
    arrivals["density_kg_m3"] = 2500.0
    impacts, info = run_ballistic(scene, arrivals, LAW, PLANE)
    assert impacts["shot_id"].tolist() == [1] and info["dropped"] == {"missed": 1}
    assert 0.0 < -impacts["vz_in_m_s"][0] < 15.0


def test_no_shots_no_impacts(make_scene):
    impacts, info = run_ballistic(make_scene(), shots(), LAW, PLANE)
    assert len(impacts) == 0 and info["mean_normal_speed_m_s"] is None and info["peak_live_shots"] == 0


def test_shots_on_their_way_at_once(make_scene):
    """Three start while the first, of .1 m at 10 m/s, flies its 9.95 ms; the fourth after it has struck."""
    rows = [(t, (0.0, 0.0, 0.1), (0.0, 0.0, -10.0), 1e-3) for t in (0.0, 0.004, 0.009, 0.0125)]
    _, info = run_ballistic(make_scene(), shots(*rows), LAW, PLANE)
    assert info["peak_live_shots"] == 3


def test_a_hundred_thousand_shots_take_no_time(make_scene):
    scene = make_scene(exposure_time_s=5.0)
    arrivals = draw_arrivals(scene)
    assert len(arrivals) > 1e5
    walls = []
    for _ in range(3):
        begun = time.perf_counter()
        run_ballistic(scene, arrivals, LAW, PLANE)
        walls.append(time.perf_counter() - begun)
    assert min(walls) < 1.0  # some .05 s; other work may share the machine
