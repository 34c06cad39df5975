"""The energy stamp: one dimple back, volume kept, and growth as sequential finite-element cells show it."""

from __future__ import annotations

import math
import time
from types import SimpleNamespace

import numpy as np
import pytest

from glue.errors import InputError
from glue.surface import roughness, stamp

WINDOW = (2e-3, 2e-3)


def johnson_cook(p):
    return 369e6 + 684e6 * p**0.73  # the law of the reference growth below


def perfectly_plastic(p):
    return 400e6


def press(impacts, dimple, window_m=WINDOW, spacing_m=10e-6, law=johnson_cook):
    return stamp.height_map(impacts, dimple, window_m, spacing_m, flow_stress_Pa=law)


def cap_volume(dimple):
    return math.pi * dimple.depth_m * (3 * dimple.radius_m**2 + dimple.depth_m**2) / 6


def test_stamp_of_a_cap_is_the_cap(dimple):
    made = stamp.stamp_of(dimple)
    assert made.volume_m3 == pytest.approx(cap_volume(dimple), rel=1e-4)  # the profile is a polygon
    sphere = (dimple.radius_m**2 + dimple.depth_m**2) / (2 * dimple.depth_m)
    assert made.cap_radius_m == pytest.approx(sphere, rel=1e-4)
    # the crest less the height at the cut, 3 radii
    assert made.pile_m.max() == pytest.approx(8.2e-6 * (1 - math.exp(-1.87 / 0.55)), rel=5e-3)
    assert made.pile_m[-1] == 0.0


def test_one_impact_gives_the_dimple_back(dimple, make_impacts):
    x, y, z = press(make_impacts([0.0], [0.0]), dimple, spacing_m=4e-6)
    r = np.hypot(*np.meshgrid(x, y))
    assert -z.min() == pytest.approx(dimple.depth_m, rel=2e-3)
    dent = -np.minimum(z, 0.0).sum() * 16e-12
    assert dent == pytest.approx(cap_volume(dimple), rel=2e-3)
    assert r[z < 0.0].max() == pytest.approx(dimple.radius_m, rel=0.02)
    inside = r < 0.98 * dimple.radius_m
    expected = np.interp(r[inside], dimple.profile_r_m, dimple.profile_z_m)
    assert z[inside] == pytest.approx(expected, abs=0.2e-6)


def test_two_distant_impacts_superpose(dimple, make_impacts):
    both = press(make_impacts([-0.7e-3, 0.705e-3], [0.0, 0.1e-3]), dimple)[2]
    one = press(make_impacts([-0.7e-3], [0.0]), dimple)[2]
    other = press(make_impacts([0.705e-3], [0.1e-3]), dimple)[2]
    assert both == pytest.approx(one + other, abs=1e-12)


def test_second_impact_on_the_spot_takes_away_the_hardened_volume(dimple, make_impacts):
    no_pile = SimpleNamespace(**{**vars(dimple), "profile_z_m": np.minimum(dimple.profile_z_m, 0.0)})
    cell = 100e-12
    once = -press(make_impacts([0.0], [0.0]), no_pile)[2].sum() * cell
    twice = -press(make_impacts([0.0, 0.0], [0.0, 0.0]), no_pile)[2].sum() * cell
    soft = -press(make_impacts([0.0, 0.0], [0.0, 0.0]), no_pile, law=perfectly_plastic)[2].sum() * cell
    ratio = stamp.volume_ratio(johnson_cook, stamp.plastic_work_density_Pa(dimple), 3)
    assert once == pytest.approx(stamp.stamp_of(no_pile).volume_m3, rel=1e-9)  # exact on any grid
    assert twice - once == pytest.approx(ratio[1] * once, rel=1e-9)
    assert soft == pytest.approx(2 * once, rel=1e-9)


def test_volume_ratio_closed_forms():
    assert stamp.volume_ratio(perfectly_plastic, 100e6, 5) == pytest.approx(np.ones(5), rel=1e-9)
    # sigma = S p: W = S p^2/2, so p_k = sqrt(k) p_1 and the ratio is sqrt(k+1) - sqrt(k)
    linear = stamp.volume_ratio(lambda p: 1e3 + 500e6 * p, 100e6, 4)
    assert linear == pytest.approx(np.diff(np.sqrt(np.arange(5))), rel=1e-3)
    assert np.all(np.diff(stamp.volume_ratio(johnson_cook, 100e6)) < 0.0)


def test_work_density_is_the_lost_kinetic_energy(dimple):
    # 7.35 mJ of a 1 mm steel sphere at 60 m/s, less the rebound's e^2
    volume = stamp.WORK_DEPTH * math.pi * dimple.radius_m**3
    assert stamp.plastic_work_density_Pa(dimple) * volume == pytest.approx(7.351e-3 * (1 - 0.34**2), rel=1e-4)


def test_size_and_speed_scale_the_stamp(dimple, make_impacts):
    # half the shot is half of every length; a quarter of the speed half the radius, so a quarter of the depth
    x, y, z = press(
        make_impacts([0.0], [0.0], diameter_m=0.5e-3), dimple, spacing_m=2e-6, window_m=(0.4e-3, 0.4e-3)
    )
    assert -z.min() == pytest.approx(dimple.depth_m / 2, rel=2e-3)
    x, y, z = press(
        make_impacts([0.0], [0.0], speed_m_s=15.0), dimple, spacing_m=2e-6, window_m=(0.4e-3, 0.4e-3)
    )
    assert -z.min() == pytest.approx(dimple.depth_m / 4, rel=0.02)  # a flatter cap of the same sphere


def test_impacts_outside_the_window_reach_in_and_order_is_time(dimple, make_impacts):
    wide = make_impacts([1.1e-3, 0.9e-3], [0.0, 0.0], time_s=[1.0, 0.0])
    z_small = press(wide, dimple)[2]
    _, _, z_large = press(wide, dimple, window_m=(4e-3, 4e-3))
    assert z_small == pytest.approx(z_large[100:300, 100:300], abs=1e-12)
    assert z_small.min() < -40e-6
    swapped = press(make_impacts([0.9e-3, 1.1e-3], [0.0, 0.0]), dimple)[2]
    assert np.array_equal(swapped, z_small)


def test_grazing_shot_below_the_grid_leaves_nothing(dimple, make_impacts):
    assert not press(make_impacts([1e-6], [1e-6], speed_m_s=1e-6), dimple)[2].any()


def test_untouched_surface_is_flat(dimple, make_impacts):
    assert not press(make_impacts([], []), dimple)[2].any()
    assert not press(make_impacts([9e-3], [0.0]), dimple)[2].any()


def test_growth_as_in_sequential_finite_element_cells(dimple, make_impacts):
    """Sa, Sz, Ssk after 5, 18, 58 impacts in a periodic 1.6 mm cell (coverage 28, 69, 98 %).

    Reference: finite-element cells under energy-controlled spheres one after another, Johnson-Cook 369 + 684
    p^.73 MPa, mean of 3 draws.  Single draws scatter by 5-9 % in Sa and Sz and .15-.2 in Ssk, so one
    standard error of the reference is 3-5 % and .1: limits 10 % and .25.  Here the mean of 60 draws.
    Nothing but WORK_DEPTH is fitted: it moves the last row's Sa by 6 % between 1 and 2 radii.
    """
    reference = [(5, 12.7e-6, 80e-6, -1.4), (18, 20.8e-6, 107e-6, 0.0), (58, 17.6e-6, 128e-6, 0.4)]
    side = 1.6e-3
    images = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]) * side
    found = {n: [] for n, *_ in reference}
    for seed in range(60):
        centre = np.random.default_rng(seed).uniform(-side / 2, side / 2, (58, 2))
        for n in found:
            x, y = (centre[:n, None, :] + images[None, :, :]).reshape(-1, 2).T
            z = press(make_impacts(x, y), dimple, (side, side), 20e-6)[2]
            # a periodic cell has no tilt to take out
            got = roughness.areal(z, 20e-6, 20e-6, levelling="mean")
            found[n].append((got["Sa_m"], got["Sz_m"], got["Ssk"]))
    for n, sa, sz, ssk in reference:
        mean = np.mean(found[n], axis=0)
        assert mean[0] == pytest.approx(sa, rel=0.10), n
        assert mean[1] == pytest.approx(sz, rel=0.10), n
        assert mean[2] == pytest.approx(ssk, abs=0.25), n


def test_ten_thousand_impacts_take_seconds(dimple, make_impacts):
    press(make_impacts([0.0], [0.0]), dimple)  # compile before the clock starts
    x, y = np.random.default_rng(0).uniform(-2.6e-3, 2.6e-3, (2, 10_000))
    impacts = make_impacts(x, y)
    start = time.process_time()
    z = press(impacts, dimple, (4e-3, 4e-3), dimple.radius_m / 16)[2]
    assert time.process_time() - start < 5.0
    assert np.isfinite(z).all()


def test_bad_input(dimple, make_impacts):
    with pytest.raises(InputError, match="must move into the target"):
        press(make_impacts([0.0], [0.0], speed_m_s=-3.0), dimple)
    with pytest.raises(InputError, match="spacing_m"):
        press(make_impacts([0.0], [0.0]), dimple, spacing_m=0.0)
    flat = SimpleNamespace(**{**vars(dimple), "profile_z_m": np.zeros_like(dimple.profile_r_m)})
    with pytest.raises(InputError, match="no dent"):
        press(make_impacts([0.0], [0.0]), flat)
