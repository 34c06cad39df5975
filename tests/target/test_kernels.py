"""Compiled kernels and script twins: the same numbers for every law, and what a rigid rotation does to a point."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from glue.errors import NotConverged
from glue.solvers import repo_root, run_freefem
from glue.target.driver import Parameter, write_driver
from glue.target.tables import read_table

sys.path.insert(0, str(repo_root() / "freefem" / "checks"))
from kernel import LAWS, random_points, update  # found through the line above

pytestmark = pytest.mark.solver

_SMALL = """
real[int, int] strain(60, 6), s0(60, 19), s1(60, 19);
{ ifstream f("random.txt");
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 6; ++i) f >> strain(k, i);
    for (int i = 0; i < 19; ++i) f >> s0(k, i);
  } }
int failed = updatePointsSmall(law, strain, s0, s1);
{ ofstream f("out.csv"); f.precision(17); f << "v" << endl;
  for (int k = 0; k < 60; ++k) for (int i = 0; i < 19; ++i) f << s1(k, i) << endl; }
{ ofstream f("status"); f << "ok" << endl << failed << endl; }
"""


def equal(script: np.ndarray, kernel: np.ndarray) -> bool:
    """To 1e-10 of the largest entry of each column."""
    assert np.isfinite(kernel).all()
    return bool((np.abs(script - kernel) <= 1e-10 * np.maximum(np.abs(kernel).max(axis=0), 1e-3)).all())


@pytest.mark.parametrize("law", LAWS)
def test_axisymmetric_kernel_and_script_agree(law, tmp_path):
    """Random states and increments, elastic and plastic alike: state, stress and all 25 moduli."""
    points = random_points(11, 60, LAWS[law])
    kernel, script = (update(tmp_path / flavour, LAWS[law], points, flavour) for flavour in ("kernel", "script"))
    grown = kernel[0][:, 4] > points[:, 14]
    assert 20 < grown.sum() < 60
    for a, b in zip(script, kernel, strict=True):
        assert equal(a, b)
    if LAWS[law][14] != 0:
        assert (kernel[0][grown, 13] > points[grown, 23]).all()


def small_points(law: list[float]) -> np.ndarray:
    """60 rows of a strain increment (6) and a state (19) in three dimensions, backstresses deviatoric."""
    rng = np.random.default_rng(12)
    state = np.hstack([rng.normal(0, 100, (60, 6)), rng.uniform(0, 0.2, (60, 1)), rng.normal(0, 40, (60, 12))])
    for o, size in ((7, law[7]), (13, law[9])):
        state[:, o : o + 3] -= state[:, o : o + 3].mean(axis=1, keepdims=True)
        state[:, o : o + 6] *= size != 0
    return np.hstack([rng.normal(0, 1, (60, 6)) * rng.choice([1e-4, 1e-2], (60, 1)), state])


def update_small(folder, law: list[float], rows: np.ndarray, flavour: str = "kernel") -> np.ndarray:
    folder.mkdir()
    np.savetxt(folder / "random.txt", rows, "%.17g")
    head = write_driver("twins", [Parameter("real[int]", "law", [float(v) for v in law], "MPa")],
                        [f"points_small_{flavour}.idp"])  # fmt: skip
    (folder / "driver.edp").write_text(head + _SMALL)
    run_freefem(folder / "driver.edp", cwd=folder, log=folder / "log", status=folder / "status")
    assert (folder / "status").read_text().split()[1] == "0"
    return read_table(folder / "out.csv")["v"].reshape(60, 19)


@pytest.mark.parametrize("law", LAWS)
def test_small_strain_kernel_and_script_agree(law, tmp_path):
    rows = small_points(LAWS[law])
    rows[0] = 0.0  # a virgin point at rest
    kernel, script = (update_small(tmp_path / flavour, LAWS[law], rows, flavour) for flavour in ("kernel", "script"))
    assert 20 < (kernel[:, 6] > rows[:, 12]).sum() < 60
    assert equal(script, kernel)


@pytest.mark.parametrize("flavour", ["kernel", "script"])
def test_small_strain_knows_no_rate_and_no_heat(flavour, tmp_path):
    rows = small_points(LAWS["Johnson-Cook"])
    with_them = update_small(tmp_path / "with", LAWS["Johnson-Cook, rate and heat"], rows, flavour)
    np.testing.assert_array_equal(with_them, update_small(tmp_path / "without", LAWS["Johnson-Cook"], rows, flavour))


@pytest.mark.parametrize("flavour", ["kernel", "script"])
def test_a_rigid_rotation_turns_stress_and_backstress_and_nothing_else(flavour, tmp_path):
    """.4 rad in one step, from rest and from an already turned state: sigma' = Q sigma Q^T, no plastic strain."""
    angle, law = 0.4, LAWS["all terms"]
    rows = random_points(2, 2, law)
    rows[:, 10:14] *= 0.3
    rows[:, 14] = 1.0
    for row, start in zip(rows, (0.0, 0.3), strict=True):
        turned = [[np.cos(t) - 1, np.sin(t), -np.sin(t), np.cos(t) - 1, 0.0] for t in (start, start + angle)]
        row[:10] = np.ravel(turned)
    state, _, _ = update(tmp_path / "points", law, rows, flavour)
    q = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    for new, old in zip(state, rows[:, 10:], strict=True):
        assert (new[4], new[13]) == (old[4], old[13])
        for o in (0, 5, 9):
            turned = q @ np.array([[old[o], old[o + 3]], [old[o + 3], old[o + 1]]]) @ q.T
            assert new[o : o + 4] == pytest.approx([turned[0, 0], turned[1, 1], old[o + 2], turned[0, 1]], abs=1e-10)


def test_a_law_array_of_an_earlier_version_stays_valid(tmp_path):
    """11 numbers, as before tables, caps, rates and heat: missing entries are 0."""
    points = random_points(3, 20, LAWS["combined"])
    new, old = (update(tmp_path / str(n), LAWS["combined"][:n], points)[0] for n in (19, 11))
    np.testing.assert_array_equal(new, old)


def test_a_point_turned_inside_out_fails_the_step(tmp_path):
    rows = np.zeros((1, 24))
    rows[0, 8] = -1.2
    with pytest.raises(NotConverged, match="1 points without a root"):
        update(tmp_path / "points", LAWS["Johnson-Cook"], rows)
