"""Runs stages in order, each only when its inputs changed, and keeps the run directory's record of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from glue import solvers, stopping
from glue.errors import InputError, PeenError
from glue.flow.imported import IMPORTED, content_of, sha256_of
from glue.scene.model import Scene
from glue.scene.reader import example_names, example_path, read_bytes, read_scene, resolved_dict
from glue.study.choices import choices
from glue.study.cost import watched
from glue.study.rundir import RunDirectory, digest, file_digest
from glue.study.stage import Stage, Work
from glue.study.target_surface import companions

# progress(stage, fraction done or None, text): called from the thread that runs the stage.
Progress = Callable[[str, float | None, str], None]


def find_scene(argument: str) -> Path:
    """Path of a scene given as a file or as the name of a shipped example. Raises InputError."""
    path = Path(argument)
    if path.exists() and not path.is_dir():  # a folder of an example's name does not hide the example
        return path
    shipped = example_path(argument)
    if shipped is None and path.is_dir():
        raise InputError(f"{argument}: is a folder, not a scene file")
    if shipped is None:
        raise InputError(
            f"{argument}: no such scene file, nor a shipped example ({', '.join(example_names())})"
        )
    return shipped


def default_out(scene: Scene, impacts: Path | None = None) -> Path:
    """``runs/<scene name>-<8 hex of the inputs>``."""
    return Path("runs") / f"{scene.name}-{digest(_resolved(scene, impacts))[:8]}"


def _resolved(scene: Scene, impacts: Path | None) -> dict:
    """The inputs: the scene in SI units, and which impact log from elsewhere (``impacts``: None or absent: none)."""
    brought = {} if impacts is None or not impacts.exists() else {"imported_impacts_sha256": sha256_of(impacts)}
    return resolved_dict(scene) | brought


def run(
    scene_argument: str,
    out: Path | None = None,
    preset: str | None = None,
    only: Sequence[str] = (),
    progress: Progress = lambda stage, fraction, text: None,
    stages: Sequence[Stage] | None = None,
    content: bytes | None = None,
    impacts: Path | None = None,
) -> Path:
    """Run a scene (file or shipped name) into ``out`` and return the run directory.

    ``content`` takes the place of the scene file's (the same scene with some keys changed).
    ``impacts``: an impact log that takes the place of the flow's own; it is copied into the run.
    ``only`` names the stages wanted; what they need is brought up to date first. Raises InputError
    before any solver starts, SolverFailed or NotConverged with the run directory in a note.
    """
    from glue.study.specify import read_specified  # here: it loads the target's models

    stages = _default_stages() if stages is None else stages
    wanted = with_needs(only or [s.name for s in stages], stages)
    scene_file = find_scene(scene_argument)
    if content is None:
        content = read_bytes(scene_file)  # once: what is checked is what is run, and a pipe gives it only once
    scene, beside = read_specified(scene_file, preset=preset, content=content, progress=progress)
    brought = {} if impacts is None else {IMPORTED: content_of(impacts)}
    path = out or default_out(scene, impacts)
    facts = {
        "scene": scene.name,
        "seed": scene.seed,
        "choices": choices(scene),
        "inferred": list(scene.inferred),
        "defaults_used": list(scene.defaults_used),
    }
    with RunDirectory.create_or_continue(
        path, scene=content, preset=preset, resolved=_resolved(scene, impacts), facts=facts,
        companions=companions(scene, scene_file) | beside | brought,
    ) as folder:
        _run_stages(folder, scene, wanted, stages, progress)
    return path


def rerun(path: Path, only: Sequence[str], progress: Progress, stages: Sequence[Stage] | None = None) -> Path:
    """Bring stages of an existing run directory up to date; errors as for :func:`run`."""
    stages = _default_stages() if stages is None else stages
    wanted = with_needs(only, stages)
    with RunDirectory.open(path) as folder:
        if not folder.scene_file.is_file():
            raise InputError(f"{folder.scene_file}: is gone; peen run SCENE --out {path} restores it")
        scene = read_scene(folder.scene_file, preset=folder.manifest["preset_argument"])
        if digest(_resolved(scene, path / IMPORTED)) != folder.manifest["inputs_sha256"]:
            raise InputError(
                f"{folder.scene_file}: was changed after the run was made (or the catalogue was);"
                " run it into a new directory"
            )
        _run_stages(folder, scene, wanted, stages, progress)
    return path


def is_done(path: Path, only: Sequence[str], stages: Sequence[Stage] | None = None) -> bool:
    """Would running these stages of the run directory ``path`` find all of them up to date?"""
    stages = _default_stages() if stages is None else stages
    try:
        with RunDirectory.open(path) as folder:
            scene = read_scene(folder.scene_file, preset=folder.manifest["preset_argument"])
            wanted = with_needs(only, stages)
            return all(folder.is_current(s.name, digest(stage_inputs(folder, scene, s))) for s in wanted)
    except (InputError, KeyError):
        return False


def _default_stages() -> tuple[Stage, ...]:
    from glue.study.stages import STAGES  # here, since it loads every model (numba, scipy: 2 s)

    return STAGES


def with_needs(names: Iterable[str], stages: Sequence[Stage]) -> list[Stage]:
    """The named stages and all that they need, in order. Raises InputError for a name that is none."""
    known = {s.name: s for s in stages}
    unknown = [n for n in names if n not in known]
    if unknown:
        raise InputError(f"--only: no stage {', '.join(unknown)}; allowed: {', '.join(known)}")
    wanted, pending = set(), list(names)
    while pending:
        name = pending.pop()
        if name not in wanted:
            wanted.add(name)
            pending += known[name].needs
    return [s for s in stages if s.name in wanted]


def _builds_on(stage: Stage, stages: Sequence[Stage]) -> list[Stage]:
    """Later stages that read what ``stage`` writes, directly or through others."""
    found = {stage.name}
    for later in stages:  # in order, so one pass follows every chain
        if found & {*later.needs, *later.uses}:
            found.add(later.name)
    return [s for s in stages if s.name in found and s is not stage]


def _run_stages(folder: RunDirectory, scene: Scene, wanted, stages, progress: Progress) -> None:
    _refuse_damage(folder, wanted)
    _look_ahead(folder, scene, wanted, stages)
    folder.renew_metrics()  # stages read it, and so does whoever asked
    for stage in wanted:
        stopping.check()
        done = frozenset(n for n, r in folder.manifest["stages"].items() if r["state"] == "complete")
        inputs = stage_inputs(folder, scene, stage)
        input_hash = digest(inputs)
        if folder.is_current(stage.name, input_hash):
            folder.keep(stage.name)
            progress(stage.name, 1.0, "up to date")
            continue
        go_on = stage.resumes and folder.can_go_on(stage.name, input_hash)
        folder.begin(stage.name, [s.name for s in _builds_on(stage, stages)], stage.owns, input_hash, go_on)
        work = Work(scene, folder.path, folder.scene_file, _teller(progress, stage.name), done, go_on)
        progress(stage.name, 0.0, "goes on from a stopped attempt" if go_on else "starts")
        record = {"input_sha256": input_hash, "went_on": go_on, "inputs": inputs, "versions": solvers.versions()}
        _run_one(folder, stage, work, record)
        progress(stage.name, 1.0, "done")
    stopping.check()  # else a run that was told to stop in its last stage would call itself done


def stage_inputs(folder: RunDirectory, scene: Scene, stage: Stage, code: dict[str, str] | None = None) -> dict:
    """All that decides the stage's result, as it is now; ``code`` where ``code_digests`` of the stage is known."""
    versions = solvers.versions()
    return {
        "scene": folder.manifest["inputs_sha256"],
        "code": code_digests(stage) if code is None else code,
        "versions": {name: versions[name] for name in stage.runs(scene, folder.path)},
        "upstream": {name: folder.outputs_digest(name) for name in (*stage.needs, *stage.uses)},
    }


def _refuse_damage(folder: RunDirectory, wanted: Sequence[Stage]) -> None:
    """Raise InputError when a stage would read files that were damaged and that are not its turn to be renewed."""
    names = {s.name for s in wanted}
    read = {n: None for s in wanted for n in s.uses if n not in names}
    complete = [n for n in read if folder.manifest["stages"].get(n, {}).get("state") == "complete"]
    problems = [
        f"{folder.path / file}: is gone or not what stage {name} wrote; run `peen run` again on this directory"
        for name in complete
        for file in folder.damaged(name)
    ]
    if problems:
        raise InputError(problems)


def _look_ahead(folder: RunDirectory, scene: Scene, wanted: Sequence[Stage], stages: Sequence[Stage]) -> None:
    """Ask every stage that is out of date, or may be once an earlier one has run, for what would stop it.

    Before anything is removed or run: a solver that is missing (SolverFailed) or a scene that a stage refuses
    (InputError) must cost no result and no time.
    """
    stale = [s for s in wanted if not folder.is_current(s.name, digest(stage_inputs(folder, scene, s)))]
    may_run = {s.name for stage in stale for s in (stage, *_builds_on(stage, stages))}
    find = {"yade": solvers.find_yade, "freefem": solvers.find_freefem}
    for name in {name: None for s in wanted if s.name in may_run for name in s.runs(scene, folder.path)}:
        find[name]()
    for stage in wanted:
        if stage.name in may_run:
            stage.refuse(scene, folder.scene_file)


def _teller(progress: Progress, name: str) -> Callable[[float | None, str], None]:
    """Progress of one stage; only its end, with the record written, counts as all done."""

    def tell(fraction: float | None, text: str = "") -> None:
        stopping.check()
        progress(name, None if fraction is None else min(fraction, 0.999), text)

    return tell


def _run_one(folder: RunDirectory, stage: Stage, work: Work, record: dict[str, Any]) -> None:
    record["date"] = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    with watched(folder.path) as cost:
        try:
            metrics, outputs = stage.run(work)
        except (PeenError, OSError) as problem:
            code = problem.exit_code if isinstance(problem, PeenError) else InputError.exit_code
            try:
                folder.fail(stage.name, {**record, **cost(), "exit_code": code, "error": str(problem)})
            except (OSError, ValueError) as second:  # a full disk fails twice; the first error is the one to tell
                problem.add_note(f"the failure could not be noted down either: {second}")
            problem.add_note(
                f"stage {stage.name} of the run in {folder.path}; once mended, the same command goes on there"
            )
            raise
        folder.finish(stage.name, {**record, **cost(), "exit_code": 0, "metrics": metrics}, outputs)


def code_digests(stage: Stage) -> dict[str, str]:
    """{path relative to the checkout: sha256} of the sources that decide the stage's result."""
    root = solvers.repo_root()
    files = sorted({p for pattern in stage.code for p in root.glob(pattern) if p.is_file()})
    return {str(p.relative_to(root)): file_digest(p) for p in files}
