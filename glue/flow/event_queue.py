"""Whose event is next, and who is near: a binary heap of the live shots by time, and their lists per cell.

Every live shot stands once in the heap, under the earliest of its own events, and knows its place there.
"""

from __future__ import annotations

import math

from glue.flow.event_compile import part


@part
def insert(world, i, t):
    """Queue the shot in slot ``i`` under time ``t``."""
    n = world.clock[0].live
    world.clock[0].live = n + 1
    world.queue[n] = i
    world.queue_s[n] = t
    _rise(world, n)


@part
def move(world, i, t):
    """Give the queued shot ``i`` another time."""
    at = world.shots[i].place
    earlier = t < world.queue_s[at]
    world.queue_s[at] = t
    if earlier:
        _rise(world, at)
    else:
        _sink(world, at)


@part
def remove(world, i):
    """Take shot ``i`` out of the queue."""
    at = world.shots[i].place
    world.shots[i].place = -1
    last = world.clock[0].live - 1
    world.clock[0].live = last
    if at == last:
        return
    moved, t = world.queue[last], world.queue_s[last]
    earlier = t < world.queue_s[at]
    world.queue[at], world.queue_s[at] = moved, t
    if earlier:
        _rise(world, at)
    else:
        _sink(world, at)


@part
def _rise(world, at):
    queue, times, shots = world.queue, world.queue_s, world.shots
    i, t = queue[at], times[at]
    while at > 0:
        above = (at - 1) >> 1
        if times[above] <= t:
            break
        queue[at], times[at] = queue[above], times[above]
        shots[queue[at]].place = at
        at = above
    queue[at], times[at] = i, t
    shots[i].place = at


@part
def _sink(world, at):
    queue, times, shots, n = world.queue, world.queue_s, world.shots, world.clock[0].live
    i, t = queue[at], times[at]
    while True:
        below = 2 * at + 1
        if below >= n:
            break
        if below + 1 < n and times[below + 1] < times[below]:
            below += 1
        if t <= times[below]:
            break
        queue[at], times[at] = queue[below], times[below]
        shots[queue[at]].place = at
        at = below
    queue[at], times[at] = i, t
    shots[i].place = at


@part
def _index(x, x0, dx, n):
    at = (x - x0) / dx
    return 0 if at < 1.0 else n - 1 if at >= n - 1.0 else int(at)


@part
def enter_cell(world, grid, i):
    """Put shot ``i`` into the list of the cell where it is."""
    shot = world.shots[i]
    shot.cx = _index(shot.x, grid.x0, grid.dx, grid.nx)
    shot.cy = _index(shot.y, grid.y0, grid.dy, grid.ny)
    shot.cz = _index(shot.z, grid.z0, grid.dz, grid.nz)
    link(world, grid, i)


@part
def link(world, grid, i):
    """Put shot ``i`` first into the list of the cell that it names."""
    shot = world.shots[i]
    cell = (shot.cz * grid.ny + shot.cy) * grid.nx + shot.cx
    first = world.cells[cell]
    shot.following, shot.preceding = first, -1
    if first >= 0:
        world.shots[first].preceding = i
    world.cells[cell] = i


@part
def unlink(world, grid, i):
    """Take shot ``i`` out of its cell's list."""
    shot = world.shots[i]
    if shot.following >= 0:
        world.shots[shot.following].preceding = shot.preceding
    if shot.preceding >= 0:
        world.shots[shot.preceding].following = shot.following
    else:
        world.cells[(shot.cz * grid.ny + shot.cy) * grid.nx + shot.cx] = shot.following


@part
def plan_exit(shot, grid, gravity, now):
    """Set when and where the shot leaves its cell after ``now``; t_cell is inf if it never does.

    Which cell a shot is in decides who is looked at, never what happens: rounding does no harm here, since
    cells are wider than shots.
    """
    s = now - shot.since
    t, axis, step = math.inf, 0, 0
    if grid.nx > 1:
        low, high = _edges(grid.x0, grid.dx, shot.cx, grid.nx)
        t, axis, step = _sooner(t, axis, step, 0, shot.x, shot.vx, gravity[0], s, low, high)
    if grid.ny > 1:
        low, high = _edges(grid.y0, grid.dy, shot.cy, grid.ny)
        t, axis, step = _sooner(t, axis, step, 1, shot.y, shot.vy, gravity[1], s, low, high)
    if grid.nz > 1:
        low, high = _edges(grid.z0, grid.dz, shot.cz, grid.nz)
        t, axis, step = _sooner(t, axis, step, 2, shot.z, shot.vz, gravity[2], s, low, high)
    shot.t_cell, shot.exit_axis, shot.exit_step = now + t, axis, step


@part
def _edges(x0, dx, cell, n):
    return x0 + cell * dx if cell > 0 else -math.inf, x0 + (cell + 1) * dx if cell < n - 1 else math.inf


@part
def _sooner(best, best_axis, best_step, axis, x, v, g, s, low, high):
    """The sooner of ``best`` and leaving [low, high] along one axis, with (axis, step); durations from now."""
    x, v = x + (v + 0.5 * g * s) * s, v + g * s
    up = _reach(max(high - x, 0.0), v, g)
    down = _reach(max(x - low, 0.0), -v, -g)
    if up < best:
        best, best_axis, best_step = up, axis, 1
    if down < best:
        best, best_axis, best_step = down, axis, -1
    return best, best_axis, best_step


@part
def _reach(gap, v, g):
    """Time until ``gap`` >= 0 is flown outwards at v + g t; starting on the edge counts only when v > 0."""
    if gap == math.inf:
        return math.inf
    if g == 0.0:
        return gap / v if v > 0.0 else math.inf
    root2 = v * v + 2.0 * g * gap
    if v > 0.0:
        return 2.0 * gap / (v + math.sqrt(root2)) if root2 >= 0.0 else math.inf
    # first inwards, and back when the pull is outwards
    return (math.sqrt(root2) - v) / g if g > 0.0 else math.inf
