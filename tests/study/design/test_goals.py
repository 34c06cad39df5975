"""Targets and objectives as written: names, units, everything wrong at once, and what counts as surely met."""

from __future__ import annotations

import types

import pytest

from glue.errors import InputError
from glue.study.design.axes import read_axes
from glue.study.design.goals import Reading, read_goals

METRICS = {
    "coverage": {"final": 0.99, "avrami_final": 0.985},
    "residual_stress": {"max_compressive_Pa": -260e6},
    "uncertainty": {
        "coverage.final": {
            "value": 0.99, "half_width_95": 0.01, "by_cause": {"statistical": 0.003, "numerical": 0.004, "material_law": 0.008},
        },
        "residual_stress.max_compressive_Pa": {
            "value": -260e6, "half_width_95": 170e6, "by_cause": {"statistical": None, "numerical": 15e6, "material_law": 169e6},
        },
    },
}  # fmt: skip
SCENE = types.SimpleNamespace(exposure_time_s=3.0, mass_flow_kg_s=0.02)


def test_units_become_si_and_are_told_again():
    goals = read_goals(["coverage>=98%", "max_compressive <= -0.25GPa", "Sa<=12um"], ["exposure_time"], ["dimple.depth_m"])
    assert [t.limit for t in goals.targets] == pytest.approx([0.98, -250e6, 12e-6])
    assert [str(t) for t in goals.targets] == ["coverage >= 98 %", "max_compressive <= -250 MPa", "Sa <= 12 µm"]
    assert [str(o) for o in goals.objectives] == ["minimise exposure_time", "maximise dimple_depth"]
    assert goals.stages == ["coverage", "target", "surface", "dimple", "uncertainty"]
    assert read_goals(["coverage.final>=0.98"], ["Sa"]).targets == read_goals(["coverage>=0.98"], ["Sa"]).targets


def test_everything_that_is_wrong_is_told_at_once():
    with pytest.raises(InputError) as told:
        read_goals(["coverag>=0.9", "max_compressive<=-250", "Sa=3um", "coverage>=0.98", "coverage<=0.9"], ["Sab", "Sz", "Sz"])
    said = told.value.problems
    assert len(said) == 6
    assert "did you mean coverage?" in said[0] and "allowed: coverage, time_98" in said[0]
    assert "a unit is missing; max_compressive allows MPa, GPa, kPa, Pa" in said[1]
    assert "must be NAME>=VALUE" in said[2] and "did you mean Sa?" in said[3]
    assert "named twice" in said[4] and "at least 98 % and at most 90 %" in said[5]


def test_compression_is_negative():
    for name, sign in (("max_compressive", "<="), ("residual_stress.max_compressive_Pa", ">=")):
        with pytest.raises(InputError, match=rf"compression is negative here: did you mean {name}<=-250MPa\?"):
            read_goals([f"{name}{sign}250MPa"], ["Sa"])
    allowed = read_goals(["surface_stress<=50MPa", "max_compressive<=0MPa"], ["Sa"]).targets
    assert [t.limit for t in allowed] == pytest.approx([50e6, 0.0])


def test_a_share_has_a_limit_from_0_to_1():
    with pytest.raises(InputError, match="98 % is written 98% or 0.98; coverage is a share"):
        read_goals(["coverage>=98"], ["Sa"])
    for wrong in ("coverage>=150%", "flow.collided_fraction<=-0.1", "coverage.beyond_table_area_share<=2"):
        with pytest.raises(InputError, match="is a share; allowed: 0 to 1, or 0% to 100%"):
            read_goals([wrong], ["Sa"])
    found = read_goals(["coverage>=100%", "coverage.percent>=200%"], ["Sa"]).targets  # as the trade counts, in per cent
    assert [t.limit for t in found] == [1.0, 200.0]


def test_a_key_path_is_answered_with_its_section():
    with pytest.raises(InputError, match="allowed: residual_stress.surface_Pa, .*arc_height_m"):
        read_goals(["residual_stress.arc_height>=1mm"], ["Sa"])


def test_nothing_to_choose_by():
    with pytest.raises(InputError, match="--minimise: nothing to choose by"):
        read_goals(["coverage>=0.98"], [])


def test_coverage_is_searched_by_its_expectation_and_judged_by_the_count():
    q = read_goals(["coverage>=0.98"], ["Sa"]).targets[0].quantity
    assert q.read(METRICS, SCENE) == pytest.approx((0.985, 0.005, 0.01))
    assert q.read(METRICS, SCENE, expected=False) == pytest.approx((0.99, 0.005, 0.01))


def test_only_what_a_rerun_may_change_is_in_the_margin():
    target = read_goals(["max_compressive<=-250MPa"], ["Sa"]).targets[0]
    reading = target.quantity.read(METRICS, SCENE)
    assert reading == pytest.approx((-260e6, 15e6, 170e6))
    assert target.slack(reading) == pytest.approx(-5e6)  # 10 MPa beyond the limit, 15 uncertain
    assert target.slack(Reading(-270e6, 15e6, 170e6)) == pytest.approx(5e6)
    assert target.scaled(5e6) == pytest.approx(0.02)


def test_an_unknown_interval_is_not_a_width_of_nothing():
    target = read_goals(["Ra<=4um"], ["Sa"]).targets[0]
    of_law = {"half_width_95": 1e-6, "by_cause": {"statistical": None, "material_law": 1e-6}}
    for uncertainty in ({}, {"roughness.Ra_m": of_law}):
        reading = target.quantity.read({"roughness": {"Ra_m": 3e-6}, "uncertainty": uncertainty}, SCENE)
        assert reading.half is None and target.slack(reading) == pytest.approx(1e-6)
        assert target.quantity.told(reading) == "3 µm, no interval known"
    assert target.quantity.told(Reading(3e-6, 0.0, 0.0)) == "3 µm"  # exactly known


def test_what_the_scene_says_itself():
    goals = read_goals([], ["shot_mass", "exposure_time"])
    assert [q.read({}, SCENE) for q in goals.quantities] == [Reading(0.06, 0.0, 0.0), Reading(3.0, 0.0, 0.0)]
    assert goals.quantities[0].read({}, SCENE) and read_goals([], ["Sa"]).quantities[0].read({}, SCENE) is None


def test_axes():
    written = ["nozzle.speed_m_s=20:100", "nozzle.mass_flow_kg_s=0.005:0.05:log", "nozzle.passes=1:4:int"]
    written.append("shots.grade=S110,S230")
    speed, flow, passes, grade = read_axes(written)
    assert [speed.at(0.0), speed.at(0.5), flow.at(0.5)] == pytest.approx([20.0, 60.0, 0.01581])
    assert [passes.at(s) for s in (0.0, 0.3, 0.99)] == [1, 2, 4] and isinstance(passes.at(0.3), int)
    assert [grade.at(s) for s in (0.0, 0.49, 0.5)] == ["S110", "S110", "S230"] and grade.ends == ("S110", "S230")
    assert speed.rounded(33.33333) == 33.33 and speed.rounded(100.004) == 100.0


def test_axes_that_are_none():
    wrong = ["a", "a=", "a=1", "a=2:1", "a=0:1:log", "a=1:2.5:int", "a=1:2:3", "b=1:2", "b=1:3"]
    with pytest.raises(InputError) as told:
        read_axes(wrong)
    assert len(told.value.problems) == 8 and "--vary b: given twice" in told.value.problems[-1]
    with pytest.raises(InputError, match="nothing may change"):
        read_axes([])
