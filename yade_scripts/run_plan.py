"""Before the run: does this scene make a simulation that can be right, and with which step and dashpots?"""

from __future__ import annotations

import math
from typing import NamedTuple

from contact_model import Calibration, Law, Solid, calibrate, check_restitution, p_wave_step_s
from dashpots import DashpotMap
from glue.errors import InputError
from glue.flow.restitution import RestitutionLaw
from glue.scene import sizes
from glue.scene.contact_checks import MAX_OVERLAP, MIN_STEPS_PER_CONTACT, elastic_overlap, steps_per_contact
from glue.scene.reach import inlet_clearance_problem

MAX_DT_OVER_P = 1.5  # at 2 the elastic energy drifts by .5 %, at 4.4 by 24 %


class Plan(NamedTuple):
    """What a run needs to know: solids (media in the scene's order), step, laws of the leading medium."""

    media: tuple[Solid, ...]
    target: Solid
    dt_s: float
    dt_over_P: float
    restitution: RestitutionLaw
    shot_target: Calibration
    shot_shot: Calibration
    laws: tuple[Law, Law]  # shot-target, shot-shot
    maps: (
        dict[str, DashpotMap] | None
    )  # "target", "shot"; None where one restitution per pair serves all contacts
    speed_limit_m_s: float  # no shot can be faster
    shortest_contact_steps: float


def solid(part) -> Solid:
    """The elastic constants of a scene's ``Shots`` or ``Material``."""
    return Solid(part.E_Pa, part.nu, part.density_kg_m3)


def plan_run(scene, restitution: RestitutionLaw, dt_over_P: float, *, guarded: bool = True) -> Plan:
    """Check all that can be checked before the first step and calibrate the restitution, or raise InputError.

    The step is ``dt_over_P`` times the least P of any shot: of the smallest, of the stiffest medium.
    ``guarded=False`` leaves out what would refuse a too large time step (to test the checks after the run).
    """
    media, target = tuple(solid(shots) for shots in scene.media), solid(scene.target.material)
    speed = max(n.normal_speed_m_s for n in scene.nozzles)
    smallest = {n: sizes.smallest_m(shots) for n, shots in enumerate(scene.media)}
    if not min(smallest.values()) > 0.0:
        raise InputError("shots.size_cv: the smallest shot has no size; must be below 0.4")
    e_target, e_shot = restitution.at(speed, scene.shots.density_kg_m3), scene.restitution.shot_shot
    ends = {"restitution.shot_target": e_target, "restitution.shot_shot": e_shot}
    if restitution.exponent or restitution.points:
        ends["restitution.shot_target at low speed"] = restitution.largest
    if restitution.hardening:
        ends["restitution.hardening.saturated"] = restitution.hardening.saturated
    problems = [check_restitution(name, e) for name, e in ends.items()]
    problems += [inlet_clearance_problem(nozzle, scene.largest_diameter_m) for nozzle in scene.nozzles]
    if not dt_over_P > 0.0 or guarded and dt_over_P > MAX_DT_OVER_P:
        problems.append(
            f"time step = {dt_over_P} P: must lie in (0, {MAX_DT_OVER_P}] P-wave steps of the smallest shot"
        )
    overlap = elastic_overlap(scene.media, scene.nozzles, scene.target.material)
    if not overlap < MAX_OVERLAP:
        problems.append(
            f"speed_m_s = {scene.fastest_m_s}: elastic overlap {overlap:.2f} of the radius;"
            f" must be below {MAX_OVERLAP}"
        )
    problems = [p for p in problems if p]
    if problems:
        raise InputError(problems)
    shortest = steps_per_contact(scene.media, scene.nozzles, scene.target.material, dt_over_P)
    if guarded and shortest < MIN_STEPS_PER_CONTACT:
        raise InputError(
            f"time step = {dt_over_P} P: the shortest contact lasts {shortest:.1f} steps; must be at least"
            f" {MIN_STEPS_PER_CONTACT}: --accuracy reference"
        )
    dt = dt_over_P * min(p_wave_step_s(smallest[n], made_of) for n, made_of in enumerate(media))
    rig = dict(shot=solid(scene.shots), target=target, diameter_m=sizes.mean_m(scene.shots), dt_s=dt)
    # two thirds: mean normal share of the relative speed when hard spheres meet at random
    speeds = {"target": speed, "shot": scene.nozzle.speed_m_s * (1.0 + e_target) * 2.0 / 3.0}
    wanted = {"target": e_target, "shot": e_shot}
    if guarded:
        on_target, on_shot = (
            calibrate(wanted[p], pair=p, speed_m_s=speeds[p], **rig) for p in ("target", "shot")
        )
    else:
        on_target, on_shot = (Calibration(wanted[p], wanted[p], *[math.nan] * 3) for p in ("target", "shot"))
    laws = (Law(on_target.en, scene.friction.shot_target), Law(on_shot.en, scene.friction.shot_shot))
    maps = None
    varies = restitution.exponent or restitution.points or restitution.hardening or len(media) > 1 or scene.shots.size != "mono"
    if varies and guarded:
        maps = {
            pair: DashpotMap(pair, en=law.en, speed_m_s=speeds[pair], **rig)
            for pair, law in zip(("target", "shot"), laws)
        }
    return Plan(
        *(media, target, dt, dt_over_P, restitution, on_target, on_shot, laws, maps),
        speed_limit_m_s=_speed_limit_m_s(scene),
        shortest_contact_steps=shortest,
    )


def _speed_limit_m_s(scene) -> float:
    """Twice the energy of one lightest and one heaviest shot at full speed, all in the lightest; two equal ones: 2 v.

    A single contact is held to much less (``ImpactLogger``): this stops a blow-up that creeps.
    """
    masses = [
        shots.density_kg_m3 * d**3
        for shots in scene.media
        for d in (sizes.smallest_m(shots), sizes.largest_m(shots))
    ]
    gas = abs(scene.air_drag.gas_speed_m_s) if scene.air_drag else 0.0
    return max(scene.fastest_m_s, gas) * math.sqrt(2.0 * (1.0 + max(masses) / min(masses)))
