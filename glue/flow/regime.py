"""Which physics of the shot stream matters, and the cheapest flow model that is good enough.

Every choice comes from dimensionless numbers: how often shots meet (``collision_number``), how many contacts a
third shot disturbs (``overlap_number``), what gravity and air do on the way to the target.  Each model's
expected error, of the mean normal energy of the impacts and of the share of shots that collided, follows from
them and is held against ``accuracy.flow_tolerance``.

A curved target counts as its tangent plane: convex ones scatter their rebounds and lower the numbers.
Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow import overlap
from glue.flow.drag import drag_number
from glue.scene.model import Choice, Scene
from glue.scene.sizes import CUT_VARIANCE
from glue.theory import hertz

BALLISTIC_BELOW = 0.01  # pi_eff below which shots that never meet are right to 1 % in number and energy
# Collisions per shot from their number to first order, see ``settled``: fitted by tests/benchmarks/collision_fit.py
CASCADE, CASCADE_POWER, THINNING = 2.42, 0.84, 2.12
# Mean normal energy lost to collisions, c n / (1 + k n) with n collisions per shot, within 13 %: same fit
ENERGY_LOSS, ENERGY_LOSS_ENDS = 0.92, 0.97
# Difference of event-driven and contact runs per collision per shot, an upper bound: tests/benchmarks/bench_flow.py
# finds .0033 of the share at .41 collisions per shot and .0012 at .14, and half of that may be chance either way
EVENT_BIAS = 0.0175
# Of contact runs at one P-wave step: drift of the energy of elastic shots 7e-4, in proportion to the step
DEM_ERROR_PER_P = 1e-3
MODELS = ("ballistic", "event", "dem")  # from cheap to exact


class FlowChoice(NamedTuple):
    """The flow model to run, why, and what the user should know about it."""

    model: str
    why: str
    warnings: list[str]


class Physics(NamedTuple):
    """A scene whose "auto" blocks are decided (kept, or None), and a sentence for each of them."""

    scene: Scene
    choices: dict[str, Choice]  # by block: "on" or "off", and why


def collision_number(scene: Scene, restitution: float) -> dict[str, float]:
    """How often a shot meets others: {"pi", "pi_eff", "crossing", "collisions_per_shot"}.

    ``pi`` is that of the nozzles blowing normally and in parallel, a check by hand:

        pi = 6 m H (1 + e) / (rho d A v e),   A = pi W^2 / 4

    (m mass flow, H stand-off, W jet width, e restitution on the target; several nozzles: mean by mass flow).
    ``pi_eff`` is the number of collisions per shot to first order, from the overlap of the jets with the
    clouds of their rebounds, of crossing jets with each other, and of faster shots with slower ones of their
    own jet (``overlap.py``).  ``crossing`` is how many shots one would meet that crosses the jet at its own
    speed.  ``collisions_per_shot`` is what becomes of pi_eff when collisions have consequences (``settled``):
    shot-shot collisions over shots, each collision counted once (not once per partner), in steady state.

    Raises InputError for a restitution outside (0, 1].
    """
    if not 0.0 < restitution <= 1.0:
        raise InputError(f"restitution {restitution}: must lie in (0, 1]")
    pi_eff, crossing = first_order_collisions(scene, restitution), crossing_number(scene)
    return {
        "pi": _head_on(scene, restitution),
        "pi_eff": pi_eff,
        "crossing": crossing,
        "collisions_per_shot": settled(pi_eff, crossing, _sine(scene), restitution),
    }


@functools.lru_cache(maxsize=8)  # asked for several times a run: choices, costs, the flow itself
def first_order_collisions(scene: Scene, restitution: float) -> float:
    """Collisions per shot if none disturbed the next: sum over pairs of clouds (see ``overlap.py``).

    Without those of rebounds among themselves, most of which are on their way out.
    """
    rates = [nozzle.mass_flow_kg_s * scene.shots_per_kg for nozzle in scene.nozzles]
    jets = [overlap.incoming(n, rate) for n, rate in zip(scene.nozzles, rates)]
    rebounds = [
        overlap.outgoing(
            n,
            rate,
            restitution,
            overlap.kept_tangential_speed(n, restitution, scene.friction.shot_target),
        )
        for n, rate in zip(scene.nozzles, rates)
    ]
    section = overlap.cross_section_m2(scene)
    total = sum(overlap.meetings_1_s(jet, cloud, section) for jet in jets for cloud in rebounds)
    for i, jet in enumerate(jets):
        total += sum(overlap.meetings_1_s(jet, other, section) for other in jets[i + 1 :])
        total += 0.5 * overlap.meetings_1_s(jet, jet, section, _overtaking_m_s(jet))
    return float(total / sum(rates))


def crossing_number(scene: Scene) -> float:
    """Shots met on the way across a jet at the target, n sigma W with n shots per volume; mean by mass flow."""
    section = overlap.cross_section_m2(scene)
    total = 0.0
    for nozzle in scene.nozzles:
        radius = nozzle.footprint_semi_axes_m[1]
        per_volume = nozzle.mass_flow_kg_s * scene.shots_per_kg / (nozzle.speed_m_s * math.pi * radius**2)
        once = 2.0 * radius * section * per_volume
        if nozzle.pulse is not None:  # who is there to be hit left the nozzle in the same burst
            once *= float(overlap.autocorrelation(nozzle.pulse, 2.0 * radius / nozzle.speed_m_s))
        total += nozzle.mass_flow_kg_s * once
    return total / scene.mass_flow_kg_s


def settled(pi_eff: float, crossing: float, sine: float, restitution: float) -> float:
    """Collisions per shot in steady state, n, from their number to first order; ``sine`` of the impact angle s.

        n = pi_eff (1 + 2.42 crossing^0.84 s^2 e^-1/2) / (1 + 2.12 pi_eff s^4)

    Numerator: a shot that was hit drifts across the jet and is hit again.  Denominator: it is then no longer
    in the rebounds' way, which counts where jet and rebounds share their path.  Fitted to event-driven runs
    (restitution between shots .8, friction .2): 30-90 degrees, e .3-.8, .02 <= pi_eff <= 2, jets 6 and more
    diameters wide; ``collision_fit.py`` measures its error on other scenes (4 % rms, 13 % at worst of 200).
    Beyond the fit, single runs: half angles of 1-10 degrees, Gaussian profiles, 10 % speed spread, mixed media,
    pulses, restitution between shots .6-.9 and friction 0-.5 within 7 %; two jets that cross where they aim: 27 %
    too many.
    """
    again = CASCADE * crossing**CASCADE_POWER * sine**2 / math.sqrt(restitution)
    return pi_eff * (1.0 + again) / (1.0 + THINNING * pi_eff * sine**4)


def overlap_number(scene: Scene, restitution: float) -> float:
    """Share of contacts with the target in which a third shot joins: contact time x rate of being met there.

    Event-driven flows take every contact as instant and of two; contact time by Hertz, at the lead medium's
    mean size; density and speed of jets and rebounds at the target's surface.
    """
    shots, material = scene.shots, scene.target.material
    modulus = hertz.effective_modulus_Pa(shots.E_Pa, shots.nu, material.E_Pa, material.nu)
    met_1_s = longest_s = 0.0
    for nozzle in scene.nozzles:
        jet = overlap.incoming(nozzle, nozzle.mass_flow_kg_s * scene.shots_per_kg)
        kept = overlap.kept_tangential_speed(nozzle, restitution, scene.friction.shot_target)
        rebound = overlap.outgoing(nozzle, jet.rate_1_s, restitution, kept)
        per_area = jet.rate_1_s / nozzle.footprint_area_m2
        rising = float(np.linalg.norm(rebound.velocity_m_s))  # the shot that is met is at rest on the whole
        met_1_s += per_area * (nozzle.speed_m_s / abs(jet.velocity_m_s[2]) + rising / rebound.velocity_m_s[2])
        touch = hertz.impact(0.5 * shots.diameter_m, shots.density_kg_m3, nozzle.normal_speed_m_s, modulus)
        longest_s = max(longest_s, touch.contact_time_s)
    return float(overlap.cross_section_m2(scene) * met_1_s * longest_s)


def gravity_number(scene: Scene) -> float:
    """Change of a shot's energy by gravity over the stand-off, 2 g H / v^2, or its sag over the jet's radius.

    The larger of the two, over all nozzles; 0 without gravity.
    """
    if scene.gravity is None:
        return 0.0
    g = scene.gravity.acceleration_m_s2
    return max(
        g * n.stand_off_m / n.speed_m_s**2 * max(2.0, n.stand_off_m / n.jet_diameter_m) for n in scene.nozzles
    )


def resolve_physics(scene: Scene) -> Physics:
    """Decide the blocks that are "auto": on where they change energy or place by more than half the tolerance.

    Half, because two of them and the model's own error add up.  Blocks that the scene states stay.
    """
    limit = 0.5 * scene.accuracy.flow_tolerance
    numbers = {"gravity": gravity_number, "air_drag": lambda s: 2.0 * drag_number(s)}
    effects = {"gravity": "energy or place of a shot", "air_drag": "energy of a shot"}
    decided, choices = {}, {}
    for block, number in numbers.items():
        asked = getattr(scene, block)
        if asked is None:
            continue
        value = number(scene)
        on = not asked.auto or value > limit
        if not asked.auto:
            rule = "the scene asks for it"
        else:
            rule = f"{'above' if on else 'within'} {limit:.2g}, half of accuracy.flow_tolerance"
        choices[block] = Choice(
            "on" if on else "off", f"changes the {effects[block]} by {value:.2g} ({rule})"
        )
        decided[block] = dataclasses.replace(asked, auto=False) if on else None
    return Physics(dataclasses.replace(scene, **decided), choices)


def expected_errors(scene: Scene, restitution: float) -> dict[str, float]:
    """Expected error of each of ``MODELS``: of mean normal energy (relative) and collided share (absolute).

    ballistic: the energy that collisions would take; event: its measured difference from contact runs, or the
    share of contacts that a third shot joins if that is larger; dem: that of its time step, and with softened contacts, which
    last longer, the share that a third shot joins for that.
    """
    collisions = collision_number(scene, restitution)["collisions_per_shot"]
    return {
        "ballistic": ENERGY_LOSS * collisions / (1.0 + ENERGY_LOSS_ENDS * collisions),
        "event": max(EVENT_BIAS * collisions, overlap_number(scene, restitution)),
        "dem": DEM_ERROR_PER_P * scene.accuracy.flow_dt_over_P
        + (scene.accuracy.flow_stiffness_scale**-0.4 - 1.0) * overlap_number(scene, restitution),
    }


def choose_flow(scene: Scene, restitution: float) -> FlowChoice:
    """The flow model to run: the scene's own, or for "auto" the cheapest within ``accuracy.flow_tolerance``.

    Ballistic flows are taken only below pi_eff = .01 too; contact runs when nothing cheaper is good enough.
    A model that the scene asks for is never replaced, but warned of when its expected error exceeds the
    tolerance (ballistic: from pi_eff = .01 on, whatever the tolerance).  Raises InputError for a restitution
    outside (0, 1].
    """
    asked, tolerance = scene.models.flow.model, scene.accuracy.flow_tolerance
    pi_eff = collision_number(scene, restitution)["pi_eff"]
    errors = expected_errors(scene, restitution)
    listed = ", ".join(f"{model} {errors[model]:.2g}" for model in MODELS)
    numbers = f"pi_eff {pi_eff:.2g}; expected error {listed}; tolerance {tolerance:g}"
    if asked != "auto":
        return FlowChoice(
            asked, f"the scene asks for it ({numbers})", _warnings(asked, pi_eff, errors, tolerance)
        )
    for model in MODELS:
        if errors[model] <= tolerance and (model != "ballistic" or pi_eff < BALLISTIC_BELOW):
            return FlowChoice(model, f"cheapest that is good enough: {numbers}", [])
    return FlowChoice("dem", f"the most exact, none is within the tolerance: {numbers}", [])


def _warnings(model: str, pi_eff: float, errors: dict[str, float], tolerance: float) -> list[str]:
    error = errors[model]
    if model == "ballistic" and pi_eff >= BALLISTIC_BELOW:
        sentence = (
            f"ballistic shots never meet, but here pi_eff = {pi_eff:.2g} (allowed below {BALLISTIC_BELOW:g}):"
            f" expect an error of {error:.1%} in the mean normal energy (less on a curved target, which counts as flat);"
            f" the event-driven flow's is {errors['event']:.1%}"
        )
    elif error > tolerance and model != "dem":
        sentence = (
            f'models.flow = "{model}": expected error {error:.2g} of energy and collided share, above'
            f" accuracy.flow_tolerance = {tolerance:g}"
        )
    else:
        return []
    return [sentence]


def _sine(scene: Scene) -> float:
    """Of the impact angle; mean over the nozzles by mass flow."""
    shares = (n.mass_flow_kg_s * math.sin(math.radians(n.impact_angle_deg)) for n in scene.nozzles)
    return sum(shares) / scene.mass_flow_kg_s


def _head_on(scene: Scene, restitution: float) -> float:
    """6 m H (1+e) / (rho d A v e), mean over the nozzles by mass flow; lead medium's size and density."""
    shots = scene.shots
    numbers = (
        6.0
        * n.mass_flow_kg_s
        * n.stand_off_m
        * (1.0 + restitution)
        / (
            shots.density_kg_m3
            * shots.diameter_m
            * math.pi
            / 4.0
            * n.jet_diameter_m**2
            * n.speed_m_s
            * restitution
        )
        * n.mass_flow_kg_s
        for n in scene.nozzles
    )
    return sum(numbers) / scene.mass_flow_kg_s


def _overtaking_m_s(cloud: overlap.Cloud) -> float:
    """Mean difference of speed between two shots of one cloud: 2/sqrt(pi) standard deviations (normal)."""
    spread = math.sqrt(CUT_VARIANCE) * cloud.nozzle.speed_cv
    return 2.0 / math.sqrt(math.pi) * spread * float(np.linalg.norm(cloud.velocity_m_s))
