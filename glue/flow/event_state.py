"""What an event-driven run knows at one moment: arrays and numbers that numba reads and a checkpoint holds.

Every live shot has a slot, a record of ``SHOT``: where it was at ``since`` and how it flies from there, and
the earliest of each kind of event that waits for it.  Slots of dropped shots are used again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

REAL, INTEGER = "f8", "i8"
SHOT = np.dtype(
    # all that the search for partners reads stands first, together
    [(name, REAL) for name in ("x", "y", "z", "vx", "vy", "vz", "since", "radius")]
    + [
        (name, INTEGER)
        for name in (
            "following",  # in the list of its cell
            "stamp",  # rises with every change of flight: a partner whose stamp moved on flies otherwise by now
            "partner",
            "partner_stamp",
            *("cx", "cy", "cz", "preceding"),  # cell, and the shot before it in the cell's list
        )
    ]
    + [(name, REAL) for name in ("t_surface", "t_pair", "t_cell", "t_kick")]
    + [(name, INTEGER) for name in ("exit_axis", "exit_step")]  # how it leaves its cell at t_cell
    + [
        (name, INTEGER)
        for name in ("place", "arrival", "collisions", "impacts")  # in the queue, -1 for an empty slot
    ]
    + [
        (name, REAL)
        for name in (
            *("wx", "wy", "wz", "mass", "compliance"),
            "exact_at",  # with kicks: the time at which (vx, vy, vz) is the true velocity
            "touched",  # time of the latest contact
            *("nx", "ny", "nz"),  # outward normal where it will touch the target
        )
    ]
)
CLOCK = np.dtype(
    [
        (name, REAL)
        for name in ("now", "next_sweep", "worst_gain", "worst_momentum", "worst_overlap", "top_speed")
    ]
    + [(name, REAL) for name in ("lowest", "energy_in", "energy_out", "mass_fed")]
    + [
        (name, INTEGER)
        for name in (
            *("leg", "fed", "live", "peak", "free", "falling", "rows", "spots"),
            *("events", "collisions", "struck", "guard_hits", "crossings", "kicks", "void"),
            *("exit", "beside", "far", "past", "inlet", "settled", "never_struck"),
        )
    ]
)
# One earlier impact for the hardening of spots: where, and the one before it in its bucket.
SPOT = np.dtype([("x", REAL), ("y", REAL), ("z", REAL), ("following", INTEGER)])
SPOT_BUCKETS = 1 << 16
FIRST_SLOTS = 256


class World(NamedTuple):
    """All that changes during a run. ``clock`` has one record of ``CLOCK``."""

    clock: np.ndarray
    shots: np.ndarray  # (slots,) SHOT
    vacant: np.ndarray  # (slots,) stack of empty slots, clock.free of them
    queue: np.ndarray  # (slots,) slots as a binary heap by time, clock.live of them
    queue_s: np.ndarray  # (slots,) their times [s]
    cells: np.ndarray  # (nx ny nz,) first shot in each cell, -1 if none
    spots: np.ndarray  # (capacity,) SPOT, clock.spots of them
    buckets: np.ndarray  # (SPOT_BUCKETS,) latest spot of each bucket, -1 if none


class Grid(NamedTuple):
    """Cells of edge lengths (dx, dy, dz) from (x0, y0, z0); the outermost reach to infinity."""

    x0: float
    y0: float
    z0: float
    dx: float
    dy: float
    dz: float
    nx: int
    ny: int
    nz: int


def empty_world(grid: Grid, first_sweep_s: float, slots: int = FIRST_SLOTS) -> World:
    clock = np.zeros(1, CLOCK)
    clock["now"], clock["next_sweep"], clock["lowest"] = -math.inf, first_sweep_s, math.inf
    world = World(
        clock,
        np.zeros(0, SHOT),
        np.zeros(0, np.int64),
        np.zeros(0, np.int64),
        np.zeros(0),
        np.full(grid.nx * grid.ny * grid.nz, -1, np.int64),
        np.zeros(0, SPOT),
        np.full(SPOT_BUCKETS, -1, np.int64),
    )
    return with_slots(world, slots)


def with_slots(world: World, slots: int) -> World:
    """The same world with at least ``slots`` slots."""
    old = len(world.shots)
    if slots <= old:
        return world
    new = slots - old
    shots = np.zeros(new, SHOT)
    shots["place"] = -1
    vacant = np.concatenate([world.vacant, np.zeros(new, np.int64)])
    free = int(world.clock["free"][0])
    vacant[free : free + new] = np.arange(slots - 1, old - 1, -1)
    world.clock["free"] += new
    return world._replace(
        shots=np.concatenate([world.shots, shots]),
        vacant=vacant,
        queue=np.concatenate([world.queue, np.zeros(new, np.int64)]),
        queue_s=np.concatenate([world.queue_s, np.zeros(new)]),
    )


def with_spots(world: World, capacity: int) -> World:
    """The same world with room for at least ``capacity`` spots; it doubles, so that growing stays cheap."""
    old = len(world.spots)
    if capacity <= old:
        return world
    more = np.zeros(max(capacity, 2 * old) - old, SPOT)
    return world._replace(spots=np.concatenate([world.spots, more]))
