"""The shot stream by whichever model the scene needs: arrivals, impact log and a record of the run.

``run_flow`` is the one entrance: it draws the arrivals once, resolves what the scene leaves to "auto", runs the
ballistic, event-driven or contact (YADE) model on them and checks what came out.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.atomic import write_text_atomic
from glue.errors import InputError, NotConverged
from glue.flow import regime, surface
from glue.flow.arrivals import draw_arrivals, read_arrivals, scene_hash, write_arrivals
from glue.flow.dem import run_dem
from glue.flow.impacts import impact_writer, stream_numbers
from glue.flow.log_checks import log_problems
from glue.flow.restitution import LARGEST, RestitutionLaw
from glue.flow.table import TableWriter
from glue.scene.model import Scene

CHECKPOINT = "flow.checkpoint.npz"  # gone when the run has ended
MANY_IMPACTS = 3.0  # per shot that struck: without gravity and gas it is 1.0 to 1.1


class FlowResult(NamedTuple):
    """Where the logs are, the impacts (``glue.flow.impacts.COLUMNS``) and the numbers of the run."""

    impacts_path: Path
    impacts: np.ndarray
    arrivals_path: Path
    info: dict


def run_flow(
    scene: Scene,
    scene_file: Path,
    out: Path,
    *,
    law: RestitutionLaw,
    surface_triangles: np.ndarray | None = None,
    progress: Callable[[float, str], None] | None = None,
    go_on: bool = False,
) -> FlowResult:
    """Simulate every shot of ``scene``; writes arrivals.csv, impacts.csv and flow.json into ``out``.

    ``scene_file``: the file that ``scene`` was read from (YADE reads it again).  ``law``: restitution on the
    target.  ``surface_triangles`` (m, 3, 3) [m]: those of an "stl" target.  ``go_on``: continue what a stopped
    run of the same inputs left in ``out``, where its model can.

    ``info`` (also flow.json): model, why, warnings, collision_number (pi_eff), impacts, mean_normal_speed_m_s,
    collided_fraction, mean_normal_energy_fraction, wall_s, physics (what "auto" blocks came to), restitution
    (the law), and the model's own numbers.

    Raises InputError for what cannot be simulated, NotConverged when a check of the run failed, SolverFailed
    when YADE stopped otherwise.
    """
    out = Path(out).resolve()
    out.mkdir(parents=True, exist_ok=True)
    arrivals_path, impacts_path, report_path = out / "arrivals.csv", out / "impacts.csv", out / "flow.json"
    start, digest = time.monotonic(), scene_hash(scene)
    choice, physics = regime.choose_flow(scene, law.e), regime.resolve_physics(scene)
    check_law(law, choice.model)
    shape = surface.from_scene(scene, surface_triangles)
    numbers = regime.collision_number(scene, law.e)
    arrivals = _arrivals(scene, arrivals_path, digest, go_on)
    if not go_on:
        for stale in out.glob(f"{CHECKPOINT}*"):
            stale.unlink()

    report_path.unlink(missing_ok=True)  # a stopped run must not be explained by an older one's report
    if choice.model == "dem":
        surface_path = None
        if shape.kind == surface.TRIANGLES:
            surface_path = out / "surface.npz"
            shape.save(surface_path)
        impacts, own = run_dem(
            scene, scene_file, out, law=law, arrivals_path=arrivals_path, surface_path=surface_path,
            progress=progress, go_on=go_on,
        )  # fmt: skip
    else:
        header = {"scene_hash": digest, "model": choice.model, "restitution": law.as_dict()}
        writer = impact_writer(impacts_path, header)
        try:
            impacts, own = _compiled(choice.model, out / CHECKPOINT, progress, go_on)(
                physics.scene, arrivals, law, shape, lambda rows: _append(writer, rows)
            )
            problems = log_problems(physics.scene, arrivals, impacts, shape)
            if problems:
                raise NotConverged(
                    f"the {choice.model} flow's own checks failed", cause="; ".join(problems), log=writer.part
                )
        except BaseException:  # Ctrl-C too: what was found so far stays, as impacts.csv.part
            writer.abandon()
            raise
        writer.finish()
    info = {
        **own,
        **stream_numbers(impacts, [nozzle.speed_m_s for nozzle in scene.nozzles]),
        "model": choice.model,
        "why": choice.why,
        "warnings": [*choice.warnings, *_warnings(impacts)],
        "collision_number": numbers["pi_eff"],
        "physics": {block: vars(decided) for block, decided in physics.choices.items()},
        "restitution": law.as_dict(),
        "wall_s": time.monotonic() - start,
    }
    write_text_atomic(report_path, json.dumps(info, indent=2, default=_plain) + "\n")
    return FlowResult(impacts_path, impacts, arrivals_path, info)


def _warnings(impacts: np.ndarray) -> list[str]:
    """What a log that is right may still leave a user to wonder at."""
    shots = len(np.unique(impacts["shot_id"]))
    if not shots or len(impacts) <= MANY_IMPACTS * shots:
        return []
    return [
        f"{len(impacts) / shots:.1f} impacts per shot: gravity or blowing gas throws rebounds back, and means over impacts"
        " speak of faint ones; air_drag.gas_speed_m_s blows through the target, where real gas turns aside"
    ]


def check_law(law: RestitutionLaw, model: str) -> None:
    """Raise InputError for a restitution that the contact law of YADE cannot have; other models take any."""
    highest = max(law.e, law.hardening.saturated if law.hardening else 0.0)
    if model == "dem" and LARGEST < highest and law.e != 1.0:
        raise InputError(
            f"restitution on the target {highest:.3f}: models.flow = dem resolves contacts, whose restitution saturates above"
            f' {LARGEST}; allowed (0, {LARGEST}] or exactly 1, or models.flow = "event"'
        )


def _arrivals(scene: Scene, path: Path, digest: str, go_on: bool) -> np.ndarray:
    """The stream, drawn and written; a stopped run's own when it is whole."""
    if go_on and path.exists():
        try:
            arrivals, header = read_arrivals(path)
            if header.get("scene_hash") == digest:
                return arrivals
        except InputError:
            pass  # stopped while it was written
    arrivals = draw_arrivals(scene)
    write_arrivals(path, arrivals, digest)
    return arrivals


def _compiled(model: str, checkpoint: Path, progress, go_on: bool):
    """The model as a function (scene, arrivals, law, surface, takes impacts as they come) -> (impacts, info)."""
    if model == "ballistic":
        from glue.flow.ballistic import run_ballistic  # here: loads numba

        def whole(scene, arrivals, law, shape, on_impacts):
            impacts, info = run_ballistic(scene, arrivals, law, shape)
            on_impacts(impacts)
            return impacts, info

        return whole
    from glue.flow.event_driven import run_event

    return lambda scene, arrivals, law, shape, on_impacts: run_event(
        scene, arrivals, law, shape, progress=progress, on_impacts=on_impacts, checkpoint=checkpoint, resume=go_on
    )


def _append(writer: TableWriter, impacts: np.ndarray) -> None:
    """Write rows and hand them to the operating system: they outlive this process."""
    writer.write(impacts.tolist())
    writer.flush()


def _plain(value):
    """numpy's numbers as Python's, for JSON."""
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} in flow.json")
