"""The shot stream in YADE: runs ``yade_scripts/shot_flow.py`` on drawn arrivals and reads its log."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from glue import solvers
from glue.atomic import write_text_atomic
from glue.errors import InputError, NotConverged, SolverFailed
from glue.flow.arrivals import scene_hash
from glue.flow.impacts import read_impacts
from glue.flow.restitution import RestitutionLaw
from glue.scene.model import Scene

_PROGRESS = re.compile(r"progress (\S+) eta_s (\S+)")


def run_dem(
    scene: Scene,
    scene_file: Path,
    out: Path,
    *,
    law: RestitutionLaw,
    arrivals_path: Path,
    surface_path: Path | None = None,
    progress: Callable[[float, str], None] | None = None,
    go_on: bool = False,
) -> tuple[np.ndarray, dict]:
    """Let YADE fly the shots of ``arrivals_path``: (impacts, what flow.json says of the run).

    ``scene_file`` is the file that ``scene`` was read from: YADE reads it again, and refuses arrivals of
    another scene.  ``law``: restitution on the target; ``surface_path``: a target of triangles (.npz of
    ``glue.flow.surface``).  ``go_on``: from a stopped run's checkpoint in ``out``, where there is one.
    Writes impacts.csv, flow.json, law.json, flow.log into ``out``.

    Raises InputError when the scene cannot be simulated (restitution, time step), NotConverged when a check
    of the run failed, SolverFailed when YADE stopped otherwise; the log so far stays as impacts.csv.part.
    """
    impacts_path, report_path = out / "impacts.csv", out / "flow.json"
    write_text_atomic(out / "law.json", json.dumps(law.as_dict(), indent=2) + "\n")

    def on_line(line: str) -> None:
        if progress and (found := _PROGRESS.match(line)):
            progress(float(found[1]), f"{float(found[2]):.0f} s left in YADE")

    args = [
        str(Path(scene_file).resolve()),
        str(out),
        "--arrivals",
        str(arrivals_path),
        "--law",
        str(out / "law.json"),
        "--accuracy",
        scene.accuracy.preset,
    ]
    if surface_path is not None:
        args += ["--surface", str(surface_path)]
    if go_on:
        args.append("--continue")
    try:
        done = solvers.run_yade(
            solvers.repo_root() / "yade_scripts" / "shot_flow.py",
            args,
            cwd=out,
            log=out / "flow.log",
            on_line=on_line,
            outputs=(impacts_path, report_path),
        )
    except SolverFailed as e:
        raise _explained(e, report_path) from None
    try:
        impacts, header = read_impacts(impacts_path)
        report = json.loads(report_path.read_text())
    except (InputError, ValueError) as e:  # what YADE wrote is no input of the user's
        raise SolverFailed(
            "YADE ended well, but what it wrote cannot be used", cause=str(e), log=done.log
        ) from None
    if header.get("scene_hash") != scene_hash(scene):
        raise SolverFailed(
            "the impact log is of another scene", cause=f"scene hash {header.get('scene_hash')}", log=done.log
        )
    return impacts, report


def _explained(error: SolverFailed, report_path: Path) -> Exception:
    """The error that flow.json tells of, or ``error`` itself when YADE did not get to write one."""
    try:
        report = json.loads(report_path.read_text())
        kind, cause = report["kind"], report["cause"]
    except (OSError, ValueError, KeyError):
        return error
    if kind is None:  # it says that all was well: then the reason is elsewhere
        return error
    if kind == "input":
        return InputError(cause)
    if kind == "check":
        return NotConverged(
            "the shot stream's own checks failed",
            cause=cause,
            log=error.log,
            tail=error.tail,
            advice='a smaller time step: accuracy.preset = "reference"',
        )
    return SolverFailed(
        error.what,
        cause=f"{error.cause} ({cause})" if kind == "stopped" else cause,
        log=error.log,
        tail=error.tail,
        advice=error.advice,
    )
