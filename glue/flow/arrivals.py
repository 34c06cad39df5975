"""The shots that leave the nozzles: drawn once per scene, read by every flow model.

Each shot has its exact time and place on its nozzle's exit, its velocity, size and medium; no two overlap
there.  How many, when and of what: ``nozzle_draws.py``; where, so that they do not overlap: ``inlet.py``.

Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.flow.inlet import overlapping, place
from glue.flow.nozzle_draws import draw_nozzle, expected_shots
from glue.flow.table import INTEGER, REAL, read_table, write_table
from glue.scene.consistency import GAUSSIAN_PEAK, mixture_volume_fraction
from glue.scene.model import Nozzle, Scene
from glue.scene.schema import MAX_VOLUME_FRACTION

__all__ = [
    "COLUMNS",
    "check_stream",
    "draw_arrivals",
    "overlapping",
    "read_arrivals",
    "scene_hash",
    "solids_share",
    "write_arrivals",
]

TITLE = "shot arrivals"
COLUMNS = np.dtype(
    [("shot_id", INTEGER)]
    + [
        (name, REAL)
        for name in (
            "time_s",
            "x_m",
            "y_m",
            "z_m",
            "vx_m_s",
            "vy_m_s",
            "vz_m_s",
            "diameter_m",
            "density_kg_m3",
        )
    ]
    + [(name, INTEGER) for name in ("nozzle_id", "pass_id", "medium")]
)

MAX_SHOTS = 20_000_000
TRIAL_SHOTS = 10_000  # drawn to find out whether a larger stream can be


def scene_hash(scene: Scene) -> str:
    """sha256 (hex) of everything the scene says; ties logs to their scene."""
    content = dataclasses.asdict(scene)
    content.pop("defaults_used")  # a value is the same whether written or defaulted
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def draw_arrivals(scene: Scene) -> np.ndarray:
    """Shots leaving the nozzles in [0, exposure), sorted by time: structured (``COLUMNS``), shape (n,).

    ``time_s`` is when the shot's centre crosses its nozzle's exit plane (the disc perpendicular to the axis,
    ``stand_off_m`` before the aim point of that time) and the position is where.  ``nozzle_id`` and ``medium``
    index ``scene.nozzles`` and ``scene.media``; ``pass_id`` is the feed's pass at that time.

    Of several media each shot is of medium k with probability in proportion to mass_fraction / mean mass.
    "poisson" arrivals are Poisson in count with the pulse's rate; "exact_mass" arrivals feed, per nozzle and
    medium, the mass flow times the integral of the pulse to within half a shot, at independent random times.

    Raises InputError when there are too many shots, or when they cannot be placed without overlap.
    """
    expected = expected_shots(scene)
    if expected > MAX_SHOTS:
        raise _too_many(expected)
    _check_solids(scene)
    draws = [draw_nozzle(scene, k) for k in range(len(scene.nozzles))]
    parts = []
    for number, (draw, leaving) in enumerate(zip(draws, place(draws, scene.seed))):
        part = np.zeros(len(draw.time_s), COLUMNS)
        part["time_s"], part["diameter_m"] = draw.time_s, draw.diameter_m
        for axis, name in enumerate("xyz"):
            part[f"{name}_m"] = leaving.positions_m[axis]
            part[f"v{name}_m_s"] = leaving.velocities_m_s[axis]
        part["density_kg_m3"] = np.array([shots.density_kg_m3 for shots in scene.media])[draw.medium]
        part["nozzle_id"], part["pass_id"], part["medium"] = number, draw.pass_id, draw.medium
        parts.append(part)
    arrivals = np.concatenate(parts)
    if len(parts) > 1:
        arrivals = arrivals[np.argsort(arrivals["time_s"], kind="stable")]
    arrivals["shot_id"] = np.arange(len(arrivals))
    return arrivals


def solids_share(scene: Scene, index: int) -> float:
    """Share of nozzle ``index``'s jet at its exit that is shot, where and when it is densest."""
    nozzle = scene.nozzles[index]
    crowding = _peak(nozzle) * (GAUSSIAN_PEAK if nozzle.profile == "gaussian" else 1.0)
    return crowding * mixture_volume_fraction(scene.media, nozzle)


def check_stream(scene: Scene) -> None:
    """Raise InputError for a scene whose shots cannot be drawn, or that by chance has none: before hours of work.

    A small stream is drawn whole.  Of a large one ``TRIAL_SHOTS`` are drawn, all nozzles together, each at its
    peak flow all the time.
    """
    expected = expected_shots(scene)
    if expected <= 2 * TRIAL_SHOTS:
        if not len(draw_arrivals(scene)):
            raise InputError(
                f"no shot leaves the nozzle: {expected:.3g} expected, none drawn with seed {scene.seed};"
                " raise exposure_time_s or mass_flow_kg_s"
            )
        return
    if expected > MAX_SHOTS:
        raise _too_many(expected)
    peak = tuple(
        dataclasses.replace(n, pulse=None, mass_flow_kg_s=n.mass_flow_kg_s * _peak(n)) for n in scene.nozzles
    )
    trial = dataclasses.replace(scene, nozzles=peak, arrivals="poisson")
    draw_arrivals(dataclasses.replace(trial, exposure_time_s=TRIAL_SHOTS / trial.shot_rate_1_s))


def write_arrivals(path: Path, arrivals: np.ndarray, scene_hash: str) -> None:
    """Write ``arrivals`` (from ``draw_arrivals``) as ``arrivals.csv``; every double survives exactly."""
    write_table(path, TITLE, arrivals, {"scene_hash": scene_hash})


def read_arrivals(path: Path) -> tuple[np.ndarray, dict]:
    """(arrivals, header) of a file written by ``write_arrivals``; InputError when it is not whole."""
    return read_table(path, TITLE, COLUMNS)


def _peak(nozzle: Nozzle) -> float:
    """Largest over mean mass flow."""
    return nozzle.pulse.peak if nozzle.pulse else 1.0


def _too_many(expected: float) -> InputError:
    return InputError(
        f"the scene feeds {expected:.3g} shots; at most {MAX_SHOTS:.0e} can be drawn: shorten exposure_time_s"
    )


def _check_solids(scene: Scene) -> None:
    """Refuse at once what would be drawn for long and in vain.

    Jets 5 and 20 shots wide, 26 draws of 2000 to 200 000 shots: all can be drawn at the limit, at .18 not even
    every short one, at .25 none.  (A Gaussian jet can be drawn beyond, but would not be Gaussian.)
    """
    for number, nozzle in enumerate(scene.nozzles):
        share = solids_share(scene, number)
        if share > MAX_VOLUME_FRACTION:
            raise InputError(
                f"shot stream too dense: shots fill {share:.1%} of the jet of nozzle {number + 1} at its densest;"
                f" allowed up to {MAX_VOLUME_FRACTION:.0%}: lower mass_flow_kg_s"
                f" (to {nozzle.mass_flow_kg_s * MAX_VOLUME_FRACTION / share:.3g} kg/s), or raise speed_m_s,"
                " jet_diameter_m or the duty of a pulse"
            )
