"""Outlines of the jets on the target and the ways that they travel, for drawing."""

from __future__ import annotations

import math

import numpy as np

from glue.scene.model import Nozzle, Scene

_POINTS = 121


def jets_of(scene: Scene) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """(footprint where it starts, way of its aim point or None) of every nozzle, each (k, 2) [m] on z = 0."""
    return [
        (footprint(nozzle), None if nozzle.feed is None else way(nozzle, scene.exposure_time_s))
        for nozzle in scene.nozzles
    ]


def footprint(nozzle: Nozzle, time_s: float = 0.0) -> np.ndarray:
    """Closed outline (k, 2) of what the jet strikes on z = 0: rays from the exit's edge, tilted by the half-angle."""
    aim_x, aim_y, _ = nozzle.aim_at(time_s)
    direction = np.array(nozzle.direction)
    round_ = np.linspace(0.0, 2.0 * math.pi, _POINTS)[:, None]
    outward = np.cos(round_) * np.array(nozzle.exit_axes[0]) + np.sin(round_) * np.array(nozzle.exit_axes[1])
    start = -nozzle.stand_off_m * direction + 0.5 * nozzle.jet_diameter_m * outward
    ray = direction + math.tan(math.radians(nozzle.divergence_half_angle_deg)) * outward
    on_target = start - ray * (start[:, 2] / ray[:, 2])[:, None]
    return on_target[:, :2] + [aim_x, aim_y]


def way(nozzle: Nozzle, until_s: float) -> np.ndarray:
    """Corners (k, 2) of the aim point's way until ``until_s``: ends of strokes."""
    feed = nozzle.feed
    stroke_s = feed.stroke_m / feed.speed_m_s
    begins = [k * (stroke_s + feed.dwell_s) for k in range(feed.passes)]
    times = [t for begin in begins for t in (begin, begin + stroke_s) if t < until_s]
    return np.array([nozzle.aim_at(t)[:2] for t in [*times, until_s]])
