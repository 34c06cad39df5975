"""Rows of the dimple benchmark on the library: its time, its error between its speeds, its exponent, every material.

Each starts from an empty cache.  The error between the speeds is held against impacts on a mesh twice as fine: the
library's curves run through the scatter of its own mesh (a solved restitution moves by 1 % with where the nodes fall),
which impacts on that same mesh would have, too.  Theirs is in the notes.
"""

from __future__ import annotations

import os
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from glue.checkrows import Rows
from glue.errors import PeenError
from glue.scene import catalogue
from glue.study.single import formulas_table, formulas_text
from glue.target.dimple import zero_height_radius
from glue.target.library import FITTED, build_library
from glue.target.speeds import cores, solve_speeds

STEEL = 7800.0  # kg/m3


def rows(rows: Rows) -> None:
    """Library of 12 speeds on 2024-T351, then every material once."""
    material = catalogue.material("al2024-t351")
    with _empty_cache():
        start = time.monotonic()
        library = build_library(material, 1.0, 120.0, 12, density_kg_m3=STEEL, elements_per_radius=6, jobs=2)
        elapsed = time.monotonic() - start
        solver_s = sum(impact.wall_s for impact in library.impacts)
        rows.below("library of 12 speeds, balanced, two at a time: time [s]", elapsed, 60.0,
                   f"{solver_s:.1f} s in FreeFem++; {cores()} cores, load {os.getloadavg()[0]:.1f}")  # fmt: skip
        middles = np.sqrt(np.array(library.speeds_m_s[:-1]) * library.speeds_m_s[1:])[::2]
        same, fine = (
            _fitted(solve_speeds(material, middles.tolist(), density_kg_m3=STEEL, elements_per_radius=n, jobs=2))
            for n in (6, 12)
        )
    for name in FITTED:
        off, own = (library.at(name, middles) / found[name] - 1.0 for found in (fine, same))
        rows.below(f"library: {name} at {len(middles)} speeds not in the table", float(np.abs(off).max()), 0.01,
                   f"rms {np.sqrt((off**2).mean()):.2%}; same mesh: worst {np.abs(own).max():.2%}, rms"
                   f" {np.sqrt((own**2).mean()):.2%}; stated error {library.curves[name].error:.2%}")  # fmt: skip
        values = library.column(name)
        rows.true(f"library: {name} monotone in v", bool((np.diff(values) * (values[-1] - values[0]) > 0).all()))
    rows.within("library: radius ~ v^n, n", library.curves["radius"].exponent(), 0.46, 0.04, f"{material.key}, 1 to 120 m/s")
    print(formulas_text(material, formulas_table(library)), flush=True)
    _materials(rows)


def _fitted(impacts) -> dict[str, np.ndarray]:
    return {
        "radius": np.array([zero_height_radius(i) for i in impacts]),
        "depth": np.array([-i.surface_z[0] for i in impacts]),
        "restitution": np.array([i.restitution for i in impacts]),
    }


def _materials(rows: Rows) -> None:
    """Every material of the catalogue at 60 m/s on the fast preset's mesh."""
    told, failed = [], []
    with _empty_cache():
        for key in catalogue.material_keys():
            try:
                (i,) = solve_speeds(catalogue.material(key), [60.0], density_kg_m3=STEEL, elements_per_radius=3)
                told.append(f"{key} a {zero_height_radius(i):.3f} R e {i.restitution:.3f}")
            except PeenError as problem:
                failed.append(f"{key}: {problem}")
    rows.true("every material of the catalogue runs at 60 m/s", not failed, "; ".join(failed or told))


@contextmanager
def _empty_cache():
    before = os.environ.get("PEEN_CACHE")
    with tempfile.TemporaryDirectory(prefix="peen-bench-") as scratch:
        os.environ["PEEN_CACHE"] = str(Path(scratch))
        try:
            yield
        finally:
            os.environ.pop("PEEN_CACHE") if before is None else os.environ.update(PEEN_CACHE=before)
