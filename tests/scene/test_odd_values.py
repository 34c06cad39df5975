"""No value whatever makes the reader fail in any way but its own."""

from __future__ import annotations

import json

import pytest

from glue.errors import InputError
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
    *("models.flow", "accuracy.preset"),
]


@pytest.mark.parametrize("key", KEYS)
def test_whatever_stands_in_a_key_is_read_or_refused_in_words(key, write_scene):
    parent = {"target.material": None} if key.startswith("target.material.") else {}
    for value in ODD_VALUES:
        path = write_scene(parent | {key: value})
        try:
            scene = read_scene(path)
        except InputError as error:
            for problem in error.problems:
                assert problem.startswith(f"{path}: ") and "not valid TOML" not in problem
                assert any(word in problem for word in ("allowed", "this version has", "must be", "required"))
        else:  # the few that are fine, an empty optional table for one
            assert json.loads(json.dumps(resolved_dict(scene), allow_nan=False))
