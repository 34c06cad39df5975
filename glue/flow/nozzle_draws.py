"""What one nozzle's shots are made of, before they have a place: times, media, diameters, speeds.

Every purpose of every nozzle has its own random numbers, so that a change to one leaves the others' draws.
The same seed gives the same bits under every numpy: only ``Generator.random`` (PCG64, a fixed algorithm) is
taken from it, logarithms and trigonometry come from the C library by ``math``, because numpy's own vectorised
ones differ in the last bit between releases; numpy's + - * / and square root are exact.

Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from glue.flow.pulse import fed_time_s, times_when_fed_s
from glue.scene.model import Nozzle, Scene, Shots
from glue.scene.sizes import CUT_SD, quantile_m

TIME, PLACE, SIZE, MEDIUM, SPEED = range(5)  # purposes of random numbers; the order is part of every result
GAUSSIAN_SD_RADII = 0.5  # standard deviation of the "gaussian" profile over the exit's radius
_NORMAL = NormalDist()


@dataclass
class Draw:
    """The shots of one nozzle, in the order of time; n of them."""

    nozzle: Nozzle
    time_s: np.ndarray  # (n,), when the centre crosses the exit plane
    medium: np.ndarray  # (n,), index in scene.media
    diameter_m: np.ndarray  # (n,)
    speed_m_s: np.ndarray  # (n,)
    aim_m: np.ndarray  # (2, n), where the axis meets z = 0 at that time
    pass_id: np.ndarray  # (n,)


def stream(seed: int, purpose: int, nozzle: int = 0, *more: int) -> np.random.Generator:
    """Random numbers of one ``purpose`` of one nozzle (by index), independent of all others."""
    key = (purpose, nozzle, *more) if nozzle or more else (purpose,)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=key)))


def rates_1_s(scene: Scene, nozzle: Nozzle) -> list[float]:
    """Mean number of shots of each medium that ``nozzle`` feeds per second."""
    return [nozzle.mass_flow_kg_s * shots.mass_fraction / shots.mean_mass_kg for shots in scene.media]


def expected_shots(scene: Scene) -> float:
    """Expected number of arrivals: rate times the integral of the pulse over the exposure, all nozzles."""
    return sum(sum(rates_1_s(scene, n)) * fed_time_s(n.pulse, scene.exposure_time_s) for n in scene.nozzles)


def draw_nozzle(scene: Scene, index: int) -> Draw:
    """Times, media, sizes, speeds and aims of nozzle ``index``; ``scene.arrivals`` decides how many shots."""
    nozzle = scene.nozzles[index]
    fed_s, medium, diameters = (_by_mass if scene.arrivals == "exact_mass" else _poisson)(scene, index)
    times = times_when_fed_s(nozzle.pulse, fed_s)
    if nozzle.pulse is not None:  # rounding must not carry a shot past the end
        times = np.minimum(times, math.nextafter(scene.exposure_time_s, 0.0))
    n = len(times)
    speeds = np.full(n, nozzle.speed_m_s)
    if nozzle.speed_cv > 0.0:
        deviates = _normal_deviates(stream(scene.seed, SPEED, index).random(n))
        speeds = nozzle.speed_m_s * (1.0 + nozzle.speed_cv * deviates)
    aims, passes = np.empty((2, n)), np.zeros(n, np.int64)
    if nozzle.feed is None:
        aims[0], aims[1] = nozzle.aim_m
    elif n:
        x, y, number = zip(*map(nozzle.aim_at, times.tolist()))
        aims[:], passes[:] = (x, y), number
    return Draw(nozzle, times, medium, diameters, speeds, aims, passes)


def _poisson(scene: Scene, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(fed time [s] ascending, medium, diameter [m]), each (n,): shots and their media at random."""
    nozzle, rates = scene.nozzles[index], rates_1_s(scene, scene.nozzles[index])
    horizon = fed_time_s(nozzle.pulse, scene.exposure_time_s)
    fed_s = _poisson_times(stream(scene.seed, TIME, index), sum(rates), horizon)
    n = len(fed_s)
    medium = np.zeros(n, np.int64)
    if len(rates) > 1:
        bounds = np.cumsum(rates)[:-1] / sum(rates)
        medium = np.searchsorted(bounds, stream(scene.seed, MEDIUM, index).random(n), side="right")
    shares = stream(scene.seed, SIZE, index).random(n)
    diameters = np.empty(n)
    for k, shots in enumerate(scene.media):
        of_k = medium == k
        diameters[of_k] = _diameters_m(shots, shares[of_k])
    return fed_s, medium, diameters


def _by_mass(scene: Scene, index: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As ``_poisson``, but as many shots of every medium as come nearest to the mass it is to feed."""
    nozzle = scene.nozzles[index]
    horizon = fed_time_s(nozzle.pulse, scene.exposure_time_s)
    diameters = [
        _diameters_of_mass_m(
            stream(scene.seed, SIZE, index, k), shots, nozzle.mass_flow_kg_s * shots.mass_fraction * horizon
        )
        for k, shots in enumerate(scene.media)
    ]
    medium = np.repeat(np.arange(len(diameters)), [len(d) for d in diameters])
    fed_s = horizon * stream(scene.seed, TIME, index).random(len(medium))
    order = np.argsort(fed_s, kind="stable")
    return fed_s[order], medium[order], np.concatenate(diameters)[order]


def _poisson_times(rng, rate_1_s: float, horizon_s: float) -> np.ndarray:
    """Arrival times of a Poisson process in [0, horizon): sums of exponential gaps, shape (n,)."""
    times, now = [], 0.0
    while True:
        for u in rng.random(4096).tolist():
            now -= math.log1p(-u) / rate_1_s
            if now >= horizon_s:
                return np.array(times)
            times.append(now)


def _diameters_m(shots: Shots, shares: np.ndarray) -> np.ndarray:
    """Diameters [m] by inversion of their distribution, shape of ``shares`` (n,)."""
    if shots.size == "mono":
        return np.full(len(shares), shots.diameter_m)
    return np.array([quantile_m(shots, u) for u in shares.tolist()])


def _diameters_of_mass_m(rng, shots: Shots, mass_kg: float) -> np.ndarray:
    """Diameters [m] of shots drawn until the mass of all is as near ``mass_kg`` as it gets, shape (n,)."""
    if shots.size == "mono":  # no need to sum equal terms
        return np.full(math.floor(mass_kg / shots.mean_mass_kg + 0.5), shots.diameter_m)
    drawn, fed_kg = [], 0.0
    while True:
        diameters = _diameters_m(shots, rng.random(4096))
        after = fed_kg + np.cumsum(shots.density_kg_m3 * math.pi / 6.0 * diameters * diameters * diameters)
        if after[-1] < mass_kg:
            drawn.append(diameters)
            fed_kg = after[-1]
            continue
        last = int(np.searchsorted(after, mass_kg))
        before = after[last - 1] if last else fed_kg
        keep = last + (after[last] - mass_kg < mass_kg - before)
        return np.concatenate([*drawn, diameters[:keep]])


def _normal_deviates(shares: np.ndarray) -> np.ndarray:
    """Standard normal, cut where shot sizes are, by inversion; shape of ``shares`` (n,)."""
    below = _NORMAL.cdf(-CUT_SD)
    return np.array([_NORMAL.inv_cdf(below + u * (1.0 - 2.0 * below)) for u in shares.tolist()])


def places_m(rng, nozzle: Nozzle, n: int) -> np.ndarray:
    """Places in the exit [m] along ``nozzle.exit_axes``, shape (2, n), by the nozzle's profile."""
    radius = 0.5 * nozzle.jet_diameter_m
    unit = _in_disc(rng, n).T
    if nozzle.profile == "uniform":
        return radius * unit
    # The squared radius of an even point is even in (0, 1) whatever its direction: it is turned into the
    # squared radius of a Gaussian one, cut at the edge, and the direction is kept.
    square = np.maximum(unit[0] ** 2 + unit[1] ** 2, 1e-300)
    inside = 1.0 - math.exp(-0.5 / GAUSSIAN_SD_RADII**2)
    wanted = [-2.0 * GAUSSIAN_SD_RADII**2 * math.log1p(-q * inside) for q in square.tolist()]
    return radius * unit * np.sqrt(np.array(wanted) / square)


def turned_m(rng, places: np.ndarray) -> np.ndarray:
    """``places`` (2, n) turned about the axis, each to a new direction."""
    unit = _in_disc(rng, places.shape[1]).T
    length = np.sqrt(unit[0] ** 2 + unit[1] ** 2)
    return unit / np.maximum(length, 1e-300) * np.sqrt(places[0] ** 2 + places[1] ** 2)


def _in_disc(rng, n: int) -> np.ndarray:
    """Uniform in the unit disc, shape (n, 2): by rejection, which needs no sine or square root."""
    points = np.empty((0, 2))
    while len(points) < n:
        square = 2.0 * rng.random((2 * (n - len(points)) + 8, 2)) - 1.0
        points = np.concatenate([points, square[square[:, 0] ** 2 + square[:, 1] ** 2 < 1.0]])
    return points[:n]


def leave(nozzle: Nozzle, aim_m: np.ndarray, places: np.ndarray, speed_m_s: np.ndarray):
    """(positions [m], velocities [m/s]), each (3, n), of shots crossing the exit plane.

    ``aim_m`` (2, n), ``places`` (2, n) from ``places_m``, ``speed_m_s`` (n,).  A diverging jet flies from a
    point behind the exit: at distance r from the axis tan(tilt) = tan(half angle) r / R, outwards.
    """
    tangent = math.tan(math.radians(nozzle.divergence_half_angle_deg)) / (0.5 * nozzle.jet_diameter_m)
    a, b = places
    stretch = speed_m_s / np.sqrt(1.0 + tangent * tangent * (a * a + b * b)) if tangent else speed_m_s
    positions, velocities = np.empty((3, len(a))), np.empty((3, len(a)))
    for axis, (d, up, level) in enumerate(zip(nozzle.direction, *nozzle.exit_axes)):
        off = a * up + b * level
        positions[axis] = -nozzle.stand_off_m * d + off
        velocities[axis] = stretch * (d + tangent * off) if tangent else stretch * d
    positions[:2] += aim_m
    return positions, velocities
