"""The run directory: the inputs it belongs to, what has been computed in it, and from what exactly.

``manifest.json`` is the only record of which stages are complete; it is written after every stage, and
a stage's record is replaced by "started" before its files are touched. So whatever stops a run, the files
that the manifest vouches for are whole and belong together, and what a stopped stage left behind is known
by the inputs that it was made from.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from glue.atomic import atomic_path, write_text_atomic
from glue.errors import InputError, InUse, SolverFailed
from glue.study.manifest import DONE, MANIFEST, SCHEMA, differences, read_manifest

STAGE_ORDER = ("dimple", "flow", "coverage", "target", "surface", "intensity", "uncertainty", "report")
METRICS, SCENE, LOCK = "metrics.json", "scene.toml", ".lock"


def digest(value: Any) -> str:
    """sha256 (hex) of a JSON-able value; equal values give equal digests."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, allow_nan=False).encode()).hexdigest()


def file_digest(path: Path) -> str:
    """sha256 (hex) of a file's content."""
    with open(path, "rb") as f:
        return hashlib.file_digest(f, "sha256").hexdigest()


class RunDirectory:
    """One run's folder, locked against a second process while this object is in use (``with``)."""

    def __init__(self, path: Path, manifest: dict, lock: int):
        self.path, self.manifest, self._lock = path, manifest, lock

    def __enter__(self) -> RunDirectory:
        return self

    def __exit__(self, *exc) -> None:
        os.close(self._lock)

    @classmethod
    def create_or_continue(
        cls, path: Path, *, scene: bytes, preset: str | None, resolved: dict, facts: dict,
        companions: Mapping[str, bytes] | None = None,
    ) -> RunDirectory:
        """Open ``path`` for the scene, making it if need be.

        ``scene`` is the scene file's content, ``companions`` {relative name: content} of the files that it names,
        copied with it; ``resolved`` the scene in SI units with its preset expanded: a directory made for another
        one is refused. ``facts`` (seed, choices) go into a new manifest as they are.
        Raises InputError when the directory holds other inputs or other files, or cannot be written, InUse when it
        is locked.
        """
        try:
            path.mkdir(parents=True, exist_ok=True)
            was_locked_once = (path / LOCK).exists()
            lock = _lock(path)  # before looking: what another peen is just making must not pass for a stranger's
        except OSError as problem:
            raise InputError(
                f"{path}: cannot write the run directory ({problem.strerror}); choose another with --out"
            ) from None
        try:
            if (path / MANIFEST).exists():
                run = cls._continue(path, lock, scene, resolved)
            else:
                run = cls._create(path, lock, scene, preset, resolved, facts, companions or {})
            for name, content in (companions or {}).items():
                if not (path / name).is_file() or (path / name).read_bytes() != content:
                    _write_bytes(path / name, content)
            return run
        except BaseException:
            if not was_locked_once and not (path / MANIFEST).exists():
                (path / LOCK).unlink(missing_ok=True)  # a folder that is refused is left as it was
            os.close(lock)
            raise

    @classmethod
    def _create(
        cls, path: Path, lock: int, scene: bytes, preset: str | None, resolved: dict, facts: dict, companions
    ) -> RunDirectory:
        known = {SCENE, LOCK, *(Path(name).parts[0] for name in companions)}
        strangers = [p.name for p in path.iterdir() if p.name not in known and p.suffix != ".part"]
        if strangers:
            raise InputError(
                f"{path}: is not empty and no run directory (holds {', '.join(sorted(strangers)[:3])} …);"
                " choose another --out"
            )
        # An interrupted start leaves the scene file's very copy; anything else is the user's own.
        if (path / SCENE).exists() and (path / SCENE).read_bytes() != scene:
            raise InputError(
                f"{path / SCENE}: is there already and another scene than the one to run, which would replace it;"
                " choose another --out"
            )
        # The scene first: a directory with a manifest is one that can be continued.
        _write_bytes(path / SCENE, scene)
        run = cls(
            path,
            {
                "schema": SCHEMA,
                **facts,
                "preset_argument": preset,
                "inputs": resolved,
                "inputs_sha256": digest(resolved),
                "scene_sha256": file_digest(path / SCENE),
                "stages": {},
            },
            lock,
        )
        run._save()
        return run

    @classmethod
    def _continue(cls, path: Path, lock: int, scene: bytes, resolved: dict) -> RunDirectory:
        run = cls(path, read_manifest(path), lock)
        changed = list(differences(run.manifest["inputs"], resolved))
        if changed:
            raise InputError(
                [f"{path}: holds a run of other inputs, which would get mixed up; choose another --out"]
                + [f"  {d}" for d in changed]
            )
        if not run.scene_file.is_file() or file_digest(run.scene_file) != run.manifest["scene_sha256"]:
            _write_bytes(run.scene_file, scene)  # the same inputs, as was just found
            run.manifest["scene_sha256"] = file_digest(run.scene_file)
            run._save()
        return run

    @classmethod
    def open(cls, path: Path) -> RunDirectory:
        """Open an existing run directory. Raises InputError when it is none, or of another schema."""
        read_manifest(path)  # before the lock: a folder that is no run gets no file of ours
        lock = _lock(path)
        try:
            return cls(path, read_manifest(path), lock)  # again: another peen may just have ended
        except BaseException:
            os.close(lock)
            raise

    @property
    def scene_file(self) -> Path:
        return self.path / SCENE

    def is_current(self, stage: str, input_hash: str) -> bool:
        """Was ``stage`` completed with exactly these inputs, and are its files still what it wrote?"""
        record = self.manifest["stages"].get(stage)
        if record is None or record["state"] not in DONE or record["input_sha256"] != input_hash:
            return False
        return not self.damaged(stage)

    def damaged(self, stage: str) -> list[str]:
        """Names of the files of a completed stage that are gone or not what it wrote."""
        outputs = self.manifest["stages"][stage]["outputs"]
        files = {name: self.path / name for name in outputs}
        return [name for name, p in files.items() if not (p.is_file() and file_digest(p) == outputs[name])]

    def keep(self, stage: str) -> None:
        """Note that ``stage``, found current, counts again if it had been put in doubt."""
        if self.manifest["stages"][stage]["state"] != "complete":
            self.manifest["stages"][stage]["state"] = "complete"
            self._save()

    def outputs_digest(self, stage: str) -> str | None:
        """Digest of the files and metrics (times apart) of a complete stage, None when it is not complete."""
        record = self.manifest["stages"].get(stage, {})
        if record.get("state") != "complete":
            return None
        metrics = {
            s: {k: v for k, v in values.items() if k != "wall_s"} for s, values in record["metrics"].items()
        }
        return digest([record["outputs"], metrics])

    def can_go_on(self, stage: str, input_hash: str) -> bool:
        """Was ``stage`` stopped, by whatever means, in a first attempt with exactly these inputs?

        An attempt that went on from another and failed is not gone on with: what it found may be the reason.
        """
        record = self.manifest["stages"].get(stage, {})
        if record.get("input_sha256") != input_hash:
            return False
        killed = record["state"] == "started"
        solver_died = record["state"] == "failed" and record.get("exit_code") == SolverFailed.exit_code
        return killed or (solver_died and not record.get("went_on", False))

    def begin(
        self, stage: str, later: Iterable[str], owned: Iterable[str], input_hash: str, go_on: bool = False
    ) -> None:
        """Note ``stage`` as started and remove its files; put the stages ``later`` built on it in doubt.

        Of the folders among ``owned`` only what the stage's record lists and unfinished files (.part) go: the
        user's own files in them stay. ``go_on`` leaves everything where it is. A doubted stage is out of
        metrics.json until its own turn, when it is kept or run again.
        """
        written = self.manifest["stages"].pop(stage, {}).get("outputs", {})
        self.manifest["stages"][stage] = {"state": "started", "input_sha256": input_hash, "went_on": go_on}
        for name in later:
            if self.manifest["stages"].get(name, {}).get("state") == "complete":
                self.manifest["stages"][name]["state"] = "in doubt"
        self._save()
        if go_on:
            return
        places = [self.path / name for name in owned]
        unfinished = [part for place in places if place.is_dir() for part in place.rglob("*.part")]
        for file in (*(self.path / name for name in written), *places, *unfinished):
            if file.is_file() or file.is_symlink():
                file.unlink()

    def finish(self, stage: str, record: dict, outputs: Iterable[str]) -> None:
        """Note ``stage`` as complete with the files ``outputs`` (relative names), and renew metrics.json."""
        hashes = {name: file_digest(self.path / name) for name in sorted(outputs)}
        self.manifest["stages"][stage] = {"state": "complete", **record, "outputs": hashes}
        self._save()

    def fail(self, stage: str, record: dict) -> None:
        """Note that ``stage`` failed; it counts as not run."""
        self.manifest["stages"][stage] = {"state": "failed", **record}
        self._save()

    def metrics(self) -> dict:
        """Content of metrics.json: the complete stages' values, later stages' over earlier ones'."""
        merged: dict[str, Any] = {"schema": SCHEMA}
        for stage in sorted(self.manifest["stages"], key=_position):
            record = self.manifest["stages"][stage]
            if record["state"] != "complete":
                continue
            for section, values in record["metrics"].items():
                target = merged.setdefault(section, {})
                target.update(values)
                for key in values:
                    if values[key] is not None:
                        target.pop(f"{key}_reason", None)
        return merged

    def renew_metrics(self) -> None:
        """Write metrics.json as the manifest has it, whatever became of the file meanwhile."""
        write_text_atomic(self.path / METRICS, _json(self.metrics()))

    def _save(self) -> None:
        write_text_atomic(self.path / MANIFEST, _json(self.manifest))
        self.renew_metrics()


def _write_bytes(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_path(path) as part:
        part.write_bytes(content)


def _position(stage: str) -> int:
    return STAGE_ORDER.index(stage) if stage in STAGE_ORDER else len(STAGE_ORDER)


def _json(value: dict) -> str:
    return json.dumps(value, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _lock(path: Path) -> int:
    handle = os.open(path / LOCK, os.O_CREAT | os.O_RDWR, 0o644)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise InUse(
            f"{path}: another peen is at work in it; wait for it or choose another --out"
        ) from None
    return handle
