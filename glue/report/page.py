"""``report.html``: one self-contained page (figures embedded, no script, no network) about one run."""

from __future__ import annotations

import base64
import json
from html import escape
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.report.figures import DPI
from glue.scene import sizes
from glue.scene.model import Scene
from glue.study.rows import ROWS, interval, shown
from glue.study.summary import choices_made

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: #1d1d1d; background: #fff;
       max-width: 1080px; margin: 2.5rem auto 4rem; padding: 0 1.25rem; }
h1 { font-size: 1.7rem; margin: 0; } h2 { font-size: 1.2rem; margin: 2.4rem 0 .7rem; }
h3 { font-size: 1rem; margin: 0 0 .4rem; }
p.lead { color: #555; margin: .2rem 0 0; }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(310px, 1fr)); gap: 1.6rem 2.2rem; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
td, th { padding: .28rem .5rem .28rem 0; border-bottom: 1px solid #e4e4e4; text-align: left;
         vertical-align: top; }
table.narrow { max-width: 620px; }
th { color: #555; font-weight: 600; }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; padding-right: 0; }
td.missing { color: #8a4b00; white-space: normal; text-align: right; padding-right: 0; }
figure { margin: 0 0 2.2rem; } img { max-width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .93rem; margin-top: .4rem; }
ul { padding-left: 1.1rem; margin: .3rem 0; font-size: .93rem; }
"""


def write_report(run: Path, scene: Scene, complete: frozenset[str]) -> list[str]:
    """Draw the figures of the run directory ``run`` and its ``report.html``; names of the files written.

    ``complete``: the stages whose files may be read.  Raises InputError for a damaged file.
    """
    from glue.report.draw import draw_figures  # here: loads numba and the target's models

    metrics = json.loads((run / "metrics.json").read_text(encoding="utf-8"))
    manifest = json.loads((run / "manifest.json").read_text(encoding="utf-8"))
    drawn = draw_figures(run, scene, complete, metrics)
    images = [(figure.title, figure.caption, figure.path.read_bytes()) for figure in drawn]
    write_text_atomic(run / "report.html", page(scene_rows(scene), manifest, metrics, images))
    return [*(figure.path.relative_to(run).as_posix() for figure in drawn), "report.html"]


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


def page(
    scene: list[tuple[str, str]], manifest: dict, metrics: dict, images: list[tuple[str, str, bytes]]
) -> str:
    """The HTML text.  images: (title, caption, PNG bytes); manifest and metrics as in the run directory."""
    name, seed = escape(str(manifest.get("scene", ""))), escape(str(manifest.get("seed", "")))
    rows = "".join(
        f"<tr><td>{escape(what)}</td><td class=number>{escape(value)}</td></tr>" for what, value in scene
    )
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{STYLE}</style></head><body>\n"
        f"<h1>{name}</h1>"
        f"<p class=lead>Shot peening from the nozzle to the residual stress · seed {seed}</p>\n"
        f"<h2>Result</h2><div class=cards>{_results(metrics)}</div>\n"
        f"<h2>Figures</h2>{''.join(_figure(*image) for image in images)}\n"
        f"<h2>Scene</h2><table class=narrow>{rows}</table>\n"
        f"{_choices(manifest, metrics)}{_costs(manifest)}</body></html>\n"
    )


def _results(metrics: dict) -> str:
    cards = []
    for section, (title, rows) in ROWS.items():
        values = metrics.get(section)
        if values:
            body = "".join(_row(metrics, section, *row) for row in rows if row[0] in values)
            cards.append(f"<div><h3>{title}</h3><table>{body}</table></div>")
    return "".join(cards) or "<p>No stage has finished.</p>"


def _row(metrics: dict, section: str, key: str, label: str, factor: float | None, unit: str, digits: int) -> str:
    values = metrics[section]
    text = escape(shown(values, key, factor, unit, digits) + interval(metrics, section, key, factor, unit, digits))
    kind = "number" if values[key] is not None else "missing"
    if factor is not None and values[key] is not None:
        text = text.replace("-", "−")
    return f"<tr><td>{label}</td><td class={kind}>{text}</td></tr>"


def _figure(title: str, caption: str, png: bytes) -> str:
    data = base64.b64encode(png).decode("ascii")
    # as wide as it was drawn, so that all figures have one size of print; the header holds the pixels
    width = round(int.from_bytes(png[16:20], "big") * 96 / DPI)
    image = f'<img alt="{escape(title)}" width={width} src="data:image/png;base64,{data}">'
    return f"<figure><h3>{escape(title)}</h3>{image}<figcaption>{escape(caption)}</figcaption></figure>"


def _choices(manifest: dict, metrics: dict) -> str:
    chosen = choices_made(manifest, metrics).items()
    rows = [(stage, choice["model"], choice["why"]) for stage, choice in chosen]
    defaults = "".join(f"<li>{escape(line)}</li>" for line in manifest.get("defaults_used", []))
    text = _table("Models and why", ("stage", "model", "why"), rows)
    return text + (f"<h2>Defaults that the scene leaves alone</h2><ul>{defaults}</ul>\n" if defaults else "")


def _costs(manifest: dict) -> str:
    rows = [
        (name, record["state"], f"{record['wall_s']:.1f} s", f"{record['peak_memory_bytes'] / 1e6:.0f} MB")
        for name, record in manifest.get("stages", {}).items()
        if "wall_s" in record
    ]
    return _table("Cost", ("stage", "state", "wall time", "peak memory"), rows)


def _table(title: str, heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A titled table, or nothing when it has no rows."""
    if not rows:
        return ""
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>" for row in rows)
    return f"<h2>{title}</h2><table><tr>{head}</tr>{body}</table>\n"
