"""What a study's folder holds beside its runs: queue, failures, marks of finished stages and busy folders, journal."""

from __future__ import annotations

import fcntl
import json
import os
import time
from pathlib import Path

from glue.atomic import write_text_atomic

QUEUE, JOURNAL, FAILURES, DONE, BUSY = "queue", "journal.csv", "failures", "done", "busy"


def failure_file(out: Path, name: str) -> Path:
    """Where the failure of a run is recorded."""
    return out / FAILURES / f"{name}.json"


def record_failure(out: Path, name: str, code: int, stage: str, cause: str) -> None:
    """Note why a run failed; {"exit_code", "stage", "cause"}, without the study's own folder in it."""
    for folder in (str(out.resolve()), str(out)):
        cause = cause.replace(f"{folder}/", "")
    record = {"exit_code": code, "stage": stage, "cause": cause}
    write_text_atomic(failure_file(out, name), json.dumps(record, indent=1) + "\n")


def claim(queue: Path) -> str | None:
    """Take the first name off the queue file, for this process alone; None when it is empty."""
    with open(queue, "r+", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        first, *rest = file.read().split("\n")
        file.seek(0)
        file.truncate()
        file.write("\n".join(rest))
        file.flush()
    return first or None


def mark(file: Path) -> None:
    """Leave an empty file."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.touch()


def note(out: Path, run: str, stage: str, event: str) -> None:
    """A line of the journal: time, run, stage, event; O_APPEND keeps the lines of several processes whole."""
    line = f"{time.time():.3f},{run},{stage},{event}\n"
    handle = os.open(out / JOURNAL, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        os.write(handle, line.encode())
    finally:
        os.close(handle)
