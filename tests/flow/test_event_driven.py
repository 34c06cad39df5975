"""Event-driven flow: closed forms, an independent reference, its own conservation laws, stopping and going on."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from event_cases import march, shots, smooth_scene
from scenes import bare_scene

from glue import stopping
from glue.errors import InputError, NotConverged
from glue.flow import event_driven
from glue.flow.arrivals import draw_arrivals
from glue.flow.event_driven import run_event
from glue.flow.event_state import Grid, empty_world
from glue.flow.impacts import COLUMNS, normal_speed_m_s
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.effects import Gravity
from glue.scene.model import SpotHardening

PLANE = TargetSurface()
LAW = RestitutionLaw(0.6)
ONE_CELL = Grid(0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1, 1, 1)
DOWN = (0.0, 0.0, -60.0)


def test_a_shot_that_meets_none_lands_where_its_flight_takes_it():
    scene = bare_scene(impact_angle_deg=60.0, mass_flow_kg_s=0.002, exposure_time_s=0.1)
    arrivals = draw_arrivals(scene)
    impacts, _ = run_event(scene, arrivals, LAW, PLANE)
    free = impacts[impacts["collisions_before"] == 0]
    free = free[np.unique(free["shot_id"], return_index=True)[1]]
    assert len(free) > 30
    left = arrivals[free["shot_id"]]
    flight = (left["z_m"] - 0.5 * left["diameter_m"]) / -left["vz_m_s"]
    np.testing.assert_allclose(free["time_s"], left["time_s"] + flight, rtol=1e-14)
    np.testing.assert_allclose(free["x_m"], left["x_m"] + left["vx_m_s"] * flight, atol=1e-16)
    np.testing.assert_array_equal(free["vx_in_m_s"], left["vx_m_s"])


def test_fifty_shots_as_by_a_search_of_all_pairs_at_every_event():
    """Mixed sizes and densities, slanted, friction: every impact of the independent reference, in its order."""
    scene = smooth_scene(mu=0.2, impact_angle_deg=70.0)
    rng = np.random.default_rng(3)
    n = 50
    across = rng.uniform(-1e-3, 1e-3, (n, 2))
    tilt = math.radians(70.0)
    velocity = 60.0 * np.array([math.cos(tilt), 0.0, -math.sin(tilt)])
    rows = [
        (3.5e-5 * k, (-0.034 + x, y, 0.094), velocity * (1.0 + 0.1 * rng.random()), d, density)
        for k, ((x, y), d, density) in enumerate(
            zip(across, rng.uniform(0.4e-3, 0.8e-3, n), rng.choice([7800.0, 2500.0], n))
        )
    ]
    arrivals = shots(*rows)
    expected = march(arrivals, 0.6, 0.8, 0.2, until_s=0.006)
    impacts, info = run_event(scene, arrivals, LAW, PLANE)
    impacts = impacts[impacts["time_s"] < 0.006]
    assert info["shot_shot_collisions"] > 20
    assert impacts["shot_id"].tolist() == expected[:, 0].astype(int).tolist()
    np.testing.assert_allclose(impacts["time_s"], expected[:, 1], rtol=1e-9)
    got = np.column_stack(
        [impacts[f"v{a}_in_m_s"] for a in "xyz"]
        + [impacts[f"v{a}_out_m_s"] for a in "xyz"]
        + [impacts[f"w{a}_out_rad_s"] for a in "xyz"]
    )
    np.testing.assert_allclose(got, expected[:, 2:], rtol=1e-6, atol=1e-6)


def test_the_cells_do_not_change_a_bit():
    scene = bare_scene(mass_flow_kg_s=0.5, exposure_time_s=0.012)
    arrivals = draw_arrivals(scene)
    expected, info = run_event(scene, arrivals, LAW, PLANE, grid=ONE_CELL)
    assert info["cell_crossings"] == 0
    for grid in (
        None,
        Grid(-0.006, -0.003, 0.01, 1.1e-3, 1.7e-3, 4e-3, 9, 5, 11),  # smaller than the jet
        Grid(-0.02, -0.02, 0.0, 3e-3, 3e-3, 1.0, 13, 13, 1),
    ):
        impacts, info = run_event(scene, arrivals, LAW, PLANE, grid=grid)
        assert info["cell_crossings"] > 1000
        assert impacts.tobytes() == expected.tobytes()


def test_elastic_smooth_shots_keep_their_energy():
    scene = smooth_scene(mass_flow_kg_s=1.0, exposure_time_s=0.008, shot_shot=1.0)
    _, info = run_event(scene, draw_arrivals(scene), RestitutionLaw(1.0), PLANE)
    assert info["shot_shot_collisions"] > 2000
    assert info["energy_left_over_fed"] == pytest.approx(1.0, abs=1e-9)
    assert info["worst"]["momentum"] < 1e-12


def test_lossy_rough_shots_lose_some_and_all_are_accounted_for():
    scene = bare_scene(mass_flow_kg_s=0.3, size="distribution", size_cv=0.15)
    arrivals = draw_arrivals(scene)
    impacts, info = run_event(scene, arrivals, LAW, PLANE)
    assert 0.1 < info["energy_left_over_fed"] < 0.6
    assert info["arrived"] == len(arrivals) == sum(info["dropped"].values()) + info["in_flight"]
    assert info["mass_fed_kg"] == pytest.approx(7800.0 * math.pi / 6.0 * (arrivals["diameter_m"] ** 3).sum())
    assert impacts.dtype == COLUMNS and (np.diff(impacts["time_s"]) >= 0.0).all()
    assert (impacts["impact_id"] == np.arange(len(impacts))).all()
    assert (normal_speed_m_s(impacts) > 0.0).all()


def test_restitution_follows_the_speed():
    law = RestitutionLaw(0.6, speed_m_s=60.0, exponent=0.25)
    impacts, info = run_event(bare_scene(), draw_arrivals(bare_scene()), law, PLANE)
    normal = normal_speed_m_s(impacts)
    assert info["collapse_guard_hits"] == 0 and normal.min() < 10.0
    expected = np.minimum(0.94, 0.6 * (normal / 60.0) ** -0.25)
    np.testing.assert_allclose(impacts["vz_out_m_s"] / normal, expected, rtol=1e-12)


def test_restitution_follows_a_table_and_the_shots_density():
    points = ((4.0, 0.7), (30.0, 0.5), (60.0, 0.3))
    law = RestitutionLaw(0.3, 60.0, points=points, density_kg_m3=4 * 7800.0)  # ours are as if half as fast
    impacts, _ = run_event(bare_scene(), draw_arrivals(bare_scene()), law, PLANE)
    normal = normal_speed_m_s(impacts)
    assert normal.min() < 8.0
    x, y = np.log(points).T
    beyond = y[0] + (y[1] - y[0]) / (x[1] - x[0]) * (np.log(0.5 * normal) - x[0])
    expected = np.exp(np.where(0.5 * normal < 4.0, beyond, np.interp(np.log(0.5 * normal), x, y)))
    np.testing.assert_allclose(impacts["vz_out_m_s"] / normal, np.minimum(0.94, expected), rtol=1e-12)


def test_equal_elastic_shots_in_line_hand_on_their_speeds():
    """The fast last one pushes through: each collision carries its speed forward by one diameter."""
    scene = smooth_scene(shot_shot=1.0)
    line = [(t, (0.0, 0.0, 0.1), (0.0, 0.0, -v)) for t, v in ((0.0, 20.0), (0.0005, 25.0), (0.001, 60.0))]
    impacts, _ = run_event(scene, shots(*line), LAW, PLANE)
    first = impacts[0]
    assert first["shot_id"] == 0
    assert first["vz_in_m_s"] == pytest.approx(-60.0, rel=1e-12)
    assert first["time_s"] == pytest.approx(0.001 + (0.1 - 0.0005 - 2 * 0.001) / 60.0, rel=1e-12)


def test_shots_bounce_under_gravity_until_they_rest():
    """Closed form: speed sqrt(v^2 + 2 g h) at first touch, then e^k of it, 2 v / g between touches."""
    scene = smooth_scene(gravity=Gravity(9.81), speed_m_s=0.5)
    law = RestitutionLaw(0.5)
    impacts, info = run_event(scene, shots((0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -0.5))), law, PLANE)
    speed = math.sqrt(0.5**2 + 2.0 * 9.81 * 0.0995)
    speeds = speed * 0.5 ** np.arange(len(impacts))
    np.testing.assert_allclose(-impacts["vz_in_m_s"], speeds, rtol=1e-9)
    np.testing.assert_allclose(np.diff(impacts["time_s"]), 2.0 * speeds[1:] / 9.81, rtol=1e-9)
    assert impacts["time_s"][0] == pytest.approx((speed - 0.5) / 9.81, rel=1e-12)
    assert info["dropped"]["settled"] == 1
    assert (
        0.5 * speeds[-1] < math.sqrt(2.0 * 9.81 * 1e-3 * 0.5e-3) < speeds[-1]
    )  # rests within .1 % of a radius


def test_endless_bouncing_between_target_and_a_heavy_shot_is_ended_and_counted():
    scene = smooth_scene(shot_shot=0.1, diameter_m=0.2e-3)
    trap = shots(
        (0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -60.0), 0.2e-3, 2500.0),
        (0.0002, (0.0, 0.0, 0.1), (0.0, 0.0, -60.0), 2e-3, 7800.0),
    )
    impacts, info = run_event(scene, trap, RestitutionLaw(0.1), PLANE)
    assert info["collapse_guard_hits"] > 0
    assert info["events"] < 10_000
    assert 1 in impacts["shot_id"] or info["in_flight"]


def test_a_spot_already_struck_rebounds_more():
    law = RestitutionLaw(0.5, hardening=SpotHardening(0.8, 3.0), spot_radius_m=0.2e-3)
    places = [0.0, 0.1e-3, 5e-3, -0.15e-3, 0.05e-3, 5.19e-3, -0.30e-3]
    rows = [(0.01 * k, (x, 0.0, 0.1), DOWN) for k, x in enumerate(places)]
    impacts, _ = run_event(smooth_scene(), shots(*rows), law, PLANE)
    earlier = [sum(abs(x - y) <= 0.2e-3 for y in places[:k]) for k, x in enumerate(places)]
    assert earlier == [0, 1, 0, 1, 3, 1, 1]
    expected = [law.at_spot(0.5, n) for n in earlier]
    np.testing.assert_allclose(impacts["vz_out_m_s"] / 60.0, expected, rtol=1e-12)


def test_a_straggler_does_not_keep_the_run():
    rows = [(0.0, (0.0, 0.0, 0.1), (0.0, 0.0, -0.1)), (0.0, (5e-3, 0.0, 0.1), DOWN)]
    impacts, info = run_event(bare_scene(), shots(*rows), LAW, PLANE)
    assert impacts["shot_id"].tolist() == [1]
    assert info["would_still_strike"] == 1 and info["simulated_s"] < 0.05


def test_going_on_from_a_checkpoint_changes_no_bit(tmp_path, monkeypatch):
    law = RestitutionLaw(0.6, hardening=SpotHardening(0.8, 3.0), spot_radius_m=0.2e-3)
    scene = bare_scene(mass_flow_kg_s=0.5, exposure_time_s=0.01)
    arrivals = draw_arrivals(scene)
    expected, numbers = run_event(scene, arrivals, law, PLANE)
    file = tmp_path / "flow.npz"
    monkeypatch.setattr(event_driven, "EVENTS", 997)
    monkeypatch.setattr(event_driven, "ROWS", 61)
    for stop_after in (2, 5, 9):
        calls = iter(range(stop_after))
        monkeypatch.setattr(stopping, "check", calls.__next__)  # raises at last, as Ctrl-C would
        with pytest.raises(StopIteration):
            run_event(scene, arrivals, law, PLANE, checkpoint=file, checkpoint_every_s=0.0)
        assert file.exists()
    monkeypatch.setattr(stopping, "check", lambda: None)
    seen = []
    impacts, info = run_event(scene, arrivals, law, PLANE, checkpoint=file, on_impacts=seen.append)
    assert impacts.tobytes() == expected.tobytes() == np.concatenate(seen).tobytes()
    assert {**info, "wall_s": 0} == {**numbers, "wall_s": 0}
    assert list(tmp_path.iterdir()) == []


def test_a_checkpoint_of_another_run_is_refused(tmp_path, monkeypatch):
    scene = bare_scene(exposure_time_s=0.005)
    arrivals = draw_arrivals(scene)
    monkeypatch.setattr(event_driven, "EVENTS", 100)
    monkeypatch.setattr(stopping, "check", lambda: (_ for _ in ()).throw(KeyboardInterrupt))
    file = tmp_path / "flow.npz"
    with pytest.raises(KeyboardInterrupt):
        run_event(scene, arrivals, LAW, PLANE, checkpoint=file)
    monkeypatch.setattr(stopping, "check", lambda: None)
    with pytest.raises(InputError, match="another scene"):
        run_event(scene, arrivals, RestitutionLaw(0.5), PLANE, checkpoint=file)
    fresh, _ = run_event(scene, arrivals, RestitutionLaw(0.5), PLANE, checkpoint=file, resume=False)
    assert len(fresh) > 0
    file.write_bytes(b"PK")
    with pytest.raises(InputError, match="damaged"):
        run_event(scene, arrivals, LAW, PLANE, checkpoint=file)


def test_progress_rises_to_the_end(monkeypatch):
    scene = bare_scene()
    monkeypatch.setattr(event_driven, "EVENTS", 50)
    monkeypatch.setattr(event_driven, "SAY_EVERY_S", 0.0)
    told = []
    run_event(
        scene, draw_arrivals(scene), LAW, PLANE, progress=lambda share, text: told.append((share, text))
    )
    shares = [share for share, _ in told]
    assert len(shares) > 5 and shares == sorted(shares) and 0.0 <= shares[0] and shares[-1] <= 1.0
    assert "s left" in told[-1][1]


def test_no_shots_are_refused():
    with pytest.raises(InputError, match="no shot leaves"):
        run_event(bare_scene(), shots(), LAW, PLANE)


def test_shots_from_nowhere_are_refused():
    rows = [(0.0, (0.0, 0.0, 0.1), DOWN), (0.001, (0.0, math.nan, 0.1), DOWN)]
    with pytest.raises(InputError, match="y_m: every number must be finite"):
        run_event(bare_scene(), shots(*rows), LAW, PLANE)


def test_a_shot_that_gets_lost_is_noticed():
    """A gravity that is no number makes every flight end nowhere."""
    scene = smooth_scene(gravity=Gravity(math.nan))
    with pytest.raises(NotConverged, match="not finite"):
        run_event(scene, shots((0.0, (0.0, 0.0, 0.1), DOWN)), LAW, PLANE)


def test_time_that_stands_still_is_noticed():
    watch, world = event_driven._Watch(), empty_world(ONE_CELL, 0.0)
    world.clock["now"] = 0.5
    with pytest.raises(NotConverged, match="t = 0.5 s: shots bounce without end"):
        for _ in range(100):
            watch.look(world)


def test_no_spot_is_forgotten_when_their_store_grows(monkeypatch):
    """Each of 40 shots on one spot counts all before it, though there was room for 4 at first."""
    monkeypatch.setattr(event_driven, "ROWS", 4)
    law = RestitutionLaw(0.5, hardening=SpotHardening(0.8, 30.0), spot_radius_m=0.2e-3)
    rows = [(0.01 * k, (0.0, 0.0, 0.1), DOWN) for k in range(40)]
    impacts, _ = run_event(smooth_scene(), shots(*rows), law, PLANE)
    np.testing.assert_allclose(
        impacts["vz_out_m_s"] / 60.0, [law.at_spot(0.5, k) for k in range(40)], rtol=1e-12
    )


def test_time_spent_compiling_is_not_extrapolated(monkeypatch):
    """100 s in the first piece, which did a tenth; then a fifth in 2 s: 7 s for the rest."""
    ticks = iter([0.0, 100.0, 102.0])
    monkeypatch.setattr(event_driven, "time", SimpleNamespace(monotonic=lambda: next(ticks)))
    world, told = empty_world(ONE_CELL, 0.0), []
    tell = event_driven._teller(
        lambda share, text: told.append(text), SimpleNamespace(start_s=0.0, fed_s=1.0), world
    )
    for now in (0.1, 0.3):
        world.clock["now"] = now
        tell(world)
    assert told[-1] == "7 s left, 0 shots in flight"
