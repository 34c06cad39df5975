"""Intensity, machine setting and coverage in place of speed and time: what is read, and what is refused, at once."""

from __future__ import annotations

import hashlib
import json

import pytest

from glue.errors import InputError
from glue.scene.reader import read_scene, resolved_dict
from glue.scene.specification import INFERRED

ASKED = {"nozzle.speed_m_s": None, "nozzle.intensity": '"6-8A"', "exposure_time_s": None, "coverage_percent": "200"}
TABLE = "[{ air_pressure_Pa = 2e5, speed_m_s = 30.0 }, { air_pressure_Pa = 4e5, speed_m_s = 50.0 }]"
AT = {"nozzle.speed_m_s": None, "nozzle.air_pressure_Pa": "3e5"}


def found(path, **changes):
    return {
        "schema": 1, "scene_sha256": hashlib.sha256(path.read_bytes()).hexdigest(), "speed_m_s": [41.5],
        "exposure_time_s": 2.25, "text": ["nozzle.speed_m_s = 41.5 from intensity 6-8A"],
    } | changes  # fmt: skip


def test_a_scene_that_is_only_specified_is_not_run_with_stand_ins(write_scene):
    path = write_scene(ASKED)
    with pytest.raises(InputError, match="not found yet"):
        read_scene(path)
    scene = read_scene(path, provisional=True)
    assert scene.specification.intensities == ("6-8A",) and scene.specification.coverage_percent == 200.0


def test_what_was_found_takes_its_place(write_scene):
    path = write_scene(ASKED)
    scene = read_scene(path, inferred=found(path))
    assert (scene.nozzle.speed_m_s, scene.exposure_time_s) == (41.5, 2.25)
    assert scene.inferred == ("nozzle.speed_m_s = 41.5 from intensity 6-8A",)
    assert "inferred" not in resolved_dict(scene) and resolved_dict(scene)["specification"]["intensities"] == ["6-8A"]


def test_what_lies_beside_the_file_counts_for_this_file_only(write_scene):
    path = write_scene(ASKED)
    path.with_name(INFERRED).write_text(json.dumps(found(path)))
    assert read_scene(path).nozzle.speed_m_s == 41.5
    path.with_name(INFERRED).write_text(json.dumps(found(path, scene_sha256="0")))
    with pytest.raises(InputError, match="not found yet"):
        read_scene(path)


def test_a_plain_scene_hashes_as_it_did(write_scene):
    assert "specification" not in resolved_dict(read_scene(write_scene()))


def test_a_speed_that_no_nozzle_has_is_told_at_the_intensity(write_scene):
    path = write_scene(ASKED)
    with pytest.raises(InputError, match="nozzle.intensity: leads to a speed of 400 m/s"):
        read_scene(path, inferred=found(path, speed_m_s=[400.0]))


def test_all_that_is_wrong_with_a_specification_at_once(problems_of):
    told = problems_of(
        {
            "nozzle.intensity": '"3A"',  # speed_m_s is there too
            "coverage_percent": "99",  # exposure_time_s too
            "shots.grade": '"S391"',
            "machine.table": "[]",
        }
    )
    assert any("coverage_percent: contradicts exposure_time_s" in t for t in told)
    assert any("called full" in t for t in told)
    assert any("nozzle.intensity: contradicts speed_m_s" in t for t in told)
    assert any("say it on strip N" in t for t in told)
    assert any("machine" in t and "array of tables" in t for t in told)
    assert any("S391" in t for t in told)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"nozzle.speed_m_s": None, "nozzle.intensity": '"8B"'}, 'a strip "B" that there is not'),
        ({"nozzle.speed_m_s": None, "nozzle.intensity": '"25A"'}, "say it on strip C"),
        ({"nozzle.speed_m_s": None, "nozzle.intensity": "8"}, "must be a text in quotes"),
        ({"nozzle.speed_m_s": None, "nozzle.intensity": '"8A"', "nozzle.air_pressure_Pa": "3e5"}, "says the same as intensity"),
        (AT, "needs a [machine]"),
        (AT | {"machine.table": TABLE, "nozzle.air_pressure_Pa": "5e5"}, "beyond the calibration; allowed 200000..400000"),
        ({"nozzle.speed_m_s": None, "nozzle.wheel_speed_m_s": "30.0", "machine.table": TABLE}, "calibrated over air_pressure_Pa"),
        ({"machine.table": TABLE}, "has no effect"),
        (AT | {"machine.table": TABLE, "machine.law": "{}"}, "say the same"),
        (AT | {"machine.table": TABLE.replace("50.0", "20.0")}, "must rise with the setting"),
        (AT | {"machine.table": TABLE.replace("4e5", "2e5")}, "stands twice"),
        (AT | {"machine.table": TABLE.replace("air_pressure_Pa = 4e5", "wheel_speed_m_s = 40")}, "mixes"),
        (AT | {"machine.curves": '[{ air_pressure_Pa = 3e5, file = "none.csv" }]'}, 'no file "none.csv"'),
        (AT | {"machine.law": "{ air_pressure_Pa = 3e5, speed_m_s = 40.0 }"}, "exponent: missing"),
        (ASKED | {"nozzle.feed_speed_m_s": "0.02"}, "finds the number of passes along one line: stroke_m is in the way or missing"),
        (ASKED | {"nozzle.feed_speed_m_s": "0.02", "nozzle.stroke_m": "0.05", "nozzle.passes": "3"}, "along one line: passes"),
        (ASKED | {"coverage_percent": "0.98"}, "0.98 a share of one is written 98"),
    ],
)
def test_what_is_refused(changes, says, problems_of):
    assert any(says in told for told in problems_of(changes)), problems_of(changes)
