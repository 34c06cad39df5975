"""What the flow benchmark runs: its scenes as files, and each flow model on the same arrivals."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue import solvers
from glue.flow import surface
from glue.flow.arrivals import draw_arrivals, scene_hash, write_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.dem import run_dem
from glue.flow.event_driven import run_event
from glue.flow.restitution import RestitutionLaw
from glue.scene.reader import read_scene

LAW = RestitutionLaw(0.6)
# 1 mm steel, 60 m/s, 20 mm jet, 100 mm stand-off: the reference scene of all flow numbers of this project.
SCENE = """
schema = 1
name = "bench-flow"
seed = {seed}
exposure_time_s = {exposure_s!r}
[shots]
grade = "S390"
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = {flow_kg_s!r}
jet_diameter_m = 0.020
stand_off_m = 0.1
impact_angle_deg = {angle_deg!r}
divergence_half_angle_deg = {half_angle_deg!r}
[target]
material = "al2024-t351"
window_m = [0.004, 0.004]
[restitution]
shot_target = 0.6
"""
# Glass beads straight down through still air, slowed from 80 m/s or falling until they fall no faster.
AIR_SCENE = """
schema = 1
name = "bench-air"
seed = 1
exposure_time_s = {exposure_s!r}
[shots]
diameter_m = {diameter_m!r}
density_kg_m3 = 2500.0
E_Pa = 70e9
nu = 0.22
[nozzle]
speed_m_s = {speed_m_s!r}
mass_flow_kg_s = 1e-6
jet_diameter_m = 0.020
stand_off_m = {stand_off_m!r}
impact_angle_deg = 90.0
[air_drag]
gas_density_kg_m3 = 1.204
gas_viscosity_Pa_s = 1.81e-5
[target]
material = "al2024-t351"
window_m = [0.0003, 0.0003]
[restitution]
shot_target = 0.6
"""
AIR_CASES = {
    "at the target": {"diameter_m": 1e-4, "speed_m_s": 80.0, "exposure_s": 0.05, "stand_off_m": 0.15},
    "terminal": {"diameter_m": 5e-5, "speed_m_s": 1.0, "exposure_s": 0.005, "stand_off_m": 0.1},
}


class Stream(NamedTuple):
    """Numbers of one flow, and the shots behind them: those of several runs pool."""

    collided: int  # first impacts that came after a collision
    first: int
    energy: float  # sum over all impacts of (v_n / nozzle speed)^2
    impacts: int

    @property
    def collided_share(self) -> float:
        return self.collided / self.first

    @property
    def energy_share(self) -> float:
        return self.energy / self.impacts


def pooled(streams: list[Stream]) -> Stream:
    return Stream(*(sum(column) for column in zip(*streams)))


def scene_file(
    folder: Path,
    *,
    kg_min: float,
    exposure_s: float,
    seed: int,
    angle_deg: float = 90.0,
    half_angle_deg: float = 0.0,
) -> Path:
    """Write the reference scene with these changes into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "scene.toml"
    path.write_text(
        SCENE.format(
            seed=seed,
            exposure_s=float(exposure_s),
            flow_kg_s=kg_min / 60.0,
            angle_deg=float(angle_deg),
            half_angle_deg=float(half_angle_deg),
        )
    )
    return path


def stream_of(impacts: np.ndarray, speed_m_s: float = 60.0) -> Stream:
    """Of an impact log in order of time."""
    first = np.unique(impacts["shot_id"], return_index=True)[1]
    collided = int((impacts["collisions_before"][first] > 0).sum())
    return Stream(collided, len(first), float((impacts["vz_in_m_s"] ** 2).sum()) / speed_m_s**2, len(impacts))


def air_file(folder: Path, case: str) -> Path:
    """Write the scene of ``AIR_CASES`` into ``folder``; gravity where the speed is to be terminal."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "scene.toml"
    text = AIR_SCENE.format(**AIR_CASES[case])
    path.write_text(text + ("[gravity]\n" if case == "terminal" else ""))
    return path


def ballistic(path: Path) -> tuple[np.ndarray, dict, float]:
    """The same arrivals, none meeting another."""
    scene = read_scene(path)
    impacts, info = run_ballistic(scene, draw_arrivals(scene), LAW, surface.from_scene(scene))
    return impacts, info, scene.exposure_time_s


def event(path: Path) -> tuple[np.ndarray, dict, float]:
    """The event-driven flow of a scene file: impacts, info, peening seconds."""
    scene = read_scene(path)
    impacts, info = run_event(scene, draw_arrivals(scene), LAW, surface.from_scene(scene))
    return impacts, info, scene.exposure_time_s


def dem(path: Path) -> tuple[np.ndarray, dict, float]:
    """The same arrivals in YADE, contact-aware stepping at 1 P."""
    scene, out = read_scene(path), path.parent
    write_arrivals(out / "arrivals.csv", draw_arrivals(scene), scene_hash(scene))
    impacts, info = run_dem(scene, path, out, law=LAW, arrivals_path=out / "arrivals.csv")
    return impacts, info, scene.exposure_time_s


def stepping(folder: Path, seeds: str) -> list[dict]:
    """Contact-aware against plain stepping, seed by seed: the numbers of yade_scripts/checks/stepping.py."""
    folder.mkdir(parents=True, exist_ok=True)
    out = folder / "stepping.json"
    script = solvers.repo_root() / "yade_scripts" / "checks" / "stepping.py"
    try:
        solvers.run_yade(
            script,
            ["--seeds", seeds, "--runs", str(out)],
            cwd=folder,
            log=folder / "stepping.log",
            outputs=(out,),
        )
    except Exception:
        if not out.exists():  # a row of its own that failed is judged here again
            raise
    return json.loads(out.read_text())


def contact_step_s(scene) -> float:
    """One P-wave step of the (only) shot size: the time step in contact of both codes."""
    shots = scene.shots
    return 0.5 * shots.diameter_m * math.sqrt(shots.density_kg_m3 / shots.E_Pa)
