"""A stage that was stopped goes on from what it left, if that was made from the very same inputs."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys

import pytest

from glue.errors import NotConverged, SolverFailed
from glue.solvers import repo_root
from glue.study.stage import Stage


@pytest.fixture
def resuming(stubs):
    """Stubs whose stage b writes ``b/log.part`` line by line and can be told to stop: .attempts says how each began."""
    stubs.attempts, stubs.stop = [], None

    def run(work):
        part = work.path / "b" / "log.part"
        part.parent.mkdir(exist_ok=True)
        stubs.attempts.append((work.go_on, part.read_text() if part.exists() else None))
        with open(part, "a") as f:
            f.write("line\n")
        if stubs.stop:
            raise stubs.stop
        part.rename(work.path / "b" / "log")
        return {"b": {"value": 1}}, ["b/log"]

    b = Stage("b", ("a",), (), ("b",), run, resumes=True)
    stubs.stages = (stubs.stages[0], b)
    return stubs


def test_a_stopped_stage_goes_on(resuming, tmp_path):
    resuming.stop = KeyboardInterrupt()
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            resuming.go(tmp_path / "run")
    resuming.stop = None
    resuming.go(tmp_path / "run")
    assert resuming.attempts == [(False, None), (True, "line\n"), (True, "line\nline\n")]
    assert resuming.go(tmp_path / "run") == [] and len(resuming.attempts) == 3
    (tmp_path / "run" / "b" / "log").unlink()  # complete once: made again from its beginning
    resuming.go(tmp_path / "run")
    assert resuming.attempts[-1] == (False, None)


def test_other_inputs_start_afresh(resuming, tmp_path):
    resuming.stop = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        resuming.go(tmp_path / "run")
    (tmp_path / "run" / "a.txt").unlink()
    resuming.salt["a"], resuming.stop = "new", None
    resuming.go(tmp_path / "run")
    assert resuming.attempts == [(False, None), (False, None)]


def test_a_stage_that_cannot_go_on_starts_afresh(resuming, tmp_path):
    resuming.stages = (resuming.stages[0], dataclasses.replace(resuming.stages[1], resumes=False))
    resuming.stop = KeyboardInterrupt()
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            resuming.go(tmp_path / "run")
    assert resuming.attempts == [(False, None), (False, None)]


@pytest.mark.parametrize(("error", "goes_on"), [(SolverFailed("died"), True), (NotConverged("wrong"), False)])
def test_only_a_solver_that_died_is_gone_on_with_and_once(resuming, tmp_path, error, goes_on):
    """What failed after going on may have been led there: then from the beginning."""
    resuming.stop = error
    for _ in range(3):
        with pytest.raises(type(error)):
            resuming.go(tmp_path / "run")
    assert [go_on for go_on, _ in resuming.attempts] == [False, goes_on, False]


PROGRAM = """
import os, sys
from glue import cli
from glue.study import pipeline
from glue.study.stage import Stage
def run(work):
    part = work.path / "flow" / "log.part"
    part.parent.mkdir(exist_ok=True)
    if not work.go_on:
        part.write_text("half")
        print("up", flush=True)
        import time; time.sleep(60)
    (work.path / "flow" / "log").write_text(part.read_text() + " and whole")
    return {}, ["flow/log"]
pipeline._default_stages = lambda: (Stage("flow", (), (), ("flow",), run, resumes=True),)
sys.exit(cli.main(["run", "al2024-s390", "--out", "run"]))
"""


def test_peen_run_again_after_kill_9(tmp_path):
    env = {**os.environ, "PYTHONPATH": str(repo_root())}

    def start():
        return subprocess.Popen(
            [sys.executable, "-c", PROGRAM], cwd=tmp_path, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )

    child = start()
    assert child.stdout.readline() == b"up\n"
    child.send_signal(signal.SIGKILL)
    child.communicate(timeout=20)
    _, said = start().communicate(timeout=20)
    assert b"goes on from a stopped attempt" in said
    assert (tmp_path / "run" / "flow" / "log").read_text() == "half and whole"
    record = json.loads((tmp_path / "run" / "manifest.json").read_text())["stages"]["flow"]
    assert record["state"] == "complete" and record["went_on"]
