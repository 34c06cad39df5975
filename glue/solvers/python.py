"""Runs a module of this package in an interpreter of its own: for runs side by side, each with its own memory and clock."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from glue.solvers import process
from glue.solvers.find import repo_root


def run_module(
    module: str,
    args: Sequence[str | Path],
    *,
    log: Path,
    on_line: Callable[[str], None] | None = None,
    interrupt_s: float | None = None,
) -> process.Finished:
    """``python -m module args`` in the present folder; output in ``log``. The caller looks at the exit code.

    ``interrupt_s`` as for :func:`process.run`.  One thread for linear algebra unless the caller's environment says
    otherwise: several such processes share the cores.
    """
    env = {"OMP_NUM_THREADS": "1", **os.environ, "PYTHONPATH": os.pathsep.join([str(repo_root()), *filter(None, [os.environ.get("PYTHONPATH")])])}
    argv = [sys.executable, "-u", "-m", module, *args]
    return process.run(argv, cwd=Path.cwd(), log=log, env=env, on_line=on_line, interrupt_s=interrupt_s)
