"""Runs YADE scripts."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from glue.errors import SolverFailed
from glue.solvers import diagnose, process
from glue.solvers.find import find_yade, require_checkout


def run_yade(
    script: Path,
    args: Sequence[str],
    *,
    cwd: Path,
    log: Path,
    timeout_s: float | None = None,
    on_line: Callable[[str], None] | None = None,
    env: Mapping[str, str] | None = None,
    outputs: Sequence[Path] = (),
) -> process.Finished:
    """Run ``yade -n -x script args`` on one thread and return when it has ended well.

    ``outputs`` are removed first and must exist afterwards, since YADE can stop early with exit code
    0. ``on_line`` gets every line printed; ``env`` adds to the environment. Raises SolverFailed.
    """
    root = require_checkout()
    binary = find_yade()
    for path in outputs:
        path.unlink(missing_ok=True)
    # YADE leaves one temporary folder behind per run: it gets a private one that goes with it.
    with tempfile.TemporaryDirectory(prefix="peen-yade-") as scratch:
        child_env = {
            **os.environ,
            "PYTHONPATH": str(root),  # alone: a virtual environment's packages would break Debian's Python
            "OMP_NUM_THREADS": "1",
            "TMPDIR": scratch,
            **(env or {}),
        }
        child_env.pop("PYTHONHOME", None)
        # -x: without it a script that raises ends with exit code 0 when standard input is closed.
        argv = [binary, "-n", "-x", "-j1", script, *args]
        try:
            done = process.run(argv, cwd=cwd, log=log, env=child_env, timeout_s=timeout_s, on_line=on_line)
        except process.TimedOut:
            raise _failed(
                script, log, f"not finished after {timeout_s:g} s", "a shorter exposure or a coarser preset"
            ) from None
        except OSError as problem:
            raise _failed(script, log, f"could not be started: {problem}", "peen doctor") from None
    if done.exit_code != 0:
        raise _failed(script, log, *diagnose.explain(done, diagnose.YADE))
    missing = [p.name for p in outputs if not p.exists()]
    if missing:
        found = diagnose.match(log, diagnose.YADE)
        cause = f"exit code 0, but {', '.join(missing)} was not written" + (
            f": {found.cause}" if found else ""
        )
        raise _failed(script, log, cause, "the log shows where the script stopped")
    return done


def _failed(script: Path, log: Path, cause: str, advice: str) -> SolverFailed:
    return SolverFailed(
        f"YADE failed in {script.name}", cause=cause, log=log, tail=process.tail(log), advice=advice
    )
