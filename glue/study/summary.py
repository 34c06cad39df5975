"""A run on one page of text, from its manifest.json and metrics.json alone."""

from __future__ import annotations

import json
from pathlib import Path

from glue.study.rundir import METRICS, STAGE_ORDER, read_manifest

# section: (key, label, factor to the printed unit, unit, digits)
_ROWS = {
    "dimple": ("One dimple", (
        ("radius_m", "radius at zero height", 1e6, "µm", 1),
        ("depth_m", "depth", 1e6, "µm", 1),
        ("restitution", "restitution", 1, "", 3),
        ("peak_force_N", "peak force", 1, "N", 0),
        ("contact_time_s", "contact time", 1e6, "µs", 2),
    )),
    "flow": ("Shot stream", (
        ("impacts", "impacts on the target", 1, "", 0),
        ("mean_normal_speed_m_s", "mean normal speed", 1, "m/s", 1),
        ("collided_fraction", "share that met another shot first", 1, "", 3),
        ("collision_number", "collision number", 1, "", 3),
    )),
    "coverage": ("Coverage", (
        ("impacts_in_window", "impacts in the window", 1, "", 0),
        ("final", "at the end", 1, "", 4),
        ("time_98_s", "time to 98 %", 1, "s", 2),
        ("avrami_final", "Avrami at the end", 1, "", 4),
        ("avrami_time_98_s", "Avrami's time to 98 %", 1, "s", 2),
        ("peeq_final", "by plastic strain, at the end", 1, "", 4),
    )),
    "residual_stress": ("Residual stress", (
        ("surface_Pa", "at the surface", 1e-6, "MPa", 0),
        ("max_compressive_Pa", "largest compressive", 1e-6, "MPa", 0),
        ("max_compressive_depth_m", "  at depth", 1e6, "µm", 0),
        ("tenth_depth_m", "down to a tenth of it at depth", 1e6, "µm", 0),
        ("compressive_depth_m", "changes sign at depth", 1e6, "µm", 0),
        ("force_balance_relative", "force balance, ∫σdz / ∫|σ|dz", 1, "", 3),
    )),
    "roughness": ("Roughness", (
        ("Sa_m", "Sa", 1e6, "µm", 2),
        ("Sq_m", "Sq", 1e6, "µm", 2),
        ("Sz_m", "Sz", 1e6, "µm", 1),
        ("Ssk", "Ssk", 1, "", 2),
        ("Sku", "Sku", 1, "", 2),
    )),
}  # fmt: skip


def summary(path: Path) -> str:
    """The summary of the run directory ``path``. Raises InputError when it is none."""
    manifest = read_manifest(path)
    metrics = json.loads((path / METRICS).read_text(encoding="utf-8"))
    lines = [f"{manifest['scene']} (seed {manifest['seed']}) in {path}"]
    for section, (title, rows) in _ROWS.items():
        if section in metrics:
            lines += [
                "",
                title,
                *(_line(metrics[section], *row) for row in rows if row[0] in metrics[section]),
            ]
    lines += [
        "",
        "Models",
        *(f"  {stage:<34}{c['model']}: {c['why']}" for stage, c in manifest["choices"].items()),
    ]
    lines += ["", "Cost", *_costs(manifest["stages"])]
    pictures = sorted((path / "figures").glob("*.png"))
    if pictures:
        lines += ["", "Figures", *(f"  {p}" for p in pictures)]
    if (path / "report.html").exists():
        lines += ["", f"Report: {path / 'report.html'}"]
    return "\n".join(lines)


def _line(values: dict, key: str, label: str, factor: float, unit: str, digits: int) -> str:
    value = values[key]
    if value is None:
        return f"  {label:<34}not determined: {values.get(key + '_reason', 'no reason given')}"
    return f"  {label:<34}{value * factor:.{digits}f} {unit}".rstrip()


def _costs(stages: dict) -> list[str]:
    lines = []
    for name in (n for n in STAGE_ORDER if n in stages):
        record = stages[name]
        note = "" if record["state"] == "complete" else "   FAILED"
        lines.append(
            f"  {name:<34}{record['wall_s']:.1f} s, {record['peak_memory_bytes'] / 1e6:.0f} MB{note}"
        )
    return lines
