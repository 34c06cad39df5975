"""Checks between keys that are each fine alone, and the closed-form estimates that they need.

Every check yields ``(key path, sentence)`` for each problem it finds.  Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from glue.scene import sizes
from glue.scene.fields import show
from glue.scene.model import Accuracy, Material, Nozzle, Shots
from glue.scene.presets import CELL_DEPTH_IN_RADII
from glue.scene.schema import MAX_RASTER_POINTS, MAX_SHOTS, MAX_VOLUME_FRACTION

Problem = tuple[str, str]
MIN_STEPS_PER_CONTACT = 9.0  # shot on shot at dt = 1.0 P: 13.7 at 60 m/s, 12 at twice the speed
MAX_OVERLAP = 0.3  # of the radius; beyond, the flow's contact law means nothing


def estimated_dimple_radius_m(shots: Shots, normal_speed_m_s: float, material: Material) -> float:
    """Dimple radius [m] before any dimple has been computed, to about 5 % on 2024 between 20 and 100 m/s.

    Energy over flow stress: a = c d (rho v^2 / Y)^(1/4), Y the flow stress at 10 % plastic strain.
    c = 0.465 from one computed dimple: 0.227 mm, 1 mm shot, 7800 kg/m3, 60 m/s, 2024 (Y = 496 MPa).
    """
    yield_Pa = material.johnson_cook.flow_stress_Pa(0.1)
    return 0.465 * shots.diameter_m * (shots.density_kg_m3 * normal_speed_m_s**2 / yield_Pa) ** 0.25


def largest_diameter_m(shots: Shots) -> float:
    """Diameter [m] that shots do not exceed in practice: the mean plus three standard deviations."""
    return shots.diameter_m * (1.0 + (3.0 * shots.size_cv if shots.size == "distribution" else 0.0))


def volume_fraction(shots: Shots, nozzle: Nozzle) -> float:
    """Share of the jet's volume that is shot: mass flow over density x jet cross-section x speed."""
    section_m2 = math.pi / 4.0 * nozzle.jet_diameter_m**2
    return nozzle.mass_flow_kg_s / (shots.density_kg_m3 * section_m2 * nozzle.speed_m_s)


def jet_problems(shots: Shots, nozzle: Nozzle) -> Iterator[Problem]:
    """The jet against its own shots and against the target's surface."""
    diameter = largest_diameter_m(shots)
    if nozzle.jet_diameter_m < diameter:
        yield (
            "nozzle.jet_diameter_m",
            f"{show(nozzle.jet_diameter_m)} m is narrower than one shot; allowed from {show(diameter)} m up",
        )
        return
    fraction = volume_fraction(shots, nozzle)
    if fraction > MAX_VOLUME_FRACTION:
        most = nozzle.mass_flow_kg_s * MAX_VOLUME_FRACTION / fraction
        yield (
            "nozzle.mass_flow_kg_s",
            f"shots would fill {show(100.0 * fraction)} % of the jet's volume, more than a stream of "
            f"separate shots can; allowed up to {show(most)} kg/s with this jet_diameter_m and speed_m_s",
        )
    angle = math.radians(nozzle.impact_angle_deg)
    # The exit is a disc across the jet: its lowest edge, with a shot there, must be above the surface.
    reach = 0.5 * nozzle.jet_diameter_m * max(math.cos(angle), 0.0) + 0.5 * diameter
    if nozzle.stand_off_m * math.sin(angle) <= reach:
        yield (
            "nozzle.stand_off_m",
            f"{show(nozzle.stand_off_m)} m puts the edge of the nozzle's exit into the target at this angle; "
            f"allowed above {show(reach / math.sin(angle))} m",
        )


def steps_per_contact(shots: Shots, nozzle: Nozzle, material: Material, dt_over_P: float) -> float:
    """How many of the flow's time steps the shortest contact lasts: Hertz, the smallest shot, no damping.

    dt = dt_over_P times P = R sqrt(rho/E).  Two shots meet at most at twice the nozzle's speed; half the mass on
    half the radius is a sphere of R/2 and four times the density on a half-space.
    """
    radius = 0.5 * sizes.smallest_m(shots)
    p_wave_s = radius * math.sqrt(shots.density_kg_m3 / shots.E_Pa)
    on_target = _contact_time_s(radius, shots.density_kg_m3, nozzle.speed_m_s, shots, material)
    on_shot = _contact_time_s(0.5 * radius, 4.0 * shots.density_kg_m3, 2.0 * nozzle.speed_m_s, shots, shots)
    return min(on_target, on_shot) / (dt_over_P * p_wave_s)


def elastic_overlap(shots: Shots, nozzle: Nozzle, material: Material) -> float:
    """Depth of the shot's elastic impact on the target at full speed, as a share of its radius (Hertz)."""
    return _relative_depth(shots.density_kg_m3, nozzle.speed_m_s, shots, material)


def _relative_depth(density_kg_m3: float, speed_m_s: float, a: Shots | Material, b: Shots | Material) -> float:
    """Depth over radius, (5 pi rho v^2 / (4 E*))^(2/5): as ``glue.theory.hertz``, which needs numpy."""
    compliance = (1.0 - a.nu**2) / a.E_Pa + (1.0 - b.nu**2) / b.E_Pa  # 1/E*
    return (1.25 * math.pi * density_kg_m3 * speed_m_s**2 * compliance) ** 0.4


def _contact_time_s(radius_m, density_kg_m3, speed_m_s, a, b) -> float:
    """2.9432 depth / v, the factor 2 integral dx / sqrt(1 - x^2.5) over 0..1."""
    factor = 0.8 * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)
    return factor * radius_m * _relative_depth(density_kg_m3, speed_m_s, a, b) / speed_m_s


def contact_problems(
    shots: Shots, nozzle: Nozzle, material: Material, accuracy: Accuracy
) -> Iterator[Problem]:
    """The flow's contacts must be shallow, and long enough for the preset's time step."""
    speed = nozzle.speed_m_s
    overlap = elastic_overlap(shots, nozzle, material)
    if overlap >= MAX_OVERLAP:
        most = speed * (MAX_OVERLAP / overlap) ** 1.25  # depth ~ speed^(4/5)
        yield (
            "nozzle.speed_m_s",
            f"{show(speed)} m/s presses a shot {show(overlap)} of its radius into an elastic target, too deep for the "
            f"flow's contact law; allowed below {show(most)} m/s with these materials",
        )
    steps = steps_per_contact(shots, nozzle, material, accuracy.flow_dt_over_P)
    if steps < MIN_STEPS_PER_CONTACT:
        most = speed * (steps / MIN_STEPS_PER_CONTACT) ** 5  # contact time ~ speed^(-1/5)
        yield (
            "nozzle.speed_m_s",
            f"{show(speed)} m/s makes the shortest contact {steps:.1f} time steps long at preset "
            f'"{accuracy.preset}", fewer than {show(MIN_STEPS_PER_CONTACT)}; allowed up to {show(most)} m/s, or '
            "--accuracy reference",
        )


def window_problems(shots: Shots, nozzle: Nozzle, window_m: tuple[float, float]) -> Iterator[Problem]:
    """The window must be evenly peened: its corners, and the dimples that reach in, inside the footprint."""
    margin = 0.5 * shots.diameter_m  # no dimple is wider than its shot
    along, across = nozzle.footprint_semi_axes_m
    if math.hypot((0.5 * window_m[0] + margin) / along, (0.5 * window_m[1] + margin) / across) > 1.0:
        side = _largest_square_m(along, across, margin)
        advice = f"a square window up to {show(side)} m" if side > 0.0 else "no window, the jet is too narrow"
        yield (
            "target.window_m",
            f"{_size(window_m)} does not lie inside the jet's footprint (ellipse of "
            f"{_size((2.0 * along, 2.0 * across))}) with half a shot diameter to spare; allowed: {advice}",
        )


def _size(sides_m: tuple[float, float]) -> str:
    return f"{show(sides_m[0])} x {show(sides_m[1])} m"


def _largest_square_m(along: float, across: float, margin: float) -> float:
    """Side [m] of the largest square that, grown by ``margin`` all round, fits the ellipse (< 0: none)."""
    return 2.0 * (along * across / math.hypot(along, across) - margin)


def resolution_problems(
    shots: Shots, nozzle: Nozzle, material: Material, window_m: tuple[float, float], accuracy: Accuracy
) -> Iterator[Problem]:
    """The window against the dimple: wide enough to carry coverage, narrow enough for one raster."""
    radius = estimated_dimple_radius_m(shots, nozzle.normal_speed_m_s, material)
    least = 1.05 * accuracy.cell_side_in_radii * radius  # 5 %: the error of the estimate
    if min(window_m) < least:
        yield (
            "target.window_m",
            f"{show(min(window_m))} m is too narrow for dimples of about {show(radius)} m radius (estimate): "
            f"the target's cell wants {show(accuracy.cell_side_in_radii)} radii; allowed from {show(least)} m up",
        )
    spacing = radius / max(accuracy.coverage_points_per_radius, accuracy.stamp_points_per_radius)
    points = window_m[0] * window_m[1] / spacing**2
    if points > MAX_RASTER_POINTS:
        widest = spacing * math.sqrt(MAX_RASTER_POINTS)
        yield (
            "target.window_m",
            f"{_size(window_m)} needs a raster of {points:.1e} points for dimples of about {show(radius)} m "
            f"radius (estimate); allowed: a square window up to {show(widest)} m "
            f'at preset "{accuracy.preset}"',
        )


def thickness_problems(
    shots: Shots, nozzle: Nozzle, material: Material, thickness_m: float
) -> Iterator[Problem]:
    """The plate must be thicker than the peened layer, or its release is no longer that of plate theory."""
    radius = estimated_dimple_radius_m(shots, nozzle.normal_speed_m_s, material)
    least = 2.0 * CELL_DEPTH_IN_RADII * radius
    if thickness_m < least:
        yield (
            "target.thickness_m",
            f"{show(thickness_m)} m is thinner than twice the target's cell of {show(CELL_DEPTH_IN_RADII)} dimple radii "
            f"(about {show(radius)} m each, estimate); allowed from {show(least)} m up, or no thickness",
        )


def count_problems(shots: Shots, nozzle: Nozzle, exposure_time_s: float) -> Iterator[Problem]:
    """The expected number of shots must be one a run can mean something by, and finish."""
    rate = nozzle.mass_flow_kg_s / shots.mean_mass_kg
    count = rate * exposure_time_s
    allowed = f"allowed {show(1.0 / rate)}..{show(MAX_SHOTS / rate)} s with this mass flow and shot"
    if count < 1.0:
        yield "exposure_time_s", f"only {show(count)} shots are expected; {allowed}"
    elif count > MAX_SHOTS:
        yield "exposure_time_s", f"{count:.2g} shots are expected, more than a run holds; {allowed}"
