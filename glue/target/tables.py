"""Reads the CSV tables that the FreeFEM drivers write (17 digits, one header line)."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from glue.errors import NotConverged, SolverFailed


def read_table(path: Path) -> dict[str, np.ndarray]:
    """Columns of a table by name, each (rows,).

    Raises SolverFailed when the file is missing, torn, or has not the rows that the driver's status file tells of it;
    NotConverged when a value is not finite.
    """
    try:
        with open(path) as f:
            names = f.readline().strip().split(",")
        values = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    except (OSError, ValueError) as problem:
        raise SolverFailed(f"FreeFem++ left no readable {path.name}", cause=str(problem), log=path) from None
    if values.size and values.shape[1] != len(names):
        raise SolverFailed(f"{path.name} has {values.shape[1]} columns, its header {len(names)}", log=path)
    rows = _rows_written(path)
    if rows is not None and len(values) != rows:
        raise SolverFailed(f"{path.name} has {len(values)} rows, FreeFem++ wrote {rows}: cut short", log=path,
                           advice="disk full? run it again")  # fmt: skip
    if not np.isfinite(values).all():
        raise NotConverged(f"{path.name} holds values that are not finite", log=path, advice="another preset")
    return {name: values[:, k] if values.size else np.empty(0) for k, name in enumerate(names)}


def _rows_written(path: Path) -> int | None:
    """What the line ``rows <name> <count>`` of the status file beside ``path`` says; None without one."""
    try:
        found = re.search(rf"^rows {re.escape(path.name)} (\d+)$", path.with_name("status").read_text(), re.MULTILINE)
    except OSError:
        return None
    return int(found.group(1)) if found else None
