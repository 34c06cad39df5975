"""From a rung to a run: the scene that it means, where it runs, what it found and cost."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Sequence
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


def jobs_of(scene_file: Path, groups: tuple[Group, ...], out: Path, short: bool = False) -> list[Job]:
    """All runs of the scene's ladder; ``short``: those of a set's later scenes, without what is dear.

    Raises InputError for a scene, or a rung of it, that cannot be read.
    """
    content = scene_file.read_bytes()
    scene = read_scene(scene_file, content=content)
    hits = mean_hits_estimate(scene)
    found = []
    for group in groups:
        share = 1.0 if group.hits is None or hits <= 0.0 else min(1.0, group.hits / hits)
        for rung in (None, *(r for r in group.rungs if not (short and r.dear))):
            for k in range(_seeds(group, rung, short)):
                found.append(_job(scene_file, content, group, rung, scene.seed + k, share, out))
    return found


def _seeds(group: Group, rung: Rung | None, short: bool) -> int:
    if short and group.short_seeds is not None:
        return group.short_seeds
    if rung is None:
        return group.reference_seeds or group.seeds
    return rung.seeds or group.seeds


def _job(scene_file, content, group, rung, seed, share, out) -> Job:
    own = dict(group.reference if rung is None else rung.changes)
    seed += own.pop("seed_offset", 0)
    window = own.pop("window_scale", 1.0)
    changes = {"accuracy": {}, "models": {}} | group.base | own | {"seed": seed} | shorter(content, share)
    if window != 1.0:
        changes["target.window_m"] = [window * side for side in tomllib.loads(content.decode("utf-8-sig"))["target"]["window_m"]]
    derived = changed(content, changes)
    inputs = digest(resolved_dict(read_scene(scene_file, content=derived)))
    what = REFERENCE if rung is None else f"{rung.factor}-{rung.level}"
    folder = f"{group.name}-{re.sub(r'[^A-Za-z0-9.]+', '-', what)}-s{seed}-{inputs[:8]}"
    return Job(scene_file, group, rung, seed, derived, out / scene_file.stem / folder)


def shorter(content: bytes, share: float) -> dict:
    """Changes that bring ``share`` of the impacts: a shorter exposure, or where a nozzle travels less mass."""
    if share >= 1.0:
        return {}
    data = tomllib.loads(content.decode("utf-8-sig"))
    nozzles = data["nozzle"] if isinstance(data["nozzle"], list) else [data["nozzle"]]
    if any("feed_speed_m_s" in n and n["feed_speed_m_s"] > 0 for n in nozzles):
        flows = [{**n, "mass_flow_kg_s": share * n["mass_flow_kg_s"]} for n in nozzles]
        return {"nozzle": flows if len(flows) > 1 else flows[0]}
    return {"exposure_time_s": share * data["exposure_time_s"]}


def run_jobs(jobs: Sequence[Job], tell: Callable[[int, dict, float], None]) -> None:
    """Run the jobs one after the other in a process of their own; ``tell(index, what it measured, seconds)`` of each.

    Those that are done are only read.  What a job measured: see ``reading``.  A rung that a solver cannot do is a result, not
    an end; Ctrl-C goes through.
    """
    todo = []
    for k, job in enumerate(jobs):
        stopping.check()
        if pipeline.is_done(job.folder, job.group.own):
            tell(k, reading(job.folder), 0.0)
        else:
            write_text_atomic(_beside(job, ".toml"), job.content.decode())
            todo.append(k)
    if not todo:
        return
    told = set()

    def on_line(line: str) -> None:
        stopping.check()
        word, _, rest = line.partition(" ")
        if word in ("done", "failed"):
            number, _, rest = rest.partition(" ")
            k = todo[int(number)]
            told.add(k)
            if word == "done":
                tell(k, reading(jobs[k].folder), float(rest))
            else:
                tell(k, failure(json.loads(rest)), 0.0)

    orders, log = _beside(jobs[todo[0]], ".jobs.json"), _beside(jobs[todo[0]], ".log")
    write_text_atomic(orders, json.dumps([_order(jobs[k]) for k in todo]))
    run_module("glue.study.tradeoff.child", [orders], log=log, on_line=on_line)
    stopping.check()
    for k in todo:
        if k not in told:
            tell(k, failure(f"the run ended without a word; log {log}"), 0.0)


def failure(cause: str) -> dict:
    """What a job measured that failed."""
    nothing = {key: {} for key in ("values", "scales", "wall_s", "cpu_s", "memory_bytes", "work")}
    return nothing | {"failed": cause.split("\n  log:")[0][:300]}


def _beside(job: Job, suffix: str) -> Path:
    return job.folder.with_name(job.folder.name + suffix)


def _order(job: Job) -> list:
    return [str(job.scene_file), str(_beside(job, ".toml")), str(job.folder), list(job.group.own)]


def reading(path: Path) -> dict:
    """What a finished run directory tells.

    {"values", "scales": by quantity; "wall_s", "cpu_s", "memory_bytes": by stage; "work": impacts of flow, target, window;
    "failed": None or why}.
    """
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
