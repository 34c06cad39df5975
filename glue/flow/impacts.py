"""The impact log: one row per impact of a shot on the target, the same for every flow model.

Target surface z = 0, target below; the row is the state at the moment of first touch and after the
contact.  Columns (SI, units in the names):

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

    Raises InputError with the reason (missing, other kind, other columns, truncated, damaged, an impact that
    does not fall).
    """
    impacts, header = read_table(path, TITLE, COLUMNS, allow_truncated=allow_truncated)
    rising = np.flatnonzero(~(impacts["vz_in_m_s"] < 0.0))
    if rising.size:
        raise InputError(
            f"{path}: impact {impacts['impact_id'][rising[0]]} has vz_in_m_s = {impacts['vz_in_m_s'][rising[0]]:g}"
            f" ({rising.size} such); the target lies below, so an impact has vz_in_m_s < 0"
        )
    return impacts, header


def stream_numbers(impacts: np.ndarray, speed_m_s: float) -> dict:
    """What the log says of the stream; ``speed_m_s`` is the nozzle's.

    ``impacts`` their number; ``mean_normal_speed_m_s`` mean of |vz| over all impacts;
    ``collided_fraction`` share of the shots' first impacts that came after a collision;
    ``mean_normal_energy_fraction`` mean of vz^2 over the nozzle speed squared.  None without impacts.
    """
    numbers = {
        "impacts": len(impacts),
        "mean_normal_speed_m_s": None,
        "collided_fraction": None,
        "mean_normal_energy_fraction": None,
    }
    if len(impacts):
        first = np.unique(impacts["shot_id"], return_index=True)[1]  # the log is in order of time
        normal = np.abs(impacts["vz_in_m_s"])
        numbers["mean_normal_speed_m_s"] = float(normal.mean())
        numbers["collided_fraction"] = float((impacts["collisions_before"][first] > 0).mean())
        numbers["mean_normal_energy_fraction"] = float((normal**2).mean() / speed_m_s**2)
    return numbers
