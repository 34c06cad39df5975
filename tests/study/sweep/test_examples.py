"""The shipped studies: each can be read, is named as its file, and makes nothing but valid scenes."""

from __future__ import annotations

import pytest

from glue.report.study_figures import STUDIES
from glue.study.sweep.library import count, libraries
from glue.study.sweep.plan import make_runs
from glue.study.sweep.study import example_studies, read_study


@pytest.mark.parametrize("name", STUDIES)
def test_every_run_of_a_shipped_study_is_a_valid_scene(name):
    study = read_study(name)
    runs = make_runs(study)
    assert study.name == name and study.accuracy == "fast" and study.replicates >= 3
    assert [run.cause for run in runs if run.cause] == []
    assert 9 <= len(runs) <= 40 and len({run.seed for run in runs}) == len(runs)
    shots = [run.scene.expected_shots for run in runs]
    assert max(shots) < 25_000  # seconds of the event-driven model
    (library,) = libraries([(run.name, run.scene) for run in runs], "target" in study.stages)  # one material: one set of impacts
    assert count([library]) <= 18


def test_every_shipped_study_of_one_factor_has_figures():
    assert sorted(STUDIES) == sorted(set(example_studies()) - {"coverage-lhs"})
