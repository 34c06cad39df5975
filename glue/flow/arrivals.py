"""The shots that leave the nozzle: drawn once per scene, read by every flow model.

Poisson in time over a fixed horizon, uniform over the jet's disc, each shot with its exact time and
place.  The same seed gives the same bits under every numpy: only ``Generator.random`` (PCG64, a
fixed algorithm) is taken from it, and logarithms come from the C library by ``math``, because
numpy's own vectorised ones differ in the last bit between releases.

Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from pathlib import Path
from statistics import NormalDist

import numpy as np

from glue.errors import InputError
from glue.flow.table import INTEGER, REAL, read_table, write_table
from glue.scene.model import Scene
from glue.scene.sizes import CUT_SD

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

SIZE_CUT_SD = CUT_SD  # shots are sieved: no diameter further than this from the mean
MAX_REDRAWS = 200  # rounds of new lateral positions; a stream that needs them all is a solid bar, not a jet
MAX_SHOTS = 20_000_000


def scene_hash(scene: Scene) -> str:
    """sha256 (hex) of everything the scene says; ties logs to their scene."""
    content = dataclasses.asdict(scene)
    content.pop("defaults_used")  # a value is the same whether written or defaulted
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def largest_diameter_m(scene: Scene) -> float:
    """Largest diameter [m] that ``draw_arrivals`` can draw."""
    spread = SIZE_CUT_SD * scene.shots.size_cv if scene.shots.size == "distribution" else 0.0
    return scene.shots.diameter_m * (1.0 + spread)


def smallest_diameter_m(scene: Scene) -> float:
    """Smallest diameter [m] that ``draw_arrivals`` can draw: it sets the time step of a DEM run."""
    return 2.0 * scene.shots.diameter_m - largest_diameter_m(scene)


def draw_arrivals(scene: Scene) -> np.ndarray:
    """Shots leaving the nozzle in [0, exposure), sorted by time: structured (``COLUMNS``), shape (n,).

    ``time_s`` is when the shot's centre crosses the nozzle's exit plane (the disc perpendicular to the
    flight, ``stand_off_m`` before the origin) and the position is where; all fly at the same velocity,
    so that shots which do not overlap here never meet before the first of them rebounds.  Diameters are
    all equal or truncated normal (mean ``diameter_m``, ``size_cv``, cut at 2.5 standard deviations).

    Raises InputError when the stream is so dense that shots cannot be placed without overlap.
    """
    if scene.expected_shots > MAX_SHOTS:
        raise InputError(
            f"the scene feeds {scene.expected_shots:.3g} shots; at most {MAX_SHOTS:.0e} can be drawn:"
            " shorten exposure_time_s"
        )
    # separate streams, so that redrawing positions leaves times and sizes as they are
    of_time, of_place, of_size = (
        np.random.Generator(np.random.PCG64(s)) for s in np.random.SeedSequence(scene.seed).spawn(3)
    )
    times = _poisson_times(of_time, scene.shot_rate_1_s, scene.exposure_time_s)
    n = len(times)
    diameters = _diameters(of_size, scene, n)
    across = _place(of_place, scene, times, diameters)

    dx, _, dz = scene.nozzle.direction
    a, b = across.T  # along (-dz, 0, dx), the disc's axis in the x-z plane, and along y
    arrivals = np.zeros(n, COLUMNS)
    arrivals["shot_id"] = np.arange(n)
    arrivals["time_s"] = times
    arrivals["x_m"] = -scene.nozzle.stand_off_m * dx - a * dz
    arrivals["y_m"] = b
    arrivals["z_m"] = -scene.nozzle.stand_off_m * dz + a * dx
    arrivals["vx_m_s"] = scene.nozzle.speed_m_s * dx
    arrivals["vz_m_s"] = scene.nozzle.speed_m_s * dz
    arrivals["diameter_m"] = diameters
    arrivals["density_kg_m3"] = scene.shots.density_kg_m3
    return arrivals


def check_stream(scene: Scene) -> None:
    """Raise InputError for a scene whose shots cannot be drawn, or that by chance has none: before hours of work."""
    if not len(draw_arrivals(scene)):
        raise InputError(
            f"no shot leaves the nozzle: {scene.expected_shots:.3g} expected, none drawn with seed {scene.seed};"
            " raise exposure_time_s or mass_flow_kg_s"
        )


def write_arrivals(path: Path, arrivals: np.ndarray, scene_hash: str) -> None:
    """Write ``arrivals`` (from ``draw_arrivals``) as ``arrivals.csv``; every double survives exactly."""
    write_table(path, TITLE, arrivals, {"scene_hash": scene_hash})


def read_arrivals(path: Path) -> tuple[np.ndarray, dict]:
    """(arrivals, header) of a file written by ``write_arrivals``; InputError when it is not whole."""
    return read_table(path, TITLE, COLUMNS)


def _poisson_times(rng, rate_1_s: float, horizon_s: float) -> np.ndarray:
    """Arrival times of a Poisson process in [0, horizon): sums of exponential gaps, shape (n,)."""
    times, now = [], 0.0
    while True:
        for u in rng.random(4096).tolist():
            now -= math.log1p(-u) / rate_1_s
            if now >= horizon_s:
                return np.array(times)
            times.append(now)


def _diameters(rng, scene: Scene, n: int) -> np.ndarray:
    """Shape (n,): the mean, or truncated normal by inversion of its distribution function."""
    shots = scene.shots
    if shots.size == "mono":
        return np.full(n, shots.diameter_m)
    normal = NormalDist()
    low = normal.cdf(-SIZE_CUT_SD)
    sizes = (normal.inv_cdf(low + u * (1.0 - 2.0 * low)) for u in rng.random(n).tolist())
    return np.array([shots.diameter_m * (1.0 + shots.size_cv * z) for z in sizes])


def _in_disc(rng, n: int) -> np.ndarray:
    """Uniform in the unit disc, shape (n, 2): by rejection, which needs no sine or square root."""
    points = np.empty((0, 2))
    while len(points) < n:
        square = 2.0 * rng.random((2 * (n - len(points)) + 8, 2)) - 1.0
        points = np.concatenate([points, square[square[:, 0] ** 2 + square[:, 1] ** 2 < 1.0]])
    return points[:n]


def _place(rng, scene: Scene, times: np.ndarray, diameters: np.ndarray) -> np.ndarray:
    """Lateral positions [m] of the centres, shape (n, 2), redrawn until no two shots overlap."""
    radius = 0.5 * scene.nozzle.jet_diameter_m
    along = scene.nozzle.speed_m_s * times
    across = radius * _in_disc(rng, len(times))
    for _ in range(MAX_REDRAWS):
        late = overlapping(along, across, diameters)
        if not len(late):
            return across
        across[late] = radius * _in_disc(rng, len(late))
    share = (
        scene.shot_rate_1_s
        * math.pi
        / 6.0
        * scene.shots.diameter_m**3
        / (math.pi * radius**2 * scene.nozzle.speed_m_s)
    )
    raise InputError(
        f"shot stream too dense: {len(late)} of {len(times)} shots still overlap another at the nozzle after"
        f" {MAX_REDRAWS} draws (shots fill {share:.1%} of the jet): lower mass_flow_kg_s, or raise speed_m_s"
        " or jet_diameter_m"
    )


def overlapping(along: np.ndarray, across: np.ndarray, diameters: np.ndarray) -> np.ndarray:
    """Indices (sorted) of shots that overlap an earlier one.

    All fly at one velocity, so their distance never changes: sqrt(along^2 + across^2) against the mean
    of the two diameters.  ``along`` (n,) [m] ascending, ``across`` (n, 2) [m], ``diameters`` (n,) [m].
    """
    reach = diameters.max(initial=0.0)
    late = np.zeros(len(along), bool)
    for lag in range(1, len(along)):
        gap = along[lag:] - along[:-lag]
        near = np.flatnonzero(gap < reach)
        if not len(near):
            break  # sorted: a larger lag only widens the gap
        later = near + lag
        distance2 = gap[near] ** 2 + ((across[later] - across[near]) ** 2).sum(axis=1)
        late[later[distance2 <= (0.5 * (diameters[later] + diameters[near])) ** 2]] = True
    return np.flatnonzero(late)
