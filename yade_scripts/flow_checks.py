"""Before the run: does this scene make a simulation that can be right?  After it: was it right?"""

from __future__ import annotations

import math
from typing import NamedTuple

from yade import O

from contact_model import (
    Calibration,
    Law,
    Solid,
    calibrate,
    check_restitution,
    p_wave_step_s,
)
from glue.errors import InputError
from glue.flow.arrivals import largest_diameter_m, smallest_diameter_m
from glue.scene.consistency import (
    MAX_OVERLAP,
    MIN_STEPS_PER_CONTACT,
    elastic_overlap,
    steps_per_contact,
)
from impact_logger import ENERGY_TOLERANCE

MAX_DT_OVER_P = 1.5  # at 2 the elastic energy drifts by .5 %, at 4.4 by 24 %


class Plan(NamedTuple):
    """What a run needs to know: solids, laws, step."""

    shot: Solid
    target: Solid
    dt_s: float
    dt_over_P: float
    shot_target: Calibration
    shot_shot: Calibration
    laws: tuple[Law, Law]  # shot-target, shot-shot


def plan_run(scene, restitution: float, dt_over_P: float, *, guarded: bool = True) -> Plan:
    """Check all that can be checked before the first step and calibrate the restitution, or raise InputError.

    ``guarded=False`` leaves out what would refuse a too large time step (to test the checks after the run).
    """
    nozzle, material = scene.nozzle, scene.target.material
    shot = Solid(scene.shots.E_Pa, scene.shots.nu, scene.shots.density_kg_m3)
    target = Solid(material.E_Pa, material.nu, material.density_kg_m3)
    small, large, mean = smallest_diameter_m(scene), largest_diameter_m(scene), scene.shots.diameter_m
    if not small > 0.0:
        raise InputError(
            f"shots.size_cv = {scene.shots.size_cv}: the smallest shot has no size; must be below 0.4"
        )
    problems = [
        p
        for p in (
            check_restitution("restitution.shot_target", restitution),
            check_restitution("restitution.shot_shot", scene.restitution.shot_shot),
        )
        if p
    ]
    if not dt_over_P > 0.0 or guarded and dt_over_P > MAX_DT_OVER_P:
        problems.append(
            f"time step = {dt_over_P} P: must lie in (0, {MAX_DT_OVER_P}] P-wave steps of the smallest shot"
        )
    angle = math.radians(nozzle.impact_angle_deg)
    lowest = nozzle.stand_off_m * math.sin(angle) - 0.5 * nozzle.jet_diameter_m * math.cos(angle)
    if not lowest > large:
        problems.append(
            f"nozzle: the lower edge of its exit is {lowest:.4g} m above the target; must be more than the"
            f" largest shot ({large:.4g} m): raise stand_off_m or impact_angle_deg"
        )
    overlap = elastic_overlap(scene.shots, nozzle, material)
    if not overlap < MAX_OVERLAP:
        problems.append(
            f"speed_m_s = {nozzle.speed_m_s}: elastic overlap {overlap:.2f} of the radius;"
            f" must be below {MAX_OVERLAP}"
        )
    if problems:
        raise InputError(problems)

    dt = dt_over_P * p_wave_step_s(small, shot)
    shortest = steps_per_contact(scene.shots, nozzle, material, dt_over_P)
    if guarded and shortest < MIN_STEPS_PER_CONTACT:
        raise InputError(
            f"time step = {dt_over_P} P: the shortest contact lasts {shortest:.1f} steps; must be at least"
            f" {MIN_STEPS_PER_CONTACT}: --accuracy reference"
        )
    rig = dict(shot=shot, target=target, diameter_m=mean, dt_s=dt)
    # two thirds: mean normal share of the relative speed when hard spheres meet at random
    speeds = {"target": nozzle.normal_speed_m_s, "shot": nozzle.speed_m_s * (1.0 + restitution) * 2.0 / 3.0}
    wanted = {"target": restitution, "shot": scene.restitution.shot_shot}
    if guarded:
        on_target, on_shot = (
            calibrate(wanted[p], pair=p, speed_m_s=speeds[p], **rig) for p in ("target", "shot")
        )
    else:
        on_target, on_shot = (Calibration(wanted[p], wanted[p], *[math.nan] * 3) for p in ("target", "shot"))
    laws = (Law(on_target.en, scene.friction.shot_target), Law(on_shot.en, scene.friction.shot_shot))
    return Plan(shot, target, dt, dt_over_P, on_target, on_shot, laws)


class Row(NamedTuple):
    """One check after the run."""

    name: str
    value: float
    limit: float
    passed: bool


def postflight(plan: Plan, stream, logger) -> list[Row]:
    """The checks of a finished run (finite speeds, flight and energy were also checked while it ran)."""
    fed, dropped, live = stream.next, sum(stream.dropped.values()), len(logger.live)
    blocked = stream.dropped["inlet"]
    soft = min(m.young / s.E_Pa for m, s in zip(O.materials, (plan.shot, plan.target)))
    lowest = min((O.bodies[b].state.pos[2] for b in logger.live), default=math.inf)
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
        ("lowest shot centre [m]", lowest, 0.0, lowest > 0.0),
        ("largest speed [m/s]", logger.top_speed, logger.speed_limit, logger.top_speed <= logger.speed_limit),
        (
            "gain of kinetic energy in a contact",
            logger.worst_gain,
            ENERGY_TOLERANCE,
            logger.worst_gain <= ENERGY_TOLERANCE,
        ),
        (
            "kinetic energy left over fed",
            stream.energy_left(),
            1.0 + ENERGY_TOLERANCE,
            stream.energy_left() <= 1.0 + ENERGY_TOLERANCE,
        ),
        ("change of momentum in a collision", logger.worst_momentum, 1e-9, logger.worst_momentum <= 1e-9),
        ("contact stiffness over the materials'", soft, 1.0, soft == 1.0),
    ]
    return [Row(*row) for row in rows]
