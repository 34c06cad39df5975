"""The dimple library: which shots it serves, and what is solved for it."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from helpers import reduced

from glue.errors import InputError
from glue.scene import catalogue
from glue.solvers import build_plugin
from glue.target.dimple import zero_height_radius
from glue.target.driver import kernel_flavour
from glue.target.library import Library, build_library
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import EnergySplit
from glue.target.speeds import solve_speeds

AL = catalogue.material("al2024-t351")
RIGID = ImpactPhysics()


def solved(v):
    """Radius .06 v^.5 R, depth .002 v R, e .7 v^-.2; a parabola for a profile."""
    r, radius, e = np.linspace(0.0, 2.0, 4001), 0.06 * v**0.5, 0.7 * v**-0.2
    points = {"peeq": np.array([0.1]), "r": np.array([radius]), "z": np.zeros(1), "volume": np.ones(1)}
    points |= {"u_r": np.zeros(1), "u_z": np.zeros(1)}
    impact = reduced(r, 0.002 * v * ((r / radius) ** 2 - 1.0), points)
    return dataclasses.replace(
        impact, restitution=e, energy=EnergySplit(2.0, 2 * e**2, 0.1, 1.9 - 2 * e**2, 0.0, 0.0, 0.0, 0.0)
    )


def library(physics=RIGID, speeds=(1.0, 4.0, 16.0, 64.0)):
    return Library(AL, speeds, tuple(solved(v) for v in speeds), 7800.0, 6, physics)


def test_curves_of_the_dimple_and_the_energy():
    found = library()
    assert found.at("radius", 9.0) == pytest.approx(0.18, rel=1e-4)
    assert found.at("depth", 9.0) == pytest.approx(0.018, rel=1e-12)
    assert found.at("restitution", [1.0, 64.0]) == pytest.approx([0.7, 0.7 * 64**-0.2], rel=1e-12)
    assert found.at("elastic_energy", 9.0) == pytest.approx(0.05, rel=1e-12)
    with pytest.raises(InputError, match="does not extrapolate; allowed 1 to 64 m/s"):
        found.at("radius", 65.0)


def test_only_density_times_speed_squared_counts_for_a_rigid_shot():
    found = library()
    assert found.at("radius", 9.0, 4 * 7800.0) == pytest.approx(found.at("radius", 18.0), rel=1e-12)
    with pytest.raises(InputError, match="does not extrapolate"):  # as dense as four times steel, as if 80 m/s
        found.at("radius", 40.0, 4 * 7800.0)


@pytest.mark.parametrize(
    "physics", [ImpactPhysics(inertia=True), ImpactPhysics(elastic_shot=(210e9, 0.3)), ImpactPhysics(rate=True, radius_m=5e-4)]
)
def test_other_densities_are_refused_where_they_count_by_themselves(physics):
    found = library(physics)
    assert found.at("radius", 9.0, 7800.0) == found.at("radius", 9.0)
    with pytest.raises(InputError, match="holds for one density"):
        found.at("radius", 9.0, 2500.0)


def test_a_rate_dependent_library_belongs_to_its_shot():
    found = library(ImpactPhysics(rate=True, radius_m=5e-4))
    found.at("radius", 9.0, radius_m=5e-4)
    with pytest.raises(InputError, match="belongs to its shot"):
        found.at("radius", 9.0, radius_m=1e-3)
    library().at("radius", 9.0, radius_m=1e-3)  # without the rate every size


def test_the_profile_between_two_speeds_has_the_curves_radius_and_depth():
    r, z = library().profile(9.0)
    assert z[0] == pytest.approx(-0.018, rel=1e-3)
    crossing = np.interp(0.0, z[r < 0.3], r[r < 0.3])
    assert crossing == pytest.approx(0.18, rel=1e-3)


def test_the_table_goes_to_json_and_the_dimple_to_si():
    found = library()
    values = json.loads(json.dumps(found.as_dict()))
    assert values["material"] == "al2024-t351" and values["speed_m_s"] == [1.0, 4.0, 16.0, 64.0]
    assert values["columns"]["restitution"][0] == pytest.approx(0.7)
    assert values["exponent"]["radius"] == pytest.approx(0.5, abs=1e-3)
    assert not math.isnan(values["error"]["radius"])


def test_too_few_points_or_falling_speeds_are_refused():
    for ends in ((60.0, 1.0), (0.0, 60.0)):
        with pytest.raises(InputError, match="rising"):
            build_library(AL, *ends, 5, density_kg_m3=7800.0, elements_per_radius=3)
    with pytest.raises(InputError, match="3 and more points"):
        build_library(AL, 1.0, 60.0, 2, density_kg_m3=7800.0, elements_per_radius=3)


@pytest.fixture(scope="module")
def kernels():
    if kernel_flavour() == "kernel":
        build_plugin()


@pytest.mark.solver
def test_two_densities_with_equal_density_times_speed_squared_leave_one_dimple(kernels):
    """The one claim that lets a library serve every medium: steel at 20 m/s and a quarter of it at 40."""
    steel, light = (
        solve_speeds(AL, [v], density_kg_m3=density, elements_per_radius=3)[0] for v, density in ((20.0, 7800.0), (40.0, 1950.0))
    )
    # Newton's tolerance of 1e-5 of the forces is what is left between them
    assert zero_height_radius(light) == pytest.approx(zero_height_radius(steel), rel=1e-6)
    assert light.surface_z[0] == pytest.approx(steel.surface_z[0], rel=1e-6)
    assert light.restitution == pytest.approx(steel.restitution, rel=1e-6)
    assert light.duration == pytest.approx(0.5 * steel.duration, rel=1e-6)


@pytest.mark.solver
@pytest.mark.parametrize("key", catalogue.material_keys())
def test_every_material_of_the_catalogue_runs(kernels, key):
    """Steel at 60 m/s, a/3: a dimple between that of a hard spring steel and of soft aluminium, energy in balance."""
    (impact,) = solve_speeds(catalogue.material(key), [60.0], density_kg_m3=7800.0, elements_per_radius=3)
    assert impact.energy_error <= 0.005
    assert 0.2 < zero_height_radius(impact) < 0.6 and 0.2 < impact.restitution < 0.9
