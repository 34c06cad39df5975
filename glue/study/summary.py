"""A run on one page of text, from its manifest.json and metrics.json alone."""

from __future__ import annotations

import json
from pathlib import Path

from glue.study.manifest import read_manifest
from glue.study.rows import ROWS, interval, shown
from glue.study.rundir import METRICS, STAGE_ORDER


def summary(path: Path) -> str:
    """The summary of the run directory ``path``. Raises InputError when it is none."""
    manifest = read_manifest(path)
    metrics = json.loads((path / METRICS).read_text(encoding="utf-8"))
    lines = [f"{manifest['scene']} (seed {manifest['seed']}) in {path}"]
    if manifest.get("inferred"):
        lines += ["", "Inferred from the specification", *(f"  {line}" for line in manifest["inferred"])]
    for section, (title, rows) in ROWS.items():
        if section in metrics:
            lines += [
                "",
                title,
                *(_line(metrics, section, *row) for row in rows if row[0] in metrics[section]),
            ]
    chosen = choices_made(manifest, metrics)
    lines += ["", "Models", *(f"  {stage:<42}{c['model']}: {c['why']}" for stage, c in chosen.items())]
    lines += ["", "Cost", *_costs(manifest["stages"])]
    pictures = sorted((path / "figures").glob("*.png"))
    if pictures:
        lines += ["", "Figures", *(f"  {p}" for p in pictures)]
    if (path / "report.html").exists():
        lines += ["", f"Report: {path / 'report.html'}"]
    return "\n".join(lines)


def choices_made(manifest: dict, metrics: dict) -> dict:
    """The manifest's choices, with the flow model that really ran and its reason once it has."""
    flow, chosen = metrics.get("flow", {}), manifest.get("choices", {})
    if "why" not in flow:
        return chosen
    return chosen | {"flow": {"model": flow["model"], "why": flow["why"]}}


def _line(metrics: dict, section: str, key: str, label: str, factor: float | None, unit: str, digits: int) -> str:
    value = shown(metrics[section], key, factor, unit, digits)
    return f"  {label:<42}{value}{interval(metrics, section, key, factor, unit, digits)}"


def _costs(stages: dict) -> list[str]:
    lines = []
    for name in (n for n in STAGE_ORDER if "wall_s" in stages.get(n, {})):  # a damaged record has no cost
        record = stages[name]
        note = "" if record["state"] == "complete" else "   FAILED"
        lines.append(
            f"  {name:<42}{record['wall_s']:.1f} s, {record['peak_memory_bytes'] / 1e6:.0f} MB{note}"
        )
    return lines
