"""The shot stream as hard spheres, event by event: free flight is crossed in one step, contacts are instants.

Compiled by numba.  The kernel (``event_loop``) runs in short pieces, between which Python looks after progress,
Ctrl-C, the impacts so far and checkpoints; where it is cut has no influence on what it computes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from glue import stopping
from glue.errors import NotConverged
from glue.flow.arrivals import scene_hash
from glue.flow.event_checkpoint import Checkpoint, key_of
from glue.flow.event_checks import check_run, run_numbers
from glue.flow.event_loop import DONE, LOST, SLOTS_FULL, UNTIL, run_until
from glue.flow.event_setup import Plan, plan_run
from glue.flow.event_state import Grid, World, empty_world, with_slots, with_spots
from glue.flow.impacts import COLUMNS, stream_numbers
from glue.flow.jets import JET_MARGIN
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface

ROWS = 16384  # most impacts of one piece
EVENTS = 50_000  # most events of one piece: some .1 s
CHECKPOINT_EVERY_S = 5.0
SAY_EVERY_S = 1.0  # progress
STUCK_PIECES = 20  # so many that end when they began: the shots bounce without end


def run_event(
    scene,
    arrivals: np.ndarray,
    law: RestitutionLaw,
    surface: TargetSurface,
    *,
    grid: Grid | None = None,
    jet_margin: float = JET_MARGIN,
    progress: Callable[[float, str], None] | None = None,
    on_impacts: Callable[[np.ndarray], None] | None = None,
    checkpoint: Path | None = None,
    resume: bool = True,
    checkpoint_every_s: float = CHECKPOINT_EVERY_S,
) -> tuple[np.ndarray, dict]:
    """Follow every shot of ``arrivals`` (``arrivals.COLUMNS``) until none will strike any more.

    Returns (impacts, info): ``impacts.COLUMNS`` in order of time, shape (n,), and the numbers of the run.
    ``progress`` gets the share done and a sentence about once a second; ``on_impacts`` gets the impacts as they
    come, each once (after a restore first all that were there).  ``checkpoint``: a file to save the run in every
    ``checkpoint_every_s`` and on Ctrl-C, gone when it has ended; one that is there is gone on from unless
    ``resume`` is False, and the result is the same bit for bit.  ``grid``: cells in place of those that fit the
    stream (they decide the cost, not the result).  "auto" blocks of the scene count as present.

    Raises InputError for no arrivals and for a checkpoint that is of another run, NotConverged when a check
    of the run fails.
    """
    begun = time.monotonic()
    plan = plan_run(scene, arrivals, law, surface, grid, jet_margin)
    found = _Impacts(on_impacts)
    world = saved = None
    if checkpoint is not None:
        key = key_of(scene_hash(scene), plan.arrivals, law.as_dict(), plan.grid, plan.shape, jet_margin)
        saved = Checkpoint(checkpoint, key)
        if resume and (earlier := saved.restore()):
            world = earlier[0]
            found.add(earlier[1])
            found.unsaved = []
    if world is None:
        world = empty_world(plan.grid, plan.start_s + plan.sweep_s)
    tell = _teller(progress, plan, world)
    watch, kept = _Watch(), time.monotonic()
    rows = np.zeros(ROWS, COLUMNS)
    done = False
    while not done:
        world, done = _piece(scene, plan, world, rows, watch)
        found.take(world, rows)
        tell(world)
        try:
            stopping.check()
        except BaseException:  # Ctrl-C: here the world is whole
            if saved:
                saved.save(world, found.to_save())
            raise
        if saved and time.monotonic() - kept >= checkpoint_every_s:
            saved.save(world, found.to_save())
            kept = time.monotonic()

    physics = plan.physics
    check_run(world, len(arrivals), conserves=physics.kick_loss_m_s == math.inf and not any(physics.pull))
    if saved:
        saved.remove()
    impacts = found.all()
    return impacts, {
        "model": "event",
        **run_numbers(world),
        **stream_numbers(impacts, [nozzle.speed_m_s for nozzle in scene.nozzles]),
        "cells": [plan.grid.nx, plan.grid.ny, plan.grid.nz],
        "guard_time_s": physics.elastic_within_s,
        "wall_s": time.monotonic() - begun,
    }


def _piece(scene, plan: Plan, world: World, rows: np.ndarray, watch: _Watch) -> tuple[World, bool]:
    """One call of the kernel: (world, whether the run has ended). Raises NotConverged when it cannot go on."""
    leg = int(world.clock["leg"][0])
    if plan.physics.spot_radius_m > 0.0:
        world = with_spots(world, int(world.clock["spots"][0]) + len(rows))
    code = run_until(
        world,
        plan.grid,
        plan.physics,
        plan.shape,
        plan.jets(scene, leg),
        plan.arrivals,
        plan.enter_s,
        rows,
        plan.leg_ends_s(leg),
        plan.end_s,
        plan.sweep_s,
        EVENTS,
    )
    if code == LOST:
        raise NotConverged(
            "the event-driven flow lost a shot",
            cause=f"a position is not finite at t = {world.clock['now'][0]:.6g} s",
            advice='models.flow = "dem"',
        )
    if code == UNTIL:
        world.clock["leg"] += 1
    elif code == SLOTS_FULL:
        world = with_slots(world, 2 * len(world.shots))
    else:
        watch.look(world)
    return world, code == DONE or (code == UNTIL and plan.leg_ends_s(leg) >= plan.end_s)


class _Watch:
    """Raises NotConverged when time stands still."""

    def __init__(self):
        self.at_s, self.pieces = math.nan, 0

    def look(self, world: World) -> None:
        now = float(world.clock["now"][0])
        self.pieces = self.pieces + 1 if now == self.at_s else 0
        self.at_s = now
        if self.pieces >= STUCK_PIECES:
            raise NotConverged(
                "the event-driven flow stands still",
                cause=f"{STUCK_PIECES * EVENTS} events at t = {now:.6g} s: shots bounce without end",
                advice='models.flow = "dem", or a lower mass_flow_kg_s',
            )


class _Impacts:
    """The impacts found, numbered and handed on as they come."""

    def __init__(self, on_impacts):
        self.on_impacts, self.parts, self.unsaved, self.n = on_impacts, [], [], 0

    def take(self, world: World, rows: np.ndarray) -> None:
        """Move what the kernel has written into ``rows``."""
        new = rows[: int(world.clock["rows"][0])].copy()
        world.clock["rows"] = 0
        new["impact_id"] = np.arange(self.n, self.n + len(new))
        self.add(new)

    def add(self, new: np.ndarray) -> None:
        self.n += len(new)
        self.parts.append(new)
        self.unsaved.append(new)
        if self.on_impacts and len(new):
            self.on_impacts(new)

    def to_save(self) -> np.ndarray:
        """Those since the last call."""
        new, self.unsaved = np.concatenate([np.zeros(0, COLUMNS), *self.unsaved]), []
        return new

    def all(self) -> np.ndarray:
        return np.concatenate(self.parts)


def _teller(progress, plan: Plan, world: World):
    """A function that tells ``progress`` of the world, about once a second.

    The time left is reckoned from the end of the first piece, in which the loop may have been compiled.
    """

    def share_of(now_s: float) -> float:
        return min(max((now_s - plan.start_s) / (plan.fed_s - plan.start_s), 0.0), 0.999)

    begun, said, first = None, time.monotonic(), share_of(float(world.clock["now"][0]))
    if progress and not run_until.signatures:
        progress(first, "compiling the event loop, once")

    def tell(world: World) -> None:
        nonlocal begun, said, first
        now, share = time.monotonic(), share_of(float(world.clock["now"][0]))
        if begun is None:
            begun, said, first = now, now, share
        if progress is None or now - said < SAY_EVERY_S:
            return
        said = now
        left_s = (now - begun) * (1.0 - share) / max(share - first, 1e-9)
        progress(share, f"{left_s:.0f} s left, {int(world.clock['live'][0])} shots in flight")

    return tell
