"""FreeFEM really runs: exact checks, twins, extremes, and refusals of what went wrong."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers import impacts

from glue.errors import NotConverged
from glue.scene.catalogue import material
from glue.scene.model import JohnsonCook
from glue.scene.reader import example_path, read_scene
from glue.solvers import repo_root, run_freefem
from glue.target.cell import solve_cell
from glue.target.dimple import solve_dimple, to_si
from glue.target.driver import Parameter, law_table, write_driver
from glue.target.reduced_impact import solve_reduced
from glue.target.tables import read_table

pytestmark = pytest.mark.solver
AL2024 = material("al2024-t351")


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory):
    """A cache of this module's own: nothing may come from an earlier run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PEEN_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def test_checks_against_exact_solutions(tmp_path):
    """freefem/checks/run.py: uniaxial cycle, Hill's sphere, Hertz, reference impact."""
    done = subprocess.run(
        [sys.executable, repo_root() / "freefem/checks/run.py"], capture_output=True, text=True, cwd=tmp_path
    )
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    passed, of = done.stdout.splitlines()[-1].split()[0].split("/")
    assert passed == of
    assert int(of) >= 20


_TWINS = {
    "small": """
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
""",
    "axisym": """
real[int, int] grad(60, 10), a0(60, 13), a1(60, 13), out(60, 20);
{ ifstream f("random.txt");
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 10; ++i) f >> grad(k, i);
    for (int i = 0; i < 13; ++i) f >> a0(k, i);
  } }
out = 0;
int failed = updatePoints(law, grad, a0, a1, out);
{ ofstream f("out.csv"); f.precision(17); f << "v" << endl;
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 13; ++i) f << a1(k, i) << endl;
    for (int i = 0; i < 20; ++i) f << out(k, i) << endl;
  } }
{ ofstream f("status"); f << "ok" << endl << failed << endl; }
""",
}


def random_states(rng, n: int) -> np.ndarray:
    """60 states (sigma, p, a1, a2) of tensors with ``n`` entries, backstresses deviatoric."""
    state = np.column_stack(
        [rng.normal(0, 100, (60, n)), rng.uniform(0, 0.2, 60), rng.normal(0, 40, (60, 2 * n))]
    )
    for o in (n + 1, 2 * n + 1):
        state[:, o : o + 3] -= state[:, o : o + 3].mean(axis=1, keepdims=True)
    return state


@pytest.mark.parametrize("law", ["johnson_cook", "combined"])
@pytest.mark.parametrize("kind", _TWINS)
def test_compiled_kernels_equal_their_script_twins(tmp_path, kind, law):
    """Random states and increments, elastic and plastic alike: the same numbers to rounding."""
    rng = np.random.default_rng(11)
    size = rng.choice([1e-4, 1e-2], (60, 1))
    if kind == "small":
        rows = np.hstack([rng.normal(0, 1, (60, 6)) * size, random_states(rng, 6)])
    else:
        old = rng.normal(0, 0.1, (60, 5))
        rows = np.hstack([old, old + rng.normal(0, 1, (60, 5)) * size, random_states(rng, 4)])
    results = {}
    for flavour in ("kernel", "script"):
        folder = tmp_path / flavour
        folder.mkdir()
        np.savetxt(folder / "random.txt", rows, "%.17g")
        table = law_table(AL2024.E_Pa, AL2024.nu, getattr(AL2024, law))
        head = write_driver(
            "twins", [Parameter("real[int]", "law", table, "MPa")], [f"points_{kind}_{flavour}.idp"]
        )
        (folder / "driver.edp").write_text(head + _TWINS[kind])
        run_freefem(folder / "driver.edp", cwd=folder, log=folder / "log", status=folder / "status")
        assert (folder / "status").read_text().split()[1] == "0"
        results[flavour] = read_table(folder / "out.csv")["v"]
    kernel, script = results["kernel"], results["script"]
    assert np.abs(kernel).max() > 100
    assert script == pytest.approx(kernel, rel=1e-9, abs=1e-9 * np.abs(kernel).max())


@pytest.mark.parametrize(
    ("law", "speed"),
    [(AL2024.johnson_cook, 1.0), (AL2024.johnson_cook, 300.0), (JohnsonCook(300e6, 0, 1), 60.0), (JohnsonCook(50e6, 0, 1), 60.0),
     (JohnsonCook(2500e6, 0, 1), 60.0), (AL2024.combined, 60.0)],
    ids=["1 m/s", "300 m/s", "perfectly plastic", "very soft", "very hard", "combined law"],
)  # fmt: skip
def test_extremes_run_and_balance(law, speed):
    """No failed step, energy balanced (checked by the solver's reader), a dimple with an edge, e inside (0, 1)."""
    impact = solve_reduced(AL2024, law, speed_m_s=speed, density_kg_m3=7800.0, elements_per_radius=3)
    d = to_si(impact, speed, 7800.0, 1e-3, 0.5, 0.0)
    assert impact.failures == 0
    assert 0.0 < d.restitution < 1.0
    assert 0.0 < d.depth_m < d.radius_m < 0.5e-3
    # Energy lost is work done on the target: no more than force times depth, no less than a third of it.
    lost = 0.5 * 7800 * np.pi / 6 * 1e-9 * speed**2 * (1 - d.restitution**2)
    assert 0.33 < lost / (d.peak_force_N * d.depth_m) < 1.0


def test_a_dimple_scales_exactly_with_the_diameter(tmp_path):
    small, large = (
        solve_dimple(
            AL2024,
            speed_m_s=60.0,
            density_kg_m3=7800.0,
            diameter_m=d,
            elements_per_radius=3,
            workdir=tmp_path,
        )
        for d in (0.05e-3, 5e-3)
    )
    assert large.radius_m / small.radius_m == pytest.approx(100.0, rel=1e-12)
    assert large.peak_force_N / small.peak_force_N == pytest.approx(1e4, rel=1e-12)
    assert (large.restitution, large.speed_exponent) == (small.restitution, small.speed_exponent)
    assert (tmp_path / "impact.edp").exists() and (tmp_path / "impact.log").exists()


@pytest.fixture(scope="module")
def scene():
    return read_scene(example_path("al2024-s390"), preset="fast")


@pytest.fixture(scope="module")
def nominal(scene, tmp_path_factory):
    return solve_dimple(scene.target.material, speed_m_s=60.0, density_kg_m3=7800.0, diameter_m=1e-3,
                        elements_per_radius=3, workdir=tmp_path_factory.mktemp("dimple"))  # fmt: skip


def test_cell_under_three_impacts(scene, nominal, tmp_path):
    """Forces balance, every impact spends its energy, the stress is compressive; twice the same numbers."""
    side = scene.accuracy.cell_side_in_radii * nominal.radius_m
    window = (1.05 * side, 1.05 * side)
    scene = replace(scene, target=replace(scene.target, window_m=window))
    log = impacts([0.0, 0.3 * side, -0.2 * side], [0.0, 0.1 * side, 0.3 * side], [60.0, 40.0, 60.0])
    shares = []
    first = solve_cell(scene, log, nominal, tmp_path / "a", lambda share, text: shares.append(share))
    again = solve_cell(scene, log, nominal, tmp_path / "b")
    assert first.impacts == 3
    assert shares[-1] == 1.0
    assert first.balance_error < 0.02
    assert first.work_error < 0.0101
    mean = 0.5 * (first.sigma_xx_Pa + first.sigma_yy_Pa)
    assert mean.min() < -100e6
    assert abs(mean[-1]) < 0.02 * abs(mean.min())  # the floor of the cell is far enough
    # The exact identity of a clamped periodic cell: a layer never pulls after compressive dents.
    assert mean.max() < 0.01 * abs(mean.min())
    assert abs(first.nominal_depth_error) < 0.15
    np.testing.assert_array_equal(first.sigma_xx_Pa, again.sigma_xx_Pa)
    done = read_table(tmp_path / "a" / "impacts_done.csv")
    assert done["energy_mJ"][1:] == pytest.approx([7.351, 3.267, 7.351], rel=1e-3)


def test_a_cell_that_cannot_converge_is_refused(scene, nominal, tmp_path, monkeypatch):
    monkeypatch.setattr("glue.target.cell._MAX_ITERATIONS", 2)
    scene = replace(scene, target=replace(scene.target, window_m=(1e-3, 1e-3)))
    with pytest.raises(NotConverged, match="does not converge") as caught:
        solve_cell(scene, impacts([0.0], [0.0]), nominal, tmp_path / "c")
    assert caught.value.exit_code == 4
    assert "freefem.log" in str(caught.value)
