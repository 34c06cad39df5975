"""Law, restitution and friction: what a user would expect of their size and sign."""

from __future__ import annotations

import dataclasses

import pytest

from glue.scene.catalogue import material
from glue.scene.reader import example_path, read_scene
from glue.study.uncertainty.model_causes import energy_spread, law_spread

SCENE = read_scene(example_path("al2024-s390"))


def of(key: str):
    return dataclasses.replace(SCENE, target=dataclasses.replace(SCENE.target, material=material(key)))


def test_the_other_sets_of_2024_are_found_and_no_other_alloy():
    assert set(law_spread(SCENE, None).stresses) == {"al2024-t351-jc1983", "al2024-t351-wierzbicki"}


def test_dimple_radii_of_the_other_sets_are_those_of_finite_elements():
    # README, "every material of the catalogue runs at 60 m/s": .454, .465, .450 R; the estimate's own error is 1 %
    assert law_spread(SCENE, None).radius == pytest.approx(0.465 / 0.454 - 1.0, abs=0.01)


def test_a_law_without_bound_counts_the_more_the_more_strain_there_is():
    little, much = law_spread(SCENE, 0.05).strength, law_spread(SCENE, 1.0).strength
    jc, bounded = SCENE.target.material.single_law, SCENE.target.material.combined
    assert much == pytest.approx(jc.flow_stress_Pa(1.0) / bounded.flow_stress_Pa(1.0) - 1.0) and much > 3 * little


def test_an_alloy_with_one_set_is_as_unsure_as_its_grade():
    spread = law_spread(of("ti6al4v"), None)
    assert list(spread.stresses.values()) == [0.14] and 0.02 < spread.radius < 0.06


def test_energy_is_the_surer_the_fewer_shots_meet():
    thin = dataclasses.replace(SCENE, nozzles=tuple(dataclasses.replace(n, mass_flow_kg_s=0.01 * n.mass_flow_kg_s) for n in SCENE.nozzles))
    assert 0.0 < energy_spread(thin, 0.34) < 0.1 * energy_spread(SCENE, 0.34) < 0.05
