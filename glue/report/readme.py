"""``make readme``: puts measured tables, a run's real output and figures into README.md, between its markers.

    python -m glue.report.readme RUN_FAST RUN_BALANCED RUN_REFERENCE --checks build/checks --bench build/bench

The text between ``<!-- begin NAME -->`` and ``<!-- end NAME -->`` is replaced; a marker without its data, or data
without its marker, is an error, so that no old number stays behind.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import sys
from pathlib import Path

from glue.errors import InputError, PeenError
from glue.report.tradeoff import markdown, presets_markdown
from glue.solvers import repo_root
from glue.study.manifest import read_manifest
from glue.study.rundir import METRICS, STAGE_ORDER
from glue.study.summary import summary
from glue.study.tradeoff.table import packaged

BENCHMARKS = (
    "flow", "dimple", "target", "intensity", "target-error", "sweep", "cluster", "studies", "design", "dilute", "trends",
)  # fmt: skip
LADDER_SCENE = "al2024-s390"
FIGURES = ("impact_map", "coverage", "residual_stress", "height_map", "dimple")

# (label, section, key, factor, digits) of the table of presets
_TRADE = (
    ("coverage at the end, %", "coverage", "final", 100, 2),
    ("time to 98 %, s", "coverage", "time_98_s", 1, 2),
    ("mean normal speed, m/s", "flow", "mean_normal_speed_m_s", 1, 1),
    ("dimple radius, µm", "dimple", "radius_m", 1e6, 1),
    ("dimple depth, µm", "dimple", "depth_m", 1e6, 1),
    ("restitution", "dimple", "restitution", 1, 3),
    ("surface stress, MPa", "residual_stress", "surface_Pa", 1e-6, 0),
    ("largest compressive, MPa", "residual_stress", "max_compressive_Pa", 1e-6, 0),
    ("turns to tension at, µm", "residual_stress", "compressive_depth_m", 1e6, 0),
    ("Sa, µm", "roughness", "Sa_m", 1e6, 1),
    ("Sz, µm", "roughness", "Sz_m", 1e6, 0),
)


def trade_table(runs: list[Path]) -> str:
    """Markdown: cost and results of the same scene and seed at each preset; a run a column."""
    manifests = [read_manifest(run) for run in runs]
    metrics = [json.loads((run / METRICS).read_text(encoding="utf-8")) for run in runs]
    names = [manifest["inputs"]["accuracy"]["preset"] for manifest in manifests]
    rows = [["", *names], ["---", *["---:"] * len(runs)]]
    for stage in STAGE_ORDER:
        if stage != "report":
            rows.append([f"{stage}, s", *(f"{manifest['stages'][stage]['wall_s']:.1f}" for manifest in manifests)])
    whole = [sum(record["wall_s"] for record in manifest["stages"].values()) for manifest in manifests]
    rows.append(["**whole run, s**", *(f"**{seconds:.0f}**" for seconds in whole)])
    memory = [max(record["peak_memory_bytes"] for record in m["stages"].values()) / 1e6 for m in manifests]
    rows.append(["peak memory, MB", *(f"{megabytes:.0f}" for megabytes in memory)])
    for label, section, key, factor, digits in _TRADE:
        values = [found[section][key] for found in metrics]
        rows.append([label, *("–" if v is None else f"{v * factor:.{digits}f}".replace("-", "−") for v in values)])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def verification_table(folder: Path) -> str:
    """Markdown: every row of the checks that ``make checks`` wrote as JSON into ``folder``."""
    lines = ["| check | measured | limit | |", "|---|---:|---|---|"]
    for path in sorted(folder.glob("*.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        passed = sum(row["passed"] for row in record["rows"])
        lines.append(f"| **{record['check']}** | **{passed}/{len(record['rows'])}** | | |")
        if path.stem == "freefem":
            lines += ["| " + " | ".join(_cells(row)) + " |" for row in record["rows"]]
    if len(lines) == 2:
        raise InputError(f"{folder}: no results of checks; run make checks")
    return "\n".join(lines)


def bench_table(file: Path) -> str:
    """Markdown: every row of one benchmark's JSON, misses included, with what was noted beside it."""
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f"{file}: no result of a benchmark; run make bench-{file.stem} (make studies, make check-cluster)") from None
    lines = ["| | measured | limit | | |", "|---|---:|---|---|---|"]
    lines += ["| " + " | ".join([*_cells(row), _escaped(row["note"])]) + " |" for row in record["rows"]]
    return "\n".join(lines)


def _cells(row: dict) -> list[str]:
    return [_escaped(row["name"]), f"{row['value']:.4g}", row["limit"], "pass" if row["passed"] else "**FAIL**"]


def _escaped(text: str) -> str:
    return text.replace("|", "\\|")


def replace_block(text: str, name: str, block: str) -> str:
    """``text`` with ``block`` between the markers of ``name``; raises InputError when they are missing."""
    pattern = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
    changed, count = pattern.subn(lambda m: m.group(1) + block + "\n" + m.group(2), text)
    if count != 1:
        raise InputError(f"README.md: {count} places marked {name}, one is needed")
    return changed


def write_readme(runs: list[Path], checks: Path, bench: Path) -> None:
    """Rewrite README.md and docs/ from three runs (fast, balanced, reference), the checks' and benchmarks' results."""
    root = repo_root()
    readme, balanced = root / "README.md", runs[1]
    shown = summary(balanced).replace(str(balanced), "runs/al2024-s390-…")
    text = readme.read_text(encoding="utf-8")
    text = replace_block(text, "output", f"```text\n{shown}\n```")
    text = replace_block(text, "trade", trade_table(runs))
    text = replace_block(text, "verification", verification_table(checks))
    measured = packaged()
    text = replace_block(text, "presets", presets_markdown(measured))
    text = replace_block(text, "ladder", markdown(measured, LADDER_SCENE))
    for name in BENCHMARKS:
        text = replace_block(text, f"bench {name}", bench_table(bench / f"{name}.json"))
    readme.write_text(text, encoding="utf-8")
    for name in FIGURES:
        shutil.copyfile(balanced / "figures" / f"{name}.png", root / "docs" / f"{name}.png")


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m glue.report.readme", description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs=3, type=Path, metavar="RUN", help="run directories: fast, balanced, reference")
    parser.add_argument("--checks", type=Path, default=Path("build/checks"), metavar="DIR")
    parser.add_argument("--bench", type=Path, default=Path("build/bench"), metavar="DIR")
    given = parser.parse_args(argv)
    try:
        write_readme(given.runs, given.checks, given.bench)
    except PeenError as problem:
        print(problem, file=sys.stderr)
        return problem.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
