"""A study's folder made by hand: mass flow by speed, two replicates each, one run refused and one failed."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

FLOWS, SPEEDS, REPLICATES = (0.005, 0.01, 0.02, 0.04), (40.0, 60.0, 80.0), 2


def write_study(folder: Path, name: str = "mass flow & speed") -> Path:
    """table.csv, costs.csv and study.json in ``folder``; coverage by Avrami, the second replicate 1 % above the first."""
    folder.mkdir(parents=True, exist_ok=True)
    rows, costs = [], []
    for flow in FLOWS:
        for speed in SPEEDS:
            for replicate in range(REPLICATES):
                run = f"{len(rows):04d}-abcdef01"
                row = {"run": run, "state": "done", "cause": "", "point": len(rows) // REPLICATES, "replicate": replicate}
                row |= {"seed": len(rows) + 1, "nozzle.mass_flow_kg_s": flow, "nozzle.speed_m_s": speed}
                if (flow, speed) == (0.04, 80.0):
                    state, cause = (("refused", "shot stream too dense: <20 %"), ("failed", "YADE ended with code 1"))[replicate]
                    rows.append(row | {"state": state, "cause": cause})
                    continue
                hits = 300.0 * flow * speed / 60.0
                rows.append(row | {
                    "coverage.final": (1.0 - math.exp(-hits)) * (1.0 + 0.01 * replicate), "coverage.final.u95": 0.01,
                    "coverage.time_98_s": 12.0 / hits, "residual_stress.max_compressive_Pa": -3e8 * (1.0 - math.exp(-0.5 * hits)),
                    "roughness.Sa_m": 2e-5 * speed / 60.0, "roughness.Sa_m.u95": 1e-6, "flow.model": "event"})  # fmt: skip
                times = {"flow.wall_s": 1.5, "flow.cpu_s": 1.2, "coverage.wall_s": 0.5, "coverage.cpu_s": 0.4}
                costs.append({"run": run, "state": "done"} | times)
    _write(folder / "table.csv", rows)
    _write(folder / "costs.csv", costs)
    axes = [
        {"name": "mass flow", "keys": ["nozzle.mass_flow_kg_s"], "unit": "kg/s", "values": list(FLOWS)},
        {"name": "speed", "keys": ["nozzle.speed_m_s"], "unit": "m/s", "values": list(SPEEDS)},
    ]
    study = {
        "schema": 1, "name": name, "file": "study.toml", "scene": "al2024-s390", "stages": ["coverage", "surface"],
        "accuracy": "fast", "set": {"models.flow": "event"}, "design": {"kind": "grid", "replicates": REPLICATES}, "axes": axes,
        "inputs_sha256": "0" * 64, "executor": "local", "versions": {"peen": "0.2.0", "yade": {"binary": "2023.02a"}},
        "begun": "2026-11-27T18:00:00Z",
    }  # fmt: skip
    (folder / "study.json").write_text(json.dumps(study))
    return folder


def _write(path: Path, rows: list[dict]) -> None:
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with open(path, "w", newline="", encoding="utf-8") as f:
        writer = csv.DictWriter(f, columns, restval="")
        writer.writeheader()
        writer.writerows(rows)
