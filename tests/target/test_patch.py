"""The impacts of one patch: its exposure is the log's, its places are the cell's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import dimple, impacts

from glue.errors import InputError
from glue.target.patch import choose_patch, choose_patches, normal_energy_J, refuse_outside, refuse_too_long, unresolved

WINDOW, SIDE = (4e-3, 4e-3), 1e-3


def test_normal_energy_of_the_reference_shot():
    """1 mm steel at 60 m/s: pi/6 7800 1e-9 kg, 7.35 mJ; only the normal part counts."""
    log = impacts([0.0], [0.0])
    log["vx_in_m_s"] = 60.0
    assert normal_energy_J(log)[0] == pytest.approx(7800 * math.pi / 6 * 1e-9 * 1800)
    assert normal_energy_J(log)[0] == pytest.approx(7.35e-3, rel=1e-3)


def test_places_order_and_exposure():
    rng = np.random.default_rng(7)
    log = impacts(rng.uniform(-3e-3, 3e-3, 4000), rng.uniform(-3e-3, 3e-3, 4000))
    patch = choose_patch(log, dimple(), WINDOW, SIDE)
    x0, y0 = (c - 0.5 * SIDE for c in patch.centre_m)
    assert ((patch.x_m >= 0) & (patch.x_m < SIDE) & (patch.y_m >= 0) & (patch.y_m < SIDE)).all()
    inside = (log["x_m"] >= x0) & (log["x_m"] < x0 + SIDE) & (log["y_m"] >= y0) & (log["y_m"] < y0 + SIDE)
    assert patch.x_m + x0 == pytest.approx(log["x_m"][inside])  # in the log's order
    assert patch.exposure == pytest.approx(inside.sum() * math.pi * 227e-6**2 / SIDE**2)
    in_window = (abs(log["x_m"]) <= 2e-3) & (abs(log["y_m"]) <= 2e-3)
    assert patch.window_exposure == pytest.approx(in_window.sum() * math.pi * 227e-6**2 / 16e-6)


def test_the_patch_nearest_to_the_windows_exposure_is_taken():
    """15 tiles hold 10 impacts, one holds 26: the mean is 11, so a tile of ten is chosen, never the odd one."""
    centres = (np.arange(4) - 1.5) * SIDE
    x, y = (c.ravel() for c in np.meshgrid(centres, centres))
    counts = np.full(16, 10)
    counts[0] = 26
    patch = choose_patch(impacts(np.repeat(x, counts), np.repeat(y, counts)), dimple(), WINDOW, SIDE)
    assert patch.x_m.size == 10


def test_faint_impacts_are_left_out_and_reported():
    speed = np.array([60.0, 1.0, 60.0])
    patch = choose_patch(impacts([0.1e-3] * 3, [0.1e-3] * 3, speed), dimple(), (1e-3, 1e-3), SIDE)
    assert patch.x_m.size == 2
    assert patch.neglected_impacts == 1
    assert patch.neglected_energy_share == pytest.approx(1 / 7201)


def test_a_window_smaller_than_the_cell_is_refused():
    with pytest.raises(InputError, match="window_m"):
        choose_patch(impacts([0.0], [0.0]), dimple(), (0.9e-3, 4e-3), SIDE)


def test_a_sparse_log_takes_a_patch_with_an_impact_in_it():
    """One impact in sixteen tiles: fifteen empty ones are nearer to the mean exposure, and stand for nothing."""
    patch = choose_patch(impacts([1.2e-3], [-0.3e-3]), dimple(), WINDOW, SIDE)
    assert patch.x_m.size == 1
    assert patch.exposure == pytest.approx(16 * patch.window_exposure)


def test_a_log_beside_the_window_is_refused():
    with pytest.raises(InputError, match="no impact"):
        choose_patch(impacts([5e-3], [0.0]), dimple(), WINDOW, SIDE)


def test_a_patch_of_faint_impacts_only_is_passed_over():
    log = impacts([-0.5e-3, 0.5e-3], [0.0, 0.0], np.array([0.5, 60.0]))
    patch = choose_patch(log, dimple(), (2e-3, 1e-3), SIDE)
    assert patch.energy_J == pytest.approx([7.351e-3], rel=1e-3)


def test_an_impact_on_the_windows_far_edge_belongs_to_the_last_patch():
    """Two tiles across: one impact on each edge of the window, one on the line between them; none is lost, none counts twice."""
    log = impacts([-1e-3, 0.0, 1e-3], [0.5e-3, 0.0, -0.5e-3])
    left, right = sorted(choose_patches(log, dimple(), (2e-3, 1e-3), SIDE, 2), key=lambda p: p.centre_m[0])
    assert left.index.tolist() == [0] and right.index.tolist() == [1, 2]
    assert right.x_m.tolist() == [0.0, SIDE]


def test_several_patches_are_a_sample_of_all_exposures():
    """Nine tiles with 1 to 9 impacts, three patches: of each third the middle one, so 2, 5 and 8; their mean is the window's."""
    centres = (np.arange(3) - 1.0) * SIDE
    x, y = (c.ravel() for c in np.meshgrid(centres, centres))
    counts = np.array([9, 1, 5, 3, 7, 2, 8, 4, 6])
    log = impacts(np.repeat(x, counts), np.repeat(y, counts))
    patches = choose_patches(log, dimple(), (3e-3, 3e-3), SIDE, 3)
    assert [p.x_m.size for p in patches] == [2, 5, 8]
    assert np.mean([p.exposure for p in patches]) == pytest.approx(patches[0].window_exposure)
    with pytest.raises(InputError, match=r"target_patches: 10 patches .* 9 of the window's 9 hold an impact; allowed: up to 9"):
        choose_patches(log, dimple(), (3e-3, 3e-3), SIDE, 10)


def test_impacts_outside_their_patch_are_refused():
    patch = choose_patch(impacts([0.1e-3] * 2, [0.1e-3] * 2), dimple(), (1e-3, 1e-3), SIDE)
    refuse_outside(patch, SIDE)
    with pytest.raises(InputError, match=r"impact 1 of the patch .* allowed: 0 to 0\.001 m"):
        refuse_outside(patch._replace(y_m=np.array([0.5e-3, -0.1e-3])), SIDE)


def test_more_impacts_than_a_day_takes_are_refused_and_told_what_fits():
    refuse_too_long(10_000, 8.0, "target = contact")
    with pytest.raises(InputError, match="target = contact: 20000 impacts .* about 44 h .* some 10800 impacts"):
        refuse_too_long(20_000, 8.0, "target = contact")


def test_dimples_finer_than_the_mesh_are_found():
    """A .3 mm shot at the reference speed leaves .3 x .227 = .068 mm."""
    patch = choose_patch(impacts([0.1e-3] * 2, [0.1e-3] * 2, 60.0, np.array([0.3e-3, 1e-3])), dimple(), (1e-3, 1e-3), SIDE)
    assert unresolved(patch, dimple(), 0.07e-3).tolist() == [True, False]
    assert unresolved(patch, dimple(), 0.06e-3).tolist() == [False, False]
