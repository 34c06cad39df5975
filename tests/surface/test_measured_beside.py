"""X-ray weighting, deviation from a measured profile, initial stress and roughness: against what can be worked out by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from glue.errors import InputError
from glue.scene.catalogue import material
from glue.surface.roughness import areal, profile, random_surface
from glue.surface.stress import deviation, xray_weighted_Pa
from glue.target.part import kept_share, part_profile
from glue.theory.plate import force_and_moment

AL = material("al2024-t351")


def test_xrays_see_a_straight_profile_one_attenuation_depth_down():
    """int (a + b z) e^(-z/t) dz / t = a + b t, also when the profile starts below the surface."""
    for z in (np.array([0.0, 1e-3]), np.array([1e-5, 2e-4, 1e-3])):
        found = xray_weighted_Pa(z, -200e6 - 2e12 * z, 11e-6)
        assert found == pytest.approx(-200e6 - 2e12 * 11e-6, rel=1e-9)


def test_xrays_see_a_step_by_its_share():
    z = np.array([0.0, 10e-6, 10.0001e-6, 1e-3])
    found = xray_weighted_Pa(z, np.array([-300e6, -300e6, 0.0, 0.0]), 10e-6)
    assert found == pytest.approx(-300e6 * (1 - math.exp(-1)), rel=1e-4)


def test_deviation_is_computed_less_measured():
    found = deviation([0.0, 1e-4], [-100e6, -300e6], [0.0, 5e-5, 1e-4, 2e-4], [-110e6, -200e6, -260e6, 0.0])
    assert found["points"] == 3  # the fourth lies below the profile
    assert found["mean_Pa"] == pytest.approx(-10e6)
    assert found["rms_Pa"] == pytest.approx(math.sqrt((10**2 + 40**2) / 3) * 1e6)
    assert found["largest_Pa"] == pytest.approx(-40e6)
    assert deviation([0.0, 1e-4], [0.0, 0.0], [1e-3], [0.0])["mean_Pa"] is None


def layers(peeq):
    depth = np.array([0.05e-3, 0.2e-3, 0.5e-3, 1.0e-3])
    peened = -300e6 * (np.asarray(peeq) > 0)
    flat = np.zeros(4)
    return SimpleNamespace(
        depth_m=depth, sigma_xx_Pa=peened, sigma_yy_Pa=peened, peeq=np.asarray(peeq, float), sigma_xx_std_Pa=flat,
        sigma_yy_std_Pa=flat, peeq_std=flat, floor_m=1.3e-3,
    )  # fmt: skip


INITIAL = ((0.0, 80e6), (0.3e-3, 80e6), (0.6e-3, -20e6), (2e-3, 0.0))


def test_an_initial_stress_rests_where_nothing_flows_and_goes_where_much_does():
    thick = part_profile(layers([0.5, 0.05, 0.0, 0.0]), None, INITIAL, AL)
    assert thick["sigma_xx_Pa"][0] == pytest.approx(-300e6, rel=1e-6)
    assert thick["sigma_xx_Pa"][3] == pytest.approx(np.interp(1e-3, *np.array(INITIAL).T))
    untouched = part_profile(layers([0, 0, 0, 0]), 10e-3, INITIAL, AL)
    assert untouched["sigma_yy_Pa"] == pytest.approx(np.interp(untouched["depth_m"], *np.array(INITIAL).T, right=0.0))


def test_what_is_lost_of_it_lets_the_part_stretch_and_bend():
    """Force and moment of the change vanish, whatever they were before."""
    found = part_profile(layers([0.5, 0.05, 0.0, 0.0]), 10e-3, INITIAL, AL)
    change = found["sigma_xx_Pa"] - np.interp(found["depth_m"], *np.array(INITIAL).T, right=0.0)
    force, moment = force_and_moment(found["depth_m"], change, 5e-3)
    assert abs(force) < 1e-9 * 3e8 * 1e-3 and abs(moment) < 1e-9 * 3e8 * 5e-6


def test_decay_by_prandtl_reuss():
    """Pure shear at yield across an initial stress: ds/dp = -3 G s/sigma_y, stepped against the closed form."""
    flow = AL.combined.flow_stress_Pa(0.003)
    G, s = 0.5 * AL.E_Pa / (1 + AL.nu), 1.0
    for _ in range(30_000):
        s -= 3 * G * s / flow * 1e-7
    assert kept_share(np.array([0.003]), AL)[0] == pytest.approx(s, rel=1e-3)


def test_a_random_surface_has_its_roughness_and_its_wavelength():
    z = random_surface((400, 300), 2e-6, 2e-6, 1.5e-6, 40e-6, 1)
    assert areal(z, 2e-6, 2e-6, "mean")["Sa_m"] == pytest.approx(1.5e-6)
    # one wavelength, any direction: the root of <|grad|^2>/<z^2> is 2 pi / wavelength
    gy, gx = np.gradient(z, 2e-6)
    assert math.sqrt((gx**2 + gy**2).mean() / (z**2).mean()) == pytest.approx(2 * math.pi / 40e-6, rel=0.03)
    assert (random_surface((4, 3), 1e-6, 1e-6, 1e-6, 1e-5, 2) != random_surface((4, 3), 1e-6, 1e-6, 1e-6, 1e-5, 3)).any()


def test_Ra_and_Rz_of_a_wave():
    """A cos(x), level as it is: 2 A/pi along x, 0 across; Rz 2 A along x in five parts of a whole wave each."""
    x = np.arange(1000) / 1000 * 5 * 2 * math.pi
    found = profile(np.tile(1e-6 * np.cos(x), (200, 1)), 1e-6, 1e-6)
    assert found["Ra_m"] == pytest.approx(0.5 * 2e-6 / math.pi, rel=0.02)
    assert found["Rz_m"] == pytest.approx(0.5 * 2e-6, rel=0.02)


def test_an_attenuation_depth_that_is_none():
    with pytest.raises(InputError, match="xray_depth_m"):
        xray_weighted_Pa([0.0, 1.0], [0.0, 1.0], 0.0)
