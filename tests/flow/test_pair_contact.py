"""The turned normal: limits known in closed form, Hertz's contact integrated in time, and collisions that YADE gave."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from glue import solvers
from glue.flow.pair_contact import parting, turned_normal

CHECK = Path(__file__).parents[2] / "yade_scripts" / "checks" / "pairs.py"

REACH, MASS, RADIUS, MODULUS = 1e-3, 0.5 * 7800.0 * math.pi / 6.0 * 1e-9, 0.25e-3, 210e9 / 1.82
PAIR = (REACH, MASS, RADIUS, MODULUS)


def struck(b, speed):
    """(n, u) under the impact parameter ``b``, seen with the second shot at rest."""
    return (b, 0.0, math.sqrt(1.0 - b * b)), (0.0, 0.0, -speed)


def after(b, speed, e):
    """Relative velocity after, without friction."""
    n, u = (np.array(v) for v in struck(b, speed))
    *turned, approach = turned_normal(n, u, e, *PAIR)
    out = u + (1.0 + e) * approach * np.array(turned)
    return out + parting(n, out)


def contact(b, speed, e):
    """The same by integrating the motion under Hertz's force and the dashpot of Antypov and Elliott (2011)."""
    n, u = (np.array(v) for v in struck(b, speed))
    k = 4.0 / 3.0 * MODULUS * math.sqrt(RADIUS)
    loss = -math.log(e)
    a = math.sqrt(5.0) * loss / math.sqrt(loss * loss + math.pi**2) * math.sqrt(MASS * k)

    def rate(_, y):
        apart = np.linalg.norm(y[:3])
        depth = max(REACH - apart, 0.0)
        along = y[:3] / apart
        force = k * depth**1.5 - a * depth**0.25 * (y[3:] @ along)
        return [*y[3:], *(force / MASS * along)]

    def ended(t, y):
        return np.linalg.norm(y[:3]) - REACH if t > 1e-9 else -1.0

    ended.terminal, ended.direction = True, 1.0
    start = [*(REACH * n + 1e-10 * u), *u]
    return solve_ivp(rate, (0.0, 1.0), start, events=ended, rtol=1e-10, atol=1e-12, max_step=1e-7).y[3:, -1]


@pytest.mark.parametrize("e", [0.3, 0.6, 0.8, 1.0])
@pytest.mark.parametrize("b", [0.2, 0.5, 0.8, 0.95])
def test_the_turned_impulse_is_that_of_the_contact_in_time(b, e):
    """Within .5 % of the closing speed at 60 m/s, half of that at 5 m/s; at e = .3 within 1.5 %."""
    for speed, limit in ((60.0, 0.005 if e > 0.3 else 0.015), (5.0, 0.0025)):
        assert np.linalg.norm(after(b, speed, e) - contact(b, speed, e)) < limit * speed


def test_without_the_turn_it_would_not_be():
    n, u = (np.array(v) for v in struck(0.8, 60.0))
    rigid = u - 2.0 * (u @ n) * n
    assert np.linalg.norm(rigid - contact(0.8, 60.0, 1.0)) > 0.05 * 60.0


def test_central_and_rigid_shots_do_not_turn():
    n, u = struck(0.0, 60.0)
    assert turned_normal(n, u, 0.8, *PAIR) == (*n, 60.0)
    n, u = struck(0.7, 60.0)
    assert turned_normal(n, u, 0.8, REACH, MASS, RADIUS, math.inf) == (*n, 60.0 * n[2])


def test_half_of_hertz_contact_at_low_speed():
    """Slow, elastic: the normal turns by g_t / d times half of 2.9432 depth / g_n."""
    n, u = struck(0.3, 0.01)
    gn, gt = 0.01 * math.sqrt(1.0 - 0.09), 0.003
    depth = (15.0 * MASS * gn**2 / (16.0 * math.sqrt(RADIUS) * MODULUS)) ** 0.4
    cosine = np.dot(n, turned_normal(n, u, 1.0, *PAIR)[:3])
    assert math.acos(cosine) == pytest.approx(0.5 * 2.9432 * depth / gn * gt / REACH, rel=2e-3)


def test_whatever_the_collision_the_pair_parts_and_keeps_its_speed():
    rng = np.random.default_rng(8)
    grazing = 0
    for _ in range(2000):
        b, speed = 1.0 - 10.0 ** rng.uniform(-6.0, -0.1), 10.0 ** rng.uniform(-1.0, 2.5)
        n, u = (np.array(v) for v in struck(b, speed))
        *turned, approach = turned_normal(n, u, 1.0, *PAIR)
        turned = np.array(turned)
        assert approach == pytest.approx(-u @ turned, rel=1e-9, abs=1e-9 * speed)  # without losses one line
        assert np.linalg.norm(turned) == pytest.approx(1.0, rel=1e-12)
        assert n @ turned > 0.9 and u @ turned < 0.0  # still towards one another
        out = u - 2.0 * (u @ turned) * turned
        extra = np.array(parting(n, out))
        grazing += extra.any()
        assert (out + extra) @ n >= 0.0
        assert np.linalg.norm(out + extra) == pytest.approx(speed, rel=1e-12)
    assert 20 < grazing < 1500


# Relative velocity (x, z) [m/s] after, from YADE at .3 P: two shots of 1 mm steel, e .8, mu 0; by speed and b.
YADE = [
    (60.0, 0.3, 31.878, 37.518),
    (60.0, 0.5, 47.688, 19.085),
    (60.0, 0.7, 53.765, -8.073),
    (60.0, 0.9, 39.264, -42.784),
    (20.0, 0.5, 15.717, 6.739),
    (20.0, 0.9, 13.700, -13.631),
]


@pytest.mark.parametrize(("speed", "b", "x", "z"), YADE)
def test_collisions_in_yade(speed, b, x, z):
    """3 % of the closing speed, the limit of the check's rms."""
    assert np.linalg.norm(after(b, speed, 0.8) - (x, 0.0, z)) < 0.03 * speed


@pytest.mark.solver
def test_all_collisions_of_the_check_in_yade(tmp_path):
    rows = tmp_path / "rows.json"
    solvers.run_yade(CHECK, ["--json", str(rows)], cwd=tmp_path, log=tmp_path / "log", outputs=(rows,))
