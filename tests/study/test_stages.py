"""What single stages report, on impacts and dimples made by hand."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.impacts import COLUMNS
from glue.scene.reader import example_path, read_scene
from glue.study import coverage_stage, flow_stage, stages, target_patches, target_stage
from glue.study.check import check
from glue.study.check_text import check_text
from glue.study.stage import Work

RADIUS = 0.5e-3


@pytest.fixture
def work(tmp_path, monkeypatch):
    """work(rows of (time_s, x_m), restitution): default scene (3 s, window 4 x 4 mm), dimples of .5 mm."""

    def make(rows, restitution=0.34):
        impacts = np.zeros(len(rows), COLUMNS)
        impacts["time_s"], impacts["x_m"] = np.array(rows, dtype=float).reshape(-1, 2).T
        impacts["vz_in_m_s"], impacts["diameter_m"] = -60.0, 1e-3
        impacts["density_kg_m3"], impacts["nz"] = 7800.0, 1.0
        dimple = SimpleNamespace(
            radius_m=RADIUS, contact_time_s=2e-6, diameter_m=1e-3, density_kg_m3=7800.0, speed_m_s=60.0,
            restitution=restitution, restitution_exponent=0.25,
            radius_for=lambda d, v, rho: RADIUS * np.asarray(d) / 1e-3,
            beyond_table=lambda d, v, rho: np.asarray(v) < 1.0,
        )  # fmt: skip
        for module in (stages, coverage_stage, flow_stage, target_stage):
            monkeypatch.setattr(module, "load_impacts", lambda path, scene: impacts, raising=False)
            monkeypatch.setattr(module, "load_dimple", lambda path: dimple)
        scene = read_scene(example_path("al2024-s390"))
        return Work(scene, tmp_path, tmp_path / "scene.toml", lambda fraction, text="": None)

    return make


def test_coverage_of_two_impacts(work, tmp_path):
    # one disc inside the window, a second in the same place, a third outside that reaches half-way in
    metrics, files = stages.coverage_stage(work([(0.5, 0.0), (1.0, 0.0), (2.0, 0.002 + 1e-9)]))
    found = metrics["coverage"]
    disc, window = math.pi * RADIUS**2, 16e-6
    assert found["impacts_in_window"] == 2
    assert found["final"] == pytest.approx(1.5 * disc / window, rel=0.01)  # 20 points to the radius
    assert found["time_98_s"] is None and "longer exposure_time_s" in found["time_98_s_reason"]
    # (2.1) with two impacts on the window in the exposure: lambda = 2 disc / window
    hits = 2 * disc / window
    assert found["avrami_final"] == pytest.approx(1 - math.exp(-hits), rel=1e-12)
    assert found["avrami_time_98_s"] == pytest.approx(3.0 * -math.log(0.02) / hits, rel=1e-12)
    # (2.2): .01667 kg/s of 4.084e-6 kg shots (7800 kg/m3, 1 mm) for 3 s on a jet of 20 mm
    shots = 0.01667 * 3.0 / (7800 * math.pi / 6 * 1e-9)
    assert found["avrami_mass_flow_final"] == pytest.approx(
        1 - math.exp(-shots * disc / (math.pi * 0.01**2)), rel=1e-12
    )
    by_mass = 3.0 * math.log(50) * math.pi * 0.01**2 / (shots * disc)
    assert found["avrami_mass_flow_time_98_s"] == pytest.approx(by_mass, rel=1e-9)
    assert found["avrami_undisturbed_time_98_s"] == pytest.approx(by_mass, rel=1e-9)  # these two met no other
    assert files == ["coverage.csv"]
    lines = (tmp_path / "coverage.csv").read_text().splitlines()
    assert lines[0] == "time_s,coverage,avrami" and lines[1] == "0,0,0"
    curve = np.loadtxt(lines[1:], delimiter=",")
    assert curve[-1, 0] == 3.0 and curve[-1, 1] == found["final"]
    assert curve[np.searchsorted(curve[:, 0], 0.49), 1] == 0.0 < curve[np.searchsorted(curve[:, 0], 0.51), 1]


def test_full_coverage_is_timed_by_the_impact_that_completes_it(work, tmp_path):
    job = work([(0.25, 0.0), (1.75, 0.0)])
    wide = job.scene.target.window_m
    stages.load_dimple(None).radius_for = lambda d, v, rho: np.array([1e-4, max(wide)]) if np.ndim(d) else 1e-4
    found = stages.coverage_stage(job)[0]["coverage"]
    assert (found["final"], found["time_98_s"]) == (1.0, 1.75)
    assert 1.75 in np.loadtxt(tmp_path / "coverage.csv", delimiter=",", skiprows=1)[:, 0]


def test_no_impact_at_all_is_null_with_a_reason(work):
    found = stages.coverage_stage(work([]))[0]["coverage"]
    assert found["final"] == 0.0 and found["impacts_in_window"] == 0
    times_98 = ("time_98_s", "avrami_time_98_s", "avrami_mass_flow_time_98_s", "avrami_undisturbed_time_98_s")
    for key in (*times_98, "avrami_final", "avrami_mass_flow_final", "peeq_final"):
        assert found[key] is None and found[f"{key}_reason"]


@pytest.mark.parametrize("restitution", [0.0, 1.0, math.nan])
def test_a_rebound_that_the_flow_cannot_have_is_told(work, restitution):
    with pytest.raises(InputError, match="write a number into the scene"):
        stages.flow_stage(work([], restitution))


def test_values_that_are_not_finite_become_null_with_a_reason():
    assert stages.plain({"a": np.float64(1.5), "b": math.inf, "c": None, "d": "x", "e": np.int64(3)}) == {
        "a": 1.5, "b": None, "b_reason": "came out as inf", "c": None, "d": "x", "e": 3,
    }  # fmt: skip


def test_a_target_that_nothing_strikes_is_null_with_reasons(work, tmp_path, monkeypatch):
    """Beside the window, and in its rim outside the cells: no solver is started, and the report goes on."""
    monkeypatch.setattr(target_stage, "ready_kernels", lambda: pytest.fail("nothing to solve"))
    for rows in ([], [(0.5, 0.0021)], [(0.5, 0.0019)]):  # window 4 x 4 mm, one cell of 4.8 x .5 = 2.4 mm
        metrics, files = stages.target_stage(work(rows))
        assert files == [] and metrics["target"]["impacts"] == 0
        for section, key in (("residual_stress", "surface_Pa"), ("coverage", "peeq_final"), ("target", "exposure")):
            assert metrics[section][key] is None and "no impact" in metrics[section][f"{key}_reason"]
    drawn = []
    monkeypatch.setattr("glue.report.page.write_report", lambda path, scene, complete: drawn.append(complete) or [])
    job = dataclasses.replace(work([]), complete=frozenset({"dimple", "flow", "target"}))
    stages.report_stage(job)
    (tmp_path / "stress_profile.csv").write_text("")
    stages.report_stage(job)
    assert drawn == [{"dimple", "flow"}, {"dimple", "flow", "target"}]


def test_an_unpeened_target_reports_what_a_peened_one_does(work, monkeypatch):
    layers = {name: np.linspace(-3.0, 1.0, 5) for name in ("sigma_xx_Pa", "sigma_yy_Pa", "sigma_xx_std_Pa")}
    layers |= {name: np.ones(5) for name in ("sigma_yy_std_Pa", "peeq", "peeq_std")}
    patch = SimpleNamespace(exposure=1.0, window_exposure=1.0, neglected_energy_share=0.0)
    rough = {"Sa_m": 1e-6, "Sq_m": 1e-6, "Sz_m": 1e-6, "Ssk": 0.0, "surface_side_m": 1e-3, "surface_remark": ""}
    cell = SimpleNamespace(
        depth_m=np.linspace(0.5e-4, 4.5e-4, 5), **layers, patch=patch, impacts=1, coverage_peeq=0.5,
        coverage_peeq_027=0.5, edge_threshold=0.1, balance_error=0.0, nominal_depth_error=0.0, nominal_force_error=0.0, dofs=9, wall_s=1.0,
        floor_m=1e-3, unresolved_impacts=0, unresolved_energy_share=0.0,
    )  # fmt: skip
    monkeypatch.setattr(target_stage, "ready_kernels", lambda: None)
    monkeypatch.setattr(target_stage, "cell_patches", lambda *args: [patch])
    monkeypatch.setattr(target_stage, "solve_patch", lambda *args, resume: cell)
    monkeypatch.setattr(target_patches, "write_outputs", lambda folder, result: (rough, ["fields.vtu"]))
    peened, files = stages.target_stage(work([(0.5, 0.0)]))
    unpeened, _ = stages.target_stage(work([]))
    assert files == ["stress_profile.csv", "target/driver.edp", "target/fields.vtu"]

    def keys(metrics):
        return {s: {k for k in v if not k.endswith("_reason") and k != "warning"} for s, v in metrics.items()}

    assert keys(unpeened) == keys(peened)


def test_check_warns_of_a_cell_that_hardly_anything_strikes():
    scene = read_scene(example_path("al2024-s390"))
    enough = check(scene)
    # impacts per area of the footprint (all shots over pi/4 W^2 at 90 degrees) times the cell of 4.8 radii
    side = 4.8 * enough["dimple_radius_estimate_m"]
    wanted = scene.expected_shots / scene.nozzle.footprint_area_m2 * side**2
    assert enough["expected_impacts_in_cell"] == pytest.approx(wanted, rel=1e-12)
    assert enough["warnings"] == []
    few = dataclasses.replace(scene, exposure_time_s=scene.exposure_time_s * 4.9 / wanted)
    assert "only 4.9 impacts are expected in the target's cell" in check(few)["warnings"][0]
    assert "warning " in check_text(few) and "warning " not in check_text(scene)
