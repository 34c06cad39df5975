"""Checks between keys that are each fine alone, and the closed-form estimates that they need.

Every check yields ``(key path, sentence)`` for each problem it finds, over all media and nozzles of the scene.
Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations_with_replacement

from glue.scene import sizes
from glue.scene.fields import show
from glue.scene.jet_checks import (
    Media,
    Nozzles,
    Problem,
    driven,
    named,
    gas_problems,
    nozzle_problems,
    size_text,
    window_problems,
)
from glue.scene.model import (
    Accuracy,
    AirDrag,
    Material,
    Nozzle,
    Restitution,
    Shots,
    Target,
)
from glue.scene.presets import PEENED_DEPTH_IN_RADII
from glue.scene.reach import inlet_clearance_problem
from glue.scene.schema import MAX_RASTER_POINTS, MAX_SHOTS, MAX_VOLUME_FRACTION
from glue.scene.softened import softened_parts

MIN_STEPS_PER_CONTACT = 9.0  # shot on shot at dt = 1.0 P: 13.7 at 60 m/s, 12 at twice the speed
MAX_OVERLAP = 0.3  # of the radius; beyond, the flow's contact law means nothing
GAUSSIAN_PEAK = 2.0 / -math.expm1(-2.0)  # middle over mean of a Gaussian of sd W/4 cut at W/2
DIMPLE_REBOUND = 0.5  # more than a dimple that presses a shot deep gives back


def problems(
    media, nozzles, target, restitution, air_drag, models, accuracy, exposure_time_s
) -> Iterator[Problem]:
    """All checks between the parts of a scene, as far as these could be read (None: could not)."""
    if not nozzles:
        return
    flows_in_yade = models is None or models.flow.model in ("auto", "dem")
    sound = True
    for name, nozzle in named(nozzles):
        found = [*nozzle_problems(name, nozzle, exposure_time_s), *(jet_problems(name, media, nozzle) if media else ())]
        sound &= not any(key.endswith(("divergence_half_angle_deg", "jet_diameter_m")) for key, _ in found)
        yield from found
    yield from gas_problems(nozzles, air_drag)
    if not media:
        return
    if exposure_time_s:
        yield from count_problems(media, nozzles, exposure_time_s)
    if not target:
        return
    if accuracy and flows_in_yade:
        yield from contact_problems(media, nozzles, target.material, accuracy, restitution, air_drag)
    if target.thickness_m:
        yield from thickness_problems(media, nozzles, target.material, target.thickness_m)
    if sound:
        yield from window_problems(media, nozzles, target.window_m)
    if accuracy:
        yield from resolution_problems(media, nozzles, target.material, target.window_m, accuracy)
    yield from surface_problems(media, target)


def estimated_dimple_radius_m(shots: Shots, normal_speed_m_s: float, material: Material) -> float:
    """Dimple radius [m] before any dimple has been computed, to about 5 % on 2024 between 20 and 100 m/s.

    Energy over flow stress: a = c d (rho v^2 / Y)^(1/4), Y the flow stress at 10 % plastic strain.
    c = 0.465 from one computed dimple: 0.227 mm, 1 mm shot, 7800 kg/m3, 60 m/s, 2024 (Y = 496 MPa).
    """
    yield_Pa = material.single_law.flow_stress_Pa(0.1)
    return 0.465 * shots.diameter_m * (shots.density_kg_m3 * normal_speed_m_s**2 / yield_Pa) ** 0.25


def dimple_radii_m(media: Media, nozzles: Nozzles, material: Material) -> tuple[float, float]:
    """(smallest, largest) estimate of the dimple radius [m] of a mean shot, over media and nozzles."""
    radii = [estimated_dimple_radius_m(s, n.normal_speed_m_s, material) for s in media for n in nozzles]
    return min(radii), max(radii)


def volume_fraction(shots: Shots, nozzle: Nozzle) -> float:
    """Mean share of the jet's volume at the exit if all of the nozzle's mass flow were these shots.

    Mass flow over density x exit area x speed.  A mixture fills the sum over its media, by their mass fractions.
    """
    section_m2 = math.pi / 4.0 * nozzle.jet_diameter_m**2
    return nozzle.mass_flow_kg_s / (shots.density_kg_m3 * section_m2 * nozzle.speed_m_s)


def mixture_volume_fraction(media: Media, nozzle: Nozzle) -> float:
    """Mean share of the jet's volume at the exit that is shot."""
    return sum(shots.mass_fraction * volume_fraction(shots, nozzle) for shots in media)


def jet_problems(name: str, media: Media, nozzle: Nozzle) -> Iterator[Problem]:
    """A jet against its own shots and against the target's surface."""
    diameter = max(sizes.largest_m(shots) for shots in media)
    if nozzle.jet_diameter_m < diameter:
        yield (
            f"{name}.jet_diameter_m",
            f"{show(nozzle.jet_diameter_m)} m is narrower than one shot; allowed from {show(diameter)} m up",
        )
        return
    peak = (nozzle.pulse.peak if nozzle.pulse else 1.0) * (GAUSSIAN_PEAK if nozzle.profile == "gaussian" else 1.0)
    fraction = peak * mixture_volume_fraction(media, nozzle)
    if fraction > MAX_VOLUME_FRACTION:
        most = nozzle.mass_flow_kg_s * MAX_VOLUME_FRACTION / fraction
        where = " where and when it is densest" if peak > 1.0 else ""
        yield (
            f"{name}.mass_flow_kg_s",
            f"shots would fill {show(100.0 * fraction)} % of the jet's volume{where}, more than a stream of "
            f"separate shots can; allowed up to {show(most)} kg/s with this jet_diameter_m and speed_m_s",
        )
    if problem := inlet_clearance_problem(nozzle, diameter):
        yield f"{name}.stand_off_m", problem


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


def resolution_problems(
    media: Media, nozzles: Nozzles, material: Material, window_m: tuple[float, float], accuracy: Accuracy
) -> Iterator[Problem]:
    """The window against the dimples: wide enough to carry coverage, narrow enough for one raster."""
    smallest, largest = dimple_radii_m(media, nozzles, material)
    least = 1.05 * accuracy.cell_side_in_radii * largest  # 5 %: the error of the estimate
    if min(window_m) < least:
        yield (
            "target.window_m",
            f"{show(min(window_m))} m is too narrow for dimples of about {show(largest)} m radius (estimate): "
            f"the target's cell wants {show(accuracy.cell_side_in_radii)} radii; allowed from {show(least)} m up",
        )
    spacing = smallest / max(accuracy.coverage_points_per_radius, accuracy.stamp_points_per_radius)
    points = window_m[0] * window_m[1] / spacing**2
    if points > MAX_RASTER_POINTS:
        widest = spacing * math.sqrt(MAX_RASTER_POINTS)
        yield (
            "target.window_m",
            f"{size_text(window_m)} needs a raster of {points:.1e} points for dimples of about {show(smallest)} m "
            f"radius (estimate); allowed: a square window up to {show(widest)} m "
            f'at preset "{accuracy.preset}"',
        )


def thickness_problems(
    media: Media, nozzles: Nozzles, material: Material, thickness_m: float
) -> Iterator[Problem]:
    """The plate must be thicker than the peened layer, or its release is no longer that of plate theory."""
    _, radius = dimple_radii_m(media, nozzles, material)
    least = PEENED_DEPTH_IN_RADII * radius
    if thickness_m < least:
        yield (
            "target.thickness_m",
            f"{show(thickness_m)} m is thinner than the peened layer of {show(PEENED_DEPTH_IN_RADII)} dimple radii "
            f"(about {show(radius)} m each, estimate); allowed from {show(least)} m up, or no thickness",
        )


def surface_problems(media: Media, target: Target) -> Iterator[Problem]:
    """A cylinder must be flat on the scale of a contact, and as wide as the window."""
    surface = target.surface
    if surface.kind != "cylinder":
        return
    shot_m = 2.5 * max(sizes.largest_m(shots) for shots in media)
    half_m = 0.5 * target.window_m["xy".index("y" if surface.axis == "x" else "x")]
    if surface.radius_m < max(shot_m, half_m):
        reason = (
            "is less than five times the largest shot's, whose contact law takes the target as flat"
            if surface.radius_m < shot_m
            else "is less than half the window's side across the axis"
        )
        yield (
            "target.surface.radius_m",
            f"{show(surface.radius_m)} m {reason}; allowed from {show(max(shot_m, half_m))} m up",
        )


def count_problems(media: Media, nozzles: Nozzles, exposure_time_s: float) -> Iterator[Problem]:
    """The expected number of shots must be one a run can mean something by, and finish."""
    per_kg = sum(shots.mass_fraction / shots.mean_mass_kg for shots in media)
    rate = per_kg * sum(nozzle.mass_flow_kg_s for nozzle in nozzles)
    count = rate * exposure_time_s
    allowed = f"allowed {show(1.0 / rate)}..{show(MAX_SHOTS / rate)} s with this mass flow and shot"
    if count < 1.0:
        yield "exposure_time_s", f"only {show(count)} shots are expected; {allowed}"
    elif count > MAX_SHOTS:
        yield "exposure_time_s", f"{count:.2g} shots are expected, more than a run holds; {allowed}"
