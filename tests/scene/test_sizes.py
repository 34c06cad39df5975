"""Sizes of shots: ends, moments and quantiles agree with each other and with what a sieve would weigh."""

from __future__ import annotations

import numpy as np
import pytest

from glue.scene import sizes
from glue.scene.catalogue import shot

SHOTS = [
    shot("S230", "mono"),
    shot("S390", "distribution"),
    shot("CW28", "distribution"),
    shot("S390", "sieve"),
    shot("S930", "sieve"),
]
N = 20_000


@pytest.fixture(params=SHOTS, ids=lambda shots: f"{shots.grade}-{shots.size}")
def shots(request):
    return request.param


def evenly_drawn(shots):
    """Diameters [m] at the middles of N equal shares of the shots, shape (N,)."""
    return np.array([sizes.quantile_m(shots, (i + 0.5) / N) for i in range(N)])


def test_quantiles_rise_from_the_smallest_to_the_largest(shots):
    drawn = evenly_drawn(shots)
    assert np.all(np.diff(drawn) >= 0.0)
    assert sizes.quantile_m(shots, 0.0) == pytest.approx(sizes.smallest_m(shots), rel=1e-9)
    assert sizes.quantile_m(shots, 1.0) == pytest.approx(sizes.largest_m(shots), rel=1e-9)


def test_moments_are_those_of_the_quantiles(shots):
    drawn = evenly_drawn(shots)  # the midpoint rule is good to 1/N at the steps of a sieve's density
    assert drawn.mean() == pytest.approx(sizes.mean_m(shots), rel=1e-4)
    assert (drawn**3).mean() == pytest.approx(sizes.mean_cube_m3(shots), rel=3e-4)


@pytest.mark.parametrize("grade", ["S70", "S230", "S390", "S930"])
def test_drawn_shots_weighed_on_the_sieves_give_the_analysis_back(grade):
    shots = shot(grade, "sieve")
    drawn = evenly_drawn(shots)
    for opening, finer in shots.sieve:
        assert (drawn[drawn < opening] ** 3).sum() / (drawn**3).sum() == pytest.approx(finer, abs=1e-3)
