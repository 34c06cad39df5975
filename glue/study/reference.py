"""The one impact that stands for all in a scene: the dimple stage solves it, the target's cell is sized by it."""

from __future__ import annotations

from glue.scene.consistency import estimated_dimple_radius_m
from glue.scene.model import Nozzle, Scene, Shots


def reference_impact(scene: Scene) -> tuple[Nozzle, Shots]:
    """The nozzle and medium whose mean shot leaves the largest dimple: it reaches deepest, so the cell must hold it.

    The others are scaled from it by diameter and density x speed^2.
    """
    pairs = [(nozzle, shots) for nozzle in scene.nozzles for shots in scene.media]
    return max(
        pairs,
        key=lambda pair: estimated_dimple_radius_m(pair[1], pair[0].normal_speed_m_s, scene.target.material),
    )
