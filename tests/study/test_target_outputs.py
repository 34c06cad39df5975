"""Fields, own surface and patches of the target in the run directory: from FreeFEM to files that pyvista opens."""

from __future__ import annotations

import csv
import dataclasses

import numpy as np
import pytest
from flow_runs import dimple as stand_in

from glue.errors import SolverFailed
from glue.flow.impacts import COLUMNS
from glue.scene.catalogue import material
from glue.scene.model import Choice
from glue.scene.reader import example_path, read_scene
from glue.study import stages, target_stage
from glue.study.stage import Work
from glue.study.target_outputs import write_outputs
from glue.study.target_patches import mean_profile
from glue.target import cell
from glue.target.contact import ContactNumerics, solve_contact
from glue.target.tables import read_table

RADIUS = 0.227e-3


def nominal():
    """The dimple of the reference impact, as far as cell and block ask for it."""
    return dataclasses.replace(stand_in(), radius_m=RADIUS, depth_m=52.4e-6, peak_force_N=261.0, speed_m_s=60.0,
                               diameter_m=1e-3, density_kg_m3=7800.0)  # fmt: skip


def log(x_m, y_m, speed_m_s=60.0) -> np.ndarray:
    impacts = np.zeros(len(x_m), COLUMNS)
    impacts["impact_id"], impacts["time_s"] = np.arange(len(x_m)), 1e-3 * np.arange(len(x_m))
    impacts["x_m"], impacts["y_m"], impacts["vz_in_m_s"], impacts["nz"] = x_m, y_m, -speed_m_s, 1.0
    impacts["diameter_m"], impacts["density_kg_m3"] = 1e-3, 7800.0
    return impacts


def columns(path) -> dict[str, np.ndarray]:
    with open(path) as f:
        rows = list(csv.DictReader(f))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def open_fields(path):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.read(path)
    volume = np.abs(mesh.compute_cell_sizes(length=False, area=False)["Volume"])
    return mesh, volume, mesh.cell_centers().points[:, 2]


@pytest.mark.solver
def test_two_patches_of_a_window_are_two_cells_and_their_mean(tmp_path, monkeypatch):
    """Two impacts in the left tile, one in the right; stopped in the second, the first is not run again."""
    scene = read_scene(example_path("al2024-s390"), preset="fast")
    side = scene.accuracy.cell_side_in_radii * RADIUS
    scene = dataclasses.replace(
        scene, models=dataclasses.replace(scene.models, target=Choice("cell", "test")),
        target=dataclasses.replace(scene.target, window_m=(2.0 * side, 1.0 * side), thickness_m=None),
        accuracy=dataclasses.replace(scene.accuracy, target_patches=2),
    )  # fmt: skip
    impacts = log([-0.5 * side, 0.4 * side, -0.3 * side], [0.0, 0.1 * side, 0.1 * side])
    monkeypatch.setattr(target_stage, "load_impacts", lambda path, scene: impacts)
    monkeypatch.setattr(target_stage, "load_dimple", lambda path: nominal())
    told = []
    work = Work(scene, tmp_path, tmp_path / "scene.toml", lambda share, text="": told.append((share, text)))
    real, ran = cell.run_freefem, []

    def once(driver, **options):
        ran.append(driver.parent.name)
        if len(ran) == 2:
            raise SolverFailed("killed")
        return real(driver, **options)

    monkeypatch.setattr(cell, "run_freefem", once)
    with pytest.raises(SolverFailed):
        stages.target_stage(work)
    metrics, files = stages.target_stage(work)
    assert ran == ["patch-1", "patch-2", "patch-2"]
    assert {f"target/patch-{k}/{name}" for k in (1, 2) for name in ("driver.edp", "fields.vtu", "surface.npz")} < set(files)
    assert told[-1][0] == 1.0 and told[-1][1].startswith("patch 2 of 2")

    target, profile = metrics["target"], columns(tmp_path / "stress_profile.csv")
    assert (target["patches"], target["impacts"]) == (2, 3)
    assert target["exposure"] == pytest.approx(target["window_exposure"])  # the two patches are the window
    assert target["surface_side_m"] == pytest.approx(side) and "whole window" in target["surface_remark"]
    assert metrics["residual_stress"]["max_compressive_std_patches_Pa"] > 1e6
    tops = []
    for k, centre in ((1, 0.5 * side), (2, -0.5 * side)):  # by exposure: the right tile first
        mesh, volume, z = open_fields(tmp_path / f"target/patch-{k}/fields.vtu")
        assert mesh.n_cells == 6 * 6 * 6 * 7
        assert volume.sum() == pytest.approx(side**2 * 6 * RADIUS, rel=1e-5)
        assert all(np.isfinite(mesh[name]).all() for name in ("stress_Pa", "peeq", "displacement_m"))
        assert mesh.points[:, 0].mean() == pytest.approx(centre, abs=0.02 * side)
        top = z > -0.1 * RADIUS
        tops.append(np.average(mesh["stress_Pa"][top, 0], weights=volume[top]))
        with np.load(tmp_path / f"target/patch-{k}/surface.npz") as surface:
            lowest = np.unravel_index(surface["z_m"].argmin(), surface["z_m"].shape)
            x, y = surface["x_m"][lowest[1]], surface["y_m"][lowest[0]]
            here = mesh.points[:, 2] == 0.0
            assert mesh["displacement_m"][here, 2].min() == pytest.approx(surface["z_m"].min(), rel=0.3)  # vertices only
        near = np.hypot(impacts["x_m"] - x, impacts["y_m"] - y).min()
        assert near < 0.6 * side / 6
        assert (tmp_path / f"target/patch-{k}/fields.vtu").stat().st_size < 200_000
    assert profile["sigma_xx_Pa"][0] == pytest.approx(np.mean(tops), rel=1e-4)
    assert profile["sigma_xx_std_patches_Pa"][0] == pytest.approx(np.std(tops, ddof=1), rel=1e-3)


@pytest.mark.solver
def test_fields_and_surface_of_a_block(tmp_path, monkeypatch):
    """One impact: the file's layers are the Gauss points' own, the surface lies in the window's coordinates."""
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    numerics = ContactNumerics(side_in_radii=4.2, elements_per_radius=1.5, load_steps=6)
    window = 2 * (4.2 * RADIUS,)
    result = solve_contact(material("al2024-t351"), log([30e-6], [0.0]), nominal(), window, tmp_path, numerics=numerics)[-1]
    rough, names = write_outputs(tmp_path, result)
    assert names == ["fields.vtu", "surface.npz"]
    mesh, volume, z = open_fields(tmp_path / "fields.vtu")
    points = read_table(tmp_path / "points-1.csv")
    assert 4 * mesh.n_cells == points["z_mm"].size
    top = -1e3 * z < 0.1145 * RADIUS * 1e3
    inside = -points["z_mm"] < 0.1145 * RADIUS * 1e3
    expected = 1e6 * np.average(points["s_xx"][inside], weights=points["volume_mm3"][inside])
    assert np.average(mesh["stress_Pa"][top, 0], weights=volume[top]) == pytest.approx(expected, rel=1e-4)
    with np.load(tmp_path / "surface.npz") as surface:
        lowest = np.unravel_index(surface["z_m"].argmin(), surface["z_m"].shape)
        assert surface["x_m"][lowest[1]] == pytest.approx(30e-6, abs=0.3 * RADIUS)
        assert surface["z_m"].min() == pytest.approx(result.surface_z_m.min(), rel=0.1)
        assert np.ptp(surface["x_m"]) == pytest.approx(result.measured_side_m)
    assert 0 < rough["Sa_m"] < rough["Sq_m"] < rough["Sz_m"] < 1.5 * 52.4e-6 and rough["Ssk"] is not None


def test_mean_and_scatter_of_patches():
    """Two patches at -100 and -140 MPa: mean -120, standard deviation 40/sqrt(2); one patch has no scatter."""
    one = {name: np.array([-100e6, 0.0]) for name in ("depth_m", "sigma_xx_Pa", "sigma_yy_Pa")}
    one |= {"peeq": np.array([0.2, 0.0]), "sigma_xx_std_Pa": np.array([3e6, 0.0]), "peeq_std": np.full(2, np.nan)}
    other = one | {"sigma_xx_Pa": np.array([-140e6, 0.0]), "sigma_yy_Pa": np.array([-140e6, 0.0]), "sigma_xx_std_Pa": np.array([4e6, 0.0])}
    profile, scatter = mean_profile([one, other])
    assert profile["sigma_xx_Pa"].tolist() == [-120e6, 0.0]
    assert profile["sigma_xx_std_patches_Pa"] == pytest.approx([40e6 / np.sqrt(2), 0.0])
    assert profile["sigma_xx_std_Pa"][0] == pytest.approx(np.sqrt(12.5) * 1e6)
    assert profile["peeq_std_patches"].tolist() == [0.0, 0.0] and "peeq_std" not in profile
    assert scatter["max_compressive_std_patches_Pa"] == pytest.approx(40e6 / np.sqrt(2))
    assert scatter["scatter_patches"] == pytest.approx(1 / (3 * np.sqrt(2)))
    profile, scatter = mean_profile([one])
    assert scatter == {} and not any("patches" in name for name in profile)
