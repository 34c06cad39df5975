"""The impact log: one row per impact of a shot on the target, the same for every flow model.

The target lies behind its surface (below z = 0 when flat); the row is the state at the moment of first
touch and after the contact.  Columns (SI, units in the names):

- ``impact_id`` 0, 1, … in order of ``time_s``; ``shot_id`` as in the arrivals
- ``time_s`` first touch, ``duration_s`` from first touch to separation
- ``x_m, y_m, z_m`` the touched point of the target, ``nx, ny, nz`` its outward normal
- ``v?_in_m_s, w?_in_rad_s`` velocity and spin just before, ``…_out_…`` just after
- ``peak_force_N`` largest total contact force (nan where the model has no forces)
- ``collisions_before`` collisions with other shots since the nozzle
- ``nozzle_id, pass_id, medium`` copied from the arrival

Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.flow.table import INTEGER, REAL, TableWriter, read_table, write_table

TITLE = "impact log"
_MOTION = [
    f"{q}{axis}_{when}_{unit}"
    for when in ("in", "out")
    for q, unit in (("v", "m_s"), ("w", "rad_s"))
    for axis in "xyz"
]
COLUMNS = np.dtype(
    [("impact_id", INTEGER), ("shot_id", INTEGER)]
    + [
        (name, REAL)
        for name in (
            "time_s",
            "duration_s",
            "x_m",
            "y_m",
            *_MOTION,
            "diameter_m",
            "density_kg_m3",
            "peak_force_N",
        )
    ]
    + [("collisions_before", INTEGER)]
    + [(name, REAL) for name in ("z_m", "nx", "ny", "nz")]
    + [(name, INTEGER) for name in ("nozzle_id", "pass_id", "medium")]
)


def impact_writer(path: Path, header: dict) -> TableWriter:
    """A writer that takes rows (tuples in the order of ``COLUMNS``) as they come; see ``TableWriter``."""
    return TableWriter(path, TITLE, COLUMNS, header)


def write_impacts(path: Path, impacts: np.ndarray, header: dict) -> None:
    """Write ``impacts`` (structured, ``COLUMNS``) whole; ``header`` should hold scene_hash and model."""
    write_table(path, TITLE, np.asarray(impacts, COLUMNS), header)


def read_impacts(path: Path, *, allow_truncated: bool = False) -> tuple[np.ndarray, dict]:
    """(impacts, header) of an impact log; a log without footer is refused unless ``allow_truncated``.

    Raises InputError with the reason (missing, other kind, other columns, truncated, damaged, a normal that
    is no unit vector, an impact that does not move into the target).
    """
    impacts, header = read_table(path, TITLE, COLUMNS, allow_truncated=allow_truncated)
    length2 = sum(impacts[name] ** 2 for name in ("nx", "ny", "nz"))
    odd = np.flatnonzero(~(np.abs(length2 - 1.0) < 1e-6))
    if odd.size:
        raise InputError(
            f"{path}: impact {impacts['impact_id'][odd[0]]} has a normal of length {length2[odd[0]] ** 0.5:g}"
            f" ({odd.size} such); the target's normal (nx, ny, nz) is a unit vector"
        )
    normal = normal_speed_m_s(impacts)
    leaving = np.flatnonzero(~(normal > 0.0))
    if leaving.size:
        raise InputError(
            f"{path}: impact {impacts['impact_id'][leaving[0]]} has a normal speed of {normal[leaving[0]]:g} m/s"
            f" ({leaving.size} such); an impact moves into the target, against its normal (v . n < 0)"
        )
    return impacts, header


def normal_speed_m_s(impacts: np.ndarray) -> np.ndarray:
    """Speed [m/s] at which each impact moves into the target, -(v . n), shape (n,): positive."""
    v, n = _vectors(impacts)
    return -sum(a * b for a, b in zip(v, n))


def tangential_velocity_m_s(impacts: np.ndarray) -> np.ndarray:
    """Velocity [m/s] of each impact along the target's surface, v - (v . n) n, shape (n, 3)."""
    v, n = _vectors(impacts)
    speed = normal_speed_m_s(impacts)
    return np.stack([a + speed * b for a, b in zip(v, n)], axis=-1)


def _vectors(impacts):
    """Velocity before the impact and normal, each a tuple of three (n,) columns."""
    v = tuple(impacts[f"v{axis}_in_m_s"] for axis in "xyz")
    return v, tuple(impacts[f"n{axis}"] for axis in "xyz")


def stream_numbers(impacts: np.ndarray, speeds_m_s) -> dict:
    """What the log says of the stream; ``speeds_m_s``: the nozzles' mean speeds, one or one per nozzle.

    ``impacts`` their number; ``mean_normal_speed_m_s`` mean of -(v . n) over all impacts;
    ``collided_fraction`` share of the shots' first impacts that came after a collision;
    ``mean_normal_energy_fraction`` mean of (v . n)^2 over the squared speed of the shot's own nozzle.
    None without impacts.
    """
    numbers = {
        "impacts": len(impacts),
        "mean_normal_speed_m_s": None,
        "collided_fraction": None,
        "mean_normal_energy_fraction": None,
    }
    if len(impacts):
        first = np.unique(impacts["shot_id"], return_index=True)[1]  # the log is in order of time
        normal = normal_speed_m_s(impacts)
        speeds = np.atleast_1d(np.asarray(speeds_m_s, dtype=float))
        own = speeds[impacts["nozzle_id"]] if speeds.size > 1 else speeds
        numbers["mean_normal_speed_m_s"] = float(normal.mean())
        numbers["collided_fraction"] = float((impacts["collisions_before"][first] > 0).mean())
        numbers["mean_normal_energy_fraction"] = float(((normal / own) ** 2).mean())
    return numbers
