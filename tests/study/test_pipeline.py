"""The engine with stub stages: what runs, what is skipped, what is left behind when something stops."""

from __future__ import annotations

import dataclasses
import json
import os
import sys
import threading
from pathlib import Path

import pytest

from glue.errors import InputError, NotConverged, SolverFailed
from glue.scene.reader import example_path, read_scene
from glue.solvers import process
from glue.study import pipeline
from glue.study.check import check
from glue.study.stage import Stage


def manifest(out):
    return json.loads((out / "manifest.json").read_text())


def test_runs_every_stage_once_and_none_the_second_time(stubs, tmp_path):
    out = tmp_path / "run"
    assert stubs.go(out) == ["a", "b", "c", "d"]
    first = (out / "metrics.json").read_bytes()
    assert stubs.go(out) == []
    assert (out / "metrics.json").read_bytes() == first
    assert json.loads(first) == {
        "schema": 1,
        "a": {"value": 1},
        "b": {"value": 2},
        "c": {"value": 3},
        "d": {"value": 1},
    }


def test_the_manifest_tells_what_was_done(stubs, tmp_path):
    stubs.go(tmp_path / "run", preset="fast")
    found = manifest(tmp_path / "run")
    assert (found["seed"], found["preset_argument"], found["inputs"]["accuracy"]["preset"]) == (
        1,
        "fast",
        "fast",
    )
    assert found["choices"]["flow"]["model"] == "dem" and "tolerance" in found["choices"]["flow"]["why"]
    record = found["stages"]["b"]
    assert (record["state"], record["exit_code"]) == ("complete", 0)
    assert record["wall_s"] >= 0 and record["peak_memory_bytes"] > 1e6
    assert record["versions"]["freefem"].keys() == {"binary", "package"}
    assert list(record["outputs"]) == ["b.txt"] and len(record["outputs"]["b.txt"]) == 64


def test_only_brings_what_is_needed_up_to_date(stubs, tmp_path):
    assert stubs.go(tmp_path / "run", only=["b"]) == ["a", "b"]
    assert json.loads((tmp_path / "run" / "metrics.json").read_text()).keys() == {"schema", "a", "b"}
    assert stubs.go(tmp_path / "run", only=["c"]) == ["c"]
    with pytest.raises(InputError, match="no stage e; allowed: a, b, c, d"):
        stubs.go(tmp_path / "run", only=["e"])


@pytest.mark.parametrize(("kind", "code"), [(SolverFailed, 3), (NotConverged, 4)])
def test_a_failure_stops_the_run_and_the_next_goes_on_from_there(stubs, tmp_path, kind, code):
    out = tmp_path / "run"
    stubs.fail["b"] = kind("the solver stopped", cause="stub")
    with pytest.raises(kind) as caught:
        stubs.go(out)
    assert str(out) in caught.value.__notes__[0]
    assert stubs.ran == ["a", "b"]
    record = manifest(out)["stages"]["b"]
    assert (record["state"], record["exit_code"]) == ("failed", code) and "stub" in record["error"]
    assert (out / "b.half").exists()  # kept for whoever looks into it, gone with the next try
    stubs.fail.clear()
    assert stubs.go(out) == ["b", "c", "d"]
    assert not (out / "b.half").exists()


def test_a_failure_takes_what_was_built_on_the_stage_out_of_the_metrics(stubs, tmp_path):
    out = tmp_path / "run"
    stubs.go(out)
    (out / "b.txt").unlink()
    stubs.fail["b"] = SolverFailed("stub")
    with pytest.raises(SolverFailed):
        stubs.go(out)
    assert json.loads((out / "metrics.json").read_text()) == {"schema": 1, "a": {"value": 1}}


def test_an_interrupted_stage_is_run_again_and_nothing_before_it(stubs, tmp_path):
    out = tmp_path / "run"
    stubs.fail["c"] = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        stubs.go(out)
    assert {n: r["state"] for n, r in manifest(out)["stages"].items()} == {
        "a": "complete", "b": "complete", "c": "started",
    }  # fmt: skip
    stubs.fail.clear()
    assert stubs.go(out) == ["c", "d"]
    assert not (out / "c.half").exists()


def test_other_results_upstream_make_the_rest_run_again(stubs, tmp_path):
    out = tmp_path / "run"
    stubs.go(out)
    (out / "b.txt").write_text("damaged")
    stubs.salt["b"] = "new"
    assert stubs.go(out) == ["b", "c", "d"]
    assert (out / "c.txt").read_text() == "cbnewa"


def test_a_file_that_vanished_is_made_again(stubs, tmp_path):
    stubs.go(tmp_path / "run")
    (tmp_path / "run" / "a.txt").unlink()
    assert stubs.go(tmp_path / "run") == ["a"]  # it comes out the same, so that what was built on it stands
    assert stubs.go(tmp_path / "run") == []


def test_changed_sources_make_a_stage_run_again(stubs, tmp_path, monkeypatch):
    source = tmp_path / "checkout" / "job.edp"
    source.parent.mkdir()
    source.write_text("one")
    stubs.go(tmp_path / "run")
    a = stubs.stages[0]
    stubs.stages = (Stage(a.name, a.needs, ("job.edp",), a.owns, a.run), *stubs.stages[1:])
    monkeypatch.setattr(pipeline.solvers, "repo_root", lambda: source.parent)
    assert stubs.go(tmp_path / "run") == ["a"]
    assert stubs.go(tmp_path / "run") == []
    source.write_text("two")
    assert stubs.go(tmp_path / "run") == ["a"]
    source.write_text("three")
    stubs.salt["a"] = "!"
    assert stubs.go(tmp_path / "run") == ["a", "b", "c", "d"]


def versions(**found):
    return lambda: {name: {"binary": found.get(name, "1.0")} for name in ("yade", "freefem")}


def test_a_missing_solver_costs_no_result(stubs, tmp_path, monkeypatch):
    out = tmp_path / "run"
    stubs.stages = (*stubs.stages[:1], stubs._stage("b", ("a",), solvers=("yade",)), *stubs.stages[2:])
    monkeypatch.setattr(pipeline.solvers, "versions", versions())
    monkeypatch.setattr(pipeline.solvers, "find_yade", lambda: Path("yade"))
    stubs.go(out)
    before = {p.name: p.read_bytes() for p in out.iterdir()}

    def missing():
        raise SolverFailed("YADE was not found")

    monkeypatch.setattr(pipeline.solvers, "find_yade", missing)
    monkeypatch.setattr(pipeline.solvers, "versions", versions(yade=None))
    for only in (["c"], ["b"], []):
        with pytest.raises(SolverFailed, match="YADE was not found"):
            stubs.go(out, only=only)
        assert stubs.ran == []
    assert {p.name: p.read_bytes() for p in out.iterdir()} == before
    with pytest.raises(SolverFailed, match="YADE was not found"):  # a first run: before the stages ahead of it
        stubs.go(tmp_path / "new")
    assert stubs.ran == []
    assert stubs.go(out, only=["d"]) == [] and stubs.go(tmp_path / "other", only=["a"]) == ["a"]


def test_a_stage_that_may_turn_out_stale_needs_its_solver_too(stubs, tmp_path, monkeypatch):
    out = tmp_path / "run"
    stubs.stages = (*stubs.stages[:1], stubs._stage("b", ("a",), solvers=("yade",)), *stubs.stages[2:])
    monkeypatch.setattr(pipeline.solvers, "find_yade", lambda: Path("yade"))
    stubs.go(out)
    (out / "a.txt").unlink()

    def missing():
        raise SolverFailed("YADE was not found")

    monkeypatch.setattr(pipeline.solvers, "find_yade", missing)
    with pytest.raises(SolverFailed):
        stubs.go(out)
    assert stubs.ran == [] and (out / "b.txt").exists()


def test_only_the_solver_that_a_stage_runs_makes_it_stale(stubs, tmp_path, monkeypatch):
    out = tmp_path / "run"
    stubs.stages = (*stubs.stages[:1], stubs._stage("b", ("a",), solvers=("freefem",)), *stubs.stages[2:])
    monkeypatch.setattr(pipeline.solvers, "find_freefem", lambda: Path("FreeFem++"))
    monkeypatch.setattr(pipeline.solvers, "versions", versions())
    stubs.go(out)
    monkeypatch.setattr(pipeline.solvers, "versions", versions(yade="2.0"))
    assert stubs.go(out) == []
    monkeypatch.setattr(pipeline.solvers, "versions", versions(freefem="2.0"))
    assert stubs.go(out) == ["b"]


def test_the_real_stages_name_their_solvers():
    from glue.study.stages import STAGES

    def of(name):
        scene = read_scene(example_path(name))
        return {s.name: s.runs(scene, Path("none")) for s in STAGES}

    others = {"dimple": ("freefem",), "coverage": (), "target": ("freefem",), "surface": (), "intensity": (), "uncertainty": (), "report": ()}
    assert of("al2024-s390") == others | {"flow": ("yade",)}
    assert of("mixed-s230-s390-traverse") == others | {"flow": ()}  # event-driven: no YADE needed


def test_another_preset_is_another_run(stubs, tmp_path):
    stubs.go(tmp_path / "run")
    with pytest.raises(InputError, match='accuracy.preset: there "balanced", here "fast"'):
        stubs.go(tmp_path / "run", preset="fast")
    assert stubs.ran == []


def test_a_stage_of_an_existing_run(stubs, tmp_path):
    out = tmp_path / "run"
    stubs.go(out, only=["a"], preset="fast")
    stubs.ran.clear()
    pipeline.rerun(out, ["c"], lambda *told: None, stubs.stages)
    assert stubs.ran == ["b", "c"]
    (out / "scene.toml").write_text((out / "scene.toml").read_text().replace("60.0", "61.0"))
    with pytest.raises(InputError, match="was changed after the run was made"):
        pipeline.rerun(out, ["c"], lambda *told: None, stubs.stages)


def test_default_directory_is_named_after_scene_and_inputs(stubs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stubs.go(None)
    stubs.go(None, preset="fast")
    names = sorted(p.name for p in Path("runs").iterdir())
    assert len(names) == 2 and all(n.startswith("al2024-s390-") and len(n) == 12 + 8 for n in names)


def test_a_scene_may_come_through_a_pipe(stubs, tmp_path):
    """``peen run <(…)``: the content can be read only once."""
    content = example_path("al2024-s390").read_bytes()
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(content,))
    writer.start()
    pipeline.run(str(pipe), tmp_path / "run", stages=stubs.stages)
    writer.join()
    assert (tmp_path / "run" / "scene.toml").read_bytes() == content


@pytest.mark.parametrize("content", ["", "{", '{"schema": 1, "a": {"value": 99}}'])
def test_damaged_metrics_are_written_anew(stubs, tmp_path, content):
    out = tmp_path / "run"
    stubs.go(out)
    good = (out / "metrics.json").read_bytes()
    (out / "metrics.json").write_text(content)
    assert stubs.go(out) == [] and (out / "metrics.json").read_bytes() == good
    (out / "metrics.json").write_text(content)
    pipeline.rerun(out, ["d"], lambda *told: None, stubs.stages)
    assert (out / "metrics.json").read_bytes() == good


@pytest.mark.parametrize("damage", [lambda p: p.unlink(), lambda p: p.write_text("half")])
def test_a_report_of_damaged_files_is_refused_until_they_are_made_again(stubs, tmp_path, damage):
    out = tmp_path / "run"
    stubs.go(out)
    damage(out / "b.txt")
    stubs.ran.clear()
    with pytest.raises(InputError, match=r"b\.txt: is gone or not what stage b wrote; run `peen run` again"):
        pipeline.rerun(out, ["d"], lambda *told: None, stubs.stages)
    assert stubs.ran == [] and (out / "d.txt").exists()
    assert stubs.go(out) == ["b"]
    pipeline.rerun(out, ["d"], lambda *told: None, stubs.stages)


def test_a_run_without_its_scene_says_what_restores_it(stubs, tmp_path):
    out = tmp_path / "run"
    stubs.go(out)
    (out / "scene.toml").unlink()
    with pytest.raises(InputError, match=r"scene\.toml: is gone; peen run SCENE --out"):
        pipeline.rerun(out, ["c"], lambda *told: None, stubs.stages)
    assert stubs.go(out) == []
    pipeline.rerun(out, ["c"], lambda *told: None, stubs.stages)


def test_a_directory_whose_name_is_not_utf_8(tmp_path):
    """The log's first line names it, byte for byte."""
    out = tmp_path / os.fsdecode(b"bad\xff")

    def run(work):
        process.run([sys.executable, "-c", "print(1)"], cwd=work.path, log=work.path / "log", env=os.environ)
        return {}, ["log"]

    pipeline.run("al2024-s390", out, stages=(Stage("a", (), (), ("log",), run),))
    assert b"bad\xff" in (out / "log").read_bytes().splitlines()[0]
    assert manifest(out)["stages"]["a"]["state"] == "complete"


def test_a_scene_that_a_later_stage_refuses_costs_no_time(stubs, tmp_path):
    def refuse(scene, scene_file):
        assert scene_file == tmp_path / "run" / "scene.toml"
        raise InputError(f"{scene.name}: too dense")

    stubs.stages = (*stubs.stages[:1], dataclasses.replace(stubs.stages[1], refuse=refuse), *stubs.stages[2:])
    with pytest.raises(InputError, match="al2024-s390: too dense"):
        stubs.go(tmp_path / "run")
    assert stubs.ran == []
    assert stubs.go(tmp_path / "run", only=["a"]) == ["a"]


def test_check_and_run_refuse_a_stream_that_cannot_be_drawn(tmp_path):
    """A jet one shot wide: the share of its volume says nothing, drawing does."""
    scene = read_scene(example_path("al2024-s390"))
    dense = dataclasses.replace(scene, nozzles=(dataclasses.replace(scene.nozzle, jet_diameter_m=1e-3),))
    with pytest.raises(InputError, match="too dense"):
        check(dense)
    from glue.study.stages import STAGES

    with pytest.raises(InputError, match="too dense"):
        next(s for s in STAGES if s.name == "flow").refuse(dense, example_path("al2024-s390"))
