"""What waits for a shot: its flight between touches, and the search for whom it will meet, for numba.

A meeting holds only while neither of the two has been touched by anything else: each touch raises a shot's
``stamp``.  A shot whose partner's stamp has moved on looks again when its turn comes, which is not after any
meeting it may have missed: whoever changes its flight looks at all shots near it, so of two shots that will
meet at least one knows of it, or has something to do before.
"""

from __future__ import annotations

import math

from glue.flow.event_compile import part
from glue.flow.event_kernels import advance_shot, drag_rate_1_s, meeting, slowed
from glue.flow.event_queue import link, plan_exit, unlink
from glue.flow.event_surface import foresee_touch


@part
def halt(shot, physics, t):
    """Bring the record to time ``t``, with the true velocity."""
    advance_shot(shot, physics.gravity, t)
    if physics.kick_loss_m_s < math.inf:
        drag_over(shot, physics, t - shot.exact_at)
        shot.exact_at = t


@part
def launch(shot, physics):
    """Begin a free flight, from the true velocity: with kicks, at that of the middle of the way to the next."""
    if physics.kick_loss_m_s < math.inf:
        span = until_kick(shot, physics)
        shot.t_kick = shot.since + span
        drag_over(shot, physics, 0.5 * span)
        shot.exact_at = shot.since + 0.5 * span


@part
def leave(shot, physics):
    """Begin a free flight at a touch: at the velocity it has there, for a quarter of the way to the next kick.

    At the velocity of the middle, what parts slowly would seem to approach and touch again at once, and so
    without end.
    """
    if physics.kick_loss_m_s < math.inf:
        halt(shot, physics, shot.since)
        shot.t_kick = shot.since + 0.25 * until_kick(shot, physics)


@part
def until_kick(shot, physics):
    """How long [s] the shot may fly straight; short where drag is strong, long for a slow rebounding shot."""
    around = physics.around
    ux = shot.vx - around.gas_vx_m_s
    uy = shot.vy - around.gas_vy_m_s
    uz = shot.vz - around.gas_vz_m_s
    density, gas, viscosity = density_of(shot), around.gas_density_kg_m3, around.gas_viscosity_Pa_s
    rate = drag_rate_1_s(math.sqrt(ux * ux + uy * uy + uz * uz), 2.0 * shot.radius, density, gas, viscosity)
    ax = around.gravity_x_m_s2 - rate * ux
    ay = around.gravity_y_m_s2 - rate * uy
    az = around.gravity_z_m_s2 - rate * uz
    a = math.sqrt(ax * ax + ay * ay + az * az)
    span = physics.kick_share / rate if rate > 0.0 else math.inf
    if a > 0.0:
        span = min(span, physics.kick_loss_m_s / a, math.sqrt(16.0 * physics.kick_bend * shot.radius / a))
    return span


@part
def density_of(shot):
    return shot.mass / (4.0 / 3.0 * math.pi * shot.radius**3)


@part
def drag_over(shot, physics, tau):
    shot.vx, shot.vy, shot.vz = slowed(
        shot.vx,
        shot.vy,
        shot.vz,
        tau,
        2.0 * shot.radius,
        density_of(shot),
        physics.around,
    )


@part
def earliest(shot):
    return min(min(shot.t_surface, shot.t_pair), min(shot.t_cell, shot.t_kick))


@part
def foresee(world, grid, physics, surface, i, t):
    """All that waits for shot ``i``, whose flight changed just now."""
    shot = world.shots[i]
    shot.stamp += 1
    foresee_touch(surface, shot, physics.gravity)
    at_middle = physics.kick_loss_m_s < math.inf and shot.exact_at > shot.since
    if at_middle and shot.t_surface < shot.t_kick:
        # The last stretch ends at the target: fly it at the velocity of its own middle, and it ends there in time.
        middle = 0.5 * (shot.since + shot.t_surface)
        drag_over(shot, physics, middle - shot.exact_at)
        shot.exact_at = middle
        foresee_touch(surface, shot, physics.gravity)
    shot.t_pair = math.inf
    plan_exit(shot, grid, physics.gravity, t)
    look_around(world, grid, physics, i, t, 1, 1, 1, 0, 0, 0)


@part
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
                        if overlap > 0.0:
                            clock.worst_overlap = max(clock.worst_overlap, overlap)
                        if when < shot.t_pair:
                            shot.t_pair = max(when, t)
                            shot.partner, shot.partner_stamp = j, other.stamp
                    j = other.following


@part
def cross(world, grid, physics, i, t):
    """Shot ``i`` goes over into the next cell and looks at those that come within reach."""
    shot = world.shots[i]
    axis, step = shot.exit_axis, shot.exit_step
    unlink(world, grid, i)
    if axis == 0:
        shot.cx += step
    elif axis == 1:
        shot.cy += step
    else:
        shot.cz += step
    link(world, grid, i)
    plan_exit(shot, grid, physics.gravity, t)
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
