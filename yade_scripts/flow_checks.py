"""While and after it runs: is the simulation right?  (Before: ``run_plan.py``.)"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from yade import O

from flight import FlowFailed
from impact_logger import ENERGY_TOLERANCE
from run_plan import Plan

# Of the sum of two radii: free shots that overlap by more were missed; a graze between two steps leaves less.
MISSED = 0.002


class Row(NamedTuple):
    """One check after the run."""

    name: str
    value: float
    limit: float
    passed: bool


def audit(mover) -> None:
    """Every free shot: finite, above the target, apart from the others, and in YADE (if it has a body there)
    as its last contact left it: else a contact was missed. Raises FlowFailed.
    """
    fleet, now, target = mover.fleet, mover.logger.clock(), mover.bodies.target
    shots, place = [s for s in fleet.shots if not s.open], fleet.at(now)[:, fleet.free]
    for shot, where in zip(shots, place.T.tolist()):
        if not target.depth_m(where) < 0.0:  # this way round, nan fails too
            raise FlowFailed(f"shot {shot.shot_id} is below the target's surface or lost: {where}")
        if shot.body >= 0:
            mover.bodies.check_flight(shot, now)
    radius, speed = fleet.radius[fleet.free], fleet.speed[fleet.free]
    # a contact about to begin is seen a step or two late
    reach = (radius[:, None] + radius) * (1.0 - MISSED) - (speed[:, None] + speed) * 3.0 * mover.logger.dt
    apart2 = ((place[:, :, None] - place[:, None, :]) ** 2).sum(axis=0)
    np.fill_diagonal(apart2, math.inf)
    through = np.argwhere(apart2 < reach * reach)
    if len(through):
        a, b = (shots[i].shot_id for i in through[0])
        raise FlowFailed(f"shots {a} and {b} fly through each other: missed a contact")


def postflight(plan: Plan, stream) -> list[Row]:
    """The checks of a finished run (finite speeds, flight and energy were also checked while it ran)."""
    logger, shots = stream.logger, stream.fleet.shots
    fed, dropped, live = stream.next, sum(stream.dropped.values()), len(shots)
    blocked = stream.dropped["inlet"]
    soft = min(m.young / s.E_Pa for m, s in zip(O.materials, (*plan.media, plan.target)))
    target, now = stream.target, logger.clock()
    lowest = min((-target.depth_m(s.at(now)) for s in shots), default=math.inf)
    left = stream.energy_left(stream.mover.kicks.work_J if stream.mover.kicks else 0.0)
    rows = [
        ("shots fed, of all arrivals", fed, len(stream.arrivals), fed == len(stream.arrivals)),
        ("shots unaccounted for", fed - dropped - live, 0, fed == dropped + live),
        (
            "shots still falling at the end",
            stream.falling(),
            max(2, 0.001 * fed),
            stream.falling() <= max(2, 0.001 * fed),
        ),
        ("shots dropped at a blocked inlet", blocked, max(2, 0.001 * fed), blocked <= max(2, 0.001 * fed)),
        ("impact rows not written", len(logger.waiting), 0, not logger.waiting),
        ("lowest shot centre above the target [m]", lowest, 0.0, lowest > 0.0),
        ("largest speed [m/s]", logger.top_speed, logger.speed_limit, logger.top_speed <= logger.speed_limit),
        (
            "gain of kinetic energy in a contact",
            logger.worst_gain,
            ENERGY_TOLERANCE,
            logger.worst_gain <= ENERGY_TOLERANCE,
        ),
        (
            "kinetic energy left over fed",
            left,
            1.0 + ENERGY_TOLERANCE,
            left <= 1.0 + ENERGY_TOLERANCE,
        ),
        ("change of momentum in a collision", logger.worst_momentum, 1e-9, logger.worst_momentum <= 1e-9),
        ("contact stiffness over the materials'", soft, 1.0, soft == 1.0),
    ]
    return [Row(*row) for row in rows]
