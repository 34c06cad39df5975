"""The ladder as data: long enough, readable on every built-in scene, references that share nothing with their rungs."""

from __future__ import annotations

import pytest

from glue.scene.reader import example_path, read_scene
from glue.study.tradeoff.jobs import jobs_of
from glue.study.tradeoff.ladder import BUILT_IN, GROUPS
from glue.study.tradeoff.lookup import row_settings

NUMBERS = {
    "dimple": ("dimple_elements_per_radius", "dimple_steps_per_contact"), "flow": ("flow_dt_over_P",),
    "coverage": ("coverage_points_per_radius",), "surface": ("stamp_points_per_radius",),
    "target": ("cell_elements_per_side", "cell_load_steps", "cell_force_tolerance"),
}  # fmt: skip
NUMBERS["whole"] = tuple(key for keys in NUMBERS.values() for key in keys)


def settings(group, changes):
    return row_settings({"changes": group.base | changes})


def test_there_are_rungs_enough():
    assert sum(len(group.rungs) for group in GROUPS) >= 25


@pytest.mark.parametrize("group", [g for g in GROUPS if g.stage in NUMBERS and g.name != "block"], ids=lambda g: g.name)
def test_a_reference_shares_no_mesh_step_or_raster_with_any_rung(group):
    reference = settings(group, group.reference)
    for rung in group.rungs:
        same = [key for key in NUMBERS[group.stage] if settings(group, rung.changes)[key] == reference[key]]
        assert not same, (rung.factor, rung.level)


@pytest.mark.parametrize("name", (BUILT_IN[0], BUILT_IN[-1]))  # at rest, and a traverse of two media
def test_every_rung_is_a_scene_that_can_be_read_in_a_folder_of_its_own(name, tmp_path):
    jobs = jobs_of(example_path(name), GROUPS, tmp_path)
    whole = read_scene(example_path(name)).expected_shots
    for job in jobs:
        scene = read_scene(example_path(name), content=job.content)
        assert scene.seed == job.seed and scene.expected_shots <= whole * (1 + 1e-9)
    # two rungs may be the same numbers in one group (a mesh that is also the base's); runs of other numbers never share
    assert len({job.folder for job in jobs}) == len(jobs)


def test_chance_has_other_seeds_than_its_reference(tmp_path):
    (chance,) = [g for g in GROUPS if g.name == "chance"]
    jobs = jobs_of(example_path("al2024-s390"), (chance,), tmp_path)
    assert not {j.seed for j in jobs if j.rung is None} & {j.seed for j in jobs if j.rung is not None}


def test_later_scenes_of_a_set_do_without_what_is_dear(tmp_path):
    file = example_path("al2024-s110")
    whole, short = (jobs_of(file, GROUPS, tmp_path, short=s) for s in (False, True))
    names = {job.folder.name for job in short}
    assert names < {job.folder.name for job in whole}
    assert not any(n.startswith("block") for n in names) and not any("preset-reference" in n for n in names)
    # what is left can still be judged: a reference for every rung
    assert {job.group.name for job in short} == {job.group.name for job in short if job.rung is None}
