"""Softened contacts: longer by Hertz's power, a larger step, refused where they become too deep."""

from __future__ import annotations

import dataclasses

import pytest

from glue.flow.regime import expected_errors
from glue.scene.contact_checks import elastic_overlap, steps_per_contact
from glue.scene.reader import example_path, read_scene
from glue.scene.softened import softened


def scene_with(scale: float):
    scene = read_scene(example_path("al2024-s390"))
    return dataclasses.replace(scene, accuracy=dataclasses.replace(scene.accuracy, flow_stiffness_scale=scale))


def test_full_stiffness_is_the_scene_itself():
    assert softened(scene_with(1.0)) == scene_with(1.0)


def test_depth_and_steps_go_with_hertz_powers():
    stiff, soft = scene_with(1.0), softened(scene_with(0.1))
    parts = [(s.media, s.nozzles, s.target.material) for s in (stiff, soft)]
    deep = [elastic_overlap(*p) for p in parts]
    steps = [steps_per_contact(*p, 1.0) for p in parts]
    assert deep[1] / deep[0] == pytest.approx(0.1**-0.4)
    assert steps[1] / steps[0] == pytest.approx(0.1 ** (0.5 - 0.4))


def test_the_flow_is_expected_to_err_more():
    assert expected_errors(scene_with(0.1), 0.4)["dem"] > expected_errors(scene_with(1.0), 0.4)["dem"]


def test_too_soft_contacts_are_refused(problems_of):
    found = problems_of({"accuracy": "{flow_stiffness_scale = 0.001}"})
    assert any("too deep for the flow's contact law" in line for line in found)
    assert any("allowed 0.0001..1" in line for line in problems_of({"accuracy": "{flow_stiffness_scale = 2.0}"}))
