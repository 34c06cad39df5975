"""The block's kernel against the axisymmetric kernel and the script twin, under rotation, and against its own factor."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from glue.errors import NotConverged
from glue.solvers import repo_root
from glue.target.driver import Parameter
from glue.target.tables import read_table

sys.path.insert(0, str(repo_root() / "freefem" / "checks"))
from driving import run_check  # found through the line above
from kernel import LAWS, random_points, update

pytestmark = pytest.mark.solver

ISOTHERMAL = [name for name, law in LAWS.items() if law[12] == 0 and law[14] == 0]
CORNER = np.array([[0.1, 0, 0], [1, 0.2, 0], [0.3, 1.1, 0.1], [0.2, 0.3, 0.9]])  # of checks/block_points.edp
EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def update_block(folder, law, rows, share=0.0):
    """Rows (n, 37) of gradients old, new (9 each) and state (19) -> new states (n, 19), first Piola stress (n, 3, 3).

    Under a constant stress P the force of a mid-edge node is volume P (grad l_i + grad l_j), that of a vertex 0.
    """
    folder.mkdir(parents=True, exist_ok=True)
    np.savetxt(folder / "points.txt", rows, "%.17g")
    run_check(folder, "points of the block",
              [Parameter("real[int]", "law", [float(v) for v in law], ""), Parameter("real", "share", float(share), ""),
               Parameter("int", "points", len(rows), "")], ["checks/block_points.edp"])  # fmt: skip
    new = read_table(folder / "new.csv")["value"].reshape(len(rows), 49)
    edges = CORNER[1:] - CORNER[0]
    volume = np.linalg.det(edges) / 6.0
    gradient = np.linalg.inv(edges).T
    gradient = np.vstack([-gradient.sum(axis=0), gradient])
    force = new[:, 19:].reshape(-1, 10, 3)
    assert np.abs(force[:, :4]).max() < 1e-9 * max(np.abs(force).max(), 1e-3)
    shape = volume * np.array([gradient[i] + gradient[j] for i, j in EDGES])  # (6, 3)
    stress = np.einsum("nki,kj->nij", force[:, 4:], np.linalg.pinv(shape).T)
    return new[:, :19], stress


def spatial(points):
    """Axisymmetric rows (n, 24) as rows of update_block: r, t, z become x, y, z."""
    rows = np.zeros((len(points), 37))
    for o, column in ((0, 0), (9, 5)):  # rr rz zr zz tt -> xx xz zx zz yy
        rows[:, [o, o + 2, o + 6, o + 8, o + 4]] = points[:, column : column + 5]
    for start, source in ((18, 10), (25, 15), (31, 19)):  # rr zz tt rz -> xx zz yy zx
        rows[:, [start, start + 2, start + 1, start + 5]] = points[:, source : source + 4]
    rows[:, 24] = points[:, 14]
    return rows


@pytest.mark.parametrize("law", ISOTHERMAL)
def test_axisymmetric_states_come_out_as_from_the_axisymmetric_kernel(law, tmp_path):
    points = random_points(31, 60, LAWS[law])
    flat, piola, _ = update(tmp_path / "axisymmetric", LAWS[law], points, step=0.0)
    solid, stress = update_block(tmp_path / "solid", LAWS[law], spatial(points))
    assert 20 < (flat[:, 4] > points[:, 14]).sum() < 60
    again = spatial(np.hstack([points[:, :10], flat]))[:, 18:]
    assert np.abs(solid - again).max() < 1e-10 * np.abs(again).max()
    expected = np.zeros((60, 3, 3))
    expected[:, [0, 0, 2, 2, 1], [0, 2, 0, 2, 1]] = piola
    assert np.abs(stress - expected).max() < 1e-10 * np.abs(expected).max()


def rotation(axis, angle):
    a = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def tensor(t):
    return np.array([[t[0], t[3], t[5]], [t[3], t[1], t[4]], [t[5], t[4], t[2]]])


@pytest.mark.parametrize("degrees", [30, 120])
def test_a_rigid_rotation_turns_stress_and_backstresses_and_no_more(degrees, tmp_path):
    """A point strained and loaded along no axis, then turned about no axis in one step."""
    law = LAWS["combined"]
    strain = np.array([[0.04, 0.05, -0.02], [-0.03, -0.06, 0.01], [0.03, 0.02, 0.03]])
    row = np.zeros((1, 37))
    row[0, 9:18] = strain.ravel()
    before, _ = update_block(tmp_path / "strained", law, row)
    Q = rotation([1, 2, -0.5], np.radians(degrees))
    row = np.hstack([strain.reshape(1, 9), (Q @ (np.eye(3) + strain) - np.eye(3)).reshape(1, 9), before])
    after, _ = update_block(tmp_path / "turned", law, row)
    assert after[0, 6] == pytest.approx(before[0, 6], rel=1e-12)
    assert before[0, 6] > 0.02
    for o in (0, 7, 13):
        turned = Q @ tensor(before[0, o : o + 6]) @ Q.T
        assert np.abs(tensor(after[0, o : o + 6]) - turned).max() < 1e-11 * np.abs(before[0, :6]).max()


@pytest.mark.parametrize("share", [0.0, 0.9, 1.0])
def test_a_state_evaluated_again_stays_as_it_is(share, tmp_path):
    """What a continued run rests on: no strain, no change.  And a homogeneous strain has one pressure, K ln(det F)."""
    law = LAWS["combined"]
    rows = np.zeros((1, 37))
    rows[0, 9:18] = [0.02, 0.05, 0.01, -0.03, -0.04, 0.0, 0.02, 0.01, 0.03]
    first, stress = update_block(tmp_path / "first", law, rows, share)
    again, same = update_block(tmp_path / "again", law, np.hstack([rows[:, 9:18], rows[:, 9:18], first]), share)
    assert np.abs(again - first).max() < 1e-11 * np.abs(first).max()
    assert np.abs(same - stress).max() < 1e-11 * np.abs(stress).max()
    bulk = law[0] / (3 * (1 - 2 * law[1]))
    pressure = bulk * np.log(np.linalg.det(np.eye(3) + rows[0, 9:18].reshape(3, 3)))
    assert first[0, :3].mean() == pytest.approx(pressure, rel=1e-9 if share > 0 else 0.01)


def test_a_point_turned_inside_out_fails_the_step(tmp_path):
    row = np.zeros((1, 37))
    row[0, 17] = -1.2
    with pytest.raises(NotConverged, match="points without a root"):
        update_block(tmp_path, LAWS["Johnson-Cook"], row)


_TWIN = """
load "Element_QF"
real[int, int] H0(60, 9), H1(60, 9), s0(60, 19), s1(60, 19), P(60, 9);
{ ifstream f("random.txt");
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 9; ++i) f >> H0(k, i);
    for (int i = 0; i < 9; ++i) f >> H1(k, i);
    for (int i = 0; i < 19; ++i) f >> s0(k, i);
  } }
s1 = 0; P = 0;
int failed = updatePointsFinite(true, law, H0, H1, s0, s1, P);
{ ofstream f(outDir + "/twin.csv"); f.precision(17); f << "value" << endl;
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 19; ++i) f << s1(k, i) << endl;
    for (int i = 0; i < 9; ++i) f << P(k, i) << endl;
  } }
{ ofstream f(statusFile); if (failed == 0) f << "ok" << endl; else f << "failed: " << failed << endl; }
"""


@pytest.mark.parametrize("law", ["Johnson-Cook", "table", "Voce"])
def test_general_states_come_out_as_from_the_script(law, tmp_path):
    """points_finite_small.idp, whose laws have no backstress."""
    rng = np.random.default_rng(5)
    old = rng.normal(0, 0.05, (60, 9))
    rows = np.hstack([old, old + rng.normal(0, 1, (60, 9)) * rng.choice([1e-3, 2e-2], (60, 1)), rng.normal(0, 100, (60, 6)),
                      rng.uniform(0, 0.2, (60, 1)), np.zeros((60, 12))])  # fmt: skip
    np.savetxt(tmp_path / "random.txt", rows, "%.17g")
    (tmp_path / "twin.edp").write_text(_TWIN)
    include = str(tmp_path / "twin.edp")
    run_check(tmp_path, "twin", [Parameter("real[int]", "law", [float(v) for v in LAWS[law]], "")],
              ["points_small_script.idp", "points_finite_small.idp", include])  # fmt: skip
    twin = read_table(tmp_path / "twin.csv")["value"].reshape(60, 28)
    state, stress = update_block(tmp_path / "kernel", LAWS[law], rows)
    assert 20 < (state[:, 6] > rows[:, 24]).sum() < 60
    assert np.abs(state - twin[:, :19]).max() < 1e-10 * np.abs(state).max()
    assert np.abs(stress.reshape(60, 9) - twin[:, 19:]).max() < 1e-10 * np.abs(stress).max()
