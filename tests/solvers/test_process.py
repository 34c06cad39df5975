"""How a child process is told to end."""

from __future__ import annotations

import os
import signal
import sys
import time

import pytest

from glue.solvers import process

CODE = (
    "import time\ntry:\n    print('up', flush=True)\n    time.sleep(60)\nexcept KeyboardInterrupt:\n"
    "    {then}\n    print('jobs called off', flush=True)\n    open('cancelled', 'w')\n"
)


def interrupted(tmp_path, then="pass", **options):
    """Whether the child, stopped when it told that it is up, could end by itself."""

    def on_line(line):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        process.run(
            [sys.executable, "-c", CODE.format(then=then)], cwd=tmp_path, log=tmp_path / "log", env=os.environ,
            on_line=on_line, **options,
        )  # fmt: skip
    return (tmp_path / "cancelled").exists()


def test_a_program_with_work_elsewhere_gets_the_time_to_call_it_off(tmp_path):
    # longer than the grace before the kill of any other program
    assert interrupted(tmp_path, f"time.sleep({process._GRACE_S + 1.0})", interrupt_s=60.0)
    assert "jobs called off" in (tmp_path / "log").read_text()


def test_other_programs_get_no_interrupt(tmp_path):
    assert not interrupted(tmp_path)


def test_a_program_that_does_not_end_is_killed(tmp_path):
    begun = time.monotonic()
    then = "print('asked', flush=True); time.sleep(60)"
    assert not interrupted(tmp_path, then, interrupt_s=1.0) and time.monotonic() - begun < 50.0
    assert "asked" in (tmp_path / "log").read_text()


def test_an_interrupt_reaches_a_program_whose_caller_ignores_them(tmp_path):
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as nohup and a shell's background jobs do
    try:
        assert interrupted(tmp_path, interrupt_s=60.0)
    finally:
        signal.signal(signal.SIGINT, before)
