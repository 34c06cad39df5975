"""Media of a scene: mixtures by mass, screening limits of the catalogue, a sieve analysis of one's own."""

from __future__ import annotations

import math

import pytest

from glue.errors import InputError
from glue.scene import sizes
from glue.scene.catalogue import shot, shot_grades, sieve_grades
from glue.scene.reader import read_scene

ALLOWED = (
    'allowed: an array of 2 to 20 tables { opening_m = …, finer = … }, openings rising, "finer" (the share of the '
    "mass that passes) rising from 0 to 1"
)
OWN = {"shots": None, "shots.density_kg_m3": "7800.0", "shots.size": '"sieve"'}


def two(first="0.5", second="0.5"):
    rows = (f'{{grade = "S230", mass_fraction = {first}}}', f'{{grade = "S390", mass_fraction = {second}}}')
    return {"shots": f"[{', '.join(rows)}]"}


def sieve(*rows):
    return OWN | {"shots.sieve": "[" + ", ".join(f"{{opening_m = {a}, finer = {b}}}" for a, b in rows) + "]"}


def test_a_mixture_by_mass(write_scene):
    """Half of a kilogram in 0.6 mm shots of .88216 mg and half in 1 mm ones of 4.08407 mg: 566 800 + 122 430."""
    scene = read_scene(write_scene(two()))
    assert [shots.grade for shots in scene.media] == ["S230", "S390"]
    assert [shots.mass_fraction for shots in scene.media] == [0.5, 0.5]
    assert scene.shots_per_kg == pytest.approx(0.5 / 0.88216e-6 + 0.5 / 4.08407e-6, rel=1e-5)
    assert (scene.smallest_diameter_m, scene.largest_diameter_m) == (0.6e-3, 1e-3)
    assert (
        'shots[2].size = "mono" (every shot of the same size; choice of this project)' in scene.defaults_used
    )
    assert read_scene(write_scene(two("0.3", "0.7000000001"))).shots.grade == "S390"


def test_media_may_be_of_unlike_stuff(write_scene):
    rows = (
        '[{grade = "GLASS500", mass_fraction = 0.2}, {grade = "S230", size = "sieve", mass_fraction = 0.8}]'
    )
    glass, steel = read_scene(write_scene({"shots": rows})).media
    assert (glass.E_Pa, glass.density_kg_m3, steel.E_Pa, steel.size) == (70e9, 2500.0, 210e9, "sieve")


def test_one_medium_written_either_way_is_the_same_scene(write_scene):
    plain = read_scene(write_scene())
    assert read_scene(write_scene({"shots": '[{grade = "S390"}]'})) == plain
    assert read_scene(write_scene({"shots.mass_fraction": "1"})) == plain


@pytest.mark.parametrize(
    "changes, expected",
    [
        (
            two("-0.5", "1.5"),
            [
                "shots[1].mass_fraction: -0.5 is out of range; this key is a share of one; allowed 1e-6..1 (a medium "
                "feeds mass, never takes it away, and all of them feed 1)",
                "shots[2].mass_fraction: 1.5 is out of range; this key is a share of one (1.5 % is written 0.015); allowed 1e-6..1 (a medium "
                "feeds mass, never takes it away, and all of them feed 1)",
            ],
        ),
        (
            two("0.5", "0.4"),
            ["shots: the mass fractions (0.5 + 0.4) sum to 0.9; allowed: a sum of 1 within 1e-6"],
        ),
        (two("0.5", "0.500002"), ["shots: the mass fractions (0.5 + 0.500002) sum to 1.000002; allowed: a sum of 1 within 1e-6"]),
        (
            {"shots.mass_fraction": "0.5"},
            ["shots.mass_fraction: the mass fractions (0.5) sum to 0.5; allowed: a sum of 1 within 1e-6"],
        ),
        (
            {"shots": '[{grade = "S230"}, {grade = "S390", mass_fraction = 1}]'},
            ["shots[1].mass_fraction: missing, and required; allowed 1e-6..1"],
        ),
        ({"shots": "[]"}, ["shots: must not be empty; allowed: one table [shots], or several written [[shots]]"]),
        (
            {"shots": "[1]"},
            [
                "shots: must be a table, or tables, not an array of something else; allowed: one table [shots], or "
                "several written [[shots]]"
            ],
        ),
        (
            {"shots": "[" + 11 * '{grade = "S230", mass_fraction = 0.1},' + "]"},
            ["shots: must be at most 10 tables, not 11; allowed 1..10"],
        ),
    ],
)  # fmt: skip
def test_a_mixture_that_is_none(changes, expected, problems_of):
    assert problems_of(changes) == expected


def test_every_cast_grade_has_limits_and_others_have_none():
    assert sieve_grades() == [grade for grade in shot_grades() if grade[0] == "S"]
    with pytest.raises(InputError, match='no shot grade with screening limits "CW28"'):
        shot("CW28", "sieve")


@pytest.mark.parametrize("grade", sieve_grades())
def test_a_grade_meets_its_own_screening_limits(grade):
    """The nominal sieve keeps at least 80 % of the mass; the mean by number lies above it, or for S110, of which a tenth
    may be as fine as dust, not far below."""
    shots, nominal = shot(grade, "sieve"), shot(grade).diameter_m
    openings, finer = zip(*shots.sieve)
    assert list(openings) == sorted(set(openings)) and list(finer) == sorted(finer)
    assert (finer[0], finer[-1]) == (0.0, 1.0)
    assert nominal in openings[1:-1] or grade == "S70"
    kept = 1.0 - finer[openings.index(nominal)]
    assert kept >= 0.8
    assert shots.diameter_m == sizes.mean_m(shots)
    assert 0.85 * nominal < shots.diameter_m < 1.35 * nominal
    assert shots.evidence == "C" and "SAE J444" in shots.source


def test_the_middle_of_each_allowance_of_s390():
    """All pass 1.70, at most 5 % on 1.40, at least 85 % on 1.00 and 96 % on 0.85 mm: halves of what may vary."""
    openings, finer = zip(*shot("S390", "sieve").sieve)
    assert openings == (0.71e-3, 0.85e-3, 1.0e-3, 1.4e-3, 1.7e-3)
    assert finer == pytest.approx((0.0, 0.02, 0.075, 0.975, 1.0), abs=1e-12)


def test_the_sieve_of_a_grade_is_printed_with_its_source(write_scene):
    scene = read_scene(write_scene({"shots.size": '"sieve"'}))
    (line,) = [line for line in scene.defaults_used if line.startswith("shots.sieve")]
    assert '"finer than 0.00071 m: 0, 0.00085 m: 0.02, 0.001 m: 0.075, 0.0014 m: 0.975, 0.0017 m: 1"' in line
    assert "SAE J444" in line and "grade C" in line


def test_a_sieve_analysis_of_ones_own(write_scene):
    """Mass spread evenly from 1 to 2 mm: by number d^-3, so the mean is int d^-2 / int d^-3 = (1/2) / (3/8) mm."""
    scene = read_scene(write_scene(sieve(("0.001", 0), ("0.002", 1))))
    assert scene.shots.sieve == ((0.001, 0.0), (0.002, 1.0))
    assert scene.shots.diameter_m == pytest.approx(4e-3 / 3.0, rel=1e-12)
    assert (scene.smallest_diameter_m, scene.largest_diameter_m) == (0.001, 0.002)
    # and the mean cube is 1 / int d^-3 dd = 8/3 mm3
    assert scene.shots.mean_mass_kg == pytest.approx(7800.0 * math.pi / 6.0 * 8.0 / 3.0 * 1e-9, rel=1e-12)


@pytest.mark.parametrize(
    "changes, expected",
    [
        (OWN, [f"shots.sieve: missing, and required; {ALLOWED}"]),
        (
            OWN | {"shots.sieve": "1"},
            [f"shots.sieve: must be an array of tables, not the integer 1; {ALLOWED}"],
        ),
        (
            OWN | {"shots.sieve": "[1, 2]"},
            [f"shots.sieve: must be an array of tables, not an array of something else; {ALLOWED}"],
        ),
        (sieve(("0.001", 0)), [f"shots.sieve: must have 2 to 20 sieves, not 1; {ALLOWED}"]),
        (
            sieve(("0.001", 0), ("0.0009", 1)),
            [f"shots.sieve[2].opening_m: 0.0009 m does not rise above the 0.001 m before it; {ALLOWED}"],
        ),
        (
            sieve(("0.001", 0), ("0.0011", 0.6), ("0.0012", 0.5), ("0.0013", 1)),
            [
                f"shots.sieve[3].finer: 0.5 after 0.6 puts a negative mass (-0.1) between these sieves; {ALLOWED}"
            ],
        ),
        (
            sieve(("0.001", 0.1), ("0.0012", 0.9)),
            [
                f"shots.sieve[1].finer: 0.1 leaves shots finer than the finest sieve without a size; {ALLOWED}",
                f"shots.sieve[2].finer: 0.9 leaves shots coarser than the coarsest sieve without a size; {ALLOWED}",
            ],
        ),
        (
            sieve(("1", 0), ("0.002", 1.5)),
            [
                "shots.sieve[1].opening_m: 1 is 1000 mm; this key is in metres (1 mm is written 0.001); "
                "allowed 2e-5..0.006 m",
                "shots.sieve[2].finer: 1.5 is out of range; this key is a share of one (1.5 % is written 0.015); "
                "allowed 0..1",
            ],
        ),
        (
            sieve(("0.001", 0), ("0.002", 1)) | {"shots.diameter_m": "0.001"},
            ["shots.diameter_m: follows from the sieve analysis; allowed: no diameter_m, or another size"],
        ),
        (
            sieve(("0.001", 0), ("0.002", 1)) | {"shots.size": '"mono"', "shots.diameter_m": "0.001"},
            ['shots.sieve: has no effect with size = "mono"; allowed: size = "sieve", or no sieve'],
        ),
        (
            {"shots.size": '"sieve"', "shots.sieve": "[]"},
            ["shots.sieve: is fixed by grade; allowed: grade alone, or your own numbers without grade"],
        ),
        (
            {"shots.grade": '"CW28"', "shots.size": '"sieve"'},
            [
                'shots.size: "sieve" needs the screening limits of a cast steel grade, and CW28 has none; allowed "mono", '
                f'"distribution", or one of {", ".join(sieve_grades())}'
            ],
        ),
        (
            {"shots.size": '"sieve"', "shots.size_cv": "0.1"},
            [
                'shots.size_cv: has no effect with size = "sieve"; allowed: size = "distribution", or no size_cv'
            ],
        ),
    ],
)
def test_a_sieve_analysis_that_is_none(changes, expected, problems_of):
    assert problems_of(changes) == expected
