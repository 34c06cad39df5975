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
real[int, int] grad(60, 10), a0(60, 14), a1(60, 14), out(60, 30);
{ ifstream f("random.txt");
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 10; ++i) f >> grad(k, i);
    for (int i = 0; i < 14; ++i) f >> a0(k, i);
  } }
out = 0;
int failed = updatePoints(law, 0., grad, a0, a1, out);
{ ofstream f("out.csv"); f.precision(17); f << "v" << endl;
  for (int k = 0; k < 60; ++k) {
    for (int i = 0; i < 14; ++i) f << a1(k, i) << endl;
    for (int i = 0; i < 30; ++i) f << out(k, i) << endl;
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
        rows = np.hstack([old, old + rng.normal(0, 1, (60, 5)) * size, random_states(rng, 4), np.zeros((60, 1))])
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


@pytest.mark.parametrize("flavour", ["kernel", "script"])
def test_a_rigid_rotation_turns_stress_and_backstress_and_nothing_else(tmp_path, flavour):
    """.4 rad in one step, from rest and from an already turned state: sigma' = Q sigma Q^T, no plastic strain."""
    before, angle = np.array([0.0, 0.3]), 0.4
    state = random_states(np.random.default_rng(2), 4)[:2] * np.r_[[0.3] * 4, 1.0, [0.3] * 8]
    state = np.hstack([state, [[0.0], [40.0]]])  # temperature: a rotation leaves it as it is
    rows = []
    for start, values in zip(before, state, strict=True):
        grads = [np.array([np.cos(t) - 1, np.sin(t), -np.sin(t), np.cos(t) - 1, 0.0]) for t in (start, start + angle)]
        rows.append(np.r_[grads[0], grads[1], values])
    np.savetxt(tmp_path / "random.txt", rows, "%.17g")
    table = law_table(AL2024.E_Pa, AL2024.nu, AL2024.combined)
    head = write_driver("rotation", [Parameter("real[int]", "law", table, "MPa")], [f"points_axisym_{flavour}.idp"])
    (tmp_path / "driver.edp").write_text(head + _TWINS["axisym"].replace("60", "2"))
    run_freefem(tmp_path / "driver.edp", cwd=tmp_path, log=tmp_path / "log", status=tmp_path / "status")
    got = read_table(tmp_path / "out.csv")["v"].reshape(2, 44)[:, :14]
    q = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    for new, old in zip(got, state, strict=True):
        assert (new[4], new[13]) == (old[4], old[13])
        for o in (0, 5, 9):
            turned = q @ np.array([[old[o], old[o + 3]], [old[o + 3], old[o + 1]]]) @ q.T
            assert new[o : o + 4] == pytest.approx([turned[0, 0], turned[1, 1], old[o + 2], turned[0, 1]], abs=1e-10)


@pytest.mark.parametrize(
    ("law", "speed"),
    [(AL2024.johnson_cook, 1.0), (AL2024.johnson_cook, 300.0), (JohnsonCook(300e6, 0, 1), 60.0), (JohnsonCook(50e6, 0, 1), 60.0),
     (JohnsonCook(2500e6, 0, 1), 60.0), (AL2024.combined, 60.0)],
    ids=["1 m/s", "300 m/s", "perfectly plastic", "very soft", "very hard", "combined law"],
)  # fmt: skip
def test_extremes_run_and_balance(law, speed):
    """No failed step, energy balanced (checked by the solver's reader), a dimple with an edge, e inside (0, 1)."""
    impact = solve_reduced(AL2024, law, speed_m_s=speed, density_kg_m3=7800.0, elements_per_radius=3)
    d = to_si(impact, speed, 7800.0, 1e-3, (0.5, 0.25), 0.0)
    assert impact.failures == 0
    assert 0.0 < d.restitution < 1.0
    assert 0.0 < d.depth_m < d.radius_m < 0.5e-3
    # Energy lost is work done on the target: no more than force times depth, no less than a third of it.
    lost = 0.5 * 7800 * np.pi / 6 * 1e-9 * speed**2 * (1 - d.restitution**2)
    assert 0.33 < lost / (d.peak_force_N * d.depth_m) < 1.0


def test_one_solution_serves_every_diameter(tmp_path):
    """Solved in units of the shot, so only the conversion is under test: radius as D, force as D^2, e as it is."""
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


def test_a_damaged_cache_entry_is_made_again(tmp_path, monkeypatch):
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path))
    law = JohnsonCook(2500e6, 0, 1)
    inputs = {"speed_m_s": 60.0, "density_kg_m3": 7800.0, "elements_per_radius": 3}
    first = solve_reduced(AL2024, law, **inputs)
    points = first.log.with_name("points.csv")
    points.write_text(points.read_text()[:5000])
    again = solve_reduced(AL2024, law, **inputs)
    np.testing.assert_array_equal(again.points["s_rr"], first.points["s_rr"])


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
    mean = 0.5 * (first.sigma_xx_Pa + first.sigma_yy_Pa)
    assert mean.min() < -100e6
    assert abs(mean[-1]) < 0.02 * abs(mean.min())  # the floor of the cell is far enough
    assert mean.max() < 0.01 * abs(mean.min())  # clamped sideways: a layer never pulls after compressive dents
    assert abs(first.nominal_depth_error) < 0.15
    np.testing.assert_array_equal(first.sigma_xx_Pa, again.sigma_xx_Pa)
    done = read_table(tmp_path / "a" / "impacts_done.csv")
    assert done["energy_mJ"][1:] == pytest.approx([7.351, 3.267, 7.351], rel=1e-3)


def test_full_coverage_against_another_code(nominal, tmp_path):
    """Layer means at four hits per point against an independent spectral solver's, two seeds of it, same law.

    Its values at 40, 80, 150, 300 um: -334, -357, -349, -313 MPa.  A P2 cell of this size was found 8 % off in rms
    over these depths, seeds of either scatter by 1-4 %: 12 % together.
    """
    scene = read_scene(example_path("al2024-s390"), preset="balanced")
    rng = np.random.default_rng(1)
    count = rng.poisson(4.0 * 16e-6 / (np.pi * nominal.radius_m**2))
    log = impacts(rng.uniform(-2e-3, 2e-3, count), rng.uniform(-2e-3, 2e-3, count))
    cell = solve_cell(scene, log, nominal, tmp_path)
    mean = 0.5 * (cell.sigma_xx_Pa + cell.sigma_yy_Pa)
    got = np.interp(np.array([40, 80, 150, 300]) * 1e-6, cell.depth_m, mean)
    off = got / np.array([-334e6, -357e6, -349e6, -313e6]) - 1.0
    print("deviation at 40, 80, 150, 300 um:", off)
    assert np.sqrt(np.mean(off**2)) < 0.12
    assert cell.patch.exposure == pytest.approx(4.0, rel=0.15)
    assert cell.coverage_peeq > 0.98


def test_few_load_steps_against_many(nominal, tmp_path):
    """Penetration of the nominal impact: the steps of balanced against four times as many, within 2 %."""
    scene = read_scene(example_path("al2024-s390"), preset="fast")
    side = scene.accuracy.cell_side_in_radii * nominal.radius_m
    penetration = {}
    for steps in (3, 6, 24):
        accuracy = replace(scene.accuracy, cell_load_steps=steps, cell_force_tolerance=1e-3)
        other = replace(scene, accuracy=accuracy, target=replace(scene.target, window_m=(1.01 * side, 1.01 * side)))
        solve_cell(other, impacts([0.0], [0.0]), nominal, tmp_path / str(steps))
        penetration[steps] = read_table(tmp_path / str(steps) / "impacts_done.csv")["penetration_mm"][0]
    off = {steps: abs(penetration[steps] / penetration[24] - 1.0) for steps in (3, 6)}
    assert off[6] < 0.02
    assert off[6] < off[3] < 0.05


def test_a_cell_that_cannot_converge_is_refused(scene, nominal, tmp_path, monkeypatch):
    monkeypatch.setattr("glue.target.cell._MAX_ITERATIONS", 2)
    scene = replace(scene, target=replace(scene.target, window_m=(1e-3, 1e-3)))
    with pytest.raises(NotConverged, match="does not converge") as caught:
        solve_cell(scene, impacts([0.0], [0.0]), nominal, tmp_path / "c")
    assert caught.value.exit_code == 4
    assert "freefem.log" in str(caught.value)
