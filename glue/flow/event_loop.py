"""The event loop: shots enter, meet, strike, are kicked and leave, one event after the other, for numba.

Every shot keeps the earliest event of each kind that it knows of: touch of the target, meeting another shot,
leaving its cell, kick.  A meeting holds only while neither of the two has been touched by anything else: each
touch raises a shot's ``stamp``.  A shot whose partner's stamp has moved on looks again when its turn comes,
which is not after any meeting it may have missed: whoever changes its flight looks at all shots near it, so
of two shots that will meet at least one knows of it, or has something to do before.
"""

from __future__ import annotations

import math

from numba import njit

from glue.flow import jets
from glue.flow.event_kernels import (
    REST_RISE,
    advance_shot,
    collide,
    energy,
    hardened,
    meeting,
    on_spot,
    restitution_at,
    slowed,
    strike,
)
from glue.flow.event_queue import cell_exit, enter_cell, insert, link, move, remove, unlink
from glue.flow.event_surface import foresee_touch

fate = njit(cache=True)(jets.fate)

UNTIL, DONE, ROWS_FULL, SLOTS_FULL, BUDGET, LOST = 0, 1, 2, 3, 4, 5


@njit(cache=True)
def run_until(world, grid, physics, surface, jet_rows, arrivals, enter_s, rows, stop_s, end_s, sweep_s, budget):
    """Work off events up to time ``stop_s``, but at most ``budget`` of them; why it stopped, as a code.

    ``arrivals`` (glue.flow.arrivals.COLUMNS) sorted by ``enter_s``; impacts are written into ``rows``
    (glue.flow.impacts.COLUMNS).  Nothing is lost by stopping anywhere: call again.  DONE: all have entered and
    none will strike before ``end_s``.  LOST: a position is not finite.
    """
    clock = world.clock[0]
    for _ in range(budget):
        t_enter = enter_s[clock.fed] if clock.fed < len(enter_s) else math.inf
        t_event = world.queue_s[0] if clock.live > 0 else math.inf
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


@njit(cache=True)
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
        advance_shot(shot, physics.gravity, t)
        shot.exact_at += physics.kick_s
        _drag(shot, physics, physics.kick_s)
        shot.t_kick = t + physics.kick_s
        foresee(world, grid, physics, surface, i, t)
        move(world, i, earliest(shot))
    else:
        clock.crossings += 1
        cross(world, grid, physics, i, t)
        move(world, i, earliest(shot))


@njit(cache=True)
def earliest(shot):
    return min(min(shot.t_surface, shot.t_pair), min(shot.t_cell, shot.t_kick))


@njit(cache=True)
def _drag(shot, physics, tau):
    shot.vx, shot.vy, shot.vz = slowed(
        shot.vx,
        shot.vy,
        shot.vz,
        tau,
        2.0 * shot.radius,
        shot.mass / (4.0 / 3.0 * math.pi * shot.radius**3),
        physics.around,
    )


@njit(cache=True)
def halt(shot, physics, t):
    """Bring the record to time ``t``, with the true velocity."""
    advance_shot(shot, physics.gravity, t)
    if physics.kick_s < math.inf:
        _drag(shot, physics, t - shot.exact_at)
        shot.exact_at = t


@njit(cache=True)
def launch(shot, physics):
    """Begin a free flight: with kicks, at the velocity that it will have half an interval on."""
    if physics.kick_s < math.inf:
        _drag(shot, physics, shot.since + 0.5 * physics.kick_s - shot.exact_at)
        shot.exact_at = shot.since + 0.5 * physics.kick_s
        shot.t_kick = shot.since + physics.kick_s


@njit(cache=True)
def foresee(world, grid, physics, surface, i, t):
    """All that waits for shot ``i``, whose flight changed just now."""
    shot = world.shots[i]
    shot.stamp += 1
    foresee_touch(surface, shot, physics.gravity)
    shot.t_pair = math.inf
    shot.t_cell = cell_exit(world, grid, physics.gravity, i, t)[0]
    look_around(world, grid, physics, i, t, 1, 1, 1, 0, 0, 0)


@njit(cache=True)
def look_around(world, grid, physics, i, t, wide_x, wide_y, wide_z, ahead_x, ahead_y, ahead_z):
    """Keep the soonest meeting of shot ``i`` with those in the cells within wide of the one ahead of its own."""
    shots, cells, gravity = world.shots, world.cells, physics.gravity  # taken out once: it costs in the loop
    shot, clock = shots[i], world.clock[0]
    x, y, z = shot.cx + ahead_x, shot.cy + ahead_y, shot.cz + ahead_z
    for iz in range(max(z - wide_z, 0), min(z + wide_z + 1, grid.nz)):
        for iy in range(max(y - wide_y, 0), min(y + wide_y + 1, grid.ny)):
            for ix in range(max(x - wide_x, 0), min(x + wide_x + 1, grid.nx)):
                j = cells[(iz * grid.ny + iy) * grid.nx + ix]
                while j >= 0:
                    other = shots[j]
                    if j != i:
                        when, overlap = meeting(shot, other, gravity)
                        if overlap > clock.worst_overlap:
                            clock.worst_overlap = overlap
                        if when < shot.t_pair:
                            shot.t_pair = max(when, t)
                            shot.partner, shot.partner_stamp = j, other.stamp
                    j = other.following


@njit(cache=True)
def cross(world, grid, physics, i, t):
    """Shot ``i`` goes over into the next cell and looks at those that come within reach."""
    shot = world.shots[i]
    _, axis, step = cell_exit(world, grid, physics.gravity, i, t)
    unlink(world, grid, i)
    if axis == 0:
        shot.cx += step
    elif axis == 1:
        shot.cy += step
    else:
        shot.cz += step
    link(world, grid, i)
    shot.t_cell = cell_exit(world, grid, physics.gravity, i, t)[0]
    if shot.t_pair < math.inf and world.shots[shot.partner].stamp != shot.partner_stamp:
        world.clock[0].void += 1
        shot.t_pair = math.inf
        look_around(world, grid, physics, i, t, 1, 1, 1, 0, 0, 0)
    elif axis == 0:
        look_around(world, grid, physics, i, t, 0, 1, 1, step, 0, 0)
    elif axis == 1:
        look_around(world, grid, physics, i, t, 1, 0, 1, 0, step, 0)
    else:
        look_around(world, grid, physics, i, t, 1, 1, 0, 0, 0, step)


@njit(cache=True)
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
        launch(shot, physics)
    foresee(world, grid, physics, surface, i, t)
    foresee(world, grid, physics, surface, j, t)
    move(world, i, earliest(a))
    move(world, j, earliest(b))


@njit(cache=True)
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
        row.z_m = shot.z - shot.radius * nz
        row.nx, row.ny, row.nz = nx, ny, nz
        row.vx_in_m_s, row.vy_in_m_s, row.vz_in_m_s = shot.vx, shot.vy, shot.vz
        row.wx_in_rad_s, row.wy_in_rad_s, row.wz_in_rad_s = shot.wx, shot.wy, shot.wz
        row.diameter_m, row.density_kg_m3 = arrival.diameter_m, arrival.density_kg_m3
        row.collisions_before = shot.collisions
        row.nozzle_id, row.pass_id, row.medium = arrival.nozzle_id, arrival.pass_id, arrival.medium
        e = restitution_at(
            approach, physics.e_target, physics.e_speed_m_s, physics.e_exponent, physics.e_largest
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
    foresee(world, grid, physics, surface, i, t)
    move(world, i, earliest(shot))


@njit(cache=True)
def admit(world, grid, physics, surface, arrival, t):
    """The next shot enters, where its free flight through its exit plane has it at ``t``."""
    clock = world.clock[0]
    clock.free -= 1
    i = world.vacant[clock.free]
    shot = world.shots[i]
    shot.x, shot.y, shot.z = arrival.x_m, arrival.y_m, arrival.z_m
    shot.vx, shot.vy, shot.vz = arrival.vx_m_s, arrival.vy_m_s, arrival.vz_m_s
    shot.wx = shot.wy = shot.wz = 0.0
    shot.radius = 0.5 * arrival.diameter_m
    shot.mass = arrival.density_kg_m3 * math.pi / 6.0 * arrival.diameter_m**3
    shot.since = shot.exact_at = arrival.time_s
    shot.touched, shot.t_kick = -math.inf, math.inf
    shot.arrival, shot.collisions, shot.impacts = clock.fed, 0, 0
    clock.energy_in += energy(shot)
    clock.mass_fed += shot.mass
    launch(shot, physics)
    advance_shot(shot, physics.gravity, t)
    clock.fed += 1
    enter_cell(world, grid, i)
    _clear_inlet(world, grid, physics, i, t)
    insert(world, i, t)
    foresee(world, grid, physics, surface, i, t)
    move(world, i, earliest(shot))
    clock.peak = max(clock.peak, clock.live)


@njit(cache=True)
def _clear_inlet(world, grid, physics, i, t):
    """Drop what blocks the place of the entering shot ``i``: shots thrown back that have not left yet."""
    shot, clock = world.shots[i], world.clock[0]
    for iz in range(max(shot.cz - 1, 0), min(shot.cz + 2, grid.nz)):
        for iy in range(max(shot.cy - 1, 0), min(shot.cy + 2, grid.ny)):
            for ix in range(max(shot.cx - 1, 0), min(shot.cx + 2, grid.nx)):
                j = world.cells[(iz * grid.ny + iy) * grid.nx + ix]
                while j >= 0:
                    other = world.shots[j]
                    after = other.following
                    s = t - other.since
                    gx, gy, gz = physics.gravity
                    dx = other.x + (other.vx + 0.5 * gx * s) * s - shot.x
                    dy = other.y + (other.vy + 0.5 * gy * s) * s - shot.y
                    dz = other.z + (other.vz + 0.5 * gz * s) * s - shot.z
                    if (
                        other.collisions + other.impacts > 0
                        and dx * dx + dy * dy + dz * dz < (shot.radius + other.radius) ** 2
                    ):
                        if other.vx * shot.vx + other.vy * shot.vy + other.vz * shot.vz < 0.0:
                            clock.exit += 1
                        else:
                            clock.inlet += 1
                        discard(world, grid, j)
                    j = after


@njit(cache=True)
def discard(world, grid, i):
    """Take shot ``i`` out of the simulation."""
    clock, shot = world.clock[0], world.shots[i]
    clock.energy_out += energy(shot)
    clock.never_struck += shot.impacts == 0
    unlink(world, grid, i)
    remove(world, i)
    shot.stamp += 1
    world.vacant[clock.free] = i
    clock.free += 1


@njit(cache=True)
def sweep(world, grid, physics, surface, jet_rows, t, end_s):
    """Drop the shots that can no longer matter and look over the others; False if one is lost."""
    clock = world.clock[0]
    clock.falling = 0
    gx, gy, gz = physics.gravity
    for i in range(len(world.shots)):
        shot = world.shots[i]
        if shot.place < 0:
            continue
        s = t - shot.since
        x = shot.x + (shot.vx + 0.5 * gx * s) * s
        y = shot.y + (shot.vy + 0.5 * gy * s) * s
        z = shot.z + (shot.vz + 0.5 * gz * s) * s
        if not abs(x) + abs(y) + abs(z) < math.inf:
            return False
        vx, vy, vz = shot.vx + gx * s, shot.vy + gy * s, shot.vz + gz * s
        leaves = vz >= 0.0 if surface.kind == 0 else shot.t_surface == math.inf
        why = fate(x, y, z, vx, vy, vz, leaves, jet_rows)
        if why == jets.KEEP:
            clock.falling += shot.t_surface <= end_s
            if surface.kind == 0:
                clock.lowest = min(clock.lowest, z / shot.radius)
            continue
        if why == jets.EXIT:
            clock.exit += 1
        elif why == jets.BESIDE:
            clock.beside += 1
        elif why == jets.FAR:
            clock.far += 1
        else:
            clock.past += 1
        discard(world, grid, i)
    return True
