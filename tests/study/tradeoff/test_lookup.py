"""Which rung speaks for a run: never a finer one, and of the coarser ones the nearest."""

from __future__ import annotations

import dataclasses

import pytest

from glue.scene.presets import PRESETS
from glue.scene.reader import example_path, read_scene
from glue.study.tradeoff.lookup import numerical, settings_of, speaking

SCENE = read_scene(example_path("al2024-s390"), preset="balanced")


def row(stage, error, model=None, **accuracy):
    changes = {f"accuracy.{k}": v for k, v in accuracy.items()} | ({f"models.{stage}": model} if model else {})
    return {
        "group": stage, "stage": stage, "factor": "rung", "level": str(accuracy), "changes": {"accuracy.preset": "fast"} | changes,
        "physics": False, "failed": None,
        "quantities": {"Sa": {"value": 1.0, "error": error, "se": 0.0, "hidden": False, "scatter": None}},
    }  # fmt: skip


STAMPS = [row("surface", e, stamp_points_per_radius=n) for n, e in ((6.0, 0.03), (12.0, 0.001), (24.0, 0.002))]
FLOWS = [row("flow", 0.2, "ballistic"), row("flow", 0.004, "dem", flow_dt_over_P=1.0), row("flow", 0.001, "dem", flow_dt_over_P=0.3)]


def spoken(rows, stage, model=None, **numbers):
    settings = settings_of(dataclasses.replace(PRESETS["balanced"], **numbers))
    return [r["quantities"]["Sa"]["error"] for r in speaking({"rows": rows}, stage, settings, model)]


@pytest.mark.parametrize("points, error", [(12.0, [0.001]), (16.0, [0.001]), (23.9, [0.001]), (99.0, [0.002]), (6.5, [0.03])])
def test_the_nearest_that_is_no_finer(points, error):
    assert spoken(STAMPS, "surface", stamp_points_per_radius=points) == error


def test_a_run_coarser_than_every_rung_hears_all_of_them():
    assert spoken(STAMPS, "surface", stamp_points_per_radius=3.0) == [0.03, 0.001, 0.002]


def test_a_smaller_step_is_a_finer_one_and_models_speak_for_themselves():
    assert spoken(FLOWS, "flow", "dem", flow_dt_over_P=0.5) == [0.004]
    assert spoken(FLOWS, "flow", "ballistic") == [0.2]
    assert spoken(FLOWS, "flow", "event") == []


def test_rungs_that_are_coarse_in_different_numbers_both_speak():
    cells = [row("target", 0.05, "cell", cell_load_steps=1, cell_elements_per_side=5), row("target", 0.03, "cell", cell_elements_per_side=4, cell_load_steps=2)]
    assert spoken(cells, "target", "cell") == [0.05, 0.03]


def test_stages_add_by_squares():
    entry = {"rows": [*STAMPS, *FLOWS]}
    found = numerical(entry, SCENE, {"flow": "dem"})  # stamp 16, dt 1 P
    assert found == {"Sa": pytest.approx((0.001**2 + 0.004**2) ** 0.5)}
