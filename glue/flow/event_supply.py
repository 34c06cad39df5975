"""Shots in and out of the event-driven flow: in before the nozzle's exit, out when they can no longer matter.

For numba.
"""

from __future__ import annotations

import math

from glue.flow import jets
from glue.flow.event_compile import part
from glue.flow.event_kernels import advance_shot, energy
from glue.flow.event_queue import enter_cell, insert, move, remove, unlink
from glue.flow.event_search import earliest, foresee

fate = part(jets.fate)


@part
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
    shot.compliance = physics.compliance[arrival.medium]
    shot.since = shot.exact_at = arrival.time_s
    shot.touched, shot.t_kick = -math.inf, math.inf
    shot.arrival, shot.collisions, shot.impacts = clock.fed, 0, 0
    clock.energy_in += energy(shot)
    clock.mass_fed += shot.mass
    if physics.kick_loss_m_s < math.inf:
        shot.t_kick = arrival.time_s  # up to the exit plane it flies as it leaves
    advance_shot(shot, physics.gravity, t)
    clock.fed += 1
    enter_cell(world, grid, i)
    _clear_inlet(world, grid, physics, i, t)
    insert(world, i, t)
    foresee(world, grid, physics, surface, i, t)
    move(world, i, earliest(shot))
    clock.peak = max(clock.peak, clock.live)


@part
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


@part
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


@part
def sweep(world, grid, physics, surface, jet_rows, t, end_s):
    """Drop the shots that can no longer matter and look over the others; False if one is lost."""
    clock = world.clock[0]
    clock.falling = 0
    gx, gy, gz = physics.gravity
    pulled = physics.pull[0] != 0.0 or physics.pull[1] != 0.0 or physics.pull[2] != 0.0
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
            # gravity that comes by kicks may yet turn a rising shot
            clock.falling += shot.t_surface <= end_s or (surface.kind != 0 and pulled)
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
