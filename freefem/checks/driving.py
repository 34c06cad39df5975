"""Writes and runs the driver of one check."""

from __future__ import annotations

from pathlib import Path

from glue.solvers import run_freefem
from glue.target.driver import Parameter, write_driver


def run_check(folder: Path, name: str, parameters: list[Parameter], includes: list[str]) -> None:
    """Write and run a driver in ``folder``; its results stand there."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [
        Parameter("string", "outDir", ".", "results"),
        Parameter("string", "statusFile", "status", "written last"),
    ]
    driver = folder / "driver.edp"
    driver.write_text(write_driver(name, paths + parameters, includes))
    run_freefem(driver, cwd=folder, log=folder / "log", status=folder / "status")
