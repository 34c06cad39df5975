"""Checkpoints of an event-driven run: the world as ``<name>.npz``, the impacts so far beside it.

The impacts only grow, so they are appended to ``<name>.rows`` (raw records of ``impacts.COLUMNS``) before each
checkpoint, which says how many of them count.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError
from glue.flow.event_compile import sources
from glue.flow.event_state import World
from glue.flow.impacts import COLUMNS


def key_of(*parts) -> str:
    """sha256 of what a run depends on: ``parts`` (arrays, tuples of them, what has a plain repr), the kernel."""
    digest = hashlib.sha256(repr((sources(), COLUMNS)).encode())
    for part in parts:
        for piece in part if isinstance(part, tuple) else (part,):
            digest.update(
                np.ascontiguousarray(piece).tobytes()
                if isinstance(piece, np.ndarray)
                else repr(piece).encode()
            )
    return digest.hexdigest()


class Checkpoint:
    """Saves to and restores from ``path`` the run that ``key`` names."""

    def __init__(self, path: Path, key: str):
        self.path, self.key = Path(path), key
        self.rows_path = self.path.with_suffix(".rows")
        self.rows = 0  # impacts in the rows file

    def restore(self) -> tuple[World, np.ndarray] | None:
        """(world, impacts so far), or None when there is no checkpoint.

        Raises InputError for one that is of another run or damaged.
        """
        if not self.path.exists():
            return None
        try:
            with np.load(self.path, allow_pickle=False) as data:
                key, rows = str(data["key"]), int(data["rows"])
                if key != self.key:
                    raise InputError(
                        f"{self.path}: checkpoint of another scene, restitution or version; remove it to start anew"
                    )
                world = World(*(data[name] for name in World._fields))
            impacts = np.fromfile(self.rows_path, COLUMNS, count=rows)
        except (OSError, ValueError, KeyError, EOFError) as e:
            raise InputError(f"{self.path}: damaged checkpoint ({e}); remove it to start anew") from None
        if len(impacts) != rows:
            raise InputError(
                f"{self.rows_path}: {len(impacts)} of {rows} impacts; remove {self.path} to start anew"
            )
        self.rows = rows
        return world, impacts

    def save(self, world: World, new: np.ndarray) -> None:
        """Make ``world`` the state to go on from; ``new`` are the impacts since the last save."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with open(self.rows_path, "r+b" if self.rows else "wb") as f:
            f.truncate(self.rows * COLUMNS.itemsize)  # what was appended after the checkpoint gone on from
            f.seek(0, os.SEEK_END)
            f.write(np.ascontiguousarray(new).tobytes())
            f.flush()
            os.fsync(f.fileno())
        self.rows += len(new)
        with atomic_path(self.path) as part, open(part, "wb") as f:
            np.savez(f, key=self.key, rows=self.rows, **world._asdict())

    def remove(self) -> None:
        """The run has ended: nothing to go on from."""
        self.path.unlink(missing_ok=True)
        self.rows_path.unlink(missing_ok=True)
