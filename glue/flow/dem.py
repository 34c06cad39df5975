"""The shot stream in YADE: draws the arrivals, runs ``yade_scripts/shot_flow.py``, reads its log."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue import solvers
from glue.errors import InputError, NotConverged, SolverFailed
from glue.flow.arrivals import draw_arrivals, scene_hash, write_arrivals
from glue.flow.impacts import read_impacts, stream_numbers
from glue.flow.regime import collision_number
from glue.scene.model import Scene

_PROGRESS = re.compile(r"progress (\S+) eta_s (\S+)")


class FlowResult(NamedTuple):
    """Where the logs are, the impacts (``glue.flow.impacts.COLUMNS``) and the numbers of the run."""

    impacts_path: Path
    impacts: np.ndarray
    arrivals_path: Path
    info: dict


def run_dem(
    scene: Scene,
    scene_file: Path,
    out: Path,
    *,
    shot_target_restitution: float,
    progress: Callable[[float, str], None] | None = None,
) -> FlowResult:
    """Simulate every shot of ``scene``; writes arrivals.csv, impacts.csv, flow.json, flow.log into ``out``.

    ``scene_file`` is the file that ``scene`` was read from: YADE reads it again, and refuses arrivals of
    another scene.  ``info`` holds model, collision_number (Pi_eff), impacts, mean_normal_speed_m_s,
    collided_fraction, mean_normal_energy_fraction, wall_s and all of flow.json (time step, steps,
    calibrated restitution, where every shot went, the checks).

    Raises InputError when the scene cannot be simulated (empty or too dense stream, restitution, time
    step), NotConverged when a check of the run failed, SolverFailed when YADE stopped otherwise; the
    log so far stays as impacts.csv.part.
    """
    out = Path(out).resolve()
    out.mkdir(parents=True, exist_ok=True)
    arrivals_path, impacts_path, report_path = out / "arrivals.csv", out / "impacts.csv", out / "flow.json"
    report_path.unlink(missing_ok=True)  # a stopped run must not be explained by an older one's report
    digest = scene_hash(scene)
    numbers = collision_number(scene, shot_target_restitution)
    write_arrivals(arrivals_path, draw_arrivals(scene), digest)

    def on_line(line: str) -> None:
        if progress and (found := _PROGRESS.match(line)):
            progress(float(found[1]), f"{float(found[2]):.0f} s left in YADE")

    args = [
        str(Path(scene_file).resolve()),
        str(out),
        "--arrivals",
        str(arrivals_path),
        "--restitution",
        repr(float(shot_target_restitution)),
        "--accuracy",
        scene.accuracy.preset,
    ]
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
    if header.get("scene_hash") != digest:
        raise SolverFailed(
            "the impact log is of another scene", cause=f"scene hash {header.get('scene_hash')}", log=done.log
        )
    info = {
        **report,
        **stream_numbers(impacts, scene.nozzle.speed_m_s),
        "model": "dem",
        "collision_number": numbers["pi_eff"],
        "wall_s": done.wall_s,
    }
    return FlowResult(impacts_path, impacts, arrivals_path, info)


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
