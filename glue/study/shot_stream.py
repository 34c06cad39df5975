"""The impacts that a scene's nozzles bring to the middle of its window: sizes, normal speeds and how many."""

from __future__ import annotations

import math

import numpy as np

from glue.errors import InputError
from glue.flow.drag import speed_after_flight, surroundings
from glue.flow.footprint import fluence_1_m2
from glue.flow.regime import expected_errors
from glue.scene import sizes
from glue.scene.model import Scene
from glue.study.flow_stage import restitution_estimate
from glue.target.strip import Stream

_SAMPLES = 120  # of a mixture; shots all alike are one


def stream_of(scene: Scene) -> Stream:
    """Expected impacts at the window's middle, mean over the scene's exposure; their number is that without collisions.

    Normal speeds are those on arrival: air drag, and the mean energy that collisions take (``energy_lost``).
    Raises InputError when no nozzle reaches the middle.
    """
    kinds = []  # (flux, nozzle, medium)
    for i, nozzle in enumerate(scene.nozzles):
        for k, shots in enumerate(scene.media):
            flux = float(fluence_1_m2(scene, 0.0, 0.0, nozzle=i, medium=k)) / scene.exposure_time_s
            if flux > 0.0:
                kinds.append((flux, nozzle, shots))
    total = sum(flux for flux, _, _ in kinds)
    if not total:
        raise InputError("no nozzle reaches the middle of the window: its saturation curve is nought; move aim_m there")
    if len(kinds) == 1 and kinds[0][2].size == "mono":
        kinds, count = [kinds[0]], 1
    else:
        count = _SAMPLES
    ends = np.cumsum([flux / total for flux, _, _ in kinds])
    columns = []
    for u in (np.arange(count) + 0.5) / count:
        k = min(int(np.searchsorted(ends, u)), len(kinds) - 1)
        low = ends[k - 1] if k else 0.0
        _, nozzle, shots = kinds[k]
        diameter = sizes.quantile_m(shots, float((u - low) / (ends[k] - low)))
        columns.append((diameter, shots.density_kg_m3, _normal_speed_m_s(scene, nozzle, shots, diameter)))
    diameter, density, speed = np.array(columns).T
    return Stream(diameter, density, speed * math.sqrt(1.0 - energy_lost(scene)), total)


def energy_lost(scene: Scene) -> float:
    """Share of the mean normal energy that collisions take from the stream, estimated (``glue.flow.regime``)."""
    return min(0.5, expected_errors(scene, restitution_estimate(scene)[0])["ballistic"])


def _normal_speed_m_s(scene: Scene, nozzle, shots, diameter_m: float) -> float:
    speed = nozzle.speed_m_s
    if scene.air_drag is not None:
        speed = speed_after_flight(speed, nozzle.stand_off_m, diameter_m, shots.density_kg_m3, surroundings(scene))
    return speed * math.sin(math.radians(nozzle.impact_angle_deg))
