"""Several media and nozzles, feed, drag and gravity in the stream that YADE flies."""

import math

import numpy as np
import pytest
from shot_cases import S390, nozzle, shot_flow

pytestmark = pytest.mark.solver

E = ("--restitution", "0.6")
MIXED = """
[[shots]]
grade = "S390"
mass_fraction = 0.6
[[shots]]
diameter_m = 0.0005
density_kg_m3 = 2500.0
E_Pa = 70e9
nu = 0.22
size = "distribution"
size_cv = 0.08
mass_fraction = 0.4
"""


def uncollided(run):
    """(their first impacts, their arrivals) of the shots that met no other before."""
    rows = run.impacts
    rows = rows[np.unique(rows["shot_id"], return_index=True)[1]]
    rows = rows[rows["collisions_before"] == 0]
    arrivals = run.arrivals
    return rows, arrivals[np.searchsorted(arrivals["shot_id"], rows["shot_id"])]


@pytest.fixture(scope="module")
def mixed(tmp_path_factory):
    """Two nozzles from two sides, one fed along and spread, both with two media."""
    spread = "divergence_half_angle_deg = 4.0\nspeed_cv = 0.05\n"
    feed = "azimuth_deg = 180.0\nfeed_speed_m_s = 1.9\n"
    nozzles = nozzle(several=True, flow=0.032, angle=60.0, stand_off=0.06, more=spread)
    nozzles += nozzle(several=True, flow=0.032, angle=70.0, stand_off=0.05, speed=50.0, more=feed)
    return shot_flow(tmp_path_factory.mktemp("mixed"), *E, shots=MIXED, nozzles=nozzles, exposure=0.016)


def test_two_nozzles_and_media_fly_and_strike_as_they_left(mixed):
    assert not mixed.failed, mixed.log
    rows, came = uncollided(mixed)
    for label in ("nozzle_id", "pass_id", "medium", "diameter_m", "density_kg_m3"):
        assert (rows[label] == came[label]).all()
    assert all((rows[f"v{c}_in_m_s"] == came[f"v{c}_m_s"]).all() for c in "xyz")
    fall = (came["z_m"] - 0.5 * came["diameter_m"]) / -came["vz_m_s"]
    for c in "xy":
        assert np.abs(rows[f"{c}_m"] - came[f"{c}_m"] - came[f"v{c}_m_s"] * fall).max() < 1e-12
    for n in 0, 1:
        for m in 0, 1:
            assert ((rows["nozzle_id"] == n) & (rows["medium"] == m)).sum() >= 5


def test_every_medium_rebounds_as_it_should(mixed):
    """One step for steel of 1 mm and glass of .4: restitution is set contact by contact, and holds for both."""
    assert mixed.report["restitution_by"] == "contact"
    rows, _ = uncollided(mixed)
    steel = np.hypot(np.hypot(rows["vx_in_m_s"], rows["vy_in_m_s"]), rows["vz_in_m_s"])
    assert steel.max() < 60.0 * 1.13 and steel.std() > 3.0
    for m in 0, 1:
        e = (-rows["vz_out_m_s"] / rows["vz_in_m_s"])[rows["medium"] == m]
        # .6 % is the scatter of one rebound over sub-step phases at this many steps per contact
        assert e.mean() == pytest.approx(0.6, abs=0.6 * 0.006 * 3.0 / math.sqrt(len(e)) + 1e-3)


def test_mass_and_shots_are_accounted_for(mixed):
    report, arrivals = mixed.report, mixed.arrivals
    mass = (math.pi / 6.0 * arrivals["density_kg_m3"] * arrivals["diameter_m"] ** 3).sum()
    assert report["mass_fed_kg"] == pytest.approx(mass, rel=1e-12)
    assert report["arrived"] == len(arrivals) == sum(report["dropped"].values()) + report["in_flight"]
    assert report["shot_shot_collisions"] > 50 and all(row["passed"] for row in report["checks"])
    # a light shot struck by a heavy one may be faster than any that left a nozzle, within what energy allows
    limit = next(row["limit"] for row in report["checks"] if row["name"].startswith("largest speed"))
    assert 68.0 < report["top_speed_m_s"] < limit and limit > 3.0 * 67.5


def test_drag_slows_them_as_the_equation_of_motion_says(tmp_path):
    """Glass of .3 mm over 150 mm in air: the logged speed against Runge-Kutta on Schiller and Naumann's law."""
    bead = "[shots]\ndiameter_m = 0.0003\ndensity_kg_m3 = 2500.0\nE_Pa = 70e9\nnu = 0.22\n"
    air = "[air_drag]\ngas_density_kg_m3 = 1.2\ngas_viscosity_Pa_s = 1.8e-5\n"
    run = shot_flow(tmp_path, *E, shots=bead, more=air, stand_off=0.15, flow=2e-4, exposure=0.03)
    assert not run.failed, run.log
    rows, came = uncollided(run)

    def slowing(v):
        re = 1.2 * v * 3e-4 / 1.8e-5
        drag = 24.0 / re * (1.0 + 0.15 * re**0.687) if re < 1000.0 else 0.44
        return -0.75 * drag * 1.2 * v * v / (2500.0 * 3e-4)

    v, z, t, dt = 60.0, 0.15, 0.0, 1e-7
    while z > 1.5e-4:
        middle = v + 0.5 * dt * slowing(v)
        z, v, t = z - dt * middle, v + dt * slowing(middle), t + dt
    assert v < 57.0, "it must matter here"
    assert -rows["vz_in_m_s"] == pytest.approx(v, rel=1e-3)
    assert rows["time_s"] - came["time_s"] == pytest.approx(t, rel=2e-4)
    assert len(rows) > 50 and run.report["kick_interval_s"] < 1e-3


def test_gravity_bends_their_way(tmp_path):
    """A hundred times that of the Earth, across the flight: free fall sideways."""
    pull = "[gravity]\nacceleration_m_s2 = 1000.0\ndirection = [1.0, 0.0, 0.0]\n"
    run = shot_flow(tmp_path, *E, shots=S390, more=pull, flow=0.004)
    assert not run.failed, run.log
    rows, came = uncollided(run)
    t = (came["z_m"] - 0.5 * came["diameter_m"]) / 60.0
    assert rows["time_s"] - came["time_s"] == pytest.approx(t, rel=1e-12)
    assert rows["x_m"] - came["x_m"] == pytest.approx(0.5 * 1000.0 * t**2, rel=2e-3)
    assert rows["vx_in_m_s"] == pytest.approx(1000.0 * t, abs=0.06)  # half a kick: .1 % of 60 m/s
