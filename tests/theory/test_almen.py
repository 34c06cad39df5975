"""Intensities as a shop writes them, and the strips' limits."""

from __future__ import annotations

import pytest

from glue.theory.almen import INCH_m, STRIPS, eigenstrain_curvature_1_m, gauge_reading_m, intensity_problem, read_intensity


@pytest.mark.parametrize(
    ("text", "low_in", "high_in", "letter"),
    [
        ("8A", 0.008, 0.008, "A"),
        ("6-8A", 0.006, 0.008, "A"),
        (" 6 - 8 a", 0.006, 0.008, "A"),
        ("10.5N", 0.0105, 0.0105, "N"),
        ("5C", 0.005, 0.005, "C"),
        ("0.254 mmA", 0.01, 0.01, "A"),
        ("0.127-0.254mmA", 0.005, 0.01, "A"),
        ("4A", 0.004, 0.004, "A"),
        ("24A", 0.024, 0.024, "A"),
    ],
)
def test_what_a_drawing_says(text, low_in, high_in, letter):
    found = read_intensity(text)
    assert (found.low_m, found.high_m) == (pytest.approx(low_in * INCH_m), pytest.approx(high_in * INCH_m))
    assert found.strip is STRIPS[letter]
    assert found.aim_m == pytest.approx(0.5 * (low_in + high_in) * INCH_m)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("8B", 'a strip "B" that there is not; allowed strips N, A, C'),
        ("8", "names no strip"),
        ("3.9A", "say it on strip N"),
        ("25A", "say it on strip C"),
        ("2-8A", "say it on strip N"),
        ("20-30A", "say it on strip C"),
        ("8-6A", "below the second"),
        ("-8A", "no Almen intensity"),
        ("A8", "no Almen intensity"),
        ("", "no Almen intensity"),
        ("60N", "say it on strip A"),
        ("1C", "say it on strip A"),
        ("8000A", "say it on strip C"),
    ],
)
def test_what_it_must_not_say(text, says):
    assert says in intensity_problem(text)
    with pytest.raises(ValueError, match="allowed"):
        read_intensity(text)


def test_it_is_written_back_as_it_was():
    assert [str(read_intensity(text)) for text in ("8A", "6-8A", "10.5N")] == ["8A", "6-8A", "10.5N"]


def test_curvature_and_reading_of_the_reference():
    """h 1.29, d .2 mm, eigenstrain 1e-3: curvature .60931 1/m, arc .09597 mm."""
    curvature = eigenstrain_curvature_1_m(1e-3, 0.2e-3, 1.29e-3)
    assert curvature == pytest.approx(0.60931, rel=1e-4)
    assert gauge_reading_m(curvature) == pytest.approx(0.09597e-3, rel=1e-4)
