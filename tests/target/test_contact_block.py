"""The block under spheres: patch test, Hertz, the reference impact, a killed run that goes on, and what is refused."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from glue.errors import NotConverged
from glue.solvers import plugin_dir, repo_root, run_freefem
from glue.solvers.blas import blas_environment
from glue.target.driver import Parameter
from glue.target.tables import read_table

sys.path.insert(0, str(repo_root() / "freefem" / "checks"))
from driving import run_check  # found through the line above

pytestmark = pytest.mark.solver

REFERENCE = (repo_root() / "freefem" / "reference_contact.edp").read_text()
ENERGY = 7.3513268  # mJ: 1 mm, 7800 kg/m3, 60 m/s
COARSE = {  # .12 mm: 12 thousand unknowns, seconds an impact
    "columnX": "[-1.92, -0.96, -0.48, -0.36, -0.24, -0.12, 0, 0.12, 0.24, 0.36, 0.48, 0.96, 1.92]",
    "layerThickness": "[0.06, 0.1, 0.17, 0.25, 0.6, 1.4]",
    "layerKind": "[0, 0, 1, 0, 0, 0]",
    "contactBox": "[-0.5, 0.5, -0.5, 0.5]",
    "contactRim": "0.06",
    "loadSteps": "6",
}




def columns(spacing: float, even: int, outer: tuple[int, ...]) -> str:
    """Grid lines: ``even`` cells on each side of 0, then wider ones."""
    right = np.r_[spacing * np.arange(1, even + 1), even * spacing + spacing * np.cumsum(outer)]
    return str(np.r_[-right[::-1], 0.0, right].tolist())


def driver(folder: Path, loads: list[list[float]], **changes: str) -> Path:
    """reference_contact.edp with other parameters and impacts, in ``folder``."""
    text = REFERENCE[: REFERENCE.index("real[int, int] impactLoad")]
    for name, value in {"snapshots": f"[{len(loads)}]", **changes}.items():
        text, count = re.subn(rf"( {name} = )[^;]+;", rf"\g<1>{value};", text)
        assert count == 1, name
    rows = "".join(f"impactLoad({k}, :) = [{', '.join(map(str, row))}];\n" for k, row in enumerate(loads))
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "driver.edp"
    path.write_text(f'{text}real[int, int] impactLoad({len(loads)}, 5);\n{rows}include "contact.edp"\n')
    return path


def run(folder: Path, loads: list[list[float]], **changes: str) -> dict[str, np.ndarray]:
    path = driver(folder, loads, **changes)
    run_freefem(path, cwd=folder, log=folder / "log", status=folder / "status")
    return read_table(folder / "impacts_done.csv")


@pytest.mark.parametrize("share", [0.0, 0.9, 1.0])
def test_patch_and_factor_on_a_mesh_with_transitions(share, tmp_path):
    """A conforming mesh keeps a homogeneous strain; the factor belongs to the forces, to single precision."""
    lines = [-1.0, -0.5, -0.3, -0.1, 0.0, 0.2, 0.3, 0.5, 1.0]
    run_check(tmp_path, "block as a solid",
              [Parameter("real[int]", "law", [73100.0, 0.33, 1e6, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], ""),
               Parameter("real", "meanDilatation", share, ""), Parameter("real[int]", "columnX", lines, ""),
               Parameter("real[int]", "columnY", lines, ""), Parameter("real[int]", "layerThickness", [0.1, 0.2, 0.2, 0.3, 0.5], ""),
               Parameter("int[int]", "layerKind", [0, 1, 0, 1, 0], "")], ["checks/block_solid.edp"])  # fmt: skip
    got = {name: values[0] for name, values in read_table(tmp_path / "solid.csv").items()}
    assert got["patch"] < 1e-12
    assert got["spread"] < 1e-11
    assert abs(got["volume"]) < 1e-12
    assert got["rest"] < 1e-7  # strains of 1e-8: what is left is of second order
    assert got["factor"] < 2e-3


def test_elastic_contact_against_hertz(tmp_path):
    """A 40 mm sphere on a target that never yields: F = 4/3 E' R^.5 d^1.5, energy .4 F d, e = 1.

    Six grid spacings in the contact's radius, a block that ends nine of those radii off: at a clamped face the far
    field F/(pi E' r) stops, 5 % of the approach at the sides and 8 % at the bottom; at a given energy the force then
    grows by three fifths of that, the approach shrinks by as much.
    """
    modulus, R, a = 73100 / (1 - 0.33**2), 20.0, 0.42
    d = a**2 / R
    force = 4 / 3 * modulus * R**0.5 * d**1.5
    got = run(tmp_path, [[0.0, 0.0, 0.4 * force * d, R, 0.6]], law="[73100, 0.33, 1e6, 0, 1, 0, 0, 0, 0, 0, 0]",
              slopeOverRadius=str(force / d / R), columnX=columns(0.07, 10, (3, 6, 14, 24)), contactBox="[-0.72, 0.72, -0.72, 0.72]",
              layerThickness="[0.07, 0.1, 0.16, 0.3, 0.5, 0.8, 1.6]", layerKind="[0, 0, 1, 0, 1, 0, 0]", gapTolerance="5e-6")  # fmt: skip
    assert 1.02 < got["peak_force_N"][0] / force < 1.08
    assert 0.94 < got["penetration_mm"][0] / d < 0.98
    assert got["contact_radius_mm"][0] == pytest.approx(a, abs=0.035)  # one node either way
    assert got["restitution"][0] == pytest.approx(1.0, abs=0.02)
    assert abs(got["depth_mm"][0]) < 0.01 * d  # nothing is left


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Two reference impacts at one place on the .07 mm grid, Johnson-Cook: the folder."""
    folder = tmp_path_factory.mktemp("reference")
    run(folder, [[0.0, 0.0, ENERGY, 0.5, 0.43], [0.0, 0.0, ENERGY, 0.5, 0.43]])
    return folder


def test_reference_impact_once_and_again(reference):
    """Against the axisymmetric solver at a/24 and a/12: peak 262.8 and 358.9 N, e .338 and .428, second depth 72.2 um."""
    got = read_table(reference / "impacts_done.csv")
    assert got["peak_force_N"] == pytest.approx([262.8, 358.9], rel=0.015)
    assert got["restitution"] == pytest.approx([0.338, 0.428], abs=0.02)
    assert got["work_mJ"] == pytest.approx([ENERGY] * 2, rel=0.005)
    assert (got["contact_radius_mm"] < 0.9 * got["reach_mm"]).all()
    assert got["depth_mm"][1] == pytest.approx(0.0722, rel=0.05)
    surface = read_table(reference / "surface-2.csv")
    r, z = np.hypot(surface["x_mm"] + surface["u_x"], surface["y_mm"] + surface["u_y"]), surface["u_z"]
    ring = (r > 0.2) & (r < 0.32)
    roots = np.roots(np.polyfit(r[ring], z[ring], 3))
    radius = [x.real for x in roots if 0.2 < x.real < 0.32 and abs(x.imag) < 1e-9][0]
    assert radius == pytest.approx(0.2627, rel=0.015)


def test_a_killed_run_goes_on_with_the_same_numbers(tmp_path):
    """Killed after its second impact; history and stresses to rounding as of a run that was left alone."""
    loads = [[0.0, 0.0, 1.0, 0.5, 0.3], [0.15, 0.1, 0.6, 0.5, 0.3], [-0.1, 0.1, 1.2, 0.4, 0.3], [0.0, -0.1, 0.8, 0.5, 0.3]]
    law = "[73100, 0.33, 270, 0, 1, 80, 12, 130, 300, 60, 12]"
    alone = run(tmp_path / "alone", loads, law=law, snapshots="[1, 4]", **COARSE)
    folder = tmp_path / "killed"
    path = driver(folder, loads, law=law, checkpointFile='"checkpoint"', snapshots="[1, 4]", **COARSE)
    root = repo_root()
    env = {**os.environ, "FF_LOADPATH": f"{plugin_dir()};/usr/lib/freefem++",
           "FF_INCLUDEPATH": f"{root / 'freefem'};{root / 'freefem' / 'lib'}",
           "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **blas_environment()}  # as run_freefem: others round otherwise  # fmt: skip
    process = subprocess.Popen(["FreeFem++", "-nw", "-ne", "-v", "0", str(path)], cwd=folder, env=env,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    try:
        first = None
        for _ in range(1200):
            time.sleep(0.05)
            assert process.poll() is None, "it ended before it could be killed"
            file = folder / "checkpoint"
            if file.exists():
                first = first or file.stat().st_mtime_ns
                if file.stat().st_mtime_ns != first:
                    break
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert not (folder / "status").exists()
    run_freefem(path, cwd=folder, log=folder / "log", status=folder / "status")
    assert read_table(folder / "result.csv")["continued_from"][0] in (2, 3)
    got = read_table(folder / "impacts_done.csv")
    for name in set(alone) - {"wall_s", "unbalanced_N"}:
        np.testing.assert_allclose(got[name], alone[name], rtol=1e-9, err_msg=name)
    for name, after in (("s_xx", 4), ("s_zz", 4), ("peeq", 4), ("peeq", 1)):  # one snapshot from before it was killed
        one, other = (read_table(f / f"points-{after}.csv")[name] for f in (folder, tmp_path / "alone"))
        assert np.abs(one - other).max() < 1e-7 * np.abs(one).max()


def test_a_checkpoint_of_other_inputs_is_refused(tmp_path):
    run(tmp_path, [[0.0, 0.0, 0.3, 0.5, 0.3]], checkpointFile='"checkpoint"', **COARSE)
    with pytest.raises(NotConverged, match="belongs to other inputs"):
        run(tmp_path, [[0.0, 0.0, 0.4, 0.5, 0.3]], checkpointFile='"checkpoint"', **COARSE)


def test_candidates_that_are_too_near_are_widened(tmp_path):
    """Half the reach that the contact needs: found, done again farther out, the same numbers as with enough."""
    short, enough = (run(tmp_path / str(reach), [[0.0, 0.0, 3.0, 0.5, reach]], **COARSE) for reach in (0.16, 0.3125))
    assert short["reach_mm"][0] > 0.16
    assert short["contact_radius_mm"][0] < 0.9 * short["reach_mm"][0]
    assert short["peak_force_N"][0] == pytest.approx(enough["peak_force_N"][0], rel=0.01)


def test_contact_at_the_edge_of_the_contact_nodes_is_refused(tmp_path):
    with pytest.raises(NotConverged, match="edge of the block's contact nodes"):
        run(tmp_path, [[0.4, 0.0, 3.0, 0.5, 0.4]], **COARSE)


def test_steps_that_cannot_converge_are_refused(tmp_path):
    with pytest.raises(NotConverged, match="does not converge"):
        run(tmp_path, [[0.0, 0.0, 3.0, 0.5, 0.4]], **(COARSE | {"maxIterations": "2"}))


def test_the_compliance_of_another_block_is_refused(tmp_path):
    """As many nodes, another Poisson's ratio; its own is read, and changes nothing."""
    keep = {"complianceFile": '"compliance.bin"'} | COARSE
    first = run(tmp_path, [[0.0, 0.0, 0.3, 0.5, 0.3]], **keep)
    again = run(tmp_path, [[0.0, 0.0, 0.3, 0.5, 0.3]], **keep)
    assert again["peak_force_N"][0] == pytest.approx(first["peak_force_N"][0], rel=1e-6)
    with pytest.raises(NotConverged, match="another block's"):
        run(tmp_path, [[0.0, 0.0, 0.3, 0.5, 0.3]], law="[73100, 0.2, 369, 684, 0.73, 0, 0, 0, 0, 0, 0]", **keep)
