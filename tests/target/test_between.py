"""Dimples and layer shapes between solved speeds: right on the curves, scaled by density, refused beyond."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from helpers import reduced

from glue.errors import InputError
from glue.scene import catalogue
from glue.solvers import build_plugin
from glue.target.between import Between, grid, solve_between
from glue.target.dimple import solve_dimple
from glue.target.driver import kernel_flavour
from glue.target.layers import LayerShape, layer_shape
from glue.target.library import Library
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import EnergySplit, solve_reduced

AL = catalogue.material("al2024-t351")


def solved(v):
    """Radius .06 v^.5 R, depth .002 v R, e .7 v^-.2; a parabola for a profile."""
    r, radius, e = np.linspace(0.0, 2.0, 4001), 0.06 * v**0.5, 0.7 * v**-0.2
    points = {"peeq": np.array([0.1]), "r": np.array([radius]), "z": np.zeros(1), "volume": np.ones(1)}
    points |= {"u_r": np.zeros(1), "u_z": np.zeros(1)}
    impact = reduced(r, 0.002 * v * ((r / radius) ** 2 - 1.0), points)
    energy = EnergySplit(2.0, 2 * e**2, 0.1, 1.9 - 2 * e**2, 0.0, 0.0, 0.0, 0.0)
    return dataclasses.replace(impact, restitution=e, energy=energy, duration=4e-3 * v**-0.1)


def shape(v):
    ones = np.ones(3)
    return LayerShape(np.array([0.1, 1.0, 2.0]), 1e8 * np.log(v) * ones, 0.1 * np.log(v) * ones, 0.2 * ones, 0.06 * v**0.5)


SPEEDS = (1.0, 4.0, 16.0, 64.0)
LIBRARY = Library(AL, SPEEDS, tuple(map(solved, SPEEDS)), 7800.0, 3, ImpactPhysics())
MADE_UP = Between(LIBRARY, tuple((v, shape(v)) for v in (16.0, 64.0)))


def test_a_dimple_between_two_speeds_lies_on_the_curves():
    dimple = MADE_UP.dimple(36.0, 1e-3, 7800.0)
    assert dimple.radius_m == pytest.approx(0.36 * 0.5e-3, rel=1e-4)
    assert dimple.depth_m == pytest.approx(0.072 * 0.5e-3, rel=1e-9)
    assert dimple.restitution == pytest.approx(0.7 * 36.0**-0.2, rel=1e-9)
    assert dimple.contact_time_s == pytest.approx(4e-3 * 36.0**-0.1 * 0.5e-3, rel=1e-9)
    assert dimple.speed_exponent == pytest.approx(0.5, abs=1e-3) and dimple.restitution_exponent == pytest.approx(0.2, abs=1e-6)
    assert dimple.radius_for(1e-3, 36.0) == pytest.approx(dimple.radius_m, rel=1e-9)
    assert dimple.radius_for(0.5e-3, 9.0) == pytest.approx(0.5 * 0.5 * dimple.radius_m, rel=1e-3)
    assert not dimple.beyond_table(1e-3, [1.0, 64.0]).any() and dimple.beyond_table(1e-3, [0.9, 65.0]).all()
    crossing = np.interp(0.0, dimple.profile_z_m[1:], dimple.profile_r_m[1:])
    assert crossing == pytest.approx(dimple.radius_m, rel=1e-3)


def test_a_heavier_shot_is_one_that_is_faster():
    light, heavy = MADE_UP.dimple(32.0, 1e-3, 7800.0), MADE_UP.dimple(16.0, 1e-3, 4 * 7800.0)
    assert heavy.radius_m == pytest.approx(light.radius_m) and heavy.restitution == pytest.approx(light.restitution)
    assert heavy.contact_time_s == pytest.approx(2.0 * light.contact_time_s)
    assert heavy.radius_for(1e-3, 8.0, 4 * 7800.0) == pytest.approx(light.radius_for(1e-3, 16.0, 7800.0))
    assert 16.0 in heavy.table_speed_m_s


def test_a_solved_speed_gives_the_solved_dimple(tmp_path):
    dimple = MADE_UP.dimple(16.0, 1e-3, 7800.0)
    assert dimple.radius_m == pytest.approx(0.24 * 0.5e-3, rel=1e-4) and dimple.table_speed_m_s.size == 4
    dimple.save(tmp_path / "d.npz")
    again = type(dimple).load(tmp_path / "d.npz")
    assert again.radius_m == dimple.radius_m and again.points_m.shape == (0, 2)


def test_layer_shapes_mix_by_the_logarithm_of_the_speed():
    mixed = MADE_UP.layer_shape(32.0, 7800.0)
    assert mixed.s_Pa == pytest.approx(1e8 * np.log(32.0) * np.ones(3))
    assert mixed.radius_R == pytest.approx(0.06 * 32**0.5, rel=1e-4)
    assert MADE_UP.layer_shape(16.0, 4 * 7800.0).p == pytest.approx(mixed.p)


def test_beyond_the_speeds_it_refuses():
    with pytest.raises(InputError, match="does not extrapolate"):
        MADE_UP.dimple(70.0, 1e-3, 7800.0)
    with pytest.raises(InputError, match="allowed 16 to 64 m/s"):
        MADE_UP.layer_shape(8.0, 7800.0)
    physics = ImpactPhysics(inertia=True)
    assert not MADE_UP.serves(physics)
    with pytest.raises(InputError, match="tie a dimple to one shot"):
        solve_between(AL, 1.0, (10.0, 20.0), 20.0, density_kg_m3=7800.0, elements_per_radius=3, steps_per_contact=90.0,
                      physics=physics, layers=False)  # fmt: skip


def test_the_grid_encloses_the_range():
    assert grid(20.0, 100.0) == pytest.approx([16.0, 22.6274, 32.0, 45.2548, 64.0, 90.5097, 128.0], rel=1e-5)
    assert grid(16.0, 64.0)[0] == 16.0 and grid(16.0, 64.0)[-1] == 64.0 and len(grid(16.0, 16.0)) == 2


@pytest.mark.solver
def test_half_way_between_solved_speeds_it_is_what_is_solved_there(tmp_path):
    # limits: three times the largest of five such differences seen on this material (radius .15 %, dent .1 %, layers .03 %,
    # restitution .8 %, which itself scatters by 1 % at this mesh)
    if kernel_flavour() == "kernel":
        build_plugin()
    v, numbers = 54.0, {"density_kg_m3": 7800.0, "elements_per_radius": 3}
    found = solve_between(AL, v, (v, v), v, **numbers, steps_per_contact=90.0, physics=ImpactPhysics(), layers=True)
    right = solve_dimple(AL, speed_m_s=v, **numbers, diameter_m=1e-3, workdir=tmp_path, other_speeds_m_s=[45.254834])
    dimple = found.dimple(v, 1e-3, 7800.0)
    assert dimple.radius_m == pytest.approx(right.radius_m, rel=0.005)
    assert dimple.depth_m == pytest.approx(right.depth_m, rel=0.003)
    assert dimple.restitution == pytest.approx(right.restitution, rel=0.025)
    law = AL.combined
    own = layer_shape(solve_reduced(AL, law, speed_m_s=v, **numbers), law, right.radius_m / 0.5e-3)
    assert found.layer_shape(v, 7800.0).s_Pa.max() == pytest.approx(own.s_Pa.max(), rel=0.01)
