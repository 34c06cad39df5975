"""No value whatever makes the reader fail in any way but its own."""

from __future__ import annotations

import json

import pytest

from glue.errors import InputError
from glue.scene import schema
from glue.scene.reader import read_scene, resolved_dict

ODD_VALUES = [
    *(
        "0",
        "-1",
        "1e308",
        "-inf",
        "nan",
        "true",
        '""',
        '"\\u0000"',
        '"é"',
        "[]",
        "[[]]",
        "[{}]",
        "{}",
        "{a = {}}",
    ),
    *("1979-05-27", "07:32:00", "9" * 4000, "[1, 2, 3]", '["a", "b"]', '[0.004, "0.004"]'),
]
KEYS = [
    *("schema", "name", "seed", "exposure_time_s", "shots", "nozzle", "target", "restitution", "friction"),
    *("models", "accuracy", "coverage_percent", "gravity", "new", '"quoted key"', '""'),
    *("shots.grade", "shots.diameter_m", "shots.size", "shots.size_cv", "nozzle.speed_m_s"),
    *("nozzle.impact_angle_deg", "nozzle.feed_speed_m_s", "target.material", "target.window_m"),
    *("target.material.E_Pa", "target.material.johnson_cook", "target.material.combined"),
    *("target.material.combined.backstresses", "restitution.shot_target", "friction.shot_shot"),
    *("models.flow", "accuracy.preset", "arrivals", "air_drag", "gravity.direction", "gravity.acceleration_m_s2"),
    *("air_drag.gas_speed_m_s", "restitution.hardening", "restitution.hardening.hits", "target.surface"),
    *("target.surface.kind", "target.surface.file", "target.surface.radius_m", "target.thickness_m"),
    *("shots.mass_fraction", "shots.sieve", "shots.sieve.opening_m", "friction.in_dimple", "strain_rate"),
    *("strain_rate.thermal", "target_inertia", "elastic_shot", "target.material.voce", "target.material.table"),
    *(f"nozzle.{key}" for key in (*schema.NOZZLE, *schema.JET, *schema.FEED, *schema.PULSE)),
]
# What must stand beside a key for it to be looked at.
BESIDE = {
    "target.surface.file": {"target.surface.kind": '"stl"'},
    "target.surface.radius_m": {"target.surface.kind": '"cylinder"'},
    "nozzle.pulse_duty": {"nozzle.mass_flow_pattern": '"pulsed"', "nozzle.pulse_frequency_Hz": "20"},
    "nozzle.pulse_amplitude": {"nozzle.mass_flow_pattern": '"sinusoidal"', "nozzle.pulse_frequency_Hz": "20"},
    "nozzle.pulse_frequency_Hz": {"nozzle.mass_flow_pattern": '"pulsed"', "nozzle.pulse_duty": "0.5"},
    **{
        f"nozzle.{key}": {"nozzle.feed_speed_m_s": "0.02", "nozzle.passes": "2"}
        for key in schema.FEED
        if key not in ("feed_speed_m_s", "passes")
    },
    "nozzle.passes": {"nozzle.feed_speed_m_s": "0.02"},
    "nozzle.stroke_m": {"nozzle.feed_speed_m_s": "0.02", "exposure_time_s": None},
    "shots.sieve": {"shots": None, "shots.density_kg_m3": "7800", "shots.size": '"sieve"'},
}


@pytest.mark.parametrize("key", KEYS)
def test_whatever_stands_in_a_key_is_read_or_refused_in_words(key, write_scene):
    beside = {"target.material": None} if key.startswith("target.material.") else BESIDE.get(key, {})
    for value in ODD_VALUES:
        path = write_scene(beside | {key: value})
        try:
            scene = read_scene(path)
        except InputError as error:
            for problem in error.problems:
                assert problem.startswith(f"{path}: ") and "not valid TOML" not in problem
                assert any(word in problem for word in ("allowed", "this version has", "must be", "required"))
        else:  # the few that are fine, an empty optional table for one
            assert json.loads(json.dumps(resolved_dict(scene), allow_nan=False))


@pytest.mark.parametrize("block", ["shots", "nozzle"])
def test_whatever_stands_among_several_blocks(block, write_scene):
    for value in ODD_VALUES:
        path = write_scene({block: f"[{value}, {value}]"})
        with pytest.raises(InputError) as caught:
            read_scene(path)
        assert all(problem.startswith(f"{path}: {block}") for problem in caught.value.problems)
