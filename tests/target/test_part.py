"""A plate let go balances; a thick part is left as the cell gave it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from glue.errors import InputError
from glue.surface.stress import profile_metrics
from glue.target.part import part_profile, strip_arc_height_m
from glue.theory.plate import force_and_moment


def cell():
    depth = np.array([0.05e-3, 0.2e-3, 0.5e-3, 1.0e-3])
    stress = np.array([-300e6, -330e6, -100e6, -1e3])
    flat = np.array([1.0, 0.5, 0.1, 0.0])
    return SimpleNamespace(
        depth_m=depth, sigma_xx_Pa=stress, sigma_yy_Pa=0.9 * stress, peeq=flat, sigma_xx_std_Pa=flat,
        sigma_yy_std_Pa=flat, peeq_std=flat, floor_m=1.3e-3,
    )  # fmt: skip


def test_no_thickness_leaves_the_layers():
    profile = part_profile(cell(), None)
    assert profile["sigma_xx_Pa"].tolist() == cell().sigma_xx_Pa.tolist()


def test_a_plate_balances_and_turns_to_tension():
    profile = part_profile(cell(), 10e-3)
    assert (profile["depth_m"][0], profile["depth_m"][-1]) == (0.0, 10e-3)
    force, moment = force_and_moment(profile["depth_m"], profile["sigma_xx_Pa"], 5e-3)
    assert abs(force) < 1e-9 * 330e6 * 1e-3
    assert abs(moment) < 1e-9 * 330e6 * 1e-3 * 5e-3
    metrics = profile_metrics(profile["depth_m"], profile["sigma_xx_Pa"])
    assert abs(metrics["force_balance_relative"]) < 1e-9
    assert 0.5e-3 < metrics["compressive_depth_m"] < 1.0e-3
    # before release: -300 - .05/.15 (-30) = -290 MPa at the surface; a thicker plate gives back less of it
    assert profile["sigma_xx_Pa"][0] > -290e6
    assert part_profile(cell(), 1.0)["sigma_xx_Pa"][0] == pytest.approx(-290e6, rel=0.01)


def test_a_strip_that_ends_above_the_floor_balances_too():
    """1.1 mm: the cell reaches to 1.3 mm, but the stress has faded."""
    profile = part_profile(cell(), 1.1e-3)
    assert profile["depth_m"].tolist() == [0.0, 0.05e-3, 0.2e-3, 0.5e-3, 1.0e-3, 1.1e-3]
    force, moment = force_and_moment(profile["depth_m"], profile["sigma_xx_Pa"], 0.55e-3)
    assert abs(force) < 1e-9 * 330e6 * 1e-3
    assert abs(moment) < 1e-9 * 330e6 * 1e-6


def test_a_strip_that_ends_inside_the_peened_layer_is_refused():
    with pytest.raises(InputError, match="inside the peened layer"):
        part_profile(cell(), 0.6e-3)


def test_arc_height_of_a_layer_of_known_eigenstrain():
    """-E/(1-nu) 1e-3 down to .2 mm of a 1.29 mm strip: .09597 mm; here the layer's edge is 1 um wide."""
    stress = -205e9 / 0.71 * 1e-3
    strip = SimpleNamespace(
        depth_m=np.array([0.1e-3, 0.1995e-3, 0.2005e-3, 0.6e-3, 1.0e-3]),
        sigma_xx_Pa=np.array([stress, stress, 0.0, 0.0, 0.0]), sigma_yy_Pa=np.array([stress, stress, 0.0, 0.0, 0.0]), floor_m=1.0e-3,
    )  # fmt: skip
    assert strip_arc_height_m(strip, 1.29e-3, 205e9, 0.29) == pytest.approx(0.09597e-3, rel=1e-4)
    strip.sigma_yy_Pa = np.zeros(5)
    assert strip_arc_height_m(strip, 1.29e-3, 205e9, 0.29) == pytest.approx(0.5 * 0.09597e-3, rel=1e-4)
