"""Many speeds at once, and the curves through what they give; ``solve_reduced`` is replaced by closed forms."""

from __future__ import annotations

import dataclasses
import math
import threading
import time

import numpy as np
import pytest
from helpers import reduced

from glue.errors import InputError, NotConverged
from glue.scene.catalogue import material
from glue.target import speeds
from glue.target.speeds import Curve, outside, solve_speeds, spaced

AL = material("al2024-t351")


def solve(monkeypatch, solver, wanted, **options):
    monkeypatch.setattr(speeds, "solve_reduced", solver)
    return solve_speeds(AL, wanted, density_kg_m3=7800.0, elements_per_radius=3, **options)


def restitutions(impacts):
    return [i.restitution for i in impacts]


def impact(e):
    return dataclasses.replace(reduced([0.0, 1.0], [-0.1, 0.0]), restitution=e)


def test_speeds_are_in_equal_ratios_and_round_numbers():
    assert spaced(1.0, 16.0, 5) == [1.0, 2.0, 4.0, 8.0, 16.0]
    assert spaced(1.0, 120.0, 12)[-1] == 120.0


@pytest.mark.parametrize("jobs", [1, 2, 7, None])
def test_results_come_in_the_order_of_the_speeds_whatever_the_order_of_ends(monkeypatch, jobs):
    def solver(material, law, *, speed_m_s, progress, **other):
        assert law is AL.single_law
        time.sleep(0.02 / speed_m_s)
        return impact(1.0 / speed_m_s)

    found = solve(monkeypatch, solver, [1.0, 2.0, 4.0, 8.0], jobs=jobs)
    assert restitutions(found) == [1.0, 0.5, 0.25, 0.125]


def test_progress_is_told_by_the_calling_thread_and_ends_complete(monkeypatch):
    told = []

    def solver(material, law, *, speed_m_s, progress, **other):
        progress(0.5)
        time.sleep(0.3)
        return impact(0.5)

    solve(monkeypatch, solver, [1.0, 2.0], jobs=2, progress=lambda share, text: told.append((share, text, threading.get_ident())))
    assert told[-1][:2] == (1.0, "2 of 2 speeds")
    shares = [t[0] for t in told]
    assert shares == sorted(shares) and 0.0 < shares[0] < 1.0
    assert {t[2] for t in told} == {threading.get_ident()}


def test_a_failure_stops_the_others_and_names_its_speed(monkeypatch):
    ended = []

    def solver(material, law, *, speed_m_s, progress, **other):
        if speed_m_s == 2.0:
            raise NotConverged("no")
        for _ in range(500):
            progress(0.1)
            time.sleep(0.01)
        ended.append(speed_m_s)

    with pytest.raises(NotConverged) as failure:
        solve(monkeypatch, solver, [1.0, 2.0, 4.0], jobs=2)
    assert failure.value.__notes__ == ["in the impact on al2024-t351 at 2 m/s"]
    assert ended == []


def test_ctrl_c_stops_all(monkeypatch):
    ended = []

    def solver(material, law, *, speed_m_s, progress, **other):
        for _ in range(500):
            progress(0.1)
            time.sleep(0.01)
        ended.append(speed_m_s)

    def interrupt(share, text):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        solve(monkeypatch, solver, [1.0, 2.0, 4.0], jobs=2, progress=interrupt)
    assert ended == []


def test_a_curve_is_exact_for_power_laws_and_never_leaves_its_table_silently():
    for n in (3, 12):
        v = np.geomspace(1.0, 100.0, n)
        curve = Curve("radius", v, 0.06 * v**0.47)
        between = np.array([1.0, 1.3, 47.0, 100.0])
        assert curve(between) == pytest.approx(0.06 * between**0.47, rel=1e-12)
        assert curve.error < 1e-12 and curve.exponent() == pytest.approx(0.47, rel=1e-12)
        for beyond in (0.99, 101.0, [5.0, 200.0], math.nan):
            with pytest.raises(InputError, match="does not extrapolate; allowed 1 to 100 m/s"):
                curve(beyond)
        assert curve.with_tails([0.01, 1000.0]) == pytest.approx([0.06 * 0.01**0.47, 0.06 * 1000**0.47], rel=1e-12)
        assert curve.with_tails([-1.0, 0.0]).tolist() == [0.0, 0.0]


def test_a_curve_is_monotone_and_tells_its_error():
    v = np.geomspace(1.0, 120.0, 12)
    bent = np.exp(-0.1 * np.log(v) - 0.015 * np.log(v) ** 2)
    curve = Curve("restitution", v, bent)
    fine = np.geomspace(1.0, 120.0, 500)
    assert (np.diff(curve(fine)) < 0.0).all()
    truth = np.exp(-0.1 * np.log(fine) - 0.015 * np.log(fine) ** 2)
    assert np.abs(curve(fine) / truth - 1.0).max() < max(curve.error, 1e-3)
    scatter = 0.01 * (-1.0) ** np.arange(12)
    noisy = Curve("restitution", v, bent * (1.0 + scatter))
    assert np.abs(noisy(fine) / truth - 1.0).max() < 0.01 < noisy.error < 0.03
    assert (np.diff(noisy(fine)) < 0.0).all()


def test_few_points_are_met():
    curve = Curve("radius", [1.0, 2.0, 5.0, 9.0], [1.0, 1.5, 1.6, 4.0])
    assert curve([1.0, 2.0, 5.0, 9.0]) == pytest.approx([1.0, 1.5, 1.6, 4.0], rel=1e-12)
    assert outside([0.5, 1.0, 9.0, 9.1], curve.speed_m_s).tolist() == [True, False, False, True]


@pytest.mark.parametrize(("v", "y"), [([1.0], [1.0]), ([1.0, 1.0], [1.0, 2.0]), ([1.0, 2.0], [0.0, 1.0])])
def test_what_makes_no_curve_is_refused(v, y):
    with pytest.raises(InputError, match="two and more rising speeds"):
        Curve("radius", v, y)
