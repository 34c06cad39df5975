"""Numerical errors of a run's quantities: measured at the most similar scene, in closed form where shots never meet."""

from __future__ import annotations

from collections.abc import Collection

from glue.flow.regime import collision_number, expected_errors
from glue.scene.model import Scene
from glue.study.tradeoff.lookup import numerical

_STAGES = ("dimple", "flow", "coverage", "target", "surface")


def mesh_errors(
    entry: dict, scene: Scene, metrics: dict, restitution: float, complete: Collection[str]
) -> dict[str, float]:
    """{quantity: relative error}; "raster coverage" and "raster t98" are those of the sample points alone.

    ``entry``: of the measured table; ``complete``: stages that were run.  Hits per point answer to dimple and flow
    through "t98_avrami": measured at another exposure, an error of the coverage itself would mean something else.
    """
    models = {"flow": metrics.get("flow", {}).get("model"), "target": metrics.get("target", {}).get("model")}
    stages = [s for s in _STAGES if s in complete]
    ballistic = models["flow"] == "ballistic"
    found = numerical(entry, scene, models, [s for s in stages if not (ballistic and s == "flow")])
    if ballistic:
        for name, error in ballistic_errors(scene, restitution).items():
            found[name] = (found.get(name, 0.0) ** 2 + error**2) ** 0.5
    raster = numerical(entry, scene, models, [s for s in stages if s == "coverage"])
    return found | {f"raster {name}": raster[name] for name in ("coverage", "t98") if name in raster}


def ballistic_errors(scene: Scene, restitution: float) -> dict[str, float]:
    """What leaving out collisions does, by the scene's own collision number (``glue.flow.regime``), measured anywhere.

    The energy's error E; hits per point as its root (a^2 goes with the speed), depth too; a share of the shots no
    larger than the collisions per shot.
    """
    energy = expected_errors(scene, restitution)["ballistic"]
    lost = energy / max(1.0 - energy, 0.01)  # over the energy that is really left
    met = min(collision_number(scene, restitution)["collisions_per_shot"], 1.0)
    return {"normal_energy": lost, "collided": met, "t98_avrami": 0.5 * lost, "Sa": 0.5 * lost, "Sz": 0.5 * lost}
