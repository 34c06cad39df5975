"""What the command prints where, and its exit codes; the solvers are stubs."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from glue import cli
from glue.errors import NotConverged, SolverFailed
from glue.scene.reader import example_path
from glue.study import pipeline
from glue.study.stage import Stage


@pytest.fixture
def stages(monkeypatch):
    """stages(error=None, said=None): one stub stage ``flow`` in place of the real ones; ``said``: more metrics."""

    def make(error=None, said=None):
        def run(work):
            if error:
                raise error
            work.progress(0.5, "half way")
            return {"flow": {"impacts": 7} | (said or {})}, []

        monkeypatch.setattr(pipeline, "_default_stages", lambda: (Stage("flow", (), (), (), run),))

    return make


def test_run_prints_the_summary_and_tells_progress_on_stderr(stages, tmp_path, capsys):
    stages()
    assert cli.main(["run", "al2024-s390", "--out", str(tmp_path / "run")]) == 0
    said = capsys.readouterr()
    assert re.search(r"impacts on the target +7\n", said.out)
    assert "half way" not in said.out and "flow       starts" in said.err and "done" in said.err


def test_a_warning_of_a_stage_reaches_stderr(stages, tmp_path, capsys):
    stages(said={"warning": "ballistic shots never meet"})
    assert cli.main(["run", "al2024-s390", "--json", "--out", str(tmp_path / "run")]) == 0
    said = capsys.readouterr()
    assert "peen: warning: flow: ballistic shots never meet" in said.err
    assert json.loads(said.out)["flow"]["warning"] == "ballistic shots never meet"


def test_json_is_all_of_stdout(stages, tmp_path, capsys):
    stages()
    assert cli.main(["run", "al2024-s390", "--json", "--out", str(tmp_path / "run")]) == 0
    assert json.loads(capsys.readouterr().out) == {"schema": 1, "flow": {"impacts": 7}}
    assert cli.main(["flow", str(tmp_path / "run"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"schema": 1, "flow": {"impacts": 7}}


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (SolverFailed("YADE failed", cause="a stub", advice="more care"), 3),
        (NotConverged("too coarse"), 4),
        (KeyboardInterrupt(), 130),
        (OSError(28, "No space left on device"), 2),
    ],
)
def test_exit_code_tells_what_failed(stages, tmp_path, capsys, error, code):
    stages(error)
    assert cli.main(["run", "al2024-s390", "--out", str(tmp_path / "run")]) == code
    said = capsys.readouterr()
    assert said.out == ""
    if code != 130:
        assert getattr(error, "strerror", str(error)) in said.err and str(tmp_path / "run") in said.err


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (["run", "nonesuch"], "no such scene file, nor a shipped example (al2024-s110, "),
        (["check", "nonesuch.toml"], "no such scene file"),
        (["check", "al2024-s390", "--accuracy", "bset"], "accuracy"),
        (["run", "al2024-s390", "--only", "flo"], "no stage flo"),
        (["run", "al2024-s390", "--target-error", "soon"], "such as 5% or 0.05"),
        (["run", "al2024-s390", "--budget", "soon"], "such as 60s, 5min or 2h"),
        (["run", "al2024-s390", "--budget", "60s", "--accuracy", "fast"], "allowed: without them"),
        (["tradeoff", "nonesuch"], "no such scene file"),
        (["tradeoff", "al2024-s390", "--only", "soup"], "no group soup; allowed: coverage, "),
        (["report", "nonesuch"], "no run directory"),
        (["dimple", "--material", "al2024-t351", "--speed", "nan"], "0.5..300 m/s"),
        (["dimple", "--material", "al2024-t351", "--speed", "0.49"], "0.5..300 m/s"),
        (["dimple", "--material", "al2024-t351", "--speed", "0.5", "--diameter", "1"], "peen: --diameter"),
        (
            ["dimple", "--material", "al2024-t351", "--speed", "60", "--diameter", "1"],
            "metres, not millimetres",
        ),
        (["dimple", "--material", "cheese", "--speed", "60"], "cheese"),
        (["dimple", "--material", "al2024-t351", "--speeds", "1-120"], "SLOWEST:FASTEST"),
        (["dimple", "--material", "al2024-t351", "--speeds", "1:120", "--diameter", "1e-3"], "serves every diameter"),
        (["dimple", "--material", "al2024-t351", "--speed", "60", "--out", "x.json"], "allowed with --speeds"),
    ],
)
def test_bad_input_is_exit_2_before_any_solver_starts(monkeypatch, tmp_path, capsys, argv, says):
    monkeypatch.setenv("PEEN_YADE", str(tmp_path / "none"))
    monkeypatch.setenv("PEEN_FREEFEM", str(tmp_path / "none"))
    monkeypatch.chdir(tmp_path)
    assert cli.main(argv) == 2
    said = capsys.readouterr()
    assert says in said.err and said.out == ""
    assert list(tmp_path.iterdir()) == []


def test_an_unwritable_run_directory_is_exit_2(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert cli.main(["run", "al2024-s390", "--out", str(tmp_path / "file" / "run")]) == 2
    assert "cannot write the run directory" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("code", "exit_code", "cause"),
    [
        ("print('Exec error : exec assert'); sys.exit(8)", 3, "cause: exit code 8"),
        (
            "Path('status').write_text('failed: the time step fell below 1e-12 s\\n')",
            4,
            "cause: the time step fell below",
        ),
    ],
)
def test_a_failing_solver_is_told_with_log_and_run_directory(
    stub, monkeypatch, tmp_path, capsys, code, exit_code, cause
):
    """The real dimple stage on a stub of FreeFem++."""
    stub("PEEN_FREEFEM", code)
    stub("PEEN_YADE", "")  # looked for before anything runs
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("PEEN_KERNEL", "script")  # no compiler needed
    run = tmp_path / "run"
    assert cli.main(["run", "al2024-s390", "--out", str(run)]) == exit_code
    said = capsys.readouterr().err
    for part in (cause, "log:", "last lines:", "try:", str(run)):
        assert part in said
    log = next(line.split()[-1] for line in said.splitlines() if line.startswith("  log:"))
    assert Path(log).is_file()
    record = json.loads((run / "manifest.json").read_text())["stages"]["dimple"]
    assert (record["state"], record["exit_code"]) == ("failed", exit_code)
    assert record["processes"][0]["exit_code"] == (8 if exit_code == 3 else 0)
    assert cli.main(["report", str(run), "--json"]) == 0  # a report of nothing is still one
    assert json.loads(capsys.readouterr().out) == {"schema": 1}


def test_a_terminal_without_the_letters_gets_question_marks(tmp_path):
    import os

    env = {**os.environ, "PYTHONIOENCODING": "ascii"}
    argv = [sys.executable, "-m", "glue", "check", "al2024-s390"]
    done = subprocess.run(argv, capture_output=True, env=env)
    assert done.returncode == 0, done.stderr
    assert b" ?m (estimate" in done.stdout and done.stdout.isascii()


def test_a_place_for_numbas_code_that_cannot_be_written_is_bad_input(stages, monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/proc/x/numba")
    stages(error=RuntimeError("cannot cache function 'f': no locator available for file 'f.py'"))  # as numba says it
    assert cli.main(["run", "al2024-s390", "--out", str(tmp_path / "run")]) == 2
    assert "peen: /proc/x/numba: cannot be written" in capsys.readouterr().err


def test_numba_finds_a_place_for_its_code(stages, monkeypatch, tmp_path):
    import os

    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")  # so that it is restored afterwards
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    assert cli.main(["check", "al2024-s390"]) == 0
    assert os.environ["NUMBA_CACHE_DIR"] == str(tmp_path / "cache" / "numba")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "mine")
    cli.main(["check", "al2024-s390"])
    assert os.environ["NUMBA_CACHE_DIR"] == "mine"


def test_a_folder_of_an_examples_name_does_not_hide_it(monkeypatch, tmp_path, capsys):
    (tmp_path / "al2024-s390").mkdir()
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)
    assert cli.main(["check", "al2024-s390"]) == 0
    assert cli.main(["check", "other"]) == 2
    assert "other: is a folder, not a scene file" in capsys.readouterr().err


def test_every_problem_of_a_scene_is_told_at_once(tmp_path, capsys):
    scene = tmp_path / "bad.toml"
    scene.write_text("schema = 1\nname = 'x'\nseed = -1\nexposure_tme_s = 3.0\n[nozzle]\nspeed_m_s = nan\n")
    assert cli.main(["check", str(scene)]) == 2
    said = capsys.readouterr().err
    for key in ("seed", "exposure_tme_s", "speed_m_s", "[shots]"):
        assert key in said


def test_check_tells_numbers_choices_and_defaults(capsys):
    assert cli.main(["check", "al2024-s390"]) == 0
    said = capsys.readouterr().out
    # 0.01667 kg/s over a 1 mm sphere of 7800 kg/m3 (4.084e-6 kg) for 3 s
    assert "12245 expected (4082 per second)" in said
    assert "dem" in said and "cell" in said and "Defaults used" in said
    assert cli.main(["check", "al2024-s390", "--json", "--accuracy", "fast"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["accuracy"]["preset"] == "fast"
    assert found["collision_number"]["pi"] == pytest.approx(
        6 * 0.01667 * 0.1 * 1.34 / (7800 * 1e-3 * 3.141592653589793 / 4 * 0.02**2 * 60 * 0.34), rel=1e-12
    )


def test_the_first_error_is_told_when_the_failure_cannot_be_noted_down(
    stages, tmp_path, capsys, monkeypatch
):
    stages(SolverFailed("YADE failed", cause="a stub"))

    def full(self, stage, record):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("glue.study.rundir.RunDirectory.fail", full)
    assert cli.main(["run", "al2024-s390", "--out", str(tmp_path / "run")]) == 3
    said = capsys.readouterr().err
    assert "YADE failed" in said and "could not be noted down either" in said and "No space left" in said


@pytest.mark.parametrize("argv", [["check", "x" * 300], ["run", "x" * 300]])
def test_a_name_that_no_file_can_have_is_bad_input(capsys, argv):
    assert cli.main(argv) == 2
    assert "File name too long" in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux only")
@pytest.mark.parametrize("json_flag", [[], ["--json"]])
def test_output_that_cannot_be_written_is_exit_2(json_flag):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "glue", "check", "al2024-s390", *json_flag],
            stdout=full, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
    assert done.returncode == 2 and "disk full?" in done.stderr
    assert "Traceback" not in done.stderr and "Exception ignored" not in done.stderr


def test_an_interrupt_during_the_imports_is_quiet(monkeypatch, capsys):
    import builtins

    from glue.__main__ import main

    def interrupted(name, *args, **kwargs):
        if name == "glue.cli":
            raise KeyboardInterrupt
        return real(name, *args, **kwargs)

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", interrupted)
    assert main() == 130
    monkeypatch.undo()
    assert capsys.readouterr() == ("", "")


def test_the_installed_command_is_the_module():
    import tomllib

    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    assert project["scripts"] == {"peen": "glue.__main__:main"}


def test_the_module_is_the_command():
    done = subprocess.run([sys.executable, "-m", "glue", "--help"], capture_output=True, text=True)
    assert done.returncode == 0 and "examples:" in done.stdout and "exit codes:" in done.stdout
    wrong = subprocess.run([sys.executable, "-m", "glue", "paint"], capture_output=True, text=True)
    assert wrong.returncode == 2 and wrong.stdout == ""


def test_check_warns_of_passes_that_miss_the_window(tmp_path, capsys):
    text = example_path("mixed-s230-s390-traverse").read_text()
    path = tmp_path / "wide.toml"
    path.write_text(re.sub(r"(?m)^pitch_m = [0-9.e-]+", "pitch_m = 0.1", text))
    assert cli.main(["check", str(path)]) == 0
    assert "pass 1, 3 of 3 brings no shot into the window" in capsys.readouterr().out
