"""Where a run's numbers come from, as HTML: models and physics with their reasons, cost, files, versions and hashes."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from glue.report.exports import FOLDER, KINDS
from glue.report.markup import Cell, bullets, number, table
from glue.study.rundir import STAGE_ORDER
from glue.study.summary import choices_made

def models(manifest: dict, metrics: dict) -> str:
    """Which model ran at each stage, and what decided it."""
    chosen = choices_made(manifest, metrics).items()
    rows = [
        (Cell(stage, kind="short"), Cell(choice["model"], kind="short"), Cell(choice["why"], kind="why"))
        for stage, choice in chosen
    ]
    return table(("stage", "model", "why"), rows, label="Models", titled=True)


def physics(pieces: Iterable) -> str:
    """Every optional piece of physics (``glue.study.pieces.Piece``): its number, threshold and decision."""
    rows = [
        (
            Cell(p.piece, kind="short"), Cell(p.decision + (" (!)" if p.misfit else ""), kind="short"), _dimensionless(p.number),
            _dimensionless(p.threshold), Cell(p.means, kind="long"), Cell(p.why, kind="long"), Cell(p.source, kind="long"),
        )
        for p in pieces
    ]  # fmt: skip
    heads = ("physics", "is", "number", "threshold", "the number is", "decided by", "threshold from")
    note = (
        "A piece matters when its number is above its threshold, at which leaving it out changes its metric by the tolerance"
        " named last; (!) marks one that is left out although it matters."
    )
    return table(heads, rows, label="Optional physics, all of it", titled=True, note=note)


def _dimensionless(value: float | None) -> Cell:
    return Cell("–", "", "number") if value is None else number(f"{value:.2g}", value)


def costs(manifest: dict) -> str:
    """Wall time with a bar, processor time and peak memory of each stage."""
    records = [(name, record) for name, record in _in_order(manifest) if "wall_s" in record]
    longest = max((record["wall_s"] for _, record in records), default=0.0) or 1.0
    rows = [
        (
            name if record["state"] == "complete" else f"{name} ({record['state']})",
            Cell(f"{record['wall_s']:.1f} s", f"{record['wall_s']:.6g}", "number"),
            Cell("", bar=record["wall_s"] / longest),
            Cell(_seconds(record.get("cpu_s")), kind="number"),
            Cell(f"{record['peak_memory_bytes'] / 1e6:.0f} MB", kind="number"),
        )
        for name, record in records
    ]
    total = sum(record["wall_s"] for _, record in records)
    note = f"{total:.1f} s in all; a stage that was up to date keeps the cost of when it ran."
    heads = ("stage", "wall time", "", "processor time", "peak memory")
    return table(heads, rows, label="Cost per stage", note=note)


def _seconds(value: float | None) -> str:
    return "" if value is None else f"{value:.1f} s"


def files(manifest: dict, run: str) -> str:
    """The run's own files, and the command for those that other codes read."""
    written = [(name, sha) for _, record in _in_order(manifest) for name, sha in sorted(record.get("outputs", {}).items())]
    rows = [(Cell(name, kind="short"), Cell(sha, kind="hash")) for name, sha in written if not name.startswith("figures/")]
    options = {"inp": " --mesh part.inp"}
    exports = [
        (Cell(f"peen export {run} --what {kind}{options.get(kind, '')}", kind="short"), Cell(told, kind="long"))
        for kind, (_, told) in KINDS.items()
    ]
    return (
        table((f"command, into {FOLDER}/", "writes"), exports, label="Files for other codes", titled=True)
        + table(("file of the run", "sha256"), rows, label="Files of the run", titled=True)
    )  # fmt: skip


def provenance(manifest: dict) -> str:
    """Command, seed, date, hashes of the inputs, and the versions of every code that took part."""
    if "inputs_sha256" not in manifest:
        return ""
    preset = manifest.get("preset_argument")
    stages = _in_order(manifest)
    dates = [record["date"] for _, record in stages if "date" in record]
    rows = [
        ("command", f"peen run scene.toml{f' --accuracy {preset}' if preset else ''}"),
        ("seed", str(manifest["seed"])),
        ("computed", "unknown" if not dates else min(dates) if min(dates) == max(dates) else f"{min(dates)} to {max(dates)}"),
        ("sha256 of scene.toml", manifest["scene_sha256"]),
        ("sha256 of the inputs in SI units", manifest["inputs_sha256"]),
        *_versions(stages),
    ]
    cells = [(Cell(what, kind="short"), Cell(value, kind="long")) for what, value in rows]
    return table(("what", "value"), cells, label="Provenance")


def _versions(stages) -> list[tuple[str, str]]:
    """Versions by code; where stages ran with different ones, all of them with the stages."""
    by_code: dict[str, dict[str, list[str]]] = {}
    for name, record in stages:
        for code, version in record.get("versions", {}).items():
            text = ", ".join(f"{k} {v}" for k, v in version.items()) if isinstance(version, dict) else str(version)
            by_code.setdefault(code, {}).setdefault(text, []).append(name)
    return [
        (code, "; ".join(text if len(found) == 1 else f"{text} ({', '.join(names)})" for text, names in found.items()))
        for code, found in by_code.items()
    ]


def _in_order(manifest: dict) -> list[tuple[str, dict]]:
    records = manifest.get("stages", {})
    return [(name, records[name]) for name in (*STAGE_ORDER, *(n for n in records if n not in STAGE_ORDER)) if name in records]


def words(title: str, lines: Iterable[str]) -> str:
    """A folded list under its title; "" without lines."""
    found = bullets(lines)
    return f"<details><summary>{escape(title)}</summary>{found}</details>\n" if found else ""
