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
from glue.solvers import repo_root
from glue.target.cell import solve_cell
from glue.target.dimple import solve_dimple, to_si
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


@pytest.mark.parametrize(
    ("law", "speed"),
    [(AL2024.johnson_cook, 1.0), (AL2024.johnson_cook, 300.0), (JohnsonCook(300e6, 0, 1), 60.0), (JohnsonCook(50e6, 0, 1), 60.0),
     (JohnsonCook(2500e6, 0, 1), 60.0), (AL2024.combined, 60.0)],
    ids=["1 m/s", "300 m/s", "perfectly plastic", "very soft", "very hard", "combined law"],
)  # fmt: skip
def test_extremes_run_and_balance(law, speed):
    """No failed step (the very soft target has one halved, near its start), energy balanced (checked by the solver's
    reader), a dimple with an edge, e inside (0, 1)."""
    impact = solve_reduced(AL2024, law, speed_m_s=speed, density_kg_m3=7800.0, elements_per_radius=3)
    d = to_si(impact, speed, 7800.0, 1e-3, (0.5, 0.25), 0.0)
    assert impact.failures <= (1 if law.flow_stress_Pa(0.0) < 100e6 else 0)
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
    """Penetration of the nominal impact: the steps of balanced and of reference against many more, within 2 %."""
    scene = read_scene(example_path("al2024-s390"), preset="fast")
    side = scene.accuracy.cell_side_in_radii * nominal.radius_m
    penetration = {}
    for steps in (3, 6, 24):
        accuracy = replace(scene.accuracy, cell_load_steps=steps, cell_force_tolerance=1e-3)
        other = replace(scene, accuracy=accuracy, target=replace(scene.target, window_m=(1.01 * side, 1.01 * side)))
        solve_cell(other, impacts([0.0], [0.0]), nominal, tmp_path / str(steps))
        penetration[steps] = read_table(tmp_path / str(steps) / "impacts_done.csv")["penetration_mm"][0]
    off = {steps: abs(penetration[steps] / penetration[24] - 1.0) for steps in (3, 6)}
    assert max(off.values()) < 0.02


def test_a_cell_that_cannot_converge_is_refused(scene, nominal, tmp_path, monkeypatch):
    monkeypatch.setattr("glue.target.cell._MAX_ITERATIONS", 2)
    scene = replace(scene, target=replace(scene.target, window_m=(1e-3, 1e-3)))
    with pytest.raises(NotConverged, match="no equilibrium|does not converge") as caught:
        solve_cell(scene, impacts([0.0], [0.0]), nominal, tmp_path / "c")
    assert caught.value.exit_code == 4
    assert "freefem.log" in str(caught.value)
