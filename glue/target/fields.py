"""Displacement, stress and plastic strain of a finished cell or block, element by element, from FreeFEM's tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.errors import SolverFailed
from glue.target.tables import read_table

STRESSES = ("s_xx", "s_yy", "s_zz", "s_xy", "s_yz", "s_zx")  # the order in which ParaView takes a symmetric tensor
_POINTS = 4  # Gauss points of an element
_VOLUME_ERROR = 1e-5  # relative; vertices are written with nine digits


@dataclass(frozen=True)
class Fields:
    """Tetrahedra of the undeformed mesh; a finite-strain block's displacement is the mesh's, after it was let go too."""

    points_m: np.ndarray  # (n, 3)
    tetrahedra: np.ndarray  # (m, 4) rows of points_m
    displacement_m: np.ndarray  # (n, 3)
    stress_Pa: np.ndarray  # (m, 6) by volume, in the order of STRESSES
    peeq: np.ndarray  # (m,)


def read_fields(folder: Path, count: int, origin_m: tuple[float, float] = (0.0, 0.0)) -> Fields:
    """Fields after ``count`` impacts of the run in ``folder``; origin_m: where the model's x = y = 0 lies.

    Raises SolverFailed for missing tables and for points that are not those of the elements, NotConverged for values
    that are not finite.
    """
    points, vertices = read_table(folder / f"points-{count}.csv"), read_table(folder / f"vertices-{count}.csv")
    elements = np.column_stack(list(read_table(folder / "elements.csv").values())).astype(int)
    place = np.column_stack([vertices[f"{axis}_mm"] for axis in "xyz"])
    corner = place[elements]
    volume = np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1])) / 6.0
    weight = points["volume_mm3"]
    if weight.size != _POINTS * len(elements) or np.abs(weight.reshape(-1, _POINTS).sum(axis=1) / volume - 1.0).max() > _VOLUME_ERROR:
        raise SolverFailed(f"points-{count}.csv and elements.csv are not of one mesh", log=folder / "elements.csv",
                           advice="remove the folder and run again")  # fmt: skip

    def mean(name: str) -> np.ndarray:
        return (weight * points[name]).reshape(-1, _POINTS).sum(axis=1) / weight.reshape(-1, _POINTS).sum(axis=1)

    return Fields(
        points_m=1e-3 * place + [*origin_m, 0.0],
        tetrahedra=elements,
        displacement_m=1e-3 * np.column_stack([vertices[f"u_{axis}"] for axis in "xyz"]),
        stress_Pa=1e6 * np.column_stack([mean(name) for name in STRESSES]),
        peeq=mean("peeq"),
    )
