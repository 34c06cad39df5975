"""Strips by layers on stand-in impacts: saturation is the exact root, sizes scale, density counts as speed, limits are told."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from glue.errors import InputError
from glue.target.strip import IntensityCurve, even_stream
from glue.theory.almen import STRIPS

sys.path.insert(0, str(Path(__file__).parent))

from strips import stand_in  # noqa: E402

LIBRARY, A = stand_in(), STRIPS["A"]


def test_saturation_is_where_doubling_brings_a_tenth():
    stream = even_stream(0.6e-3, 7800.0, 40.0)
    hits, height = LIBRARY.saturation(A, stream)
    assert LIBRARY.arc_height_m(A, stream, hits) == height
    assert LIBRARY.arc_height_m(A, stream, 2 * hits) == pytest.approx(1.1 * height, rel=1e-4)


def test_arc_heights_grow_with_exposure_speed_and_size():
    def heights(values, make):
        return [LIBRARY.arc_height_m(A, *make(v)) for v in values]

    for rising in (
        heights((0.1, 0.3, 1.0, 3.0), lambda n: (even_stream(0.6e-3, 7800.0, 40.0), n)),
        heights((15, 30, 60, 120), lambda v: (even_stream(0.6e-3, 7800.0, v), 1.0)),
        heights((0.2e-3, 0.4e-3, 0.8e-3), lambda d: (even_stream(d, 7800.0, 40.0), 1.0)),
    ):
        assert (np.diff(rising) > 0).all()


def test_a_strip_scaled_with_the_shot_bends_by_as_much_less():
    """Same strains at a scaled depth: curvature goes with 1/size, and the gauge is not scaled."""
    one = LIBRARY.arc_height_m(A, even_stream(0.5e-3, 7800.0, 40.0), 0.8)
    double = A._replace(thickness_m=2 * A.thickness_m)
    assert LIBRARY.arc_height_m(double, even_stream(1e-3, 7800.0, 40.0), 0.8) == pytest.approx(0.5 * one, rel=1e-3)


def test_density_counts_as_speed():
    light = LIBRARY.arc_height_m(A, even_stream(0.6e-3, 3900.0, 40.0 * math.sqrt(2.0)), 0.8)
    assert light == pytest.approx(LIBRARY.arc_height_m(A, even_stream(0.6e-3, 7800.0, 40.0), 0.8), rel=1e-9)


def test_two_sizes_bend_between_one_and_the_other():
    parts = [even_stream(d, 7800.0, 40.0) for d in (0.4e-3, 0.8e-3)]
    mixed = parts[0]._replace(
        diameter_m=np.array([0.4e-3, 0.8e-3]), density_kg_m3=np.full(2, 7800.0), normal_speed_m_s=np.full(2, 40.0)
    )
    low, both, high = (LIBRARY.arc_height_m(A, s, 0.8) for s in (parts[0], mixed, parts[1]))
    assert low < both < high
    areas = [LIBRARY.hits_1_s(s) for s in parts]
    assert LIBRARY.hits_1_s(mixed) == pytest.approx(np.mean(areas))


def test_intensity_to_speed_and_back():
    curve = IntensityCurve(LIBRARY, A, even_stream(0.6e-3, 7800.0, 40.0))
    factor = curve.factor(8e-3 * 0.0254)
    assert LIBRARY.intensity_m(A, curve.faster(factor)) == pytest.approx(8e-3 * 0.0254, rel=2e-4)
    # the slope is that of two neighbours
    up, down = (curve.exact(factor * f) for f in (1.05, 1 / 1.05))
    assert curve.exponent(factor) == pytest.approx(math.log(up / down) / math.log(1.05**2), rel=0.05)


def test_out_of_reach_names_what_can_be_had():
    curve = IntensityCurve(LIBRARY, A, even_stream(0.3e-3, 7800.0, 40.0))
    with pytest.raises(InputError, match=r"out of reach of these shots: allowed .*A \(at .* m/s"):
        curve.factor(23e-3 * 0.0254)


def test_a_strip_that_is_too_thin_and_speeds_that_are_not_solved():
    with pytest.raises(InputError, match="strip N: .*inside the peened layer"):
        LIBRARY.arc_height_m(STRIPS["N"], even_stream(2.36e-3, 7800.0, 100.0), 1.0)
    with pytest.raises(InputError, match="solved for 10 to 160 m/s"):
        LIBRARY.arc_height_m(A, even_stream(1e-3, 7800.0, 5.0), 1.0)
