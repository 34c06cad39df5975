"""Expected hits and coverage of still and moving jets, mixed media and curved targets, against closed forms."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from glue.scene.model import Feed, Pulse, Surface
from glue.scene.reader import example_path, read_scene
from glue.study.exposure import Hits, dimple_areas_m2, expected_hits, number_shares
from glue.surface.coverage import dimple_semi_axes
from glue.theory import avrami

AREA = math.pi * 0.2e-3**2


@pytest.fixture(scope="module")
def scene():
    return read_scene(example_path("al2024-s390"))


def changed(scene, nozzle=None, target=None, **changes):
    if nozzle:
        changes["nozzles"] = (dataclasses.replace(scene.nozzle, **nozzle),)
    if target:
        changes["target"] = dataclasses.replace(scene.target, **target)
    return dataclasses.replace(scene, **changes)


def test_a_still_even_jet_is_the_mass_flow_form(scene):
    """(2.2) of the paper, in glue.theory.avrami: shots spread over the jet's circle."""
    hits = expected_hits(scene, np.array([[AREA]]))
    n, s = scene.nozzle, scene.shots
    arguments = (0.2e-3**2, n.mass_flow_kg_s, n.footprint_area_m2, (0.5 * s.diameter_m) ** 3, s.density_kg_m3)
    for t in (0.1, 1.0, 3.0):
        assert hits.coverage([t])[0] == pytest.approx(float(avrami.mass_flow_form(*arguments, t)), rel=1e-12)
    per_second = float(hits.hits[-1].mean()) / 3.0
    assert hits.time_to(0.98) == pytest.approx(-math.log(0.02) / per_second, rel=1e-12)
    # a still jet goes on beyond the exposure that was asked for
    level = -math.expm1(-2.0 * 3.0 * per_second)
    assert hits.time_to(level) == pytest.approx(6.0, rel=1e-9)


def test_a_traverse_brings_its_hits_as_it_passes(scene):
    """20 mm jet at 20 mm/s over 60 mm: the window's middle sees it from 1 s to 2 s, chord 20 mm at the middle line."""
    feed = Feed(0.02, 0.06)
    moving = changed(scene, nozzle={"feed": feed})
    hits = expected_hits(moving, np.array([[AREA]]))
    assert hits.at([0.85]).max() == 0.0  # the window's edge is met at 1 s - 2 mm / 20 mm/s, less rounding of the circle
    middle = len(hits.hits[-1]) // 2
    n = moving.nozzle
    rate = n.mass_flow_kg_s / moving.shots.mean_mass_kg / (math.pi * 0.01**2)
    assert hits.hits[-1][middle] == pytest.approx(AREA * rate * 0.02 / 0.02, rel=1e-6)
    assert hits.at([1.5])[0][middle] == pytest.approx(0.5 * hits.hits[-1][middle], rel=1e-3)
    assert not hits.goes_on and hits.at([9.0])[0][middle] == hits.hits[-1][middle]
    final = hits.coverage([3.0])[0]
    assert hits.time_to(final + 1e-6) is None and 1.0 < hits.time_to(0.9 * final) < 2.2


def test_a_pulsed_jet_rests_between_its_bursts(scene):
    """Half of each second on, at twice the flow: all of a second's hits come in its first half."""
    still = expected_hits(scene, np.array([[AREA]])).hits[-1][0] / 3.0
    hits = expected_hits(changed(scene, nozzle={"pulse": Pulse("pulsed", 1.0, duty=0.5)}), np.array([[AREA]]))
    times = [0.3, 0.5, 0.75, 1.0, 1.3, 3.0]
    assert hits.at(times)[:, 0] == pytest.approx(still * np.array([0.6, 1.0, 1.0, 1.0, 1.6, 3.0]), rel=0.02)


def test_coverage_of_an_uneven_window_is_the_mean_over_places():
    """Half the window hit twice on average, half never: not what the mean of one hit would cover."""
    half = Hits(np.array([0.0, 1.0]), np.array([[0.0] * 4, [2.0, 2.0, 0.0, 0.0]]), True)
    assert half.coverage([1.0])[0] == pytest.approx(0.5 * -math.expm1(-2.0))
    assert half.time_to(0.98) is None  # a bare half stays bare
    assert half.time_to(0.4) == pytest.approx(-math.log(0.2) / 2.0)
    assert half.scaled_to(3.0).hits[-1].mean() == pytest.approx(3.0)


def test_hits_without_any_expected_are_spread_evenly():
    """Impacts that only rebounds brought: the log has them, the jets do not aim there."""
    none = Hits(np.array([0.0, 2.0]), np.zeros((2, 4)), True).scaled_to(0.5)
    assert none.coverage([1.0])[0] == pytest.approx(-math.expm1(-0.25))


def test_two_media_share_by_number(scene):
    """Equal masses of 1 mm and 0.5 mm shots of one density: one to eight by number."""
    small = dataclasses.replace(scene.shots, diameter_m=0.5e-3, mass_fraction=0.5)
    mixed = changed(scene, media=(dataclasses.replace(scene.shots, mass_fraction=0.5), small))
    assert number_shares(mixed) == pytest.approx([1 / 9, 8 / 9])
    areas = np.array([[AREA, AREA / 4]])
    one = expected_hits(scene, np.array([[AREA]]))
    both = expected_hits(mixed, areas)
    assert both.hits[-1] == pytest.approx(one.hits[-1] * (0.5 + 0.5 * 8 / 4), rel=1e-12)


def test_a_cylinder_spreads_what_falls_on_its_flanks(scene):
    """Straight down: at the angle a round the cylinder the fluence is cos a of the plane's."""
    radius = 3e-3
    round_ = changed(scene, target={"surface": Surface("cylinder", radius, "y")})
    plane = expected_hits(scene, np.array([[AREA]])).hits[-1]
    found = expected_hits(round_, np.array([[AREA]])).hits[-1].reshape(9, 9)
    angle = 4e-3 * ((np.arange(9) + 0.5) / 9 - 0.5) / radius
    assert found == pytest.approx(plane[0] * np.cos(angle)[None, :].repeat(9, axis=0), rel=1e-12)


def test_areas_are_those_of_the_log_or_of_the_shot_as_it_left(scene):
    from types import SimpleNamespace

    from glue.flow.impacts import COLUMNS

    dimple = SimpleNamespace(
        radius_for=lambda d, v, rho: 0.2 * d * np.sqrt(v / 60.0) * (rho / 7800.0) ** 0.25,
        contact_time_s=2e-6, diameter_m=1e-3, density_kg_m3=7800.0,
    )  # fmt: skip
    two = changed(scene, media=(dataclasses.replace(scene.shots, mass_fraction=0.5),) * 2)
    log = np.zeros(3, COLUMNS)
    found = dimple_areas_m2(two, dimple, log, np.array([1.0, 2.0, 6.0]))
    rho = scene.shots.density_kg_m3
    assert found[0, 0] == 3.0
    assert found[0, 1] == pytest.approx(math.pi * (0.2 * 1e-3) ** 2 * math.sqrt(rho / 7800.0), rel=1e-9)
    oblique = changed(two, nozzles=(dataclasses.replace(scene.nozzle, impact_angle_deg=30.0),))
    log = np.zeros(1, COLUMNS)  # what such a shot leaves when it strikes
    log["diameter_m"], log["density_kg_m3"], log["nz"] = 1e-3, rho, 1.0
    log["vx_in_m_s"], log["vz_in_m_s"] = 60.0 * math.cos(math.radians(30.0)), -60.0 * math.sin(math.radians(30.0))
    major, minor, _ = dimple_semi_axes(dimple, log)
    assert major[0] > 1.05 * minor[0]
    assert dimple_areas_m2(oblique, dimple, log[:0], np.empty(0))[0, 0] == pytest.approx(math.pi * major[0] * minor[0], rel=1e-6)
