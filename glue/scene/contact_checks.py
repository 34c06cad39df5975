"""Checks of the flow's contacts: shallow enough for YADE's contact law, and long enough for the preset's time step.

Closed forms of Hertz over all media and nozzles of the scene.  Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations_with_replacement

from glue.scene import sizes
from glue.scene.effects import AirDrag
from glue.scene.fields import show
from glue.scene.jet_checks import Media, Nozzles, Problem, driven, named
from glue.scene.model import Material, Restitution, Shots
from glue.scene.presets import Accuracy
from glue.scene.softened import softened_parts

MIN_STEPS_PER_CONTACT = 9.0  # shot on shot at dt = 1.0 P: 13.7 at 60 m/s, 12 at twice the speed
MAX_OVERLAP = 0.3  # of the radius; beyond, the flow's contact law means nothing
DIMPLE_REBOUND = 0.5  # more than a dimple that presses a shot deep gives back


def steps_per_contact(media: Media, nozzles: Nozzles, material: Material, dt_over_P: float) -> float:
    """How many of the flow's time steps the shortest contact lasts: Hertz, no damping.

    dt = dt_over_P times the least P = R sqrt(rho/E) of any shot.  Contacts are shortest between the smallest shots,
    of one medium or of two, at up to twice the fastest shot's speed, or of those on the target at that speed.
    """
    speed = _fastest_m_s(nozzles)
    p_wave_s = min(0.5 * sizes.smallest_m(s) * math.sqrt(s.density_kg_m3 / s.E_Pa) for s in media)
    on_target = (_contact(s, sizes.smallest_m(s), material, None, speed)[1] for s in media)
    on_shot = (
        _contact(a, sizes.smallest_m(a), b, sizes.smallest_m(b), 2.0 * speed)[1]
        for a, b in combinations_with_replacement(media, 2)
    )
    return min(*on_target, *on_shot) / (dt_over_P * p_wave_s)


def elastic_overlap(media: Media, nozzles: Nozzles, material: Material) -> float:
    """Depth of the deepest elastic impact on the target at full speed, as a share of the shot's radius (Hertz)."""
    speed = _fastest_m_s(nozzles)
    return max(2.0 * _contact(s, 1.0, material, None, speed)[0] for s in media)


def shot_overlap(media: Media, nozzles: Nozzles, rebound: float) -> float:
    """Depth of the deepest elastic impact of two shots over the smaller one's radius (Hertz).

    They meet in flight, or one of them after the target threw it back with ``rebound`` times its normal speed.
    """
    speed = max(_meeting_speeds_m_s(nozzles, rebound))
    return max(
        2.0 * _contact(a, x, b, y, speed)[0] / min(x, y)
        for a, b in combinations_with_replacement(media, 2)
        for x in (sizes.smallest_m(a), sizes.largest_m(a))
        for y in (sizes.smallest_m(b), sizes.largest_m(b))
    )


def _fastest_m_s(nozzles: Nozzles) -> float:
    return max(nozzle.fastest_m_s for nozzle in nozzles)


def _meeting_speeds_m_s(nozzles: Nozzles, rebound: float) -> Iterator[float]:
    """Relative speeds [m/s] at which the fastest shots of two nozzles meet, coming or going."""
    for a in nozzles:
        for b in nozzles:
            (ax, ay, az), (bx, by, bz) = a.direction, b.direction
            v, w = a.fastest_m_s, b.fastest_m_s
            flat = math.hypot(v * ax - w * bx, v * ay - w * by)
            yield math.hypot(flat, v * az - w * bz)
            yield math.hypot(flat, v * az + rebound * w * bz)


def _contact(a: Shots, a_m: float, b: Shots | Material, b_m: float | None, speed_m_s: float) -> tuple[float, float]:
    """(depth [m], time [s]) of an elastic impact of a sphere of diameter ``a_m`` on another, or (None) on a plane.

    depth = (15 m v^2 / (16 E* R^(1/2)))^(2/5), time = 2.9432 depth / v, the factor 2 integral dx / sqrt(1 - x^2.5)
    over 0..1; as ``glue.theory.hertz``, which needs numpy.
    """
    mass, radius = a.density_kg_m3 * math.pi / 6.0 * a_m**3, 0.5 * a_m
    if b_m is not None:
        other = b.density_kg_m3 * math.pi / 6.0 * b_m**3
        mass, radius = mass * other / (mass + other), radius * b_m / (a_m + b_m)
    compliance = (1.0 - a.nu**2) / a.E_Pa + (1.0 - b.nu**2) / b.E_Pa  # 1/E*
    depth = (15.0 / 16.0 * mass * speed_m_s**2 * compliance / math.sqrt(radius)) ** 0.4
    factor = 0.8 * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)
    return depth, factor * depth / speed_m_s


def contact_problems(
    media: Media,
    nozzles: Nozzles,
    material: Material,
    accuracy: Accuracy,
    restitution: Restitution | None,
    air_drag: AirDrag | None,
) -> Iterator[Problem]:
    """YADE's contacts must be shallow, and long enough for the preset's time step."""
    media, material = softened_parts(media, material, accuracy.flow_stiffness_scale)
    exits, nozzles = nozzles, tuple(driven(nozzle, media, air_drag) for nozzle in nozzles)
    name, nozzle = max(named(nozzles), key=lambda pair: pair[1].fastest_m_s)
    fastest = nozzle.fastest_m_s
    said = f"{show(fastest)} m/s" + (" (the fastest by speed_cv)" if nozzle.speed_cv else "")
    key, must = f"{name}.speed_m_s", "allowed"
    if air_drag and nozzle.speed_m_s > dict(named(exits))[name].speed_m_s:
        key, must, said = "air_drag.gas_speed_m_s", "allowed: a gas that drives shots", f"driving shots to {said}"
    overlap, how = max(
        (elastic_overlap(media, nozzles, material), "a shot {} of its radius into an elastic target"),
        (shot_overlap(media, nozzles, _largest_rebound(restitution)), "two shots {} of a radius into each other"),
    )
    if overlap >= MAX_OVERLAP:
        most = nozzle.speed_m_s * (MAX_OVERLAP / overlap) ** 1.25  # depth ~ speed^(4/5)
        yield (
            key,
            f"{said} presses {how.format(show(overlap))}, too deep for the flow's contact law; {must} below "
            f"{show(most)} m/s with these materials",
        )
    steps = steps_per_contact(media, nozzles, material, accuracy.flow_dt_over_P)
    if steps < MIN_STEPS_PER_CONTACT:
        most = nozzle.speed_m_s * (steps / MIN_STEPS_PER_CONTACT) ** 5  # contact time ~ speed^(-1/5)
        yield (
            key,
            f"{said} makes the shortest contact {steps:.1f} time steps long at preset "
            f'"{accuracy.preset}", fewer than {show(MIN_STEPS_PER_CONTACT)}; {must} up to {show(most)} m/s, or '
            "--accuracy reference",
        )


def _largest_rebound(restitution: Restitution | None) -> float:
    e = restitution.shot_target if restitution else DIMPLE_REBOUND
    e = DIMPLE_REBOUND if isinstance(e, str) else e
    return max(e, restitution.hardening.saturated) if restitution and restitution.hardening else e
