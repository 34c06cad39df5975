"""Checks between keys that are each fine alone, and the closed-form estimates that they need.

Every check yields ``(key path, sentence)`` for each problem it finds, over all media and nozzles of the scene.
Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from glue.scene import sizes
from glue.scene.contact_checks import contact_problems
from glue.scene.fields import show
from glue.scene.jet_checks import (
    Media,
    Nozzles,
    Problem,
    gas_problems,
    named,
    nozzle_problems,
    size_text,
    window_problems,
)
from glue.scene.model import Material, Nozzle, Shots, Target
from glue.scene.presets import PEENED_DEPTH_IN_RADII, Accuracy
from glue.scene.reach import inlet_clearance_problem
from glue.scene.schema import MAX_RASTER_POINTS, MAX_SHOTS, MAX_VOLUME_FRACTION

GAUSSIAN_PEAK = 2.0 / -math.expm1(-2.0)  # middle over mean of a Gaussian of sd W/4 cut at W/2


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
