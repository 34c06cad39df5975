"""Optional physics of a scene: absent, "auto" or given in numbers."""

from __future__ import annotations

import pytest

from glue.scene.effects import AirDrag, Gravity, StrainRate, Switch
from glue.scene.model import Friction, SpotHardening
from glue.scene.reader import read_scene


def test_absent_blocks_are_not_modelled_and_said_so(write_scene):
    scene = read_scene(write_scene())
    assert (scene.gravity, scene.air_drag, scene.restitution.hardening) == (None, None, None)
    assert (scene.strain_rate, scene.target_inertia, scene.elastic_shot) == (None, None, None)
    assert scene.friction == Friction(0.2, 0.2, in_dimple=False)
    assert 'gravity = "none" (straight flights: an absent block is not modelled)' in scene.defaults_used
    assert 'air_drag = "none" (flights in vacuum: an absent block is not modelled)' in scene.defaults_used

    for key, without in (
        ("strain_rate", "laws that know no rate and no heat"),
        ("target_inertia", "a quasi-static target"),
        ("elastic_shot", "rigid shots in the dimple model"),
    ):
        assert f'{key} = "none" ({without}: an absent block is not modelled)' in scene.defaults_used
    assert "friction.in_dimple = false (the dimple is pressed without friction; choice of this project)" in scene.defaults_used


def test_auto_leaves_it_to_the_regime_numbers(write_scene):
    scene = read_scene(write_scene({"gravity": '"auto"', "air_drag": '"auto"'}))
    assert scene.gravity == Gravity(9.81, (0.0, 0.0, -1.0), auto=True)
    assert scene.air_drag == AirDrag(1.204, 1.81e-5, 0.0, auto=True)
    assert "gravity.acceleration_m_s2 = 9.81 (standard gravity; grade D)" in scene.defaults_used


def test_a_block_models_it(write_scene):
    scene = read_scene(
        write_scene({"gravity": "{}", "air_drag": "{gas_speed_m_s = 80, gas_density_kg_m3 = 1.1}"})
    )
    assert scene.gravity == Gravity(9.81)
    assert scene.air_drag == AirDrag(1.1, 1.81e-5, 80.0)


def test_the_direction_of_gravity_is_scaled_to_length_one(write_scene):
    gravity = read_scene(write_scene({"gravity": "{direction = [3, 0, -4], acceleration_m_s2 = 10}"})).gravity
    assert gravity.direction == pytest.approx((0.6, 0.0, -0.8), rel=1e-15)
    assert gravity.vector == pytest.approx((6.0, 0.0, -8.0), rel=1e-15)


def test_restitution_that_rises_where_shots_struck_before(write_scene):
    scene = read_scene(write_scene({"restitution.hardening": "{}"}))
    assert scene.restitution.hardening == SpotHardening(0.65, 4.0)
    assert any(
        line.startswith("restitution.hardening.saturated = 0.65 (") and line.endswith("grade C)")
        for line in scene.defaults_used
    )
    given = {"restitution.shot_target": "0.5", "restitution.hardening": "{saturated = 0.501, hits = 4}"}
    assert read_scene(write_scene(given)).restitution.hardening == SpotHardening(0.501, 4.0)


def test_physics_of_the_impact(write_scene):
    given = {"strain_rate": "{}", "target_inertia": "{}", "elastic_shot": "{}", "friction": "{in_dimple = true}"}
    scene = read_scene(write_scene(given))
    assert (scene.strain_rate, scene.target_inertia, scene.elastic_shot) == (StrainRate(), Switch(), Switch())
    assert scene.friction == Friction(0.2, 0.2, in_dimple=True)
    scene = read_scene(write_scene({key: '"auto"' for key in ("strain_rate", "target_inertia", "elastic_shot")}))
    assert scene.strain_rate == StrainRate(auto=True)
    assert (scene.target_inertia, scene.elastic_shot) == (Switch(auto=True), Switch(auto=True))
    hot = read_scene(write_scene({"strain_rate.thermal": "true", "target.material": '"ti6al4v"'}))
    assert hot.strain_rate == StrainRate(thermal=True)


def own(johnson_cook: str) -> dict[str, str | None]:
    return {
        "target.material": None,
        "target.material.E_Pa": "205e9",
        "target.material.nu": "0.29",
        "target.material.density_kg_m3": "7850",
    } | ({"target.material.johnson_cook": johnson_cook} if johnson_cook else
         {"target.material.table": "[[0, 300e6], [0.1, 400e6]]"})  # fmt: skip


@pytest.mark.parametrize("curve", ["", "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36}"])
def test_auto_rate_dependence_may_stand_beside_a_law_without_one(curve, write_scene):
    assert read_scene(write_scene(own(curve) | {"strain_rate": '"auto"'})).strain_rate == StrainRate(auto=True)


@pytest.mark.parametrize(
    "changes, expected",
    [
        (
            own("{A_Pa = 350e6, B_Pa = 275e6, n = 0.36}") | {"strain_rate": "{}"},
            "strain_rate: has no effect: own material knows no rate (C is 0); allowed: no strain_rate block, "
            "or a material with johnson_cook.C above 0",
        ),
        (
            own("") | {"strain_rate": "{}"},
            "strain_rate: has no effect: own material knows no rate (it has no johnson_cook curve); allowed: no "
            "strain_rate block, or a material with johnson_cook.C above 0",
        ),
        (
            {"target.material": '"in718"', "strain_rate.thermal": "true"},
            "strain_rate.thermal: nickel alloy IN718 has no m and no melting_K and no specific_heat_J_kg_K; allowed: "
            "false, or a material whose johnson_cook has m, melting_K and specific_heat_J_kg_K",
        ),
        (
            {"strain_rate.thermal": "1"},
            "strain_rate.thermal: must be true or false, not the integer 1; allowed true, false",
        ),
        ({"strain_rate": "true"}, 'strain_rate: must be a table [strain_rate] or "auto", not the boolean true'),
        ({"strain_rate.C": "0.1"}, "strain_rate.C: unknown key; allowed: thermal"),
        (
            {"target_inertia.density_kg_m3": "2780"},
            "target_inertia.density_kg_m3: unknown key; [target_inertia] is an empty block; allowed: no keys",
        ),
        ({"elastic_shot": "[]"}, 'elastic_shot: must be a table [elastic_shot] or "auto", not an array'),
        (
            {"friction": "{in_dimple = true, shot_target = 0}"},
            "friction.in_dimple: has no effect with shot_target = 0; allowed: shot_target above 0, or in_dimple = false",
        ),
    ],
)  # fmt: skip
def test_wrong_physics_of_the_impact(changes, expected, problems_of):
    assert problems_of(changes) == [expected]


@pytest.mark.parametrize(
    "changes, expected",
    [
        (
            {"restitution.shot_target": "0.65", "restitution.hardening": "{}"},
            [
                "restitution.hardening.saturated: 0.65 is no more than restitution.shot_target, 0.65: a spot that was struck "
                "before is harder and rebounds more; allowed above 0.65, up to 0.94, or exactly 1"
            ],
        ),
        (
            {"restitution.hardening": "{saturated = 0.97, hits = 0}"},
            [
                "restitution.hardening.saturated: 0.97 cannot be reached: above 0.94 the contact law of YADE saturates "
                "(0.97 rebounds at 0.965, 0.999 at 0.984); allowed above 0 up to 0.94, or exactly 1",
                "restitution.hardening.hits: 0 is out of range; allowed 0.1..1000",
            ],
        ),
        (
            {"restitution.hardening": "true"},
            ["restitution.hardening: must be a table [restitution.hardening], not the boolean true"],
        ),
        (
            {"restitution.hardening": "{hit = 1}"},
            ['restitution.hardening.hit: unknown key; did you mean "hits"? allowed: saturated, hits'],
        ),
        ({"gravity": "true"}, ['gravity: must be a table [gravity] or "auto", not the boolean true']),
        ({"air_drag": '"on"'}, ['air_drag: must be a table [air_drag] or "auto", not the text "on"']),
        (
            {"gravity": "{acceleration_m_s2 = 9810}"},
            ["gravity.acceleration_m_s2: 9810 is out of range; this key is in metres per second squared; allowed 0.001..1000 m/s2"],
        ),
        (
            {"gravity": "{direction = [0, 0, 0]}"},
            ["gravity.direction: [0, 0, 0] points nowhere; allowed: any vector but that, it is scaled to length 1"],
        ),
        (
            {"gravity": "{direction = [0, -1]}"},
            ["gravity.direction: must be three numbers, not 2; allowed: three numbers [x, y, z], each -1e6..1e6"],
        ),
        (
            {"air_drag": "{gas_viscosity_Pa_s = 18.1}"},
            [
                "air_drag.gas_viscosity_Pa_s: 18.1 is out of range; this key is in pascal seconds (18.1 mPa s is written "
                "0.0181); allowed 1e-7..0.1 Pa s"
            ],
        ),
        (
            {"air_drag": "{gas_density_kg_m3 = 0, gas_speed_m_s = -1}"},
            [
                "air_drag.gas_density_kg_m3: 0 is out of range; this key is in kilograms per cubic metre; "
                "allowed 0.001..1000 kg/m3",
                "air_drag.gas_speed_m_s: -1 is out of range; this key is in metres per second; allowed 0..500 m/s",
            ],
        ),
    ],
)  # fmt: skip
def test_wrong_physics(changes, expected, problems_of):
    assert problems_of(changes) == expected
