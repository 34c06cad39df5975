"""The foreseen moment of contact against brute force; pure Python, YADE is not needed."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "yade_scripts"))

import forecast  # noqa: E402
from flight import Fleet, Flying  # noqa: E402


def shot(pos, vel, radius=0.5, t=0.0, number=0):
    return Flying((number, t, *map(float, pos), *map(float, vel), 2.0 * radius, 7800.0, 0, 0, 0))


def fleet_of(*shots):
    fleet = Fleet()
    for s in shots:
        fleet.add(s)
    return fleet


def touch_time_s(a, b, now):
    """When ``a`` and ``b``, alone in the world, touch."""
    found = fleet_of(a, b).touches(a, now)
    return found[0][0] if found else math.inf


def test_head_on_and_miss():
    a, b = shot((0, 0, 0), (1, 0, 0)), shot((5, 0, 0), (-3, 0, 0))
    assert touch_time_s(a, b, 0.0) == 1.0  # gap 4 at closing speed 4
    assert touch_time_s(a, b, 0.5) == 1.0
    assert touch_time_s(a, shot((5, 1.001, 0), (-3, 0, 0)), 0.0) == math.inf
    assert touch_time_s(a, shot((5, 0, 0), (2, 0, 0)), 0.0) == math.inf  # flies ahead, faster
    assert touch_time_s(a, shot((0.9, 0, 0), (0, 0, 0)), 0.0) == 0.0  # overlap, closing


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
        got = touch_time_s(a, b, now)
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
    a, b, c = shot((0, 0, 9), (1, 0, 0)), shot((5, 0, 9), (-3, 0, 0)), shot((50, 0, 9.5), (0, 0, -1))
    fleet = fleet_of(a, b)
    seen = forecast.Forecast(fleet)
    for s in (a, b):
        seen.renew(s, 0.0)
    assert seen.next() == 1.0
    seen.renew(c, 0.0)  # lands at 9
    b.flight += 1  # dropped
    assert seen.next() == 9.0 and seen.take() == (9.0, (c,))
    assert seen.next() == math.inf


def test_a_shot_in_contact_is_not_foreseen():
    a, b = shot((0, 0, 9), (1, 0, 0)), shot((5, 0, 9), (-3, 0, 0))
    fleet = fleet_of(a, b)
    fleet.hold(b)
    seen = forecast.Forecast(fleet)
    seen.renew(a, 0.0)
    assert seen.next() == math.inf
    fleet.renew(b)
    seen.renew(b, 0.5)
    assert seen.next() == 1.0 and seen.take() == (1.0, (b, a))


def test_a_checkpoint_brings_back_what_was_foreseen():
    rng = np.random.default_rng(5)
    shots = [shot(rng.uniform(1, 20, 3), rng.normal(size=3), 0.4, number=n) for n in range(40)]
    seen = forecast.Forecast(fleet_of(*shots))
    for s in shots:
        seen.renew(s, 0.0)
    shots[3].flight += 1
    again = forecast.Forecast(seen.fleet)
    again.restore(seen.state(), {s.shot_id: s for s in shots})
    order = []
    while (t := seen.next()) < math.inf:
        assert again.next() == t
        pair = seen.take()
        assert again.take() == pair and shots[3] not in pair[1]
        order.append(t)
    assert again.next() == math.inf and len(order) > 15 and order == sorted(order)


def test_fleet_keeps_its_slots_together():
    """Shots come and go by the hundred; every question is answered as by a loop over those that are there."""
    rng = np.random.default_rng(8)
    fleet, here = Fleet(), []
    for n in range(600):
        if here and rng.random() < 0.4:
            gone = here.pop(int(rng.integers(len(here))))
            fleet.remove(gone)
        s = shot(rng.uniform(-9, 9, 3), rng.normal(size=3), rng.uniform(0.1, 0.5), rng.normal(), n)
        fleet.add(s)
        here.append(s)
    assert set(fleet.shots) == set(here) and len(here) > 200
    for s in here:
        assert fleet.shots[s.slot] is s and tuple(fleet.at(1.7)[:, s.slot]) == s.at(1.7)
    place = (1.0, 2.0, 3.0)
    near = {s for s in here if math.dist(s.at(1.7), place) < s.radius + 2.0 + 0.5 * math.hypot(*s.vel)}
    assert set(fleet.near(place, 2.0, 0.5, 1.7)) == near and 3 < len(near) < 100


@pytest.mark.parametrize("offset, hits", [(0.999999, True), (1.000001, False)])
def test_grazes_are_told_apart(offset, hits):
    a, b = shot((0, 0, 0), (0, 0, 0)), shot((10, offset, 0), (-1, 0, 0))
    assert (touch_time_s(a, b, 0.0) < math.inf) == hits
