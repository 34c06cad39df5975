"""Reads back what the stages wrote into a run directory."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError
from glue.flow.arrivals import scene_hash
from glue.flow.impacts import read_impacts
from glue.scene.model import Scene
from glue.surface.window import in_window_coordinates
from glue.target.dimple import Dimple


def load_dimple(path: Path) -> Dimple:
    """The dimple of the run directory ``path``. Raises InputError when it has none."""
    return Dimple.load(path / "dimple" / "dimple.npz")


def load_impacts(path: Path, scene: Scene) -> np.ndarray:
    """The impacts of a run directory, in the coordinates of the scene's window (``glue.surface.window``).

    Raises InputError for a log that cannot be read or is another scene's.
    """
    file = path / "flow" / "impacts.csv"
    impacts, header = read_impacts(file)
    if header.get("scene_hash") != scene_hash(scene):
        raise InputError(
            f"{file}: is the log of another scene (its scene_hash is {str(header.get('scene_hash'))[:12]}, this scene's is "
            f"{scene_hash(scene)[:12]}); allowed: this scene's own, peen flow {path} writes it"
        )
    return in_window_coordinates(impacts, scene.target.surface)


def plain(values: dict) -> dict:
    """``values`` for JSON: Python numbers, and null with a reason for what is not finite."""
    result = {}
    for key, value in values.items():
        value = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, float) and not math.isfinite(value):
            result |= {key: None, f"{key}_reason": f"came out as {value}"}
        else:
            result[key] = value
    return result


def write_columns(path: Path, **columns: np.ndarray) -> None:
    """A CSV file with a header line; 17 digits, so that reading gives the same numbers back."""
    with atomic_path(path) as part:
        np.savetxt(
            part, np.column_stack(list(columns.values())), "%.17g", ",", header=",".join(columns), comments=""
        )
