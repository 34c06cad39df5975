"""Checks of the nozzles: each one's numbers against each other, and where the jets land against the window.

Standard library only.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

from glue.scene import reach, sizes
from glue.scene.effects import AirDrag
from glue.scene.fields import show
from glue.scene.model import Nozzle, Shots

Problem = tuple[str, str]
Media = tuple[Shots, ...]
Nozzles = tuple[Nozzle, ...]
FLATTEST_DEG = 2.0  # every shot of a diverging jet must come down at least so steeply
MAX_FEED_OVER_SPEED = 0.05  # shots leave a moving nozzle as one at rest


def named(nozzles: Nozzles) -> Iterator[tuple[str, Nozzle]]:
    """(key path, nozzle) for each."""
    for number, nozzle in enumerate(nozzles, start=1):
        yield ("nozzle" if len(nozzles) == 1 else f"nozzle[{number}]"), nozzle


def nozzle_problems(name: str, nozzle: Nozzle, exposure_time_s: float | None) -> Iterator[Problem]:
    """One nozzle's numbers against each other."""
    if nozzle.impact_angle_deg - nozzle.divergence_half_angle_deg < FLATTEST_DEG:
        yield (
            f"{name}.divergence_half_angle_deg",
            f"{show(nozzle.divergence_half_angle_deg)} deg sends the jet's upper edge off less than {show(FLATTEST_DEG)} "
            f"deg below level at this impact angle, so that shots pass over the target; allowed 0.."
            f"{show(nozzle.impact_angle_deg - FLATTEST_DEG)} deg",
        )
    if nozzle.feed and nozzle.feed.speed_m_s > MAX_FEED_OVER_SPEED * nozzle.speed_m_s:
        yield (
            f"{name}.feed_speed_m_s",
            f"{show(nozzle.feed.speed_m_s)} m/s is not slow against the shots: they leave as from a nozzle at rest; "
            f"allowed up to {show(MAX_FEED_OVER_SPEED * nozzle.speed_m_s)} m/s with this speed_m_s",
        )
    if nozzle.pulse and exposure_time_s and nozzle.pulse.frequency_Hz * exposure_time_s < 1.0 - 1e-9:
        yield (
            f"{name}.pulse_frequency_Hz",
            f"{show(nozzle.pulse.frequency_Hz)} Hz is less than one period in {show(exposure_time_s)} s, over which "
            f"mass_flow_kg_s is no mean; allowed from {show(1.0 / exposure_time_s)} Hz up",
        )


def gas_problems(nozzles: Nozzles, air: AirDrag | None) -> Iterator[Problem]:
    """Blowing gas has one direction everywhere, that of the first nozzle: others must share it."""
    if air is None or not air.gas_speed_m_s:
        return
    first = nozzles[0].direction
    if any(math.dist(first, nozzle.direction) > 1e-9 for nozzle in nozzles[1:]):
        yield (
            "air_drag.gas_speed_m_s",
            f"{show(air.gas_speed_m_s)} m/s blows along the first nozzle's axis everywhere, across the jets of the others; "
            "allowed 0 (still gas), or nozzles of one direction",
        )


def driven(nozzle: Nozzle, media: Media, air: AirDrag | None) -> Nozzle:
    """The nozzle with its speed raised to the most that a faster gas can drive any of its shots to on their way.

    v^2 <= v0^2 + 2 a H, a the Schiller-Naumann drag at the exit, where the gas is fastest against the shots.
    """
    if air is None or air.gas_speed_m_s <= nozzle.speed_m_s:
        return nozzle
    ahead, most = air.gas_speed_m_s - nozzle.speed_m_s, nozzle.speed_m_s
    for shots in media:
        d = sizes.smallest_m(shots)
        reynolds = air.gas_density_kg_m3 * ahead * d / air.gas_viscosity_Pa_s
        coefficient = max(24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687), 0.44)
        push = 0.75 * coefficient * air.gas_density_kg_m3 * ahead**2 / (shots.density_kg_m3 * d)
        most = max(most, math.sqrt(nozzle.speed_m_s**2 + 2.0 * push * nozzle.stand_off_m))
    return dataclasses.replace(nozzle, speed_m_s=min(most, air.gas_speed_m_s))


def window_problems(media: Media, nozzles: Nozzles, window_m: tuple[float, float]) -> Iterator[Problem]:
    """One jet must peen the window evenly, with the dimples that reach in, and none may miss it."""
    margin = 0.5 * max(sizes.largest_m(shots) for shots in media)  # no dimple is wider than its shot
    missed = False
    for name, nozzle in named(nozzles):
        if reach.misses(nozzle, window_m):
            missed = True
            x, y = reach.middle_m(nozzle)
            yield (
                f"{name}.aim_m",
                f"the jet's footprint, {size_text(_footprint_m(nozzle))} about ({show(x)}, {show(y)}), misses the window of "
                f"{size_text(window_m)} about (0, 0) altogether; allowed: an aim_m, or feed, that brings them together",
            )
        elif nozzle.feed:
            least = reach.needed_stroke_m(nozzle, window_m, margin)
            if nozzle.feed.stroke_m < least * (1.0 - 1e-9):
                yield (
                    f"{name}.stroke_m",
                    f"{show(nozzle.feed.stroke_m)} m does not carry the whole footprint over the window and off it, so "
                    f"that its ends get more than its middle; allowed from {show(least)} m up (stroke_m, or what "
                    "exposure_time_s and feed_speed_m_s make of it)",
                )
    if missed or any(reach.covers(nozzle, window_m, margin) for nozzle in nozzles):
        return
    side = max(reach.largest_square_m(nozzle, margin) for nozzle in nozzles)
    advice = f"a square window up to {show(side)} m" if side > 0.0 else "no window, the jet is too narrow"
    if len(nozzles) > 1:
        whose = "the (swept) footprint of any one nozzle"
    elif nozzles[0].feed:
        whose = "what the passes sweep, side by side without a gap,"
    else:
        whose = f"the jet's footprint (ellipse of {size_text(_footprint_m(nozzles[0]))})"
    yield (
        "target.window_m",
        f"{size_text(window_m)} does not lie inside {whose} with half a shot diameter to spare; allowed: {advice}",
    )


def _footprint_m(nozzle: Nozzle) -> tuple[float, float]:
    ellipse = reach.footprint(nozzle)
    return 2.0 * ellipse.along_m, 2.0 * ellipse.across_m


def size_text(sides_m: tuple[float, float]) -> str:
    return f"{show(sides_m[0])} x {show(sides_m[1])} m"
