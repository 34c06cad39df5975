from __future__ import annotations

import fcntl
import hashlib
import json
import os

import pytest

from glue.errors import InputError
from glue.study.rundir import RunDirectory, digest


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "my scene.toml"
    path.write_text("schema = 1\n")
    return path


def make(path, scene_file, **resolved):
    facts = {"scene": "s", "seed": 1, "choices": {}, "defaults_used": []}
    return RunDirectory.create_or_continue(
        path, scene=scene_file.read_bytes(), preset=None, resolved=resolved, facts=facts
    )


def test_a_new_directory_holds_the_scene_and_its_inputs(tmp_path, scene_file):
    with make(tmp_path / "a" / "run", scene_file, speed_m_s=60.0):
        manifest = json.loads((tmp_path / "a" / "run" / "manifest.json").read_text())
    assert manifest["inputs"] == {"speed_m_s": 60.0}
    assert manifest["inputs_sha256"] == digest({"speed_m_s": 60.0})
    assert (tmp_path / "a" / "run" / "scene.toml").read_text() == "schema = 1\n"
    assert json.loads((tmp_path / "a" / "run" / "metrics.json").read_text()) == {"schema": 1}


def test_other_inputs_are_refused_with_what_differs(tmp_path, scene_file):
    make(tmp_path / "run", scene_file, nozzle={"speed_m_s": 60.0, "n": 1}, seed=1).__exit__()
    with pytest.raises(InputError) as caught:
        make(tmp_path / "run", scene_file, nozzle={"speed_m_s": 80.0, "n": 1}, seed=1)
    assert "other inputs" in caught.value.problems[0]
    assert caught.value.problems[1:] == ["  nozzle.speed_m_s: there 60.0, here 80.0"]


def test_a_folder_of_other_things_is_refused_and_left_alone(tmp_path, scene_file):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("x")
    with pytest.raises(InputError, match="no run directory .holds chapter.tex"):
        make(tmp_path / "thesis", scene_file)
    assert [p.name for p in (tmp_path / "thesis").iterdir()] == ["chapter.tex"]


def test_an_unwritable_place_is_refused(tmp_path, scene_file):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write the run directory .Not a directory"):
        make(tmp_path / "file" / "run", scene_file)


def test_what_an_interrupted_start_left_does_not_stand_in_the_way(tmp_path, scene_file):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "scene.toml").write_text("schema = 1\n")  # atomic: whole when it has its name
    (tmp_path / "run" / "scene.toml.part").write_text("half")
    (tmp_path / "run" / "manifest.json.part").write_text("{")
    with make(tmp_path / "run", scene_file) as run:
        assert run.scene_file.read_text() == "schema = 1\n"


def test_a_scene_of_the_users_is_not_overwritten(tmp_path, scene_file):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "scene.toml").write_text("# my other scene\n")
    with pytest.raises(InputError, match=r"mine/scene\.toml: is there already"):
        make(tmp_path / "mine", scene_file)
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["scene.toml"]
    assert (tmp_path / "mine" / "scene.toml").read_text() == "# my other scene\n"


def test_the_scene_is_copied_byte_for_byte(tmp_path):
    scene = tmp_path / "windows.toml"
    scene.write_bytes(b"\xef\xbb\xbfschema = 1\r\n")
    with make(tmp_path / "run", scene) as run:
        assert run.scene_file.read_bytes() == scene.read_bytes()
        assert run.manifest["scene_sha256"] == hashlib.sha256(scene.read_bytes()).hexdigest()


def test_the_loser_of_two_starts_hears_of_the_other(tmp_path, scene_file):
    """The winner has the lock, and has written half of what makes a run directory."""
    (tmp_path / "run").mkdir()
    held = os.open(tmp_path / "run" / ".lock", os.O_CREAT | os.O_RDWR)
    fcntl.flock(held, fcntl.LOCK_EX)
    (tmp_path / "run" / "dimple").mkdir()
    with pytest.raises(InputError, match="another peen is at work"):
        make(tmp_path / "run", scene_file)
    os.close(held)


def test_one_process_at_a_time(tmp_path, scene_file):
    with make(tmp_path / "run", scene_file), pytest.raises(InputError, match="another peen is at work"):
        make(tmp_path / "run", scene_file)
    make(tmp_path / "run", scene_file).__exit__()  # free again


@pytest.mark.parametrize("content", ["", "{", "[]", '{"schema": 99}', '{"schema": 1}'])
def test_a_damaged_or_later_manifest_is_refused(tmp_path, content):
    (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(InputError, match=r"manifest\.json"):
        RunDirectory.open(tmp_path)


@pytest.mark.parametrize("key", ["scene", "seed", "choices", "inputs", "inputs_sha256", "scene_sha256", "stages"])
def test_a_manifest_without_what_it_must_hold_is_refused(tmp_path, scene_file, key):
    make(tmp_path / "run", scene_file).__exit__()
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    del manifest[key]
    (tmp_path / "run" / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=f"manifest.json: is damaged .{key}."):
        make(tmp_path / "run", scene_file)


@pytest.mark.parametrize("record", [None, {}, {"state": "complete"}, {"state": "complete", "input_sha256": "x"}])
def test_a_damaged_record_of_a_stage_is_refused(tmp_path, scene_file, record):
    make(tmp_path / "run", scene_file).__exit__()
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    manifest["stages"]["flow"] = record
    (tmp_path / "run" / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match="is damaged .stages.flow."):
        RunDirectory.open(tmp_path / "run")


@pytest.mark.parametrize("damage", [lambda p: p.unlink(), lambda p: p.write_text("half")])
def test_a_lost_copy_of_the_scene_is_restored(tmp_path, scene_file, damage):
    make(tmp_path / "run", scene_file).__exit__()
    damage(tmp_path / "run" / "scene.toml")
    scene_file.write_text("# a word more\nschema = 1\n")  # the same inputs
    with make(tmp_path / "run", scene_file) as run:
        assert run.scene_file.read_bytes() == scene_file.read_bytes()
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert manifest["scene_sha256"] == hashlib.sha256(scene_file.read_bytes()).hexdigest()
    scene_file.write_text("schema = 1\n")
    with make(tmp_path / "run", scene_file) as run:  # a copy that is whole stays
        assert run.scene_file.read_text() == "# a word more\nschema = 1\n"


def test_complete_means_same_inputs_and_untouched_files(tmp_path, scene_file):
    with make(tmp_path / "run", scene_file) as run:
        (run.path / "a.csv").write_text("1")
        run.finish("flow", {"input_sha256": "h1", "metrics": {}}, ["a.csv"])
        assert run.is_current("flow", "h1")
        assert not run.is_current("flow", "h2")
        (run.path / "a.csv").write_text("2")
        assert not run.is_current("flow", "h1")
        (run.path / "a.csv").unlink()
        assert not run.is_current("flow", "h1")


def test_beginning_a_stage_removes_its_files_and_doubts_what_builds_on_it(tmp_path, scene_file):
    with make(tmp_path / "run", scene_file) as run:
        for stage, name in (("dimple", "d"), ("flow", "f"), ("coverage", "c")):
            (run.path / name).write_text("x")
            run.finish(stage, {"input_sha256": "h", "metrics": {stage: {"value": 1}}}, [name])
        run.begin("flow", ["coverage"], ["f", "never_written"], "h")
        names = sorted(p.name for p in run.path.iterdir())
        assert names == [".lock", "c", "d", "manifest.json", "metrics.json", "scene.toml"]
        assert json.loads((run.path / "metrics.json").read_text()) == {"schema": 1, "dimple": {"value": 1}}
        assert run.outputs_digest("coverage") is None
        assert run.is_current("coverage", "h")
        run.keep("coverage")
        assert run.metrics() == {"schema": 1, "dimple": {"value": 1}, "coverage": {"value": 1}}


def test_a_users_own_files_in_a_stages_folder_stay(tmp_path, scene_file):
    with make(tmp_path / "run", scene_file) as run:
        folder = run.path / "flow"
        (folder / "notes").mkdir(parents=True)
        for name in ("impacts.csv", "mine.ods", "notes/impacts.csv", "half.csv.part", "notes/x.part"):
            (folder / name).write_text("x")
        run.finish("flow", {"input_sha256": "h", "metrics": {}}, ["flow/impacts.csv"])
        run.begin("flow", [], ["flow"], "h")
        left = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*"))
        assert left == ["mine.ods", "notes", "notes/impacts.csv"]


def test_a_later_stage_replaces_a_value_and_its_reason(tmp_path, scene_file):
    with make(tmp_path / "run", scene_file) as run:
        # finished out of order: the order of the way of the data decides, not that of time
        run.finish("target", {"input_sha256": "t", "metrics": {"coverage": {"peeq_final": 0.9}}}, [])
        early = {"coverage": {"final": 1.0, "peeq_final": None, "peeq_final_reason": "not run"}}
        run.finish("coverage", {"input_sha256": "c", "metrics": early}, [])
        assert run.metrics() == {"schema": 1, "coverage": {"final": 1.0, "peeq_final": 0.9}}


def test_a_failed_stage_has_no_metrics(tmp_path, scene_file):
    with make(tmp_path / "run", scene_file) as run:
        run.fail("flow", {"exit_code": 3})
        assert run.metrics() == {"schema": 1}
        assert run.outputs_digest("flow") is None
        assert not run.is_current("flow", "h")
