"""Ctrl-C and kill in the middle of a run: no solver stays, no record claims what is not there."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys

import pytest

from glue import stopping
from glue.solvers import repo_root
from glue.study.stage import Stage


def manifest(out):
    return json.loads((out / "manifest.json").read_text())


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_kill_leaves_no_solver_running_and_no_complete_stage(tmp_path, number):
    """A stage waits for a solver that would write ``alive`` after a second; peen is killed before that."""
    program = tmp_path / "program.py"
    program.write_text(
        "import os, sys\nfrom glue import cli\nfrom glue.solvers import process\n"
        "from glue.study import pipeline\nfrom glue.study.stage import Stage\n"
        "def run(work):\n"
        "    code = \"import time; print('up', flush=True); time.sleep(1); open('alive', 'w')\"\n"
        "    process.run([sys.executable, '-c', code], cwd=work.path,\n"
        "                log=work.path / 'log', env=os.environ,\n"
        "                on_line=lambda line: print(line, flush=True))\n"
        "    return {}, []\n"
        "pipeline._default_stages = lambda: (Stage('flow', (), (), (), run),)\n"
        "sys.exit(cli.main(['run', 'al2024-s390', '--out', 'run']))\n"
    )
    env = {**os.environ, "PYTHONPATH": str(repo_root())}
    child = subprocess.Popen(
        [sys.executable, program], cwd=tmp_path, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert child.stdout.readline() == b"up\n"
    child.send_signal(number)
    _, stderr = child.communicate(timeout=20)
    assert child.returncode == {signal.SIGKILL: -9, signal.SIGTERM: 143, signal.SIGINT: 130}[number], stderr
    import time

    time.sleep(1.2)
    assert not (tmp_path / "run" / "alive").exists()
    assert [r["state"] for r in manifest(tmp_path / "run")["stages"].values()] == ["started"]
    assert not list((tmp_path / "run").rglob("*.part"))


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    ("number", "raised"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)]
)
@pytest.mark.parametrize("stage", ["b", "d"])
def test_a_signal_lost_in_a_callback_still_stops_the_run(stubs, tmp_path, number, raised, stage):
    """As in numba's compiler: what the handler raises inside a C callback goes no further."""
    deliver = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(number))
    inner = next(s for s in stubs.stages if s.name == stage)

    def run(work):
        deliver()
        return inner.run(work)

    renewed = Stage(stage, inner.needs, (), inner.owns, run, inner.uses)
    stubs.stages = tuple(renewed if s.name == stage else s for s in stubs.stages)
    with stopping.noticed(), pytest.raises(raised):
        stubs.go(tmp_path / "run")
    assert stubs.ran == {"b": ["a", "b"], "d": ["a", "b", "c", "d"]}[stage]
    assert manifest(tmp_path / "run")["stages"][stage]["state"] == "complete"  # its result is whole: kept


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_signal_lost_in_a_callback_stops_a_stage_that_tells_its_progress(stubs, tmp_path):
    deliver = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))

    def run(work):
        deliver()
        work.progress(0.5, "half way")
        stubs.ran.append("too far")

    stubs.stages = (Stage("a", (), (), (), run),)
    with stopping.noticed(), pytest.raises(KeyboardInterrupt):
        stubs.go(tmp_path / "run")
    assert stubs.ran == [] and signal.getsignal(signal.SIGINT) is signal.default_int_handler
