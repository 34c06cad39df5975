"""The study's file: every mistake at once, in words; what its axes and designs mean."""

from __future__ import annotations

import numpy as np
import pytest

from glue.errors import InputError
from glue.study.sweep.design import points, remarks, run_seed
from glue.study.sweep.study import example_studies, read_study

HEAD = 'schema = 1\nname = "s"\nscene = "al2024-s390"\n'


def study(tmp_path, text):
    file = tmp_path / "study.toml"
    file.write_text(text)
    return read_study(file)


def problems(tmp_path, text):
    with pytest.raises(InputError) as caught:
        study(tmp_path, text)
    return caught.value.problems


def test_every_mistake_is_told_at_once(tmp_path):
    told = problems(
        tmp_path,
        'schema = 1\nname = "s"\nscene = "al2024-s391"\naccurracy = "fast"\nstages = ["coverages"]\n'
        '[set]\nseed = 3\n[design]\nkind = "lsh"\nreplicates = 0\n'
        '[[axis]]\nkey = "nozzle.speed_m_s"\nrange = [60, 40]\n'
        '[[axis]]\nkeys = ["a.b", "a.c"]\nvalues = [[1, 2], [3]]\n',
    )
    text = "\n".join(told)
    for words in (
        'accurracy: unknown key; did you mean "accuracy"?', '"al2024-s391": no such file', 'did you mean "coverage"?',
        'seed: "seed" is the scene\'s own', 'did you mean "lhs"?', "design.replicates: 0 is out of range; allowed 1..10000",
        "axis[1].range: must rise", "axis[2].values: with keys = [...] either plain values or arrays of 2",
    ):  # fmt: skip
        assert words in text
    assert len(told) == 8


@pytest.mark.parametrize(
    "axis, words",
    [
        ('key = "a.b"', "either values = [...] or range"),
        ('key = "a.b"\nvalues = [1]\nrange = [1, 2]', "either values = [...] or range"),
        ('key = "a.b"\nrange = [1, 2]', "points: missing, and required"),
        ('key = "a.b"\nrange = [0, 2]\npoints = 3\nspacing = "log"', "needs numbers above 0"),
        ('key = "a.b"\nvalues = [nan]', "is no value of a scene's key"),
        ('key = "a.b"\nvalues = []', "an empty one"),
        ('key = "seed"\nvalues = [1]', "seeds are the replicates'"),
        ('key = "a.b"\nvalues = [1]\nfactors = [2]', "beside keys"),
        ('key = "a b"\nvalues = [1]', "the path of a key"),
        ('key = "a.b"\nvalues = [1]\npoints = 3', "belongs to a range"),
    ],
)
def test_an_axis_that_means_nothing_is_refused(tmp_path, axis, words):
    assert words in "\n".join(problems(tmp_path, f'{HEAD}[design]\nkind = "grid"\n[[axis]]\n{axis}\n'))


def test_a_key_changed_twice_is_refused(tmp_path):
    two = '[[axis]]\nkey = "a.b"\nvalues = [1]\n' * 2
    assert "is changed by axis[1] already" in "\n".join(problems(tmp_path, f'{HEAD}[design]\nkind = "grid"\n{two}'))
    told = problems(tmp_path, f'{HEAD}[set]\na.b = 2\n[design]\nkind = "grid"\n[[axis]]\nkey = "a.b"\nvalues = [1]\n')
    assert "is changed by an axis too" in "\n".join(told)


def test_a_key_that_the_scene_does_not_have_cannot_be_removed(tmp_path):
    text = 'remove = {}\n[design]\nkind = "grid"\n[[axis]]\nkey = "nozzle.speed_m_s"\nvalues = [1]\n'
    (told,) = problems(tmp_path, HEAD + text.format('["shots.grad", "target.material", "nozzle"]'))
    assert 'remove: the scene has no "shots.grad"; did you mean "shots.grade"?' in told
    assert study(tmp_path, HEAD + text.format('["shots.grade"]')).changes == {"shots.grade": None}


def test_a_range_of_a_whole_number_is_rounded(tmp_path):
    axis = '[[axis]]\nkey = "nozzle.passes"\nrange = [1, 10]\n'
    grid = points(study(tmp_path, f'{HEAD}[design]\nkind = "grid"\n{axis}points = 4\nspacing = "log"\n'))
    assert [repr(p["nozzle.passes"]) for p in grid] == ["1", "2", "5", "10"]  # of 1, 2.15, 4.64, 10
    found = [p["nozzle.passes"] for p in points(study(tmp_path, f'{HEAD}[design]\nkind = "lhs"\nsamples = 20\n{axis}'))]
    assert all(isinstance(value, int) for value in found) and set(found) == set(range(1, 11))
    text = f'{HEAD}[design]\nkind = "grid"\n{axis}points = 12\n'
    assert "12 steps give a whole number twice" in "\n".join(problems(tmp_path, text))


def test_a_grid_is_every_combination_and_its_last_axis_changes_fastest(tmp_path):
    found = points(
        study(
            tmp_path,
            HEAD + '[design]\nkind = "grid"\n[[axis]]\nkey = "shots.grade"\nvalues = ["S230", "S390"]\n'
            '[[axis]]\nkey = "nozzle.speed_m_s"\nrange = [20, 80]\npoints = 3\nspacing = "log"\n',
        )
    )
    assert [p["shots.grade"] for p in found] == ["S230"] * 3 + ["S390"] * 3
    assert [p["nozzle.speed_m_s"] for p in found[:3]] == [20.0, 40.0, 80.0]


def test_keys_change_together_alike_by_factors_or_each_by_its_own(tmp_path):
    axes = (
        '[[axis]]\nkeys = ["a.x", "a.y"]\nvalues = [3]\n',
        '[[axis]]\nkeys = ["b.x", "b.y"]\nfactors = [1, 100]\nvalues = [0.5]\n',
        '[[axis]]\nkeys = ["c.x", "c.y"]\nvalues = [["S230", 7]]\n',
        '[[axis]]\nkey = "d.window_m"\nvalues = [[1e-3, 2e-3]]\n',
    )
    (only,) = points(study(tmp_path, HEAD + '[design]\nkind = "grid"\n' + "".join(axes)))
    assert only == {
        "a.x": 3, "a.y": 3, "b.x": 0.5, "b.y": 50.0, "c.x": "S230", "c.y": 7, "d.window_m": [1e-3, 2e-3],
    }  # fmt: skip


RANGES = (
    '[[axis]]\nkey = "nozzle.speed_m_s"\nrange = [40, 80]\n'
    '[[axis]]\nkey = "nozzle.mass_flow_kg_s"\nrange = [0.001, 0.1]\nspacing = "log"\n'
    '[[axis]]\nkey = "shots.grade"\nvalues = ["S110", "S230"]\n'
)


@pytest.mark.parametrize("kind", ["lhs", "sobol"])
def test_sampled_points_fill_every_axis_evenly(tmp_path, kind):
    """A Latin hypercube and 16 Sobol points: each 16th of an axis holds one point; of a listed value its equal share."""
    found = points(study(tmp_path, f'{HEAD}[design]\nkind = "{kind}"\nsamples = 16\nseed = 5\n{RANGES}'))
    speed = np.sort([(p["nozzle.speed_m_s"] - 40.0) / 40.0 for p in found])
    flow = np.sort([np.log10(p["nozzle.mass_flow_kg_s"] / 0.001) / 2.0 for p in found])
    for share in (speed, flow):
        assert np.floor(share * 16).astype(int).tolist() == list(range(16))
    assert sorted(p["shots.grade"] for p in found) == ["S110"] * 8 + ["S230"] * 8


def test_the_same_seed_gives_the_same_design_and_another_another(tmp_path):
    text = f'{HEAD}[design]\nkind = "lhs"\nsamples = 5\nseed = {{}}\n{RANGES}'
    assert points(study(tmp_path, text.format(1))) == points(study(tmp_path, text.format(1)))
    assert points(study(tmp_path, text.format(1))) != points(study(tmp_path, text.format(2)))


def test_sobol_says_in_words_which_numbers_fill_evenly(tmp_path):
    text = f'{HEAD}[design]\nkind = "sobol"\nsamples = {{}}\n{RANGES}'
    assert "128 or 256 would" in remarks(study(tmp_path, text.format(200)))[0]
    assert remarks(study(tmp_path, text.format(256))) == []


def test_every_run_has_shots_of_its_own_unless_they_are_shared(tmp_path):
    own = study(tmp_path, f'{HEAD}[design]\nkind = "lhs"\nsamples = 5\n{RANGES}')
    seeds = {run_seed(own, 1, point, replicate) for point in range(100) for replicate in range(3)}
    assert len(seeds) == 300 and all(0 <= seed < 2**32 for seed in seeds)
    shared = study(tmp_path, f'{HEAD}[design]\nkind = "lhs"\nsamples = 5\nseeds = "shared"\n{RANGES}')
    assert {run_seed(shared, 7, point, 1) for point in range(5)} == {8}


@pytest.mark.parametrize("name", example_studies())
def test_shipped_studies_can_be_read(name):
    assert read_study(name).name == name
