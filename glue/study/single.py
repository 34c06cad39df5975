"""One impact without a scene: ``peen dimple``."""

from __future__ import annotations

import tempfile
from pathlib import Path

from glue.errors import InputError
from glue.scene import catalogue, schema
from glue.scene.presets import DEFAULT_PRESET, PRESETS
from glue.study.stages import dimple_metrics, ready_kernels
from glue.target.dimple import solve_dimple


def single_dimple(
    material: str, speed_m_s: float, grade: str, diameter_m: float | None, preset: str | None, progress
) -> dict:
    """Solve a normal impact; the values are those of metrics.json's section ``dimple``.

    material, grade: keys of the catalogue; ``diameter_m`` replaces the grade's. Raises InputError for
    a value out of range, SolverFailed or NotConverged.
    """
    problems = []
    speed = schema.NOZZLE["speed_m_s"].problem(speed_m_s)  # what a scene allows
    if speed:
        problems.append(f"--speed: {speed}")
    if diameter_m is not None and not 1e-5 <= diameter_m <= 1e-2:
        problems.append(f"--diameter {diameter_m:g}: must lie in 1e-5..1e-2 m (metres, not millimetres)")
    if preset is not None and preset not in PRESETS:
        problems.append(f"--accuracy {preset}: allowed {', '.join(PRESETS)}")
    if problems:
        raise InputError(problems)
    shots, law = catalogue.shot(grade), catalogue.material(material)
    ready_kernels()
    with tempfile.TemporaryDirectory(prefix="peen-dimple-") as scratch:
        dimple = solve_dimple(
            law,
            speed_m_s=speed_m_s,
            density_kg_m3=shots.density_kg_m3,
            diameter_m=diameter_m or shots.diameter_m,
            elements_per_radius=PRESETS[preset or DEFAULT_PRESET].dimple_elements_per_radius,
            workdir=Path(scratch),
            progress=lambda fraction, text="": progress("dimple", fraction, text),
        )
    return dimple_metrics(dimple)
