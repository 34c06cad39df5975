"""The manifest of a run directory: reading it, what it must hold, how two sets of inputs differ."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from glue.errors import InputError

SCHEMA = 1
MANIFEST = "manifest.json"
DONE = ("complete", "in doubt")  # states of a stage whose files are whole; others: "started", "failed"


def read_manifest(path: Path) -> dict:
    """The manifest of the run directory ``path``. Raises InputError when there is none or it is damaged."""
    try:
        manifest = json.loads((path / MANIFEST).read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(
            f"{path}: no run directory (it has no {MANIFEST}); peen run SCENE --out {path} makes one"
        ) from None
    except (OSError, ValueError) as problem:
        raise InputError(
            f"{path / MANIFEST}: cannot be read ({problem}); remove the directory and run again"
        ) from None
    if not isinstance(manifest, dict):
        raise InputError(f"{path / MANIFEST}: is no manifest; remove the directory and run again")
    if manifest.get("schema") != SCHEMA:
        raise InputError(
            f"{path / MANIFEST}: schema {manifest.get('schema')!r}, this version reads {SCHEMA}; run anew"
        )
    wrong = [key for key, kind in _KEYS.items() if not isinstance(manifest.get(key), kind)]
    if not wrong:
        wrong = [f"stages.{name}" for name, record in manifest["stages"].items() if not _is_record(record)]
    if wrong:
        raise InputError(
            f"{path / MANIFEST}: is damaged ({', '.join(wrong)}); remove the directory and run again"
        )
    return manifest


# What a manifest must hold for everything that reads it to find it; None stands for "as the scene says".
_KEYS = {
    "scene": str,
    "seed": int,
    "choices": dict,
    "defaults_used": list,
    "preset_argument": str | None,
    "inputs": dict,
    "inputs_sha256": str,
    "scene_sha256": str,
    "stages": dict,
}


def _is_record(record: Any) -> bool:
    """Is this what ``begin``, ``finish`` or ``fail`` wrote?"""
    if not isinstance(record, dict):
        return False
    if record.get("state") in ("failed", "started"):
        return True
    return (
        record.get("state") in DONE
        and isinstance(record.get("input_sha256"), str)
        and all(isinstance(record.get(key), dict) for key in ("outputs", "metrics"))
        and all(isinstance(values, dict) for values in record["metrics"].values())
    )


def differences(old: Any, new: Any, key: str = "") -> Iterator[str]:
    """Sentences "key: there a, here b" for every leaf that differs."""
    if isinstance(old, dict) and isinstance(new, dict):
        for name in sorted({*old, *new}):
            yield from differences(old.get(name), new.get(name), f"{key}.{name}" if key else name)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (there, here) in enumerate(zip(old, new, strict=True)):
            yield from differences(there, here, f"{key}[{k}]")
    elif old != new:
        yield f"{key}: there {json.dumps(old)}, here {json.dumps(new)}"
