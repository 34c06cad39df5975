"""Checks between keys that are each fine alone, and the closed-form estimates that they need.

Every check yields ``(key path, sentence)`` for each problem it finds.  Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from glue.scene.fields import show
from glue.scene.model import Accuracy, Material, Nozzle, Shots
from glue.scene.presets import CELL_DEPTH_IN_RADII
from glue.scene.schema import MAX_RASTER_POINTS, MAX_SHOTS, MAX_VOLUME_FRACTION

Problem = tuple[str, str]


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
