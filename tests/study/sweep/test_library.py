"""One library of dimples for all runs of a study: which speeds, for whom; one process solves, the others wait."""

from __future__ import annotations

import dataclasses
import json
import threading
import time

import numpy as np
import pytest

from glue.scene.derive import changed
from glue.scene.reader import example_path, read_scene, resolved_dict
from glue.study.dimple_stage import fastest_speed, impact_density, impact_speeds, layer_speeds, other_speeds
from glue.study.sweep.library import count, libraries
from glue.study.sweep.plan import make_runs
from glue.study.sweep.study import read_study
from glue.target.between import RATIO
from glue.target.cache import cached_folder


def scene(**changes):
    file = example_path("al2024-s390")
    keys = {"accuracy.preset": "fast", "accuracy.dimple_speed_ratio": RATIO} | {k.replace("__", "."): v for k, v in changes.items()}
    return read_scene(file, content=changed(file.read_bytes(), keys))


@pytest.mark.parametrize("nominal", [0.7, 3.0, 42.0, 60.0, 240.0])
def test_shared_speeds_enclose_the_scene_s_own(nominal):
    own = scene(nozzle__speed_m_s=nominal)
    speeds = np.array(impact_speeds(own))
    assert speeds[0] <= nominal / 16 and speeds[-1] >= fastest_speed(own) and (speeds >= nominal / 16).sum() >= speeds.size - 1
    powers = np.log(speeds) / np.log(RATIO)
    assert np.allclose(powers, np.round(powers), atol=1e-6) and (np.diff(powers) < 1.5).all()
    low, high = layer_speeds(own)
    assert low < nominal < high and impact_density(own) == 7800.0


def test_runs_at_many_speeds_and_angles_need_one_library():
    runs = [
        (f"{k}", scene(nozzle__speed_m_s=float(v), nozzle__impact_angle_deg=float(a)))
        for k, (v, a) in enumerate(np.random.default_rng(1).uniform((40.0, 45.0), (80.0, 90.0), (200, 2)))
    ]
    (library,) = libraries(runs, target=True)
    # dimples of 28/16 to 80 m/s: log2(80 / 1.8) x 2 = 11 and the ends; layers of 28 to 80 m/s: log2(80 / 28) x 2 = 3 and the ends
    assert len(library["runs"]) == 200 and len(library["speeds_m_s"]) == 13 and len(library["layer_speeds_m_s"]) == 5
    assert count([library]) == 18 and count(libraries(runs, target=False)) == 13


def test_another_material_is_another_library_and_another_shot_is_not():
    small = changed(example_path("al2024-s390").read_bytes(), {"shots.grade": None, "shots.diameter_m": 6e-4, "shots.density_kg_m3": 7800.0})
    other = read_scene(example_path("al2024-s390"), content=changed(small, {"accuracy.preset": "fast", "accuracy.dimple_speed_ratio": RATIO}))
    light = dataclasses.replace(other, media=(dataclasses.replace(other.media[0], density_kg_m3=2500.0),))
    found = libraries([("a", scene()), ("b", other), ("c", light), ("d", scene(target__material="steel4340"))], target=False)
    assert [library["runs"] for library in found] == [["a", "b", "c"], ["d"]]
    assert impact_speeds(light)[0] < impact_speeds(other)[0]  # as a slower shot of steel


def test_a_scene_that_shares_nothing_is_as_it_was():
    own = read_scene(example_path("al2024-s390"), preset="fast")
    assert impact_speeds(own) == [3.75, 15.0, 60.0] and other_speeds(own) == [3.75, 15.0]
    assert layer_speeds(own) == [60.0] and impact_density(own) == own.media[0].density_kg_m3
    assert "dimple_speed_ratio" not in resolved_dict(own)["accuracy"]  # its runs keep their names
    assert json.loads(json.dumps(resolved_dict(scene())["accuracy"]["dimple_speed_ratio"])) == RATIO


@pytest.mark.parametrize(("speeds", "library", "shared"), [
    ([60.0], "auto", False), ([60.0], "shared", True),  # one speed: 3 impacts of its own against 10
    ([30.0, 40.0, 50.0, 60.0, 70.0, 80.0], "auto", True), ([30.0, 80.0], "own", False),  # six: 18 against 13
])  # fmt: skip
def test_impacts_are_shared_where_that_takes_fewer(tmp_path, speeds, library, shared):
    text = f'schema = 1\nname = "s"\nscene = "al2024-s390"\naccuracy = "fast"\nlibrary = "{library}"\n[design]\nkind = "grid"\n'
    (tmp_path / "s.toml").write_text(text + f'[[axis]]\nkey = "nozzle.speed_m_s"\nvalues = {speeds}\n')
    runs = make_runs(read_study(tmp_path / "s.toml"))
    assert {bool(run.scene.accuracy.dimple_speed_ratio) for run in runs} == {shared}


def test_two_that_want_the_same_at_a_time_make_it_once(tmp_path, monkeypatch):
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path))
    made = []

    def make(folder):
        made.append(folder)
        time.sleep(0.3)
        (folder / "result").write_text("it")

    found = []
    threads = [threading.Thread(target=lambda: found.append(cached_folder("kind", "key", make))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1 and sorted(hit for _, hit in found) == [False, True, True, True]
    assert [p.name for p in (tmp_path / "kind").iterdir()] == ["key"]  # no lock is left
