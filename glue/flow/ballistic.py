"""The shot stream without collisions: every shot flies from the nozzle to the target and strikes once.

Right to 1 % where the collision number is below .01 (``regime.py``).  Drag and gravity bend the flight, the
target may be curved, restitution may fall with speed and rise where shots struck before.  Shots that never
reach the target (they pass beside a curved one, or the gas stops them) are counted as missed.
"""

from __future__ import annotations

import math
import time
from bisect import bisect_left

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from glue.flow import drag, tangential
from glue.flow.event_compile import part, sources
from glue.flow.event_surface import foresee_touch, shape_of
from glue.flow.impacts import COLUMNS, stream_numbers
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import PLANE, TargetSurface

# A bent flight is followed in stretches; on each the speed changes by at most this much, and the path leaves
# the straight line by at most this many diameters. The velocity is exact at any length, the way right to
# fourth order; the limit is there so that no touch is overlooked.
STRETCH_LOSS, STRETCH_BEND = 0.02, 0.05
LONGEST_FLIGHT = 100.0  # a shot still on its way after this many flights of the stand-off never arrives

_AXES = "xyz"
_FLYING = np.dtype(
    [
        (name, "f8")
        for name in (
            "x",
            "y",
            "z",
            "vx",
            "vy",
            "vz",
            "radius",
            "density",
            "since",
            "t_surface",
            "nx",
            "ny",
            "nz",
        )
    ]
)

slowed = part(drag.slowed)
impulse_across = part(tangential.impulse_across)
slip_on_target = part(tangential.slip_on_target)
change_on_target = part(tangential.change_on_target)


def run_ballistic(
    scene, arrivals: np.ndarray, law: RestitutionLaw, surface: TargetSurface
) -> tuple[np.ndarray, dict]:
    """One impact per shot that reaches the target, and the numbers of the run.

    ``arrivals`` as in ``arrivals.COLUMNS``; impacts as in ``impacts.COLUMNS``, in order of time, with
    ``collisions_before`` 0, ``duration_s`` 0 and ``peak_force_N`` nan: contacts are instants.  A gravity or
    air-drag block that is "auto" counts as present.
    """
    begun = time.perf_counter()
    shots = np.zeros(len(arrivals), _FLYING)
    for axis in _AXES:
        shots[axis], shots["v" + axis] = arrivals[f"{axis}_m"], arrivals[f"v{axis}_m_s"]
    shots["radius"], shots["density"] = 0.5 * arrivals["diameter_m"], arrivals["density_kg_m3"]
    longest = LONGEST_FLIGHT * max(n.stand_off_m / n.speed_m_s for n in scene.nozzles)
    stretch = drag.kick_interval_s(scene, STRETCH_LOSS, STRETCH_BEND)
    around = drag.Surroundings(*(float(v) for v in drag.surroundings(scene)))
    fly(shots, shape_of(surface), stretch, longest, around)

    struck = np.flatnonzero(np.isfinite(shots["t_surface"]))
    struck = struck[np.argsort(arrivals["time_s"][struck] + shots["t_surface"][struck], kind="stable")]
    arrived, shots = arrivals[struck], shots[struck]
    impacts = np.zeros(len(struck), COLUMNS)
    impacts["impact_id"] = np.arange(len(struck))
    for name in ("shot_id", "diameter_m", "density_kg_m3", "nozzle_id", "pass_id", "medium"):
        impacts[name] = arrived[name]
    impacts["time_s"] = arrived["time_s"] + shots["t_surface"]
    impacts["peak_force_N"] = np.nan
    for axis in _AXES:
        impacts["n" + axis] = shots["n" + axis]
        impacts[f"{axis}_m"] = shots[axis] - shots["radius"] * shots["n" + axis]
        impacts[f"v{axis}_in_m_s"] = shots["v" + axis]
    if surface.kind == PLANE:
        impacts["z_m"] = 0.0  # without the rounding of the way
    e = _restitution(law, impacts)
    out = np.zeros((len(shots), 6))
    rebounds(shots, e, float(scene.friction.shot_target), out)
    for i, axis in enumerate(_AXES):
        impacts[f"v{axis}_out_m_s"], impacts[f"w{axis}_out_rad_s"] = out[:, i], out[:, 3 + i]

    mass = math.pi / 6.0 * arrivals["density_kg_m3"] * arrivals["diameter_m"] ** 3
    info = {
        "model": "ballistic",
        **stream_numbers(impacts, [n.speed_m_s for n in scene.nozzles]),
        "arrived": len(arrivals),
        "dropped": {"missed": len(arrivals) - len(impacts)},
        "shot_shot_collisions": 0,
        "mass_fed_kg": float(mass.sum()),
        "peak_live_shots": _most_at_once(arrived["time_s"], impacts["time_s"]),
        "wall_s": time.perf_counter() - begun,
    }
    return impacts, info


@part
def _fly(shots, shape, stretch_s, longest_s, around):
    """Move every shot to its first touch: ``t_surface`` [s] after it left (inf: none), velocity, normal."""
    straight = (0.0, 0.0, 0.0)
    for k in range(len(shots)):
        shot = shots[k]
        if stretch_s == math.inf:
            foresee_touch(shape, shot, straight)
            shot.x += shot.t_surface * shot.vx
            shot.y += shot.t_surface * shot.vy
            shot.z += shot.t_surface * shot.vz
            continue
        now = 0.0
        while now < longest_s:
            x, y, z, v = shot.x, shot.y, shot.z, (shot.vx, shot.vy, shot.vz)
            # the chord to where the shot is a stretch later; if it touches, that to the touch, and so on
            span = stretch_s
            for _ in range(8):
                mean, end = _mean_velocity(shot, v, span, around)
                shot.vx, shot.vy, shot.vz = mean
                shot.since = 0.0
                foresee_touch(shape, shot, straight)
                found = shot.t_surface
                if found > stretch_s or abs(found - span) <= 1e-12 * span:
                    break
                span = found
            if found <= stretch_s:
                span = found
            shot.x, shot.y, shot.z = x + span * mean[0], y + span * mean[1], z + span * mean[2]
            shot.vx, shot.vy, shot.vz = end
            now += span
            shot.t_surface = now if found <= stretch_s else math.inf
            if found <= stretch_s:
                break


@part
def _mean_velocity(shot, v, span, around):
    """(mean, last) velocity over the next ``span`` seconds; the mean by Simpson's rule."""
    d, rho = 2.0 * shot.radius, shot.density
    mx, my, mz = slowed(v[0], v[1], v[2], 0.5 * span, d, rho, around)
    ex, ey, ez = slowed(v[0], v[1], v[2], span, d, rho, around)
    mean = ((v[0] + 4.0 * mx + ex) / 6.0, (v[1] + 4.0 * my + ey) / 6.0, (v[2] + 4.0 * mz + ez) / 6.0)
    return mean, (ex, ey, ez)


@part
def _rebounds(shots, e, mu, out):
    """Put velocity [m/s] and spin [rad/s] after the impacts into ``out`` (n, 6); shots come without spin."""
    for k in range(len(shots)):
        s = shots[k]
        gn, tx, ty, tz, gt = slip_on_target(s.vx, s.vy, s.vz, 0.0, 0.0, 0.0, s.nx, s.ny, s.nz, s.radius)
        across = impulse_across(gn, gt, e[k], mu)
        change = change_on_target(gn, tx, ty, tz, gt, s.nx, s.ny, s.nz, s.radius, e[k], across)
        out[k, 0], out[k, 1], out[k, 2] = s.vx, s.vy, s.vz
        for i in range(6):
            out[k, i] += change[i]


def _cached(made_of: int):
    """``_fly`` and ``_rebounds``, kept on disk for these ``sources``."""

    @njit(cache=True)
    def fly(shots, shape, stretch_s, longest_s, around):
        if made_of >= 0:
            _fly(shots, shape, stretch_s, longest_s, around)

    @njit(cache=True)
    def rebounds(shots, e, mu, out):
        if made_of >= 0:
            _rebounds(shots, e, mu, out)

    return fly, rebounds


fly, rebounds = _cached(sources())


def _most_at_once(begins: np.ndarray, ends: np.ndarray) -> int:
    """Largest number of shots on their way to the target at any time."""
    order = np.argsort(np.concatenate([ends, begins]), kind="stable")  # at a tie the one that ends goes first
    return int(np.where(order < len(ends), -1, 1).cumsum().max(initial=0))


def _restitution(law: RestitutionLaw, impacts: np.ndarray) -> np.ndarray:
    """Restitution of each impact (in order of time), shape (n,)."""
    normal = -sum(impacts[f"v{axis}_in_m_s"] * impacts["n" + axis] for axis in _AXES)
    e = law.at_speeds(normal, impacts["density_kg_m3"])
    if law.hardening is None or not len(e):
        return e
    points = np.column_stack([impacts[f"{axis}_m"] for axis in _AXES])
    tree = cKDTree(points)
    for k, point in enumerate(points):
        earlier = bisect_left(tree.query_ball_point(point, law.spot_radius_m, return_sorted=True), k)
        e[k] = law.at_spot(e[k], earlier)
    return e
