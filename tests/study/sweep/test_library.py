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
from glue.study.dimple_stage import dimple_speed, other_speeds
from glue.study.sweep.library import RATIO, libraries
from glue.target.cache import cached_folder
from glue.target.speeds import shared


def scene(**changes):
    file = example_path("al2024-s390")
    keys = {"accuracy.preset": "fast", "accuracy.dimple_speed_ratio": RATIO} | {k.replace("__", "."): v for k, v in changes.items()}
    return read_scene(file, content=changed(file.read_bytes(), keys))


@pytest.mark.parametrize("nominal", [0.7, 3.0, 42.0, 60.0, 299.0])
@pytest.mark.parametrize("points", [2, 3, 9])
def test_shared_speeds_hold_the_scenes_own(nominal, points):
    top, others = shared(nominal, 1.3 * nominal, nominal / 16, points, RATIO)
    assert nominal <= top <= RATIO * nominal and max(others) >= 1.3 * nominal
    below = [v for v in others if v < top]
    ratio = 16 ** (1 / (points - 1))
    assert below and nominal / 16 / ratio < min(below) < nominal / 16 * ratio
    assert all(top / v > ratio**0.4 for v in below)  # a slope between close neighbours would be scatter
    powers = np.log([top, *others]) / np.log(RATIO)
    assert np.allclose(powers, np.round(powers), atol=1e-6)


def test_runs_at_many_speeds_and_angles_need_one_library():
    runs = [
        (f"{k}", scene(nozzle__speed_m_s=float(v), nozzle__impact_angle_deg=float(a)))
        for k, (v, a) in enumerate(np.random.default_rng(1).uniform((40.0, 45.0), (80.0, 90.0), (200, 2)))
    ]
    (library,) = libraries(runs)
    # of 28 to 80 m/s: log(80 / 28) / log(1.05) = 21.5, and the table's three below
    assert len(library["runs"]) == 200 and 20 <= len(library["speeds_m_s"]) <= 26


def test_another_material_or_density_is_another_library_and_another_diameter_is_not():
    small = changed(example_path("al2024-s390").read_bytes(), {"shots.grade": None, "shots.diameter_m": 6e-4, "shots.density_kg_m3": 7800.0})
    other = read_scene(example_path("al2024-s390"), content=changed(small, {"accuracy.preset": "fast", "accuracy.dimple_speed_ratio": RATIO}))
    light = dataclasses.replace(other, media=(dataclasses.replace(other.media[0], density_kg_m3=2500.0),))
    found = libraries([("a", scene()), ("b", other), ("c", light), ("d", scene(target__material="steel4340"))])
    assert [library["runs"] for library in found] == [["a", "b"], ["c"], ["d"]]


def test_a_scene_that_shares_nothing_is_as_it_was():
    own = read_scene(example_path("al2024-s390"), preset="fast")
    assert dimple_speed(own) == 60.0 and other_speeds(own) == [3.75, 15.0]
    assert "dimple_speed_ratio" not in resolved_dict(own)["accuracy"]  # its runs keep their names
    assert json.dumps(resolved_dict(scene())["accuracy"]["dimple_speed_ratio"]) == "1.05"


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
