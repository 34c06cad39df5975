"""Short shot streams for the tests that really run YADE: a scene file, and ``shot_flow.py`` on it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue import solvers
from glue.errors import SolverFailed
from glue.flow.arrivals import read_arrivals
from glue.flow.impacts import read_impacts

SCRIPTS = Path(__file__).parents[2] / "yade_scripts"
SCENE = """
schema = 1
name = "short"
seed = {seed}
exposure_time_s = {exposure}
{shots}
{nozzles}
[target]
material = "al2024-t351"
window_m = [0.004, 0.004]
{target}
{more}
"""
S390 = '[shots]\ngrade = "S390"\n'
NOZZLE = """
[nozzle]
speed_m_s = {speed}
mass_flow_kg_s = {flow}
jet_diameter_m = 0.020
stand_off_m = {stand_off}
impact_angle_deg = {angle}
{more}
"""


def nozzle(*, speed=60.0, flow=0.083333, stand_off=0.05, angle=90.0, more="", several=False) -> str:
    text = NOZZLE.format(speed=speed, flow=flow, stand_off=stand_off, angle=angle, more=more)
    return text.replace("[nozzle]", "[[nozzle]]") if several else text


def write_scene(
    folder, *, seed=3, exposure=0.006, shots=S390, nozzles=None, target="", more="", **jet
) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "scene.toml"
    text = SCENE.format(
        seed=seed,
        exposure=exposure,
        shots=shots,
        nozzles=nozzles or nozzle(**jet),
        target=target,
        more=more,
    )
    path.write_text(text)
    return path


class Run(NamedTuple):
    """What a run left: its failure or None, flow.json (None: not written), its output, its folder."""

    failed: SolverFailed | None
    report: dict | None
    log: str
    out: Path

    @property
    def impacts(self) -> np.ndarray:
        return read_impacts(self.out / "impacts.csv")[0]

    @property
    def arrivals(self) -> np.ndarray:
        return read_arrivals(self.out / "arrivals.csv")[0]


def shot_flow(folder, *args, scene=None, **changes) -> Run:
    """Run ``shot_flow.py`` on ``scene`` (or on one made of ``changes``) into ``folder``/out."""
    scene = scene or write_scene(folder, **changes)
    out, log = folder / "out", folder / "log.txt"
    failed = None
    try:
        solvers.run_yade(SCRIPTS / "shot_flow.py", [str(scene), str(out), *args], cwd=folder, log=log)
    except SolverFailed as e:
        failed = e
    report = out / "flow.json"
    there = out.is_dir() and report.exists()
    return Run(failed, json.loads(report.read_text()) if there else None, log.read_text(), out)
