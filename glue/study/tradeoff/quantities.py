"""What a user reads off a run, and on which scale an error of it counts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Quantity(NamedTuple):
    """``section`` and ``key`` of metrics.json; errors are relative to ``scale``: "own", "one" or another key's value."""

    name: str
    section: str
    key: str
    label: str
    stage: str  # that finds it
    scale: str = "own"
    headline: bool = False  # counts for --target-error
    unit: str = ""
    factor: float = 1.0  # to the unit
    digits: int = 3


QUANTITIES = (
    Quantity("dimple_radius", "dimple", "radius_m", "dimple radius", "dimple", headline=True, unit="µm", factor=1e6, digits=1),
    Quantity("dimple_depth", "dimple", "depth_m", "dimple depth", "dimple", headline=True, unit="µm", factor=1e6, digits=1),
    Quantity("restitution", "dimple", "restitution", "restitution", "dimple", headline=True),
    Quantity("peak_force", "dimple", "peak_force_N", "peak force", "dimple", headline=True, unit="N", digits=1),
    Quantity("normal_energy", "flow", "mean_normal_energy_fraction", "mean normal energy", "flow", headline=True),
    Quantity("collided", "flow", "collided_fraction", "share that collided", "flow", scale="one"),
    Quantity("coverage", "coverage", "final", "coverage at the end", "coverage", scale="one", headline=True, digits=4),
    Quantity("t98", "coverage", "time_98_s", "t98", "coverage", headline=True, unit="s"),
    Quantity("t98_avrami", "coverage", "avrami_time_98_s", "t98, Avrami", "coverage", unit="s"),
    Quantity("surface_stress", "residual_stress", "surface_Pa", "surface stress", "target", scale="max_compressive_Pa",
             headline=True, unit="MPa", factor=1e-6, digits=1),
    Quantity("largest_stress", "residual_stress", "max_compressive_Pa", "largest compression", "target", headline=True,
             unit="MPa", factor=1e-6, digits=1),
    Quantity("largest_depth", "residual_stress", "max_compressive_depth_m", "its depth", "target",
             scale="tenth_depth_m", headline=True, unit="µm", factor=1e6, digits=0),
    Quantity("sign_change", "residual_stress", "compressive_depth_m", "sign-change depth", "target", unit="µm", factor=1e6,
             digits=0),
    Quantity("tenth_depth", "residual_stress", "tenth_depth_m", "depth of a tenth", "target", headline=True, unit="µm",
             factor=1e6, digits=0),
    Quantity("Sa", "roughness", "Sa_m", "Sa", "surface", headline=True, unit="µm", factor=1e6, digits=2),
    Quantity("Sz", "roughness", "Sz_m", "Sz", "surface", unit="µm", factor=1e6, digits=1),
)  # fmt: skip
BY_NAME = {q.name: q for q in QUANTITIES}


def values(metrics: Mapping) -> dict[str, float]:
    """{quantity: value} of those that metrics.json tells."""
    found = {q.name: metrics.get(q.section, {}).get(q.key) for q in QUANTITIES}
    return {name: float(value) for name, value in found.items() if value is not None}


def scales(metrics: Mapping) -> dict[str, float]:
    """{quantity: what its error is divided by}, from the metrics of the run that is taken as right."""
    own = values(metrics)
    found = {}
    for q in QUANTITIES:
        if q.name in own:
            other = own[q.name] if q.scale == "own" else metrics[q.section].get(q.scale)
            found[q.name] = 1.0 if q.scale == "one" else abs(float(other or own[q.name]))
    return {name: scale for name, scale in found.items() if scale > 0.0}
