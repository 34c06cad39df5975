"""Reads back what the stages wrote into a run directory."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.flow.impacts import read_impacts
from glue.target.dimple import Dimple


def load_dimple(path: Path) -> Dimple:
    """The dimple of the run directory ``path``. Raises InputError when it has none."""
    return Dimple.load(path / "dimple" / "dimple.npz")


def load_impacts(path: Path) -> np.ndarray:
    """The impact log of the run directory ``path``, a structured array (see ``glue.flow.impacts``)."""
    return read_impacts(path / "flow" / "impacts.csv")[0]


def write_columns(path: Path, **columns: np.ndarray) -> None:
    """A CSV file with a header line; 17 digits, so that reading gives the same numbers back."""
    with atomic_path(path) as part:
        np.savetxt(
            part, np.column_stack(list(columns.values())), "%.17g", ",", header=",".join(columns), comments=""
        )
