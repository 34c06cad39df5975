"""``report.html``: one self-contained page about one run: figures, script and style inside, nothing from the network."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.report import provenance, results
from glue.report.figures import DPI
from glue.report.markup import Cell, Section, document, figure, table
from glue.report.scene_rows import scene_rows
from glue.scene.model import Scene


def write_report(run: Path, scene: Scene, complete: frozenset[str]) -> list[str]:
    """Draw the figures of the run directory ``run`` and its ``report.html``; names of the files written.

    ``complete``: the stages whose files may be read.  Raises InputError for a damaged file.
    """
    from glue.report.draw import draw_figures, draw_slider  # here: they load numba and the target's models
    from glue.study.check import mean_hits_estimate
    from glue.study.flow_stage import restitution_estimate
    from glue.study.pieces import pieces

    metrics = json.loads((run / "metrics.json").read_text(encoding="utf-8"))
    manifest = json.loads((run / "manifest.json").read_text(encoding="utf-8"))
    drawn = draw_figures(run, scene, complete, metrics)
    images = [(f.title, f.caption, f.path.read_bytes()) for f in drawn]
    imported = metrics.get("flow", {}).get("model") == "imported"
    optional = pieces(scene, restitution_estimate(scene, run)[0], mean_hits_estimate(scene), imported)
    text = page(
        scene_rows(scene), manifest, metrics, images, slider=draw_slider(run, scene, complete), pieces=optional, run=run.name
    )
    write_text_atomic(run / "report.html", text)
    return [*(f.path.relative_to(run).as_posix() for f in drawn), "report.html"]


def page(
    scene: list[tuple[str, str]], manifest: dict, metrics: dict, images: list[tuple[str, str, bytes]], *, slider: str = "",
    pieces: Iterable = (), run: str = "RUN",
) -> str:  # fmt: skip
    """The HTML text.

    images: (title, caption, PNG bytes); manifest and metrics as in the run directory; slider: HTML of the impact map
    (``slider.impact_slider``); pieces: ``glue.study.pieces.Piece``; run: the run directory's name.
    """
    modelled = (
        table(("", ""), [(Cell(what, kind="short"), value) for what, value in scene], label="Scene")
        + provenance.words("Inferred from the specification", manifest.get("inferred", []))
        + provenance.words("Defaults that the scene leaves alone", manifest.get("defaults_used", []))
    )
    return document(
        str(manifest.get("scene", "")),
        f"Shot peening from the nozzle to the residual stress · seed {manifest.get('seed', '')}",
        [
            Section("result", "Result", results.tiles(metrics) + results.warnings(metrics)),
            Section("figures", "Figures", slider + "".join(figure(*image, DPI) for image in images)),
            Section("scene", "What was peened", modelled if scene else ""),
            Section("models", "What was modelled, and why", provenance.models(manifest, metrics) + provenance.physics(pieces)),
            Section("metrics", "All numbers and their uncertainty", results.all_metrics(metrics)),
            Section("cost", "Cost per stage", provenance.costs(manifest)),
            Section("files", "Files", provenance.files(manifest, run) if manifest.get("stages") else ""),
            Section("provenance", "Provenance", provenance.provenance(manifest)),
        ],
    )
