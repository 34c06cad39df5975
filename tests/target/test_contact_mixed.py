"""A .3 mm and a 1 mm shot on one block: each by its own radius and energy, against the axisymmetric solver scaled to it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_contact_block import driver

from glue.solvers import run_freefem
from glue.target.tables import read_table

pytestmark = pytest.mark.solver

SMALL, LARGE = -0.25, 0.25  # mm, places on the x axis: their dimples, .068 and .227 mm wide, do not meet


def energy_mJ(diameter_mm: float) -> float:
    """Steel of 7800 kg/m3 at 60 m/s."""
    return 7800 * math.pi / 6 * (1e-3 * diameter_mm) ** 3 * 0.5 * 60.0**2 * 1e3


def lines(*parts: tuple[float, float, int]) -> str:
    """Grid lines of (from, to, cells) one after another."""
    found = [np.linspace(a, b, n, endpoint=False) for a, b, n in parts]
    return str([*np.round(np.concatenate(found), 6).tolist(), parts[-1][1]])


def test_each_shot_leaves_its_own_dimple(tmp_path):
    """Grid .035 mm under the small shot, .07 under the large one: two and 3.2 elements a dimple radius.

    The large one: within the limits of the reference impact on that grid.  The small one, everything scaled by .3: force
    by .09, depth by .3; two elements a radius are good for 10 %.
    """
    path = driver(
        tmp_path, [[SMALL, 0.0, energy_mJ(0.3), 0.15, 0.13], [LARGE, 0.0, energy_mJ(1.0), 0.5, 0.43]],
        columnX=lines((-2.0, -1.2, 1), (-1.2, -0.75, 1), (-0.75, -0.5, 1), (-0.5, -0.39, 1), (-0.39, -0.11, 8), (-0.11, 0.66, 11),
                      (0.66, 0.8, 1), (0.8, 1.05, 1), (1.05, 1.5, 1), (1.5, 2.0, 1), (2.0, 2.6, 1)),
        columnY=lines((-2.1, -1.3, 1), (-1.3, -0.8, 1), (-0.8, -0.55, 1), (-0.55, -0.42, 1), (-0.42, -0.14, 4), (-0.14, 0.14, 8),
                      (0.14, 0.42, 4), (0.42, 0.55, 1), (0.55, 0.8, 1), (0.8, 1.3, 1), (1.3, 2.1, 1)),
        layerThickness="[0.012, 0.022, 0.037, 0.06, 0.09, 0.13, 0.2, 0.4, 0.8, 1.6]", layerKind="[0, 0, 0, 0, 1, 0, 1, 0, 0, 0]",
        contactBox="[-0.4, 0.67, -0.43, 0.43]",
    )  # fmt: skip
    run_freefem(path, cwd=tmp_path, log=tmp_path / "log", status=tmp_path / "status")
    got = read_table(tmp_path / "impacts_done.csv")
    small, large = ({name: values[k] for name, values in got.items()} for k in (0, 1))
    assert got["work_mJ"] == pytest.approx([energy_mJ(0.3), energy_mJ(1.0)], rel=0.005)
    assert large["peak_force_N"] == pytest.approx(262.8, rel=0.03)
    assert large["depth_mm"] == pytest.approx(0.0524, rel=0.05)
    assert large["restitution"] == pytest.approx(0.338, abs=0.02)
    assert small["peak_force_N"] == pytest.approx(0.09 * 262.8, rel=0.10)
    assert small["depth_mm"] == pytest.approx(0.3 * 0.0524, rel=0.10)
    assert small["restitution"] == pytest.approx(0.338, abs=0.05)
