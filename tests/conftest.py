"""Solver tests need the real YADE and FreeFem++; stub solvers stand in for them everywhere else."""

from __future__ import annotations

import os
import shutil
import signal
import stat
import sys

import pytest


# A shell's background job ignores Ctrl-C, and every process it starts inherits that: tests of Ctrl-C need it back.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_runtest_setup(item):
    if item.get_closest_marker("solver") is None:
        return
    missing = [name for name in ("yade", "FreeFem++", "ff-c++") if shutil.which(name) is None]
    if missing:
        reason = f"{', '.join(missing)} not installed; make setup"
        pytest.fail(reason) if os.environ.get("PEEN_REQUIRE_SOLVERS") == "1" else pytest.skip(reason)
    from glue.solvers import build_plugin

    build_plugin()


@pytest.fixture
def stub(tmp_path, monkeypatch):
    """stub("PEEN_FREEFEM", python_code): a program of that code stands in for the solver; its path."""

    def make(variable: str, code: str):
        program = tmp_path / variable.lower()
        program.write_text(
            f"#!{sys.executable}\nimport os, signal, sys, time\nfrom pathlib import Path\n{code}\n"
        )
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv(variable, str(program))
        return program

    return make
