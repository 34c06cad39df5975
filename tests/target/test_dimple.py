"""What is read off an impact's fields, and how a dimple scales."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from helpers import dimple, reduced

from glue.errors import InputError, NotConverged
from glue.scene.catalogue import material
from glue.target import dimple as module
from glue.target.dimple import Dimple, edge_peeq, layer_stress, zero_height_radius
from glue.target.physics import ImpactPhysics


YIELDED = {"peeq": np.array([0.1])}


def test_zero_height_radius_of_a_known_profile():
    """z = r^2 - 0.25 crosses zero at r = 0.5; nodes at distance h miss it by h^2/8 f''/f' at most."""
    r = np.linspace(0, 2, 201)
    assert zero_height_radius(reduced(r, r**2 - 0.25, YIELDED)) == pytest.approx(0.5, abs=0.01**2 / 4)


@pytest.mark.parametrize("surface", [[0.1, 0.1, 0.0], [-0.1, -0.1, -0.01]])
def test_a_surface_without_a_dimple_is_refused(surface):
    with pytest.raises(NotConverged, match="no dimple"):
        zero_height_radius(reduced([0, 1, 2], surface))


def test_an_elastic_impact_leaves_no_dimple():
    """A surface that did not come back to the last digit, but nothing yielded: solver noise."""
    r = np.linspace(0, 2, 201)
    with pytest.raises(NotConverged, match="no dimple"):
        zero_height_radius(reduced(r, 1e-7 * (r**2 - 0.25)))


def section(stress, n=40):
    """Gauss points on a grid of the section r in 0..4, depth 0..4, with ``stress(r, depth)``."""
    step = 4 / n
    r, depth = (
        g.ravel() for g in np.meshgrid(np.arange(n) * step + step / 2, np.arange(n) * step + step / 2)
    )
    zero = np.zeros(r.size)
    return {
        "r": r,
        "z": -depth,
        "u_r": zero,
        "u_z": zero,
        "volume": r,
        "s_rr": stress(r, depth),
        "peeq": depth,
    }


def test_layer_stress_is_the_mean_over_the_disc():
    """Stress r^2 + depth: over a disc of radius a the mean of r^2 is a^2/2."""
    depth, mean = layer_stress(reduced([0], [0], section(lambda r, d: r**2 + d)), disc_radius=0.5)
    middle = (depth > 0.2) & (depth < 3.5)
    # linear interpolation of r^2 between points .1 apart is high by at most .1^2/8 2, twice that near the axis
    assert mean[middle] == pytest.approx(0.125 + depth[middle], abs=0.005)


def test_edge_strain_is_taken_at_the_edge():
    values = section(lambda r, d: 0 * r)
    values["peeq"] = np.where(values["r"] < 1.5, 1.0, 0.25)
    assert edge_peeq(reduced([0], [0], values), 1.0) == 1.0
    assert edge_peeq(reduced([0], [0], values), 2.0) == 0.25


def test_radius_scales_with_diameter_and_speed():
    d = dimple(exponent=0.5)
    assert d.radius_for(2e-3, 60.0) == pytest.approx(2 * 227e-6)
    assert d.radius_for(1e-3, 15.0) == pytest.approx(0.5 * 227e-6)
    assert d.radius_for(np.array([1e-3, 1e-3]), np.array([-5.0, 0.0])).tolist() == [0.0, 0.0]
    # only density x speed^2 counts: a quarter of the density is half the speed
    assert d.radius_for(1e-3, 60.0, 7800.0 / 4) == pytest.approx(d.radius_for(1e-3, 30.0), rel=1e-12)
    assert d.radius_for(1e-3, 60.0, 7800.0) == d.radius_for(1e-3, 60.0)


def test_save_and_load_round_trip(tmp_path):
    dimple().save(tmp_path / "d.npz")
    back = Dimple.load(tmp_path / "d.npz")
    assert back.radius_m == 227e-6
    assert isinstance(back.dofs, int)
    assert back.points_m.shape == (3, 2)


@pytest.mark.parametrize("content", [None, b"not a zip"])
def test_a_dimple_file_that_is_not_one_is_named(tmp_path, content):
    path = tmp_path / "d.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match="dimple stage"):
        Dimple.load(path)


def solved(speeds, power=0.5, rebound=0.25, yields_above=0.0):
    """Reduced impacts by speed whose radius and restitution follow power laws."""
    r, found = np.linspace(0, 2, 2001), {}
    for v in speeds:
        radius = 0.5 * (v / 60.0) ** power
        impact = reduced(r, r**2 - radius**2, YIELDED if v > yields_above else {"peeq": np.zeros(1)})
        points = {**reduced([0], [0], section(lambda r, d: 0 * r, n=39)).points, **impact.points}
        points["peeq"] = np.full(points["r"].size, float(impact.points["peeq"].max()))
        impact = dataclasses.replace(impact, triangles=np.zeros((points["r"].size // 3, 3, 2)))
        found[v] = dataclasses.replace(impact, restitution=0.34 * (v / 60.0) ** -rebound, points=points)
    return found


RIGID = ImpactPhysics()


def tabulated(speeds, physics=RIGID, **laws):
    return module.tabulated(solved(speeds, **laws), material("al2024-t351"), 60.0, 7800.0, 1e-3, physics)


def test_exponents_are_those_of_the_step_below():
    """Half the speed: radius sqrt(1/2) as wide, rebound 2^(1/4) as high. Elastoplastic impact has these two powers."""
    found = tabulated((30.0, 60.0))
    assert found.speed_exponent == pytest.approx(0.5, abs=1e-4)
    assert found.restitution_exponent == pytest.approx(0.25, rel=1e-12)


def test_the_table_gives_the_radius_between_and_beyond_its_speeds():
    found = tabulated((3.75, 7.5, 15.0, 30.0, 60.0))
    for v in (1.0, 3.75, 11.0, 60.0, 70.0):
        assert found.radius_for(1e-3, v) == pytest.approx(0.25e-3 * (v / 60.0) ** 0.5, rel=1e-3)
    assert found.radius_for(1e-3, 60.0) == pytest.approx(found.radius_m, rel=1e-12)
    assert found.radius_for(2e-3, np.array([-1.0, 0.0])).tolist() == [0.0, 0.0]
    beyond = found.beyond_table(1e-3, np.array([1.0, 3.75, 20.0, 60.0, 61.0]))
    assert beyond.tolist() == [True, False, False, False, True]
    # four times as dense is twice as fast
    assert found.beyond_table(1e-3, 40.0, 4 * 7800.0) and not found.beyond_table(1e-3, 40.0)


def test_speeds_at_which_nothing_yields_are_left_out():
    found = tabulated((3.75, 15.0, 60.0), yields_above=5.0)
    assert found.table_speed_m_s.tolist() == [15.0, 60.0]
    with pytest.raises(NotConverged, match="no dimple"):
        tabulated((15.0, 60.0), yields_above=20.0)
    with pytest.raises(NotConverged, match="no dimple"):
        tabulated((15.0, 60.0), yields_above=100.0)


def test_physics_that_does_not_scale_is_not_scaled():
    rigid = tabulated((30.0, 60.0))
    assert rigid.radius_for(3e-3, 60.0, 2500.0) == pytest.approx(3 * rigid.radius_for(1e-3, 60.0 * (2500 / 7800) ** 0.5))
    for physics in (ImpactPhysics(inertia=True), ImpactPhysics(elastic_shot=(210e9, 0.3))):
        found = tabulated((30.0, 60.0), physics)
        assert found.radius_for(3e-3, 60.0, 7800.0) == pytest.approx(3 * found.radius_for(1e-3, 60.0))
        with pytest.raises(InputError, match="density"):
            found.radius_for(1e-3, 60.0, 2500.0)
    rate = tabulated((30.0, 60.0), ImpactPhysics(rate=True, radius_m=0.5e-3))
    rate.radius_for(np.array([0.9e-3, 1.1e-3]), 60.0, 7800.0)  # C ln 1.1 = 8e-4
    for diameter in (0.3e-3, 3e-3):
        with pytest.raises(InputError, match="belongs to its diameter"):
            rate.radius_for(diameter, 60.0)
