"""Our log out, in again, and run: the same coverage; a log that cannot be the scene's is refused before anything runs."""

from __future__ import annotations

import json

import numpy as np
import pytest

from glue import cli
from glue.errors import InputError
from glue.flow.impacts import read_impacts, write_impacts


def test_round_trip_gives_identical_coverage(go, tmp_path, capsys):
    out, own = go("ballistic")
    assert cli.main(["export", str(out), "--what", "log", "--unit", "mm"]) == 0
    log = tmp_path / "again.csv"
    table, column_map = out / "export" / "impacts.csv", out / "export" / "impacts_map.toml"
    assert cli.main(["import", str(table), "--map", str(column_map), "--out", str(log)]) == 0
    assert f"peen run SCENE --impacts {log}" in capsys.readouterr().out
    again, found = go("ballistic", name="again", impacts=log)
    assert (again / "coverage.csv").read_bytes() == (out / "coverage.csv").read_bytes()
    assert found["coverage"] == own["coverage"]
    assert found["flow"]["model"] == "imported" and "impacts.csv" in found["flow"]["why"]
    # what the run was made from is on record, and another log is another run
    manifest = json.loads((again / "manifest.json").read_text())
    assert len(manifest["inputs"]["imported_impacts_sha256"]) == 64
    assert "flow/arrivals.csv" not in manifest["stages"]["flow"]["outputs"]
    with pytest.raises(InputError, match="imported_impacts_sha256"):
        go("ballistic", name="again")


def test_another_log_of_the_same_scene_is_another_run(go, tmp_path):
    out, _ = go("ballistic")
    impacts, header = read_impacts(out / "flow" / "impacts.csv")
    write_impacts(tmp_path / "half.csv", impacts[::2], header)
    with pytest.raises(InputError, match="other inputs"):
        go("ballistic", impacts=tmp_path / "half.csv")
    _, found = go("ballistic", name="half", impacts=tmp_path / "half.csv")
    assert found["flow"]["impacts"] == len(impacts[::2])
    assert "shots, the scene's jet feeds" in found["flow"]["warning"]


def test_a_log_that_cannot_be_the_scenes_is_refused_with_all_that_is_wrong(go, tmp_path):
    out, _ = go("ballistic")
    impacts, header = read_impacts(out / "flow" / "impacts.csv")
    wrong = impacts.copy()
    wrong["vz_in_m_s"] *= 1000.0  # mm/s taken for m/s
    wrong["z_m"], wrong["nozzle_id"] = 0.01, 3
    write_impacts(tmp_path / "wrong.csv", wrong, header)
    with pytest.raises(InputError) as caught:
        go("ballistic", name="wrong", impacts=tmp_path / "wrong.csv")
    told = "\n".join(caught.value.problems)
    for words in ("faster than", "away from the target's surface", "nozzle_id goes to 3; allowed: 0 to 0"):
        assert words in told
    assert not (tmp_path / "wrong" / "dimple").exists()
    with pytest.raises(InputError, match="none.csv"):
        go("ballistic", name="none", impacts=tmp_path / "none.csv")


def test_a_log_in_the_wrong_units_is_refused_with_both_numbers(go, tmp_path):
    """Shots of S390 (1 mm, 7800 kg/m3) and a window of 3 mm against a log whose mm and g/cm3 were taken for SI."""
    out, _ = go("ballistic")
    impacts, header = read_impacts(out / "flow" / "impacts.csv")
    for number, (changes, words) in enumerate((
        ({"diameter_m": 1e3}, ("diameter_m is 1; allowed: 0.00095 to 0.00105 m", "is it in mm")),
        ({"density_kg_m3": 1e-3}, ("density_kg_m3 is 7.8; allowed: 7410 to 8190 kg/m3", "is it in g/cm3")),
        ({"x_m": 1e3, "y_m": 1e3}, ("none of", "reaches the window of 0.003 x 0.003 m", "mm")),
        ({"diameter_m": 1.06}, ("diameter_m is 0.00106", "is its unit in the map right?")),
    )):  # fmt: skip
        wrong = impacts.copy()
        for name, factor in changes.items():
            wrong[name] *= factor
        write_impacts(tmp_path / "units.csv", wrong, header)
        with pytest.raises(InputError) as caught:
            go("ballistic", name=f"units{number}", impacts=tmp_path / "units.csv")
        assert any(all(word in told for word in words) for told in caught.value.problems), caught.value.problems
    write_impacts(tmp_path / "none.csv", impacts[:0], header)
    with pytest.raises(InputError, match="holds no impact"):
        go("ballistic", name="none", impacts=tmp_path / "none.csv")
    worn = impacts.copy()
    worn["diameter_m"] *= 0.97
    write_impacts(tmp_path / "worn.csv", worn, header)
    go("ballistic", name="worn", impacts=tmp_path / "worn.csv")


def test_touched_points_are_put_onto_the_plane_within_a_twentieth_of_the_shot(go, tmp_path):
    out, own = go("ballistic")
    impacts, header = read_impacts(out / "flow" / "impacts.csv")
    impacts["z_m"] = np.where(np.arange(len(impacts)) % 2, 4e-5, -4e-5)  # of shots of 1 mm
    write_impacts(tmp_path / "rough.csv", impacts, header)
    again, found = go("ballistic", name="rough", impacts=tmp_path / "rough.csv")
    assert not read_impacts(again / "flow" / "impacts.csv")[0]["z_m"].any()
    assert found["coverage"] == own["coverage"]
