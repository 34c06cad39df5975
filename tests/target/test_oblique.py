"""Oblique impacts: measuring a known dent, refusals, and FreeFEM against Hertz, momentum and energy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError, NotConverged
from glue.scene.catalogue import material
from glue.scene.model import JohnsonCook
from glue.solvers import run_freefem
from glue.target.driver import Parameter, law_table, write_driver
from glue.target.oblique import ObliqueNumerics, Throw, measure_dimple, solve_oblique
from glue.target.tables import read_table
from glue.theory import hertz

AL2024 = material("al2024-t351")
STEEL = 7800.0
HARD = JohnsonCook(1e15, 0.0, 1.0)  # cannot yield


def dent(step: float):
    """Nodes ``step`` apart of half a surface with an elliptic dent and a ridge around it, smooth as real ones are.

    z = depth (t - 1) exp(-c t), t = ((x - .4)/1.3)^2 + (y/.9)^2, c = 1, depth .2: the contour of height 0 is t = 1.
    """
    x, y = np.meshgrid(np.arange(-4.0, 5.0, step), np.arange(0.0, 4.0, step))
    x, y = x.ravel(), y.ravel()
    t = ((x - 0.4) / 1.3) ** 2 + (y / 0.9) ** 2
    return x, y, 0.2 * (t - 1.0) * np.exp(-t)


def test_size_of_a_known_dent():
    """Volume pi a b depth (1/c - (1 - exp -c)/c^2), ridge depth exp(-c - 1)/c at t = 1 + 1/c."""
    got = measure_dimple(*dent(0.12))
    assert got["length"] == pytest.approx(2.6, rel=0.01)
    assert got["width"] == pytest.approx(1.8, rel=0.01)
    assert got["front"] == pytest.approx(1.7, rel=0.01)
    assert got["area"] == pytest.approx(math.pi * 1.3 * 0.9, rel=0.01)
    assert got["depth"] == pytest.approx(0.2, rel=0.002)
    assert got["volume"] == pytest.approx(math.pi * 1.3 * 0.9 * 0.2 * math.exp(-1.0), rel=0.01)
    assert got["pile_front"] == pytest.approx(0.2 * math.exp(-2.0), rel=0.01)


def test_a_surface_without_a_dent_is_refused():
    x, y, z = dent(0.2)
    with pytest.raises(NotConverged, match="no dimple with an edge"):
        measure_dimple(x, y, z - 1.0)


def test_all_bad_throws_are_named_at_once():
    throws = [Throw(60.0, 5.0), Throw(-1.0, 45.0), Throw(60.0, 45.0, friction=2.0)]
    with pytest.raises(InputError) as caught:
        solve_oblique(AL2024, AL2024.combined, throws, density_kg_m3=STEEL)
    text = str(caught.value)
    assert all(word in text for word in ("angle_deg = 5", "speed_m_s = -1", "friction = 2", "backstresses"))


def test_a_throw_splits_into_its_components():
    throw = Throw(60.0, 30.0)
    assert throw.normal_m_s == pytest.approx(30.0)
    assert math.hypot(throw.normal_m_s, throw.tangential_m_s) == pytest.approx(60.0)
    assert Throw(60.0, 90.0).tangential_m_s == 0.0


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PEEN_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


_POINTS = """
int n = 200;
real[int, int] h0(n, 9), h1(n, 9), s0(n, 19), s1(n, 19), P(n, 9);
{ ifstream f("in.txt"); for (int k = 0; k < n; ++k) { for (int i = 0; i < 9; ++i) f >> h0(k, i);
  for (int i = 0; i < 9; ++i) f >> h1(k, i); for (int i = 0; i < 7; ++i) f >> s0(k, i); } }
for (int k = 0; k < n; ++k) for (int i = 7; i < 19; ++i) s0(k, i) = 0;
int failed = updatePointsFinite(true, law, h0, h1, s0, s1, P);
{ ofstream f("out.csv"); f.precision(17); f << "v" << endl;
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < 7; ++i) f << s1(k, i) << endl;
    for (int i = 0; i < 9; ++i) f << P(k, i) << endl; } }
{ ofstream f("status"); f << "ok" << endl << failed << endl; }
"""


@pytest.mark.solver
def test_finite_strain_points_against_the_same_formulas_in_numpy(tmp_path):
    """Elastic points under random finite gradients: rotation by matrix inverse (Cayley), Piola stress by F^-T."""
    rng = np.random.default_rng(4)
    h0, h1 = rng.uniform(-0.2, 0.2, (2, 200, 3, 3))
    s0 = rng.uniform(-100.0, 100.0, (200, 7))
    s0[:, 6] = 0.1
    np.savetxt(tmp_path / "in.txt", np.hstack([h0.reshape(-1, 9), h1.reshape(-1, 9), s0]), fmt="%.17g")
    (tmp_path / "points.edp").write_text(_POINTS)
    driver = tmp_path / "driver.edp"
    law = Parameter("real[int]", "law", law_table(AL2024.E_Pa, AL2024.nu, HARD), "")
    includes = ["points_small_kernel.idp", "points_finite_small.idp", str(tmp_path / "points.edp")]
    driver.write_text(write_driver("points", [law], includes))
    run_freefem(driver, cwd=tmp_path, log=tmp_path / "log", status=tmp_path / "status")
    got = read_table(tmp_path / "out.csv")["v"].reshape(200, 16)
    one, mu = np.eye(3), AL2024.E_Pa * 1e-6 / 2 / (1 + AL2024.nu)
    lam = 2 * mu * AL2024.nu / (1 - 2 * AL2024.nu)
    place = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
    for k in range(200):
        h = (h1[k] - h0[k]) @ np.linalg.inv(one + 0.5 * (h0[k] + h1[k]))
        strain, spin = 0.5 * (h + h.T), 0.5 * (h - h.T)
        Q = np.linalg.solve(one - 0.5 * spin, one + 0.5 * spin)
        sigma = np.zeros((3, 3))
        for i, (a, b) in enumerate(place):
            sigma[a, b] = sigma[b, a] = s0[k, i]
        sigma = Q @ sigma @ Q.T + 2 * mu * strain + lam * np.trace(strain) * one
        F = one + h1[k]
        piola = np.linalg.det(F) * sigma @ np.linalg.inv(F).T
        scale = np.abs(piola).max()
        assert got[k, :6] == pytest.approx([sigma[p] for p in place], abs=1e-10 * scale)
        assert got[k, 7:] == pytest.approx(piola.ravel(), abs=1e-10 * scale)
        assert got[k, 6] == 0.1


@pytest.mark.solver
def test_elastic_oblique_impact_is_hertz_and_keeps_its_tangential_speed(cache):
    """Frictionless and elastic: e = 1, tangential speed kept, force of Hertz; limits those of a mesh of a/3."""
    throws = [Throw(3.0, 90.0), Throw(3.0 * math.sqrt(2.0), 45.0)]
    straight, oblique = solve_oblique(AL2024, HARD, throws, density_kg_m3=STEEL, measure=False)
    exact = hertz.impact(1.0, STEEL, 3.0, hertz.effective_modulus_Pa(AL2024.E_Pa, AL2024.nu))
    for run in (straight, oblique):
        assert run.restitution == pytest.approx(1.0, abs=0.01)
        assert run.peak_force * 1e6 == pytest.approx(exact.force_N, rel=0.05)
        assert run.duration == pytest.approx(exact.contact_time_s, rel=0.05)
        assert run.energy_error < 0.005
    assert oblique.tangential_out_m_s == pytest.approx(3.0, rel=1e-3)
    assert oblique.peak_force == pytest.approx(straight.peak_force, rel=0.02)


@pytest.mark.solver
def test_a_dent_deflects_the_shot_that_slides_in_it(cache):
    """Without friction the crater's wall ahead lifts the shot (more rebound), brakes it, and is pushed on (longer)."""
    coarse = ObliqueNumerics(elements_per_radius=2, shells=3, steps_per_contact=20.0)
    throws = [Throw(30.0, 90.0), Throw(60.0, 30.0)]
    straight, oblique = solve_oblique(AL2024, AL2024.johnson_cook, throws, density_kg_m3=STEEL, numerics=coarse)
    assert straight.tangential_out_m_s == pytest.approx(0.0, abs=0.01 * 30.0)
    assert straight.length == pytest.approx(straight.width, rel=0.05)  # round
    assert oblique.restitution > 1.2 * straight.restitution
    assert 0.8 * throws[1].tangential_m_s < oblique.tangential_out_m_s < 0.97 * throws[1].tangential_m_s
    assert oblique.area > 1.05 * straight.area
    assert oblique.length > 1.05 * oblique.width
    assert max(straight.energy_error, oblique.energy_error) < 0.02
