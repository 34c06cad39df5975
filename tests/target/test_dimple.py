"""What is read off an impact's fields, and how a dimple scales."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import dimple, reduced

from glue.errors import InputError, NotConverged
from glue.target.dimple import Dimple, edge_peeq, layer_stress, zero_height_radius


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


def test_exponents_are_those_of_two_impacts(monkeypatch, tmp_path):
    """Half the speed: radius sqrt(1/2) as wide, rebound 2^(1/4) as high. Elastoplastic impact has these two powers."""
    import dataclasses

    from glue.target import dimple as module

    r = np.linspace(0, 2, 2001)

    def solved(material, law, *, speed_m_s, **other):
        radius = 0.5 * (speed_m_s / 60.0) ** 0.5
        impact = reduced(r, r**2 - radius**2, YIELDED)
        return dataclasses.replace(impact, restitution=0.34 * (speed_m_s / 60.0) ** -0.25)

    monkeypatch.setattr(module, "solve_reduced", solved)
    monkeypatch.setattr(module, "copy_record", lambda *args: None)
    monkeypatch.setattr(module, "to_si", lambda impact, speed, density, diameter, exponents, wall_s: exponents)
    material = type("Material", (), {"johnson_cook": None})
    found = module.solve_dimple(
        material, speed_m_s=60.0, density_kg_m3=7800.0, diameter_m=1e-3, elements_per_radius=6, workdir=tmp_path
    )
    assert found[0] == pytest.approx(0.5, abs=1e-4) and found[1] == pytest.approx(0.25, rel=1e-12)
