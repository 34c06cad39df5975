"""Which impact physics a scene gets: what it states stays, "auto" follows the numbers."""

from __future__ import annotations

import dataclasses

import pytest

from glue.scene import catalogue
from glue.scene.effects import StrainRate, Switch
from glue.scene.model import Friction
from glue.scene.reader import example_path, read_scene
from glue.target import regime
from glue.target.physics import ImpactPhysics

AL, STEEL = catalogue.material("al2024-t351"), catalogue.shot("S390")


def scene(**blocks):
    return dataclasses.replace(read_scene(example_path("al2024-s390")), **blocks)


def decide(speed=60.0, **blocks):
    return regime.impact_physics(scene(**blocks), STEEL, speed)


def test_absent_blocks_are_not_modelled():
    assert decide() == (ImpactPhysics(), {})


def test_stated_blocks_stay_however_small_their_effect():
    found = decide(0.5, strain_rate=StrainRate(thermal=True), target_inertia=Switch(), elastic_shot=Switch(),
                   friction=Friction(0.2, 0.2, in_dimple=True))  # fmt: skip
    assert found.physics == ImpactPhysics(True, True, True, 0.2, (STEEL.E_Pa, STEEL.nu), 0.5e-3)
    assert {c.model for c in found.choices.values()} == {"on"}


def test_auto_follows_the_numbers():
    fast, slow = (decide(v, target_inertia=Switch(auto=True)) for v in (60.0, 1.0))
    assert fast.physics.inertia and not slow.physics.inertia
    assert "within 0.012" in slow.choices["target_inertia"].why and slow.choices["target_inertia"].model == "off"
    no_rate = dataclasses.replace(AL, johnson_cook=dataclasses.replace(AL.johnson_cook, C=0.0))
    assert regime.rate_number(no_rate, STEEL, 60.0) == 0.0
    assert regime.rate_number(AL, STEEL, 60.0) > regime.TOLERANCE


def test_numbers_against_finite_elements():
    """Steel on 2024, a/3: e .3453 at 60 m/s, with inertia .3080, elastic shot .3838, rate (1 mm) .3538; .4625 and .4448
    with inertia at 15 m/s.  Good to a factor of 2.5."""
    for number, change in (
        (regime.inertia_number(AL, STEEL, 60.0), 1 - 0.3080 / 0.3453),
        (regime.inertia_number(AL, STEEL, 15.0), 1 - 0.4448 / 0.4625),
        (regime.elastic_shot_number(AL, STEEL), 0.3838 / 0.3453 - 1),
        (regime.rate_number(AL, STEEL, 60.0), 0.3538 / 0.3453 - 1),
    ):
        assert change / 2.5 < number < 2.5 * change
    assert regime.restitution_estimate(AL, STEEL, 60.0) == pytest.approx(0.3453, rel=0.2)


def test_the_rate_matters_more_for_small_shots_and_size_for_nothing_else():
    small = dataclasses.replace(STEEL, diameter_m=0.1e-3)
    assert regime.rate_number(AL, small, 60.0) > regime.rate_number(AL, STEEL, 60.0)
    for number in (regime.inertia_number, regime.restitution_estimate):
        assert number(AL, small, 60.0) == pytest.approx(number(AL, STEEL, 60.0), rel=1e-12)
