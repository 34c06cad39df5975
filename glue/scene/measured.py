"""What a laboratory knows of the part: its stress and roughness before peening, and what it measured after.

Standard library only.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

from glue.scene import schema
from glue.scene.asked import Measured
from glue.scene.fields import kind, quoted, show
from glue.scene.table import Table

_STRESS = (
    "allowed: an array of 1 to 50 tables { depth_m = …, stress_Pa = … }, depths rising from 0; no stress below the last"
)


def beside(scene_file: Path, written: str) -> Path | None:
    """A file that a scene names: from the folder of the scene file, else by its bare name beside it."""
    folder = scene_file.parent
    for candidate in (folder / written, folder / Path(written).name):
        if candidate.is_file():
            return candidate
    return None


def read_initial_stress(table: Table) -> tuple[tuple[float, float], ...]:
    """``initial_stress`` of ``[target]``: (depth, stress) by rising depth; () when absent or refused."""
    if "initial_stress" not in table:
        return ()
    rows = table.data["initial_stress"]
    if not isinstance(rows, list) or not rows or len(rows) > 50 or not all(isinstance(row, Mapping) for row in rows):
        table.problem("initial_stress", f"must be an array of tables, not {kind(rows)}; {_STRESS}")
        return ()
    pairs = []
    for number, row in enumerate(rows, 1):
        entry = Table(row, f"{table.at('initial_stress')}[{number}]", table.log)
        entry.refuse_others(schema.INITIAL_STRESS)
        pairs.append(tuple(entry.get_all(schema.INITIAL_STRESS).values()))
    if any(None in pair for pair in pairs):
        return ()
    if pairs[0][0] != 0.0 or any(a[0] >= b[0] for a, b in pairwise(pairs)):
        table.problem("initial_stress", f"depths {', '.join(show(z) for z, _ in pairs)} m; {_STRESS}")
        return ()
    return tuple(pairs)


def read_initial_roughness(table: Table) -> tuple[float, float] | None:
    """``initial_roughness`` of ``[target]``: (Sa, wavelength) [m]; None when absent (flat) or refused."""
    if "initial_roughness" not in table:
        return None
    entry = table.optional_table("initial_roughness")
    if entry is None:
        return None
    entry.refuse_others(schema.INITIAL_ROUGHNESS)
    values = tuple(entry.get_all(schema.INITIAL_ROUGHNESS).values())
    return None if None in values else values


def read_measured(top: Table, scene_file: Path) -> Measured | None:
    """``[measured]``; None when absent or refused."""
    if "measured" not in top:
        return None
    table = top.optional_table("measured")
    if table is None:
        return None
    table.refuse_others(schema.MEASURED, elsewhere=schema.BELONGS_IN)
    given = {key: table.get(key, field) for key, field in schema.MEASURED.items() if key in table}
    if not given:
        top.problem("measured", f"is empty; allowed: {', '.join(schema.MEASURED)}")
    if not given or None in given.values():
        return None
    if "stress_file" in given:
        path = beside(scene_file, given["stress_file"])
        if path is None:
            where = scene_file.parent or "."
            missing = f"no file {quoted(given['stress_file'])} in {where}"
            table.problem("stress_file", f"{missing}; allowed: a CSV file with depth_* and stress_*")
            return None
        given["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    return Measured(**given)
