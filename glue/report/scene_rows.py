"""The scene as a table in a reader's units."""

from __future__ import annotations

from glue.scene import sizes
from glue.scene.model import Scene


def scene_rows(scene: Scene) -> list[tuple[str, str]]:
    """The scene in a reader's units: (what, value); a row for each medium and nozzle where there are several."""
    target = scene.target
    width, height = (1e3 * side for side in target.window_m)
    rows = [
        ("Target", target.material.name),
        ("Surface", _surface(target.surface)),
        ("Window", f"{width:g} × {height:g} mm"),
        ("Thickness", f"{1e3 * target.thickness_m:g} mm, free" if target.thickness_m else "too thick to stretch or bend"),
    ]  # fmt: skip
    for k, shots in enumerate(scene.media, 1):
        mark = f" {k}" if len(scene.media) > 1 else ""
        share = f", {100 * shots.mass_fraction:g} % by mass" if mark else ""
        rows += [
            (f"Shots{mark}", f"{shots.grade or 'own'}, {_size(shots)}{share}"),
            (f"Shot density{mark}", f"{shots.density_kg_m3:g} kg/m³"),
        ]
    for k, nozzle in enumerate(scene.nozzles, 1):
        rows += [(what + (f" {k}" if len(scene.nozzles) > 1 else ""), value) for what, value in _nozzle(nozzle)]
    if scene.air_drag is not None:
        gas = scene.air_drag
        rows.append(("Gas", f"{gas.gas_density_kg_m3:g} kg/m³, blowing at {gas.gas_speed_m_s:g} m/s"))
    return [
        *rows,
        ("Exposure", f"{scene.exposure_time_s:g} s, {scene.expected_shots:.0f} shots expected"),
        ("Accuracy", scene.accuracy.preset),
    ]


def _surface(surface) -> str:
    if surface.kind == "cylinder":
        return f"cylinder of {1e3 * surface.radius_m:g} mm radius along {surface.axis}"
    return f"triangles of {surface.file}" if surface.kind == "stl" else "plane"


def _size(shots) -> str:
    if shots.size == "distribution":
        return f"mean {1e3 * shots.diameter_m:.3g} mm, coefficient of variation {100 * shots.size_cv:g} %"
    if shots.size == "sieve":
        least, most = 1e3 * sizes.smallest_m(shots), 1e3 * sizes.largest_m(shots)
        return f"mean {1e3 * shots.diameter_m:.3g} mm, sieved {least:g} to {most:g} mm"
    return f"{1e3 * shots.diameter_m:g} mm"


def _nozzle(nozzle) -> list[tuple[str, str]]:
    """Rows of one nozzle: what every one has, then what only some do."""
    spread = f", coefficient of variation {100 * nozzle.speed_cv:g} %" if nozzle.speed_cv else ""
    opens = nozzle.divergence_half_angle_deg
    towards = f", towards {nozzle.azimuth_deg:g}° from x" if nozzle.azimuth_deg else ""
    rows = [
        ("Speed", f"{nozzle.speed_m_s:g} m/s{spread}"),
        ("Impact angle", f"{nozzle.impact_angle_deg:g}° from the surface{towards}"),
        ("Mass flow", f"{60 * nozzle.mass_flow_kg_s:.3g} kg/min"),
        ("Jet diameter", f"{1e3 * nozzle.jet_diameter_m:g} mm, {nozzle.profile}" + (f", opening by {opens:g}°" if opens else "")),
        ("Stand-off", f"{1e3 * nozzle.stand_off_m:g} mm"),
    ]  # fmt: skip
    if nozzle.feed is not None:
        feed = nozzle.feed
        passes = f"{feed.passes} pass{'es' if feed.passes > 1 else ''}"
        apart = f", {1e3 * feed.pitch_m:g} mm apart" if feed.passes > 1 else ""
        rows.append(("Feed", f"{1e3 * feed.speed_m_s:g} mm/s, {passes} of {1e3 * feed.stroke_m:g} mm{apart}"))
    if nozzle.pulse is not None:
        pulse = nozzle.pulse
        how = f"on for {100 * pulse.duty:g} %" if pulse.pattern == "pulsed" else f"± {100 * pulse.amplitude:g} %"
        rows.append(("Pulses", f"{pulse.pattern}, {pulse.frequency_Hz:g} Hz, {how}"))
    return rows
