"""Every way in which YADE may fail, played by stubs, and what it is started with."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from glue.errors import SolverFailed
from glue.solvers import repo_root, run_yade


@pytest.fixture
def run(tmp_path, stub):
    def go(code: str, args=(), **options):
        stub("PEEN_YADE", code)
        return run_yade(tmp_path / "job.py", list(args), cwd=tmp_path, log=tmp_path / "job.log", **options)

    return go


def test_started_without_input_on_one_thread_with_only_the_checkout_to_import(run, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/venv")
    run(
        "import json, tempfile; print(json.dumps([sys.argv[1:], sys.stdin.read(), os.environ['PYTHONPATH'],"
        "os.environ['OMP_NUM_THREADS'], os.environ['MARK'], tempfile.mkdtemp()]))",
        ["scene.toml", "a b"],
        env={"MARK": "x"},
    )
    argv, stdin, path, threads, mark, scratch = json.loads((tmp_path / "job.log").read_text().splitlines()[1])
    assert argv == ["-n", "-x", "-j1", str(tmp_path / "job.py"), "scene.toml", "a b"]
    assert (stdin, path, threads, mark) == ("", str(repo_root()), "1", "x")
    assert not Path(scratch).parent.exists()  # YADE's own temporary folders go with it


@pytest.mark.parametrize(
    ("code", "cause"),
    [
        ("raise ValueError('the shot left the domain')", "ValueError: the shot left the domain"),
        ("import nonesuch_module", "lacks the module nonesuch_module"),
        ("sys.exit(3)", "exit code 3"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "killed by signal 9 (SIGKILL)"),
        ("raise MemoryError", "out of memory"),
    ],
)
def test_failures_name_their_cause(run, tmp_path, code, cause):
    with pytest.raises(SolverFailed) as caught:
        run(code)
    assert cause in caught.value.cause
    assert caught.value.log == tmp_path / "job.log"


def test_exit_code_0_without_the_outputs_is_a_failure(run, tmp_path):
    (tmp_path / "impacts.csv").write_text("of an older run")
    with pytest.raises(SolverFailed, match="exit code 0, but impacts.csv was not written"):
        run("pass", outputs=[tmp_path / "impacts.csv"])


def test_time_limit(run):
    with pytest.raises(SolverFailed, match="not finished after 0.2 s"):
        run("time.sleep(60)", timeout_s=0.2)


def test_a_child_that_closes_its_output_still_meets_the_limit(run):
    with pytest.raises(SolverFailed, match="not finished after 0.3 s"):
        run("os.close(1); os.close(2); time.sleep(60)", timeout_s=0.3)


def test_missing_binary(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("PEEN_YADE", raising=False)
    with pytest.raises(SolverFailed, match="no yade on the path"):
        run_yade(tmp_path / "job.py", [], cwd=tmp_path, log=tmp_path / "log")
