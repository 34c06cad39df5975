"""Block, driver and checks of the contact model without FreeFEM; and one small run from impacts to layer means."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import dimple, impacts

from glue.errors import InputError, NotConverged
from glue.scene.catalogue import material
from glue.solvers import compile_freefem
from glue.target.block import make_block, refuse_too_large
from glue.target.contact import ContactNumerics, contact_driver, solve_contact
from glue.target.contact_result import ContactResult, check
from glue.target.driver import law_table
from glue.target.patch import Patch, contact_radii_m

GOLDEN = Path(__file__).parents[1] / "golden" / "contact.edp"
AL2024 = material("al2024-t351")


def patch() -> Patch:
    place = np.array([0.3e-3, 0.5e-3])
    return Patch(place, place[::-1], np.array([7.35e-3, 3.1e-3]), np.array([0.5e-3, 0.4e-3]), (0.0, 0.0), 0.3, 0.3, 0, 0.0)


def golden_text() -> str:
    law = law_table(AL2024.E_Pa, AL2024.nu, AL2024.combined)
    block = make_block(0.227, 0.8, 2.0)
    return contact_driver("golden", law, ContactNumerics(finite_strain=True), dimple(), block, patch(), np.array([0.43e-3, 0.33e-3]))


def test_golden_driver():
    """A driver changes only on purpose: PEEN_UPDATE_GOLDEN=1 pytest tests/target rewrites it."""
    if os.environ.get("PEEN_UPDATE_GOLDEN") == "1":
        GOLDEN.write_text(golden_text())
    assert golden_text() == GOLDEN.read_text()


@pytest.mark.solver
def test_golden_driver_compiles(tmp_path):
    driver = tmp_path / "driver.edp"
    driver.write_text(GOLDEN.read_text())
    compile_freefem(driver)


@pytest.mark.parametrize(("side", "elements"), [(0.3, 3.24), (1.0, 3.24), (1.6, 2.0), (0.05, 1.0)])
def test_grid_lines_rise_can_be_halved_and_hold_the_contact(side, elements):
    block = make_block(0.227, side, elements)
    assert (np.diff(block.columns) > 0).all()
    assert (len(block.columns) - 1) % 2 ** block.coarser.sum() == 0
    assert block.columns == pytest.approx(-block.columns[::-1])
    assert block.contact_half >= 0.5 * side + 1.5 * 0.227
    even = np.diff(block.columns)[abs(block.columns[:-1] + 0.5 * block.spacing) < block.contact_half - block.spacing]
    assert even == pytest.approx(block.spacing)


def test_a_block_scales_with_the_dimple():
    small, large = make_block(0.1, 0.5, 3.0), make_block(1.0, 5.0, 3.0)
    assert large.columns == pytest.approx(10 * small.columns)
    assert large.bounds == pytest.approx(10 * small.bounds)
    assert large.unknowns == small.unknowns


def test_a_block_beyond_the_memory_is_refused_and_told_what_fits():
    block = make_block(0.227, 1.6, 3.24)
    with pytest.raises(InputError, match=r"GB; allowed: 1\.5 GB\. a patch of [\d.]+ mm would fit"):
        refuse_too_large(0.227, block, 3.24, 1.5)
    with pytest.raises(InputError, match="no patch fits"):
        refuse_too_large(0.227, block, 3.24, 0.1)
    refuse_too_large(0.227, block, 3.24, 8.0)


def test_a_window_without_room_to_measure_is_refused(tmp_path):
    with pytest.raises(InputError, match="leaves no square"):
        solve_contact(AL2024, impacts([0.0], [0.0]), dimple(), (0.5e-3, 2e-3), tmp_path)


@pytest.mark.parametrize(("count", "finite", "asked"), [(4, 1, None), (14, 0, None), (14, 1, True), (4, 0, False)])
def test_strain_is_finite_up_to_an_exposure_or_as_asked(count, finite, asked, tmp_path, monkeypatch):
    """4 dimples of .162 mm2 on .9 mm2: exposure .71; 14: 2.5."""
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("glue.target.contact.run_freefem", lambda *args, **more: (_ for _ in ()).throw(InterruptedError))
    along = np.linspace(-0.4e-3, 0.4e-3, count)
    numerics = ContactNumerics(side_in_radii=4.2, elements_per_radius=1.5, finite_strain=asked)
    with pytest.raises(InterruptedError):
        solve_contact(AL2024, impacts(along, along, [60.0] * count, [1e-3] * count), dimple(), (1e-3, 1e-3), tmp_path / "run",
                      numerics=numerics)  # fmt: skip
    assert f"int finiteStrain = {finite};" in (tmp_path / "run" / "driver.edp").read_text()


def test_expected_radii():
    """The nominal impact its own; 16 times the energy twice the radius; at one speed proportional to the shot."""
    place = np.zeros(3)
    nominal = 0.5 * 7800 * np.pi / 6 * 1e-9 * 60**2
    p = patch()._replace(x_m=place, y_m=place, energy_J=nominal * np.array([1.0, 16.0, 0.125]), radius_m=0.5e-3 * np.array([1.0, 1.0, 0.5]))
    assert contact_radii_m(p, dimple()) == pytest.approx(227e-6 * np.array([1.0, 2.0, 0.5]))


def sound() -> ContactResult:
    layer, history = np.zeros(2), {"impact": [0.0, 1.0], "energy_mJ": [7.0, 7.0], "work_mJ": [7.0, 7.01], "back_mJ": [0.8, 0.8],
                                   "work_inside_mJ": [6.1, 6.1], "unbalanced_N": [0.5, 0.5], "peak_force_N": [260.0, 260.0]}  # fmt: skip
    return ContactResult(layer, layer, layer, layer, layer, layer, layer, 0.01, layer, layer, layer,
                         {k: np.array(v) for k, v in history.items()}, patch(), 1e-3, 1e-3, 2, True, 10, 1.0, 1.0)  # fmt: skip


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [("work_mJ", 7.2, "impact 1: work off"), ("work_inside_mJ", 5.0, "impact 1: work of the internal forces"),
     ("unbalanced_N", 5.0, "impact 1: forces of the unloaded block")],
)  # fmt: skip
def test_what_does_not_balance_is_refused(column, value, said, tmp_path):
    result = sound()
    check(result, tmp_path / "log")
    result.history[column][1] = value
    with pytest.raises(NotConverged, match=said):
        check(result, tmp_path / "log")


def test_vertical_stress_and_missing_impacts_are_refused(tmp_path):
    with pytest.raises(NotConverged, match="vertical"):
        check(replace(sound(), balance_error=0.2), tmp_path / "log")
    with pytest.raises(NotConverged, match="2 of 3 impacts"):
        check(replace(sound(), impacts=3), tmp_path / "log")


@pytest.mark.solver
def test_two_impacts_to_layer_means(tmp_path, monkeypatch):
    """Mixed sizes on a coarse block: compression under the surface, nothing at the floor, the compliance kept."""
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    log = impacts([0.0, 0.15e-3], [0.0, 0.1e-3], [60.0, 50.0], [1e-3, 0.8e-3])
    shares = []
    numerics = ContactNumerics(side_in_radii=4.2, elements_per_radius=1.5, load_steps=6)
    first, result = solve_contact(AL2024, log, dimple(), (1e-3, 1e-3), tmp_path / "run", numerics=numerics, snapshots=(1, 5),
                                  progress=lambda share, text: shares.append(share))  # fmt: skip
    assert shares[-1] == 1.0
    assert first.impacts == len(first.history["impact"]) == 1  # the patch's impacts end before the fifth
    assert 0 < first.peeq[0] < result.peeq[0]
    assert result.finite_strain
    assert result.impacts == 2
    assert result.dofs == make_block(0.227, 4.2 * 0.227, 1.5).unknowns  # the estimate counts exactly
    mean = 0.5 * (result.sigma_xx_Pa + result.sigma_yy_Pa)
    assert mean[:4].max() < -100e6
    assert abs(mean[-1]) < 0.03 * abs(mean.min())
    assert result.surface_z_m.min() < -40e-6
    assert result.history["energy_mJ"] == pytest.approx([7.351, 2.614], rel=1e-3)
    assert list((tmp_path / "cache" / "contact").glob("*.bin"))
    assert not (tmp_path / "run" / "checkpoint").exists()
