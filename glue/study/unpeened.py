"""What the target stage reports when the shots missed the window: nothing to solve, yet no reason to stop."""

from __future__ import annotations

import numpy as np

from glue.scene.model import Scene
from glue.target.dimple import Dimple

# What a model reports of itself in metrics.json.
_PATCH = ("exposure", "window_exposure", "neglected_energy_share", "unresolved_energy_share", "balance_error", "dofs",
          "Sa_m", "Sq_m", "Sz_m", "Ssk", "surface_side_m", "surface_remark", "patches", "unresolved_impacts")  # fmt: skip
_OWN = {
    "cell": (*_PATCH, "nominal_depth_error", "nominal_force_error"),
    "contact": (*_PATCH, "strain", "restitution_mean", "restitution_flow_mean", "restitution_fresh", "restitution_flow_fresh"),
    "layers": ("exposure", "dofs"),
}  # fmt: skip


def impacts_to_solve(scene: Scene, impacts: np.ndarray, dimple: Dimple) -> int:
    """How many impacts fall into the cells that tile the window's middle, of which the target stage solves one."""
    side = scene.accuracy.cell_side_in_radii * dimple.radius_m
    half = [0.5 * side * (w // side) for w in scene.target.window_m]
    return int(((abs(impacts["x_m"]) <= half[0]) & (abs(impacts["y_m"]) <= half[1])).sum())


def unpeened(scene: Scene) -> dict:
    """The target's sections of metrics.json when nothing struck the window: null, with the reason."""
    model = scene.models.target.model
    nothing = "no impact inside the window's cells; a longer exposure_time_s is needed"

    def unknown(*keys: str) -> dict:
        return {key: None for key in keys} | {f"{key}_reason": nothing for key in keys}

    return {
        "target": {"model": model, "impacts": 0, "wall_s": 0.0} | unknown(*_OWN[model]),
        "residual_stress": unknown(
            "surface_Pa", "max_compressive_Pa", "max_compressive_depth_m", "compressive_depth_m", "tenth_depth_m",
            "force_balance_N_m", "force_balance_relative", "moment_balance_relative", "arc_height_m",
        ),
        "coverage": unknown("peeq_final", *(("peeq_threshold", "peeq_027_final") if model == "cell" else ())),
    }  # fmt: skip
