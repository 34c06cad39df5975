"""The impulse across a contact: limits known in closed form, and impacts that YADE gave."""

import math
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from glue.flow.tangential import change_on_target, impulse_across, slip_on_target

CHECK = Path(__file__).parents[2] / "yade_scripts" / "checks" / "tangential.py"


def strike(v, w, n, radius, e, mu):
    """Velocity and spin (3,), (3,) after the impact."""
    gn, tx, ty, tz, gt = slip_on_target(*v, *w, *n, radius)
    change = change_on_target(gn, tx, ty, tz, gt, *n, radius, e, impulse_across(gn, gt, e, mu))
    return np.array(v) + change[:3], np.array(w) + change[3:]


@pytest.mark.parametrize("e", [0.1, 0.6, 1.0])
def test_far_beyond_the_limit_it_is_coulombs(e):
    for gt in (30.0, 300.0):
        assert impulse_across(2.0, gt, e, 0.2) == pytest.approx(0.2 * (1.0 + e) * 2.0)
    assert impulse_across(2.0, 30.0, e, 0.0) == 0.0


def test_a_rough_contact_answers_with_the_slip_and_never_beyond_reversing_it():
    """Impulse over g_t between 0 and that of a perfectly elastic, perfectly rough sphere (4/7)."""
    for e in np.linspace(0.05, 1.0, 20):
        for gt in np.geomspace(1e-6, 100.0, 60):
            across = impulse_across(40.0, gt, e, 0.3)
            assert 0.0 < across < 4.0 / 7.0 * gt
            assert across <= 0.3 * (1.0 + e) * 40.0


def test_the_impulse_is_continuous_in_slip_and_restitution():
    gts, es = np.geomspace(0.1, 400.0, 4000), np.linspace(0.1, 1.0, 400)
    of_slip = np.array([impulse_across(40.0, g, 0.5, 0.3) for g in gts])
    of_e = np.array([impulse_across(40.0, 15.0, e, 0.3) for e in es])
    for values in (of_slip, of_e):
        assert np.abs(np.diff(values)).max() < 0.01 * values.max()


# Sideways velocity [m/s] after, from YADE at .3 P, 1 mm steel on aluminium: e, mu, angle, spin share, after.
# Of the sides of the friction cone both, and with spin; limit 3 % of the slip, as in the check.
YADE = [
    (0.6, 0.1, 25.0, 0.0, 50.3227),
    (0.3, 0.2, 45.0, -0.5, 31.8620),
    (0.45, 0.5, 35.0, 0.0, 29.3261),
    (0.6, 0.3, 45.0, 0.0, 25.3970),
    (0.6, 0.3, 75.0, 0.0, 10.0723),
    (0.75, 0.1, 75.0, 0.0, 9.1213),
    (0.9, 0.3, 65.0, 0.5, 22.9442),
]


@pytest.mark.parametrize(("e", "mu", "angle", "spin", "after"), YADE)
def test_impacts_in_yade(e, mu, angle, spin, after):
    across, down = 60.0 * math.cos(math.radians(angle)), 60.0 * math.sin(math.radians(angle))
    v, _ = strike((across, 0.0, -down), (0.0, spin * across / 5e-4, 0.0), (0.0, 0.0, 1.0), 5e-4, e, mu)
    assert v[0] == pytest.approx(after, abs=0.03 * (1.0 - spin) * across)
    assert v[2] == pytest.approx(e * down)


def test_sphere_keeps_its_angular_momentum_about_the_touched_point():
    """The impulse acts there, so m r x v + I w about it cannot change; nor can energy rise."""
    rng = np.random.default_rng(4)
    for _ in range(300):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        v, w = rng.normal(size=3) * 30.0, rng.normal(size=3) * 4e4
        v -= (v @ n + rng.uniform(1.0, 60.0)) * n
        e, mu = rng.uniform(0.1, 1.0), rng.uniform(0.0, 0.6)
        after_v, after_w = strike(v, w, n, 5e-4, e, mu)
        about = [5e-4 * np.cross(n, a) + 0.4 * 5e-4**2 * b for a, b in ((v, w), (after_v, after_w))]
        assert about[1] == pytest.approx(about[0], rel=1e-10, abs=1e-15)
        assert after_v @ n == pytest.approx(-e * (v @ n))
        energy = [a @ a + 0.4 * (5e-4 * b) @ (5e-4 * b) for a, b in ((v, w), (after_v, after_w))]
        assert energy[1] <= energy[0] * (1.0 + 1e-12)


def test_a_rolling_sphere_has_no_slip():
    v, w = (10.0, 0.0, -5.0), (0.0, 10.0 / 5e-4, 0.0)
    assert slip_on_target(*v, *w, 0.0, 0.0, 1.0, 5e-4)[4] == pytest.approx(0.0, abs=1e-12)
    after_v, after_w = strike(v, w, (0.0, 0.0, 1.0), 5e-4, 0.6, 0.3)
    assert after_v == pytest.approx((10.0, 0.0, 3.0)) and after_w == pytest.approx(w)


@pytest.mark.solver
def test_the_whole_grid_in_yade(tmp_path):
    """The check: fitted table, impacts that were not fitted, spins, two shots; about five seconds."""
    done = subprocess.run(
        ["yade", "-n", "-x", "-j1", CHECK, "--json", tmp_path / "rows.json"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]
