"""What the target cannot take is told before anything runs, and a log that is not the scene's own is not used."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.arrivals import scene_hash
from glue.flow.impacts import COLUMNS, write_impacts
from glue.scene.model import Choice
from glue.scene.reader import example_path, read_scene
from glue.study import target_stage
from glue.study.check import check
from glue.study.results import load_impacts
from glue.study.target_stage import expected_work, refuse_target
from glue.target.contact import SECONDS_PER_IMPACT


def scene(model: str, exposure_time_s: float = 3.0, patches: int = 1):
    """The default scene: 5.2 hits per point in 3 s."""
    plain = read_scene(example_path("al2024-s390"))
    return dataclasses.replace(
        plain, exposure_time_s=exposure_time_s, models=dataclasses.replace(plain.models, target=Choice(model, "test")),
        accuracy=dataclasses.replace(plain.accuracy, target_patches=patches),
    )  # fmt: skip


def test_the_log_of_another_scene_is_refused(tmp_path):
    log = np.zeros(1, COLUMNS)
    log["vz_in_m_s"], log["nz"] = -60.0, 1.0
    mine = scene("cell")
    write_impacts(tmp_path / "flow" / "impacts.csv", log, {"scene_hash": scene_hash(mine)})
    assert len(load_impacts(tmp_path, mine)) == 1
    with pytest.raises(InputError, match=r"impacts\.csv: is the log of another scene .* peen flow"):
        load_impacts(tmp_path, dataclasses.replace(mine, seed=2))


def test_expected_work_counts_the_impacts_of_every_patch():
    """Twice the exposure, twice the impacts; three patches, three times the time; a block's patch is (5.5/4.8)^2 cells."""
    one, twice = expected_work(scene("cell")), expected_work(scene("cell", 6.0, 3))
    assert twice["impacts"] == pytest.approx(2 * one["impacts"])
    assert twice["seconds"] == pytest.approx(6 * one["seconds"])
    block = expected_work(scene("contact"))
    assert block["impacts"] / one["impacts"] == pytest.approx((5.5 / 4.8) ** 2)
    assert block["memory_GB"] > 1 and one["memory_GB"] is None


def test_more_impacts_than_two_days_take_are_refused_before_anything_runs(tmp_path):
    """50 impacts in 3 s; half of their estimated time is held against a day."""
    refuse_target(scene("contact", 600.0), tmp_path)
    fits = int(2 * 24 * 3600 / SECONDS_PER_IMPACT)
    with pytest.raises(InputError, match=rf"target = contact: \d+ impacts in the patch would take about \d+ h .* some {fits} impacts"):
        refuse_target(scene("contact", 3000.0), tmp_path)


def test_more_memory_than_there_is_is_refused_before_anything_runs(tmp_path, monkeypatch):
    refuse_target(scene("cell"), tmp_path)
    monkeypatch.setattr(target_stage, "available_GB", lambda: 0.5)
    refuse_target(scene("cell"), tmp_path)
    with pytest.raises(InputError, match=r'needs about [\d.]+ GB; allowed: 0\.5 GB.* target = "cell"'):
        refuse_target(scene("contact"), tmp_path)


@pytest.mark.parametrize(
    ("asked", "says"),
    [(("layers", 6.0), "hits per point are expected, calibrated"), (("layers", 30.0), "and refused beyond 24"),
     (("layers", 3.0, 2), "target_patches has no effect"), (("contact", 120.0), "impacts will take about")],
)  # fmt: skip
def test_check_warns_of_what_a_model_will_not_do_well(asked, says):
    (warning,) = check(scene(*asked))["warnings"]
    assert says in warning
    assert not check(scene(asked[0]))["warnings"]
