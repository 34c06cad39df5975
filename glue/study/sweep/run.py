"""Runs a study, or goes on with it: what is finished stays, what failed is recorded, tables are written in any case."""

from __future__ import annotations

import datetime
import fcntl
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from glue import solvers
from glue.atomic import write_text_atomic
from glue.errors import InputError, InUse
from glue.study.sweep.cluster import refuse_snakemake, run_snakemake
from glue.study.sweep.design import remarks
from glue.study.sweep.plan import PLAN, Run, default_out, make_runs, plan_dict, refuse_runs, study_sha256
from glue.study.sweep.records import BUSY, FAILURES, failure_file
from glue.study.sweep.study import Study, read_study

EXECUTORS = ("local", "snakemake")
Progress = Callable[[str, float | None, str], None]


class Prepared:
    """A study with its runs, each checked, and the names of those that are finished."""

    def __init__(self, study: Study, runs: list[Run], out: Path, done: set[str], retry: set[str]):
        self.study, self.runs, self.out, self.done, self._retry = study, runs, out, done, retry

    def todo(self, most: int | None = None) -> list[Run]:
        """Valid runs that are neither finished nor failed (unless to be tried again), of the first ``most``."""

        def waits(run: Run) -> bool:
            failed = failure_file(self.out, run.name).exists() and run.name not in self._retry
            return not run.cause and run.name not in self.done and not failed

        return [run for run in self.runs[:most] if waits(run)]


def prepare(study_file: str | Path, out: Path | None = None, retry_failed: bool = False) -> Prepared:
    """Read a study and check every run's scene; nothing is written.  Raises InputError with all problems found."""
    from glue.study.pipeline import with_needs  # here: the stages load every model
    from glue.study.stages import STAGES
    from glue.study.sweep.done import Finished

    study = read_study(study_file)
    runs = make_runs(study)
    out = out or default_out(study, runs)
    _refuse_other(out, study_sha256(study, runs))
    finished = Finished(study.stages, STAGES)
    done = {run.name for run in runs if finished(out / "runs" / run.name, run)}
    refuse_runs(study, runs, with_needs(study.stages, STAGES), lambda run: run.name in done)
    if all(run.cause for run in runs):
        sentences = dict.fromkeys(line for run in runs for line in run.cause.split("\n"))
        raise InputError([f"{study.file}: no run of the study can be made", *list(sentences)[:10]])
    names = {file.stem for file in (out / FAILURES).glob("*.json")} if retry_failed else set()
    return Prepared(study, runs, out, done, names)


def run_study(
    study_file: str | Path,
    out: Path | None = None,
    jobs: int | None = None,
    progress: Progress = lambda stage, fraction, text: None,
    *,
    executor: str = "local",
    profile: Path | None = None,
    retry_failed: bool = False,
    first: int | None = None,
) -> Path:
    """Run a study (a file or a shipped name), or go on with it, and return its folder ``out``.

    ``jobs`` runs at a time (default: one per core; with a profile its own number).  ``executor`` "snakemake" leaves
    them to Snakemake, ``profile`` a folder of its settings.  ``retry_failed`` tries failed runs again; ``first`` makes
    only that many of the runs.  Failed runs
    are recorded in the tables (see ``glue.study.sweep.table``), and ``exit_code(out)`` tells of them.  Raises InputError before
    anything starts, SolverFailed when runs cannot be started at all, InUse when other processes did not leave some.
    """
    from glue.study.pipeline import with_needs
    from glue.study.stages import STAGES
    from glue.study.sweep import table
    from glue.study.sweep.done import Finished
    from glue.target.cache import cache_root, refuse_unwritable
    from glue.target.speeds import cores

    if executor not in EXECUTORS:
        raise InputError(f"executor {executor}: allowed {', '.join(EXECUTORS)}")
    if executor == "snakemake":
        refuse_snakemake(profile)
    if jobs is not None and jobs < 1:
        raise InputError(f"--jobs {jobs}: allowed from 1 up, such as the number of cores")
    prepared = prepare(study_file, out, retry_failed)
    study, runs, out = prepared.study, prepared.runs, prepared.out
    for sentence in remarks(study):
        progress("study", 1.0, sentence)
    todo, begun = prepared.todo(first), _begun(out) or _now()
    elsewhere = executor == "snakemake" and profile is not None  # where the cores of this machine say nothing
    at_a_time = jobs or (None if elsewhere else cores())
    if todo:
        refuse_unwritable()  # else every run fails of it
    with _locked(out):
        names = [stage.name for stage in with_needs(study.stages, STAGES)]
        _write_plan(prepared, todo, names, None if elsewhere else at_a_time, cache_root())
        progress("study", 1.0, _first_words(prepared, todo))
        try:
            if todo:
                _execute(prepared, todo, names, executor, profile, at_a_time, progress)
        finally:  # also when it is stopped: what there is can be read
            finished = Finished(study.stages, STAGES)
            done = prepared.done | {run.name for run in todo if finished(out / "runs" / run.name, run)}
            counts = table.write_tables(out, study, runs, done)
            facts = {"inputs_sha256": study_sha256(study, runs), "executor": executor, "versions": solvers.versions()}
            _write_json(out / table.STUDY, table.study_dict(study, counts, **facts, begun=begun, ended=_now()))
    if not table.has_parquet():
        progress("study", 1.0, "no table.parquet, since pyarrow is not installed; table.csv holds the same")
    return out


def _begun(out: Path) -> str | None:
    """When the study in ``out`` was first run; None where it was not."""
    try:
        return json.loads((out / "study.json").read_text(encoding="utf-8"))["begun"]
    except (OSError, ValueError, KeyError):
        return None


def exit_code(out: Path) -> int:
    """0 when no run of the study in ``out`` failed, else the exit code of the first that did."""
    return json.loads((out / "study.json").read_text(encoding="utf-8"))["exit_code"]


def _execute(
    prepared: Prepared, todo: list[Run], names: list[str], executor: str, profile, jobs: int | None, progress: Progress
) -> None:
    out = prepared.out
    for run in todo:
        failure_file(out, run.name).unlink(missing_ok=True)
        (out / BUSY / run.name).unlink(missing_ok=True)
    if executor == "snakemake":
        run_snakemake(out, todo, names[-1], jobs, profile, lambda share, text: progress("runs", share, text))
    else:
        _execute_here(out, todo, names, jobs, progress)
    if busy := [run.name for run in todo if (out / BUSY / run.name).exists()]:
        others = f" and {len(busy) - 1} more" if len(busy) > 1 else ""
        words = "other processes are still at work there; the same command goes on once they have ended"
        raise InUse(f"{out / 'runs' / busy[0]}{others}: {words}")


def _execute_here(out: Path, todo: list[Run], names: list[str], jobs: int, progress: Progress) -> None:
    from glue.study.sweep.library import libraries, solve_libraries
    from glue.study.sweep.local import run_local

    known = [(run.name, run.scene) for run in todo if run.scene.specification is None]
    if known and "dimple" in names:
        scenes = dict(known)
        wanted = [(scenes[library["run"]], library) for library in libraries(known, "target" in names)]
        failed = solve_libraries(wanted, jobs, lambda share, text: progress("library", share, text))
        if failed:
            progress("library", 1.0, f"{failed} of the shared impacts could not be solved; the runs that need them will tell")
    run_local(out, todo, jobs, lambda share, text: progress("runs", share, text))


def _write_plan(prepared: Prepared, todo: list[Run], names: list[str], jobs: int | None, cache: Path) -> None:
    from glue.study.sweep.estimate import library_cost_s, stage_costs
    from glue.study.sweep.library import libraries

    study = prepared.study
    for run in todo:
        costs = stage_costs(run.scene)
        run.costs = {name: tuple(costs[name]) for name in names}
    known = [(run.name, run.scene) for run in todo if run.scene.specification is None]
    shared, scenes = libraries(known, "target" in names) if "dimple" in names else [], dict(known)
    shared = [library | {"seconds": library_cost_s(scenes[library["run"]], library)} for library in shared]
    plan = plan_dict(study, prepared.runs, shared, cache, study_sha256(study, prepared.runs))
    _write_json(prepared.out / PLAN, plan | {"all_stages": names, "todo": [run.name for run in todo], "jobs": jobs})
    for name, content in (("study.toml", study.content), ("scene.toml", study.scene_content)):
        write_text_atomic(prepared.out / name, content.decode("utf-8-sig"))


def _first_words(prepared: Prepared, todo: list[Run]) -> str:
    refused = sum(bool(run.cause) for run in prepared.runs)
    others = [f"{len(prepared.done)} finished", f"{len(todo)} to do"] + ([f"{refused} refused"] if refused else [])
    return f"{len(prepared.runs)} runs in {prepared.out}: {', '.join(others)}"


def _refuse_other(out: Path, sha256: str) -> None:
    """Raise InputError when ``out`` holds another study, or something else."""
    if not out.exists():
        return
    try:
        plan = json.loads((out / PLAN).read_text(encoding="utf-8"))
    except FileNotFoundError:
        if out.is_dir() and not any(p.name != ".lock" for p in out.iterdir()):
            return
        raise InputError(f"{out}: is not empty and no study's folder (it has no {PLAN}); choose another --out") from None
    except (OSError, ValueError) as problem:
        raise InputError(f"{out / PLAN}: cannot be read ({problem}); choose another --out") from None
    if plan.get("inputs_sha256") != sha256:
        raise InputError(
            f"{out}: holds a study of other runs ({plan.get('study')}, {len(plan.get('runs', []))} runs): the study file, its scene"
            " or the catalogue was changed; choose another --out"
        )


@contextmanager
def _locked(out: Path) -> Iterator[None]:
    """One process at a time works on the study."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        handle = os.open(out / ".lock", os.O_CREAT | os.O_RDWR, 0o644)
    except OSError as problem:
        raise InputError(f"{out}: cannot write the study's folder ({problem.strerror}); choose another with --out") from None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise InputError(f"{out}: another peen sweep is at work in it; wait for it or choose another --out") from None
    try:
        yield
    finally:
        os.close(handle)


def _write_json(path: Path, value: dict) -> None:
    write_text_atomic(path, json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def _now() -> str:
    return datetime.datetime.now().astimezone().isoformat(timespec="seconds")
