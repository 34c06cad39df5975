"""Dropping: what is dropped never enters a jet again, and what could still meet one stays."""

import dataclasses
import math

import numpy as np
import pytest

from glue.flow import jets
from glue.scene import model

MARGIN = jets.JET_MARGIN


def fate(p, v, rows):
    """On a plane target, with an infinitely small shot."""
    return jets.fate(*p, *v, v[2] >= 0.0, rows)


def of(make_scene, *nozzles, **changes):
    scene = make_scene(**changes)
    return dataclasses.replace(
        scene, nozzles=tuple(dataclasses.replace(scene.nozzle, **n) for n in nozzles or [{}])
    )


def in_jet(points, nozzle):
    """Whether each of the points (n, 3) lies in the undisturbed jet, by the geometry of its cone."""
    d = np.array(nozzle.direction)
    q = points - (np.array([*nozzle.aim_m, 0.0]) - nozzle.stand_off_m * d)
    s = q @ d
    off = np.linalg.norm(q - s[:, None] * d, axis=1)
    wide = 0.5 * nozzle.jet_diameter_m + s * math.tan(math.radians(nozzle.divergence_half_angle_deg))
    return (s >= 0.0) & (off <= wide) & (points[:, 2] >= 0.0)


def test_the_simple_cases(make_scene):
    rows = jets.jet_rows(of(make_scene), 0.0)
    up, down = (1.0, 0.0, 30.0), (1.0, 0.0, -30.0)
    beside = 0.010 * (1.0 + MARGIN) + 1.1e-3
    assert fate((0.0, 0.0, 0.05), up, rows) == jets.KEEP
    assert fate((0.0, 0.0, 0.101), up, rows) == jets.EXIT
    assert fate((beside, 0.0, 0.05), up, rows) == jets.BESIDE
    assert fate((-beside, 0.0, 0.05), up, rows) == jets.KEEP  # comes back across the axis
    assert fate((beside, 0.0, 0.05), down, rows) == jets.KEEP
    assert fate((1.02, 0.0, 0.05), down, rows) == jets.FAR
    assert fate((-1.02, 0.0, 0.05), down, rows) == jets.KEEP


def test_a_wide_jet_catches_up_with_what_rises_beside_it(make_scene):
    """The cone narrows upwards: sinking shots may enter it from the side, rising ones leave it."""
    rows = jets.jet_rows(of(make_scene, dict(divergence_half_angle_deg=30.0)), 0.0)
    out = 0.5 * 0.02 + 0.09 * math.tan(math.radians(30.0))
    assert fate((1.6 * out + 1e-3, 0.0, 0.01), (10.0, 0.0, 1.0), rows) == jets.BESIDE
    assert jets.fate(1.6 * out + 1e-3, 0.0, 0.01, 1.0, 0.0, -10.0, True, rows) == jets.KEEP


@pytest.mark.parametrize("seed", range(4))
def test_dropped_shots_never_meet_a_jet_again(make_scene, seed):
    rng = np.random.default_rng(seed)
    scene = of(
        make_scene,
        dict(divergence_half_angle_deg=8.0),
        dict(impact_angle_deg=50.0, azimuth_deg=130.0, aim_m=(0.02, -0.01), stand_off_m=0.06),
        dict(impact_angle_deg=70.0, azimuth_deg=-40.0, divergence_half_angle_deg=2.0, jet_diameter_m=0.008),
    )
    rows = jets.jet_rows(scene, 0.0)
    counts = dict.fromkeys(jets.REASONS, 0)
    for _ in range(2000):
        p = rng.uniform([-0.1, -0.1, 0.0], [0.1, 0.1, 0.15])
        v = rng.normal(size=3) * 30.0
        what = fate(p, v, rows)
        counts[jets.REASONS[what]] += 1
        if what == jets.KEEP:
            continue
        way = p + np.linspace(0.0, 1.0, 400)[1:, None] ** 2 * 0.02 * v
        assert not any(in_jet(way, nozzle).any() for nozzle in scene.nozzles), (what, p, v)
    assert min(counts[k] for k in ("exit", "beside", "")) > 100  # every case was tried


def test_rows_follow_the_feed(make_scene):
    feed = model.Feed(speed_m_s=0.02, stroke_m=0.04, passes=2, pitch_m=0.01, dwell_s=0.5)
    scene = of(make_scene, dict(feed=feed))
    assert jets.jet_rows(scene, 0.0)[0][:3] == pytest.approx((-0.02, -0.005, 0.1))
    assert jets.jet_rows(scene, 2.2)[0][:3] == pytest.approx((0.02, -0.005, 0.1))
    assert jets.jet_rows(scene, 4.5)[0][:3] == pytest.approx((-0.02, 0.005, 0.1))


def test_past_a_curved_target(make_scene):
    """A shot that flies past a shaft never leaves the cone: it is dropped when it is below the body."""
    rows = jets.jet_rows(of(make_scene), 0.0, body_m=0.01)
    assert jets.fate(0.008, 0.0, -0.009, 0.0, 0.0, -60.0, True, rows) == jets.KEEP
    assert jets.fate(0.008, 0.0, -0.011, 0.0, 0.0, -60.0, True, rows) == jets.PAST
    assert jets.fate(0.008, 0.0, -0.011, 0.0, 0.0, -60.0, False, rows) == jets.KEEP
    endless = jets.jet_rows(of(make_scene), 0.0)
    assert jets.fate(0.008, 0.0, -9.0, 0.0, 0.0, -60.0, True, endless) == jets.KEEP


def test_the_margin_is_outside_every_shot_of_the_jet(make_scene):
    """Without margin, a large shot half outside a thin jet can still be met by another at its edge."""
    scene = of(make_scene, dict(jet_diameter_m=0.002), diameter_m=2e-3)
    rows = jets.jet_rows(scene, 0.0, margin=0.0)
    # centres of two touching shots are 2 mm apart; the jet's outermost centre is 1 mm from the axis
    assert fate((2.9e-3, 0.0, 0.05), (1.0, 0.0, 1.0), rows) == jets.KEEP
    assert fate((3.1e-3, 0.0, 0.05), (1.0, 0.0, 1.0), rows) == jets.BESIDE
