"""The event loop: shots enter, meet, strike, are kicked and leave, one event after the other, for numba.

Every shot keeps the earliest event of each kind that it knows of (``event_search``): touch of the target,
meeting another shot, leaving its cell, kick.  Shots touch one another and the target here.
"""

from __future__ import annotations

import math

from numba import njit

from glue.flow.event_compile import part, sources
from glue.flow.event_kernels import (
    REST_RISE,
    collide,
    equivalent_speed,
    hardened,
    on_spot,
    restitution_at,
    strike,
)
from glue.flow.event_queue import move
from glue.flow.event_search import cross, earliest, foresee, halt, launch, leave, look_around
from glue.flow.event_supply import admit, discard, sweep

UNTIL, DONE, ROWS_FULL, SLOTS_FULL, BUDGET, LOST = 0, 1, 2, 3, 4, 5


@part
def _run_until(
    world, grid, physics, surface, jet_rows, arrivals, enter_s, rows, stop_s, end_s, sweep_s, budget
):
    """Work off events up to time ``stop_s``, but at most ``budget`` of them; why it stopped, as a code.

    ``arrivals`` (glue.flow.arrivals.COLUMNS) sorted by ``enter_s``; impacts are written into ``rows``
    (glue.flow.impacts.COLUMNS).  Nothing is lost by stopping anywhere: call again.  DONE: all have entered and
    none will strike before ``end_s``.  LOST: a position is not finite.
    """
    clock = world.clock[0]
    for _ in range(budget):
        t_enter = enter_s[clock.fed] if clock.fed < len(enter_s) else math.inf
        t_event = world.queue_s[0] if clock.live > 0 else math.inf
        if not t_event <= math.inf:
            return LOST
        t = min(t_enter, t_event, clock.next_sweep)
        if t > stop_s:
            return UNTIL
        if clock.rows == len(rows):
            return ROWS_FULL
        if t_enter == t and clock.free == 0:
            return SLOTS_FULL
        clock.now = t
        if t_enter == t:
            admit(world, grid, physics, surface, arrivals[clock.fed], t)
        elif clock.next_sweep == t:
            clock.next_sweep = t + sweep_s
            if not sweep(world, grid, physics, surface, jet_rows, t, end_s):
                return LOST
            if clock.fed == len(enter_s) and clock.falling == 0:
                return DONE
        else:
            clock.events += 1
            handle(world, grid, physics, surface, arrivals, rows, world.queue[0], t)
    return BUDGET


@part
def handle(world, grid, physics, surface, arrivals, rows, i, t):
    """The event of shot ``i`` that is due at ``t``."""
    clock, shot = world.clock[0], world.shots[i]
    if shot.t_surface <= t:
        impact(world, grid, physics, surface, arrivals, rows, i, t)
    elif shot.t_pair <= t:
        j = shot.partner
        if world.shots[j].stamp == shot.partner_stamp:
            meet(world, grid, physics, surface, i, j, t)
        else:
            clock.void += 1
            shot.t_pair = math.inf
            look_around(world, grid, physics, i, t, 1, 1, 1, 0, 0, 0)
            move(world, i, earliest(shot))
    elif shot.t_kick <= t:
        clock.kicks += 1
        halt(shot, physics, t)
        launch(shot, physics)
        foresee(world, grid, physics, surface, i, t)
        move(world, i, earliest(shot))
    else:
        clock.crossings += 1
        cross(world, grid, physics, i, t)
        move(world, i, earliest(shot))


@part
def meet(world, grid, physics, surface, i, j, t):
    """Shots ``i`` and ``j`` touch at ``t``."""
    clock, a, b = world.clock[0], world.shots[i], world.shots[j]
    halt(a, physics, t)
    halt(b, physics, t)
    e = physics.e_shots
    if t - max(a.touched, b.touched) < physics.elastic_within_s:
        e = 1.0
        clock.guard_hits += 1
    gain, push = collide(a, b, e, physics.mu_shots)
    clock.collisions += 1
    clock.worst_gain = max(clock.worst_gain, gain)
    clock.worst_momentum = max(clock.worst_momentum, push)
    for k in (i, j):
        shot = world.shots[k]
        shot.touched = t
        shot.collisions += 1
        clock.top_speed = max(clock.top_speed, math.sqrt(shot.vx**2 + shot.vy**2 + shot.vz**2))
        leave(shot, physics)
    foresee(world, grid, physics, surface, i, t)
    foresee(world, grid, physics, surface, j, t)
    move(world, i, earliest(a))
    move(world, j, earliest(b))


@part
def impact(world, grid, physics, surface, arrivals, rows, i, t):
    """Shot ``i`` touches the target at ``t``; the impact becomes the next row."""
    clock, shot = world.clock[0], world.shots[i]
    halt(shot, physics, t)
    nx, ny, nz = shot.nx, shot.ny, shot.nz
    approach = -(shot.vx * nx + shot.vy * ny + shot.vz * nz)
    if approach > 0.0:
        row, arrival = rows[clock.rows], arrivals[shot.arrival]
        row.shot_id, row.time_s, row.duration_s, row.peak_force_N = arrival.shot_id, t, 0.0, math.nan
        row.x_m = shot.x - shot.radius * nx
        row.y_m = shot.y - shot.radius * ny
        row.z_m = shot.z - shot.radius * nz if surface.kind != 0 else 0.0
        row.nx, row.ny, row.nz = nx, ny, nz
        row.vx_in_m_s, row.vy_in_m_s, row.vz_in_m_s = shot.vx, shot.vy, shot.vz
        row.wx_in_rad_s, row.wy_in_rad_s, row.wz_in_rad_s = shot.wx, shot.wy, shot.wz
        row.diameter_m, row.density_kg_m3 = arrival.diameter_m, arrival.density_kg_m3
        row.collisions_before = shot.collisions
        row.nozzle_id, row.pass_id, row.medium = arrival.nozzle_id, arrival.pass_id, arrival.medium
        speed = equivalent_speed(approach, arrival.density_kg_m3, physics.e_density_kg_m3)
        e = restitution_at(
            speed, physics.e_target, physics.e_speed_m_s, physics.e_exponent, physics.e_largest, physics.e_logs
        )
        if physics.spot_radius_m > 0.0:
            earlier = on_spot(world, physics, row.x_m, row.y_m, row.z_m)
            e = hardened(e, earlier, physics.saturated, physics.hits)
        if t - shot.touched < physics.elastic_within_s:
            e = 1.0
            clock.guard_hits += 1
        gain = strike(shot, (nx, ny, nz), e, physics.mu_target)
        clock.worst_gain = max(clock.worst_gain, gain)
        row.vx_out_m_s, row.vy_out_m_s, row.vz_out_m_s = shot.vx, shot.vy, shot.vz
        row.wx_out_rad_s, row.wy_out_rad_s, row.wz_out_rad_s = shot.wx, shot.wy, shot.wz
        clock.rows += 1
        clock.struck += 1
        shot.touched = t
        shot.impacts += 1
        pull = -(physics.pull[0] * nx + physics.pull[1] * ny + physics.pull[2] * nz)
        if (e * approach) ** 2 < 2.0 * pull * REST_RISE * shot.radius:
            discard(world, grid, i)
            clock.settled += 1
            return
    launch(shot, physics)
    if not shot.vx * nx + shot.vy * ny + shot.vz * nz > 0.0:
        leave(shot, physics)
    foresee(world, grid, physics, surface, i, t)
    move(world, i, earliest(shot))


def _cached(made_of: int):
    """``_run_until``, kept on disk for these ``sources``."""

    @njit(cache=True)
    def run_until(
        world, grid, physics, surface, jet_rows, arrivals, enter_s, rows, stop_s, end_s, sweep_s, budget
    ):
        if made_of < 0:
            return -1
        return _run_until(
            world, grid, physics, surface, jet_rows, arrivals, enter_s, rows, stop_s, end_s, sweep_s, budget
        )

    return run_until


run_until = _cached(sources())
