"""What a study would run and roughly cost, without running anything."""

from __future__ import annotations

from pathlib import Path

from glue.study.sweep.design import remarks
from glue.study.sweep.estimate import library_cost_s, stage_costs
from glue.study.sweep.library import count, libraries
from glue.study.sweep.run import prepare
from glue.target.speeds import cores


def dry_run(study_file: str | Path, out: Path | None, jobs: int | None, retry_failed: bool, first: int | None) -> dict:
    """{"out", "runs": [{"run", "state", "cause", axes…, "cost_s"}], "impacts", "jobs", "cost_s", "wall_s", "remarks"}."""
    from glue.study.pipeline import with_needs
    from glue.study.stages import STAGES

    prepared = prepare(study_file, out, retry_failed)
    names = [stage.name for stage in with_needs(prepared.study.stages, STAGES)]
    todo = {run.name: run for run in prepared.todo(first)}
    rows = []
    for run in prepared.runs:
        state = "done" if run.name in prepared.done else "refused" if run.cause else "to do" if run.name in todo else "waits"
        costs = stage_costs(run.scene) if state == "to do" else {}
        cost = sum(costs[name].seconds for name in names) if costs else 0.0
        rows.append({"run": run.name, "state": state, "cause": run.cause, "axes": run.axes, "seed": run.seed, "cost_s": cost})
    known = [(run.name, run.scene) for run in todo.values() if run.scene.specification is None]
    shared = libraries(known, "target" in names) if "dimple" in names else []
    by_name = dict(known)
    cost = sum(row["cost_s"] for row in rows)
    cost += sum(library_cost_s(by_name[library["run"]], library) for library in shared)
    jobs = jobs or cores()
    return {
        "out": str(prepared.out), "runs": rows, "impacts": count(shared), "jobs": jobs, "cost_s": cost, "wall_s": cost / jobs,
        "remarks": remarks(prepared.study),
    }  # fmt: skip


def dry_text(found: dict) -> str:
    """The same for reading: a line a run, then the sum."""
    lines = []
    for row in found["runs"]:
        axes = ", ".join(f"{key} = {value}" for key, value in row["axes"].items())
        told = row["cause"].split("\n")[0] if row["cause"] else f"about {row['cost_s']:.0f} s" if row["state"] == "to do" else ""
        lines.append(f"{row['run']}  {row['state']:<7}  {axes}  {told}".rstrip())
    todo = sum(row["state"] == "to do" for row in found["runs"])
    lines.append(
        f"{todo} of {len(found['runs'])} runs to do in {found['out']}, with {found['impacts']} shared impacts: to a factor of two"
        f" {found['cost_s']:.0f} s of computing, {found['wall_s']:.0f} s with {found['jobs']} at a time"
    )
    return "\n".join(lines)
