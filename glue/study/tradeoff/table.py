"""The measured table: written by ``peen tradeoff``, kept with the package, read by ``check``, ``run`` and the error budget."""

from __future__ import annotations

import json
import math
import os
import platform
import shlex
import sys
import time
from functools import cache
from pathlib import Path

from glue import solvers
from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.scene.model import Scene
from glue.scene.reader import read_scene
from glue.study.check import mean_hits_estimate
from glue.study.reference import reference_impact
from glue.study.tradeoff.ladder import PATCH_SIDE_IN_RADII, PATCHES
from glue.theory.impact_scale import REPRESENTATIVE_STRAIN

SCHEMA = 1
MEASURED = Path(__file__).resolve().parent / "measured.json"


def features(scene: Scene) -> dict[str, float]:
    """What makes two scenes alike for the errors of their numerics: logarithms and shares, of order one."""
    nozzle, shots = reference_impact(scene)
    law = scene.target.material.single_law
    stress = law.flow_stress_Pa(REPRESENTATIVE_STRAIN)
    return {
        "impact": 0.5 * math.log(shots.density_kg_m3 * nozzle.normal_speed_m_s**2 / stress),
        "stiffness": 0.5 * math.log(scene.target.material.E_Pa / stress),
        "hits": 0.3 * math.log(max(mean_hits_estimate(scene), 1e-3)),  # relative errors hardly change with it
        "angle": 2.0 * math.sin(math.radians(nozzle.impact_angle_deg)),
        "sizes": math.log(scene.largest_diameter_m / scene.smallest_diameter_m),
    }


def provenance(commandline: list[str]) -> dict:
    """Where, when and with what a table is measured."""
    return {
        "date": time.strftime("%Y-%m-%d"), "command": shlex.join(commandline), "machine": _processor(),
        "cores": os.cpu_count(), "load_1_min": os.getloadavg()[0], "python": platform.python_version(),
        "versions": {name: v.get("package") if isinstance(v, dict) else v for name, v in solvers.versions().items()},
    }  # fmt: skip


def write_table(path: Path, scenes: dict[str, dict]) -> None:
    """``scenes``: {name: {"features", "scatter", …}} (see ``scene_entry``); a table that is there keeps its other scenes."""
    kept = read_table(path)["scenes"] if path.exists() else {}
    table = {"schema": SCHEMA, "provenance": provenance(["peen", *sys.argv[1:]]), "scenes": kept | scenes}
    write_text_atomic(path, json.dumps(table, indent=1, allow_nan=False) + "\n")


def read_table(path: Path = MEASURED) -> dict:
    """A table that ``write_table`` wrote.  Raises InputError when there is none, or of another schema."""
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as problem:
        raise InputError(f"{path}: no table of measured errors ({problem}); peen tradeoff makes one") from None
    if table.get("schema") != SCHEMA:
        raise InputError(f"{path}: schema {table.get('schema')!r}, this version reads {SCHEMA}; run peen tradeoff again")
    return table


@cache
def packaged() -> dict:
    """The table that comes with this version."""
    return read_table()


def nearest(scene: Scene, table: dict) -> tuple[str, float]:
    """(name, distance) of the measured scene that is most like ``scene``; distance 1 is a factor e in one number."""
    here = features(scene)

    def distance(name: str) -> float:
        there = table["scenes"][name]["features"]
        return math.dist(list(here.values()), [there[key] for key in here])

    return min(((name, distance(name)) for name in table["scenes"]), key=lambda pair: pair[1])


def scene_entry(scene_file: Path, rows: list[dict], scatter: dict, patches: dict[str, dict]) -> dict:
    """A scene's part of the table; ``patches``: {group: scatter} of patches at different exposures."""
    scene = read_scene(scene_file)
    return {
        "features": features(scene), "window_m": list(scene.target.window_m), "scatter": scatter,
        "patch_side_in_radii": PATCH_SIDE_IN_RADII,
        "patches": patches, "patch_hits": {g.name: g.hits for g in PATCHES if g.name in patches},
        "rows": rows,
    }  # fmt: skip


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())
