"""Scene files with keys changed: the same scene but for what was changed."""

from __future__ import annotations

import dataclasses

import pytest

from glue.scene.derive import changed
from glue.scene.reader import example_names, example_path, read_scene


@pytest.mark.parametrize("name", example_names())
def test_a_scene_written_again_is_the_same_scene(name):
    path = example_path(name)
    again = read_scene(path, content=changed(path.read_bytes(), {}), provisional=True)
    assert again == read_scene(path, provisional=True)


def test_changes_reach_every_table_of_an_array_and_nothing_else():
    path = example_path("two-nozzles-pulsed")
    plain = read_scene(path)
    content = changed(path.read_bytes(), {"nozzle.mass_flow_kg_s": 1e-3, "seed": 7, "accuracy.preset": "fast"})
    scene = read_scene(path, content=content)
    assert scene.accuracy.preset == "fast" and scene.seed == 7
    assert scene.nozzles == tuple(dataclasses.replace(n, mass_flow_kg_s=1e-3) for n in plain.nozzles)
    assert (scene.media, scene.target) == (plain.media, plain.target)


def test_none_removes_a_key():
    path = example_path("glass-drag")
    assert read_scene(path, content=changed(path.read_bytes(), {"air_drag": None})).air_drag is None
