"""Choosing by a table that is made up: the cheapest that is good enough, the best in time, refusals with the nearest."""

from __future__ import annotations

import dataclasses

import pytest

from glue.errors import InputError
from glue.scene.derive import changed
from glue.scene.reader import example_path, read_scene
from glue.study.tradeoff.choose import choose, preset_block
from glue.study.tradeoff.table import features
from glue.study.tradeoff.wishes import parse_error, parse_seconds

SCENE = read_scene(example_path("steel4340-s390"))  # leaves its models to auto


def row(stage, level, changes, cost_s, *, physics=False, **errors):
    quantities = {n: {"value": 1.0, "error": e, "se": 0.0, "hidden": False, "scatter": None} for n, e in errors.items()}
    return {
        "group": stage, "stage": stage, "factor": "rung", "level": level, "changes": changes, "cpu_s": cost_s, "physics": physics,
        "failed": None, "quantities": quantities, "work": {}, "memory_bytes": 1e6, "stage_cpu_s": {},
    }  # fmt: skip


def table(*rows):
    return {"scenes": {"made-up": {"features": features(SCENE), "rows": list(rows)}}, "provenance": {"date": "today"}}


DIMPLES = (
    row("dimple", "coarse", {"accuracy.dimple_elements_per_radius": 3}, 2.0, dimple_radius=0.04),
    row("dimple", "fine", {"accuracy.dimple_elements_per_radius": 12}, 20.0, dimple_radius=0.003),
    row("dimple", "free lunch", {"accuracy.dimple_elements_per_radius": 4}, 0.0, physics=True, dimple_radius=0.0),
)
RASTERS = (
    row("coverage", "coarse", {"accuracy.coverage_points_per_radius": 6.0}, 1.0, coverage=0.03),
    row("coverage", "fine", {"accuracy.coverage_points_per_radius": 40.0}, 5.0, coverage=0.001),
)


def chosen(*, rows=(*DIMPLES, *RASTERS), scene=SCENE, stages=("dimple", "coverage"), **wishes):
    return choose(scene, table=table(*rows), stages=stages, **wishes)


def test_the_cheapest_that_is_good_enough():
    assert chosen(target_error=0.1).cost_s == 3.0
    half = chosen(target_error=0.035)  # the coarse raster will do, the coarse dimple will not
    assert [part.label.split()[-1] for part in half.parts] == ["fine", "coarse"]
    assert chosen(target_error=0.004).cost_s == 25.0


def test_errors_of_stages_on_one_quantity_add_by_squares():
    both = (DIMPLES[1] | {"quantities": RASTERS[0]["quantities"]}, RASTERS[0])
    assert chosen(rows=both, target_error=0.05).worst == ("coverage", pytest.approx(0.03 * 2**0.5))


def test_the_most_exact_in_time():
    assert chosen(budget_s=10.0).worst == ("dimple_radius", 0.04)
    assert chosen(budget_s=100.0).worst == ("dimple_radius", 0.003)


def test_what_does_not_fit_is_refused_with_the_nearest():
    with pytest.raises(InputError, match=r"nearest: dimple rung fine, coverage rung fine.*0\.3 %"):
        chosen(target_error=0.001)
    with pytest.raises(InputError, match=r"as fast; the nearest: dimple rung coarse.*about 3 s"):
        chosen(budget_s=1.0)
    with pytest.raises(InputError, match="no rung of surface was measured"):
        chosen(target_error=0.1, stages=("dimple", "surface"))


def test_the_choice_is_written_into_the_scene():
    content = changed(example_path("steel4340-s390").read_bytes(), chosen(target_error=0.035).changes)
    accuracy = read_scene(example_path("steel4340-s390"), content=content).accuracy
    assert (accuracy.dimple_elements_per_radius, accuracy.coverage_points_per_radius) == (12, 6.0)


def test_a_model_that_the_scene_asks_for_is_never_replaced():
    flows = (
        row("flow", "event", {"models.flow": "event"}, 1.0, normal_energy=0.001),
        row("flow", "dem", {"models.flow": "dem"}, 60.0, normal_energy=0.001),
    )
    assert chosen(rows=flows, stages=("flow",), target_error=0.1).cost_s == 1.0
    asked = read_scene(example_path("al2024-s390"))  # flow = "dem"
    assert chosen(rows=flows, stages=("flow",), scene=asked, target_error=0.1).cost_s == 60.0


def test_ballistic_flow_is_judged_by_the_scenes_own_collisions():
    # measured where shots hardly met, wanted where a fifth of the energy is lost
    flows = (
        row("flow", "ballistic", {"models.flow": "ballistic"}, 0.1, normal_energy=0.001),
        row("flow", "event", {"models.flow": "event"}, 1.0, normal_energy=0.002),
    )
    assert "event" in chosen(rows=flows, stages=("flow",), target_error=0.05).parts[0].label


def test_check_tells_the_presets_cost_and_error():
    whole = row("whole", "balanced", {"accuracy.preset": "balanced"}, 42.0, dimple_radius=0.012) | {"factor": "preset"}
    text = "\n".join(preset_block(SCENE, table(whole)))
    assert "42 s" in text and "dimple radius 1.2 %" in text and "made-up" in text
    assert preset_block(dataclasses.replace(SCENE, accuracy=dataclasses.replace(SCENE.accuracy, preset="fast")), table(whole)) == []


@pytest.mark.parametrize("text, share", [("5%", 0.05), ("0.05", 0.05), (" 12.5 % ", 0.125)])
def test_errors_wished_for(text, share):
    assert parse_error(text) == pytest.approx(share)


@pytest.mark.parametrize("text, seconds", [("60s", 60.0), ("5min", 300.0), ("1.5h", 5400.0), ("30", 30.0)])
def test_times_wished_for(text, seconds):
    assert parse_seconds(text) == seconds


@pytest.mark.parametrize("text", ["", "much", "-5%", "0", "200%", "5 percent"])
def test_errors_that_are_none(text):
    with pytest.raises(InputError, match="--target-error"):
        parse_error(text)


def test_for_a_scene_that_was_not_measured_the_spread_over_scenes_comes_on_top():
    """Coverage errs by .03 on the nearest and .01 on another: .03 + stdev(.03, .01) = .0441 on a third, .03 on the first."""
    two, near = table(*RASTERS), features(SCENE)
    other = [RASTERS[0] | {"quantities": row("coverage", "coarse", {}, 1.0, coverage=0.01)["quantities"]}]
    two["scenes"]["other"] = {"features": {key: value + 2.0 for key, value in near.items()}, "rows": other}
    assert choose(SCENE, table=two, stages=["coverage"], budget_s=2.0).worst[1] == pytest.approx(0.03)
    stranger = dataclasses.replace(SCENE, exposure_time_s=1.5 * SCENE.exposure_time_s)
    assert choose(stranger, table=two, stages=["coverage"], budget_s=2.0).worst[1] == pytest.approx(0.03 + 0.02 / 2**0.5)
