"""A whole run, small but real: both solvers, every stage, twice."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from glue import cli

pytestmark = pytest.mark.solver

# A narrow, dense jet: 122 shots on 28 mm2, so that 0.03 s give a few impacts per dimple area.
SCENE = """
schema = 1
name = "small"
seed = 3
exposure_time_s = 0.03
[shots]
grade = "S390"
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = 0.01667
jet_diameter_m = 0.006
stand_off_m = 0.02
impact_angle_deg = 90.0
[target]
material = "al2024-t351"
window_m = [0.002, 0.002]
[restitution]
shot_target = "from_dimple"
[models]
flow = "dem"
target = "cell"
[accuracy]
preset = "fast"
"""

# The keys of metrics.json that others rely on.
SCHEMA = {
    "flow": {"model", "collision_number", "impacts", "mean_normal_speed_m_s", "collided_fraction", "wall_s"},
    "dimple": {
        "radius_m",
        "depth_m",
        "crest_radius_m",
        "restitution",
        "peak_force_N",
        "contact_time_s",
        "speed_m_s",
        "wall_s",
    },
    "coverage": {"final", "time_98_s", "avrami_final", "avrami_time_98_s", "impacts_in_window", "peeq_final"},
    "residual_stress": {"surface_Pa", "max_compressive_Pa", "max_compressive_depth_m", "compressive_depth_m"},
    "roughness": {"Sa_m", "Sq_m", "Sz_m", "Ssk", "Sku", "levelling", "filter"},
    "target": {"model", "impacts", "dofs", "wall_s"},
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two run directories of the same scene, the second with an empty cache of its own."""
    folder = tmp_path_factory.mktemp("end to end")  # spaces in paths are allowed
    (folder / "small.toml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch:
        for name in ("one", "two"):
            patch.setenv("PEEN_CACHE", str(folder / f"cache {name}"))
            assert cli.main(["run", str(folder / "small.toml"), "--out", str(folder / name)]) == 0
    return folder / "one", folder / "two"


def test_layers_stand_in_for_the_cell(runs, tmp_path, monkeypatch):
    """Same scene, event-driven: the layer model's stress is that of the cell within the scatter of a few impacts."""
    monkeypatch.setenv("PEEN_CACHE", str(runs[0].parent / "cache one"))
    (tmp_path / "layers.toml").write_text(SCENE.replace('"cell"', '"layers"').replace('"dem"', '"event"'))
    run = tmp_path / "run"
    assert cli.main(["run", str(tmp_path / "layers.toml"), "--out", str(run), "--only", "target"]) == 0
    found = metrics(run)
    assert found["target"]["model"] == "layers" and found["target"]["dofs_reason"]
    with open(run / "stress_profile.csv") as f:
        columns = next(csv.reader(f))
    assert columns == ["depth_m", "sigma_xx_Pa", "sigma_yy_Pa", "peeq"]
    cell = metrics(runs[0])["residual_stress"]["max_compressive_Pa"]
    assert found["residual_stress"]["max_compressive_Pa"] == pytest.approx(cell, rel=0.25)


def metrics(run):
    return json.loads((run / "metrics.json").read_text())


def test_every_value_is_there_or_says_why_not(runs):
    found = metrics(runs[0])
    for section, keys in SCHEMA.items():
        assert keys <= found[section].keys()
        missing = {k for k, v in found[section].items() if v is None}
        assert all(found[section][f"{k}_reason"] for k in missing)


def test_same_scene_and_seed_give_the_same_metrics_apart_from_times(runs):
    one, two = (metrics(run) for run in runs)
    for found in (one, two):
        for section in SCHEMA:
            found[section].pop("wall_s", None)
    assert one == two


def test_the_stages_agree_with_each_other(runs):
    run, found = runs[0], metrics(runs[0])
    with open(run / "coverage.csv") as f:
        curve = list(csv.DictReader(f))
    assert curve[0].keys() == {"time_s", "coverage", "avrami"}
    assert float(curve[-1]["coverage"]) == found["coverage"]["final"]
    with np.load(run / "surface.npz") as surface:
        assert surface["z_m"].shape == (surface["y_m"].size, surface["x_m"].size)
        h = surface["z_m"]
        # Levelling takes a plane out; what is left varies by no more than the heights themselves.
        assert 0 < found["roughness"]["Sq_m"] <= h.std()
    # The dimple of 1 mm steel at 60 m/s on this alloy: .227 mm and .34 (two independent codes), fast mesh.
    assert found["dimple"]["radius_m"] == pytest.approx(0.227e-3, rel=0.02)
    assert found["dimple"]["restitution"] == pytest.approx(0.34, abs=0.02)
    assert found["residual_stress"]["max_compressive_Pa"] < -100e6


def test_the_manifest_says_how_each_stage_came_about(runs):
    manifest = json.loads((runs[0] / "manifest.json").read_text())
    assert list(manifest["stages"]) == ["dimple", "flow", "coverage", "target", "surface", "intensity", "uncertainty", "report"]
    programs = {
        name: [p["program"] for p in record["processes"]] for name, record in manifest["stages"].items()
    }
    assert programs["flow"] == ["yade"] and programs["target"] == ["FreeFem++"]
    assert set(programs["dimple"]) == {"FreeFem++"}
    for name, record in manifest["stages"].items():
        assert record["exit_code"] == 0 and record["peak_memory_bytes"] > 1e6
        assert record["inputs"]["code"], f"{name} names no source"
    assert "freefem/cell.edp" in manifest["stages"]["target"]["inputs"]["code"]
    assert "yade_scripts/shot_flow.py" in manifest["stages"]["flow"]["inputs"]["code"]


def test_a_second_command_runs_nothing(runs, capsys, monkeypatch, tmp_path):
    before = (runs[0] / "manifest.json").read_bytes()
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path))
    assert cli.main(["run", str(runs[0] / "scene.toml"), "--out", str(runs[0])]) == 0
    assert capsys.readouterr().err.count("up to date") == 8
    assert (runs[0] / "manifest.json").read_bytes() == before


def test_figures_and_report_are_written(runs):
    pictures = sorted(p.name for p in (runs[0] / "figures").iterdir())
    assert len(pictures) == 5 and all(p.endswith(".png") for p in pictures)
    assert (runs[0] / "report.html").read_text().count("<img ") == 5
