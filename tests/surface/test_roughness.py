"""Areal roughness of sinusoids, whose values are known, and of surfaces at the edge of the definitions."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.surface import roughness

A, N = 3e-6, 400
PHASE = 2 * math.pi * (np.arange(N) + 0.5) / N  # one period, so cosines are even about the middle: no tilt


def test_sinusoid():
    got = roughness.areal(np.tile(A * np.cos(4 * PHASE), (10, 1)), 1e-6, 1e-6)
    # midpoint sums over whole periods: exact for the powers; 1/(24 (N/16)^2) relative for |cos|, here < 7e-5
    assert got["Sa_m"] == pytest.approx(2 * A / math.pi, rel=2e-3)
    assert got["Sq_m"] == pytest.approx(A / math.sqrt(2), rel=1e-12)
    assert got["Sku"] == pytest.approx(1.5, rel=1e-12)
    assert got["Ssk"] == pytest.approx(0.0, abs=1e-12)
    assert got["Sz_m"] == pytest.approx(2 * A, rel=1e-3)
    assert (got["levelling"], got["filter"]) == ("plane", "none")


def test_product_of_two_cosines():
    got = roughness.areal(A * np.cos(PHASE)[None, :] * np.cos(2 * PHASE)[:, None], 1e-6, 2e-6)
    assert got["Sa_m"] == pytest.approx(4 * A / math.pi**2, rel=1e-3)
    assert got["Sq_m"] == pytest.approx(A / 2, rel=1e-12)
    assert got["Sku"] == pytest.approx(2.25, rel=1e-12)


def test_plane_levelling_takes_a_tilt_out_and_nothing_else():
    wave = A * np.cos(PHASE)[None, :] * np.cos(PHASE)[:200, None]
    y, x = np.mgrid[0:200, 0:N].astype(float)
    tilted = wave + 5e-6 + 3e-8 * x - 2e-8 * y
    plain = roughness.areal(wave, 1e-6, 2e-6)
    for key, value in roughness.areal(tilted, 1e-6, 2e-6).items():
        assert value == (
            pytest.approx(plain[key], rel=1e-9, abs=1e-9) if isinstance(value, float) else plain[key]
        )
    # as numpy's own least squares sees it
    design = np.column_stack([np.ones(wave.size), x.ravel(), y.ravel()])
    fit = design @ np.linalg.lstsq(design, tilted.ravel(), rcond=None)[0]
    assert roughness.level_plane(tilted, 1e-6, 2e-6).ravel() == pytest.approx(tilted.ravel() - fit, abs=1e-15)


def test_mean_levelling_keeps_the_tilt():
    ramp = np.tile(np.linspace(0.0, 1.0, 101), (5, 1))
    assert roughness.areal(ramp, 1.0, 1.0, levelling="mean")["Sz_m"] == 1.0
    assert roughness.areal(ramp, 1.0, 1.0)["Sz_m"] == pytest.approx(0.0, abs=1e-12)


def test_one_deep_pit_is_skewed_down():
    z = np.zeros((10, 10))
    z[5, 5] = -1.0  # share s = .01 at -1: Sq^2 = s(1-s), Ssk = -(1-2s)/sqrt(s(1-s)), Sku = 1/(s(1-s)) - 3
    got = roughness.areal(z, 1.0, 1.0, levelling="mean")
    assert got["Ssk"] == pytest.approx(-0.98 / math.sqrt(0.0099), rel=1e-12)
    assert got["Sku"] == pytest.approx(1 / 0.0099 - 3, rel=1e-12)


@pytest.mark.parametrize("height", [0.0, 7e-6])
def test_flat_surface_has_no_shape_and_says_so(height):
    got = roughness.areal(np.full((4, 4), height), 1.0, 1.0)
    assert got["Sz_m"] == 0.0
    assert got["Ssk"] is None and got["Sku"] is None
    assert "flat" in got["Ssk_reason"]


@pytest.mark.parametrize("z, text", [(np.zeros((1, 5)), "2 x 2"), (np.full((3, 3), np.nan), "9 heights")])
def test_refuses_what_it_cannot_measure(z, text):
    with pytest.raises(InputError, match=text):
        roughness.areal(z, 1.0, 1.0)
    with pytest.raises(InputError, match="levelling"):
        roughness.areal(np.zeros((3, 3)), 1.0, 1.0, levelling="wishful")
