"""From a rung to a run: the scene that it means, where it runs, what it found and cost."""

from __future__ import annotations

import json
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

from glue import stopping
from glue.atomic import write_text_atomic
from glue.scene.derive import changed
from glue.scene.reader import read_scene, resolved_dict
from glue.solvers import run_module
from glue.study import pipeline
from glue.study.check import mean_hits_estimate
from glue.study.manifest import read_manifest
from glue.study.rundir import METRICS, digest
from glue.study.tradeoff.ladder import Group, Rung
from glue.study.tradeoff.quantities import scales, values

REFERENCE = "reference"


@dataclass(frozen=True)
class Job:
    """One run of a rung, or of its group's reference (``rung`` None), with one seed."""

    scene_file: Path
    group: Group
    rung: Rung | None
    seed: int
    content: bytes
    folder: Path

    @property
    def name(self) -> str:
        what = REFERENCE if self.rung is None else f"{self.rung.factor} {self.rung.level}"
        return f"{self.scene_file.stem}: {self.group.name}, {what}, seed {self.seed}"


def jobs_of(scene_file: Path, groups: tuple[Group, ...], out: Path) -> list[Job]:
    """All runs of the scene's ladder.  Raises InputError for a scene, or a rung of it, that cannot be read."""
    content = scene_file.read_bytes()
    scene = read_scene(scene_file, content=content)
    hits = mean_hits_estimate(scene)
    found = []
    for group in groups:
        share = 1.0 if group.hits is None or hits <= 0.0 else min(1.0, group.hits / hits)
        for rung in (None, *group.rungs):
            for k in range(_seeds(group, rung)):
                found.append(_job(scene_file, content, group, rung, scene.seed + k, share, out))
    return found


def _seeds(group: Group, rung: Rung | None) -> int:
    if rung is None:
        return group.reference_seeds or group.seeds
    return rung.seeds or group.seeds


def _job(scene_file, content, group, rung, seed, share, out) -> Job:
    own = dict(group.reference if rung is None else rung.changes)
    seed += own.pop("seed_offset", 0)
    window = own.pop("window_scale", 1.0)
    changes = {"accuracy": {}, "models": {}} | group.base | own | {"seed": seed} | _shorter(content, share)
    if window != 1.0:
        changes["target.window_m"] = [window * side for side in tomllib.loads(content.decode("utf-8-sig"))["target"]["window_m"]]
    derived = changed(content, changes)
    inputs = digest(resolved_dict(read_scene(scene_file, content=derived)))
    what = REFERENCE if rung is None else f"{rung.factor}-{rung.level}"
    folder = f"{group.name}-{re.sub(r'[^A-Za-z0-9.]+', '-', what)}-s{seed}-{inputs[:8]}"
    return Job(scene_file, group, rung, seed, derived, out / scene_file.stem / folder)


def _shorter(content: bytes, share: float) -> dict:
    """Changes that bring ``share`` of the impacts: a shorter exposure, or where a nozzle travels less mass."""
    if share >= 1.0:
        return {}
    data = tomllib.loads(content.decode("utf-8-sig"))
    nozzles = data["nozzle"] if isinstance(data["nozzle"], list) else [data["nozzle"]]
    if any("feed_speed_m_s" in n and n["feed_speed_m_s"] > 0 for n in nozzles):
        flows = [{**n, "mass_flow_kg_s": share * n["mass_flow_kg_s"]} for n in nozzles]
        return {"nozzle": flows if len(flows) > 1 else flows[0]}
    return {"exposure_time_s": share * data["exposure_time_s"]}


def run_job(job: Job) -> dict:
    """Run the job in a process of its own, or find it done; what it measured.

    {"values", "scales": by quantity; "wall_s", "cpu_s", "memory_bytes": by stage; "work": impacts of flow, target, window;
    "failed": None or why}.  A rung that a solver cannot do is a result, not an end; Ctrl-C goes through.
    """
    if not pipeline.is_done(job.folder, job.group.own):
        log, content = job.folder.with_name(f"{job.folder.name}.log"), job.folder.with_name(f"{job.folder.name}.toml")
        write_text_atomic(content, job.content.decode())
        done = run_module(
            "glue.study.tradeoff.child", [job.scene_file, content, job.folder, *job.group.own], log=log,
            on_line=lambda line: stopping.check(),
        )  # fmt: skip
        stopping.check()
        if done.exit_code != 0:
            nothing = {key: {} for key in ("values", "scales", "wall_s", "cpu_s", "memory_bytes", "work")}
            return nothing | {"failed": _cause(log)}
    return reading(job.folder)


def _cause(log: Path) -> str:
    """What the run said when it gave up."""
    text = log.read_text(encoding="utf-8", errors="replace")
    said = text.rpartition("peen: ")[2] if "peen: " in text else "stopped without a reason"
    return f"{said.split('  log:')[0].strip()[:300]} (log {log})"


def reading(path: Path) -> dict:
    """The same of a finished run directory."""
    stages = read_manifest(path)["stages"]
    metrics = json.loads((path / METRICS).read_text(encoding="utf-8"))
    cpu = {name: record["cpu_s"] for name, record in stages.items()}
    wall = {name: record["wall_s"] for name, record in stages.items()}
    solved = metrics.get("dimple", {}).get("wall_s", 0.0)  # what the impacts took when they were solved, cached since or not
    for cost in (cpu, wall):
        cost["dimple"] = max(cost.get("dimple", 0.0), solved)
    counts = {"flow": ("flow", "impacts"), "target": ("target", "impacts"), "window": ("coverage", "impacts_in_window")}
    return {
        "work": {name: metrics[s][key] for name, (s, key) in counts.items() if metrics.get(s, {}).get(key) is not None},
        "values": values(metrics), "scales": scales(metrics), "wall_s": wall, "cpu_s": cpu, "failed": None,
        "memory_bytes": {name: record["peak_memory_bytes"] for name, record in stages.items()},
    }  # fmt: skip
