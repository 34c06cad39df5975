"""Shots and target in YADE: materials, contact law, time step, and the restitution the law really gives.

Hertz-Mindlin contact (``MindlinPhys``) with a restitution per pair of materials.  What is set here and
why, each measured with YADE 2023.02a:

- ``NewtonIntegrator(damping=0)``: the default 0.2 falsifies every rebound;
- ``hertzian=True`` on wall and facet: without it the contact radius is R/2 (facet: between) and the peak
  force 13 % (8 %) low;
- ``es=0.99``: left alone it equals ``en`` and the sliding impulse is 8.6 % above Coulomb's;
- a fixed time step: no time stepper sees an impact coming;
- ``en`` is corrected until the mean rebound at the working time step is the wanted one: at one P-wave
  step a contact lasts 20-30 steps and the rebound is some tenths of a per cent low, more at low ``en``.
"""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import NamedTuple

from yade import O, utils
from yade.wrapper import (
    Bo1_Facet_Aabb,
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    ForceResetter,
    FrictMat,
    Ig2_Facet_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom_MindlinPhys_Mindlin,
    MatchMaker,
    NewtonIntegrator,
)

from glue.errors import InputError
from glue.theory import hertz

LIVE, PARKED = 1, 2  # group masks: parked bodies neither move nor touch, and cost the integrator nothing
EN_RANGE = "(0, 0.94] or exactly 1"  # en saturates above .94 (.97 gives .965), 0 gives NaN


@dataclass(frozen=True)
class Solid:
    """Elastic constants of shot or target."""

    E_Pa: float
    nu: float
    density_kg_m3: float


class Law(NamedTuple):
    """One pair's inputs of the contact law: restitution as given to YADE, friction coefficient."""

    en: float
    friction: float


class Rebound(NamedTuple):
    """One impact in the measuring rig."""

    restitution: float
    peak_force_N: float
    duration_s: float
    betan: float  # damping ratio of the contact


def check_restitution(name: str, e: float) -> str | None:
    """The complaint about a restitution that the law cannot give, or None."""
    if e == 1.0 or 0.0 < e <= 0.94:
        return None
    return f"{name} = {e}: must lie in {EN_RANGE} (between, the contact law does not give what is asked)"


def p_wave_step_s(diameter_m: float, solid: Solid) -> float:
    """P = R sqrt(rho/E) [s], the time a P wave takes through the radius of the smallest shot."""
    return 0.5 * diameter_m * math.sqrt(solid.density_kg_m3 / solid.E_Pa)


def contact_modulus_Pa(a: Solid, b: Solid) -> float:
    return hertz.effective_modulus_Pa(a.E_Pa, a.nu, b.E_Pa, b.nu)


class Built(NamedTuple):
    """Ids of YADE's materials: of the shots by medium, of the target."""

    media: list[int]
    target: int


def build(shot: Solid, target: Solid, shot_target: Law, shot_shot: Law, *, dt_s: float, sweep_m: float):
    """``build_media`` for one medium on the plane z = 0 (body 0); returns the shots' material."""
    return build_media((shot,), target, shot_target, shot_shot, dt_s=dt_s, sweep_m=sweep_m).media[0]


def build_media(
    media, target: Solid, shot_target: Law, shot_shot: Law, *, dt_s: float, sweep_m: float, plane: bool = True
) -> Built:
    """Empty the simulation; set materials of all ``media`` (Solids) and of the target, plane (body 0), engines.

    Every medium has the given laws against the target and against every medium.  ``sweep_m`` is how far a shot
    may move before the collider looks again: performance only.
    """
    O.reset()

    def material(solid, law, label):
        return O.materials.append(
            FrictMat(
                young=solid.E_Pa,
                poisson=solid.nu,
                density=solid.density_kg_m3,
                frictionAngle=math.atan(law.friction),
                label=label,
            )
        )

    shots = [material(solid, shot_shot, f"shot{n}") for n, solid in enumerate(media)]
    plate = material(target, shot_target, "target")
    if plane:
        wall = utils.wall(0.0, axis=2, sense=1, material=plate)  # one plane: two facets would make two contacts
        wall.mask = LIVE
        assert O.bodies.append(wall) == 0

    def per_pair(on_target, on_shot):
        pairs = [(n, plate, on_target) for n in shots]
        pairs += [(n, m, on_shot) for n in shots for m in shots if n <= m]
        return MatchMaker(matches=pairs)

    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb(), Bo1_Facet_Aabb()], verletDist=sweep_m),
        InteractionLoop(
            [
                Ig2_Sphere_Sphere_ScGeom(),
                Ig2_Wall_Sphere_ScGeom(hertzian=True),
                Ig2_Facet_Sphere_ScGeom(hertzian=True),
            ],
            [
                Ip2_FrictMat_FrictMat_MindlinPhys(
                    en=per_pair(shot_target.en, shot_shot.en),
                    es=per_pair(0.99, 0.99),
                    frictAngle=per_pair(math.atan(shot_target.friction), math.atan(shot_shot.friction)),
                )
            ],
            [Law2_ScGeom_MindlinPhys_Mindlin()],
        ),
        NewtonIntegrator(damping=0.0, gravity=(0.0, 0.0, 0.0), mask=LIVE),
    ]
    O.dt = dt_s
    return Built(shots, plate)


def add_shot(material: int, diameter_m: float, position, velocity) -> int:
    """Append a live sphere; returns its body id."""
    body = utils.sphere(position, 0.5 * diameter_m, material=material)
    body.mask = LIVE
    body.state.vel = velocity
    return O.bodies.append(body)


def look_for_partners() -> None:
    """Have the collider look at once; to be called when bodies were moved by hand (4 us).

    By itself it does so only after the integrator has seen a body leave its box, a step late
    (``collider.doSort`` does not change that: it says how to sort, not when).
    """
    O.engines[1]()


def sort_anew() -> None:
    """Have the collider look at every pair when it looks next, not only at those whose order has changed."""
    O.engines[1].doSort = True


def total_force_N(interaction) -> float:
    """Size [N] of the normal contact force, |normalForce - normalViscous|.

    YADE keeps the elastic part and the dashpot's part apart; bodies feel their difference.
    """
    phys = interaction.phys
    return (phys.normalForce - phys.normalViscous).norm()


def measure_rebounds(
    shot: Solid,
    target: Solid,
    *,
    pair: str,
    en: float,
    speed_m_s: float,
    diameter_m: float,
    dt_s: float,
    phases: int,
    betan: float | None = None,
) -> list[Rebound]:
    """Head-on impacts at ``phases`` equal sub-step phases, all in one go far apart from each other.

    ``pair`` is "target" (shot on plane) or "shot" (two shots, ``speed_m_s`` their closing speed, each
    with half of it).  ``betan`` replaces the damping ratio after the contact's first step, as ``dashpots.py`` does;
    that of ``en`` until then.  Empties the simulation.  Durations are exact below the step: free flight before
    and after gives the moments of first and last touch.
    """
    law = Law(en, 0.0)
    steel = build(shot, target, law, law, dt_s=dt_s, sweep_m=0.1 * diameter_m)
    radius = 0.5 * diameter_m
    own = speed_m_s if pair == "target" else 0.5 * speed_m_s
    start, first, touch = [], [], []
    for i in range(phases):
        gap = speed_m_s * dt_s * (3.0 + (i + 0.5) / phases)  # never on a step, where rounding would decide
        x = 4.0 * diameter_m * i
        z = radius + gap if pair == "target" else 100.0 * diameter_m
        first.append(add_shot(steel, diameter_m, (x, 0.0, z), (0.0, 0.0, -own)))
        if pair == "shot":
            add_shot(steel, diameter_m, (x, 0.0, z - diameter_m - gap), (0.0, 0.0, own))
        touch.append(gap / speed_m_s)
        start.append(z)
    peaks, ends, ratios = [0.0] * phases, [None] * phases, [math.nan] * phases
    while None in ends:
        O.step()
        for i, body in enumerate(first):
            contacts = O.bodies[body].intrs()
            state = O.bodies[body].state
            if contacts:
                if not peaks[i]:
                    if betan is not None:
                        contacts[0].phys.betan = betan
                    ratios[i] = contacts[0].phys.betan
                peaks[i] = max(peaks[i], total_force_N(contacts[0]))
            elif peaks[i] and ends[i] is None:
                apart = state.pos[2] - (0.0 if pair == "target" else O.bodies[body + 1].state.pos[2])
                touching = radius if pair == "target" else diameter_m
                speed = state.vel[2] * (speed_m_s / own)
                ends[i] = (state.vel[2] / own, O.time - (apart - touching) / speed)
        if O.time > 1e3 * max(touch) + 1e4 * dt_s:
            raise InputError(f"a {pair} contact with en = {en} did not end at dt = {dt_s:.3g} s")
    return [
        Rebound(e, peak, end - begin, ratio)
        for (e, end), peak, begin, ratio in zip(ends, peaks, touch, ratios)
    ]


class Calibration(NamedTuple):
    """The ``en`` to give YADE and the rebound that it produces, mean and range over sub-step phases."""

    wanted: float
    en: float
    mean: float
    low: float
    high: float


def calibrate(wanted: float, *, phases: int = 32, **rig) -> Calibration:
    """``en`` whose mean rebound is ``wanted`` within 1e-4 of it, by secant (``rig``: where it is measured).

    1 is taken as it is: undamped contacts return their energy, and no ``en`` could correct them upwards.
    Raises InputError when no ``en`` does it.
    """

    def mean_at(en):
        e = [r.restitution for r in measure_rebounds(en=en, phases=phases, **rig)]
        return Calibration(wanted, en, statistics.fmean(e), min(e), max(e))

    now = mean_at(wanted)
    if wanted == 1.0:
        return now
    slope = 1.0  # de/den is near 1 away from the ends
    for _ in range(12):
        miss = wanted - now.mean
        if abs(miss) <= 1e-4 * wanted:
            return now
        en = min(max(now.en + miss / slope, 0.2 * now.en), 0.5 * (1.0 + now.en))
        new = mean_at(en)
        if new.en != now.en and new.mean != now.mean:
            slope = max((new.mean - now.mean) / (new.en - now.en), 0.1)
        now = new
    raise InputError(
        f"no en gives a mean restitution of {wanted} at dt = {rig['dt_s']:.3g} s"
        f" (en {now.en:.4f} gives {now.mean:.4f}): use a smaller time step"
    )
