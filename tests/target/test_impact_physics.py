"""Optional physics of the single impact: refusals, keys, warnings, and FreeFEM's balances step by step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError, NotConverged
from glue.scene.catalogue import material
from glue.target import reduced_impact
from glue.target.dimple import zero_height_radius
from glue.target.physics import STEEL_SHOT, ImpactPhysics, shot_yield_warning
from glue.target.reduced_impact import Numerics, solve_hits, solve_reduced
from glue.target.tables import read_table

AL2024 = material("al2024-t351")
SHOT = (210e9, 0.3)
INPUTS = {"speed_m_s": 60.0, "density_kg_m3": 7800.0, "elements_per_radius": 3}


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"friction": -0.1}, "allowed 0 to 1"),
        ({"friction": math.nan}, "allowed 0 to 1"),
        ({"elastic_shot": (0.0, 0.3)}, "positive and finite"),
        ({"elastic_shot": (210e9, 0.5)}, "0 to 0.49"),
        ({"rate": True}, "needs radius_m"),
        ({"hits": 0}, "1 to 10"),
        ({"hits": 11}, "1 to 10"),
        ({"hits": 2.0}, "whole"),
    ],
)
def test_physics_outside_its_range_is_refused(wrong, told):
    with pytest.raises(InputError, match=told):
        ImpactPhysics(**wrong)


def test_all_that_is_wrong_is_told_at_once():
    with pytest.raises(InputError) as caught:
        ImpactPhysics(friction=2.0, hits=0)
    assert "friction" in str(caught.value) and "hits" in str(caught.value)


def lines(**physics) -> list[str]:
    """The parameters that a result is keyed by."""
    got = reduced_impact._parameters(AL2024, AL2024.johnson_cook, 60.0, 7800.0, 3, Numerics(), ImpactPhysics(**physics))
    return [p.line() for p in got]


def test_a_result_is_keyed_by_its_physics_and_by_the_radius_only_with_rate():
    assert lines(radius_m=0.5e-3) == lines(radius_m=0.1e-3) == lines()
    assert lines(rate=True, radius_m=0.5e-3) != lines(rate=True, radius_m=0.1e-3)
    others = [lines(), lines(small_strain=True), lines(inertia=True), lines(friction=0.2), lines(elastic_shot=SHOT), lines(elastic_shot=(70e9, 0.22)),
              lines(hits=2), lines(rate=True, radius_m=0.5e-3)]  # fmt: skip
    assert len({"\n".join(o) for o in others}) == len(others)


def test_a_shot_that_yields_is_told():
    """Hertz: first yield at p0 = 1.6 Y, where the mean is two thirds of p0; fully plastic at a mean of 2.8 Y."""
    Y = STEEL_SHOT.yield_Pa
    assert shot_yield_warning(1.59 * Y, 1.06 * Y, Y) is None
    assert "yields inside" in shot_yield_warning(1.61 * Y, 1.07 * Y, Y)
    assert "flattened" in shot_yield_warning(3.0 * Y, 2.81 * Y, Y)
    with pytest.raises(InputError, match="positive"):
        shot_yield_warning(1e9, 1e9, 0.0)


def test_one_hit_is_no_repeated_hit():
    with pytest.raises(InputError, match="2 to 10"):
        solve_hits(AL2024, AL2024.johnson_cook, hits=1, **INPUTS)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PEEN_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.mark.solver
@pytest.mark.parametrize(
    "physics",
    [{}, {"inertia": True}, {"friction": 0.2}, {"elastic_shot": SHOT}, {"inertia": True, "friction": 0.2, "elastic_shot": SHOT}],
    ids=["plain", "inertia", "friction", "elastic shot", "all"],
)  # fmt: skip
def test_energy_and_momentum_balance_at_every_step(cache, physics):
    """From the history alone: energies add up to .5 %; the force's impulse is the shot's change of momentum."""
    got = solve_reduced(AL2024, AL2024.johnson_cook, physics=ImpactPhysics(**physics), **INPUTS)
    h = read_table(got.log.with_name("history.csv"))
    mass = 7.8e-3 * 4.0 / 3.0 * math.pi
    first = 0.5 * mass * 60.0**2
    others = h["contact_energy"] + h["target_kinetic"] + h["radiated"] + h["friction"] + h["shot_elastic"]
    kinetic = 0.5 * mass * h["velocity"] ** 2
    assert np.abs(kinetic + others + h["internal_work"] - first).max() < 0.005 * first
    assert np.abs(kinetic + others + h["elastic"] + h["plastic"] - first).max() < 0.005 * first
    time, force = np.r_[0.0, h["time"]], np.r_[0.0, h["force"]]
    impulse = np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(time))
    np.testing.assert_allclose(impulse, mass * (h["velocity"] + 60.0), rtol=1e-9)
    for name, on in (("target_kinetic", "inertia"), ("radiated", "inertia"), ("friction", "friction"), ("shot_elastic", "elastic_shot")):
        assert (np.abs(h[name]).max() > 0.0) == (on in physics), name
    assert got.energy.friction >= 0.0


@pytest.mark.solver
def test_effects_have_the_sign_of_the_mechanics(cache):
    """Waves take from the rebound, an elastic shot and friction add to it; none moves the dimple's radius by 2 %."""
    plain, waves, rough, elastic = (
        solve_reduced(AL2024, AL2024.johnson_cook, physics=ImpactPhysics(**p), **INPUTS)
        for p in ({}, {"inertia": True}, {"friction": 0.2}, {"elastic_shot": SHOT})
    )
    assert waves.restitution < 0.95 * plain.restitution
    assert elastic.restitution > 1.05 * plain.restitution
    assert rough.peak_force > plain.peak_force
    for other in (waves, rough, elastic):
        assert zero_height_radius(other) == pytest.approx(zero_height_radius(plain), rel=0.02)


@pytest.mark.solver
def test_hits_on_one_spot(cache):
    """The table agrees with the last hit's own result; a hardened, deeper seat gives more back each time."""
    once = solve_reduced(AL2024, AL2024.combined, **INPUTS)
    last = solve_reduced(AL2024, AL2024.combined, physics=ImpactPhysics(hits=3), **INPUTS)
    hits = last.hits
    assert once.hits is None
    assert len(hits.restitution) == 3
    assert hits.restitution[0] == pytest.approx(once.restitution, abs=0.005)  # another mesh: later hits reach further
    assert hits.radius[0] == pytest.approx(zero_height_radius(once), rel=0.01)
    assert hits.radius[-1] == pytest.approx(zero_height_radius(last), rel=1e-12)
    assert hits.restitution[-1] == last.restitution
    assert (np.diff(hits.restitution) > 0).all() and (np.diff(hits.depth) > 0).all() and (np.diff(hits.plastic) < 0).all()


@pytest.mark.solver
def test_a_shot_too_soft_for_small_strains_is_refused(cache):
    with pytest.raises(NotConverged, match="too soft"):
        solve_reduced(AL2024, AL2024.johnson_cook, physics=ImpactPhysics(elastic_shot=(1e9, 0.3)), **INPUTS)


@pytest.mark.solver
def test_small_strain_is_that_of_another_small_strain_solution():
    """Depth 59.8 um, radius 240 um, e .280: an axisymmetric small-strain solution of this impact on a mesh of a/11."""
    got = solve_reduced(AL2024, AL2024.johnson_cook, physics=ImpactPhysics(small_strain=True), **INPUTS | {"elements_per_radius": 6})
    assert -float(got.surface_z[0]) * 500.0 == pytest.approx(59.8, rel=0.02)
    assert zero_height_radius(got) * 500.0 == pytest.approx(240.0, rel=0.01)
    assert got.restitution == pytest.approx(0.280, abs=0.005)


@pytest.mark.solver
def test_small_strain_does_nothing_where_strains_are_small():
    slow = INPUTS | {"speed_m_s": 1.0}
    small, finite = (solve_reduced(AL2024, AL2024.johnson_cook, physics=ImpactPhysics(small_strain=s), **slow) for s in (True, False))
    assert small.restitution == pytest.approx(finite.restitution, rel=0.005)
    assert zero_height_radius(small) == pytest.approx(zero_height_radius(finite), rel=0.005)
