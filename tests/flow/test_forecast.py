"""The foreseen moment of contact against brute force; pure Python, YADE is not needed."""

import importlib.util
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

_path = Path(__file__).parents[2] / "yade_scripts" / "forecast.py"
_spec = importlib.util.spec_from_file_location("forecast", _path)
forecast = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(forecast)


def shot(pos, vel, radius=0.5, t=0.0):
    s = SimpleNamespace(t=t, pos=tuple(pos), vel=tuple(vel), radius=radius, flight=0, open=0)
    s.at = lambda now: tuple(p + v * (now - s.t) for p, v in zip(s.pos, s.vel))
    return s


def test_head_on_and_miss():
    a, b = shot((0, 0, 0), (1, 0, 0)), shot((5, 0, 0), (-3, 0, 0))
    assert forecast.touch_time_s(a, b, 0.0) == 1.0  # gap 4 at closing speed 4
    assert forecast.touch_time_s(a, b, 0.5) == 1.0
    assert forecast.touch_time_s(a, shot((5, 1.001, 0), (-3, 0, 0)), 0.0) == math.inf
    assert forecast.touch_time_s(a, shot((5, 0, 0), (2, 0, 0)), 0.0) == math.inf  # flies ahead, faster
    assert forecast.touch_time_s(a, shot((0.9, 0, 0), (0, 0, 0)), 0.0) == 0.0  # overlap, closing


def test_landing():
    assert forecast.landing_time_s(shot((0, 0, 2.5), (7, 0, -4), t=1.0), 1.0) == 1.5
    assert forecast.landing_time_s(shot((0, 0, 2.5), (7, 0, 4)), 0.0) == math.inf


def test_touch_time_against_sampled_distances():
    rng = np.random.default_rng(11)
    met = 0
    for _ in range(400):
        # roughly aimed at each other, so that about half of the pairs meet
        p, q = rng.uniform(-5, 5, (2, 3))
        a = shot(p, 0.3 * (q - p) + 0.2 * rng.normal(size=3), rng.uniform(0.2, 1))
        b = shot(q, 0.2 * (p - q) + 0.2 * rng.normal(size=3), rng.uniform(0.2, 1), t=-0.7)
        now, times = 0.3, np.linspace(0.3, 12.3, 24001)
        track = (np.array(a.at(now)) - b.at(now)) + np.outer(times - now, np.array(a.vel) - b.vel)
        gap = np.linalg.norm(track, axis=1) - a.radius - b.radius
        if gap[0] <= 0:
            continue
        expected = times[np.argmax(gap <= 0)] if (gap <= 0).any() else math.inf
        got = forecast.touch_time_s(a, b, now)
        if got < 12.3 and math.isinf(expected):
            assert gap.min() < 1e-6, "foreseen, but never closer than this: a graze between samples"
            continue
        if math.isinf(expected):
            assert got > 12.3
        else:
            met += 1
            assert expected - 0.0005 - 1e-9 <= got <= expected
    assert 100 < met < 390


def test_changed_flight_voids_what_was_foreseen():
    a, b, c = shot((0, 0, 9), (1, 0, 0)), shot((5, 0, 9), (-3, 0, 0)), shot((0, 0, 9.5), (0, 0, -1))
    seen = forecast.Forecast()
    for s in (a, b):
        seen.renew(s, [a, b], 0.0)
    assert seen.next(0.0) == 1.0
    seen.renew(c, [], 0.0)  # lands at 9
    b.flight += 1  # dropped
    assert seen.next(0.0) == 9.0
    assert seen.next(9.1) == math.inf


def test_a_shot_in_contact_is_not_foreseen():
    a, b = shot((0, 0, 9), (1, 0, 0)), shot((5, 0, 9), (-3, 0, 0))
    b.open = 1
    seen = forecast.Forecast()
    seen.renew(a, [a, b], 0.0)
    assert seen.next(0.0) == math.inf


@pytest.mark.parametrize("offset, hits", [(0.999999, True), (1.000001, False)])
def test_grazes_are_told_apart(offset, hits):
    a, b = shot((0, 0, 0), (0, 0, 0)), shot((10, offset, 0), (-1, 0, 0))
    assert (forecast.touch_time_s(a, b, 0.0) < math.inf) == hits
