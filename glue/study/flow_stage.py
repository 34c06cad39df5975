"""The stage ``flow``: what restitution the shots get, which model runs, what is told of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.flow import surface
from glue.flow.arrivals import check_stream
from glue.flow.imported import IMPORTED, check_imported, use_imported
from glue.flow.regime import choose_flow
from glue.flow.restitution import LARGEST, RestitutionLaw
from glue.flow.run import check_law, run_flow
from glue.scene.model import Scene
from glue.study.results import load_dimple, plain
from glue.study.stage import Work
from glue.study.target_surface import target_triangles

# Of a rigid 1 mm steel shot on 2024 at 60 m/s: a guess of the restitution until the dimple is computed.
RESTITUTION_GUESS = 0.34
_METRICS = (
    "model", "why", "collision_number", "impacts", "mean_normal_speed_m_s", "collided_fraction",
    "mean_normal_energy_fraction", "wall_s",
)  # fmt: skip


def flow_stage(work: Work) -> tuple[dict, list[str]]:
    """Every shot's way from the nozzle to the target; writes the impact log."""
    law = restitution_law(work.scene, load_dimple(work.path))
    if (work.path / IMPORTED).exists():
        shape = surface.from_scene(work.scene, target_triangles(work.scene, work.scene_file))
        info = use_imported(work.scene, work.path / IMPORTED, work.path / "flow", shape, law.e)
        return {"flow": _told(info)}, ["flow/impacts.csv", "flow/flow.json"]
    flow = run_flow(
        work.scene,
        work.scene_file,
        work.path / "flow",
        law=law,
        surface_triangles=target_triangles(work.scene, work.scene_file),
        progress=work.progress,
        go_on=work.go_on,
    )
    return {"flow": _told(flow.info)}, ["flow/arrivals.csv", "flow/impacts.csv", "flow/flow.json"]


def _told(info: dict) -> dict:
    """The section ``flow`` of metrics.json."""
    metrics = plain({k: info[k] for k in _METRICS})
    if info["warnings"]:
        metrics["warning"] = "; ".join(info["warnings"])
    if info["physics"]:
        metrics["physics"] = info["physics"]
    return metrics


def restitution_law(scene: Scene, dimple) -> RestitutionLaw:
    """Restitution on the target: the scene's number, or the dimple's table over the normal speed.

    The dimple's holds for shots of its density; others rebound as if faster or slower by the root of the ratio, as
    their dimples are.  Spots that were struck before are as wide as the dimple.  Raises InputError for a dimple whose rebound is
    none.
    """
    asked, hardening = scene.restitution.shot_target, scene.restitution.hardening
    e, exponent, points, density = asked, 0.0, (), 0.0
    if asked == "from_dimple":
        e, exponent = dimple.restitution, dimple.restitution_exponent
        if not (0.0 < e < 1.0 and -0.1 < exponent < 1.0):
            raise InputError(
                f"restitution.shot_target = from_dimple: the dimple gives {e:.3f} falling with the speed to the power"
                f" {exponent:.2f}; expected between 0 and 1 and 0 to 1; write a number into the scene"
            )
        density = dimple.density_kg_m3
        if dimple.table_speed_m_s.size > 1:
            # Never rising, whatever the solved values' scatter of a hundredth.
            falling = np.minimum.accumulate(np.minimum(dimple.table_restitution, 1.0))
            points = tuple(zip(dimple.table_speed_m_s.tolist(), falling.tolist(), strict=True))
    highest = max(e, hardening.saturated if hardening else 0.0)
    return RestitutionLaw(
        e,
        dimple.speed_m_s,
        max(exponent, 0.0),  # a trace below zero is the dimple's own numerical error
        largest=LARGEST if highest <= LARGEST else 1.0,
        hardening=hardening,
        spot_radius_m=dimple.radius_m,
        points=points,
        density_kg_m3=density,
    )


def restitution_estimate(scene: Scene, path: Path | None = None) -> tuple[float, str]:
    """(restitution, where it is from) before the flow runs: the scene's, the dimple's in ``path``, or a guess."""
    asked = scene.restitution.shot_target
    if asked != "from_dimple":
        return asked, "the scene"
    if path is not None:
        try:
            e = load_dimple(path).restitution
            if 0.0 < e <= 1.0 and math.isfinite(e):
                return e, "the dimple"
        except InputError:
            pass
    return RESTITUTION_GUESS, "guess until the dimple is computed"


def flow_solvers(scene: Scene, path: Path) -> tuple[str, ...]:
    """YADE, but only where the flow model is that of contacts, and none where the log is from elsewhere."""
    if (path / IMPORTED).exists():
        return ()
    e, _ = restitution_estimate(scene, path)
    return ("yade",) if choose_flow(scene, e).model == "dem" else ()


def refuse_flow(scene: Scene, scene_file: Path) -> None:
    """Raise InputError for what the flow would refuse, hours of a dimple later: stream, surface, restitution."""
    check_stream(scene)
    triangles, log = target_triangles(scene, scene_file), scene_file.with_name(IMPORTED)
    if log.exists():
        check_imported(scene, log, surface.from_scene(scene, triangles))
    asked = scene.restitution.shot_target
    if asked != "from_dimple":
        hardening = scene.restitution.hardening
        highest = max(asked, hardening.saturated if hardening else 0.0)
        law = RestitutionLaw(asked, largest=max(LARGEST, highest))
        check_law(law, choose_flow(scene, asked).model)
