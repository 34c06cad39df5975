"""The shot stream as hard spheres, event by event: free flight is crossed in one step, contacts are instants.

Compiled by numba; a shot of the reference scene (1 mm, 60 m/s, 5 kg/min) costs some ten microseconds.  The
kernel (``event_loop``) runs in short pieces between which Python looks after progress, Ctrl-C, the impacts so
far and checkpoints; where it is cut has no influence on what it computes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from glue import stopping
from glue.errors import InputError, NotConverged
from glue.flow import drag
from glue.flow.event_kernels import Physics
from glue.flow.event_loop import BUDGET, DONE, LOST, ROWS_FULL, SLOTS_FULL, run_until
from glue.flow.event_state import Grid, World, empty_world, with_slots, with_spots
from glue.flow.event_surface import shape_of
from glue.flow.impacts import COLUMNS, stream_numbers
from glue.flow.jets import jet_rows
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import PLANE, TargetSurface

# Shots enter this many largest diameters upstream of the exit plane, as in YADE: rebounding shots meet the
# stream until they leave through the exit.
INLET_DIAMETERS = 1.25
SWEEPS_PER_FLIGHT = 10.0  # looks over all shots (who can be dropped?) in the time from nozzle to target
TAIL_FLIGHTS = 20.0  # give up on slow stragglers after this many flights of the stand-off at nozzle speed
# The guard against endless bouncing: a contact sooner than this many diameters of flight at nozzle speed
# after a shot's last one loses no energy.  Three shots of e = .1 between walls would else touch without end.
GUARD_DIAMETERS = 1e-3
ROWS = 16384  # impacts between two calls of the kernel
EVENTS = 100_000  # likewise: some .1 s


def run_event(
    scene,
    arrivals: np.ndarray,
    law: RestitutionLaw,
    surface: TargetSurface,
    *,
    grid: Grid | None = None,
) -> tuple[np.ndarray, dict]:
    """Impacts (``impacts.COLUMNS``, in order of time) of ``arrivals`` (``arrivals.COLUMNS``) and numbers."""
    begun = time.perf_counter()
    enter_s, arrivals = entries(scene, arrivals)
    physics = physics_of(scene, law, surface)
    grid = grid or choose_grid(scene, arrivals)
    shape = shape_of(surface)
    flight_s = max(n.stand_off_m / n.speed_m_s for n in scene.nozzles)
    sweep_s = min(n.stand_off_m / n.speed_m_s for n in scene.nozzles) / SWEEPS_PER_FLIGHT
    end_s = float(arrivals["time_s"].max()) + (1.0 + TAIL_FLIGHTS) * flight_s
    world = empty_world(grid, float(enter_s[0]) + sweep_s)
    rows = np.zeros(ROWS, COLUMNS)
    parts = []
    aimed_s = 100.0 * sweep_s  # the jets count as at rest for so long
    piece = 0
    while True:
        middle = float(enter_s[0]) + (piece + 0.5) * aimed_s
        jets = np.array(jet_rows(scene, min(max(middle, 0.0), scene.exposure_time_s)))
        stop_s = min(float(enter_s[0]) + (piece + 1) * aimed_s, end_s)
        if physics.spot_radius_m > 0.0:
            world = with_spots(world, int(world.clock["spots"][0]) + ROWS)
        code = run_until(
            world, grid, physics, shape, jets, arrivals, enter_s, rows, stop_s, end_s, sweep_s, EVENTS
        )
        n = int(world.clock["rows"][0])
        parts.append(rows[:n].copy())
        world.clock["rows"] = 0
        stopping.check()
        if code == DONE:
            break
        if code == SLOTS_FULL:
            world = with_slots(world, 2 * len(world.shots))
        elif code == LOST:
            raise NotConverged("lost")
        elif code == 0:
            if stop_s >= end_s:
                break
            piece += 1
    impacts = np.concatenate(parts)
    impacts["impact_id"] = np.arange(len(impacts))
    clock = world.clock[0]
    info = {
        "model": "event",
        **stream_numbers(impacts, scene.nozzle.speed_m_s),
        "arrived": int(clock["fed"]),
        "dropped": {k: int(clock[k]) for k in ("exit", "beside", "far", "past", "settled")},
        "shot_shot_collisions": int(clock["collisions"]),
        "collapse_guard_hits": int(clock["guard_hits"]),
        "events": int(clock["events"]),
        "peak_live_shots": int(clock["peak"]),
        "wall_s": time.perf_counter() - begun,
    }
    return impacts, info


def entries(scene, arrivals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(times [s] at which the shots enter, ascending; the arrivals in that order)."""
    speed = np.sqrt(sum(arrivals[v] ** 2 for v in ("vx_m_s", "vy_m_s", "vz_m_s")))
    enter_s = arrivals["time_s"] - INLET_DIAMETERS * arrivals["diameter_m"].max(initial=0.0) / speed
    order = np.argsort(enter_s, kind="stable")
    return enter_s[order], arrivals[order]


def physics_of(scene, law: RestitutionLaw, surface: TargetSurface) -> Physics:
    """The constants of a run of ``scene``; an "auto" block counts as present."""
    around = drag.surroundings(scene)
    pull = (around.gravity_x_m_s2, around.gravity_y_m_s2, around.gravity_z_m_s2)
    bends = surface.kind == PLANE
    gas = around.gas_density_kg_m3 > 0.0
    kicked = gas or any(pull) and not bends
    if bends:
        around = around._replace(gravity_x_m_s2=0.0, gravity_y_m_s2=0.0, gravity_z_m_s2=0.0)
    return Physics(
        e_shots=float(scene.restitution.shot_shot),
        mu_shots=float(scene.friction.shot_shot),
        beta_shots=0.0,
        e_target=float(law.e),
        e_speed_m_s=float(law.speed_m_s),
        e_exponent=float(law.exponent),
        e_largest=float(law.largest),
        mu_target=float(scene.friction.shot_target),
        beta_target=0.0,
        saturated=float(law.hardening.saturated) if law.hardening else 0.0,
        hits=float(law.hardening.hits) if law.hardening else 1.0,
        spot_radius_m=float(law.spot_radius_m) if law.hardening else 0.0,
        elastic_within_s=GUARD_DIAMETERS * scene.smallest_diameter_m / scene.fastest_m_s,
        gravity=pull if bends else (0.0, 0.0, 0.0),
        pull=pull,
        kick_s=drag.kick_interval_s(scene) if kicked else math.inf,
        around=drag.Surroundings(*(float(x) for x in around)),
    )


def choose_grid(scene, arrivals) -> Grid:
    return Grid(0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1, 1, 1)
