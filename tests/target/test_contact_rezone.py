"""Rezoning: what it must keep, what it must let go of, and the run that stops without it."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

from glue.errors import NotConverged
from glue.solvers import repo_root, run_freefem
from glue.target.driver import Parameter
from glue.target.tables import read_table

sys.path.insert(0, str(repo_root() / "freefem" / "checks"))
from driving import run_check  # found through the line above
from test_contact_block import COARSE, ENERGY, run

pytestmark = pytest.mark.solver

LAW = "[73100, 0.33, 270, 0, 1, 80, 12, 130, 300, 60, 12]"


def rezoned(folder, amplitude, bump, cells=6):
    lines = np.linspace(-1, 1, 2 * cells + 1).tolist()
    run_check(folder, "a block rezoned",
              [Parameter("real[int]", "law", [73100.0, 0.33, 270.0, 0.0, 1.0, 80.0, 12.0, 130.0, 300.0, 60.0, 12.0], ""),
               Parameter("real", "meanDilatation", 0.0, ""), Parameter("real[int]", "columnX", lines, ""),
               Parameter("real[int]", "columnY", lines, ""), Parameter("real[int]", "layerThickness", [0.05, 0.1, 0.15, 0.25, 0.45], ""),
               Parameter("int[int]", "layerKind", [0, 0, 1, 0, 0], ""), Parameter("real", "rezoneDepth", 0.5, ""),
               Parameter("real", "amplitude", amplitude, ""), Parameter("real", "bump", bump, "")], ["checks/block_rezone.edp"])  # fmt: skip
    return {name: values[0] for name, values in read_table(folder / "rezone.csv").items()}


def test_nothing_moved_nothing_changes(tmp_path):
    got = rezoned(tmp_path, 0.0, 0.0)
    assert got["lost"] == got["along"] == 0
    assert got["changed"] < 1e-12


def test_the_surface_and_a_field_in_space_are_kept(tmp_path):
    """Displacements along the surface of half an element let go of: heights to 2 %, the field (gradient 3.7) to a part of
    the .2 that it had moved by; both better on a finer grid."""
    coarse, fine = rezoned(tmp_path / "6", 0.06, 0.05), rezoned(tmp_path / "9", 0.06, 0.05, cells=9)
    for got in (coarse, fine):
        assert got["along"] == 0
        assert got["lost"] < 1e-8
    assert coarse["surface"] < 0.02
    assert fine["surface"] < 0.5 * coarse["surface"]
    assert coarse["state"] < 0.02
    assert fine["state"] < coarse["state"]


def test_impacts_rezoned_or_not_are_alike(tmp_path):
    """Three overlapping impacts that need no rezoning, rezoned after every step all the same."""
    loads = [[0.0, 0.0, 4.0, 0.5, 0.4], [0.15, 0.1, 4.0, 0.5, 0.4], [-0.1, 0.1, 4.0, 0.5, 0.4]]
    never, always = (run(tmp_path / name, loads, law=LAW, rezoneBelow=below, **COARSE) for name, below in (("never", "-1e9"), ("always", "1e9")))
    assert never["rezonings"].sum() == 0
    assert (always["rezonings"] > 5).all()
    assert always["peak_force_N"] == pytest.approx(never["peak_force_N"], rel=0.08)
    assert always["depth_mm"] == pytest.approx(never["depth_mm"], rel=0.08)
    tables = [read_table(tmp_path / name / "points-3.csv") for name in ("never", "always")]
    means = []
    for t in tables:
        near = (np.hypot(t["x_mm"], t["y_mm"]) < 0.4) & (t["z_mm"] > -0.33)
        means.append(np.average(t["s_xx"][near] + t["s_yy"][near], weights=t["volume_mm3"][near]))
    assert means[1] == pytest.approx(means[0], rel=0.08)


_CELL = """string outDir = ".";
string statusFile = "status";
real[int] law = {law};
real side = 1.0896;
real depth = 1.362;
int elements = 6;
int layers = 7;
real layerRatio = 1.7172188818690954;
int finiteStrain = 1;
real meanDilatation = 0.9;
real zoneFactor = 1000;
int loadSteps = 6;
real stepBend = 1.25;
int releaseSteps = 1;
int andersonDepth = 10;
real forceTolerance = 1e-2;
real gapTolerance = 1e-4;
int maxIterations = 150;
real nominalSlope = 9270;
real[int] nominal = [{energy}, 0.5, 0.43];
int[int] snapshots = [{count}];
real[int, int] impactLoad({count}, 5);
{rows}include "{model}"
"""


def cell(folder, places, model):
    rows = "".join(f"impactLoad({k}, :) = [{x}, {y}, {ENERGY}, 0.5, 0.43];\n" for k, (x, y) in enumerate(places))
    folder.mkdir()
    path = folder / "driver.edp"
    path.write_text(_CELL.format(law=LAW, energy=ENERGY, count=len(places), rows=rows, model=model))
    run_freefem(path, cwd=folder, log=folder / "log", status=folder / "status")


def test_a_cell_that_stops_without_it_goes_on(tmp_path):
    """Two hits per point on a coarse cell, a law that saturates: without rezoning it stops at the tenth impact."""
    places = np.random.default_rng(1).uniform(0, 1.0896, (14, 2)).tolist()
    cell(tmp_path / "with", places, "cell.edp")
    done = read_table(tmp_path / "with" / "impacts_done.csv")
    assert len(done["impact"]) == 15
    points = read_table(tmp_path / "with" / "points-14.csv")
    assert points["peeq"].max() < 12
    source = (repo_root() / "freefem" / "cell.edp").read_text()
    without, changed = re.subn("rezoneBelow = [0-9.]+", "rezoneBelow = -1e9", source)
    assert changed == 1
    (tmp_path / "never.edp").write_text(without)
    with pytest.raises(NotConverged):
        cell(tmp_path / "without", places, tmp_path / "never.edp")
