"""The shot stream as hard spheres, event by event: free flight is crossed in one step, contacts are instants.

Compiled by numba.  The kernel (``event_loop``) runs in short pieces between which Python looks after progress,
Ctrl-C, the impacts so far and checkpoints; where it is cut has no influence on what it computes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from glue import stopping
from glue.errors import InputError, NotConverged
from glue.flow.arrivals import scene_hash
from glue.flow.event_checkpoint import Checkpoint, key_of
from glue.flow.event_checks import check_run, run_numbers
from glue.flow.event_loop import DONE, LOST, SLOTS_FULL, UNTIL, run_until
from glue.flow.event_setup import choose_grid, entries, physics_of
from glue.flow.event_state import Grid, empty_world, with_slots, with_spots
from glue.flow.event_surface import shape_of
from glue.flow.impacts import COLUMNS, stream_numbers
from glue.flow.jets import JET_MARGIN, jet_rows
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface

SWEEPS_PER_FLIGHT = 10.0  # looks over all shots (who can be dropped?) in the time from nozzle to target
SWEEPS_PER_AIM = 100  # so long the jets count as at rest when shots are dropped
TAIL_FLIGHTS = 20.0  # give up on slow stragglers after this many flights of the stand-off at nozzle speed
ROWS = 16384  # most impacts of one piece
EVENTS = 50_000  # most events of one piece: some .1 s
CHECKPOINT_EVERY_S = 5.0
SAY_EVERY_S = 1.0  # progress
STUCK_PIECES = 20  # so many without any progress in time: the shots bounce without end


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
    stream (they decide the cost, not the result).

    Raises InputError for no arrivals and for a checkpoint that is of another run, NotConverged when a check
    of the run fails.
    """
    begun = time.monotonic()
    if not len(arrivals):
        raise InputError("no shot leaves the nozzle: raise exposure_time_s or mass_flow_kg_s")
    enter_s, arrivals = entries(arrivals)
    physics, shape = physics_of(scene, law, surface), shape_of(surface)
    grid = grid or choose_grid(scene, arrivals)
    flights_s = [n.stand_off_m / n.speed_m_s for n in scene.nozzles]
    start_s, sweep_s = float(enter_s[0]), min(flights_s) / SWEEPS_PER_FLIGHT
    fed_s = float(arrivals["time_s"].max()) + max(flights_s)
    end_s = fed_s + TAIL_FLIGHTS * max(flights_s)
    body_m = -surface.lowest_m / min(abs(n.direction[2]) for n in scene.nozzles)

    def jets_of(piece: int) -> np.ndarray:
        middle = start_s + (piece + 0.5) * SWEEPS_PER_AIM * sweep_s
        return np.array(jet_rows(scene, min(max(middle, 0.0), scene.exposure_time_s), jet_margin, body_m))

    saved, world, done = None, None, []
    if checkpoint is not None:
        saved = Checkpoint(
            checkpoint,
            key_of(scene_hash(scene), arrivals, law.as_dict(), tuple(grid), tuple(shape), jet_margin),
        )
        if resume and (found := saved.restore()):
            world, earlier = found
            done.append(earlier)
            if on_impacts and len(earlier):
                on_impacts(earlier)
    if world is None:
        world = empty_world(grid, start_s + sweep_s)
    clock = world.clock[0]
    rows, unsaved, stuck = np.zeros(ROWS, COLUMNS), [], 0
    written = sum(map(len, done))
    said = kept = time.monotonic()
    first_s = max(float(clock["now"]), start_s)
    while True:
        piece, before_s = int(clock["piece"]), float(clock["now"])
        stop_s = min(start_s + (piece + 1) * SWEEPS_PER_AIM * sweep_s, end_s)
        if physics.spot_radius_m > 0.0:
            world = with_spots(world, int(clock["spots"]) + ROWS)
        code = run_until(
            *(world, grid, physics, shape, jets_of(piece), arrivals, enter_s, rows),
            stop_s,
            end_s,
            sweep_s,
            EVENTS,
        )
        new = rows[: int(clock["rows"])].copy()
        clock["rows"] = 0
        new["impact_id"] = np.arange(written, written + len(new))
        written += len(new)
        done.append(new)
        unsaved.append(new)
        if on_impacts and len(new):
            on_impacts(new)
        if code == LOST:
            raise NotConverged(
                "the event-driven flow lost a shot",
                cause=f"a position is not finite at t = {float(clock['now']):.6g} s",
                advice="report the scene: this is a defect",
            )
        if code == DONE or (code == UNTIL and stop_s >= end_s):
            break
        if code == UNTIL:
            clock["piece"] += 1
        elif code == SLOTS_FULL:
            world = with_slots(world, 2 * len(world.shots))
        stuck = stuck + 1 if float(clock["now"]) == before_s and code != SLOTS_FULL else 0
        if stuck >= STUCK_PIECES:
            raise NotConverged(
                "the event-driven flow stands still",
                cause=f"{STUCK_PIECES * EVENTS} contacts at t = {float(clock['now']):.6g} s: shots bounce without end",
                advice='models.flow = "dem", or a lower mass_flow_kg_s',
            )
        now = time.monotonic()
        try:
            stopping.check()
        except BaseException:  # Ctrl-C: here the world is whole
            if saved:
                saved.save(world, np.concatenate(unsaved))
            raise
        if saved and now - kept >= checkpoint_every_s:
            saved.save(world, np.concatenate(unsaved))
            unsaved, kept = [], time.monotonic()
        if progress and now - said >= SAY_EVERY_S:
            share = _share(clock, start_s, fed_s)
            this_run = max(share - _share_at(first_s, start_s, fed_s), 1e-9)
            left_s = (now - begun) * (1.0 - share) / this_run
            progress(share, f"{left_s:.0f} s left, {int(clock['live'])} shots in flight")
            said = now
    impacts = np.concatenate(done)
    info = {
        "model": "event",
        **run_numbers(world),
        **stream_numbers(impacts, [nozzle.speed_m_s for nozzle in scene.nozzles]),
        "cells": [grid.nx, grid.ny, grid.nz],
        "kick_interval_s": physics.kick_s if physics.kick_s < math.inf else None,
        "guard_time_s": physics.elastic_within_s,
    }
    check_run(world, len(arrivals), conserves=physics.kick_s == math.inf and not any(physics.pull))
    if saved:
        saved.remove()
    info["wall_s"] = time.monotonic() - begun
    return impacts, info


def _share_at(now_s: float, start_s: float, fed_s: float) -> float:
    return min(max((now_s - start_s) / (fed_s - start_s), 0.0), 0.999)


def _share(clock, start_s: float, fed_s: float) -> float:
    """Share of the run that is done, by simulated time."""
    return _share_at(float(clock["now"]), start_s, fed_s)
