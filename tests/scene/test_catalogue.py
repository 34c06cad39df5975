"""The catalogue is complete, says where every number comes from, and holds the reference values."""

from __future__ import annotations

import pytest

from glue.errors import InputError
from glue.scene import schema
from glue.scene.catalogue import (
    GRADES,
    closest,
    material,
    material_keys,
    material_tables,
    shot,
    shot_grades,
    shot_tables,
    worst_grade,
)
from glue.scene.presets import PRESETS

MPa, GPa = 1e6, 1e9
# A, B [MPa], n, C, reference rate [1/s], E [GPa], nu, density [kg/m3], worst grade.
REFERENCE = {
    "al2024-t351": (369, 684, 0.73, 0.0083, 1.0, 73.1, 0.33, 2780, "C"),
    "al2024-t351-jc1983": (265, 426, 0.34, 0.015, 1.0, 73.1, 0.33, 2780, "C"),
    "al2024-t351-wierzbicki": (352, 440, 0.42, 0.0083, 1.0, 73.1, 0.33, 2780, "C"),
    "al7075-t6": (546, 678, 0.71, 0.024, 1.0, 71.7, 0.33, 2810, "C"),
    "ti6al4v": (1098, 1092, 0.93, 0.014, 1.0, 113.8, 0.342, 4430, "C"),
    "in718": (460, 1700, 0.65, 0.017, 1e-3, 200, 0.3, 8220, "A"),
    "steel4340": (792, 510, 0.26, 0.014, 1.0, 205, 0.29, 7850, "C"),
    "ss316l": (305, 1161, 0.61, 0.01, 1.0, 193, 0.3, 8000, "C"),
    "sae1070": (1408, 600.8, 0.234, 0.0134, 1.0, 205, 0.29, 7850, "C"),
}
# m, melting temperature [K], specific heat [J/kg/K]; the sets of IN718 and SAE 1070 have no m.
THERMAL = {
    "al2024-t351": (1.7, 775.0, 875.0),
    "al2024-t351-jc1983": (1.0, 775.0, 875.0),
    "al2024-t351-wierzbicki": (1.0, 775.0, 875.0),
    "al7075-t6": (1.56, 750.0, 960.0),
    "ti6al4v": (1.1, 1873.0, 526.3),
    "steel4340": (1.03, 1793.0, 477.0),
    "ss316l": (0.517, 1673.0, 470.0),
}
# Nominal diameters [mm].
SHOTS = {
    "S70": 0.18,
    "S110": 0.30,
    "S170": 0.425,
    "S230": 0.60,
    "S280": 0.71,
    "S330": 0.85,
    "S390": 1.00,
    "S460": 1.18,
    "S550": 1.40,
    "S660": 1.70,
    "S780": 2.00,
    "S930": 2.36,
    "CW14": 0.35,
    "CW62": 1.60,
    # Middles of the sieve bands.
    "AZB150": (0.15 + 0.21) / 2,
    "AZB210": (0.21 + 0.30) / 2,
    "AZB300": (0.30 + 0.425) / 2,
    "AZB425": (0.425 + 0.60) / 2,
    "AZB600": (0.60 + 0.85) / 2,
    "AZB850": (0.85 + 1.18) / 2,
}


def groups_with_numbers(table, path):
    """(path, table that holds numbers, the source and grade in force there), all the way down."""
    for key, value in table.items():
        here = f"{path}.{key}"
        if isinstance(value, dict):
            inherited = {name: table[name] for name in ("source", "grade") if name in table}
            yield from groups_with_numbers(inherited | value, here)
        elif isinstance(value, int | float):
            yield path, table


@pytest.mark.parametrize("file", [material_tables, shot_tables], ids=["materials", "shots"])
def test_every_number_has_a_source_and_a_grade(file):
    found = 0
    for path, table in groups_with_numbers(file(), ""):
        found += 1
        assert isinstance(table.get("source"), str) and table["source"], path
        assert table.get("grade") in set(GRADES), path
    assert found > 50


@pytest.mark.parametrize("key", REFERENCE)
def test_material_numbers(key):
    A, B, n, C, rate_ref, E, nu, density, grade = REFERENCE[key]
    m = material(key)
    law = m.johnson_cook
    assert (law.A_Pa, law.B_Pa) == (pytest.approx(A * MPa, rel=1e-15), pytest.approx(B * MPa, rel=1e-15))
    assert (law.n, law.C, law.rate_ref_1_s) == (n, C, rate_ref)
    assert (law.m, law.melting_K, law.specific_heat_J_kg_K) == THERMAL.get(key, (0.0, None, None))
    assert (law.reference_K, law.taylor_quinney, law.saturation_Pa) == (293.0, 0.9, None)
    assert m.single_law is law
    assert m.E_Pa == pytest.approx(E * GPa, rel=1e-15)
    assert (m.key, m.nu, m.density_kg_m3, m.grade) == (key, nu, density, grade)
    assert "grade C" in m.combined_source


def test_all_materials_are_in_the_reference():
    assert material_keys() == list(REFERENCE)


def test_the_bounded_law_of_2024_is_the_chosen_one():
    law = material("al2024-t351").combined
    assert (law.R0_Pa, law.Q_Pa, law.b) == (270e6, 80e6, 12.0)
    assert law.backstresses == ((130e6, 300.0), (60e6, 12.0))
    assert material("al2024-t351").combined_source.startswith("chosen by this project")
    assert "fitted on T3" in material("al2024-t351").name


@pytest.mark.parametrize("grade", SHOTS)
def test_shot_diameters(grade):
    assert shot(grade).diameter_m == pytest.approx(SHOTS[grade] * 1e-3, rel=1e-12)


@pytest.mark.parametrize(
    "grade, medium, E, nu, density",
    [
        ("S390", "cast-steel", 210, 0.3, 7800),
        ("CW28", "cut-wire", 210, 0.3, 7800),
        ("GLASS200", "glass", 70, 0.22, 2500),
        ("AZB300", "ceramic", 300, 0.27, 3850),
    ],
)
def test_shot_substances(grade, medium, E, nu, density):
    s = shot(grade)
    assert (s.grade, s.medium, s.E_Pa, s.nu, s.density_kg_m3) == (grade, medium, E * GPa, nu, density)
    assert (s.size, s.size_cv, s.evidence) == ("mono", 0.0, "C")


def test_cut_wire_is_named_after_thousandths_of_an_inch():
    """To the hundredth of a millimetre to which the list is given (CW62, 1/16 inch, is sold as 1.6 mm)."""
    for grade in shot_grades():
        if grade.startswith("CW") and grade != "CW62":
            assert shot(grade).diameter_m == pytest.approx(int(grade[2:]) * 25.4e-6, abs=6e-6)


def test_catalogue_entries_lie_within_the_ranges_of_the_scene_file():
    for grade in shot_grades():
        for size in ("mono", "distribution"):
            s = shot(grade, size)
            for key in ("diameter_m", "density_kg_m3", "E_Pa", "nu"):
                assert schema.SHOTS[key].problem(getattr(s, key)) is None, (grade, key)
    for key in material_keys():
        m = material(key)
        for name in ("E_Pa", "nu", "density_kg_m3"):
            assert schema.MATERIAL[name].problem(getattr(m, name)) is None
        for name, field in schema.JOHNSON_COOK.items():
            assert field.problem(getattr(m.johnson_cook, name)) is None
        for name, field in schema.JOHNSON_COOK_OPTIONAL.items():
            value = getattr(m.johnson_cook, name)
            assert value is None or field.problem(value) is None


def test_nearest_names():
    assert closest("s390", shot_grades()) == "S390"
    assert closest("AL2024-T3", material_keys()) == "al2024-t351"
    assert closest("zirconium", material_keys()) is None
    with pytest.raises(InputError, match='no material "in71" in the catalogue; did you mean "in718"'):
        material("in71")
    with pytest.raises(InputError, match='no shot grade "S400" in the catalogue'):
        shot("S400")


def test_worst_grade_runs_from_derived_to_unverified():
    assert [worst_grade(pair) for pair in ("DA", "AB", "BC", "CD")] == ["A", "B", "C", "C"]


def test_presets():
    """dt/P, stiffness scale, elements per radius, steps per contact, speeds, cell side, elements, load steps and tolerance, raster points, stamp points."""
    fields = (
        "flow_dt_over_P",
        "flow_stiffness_scale",
        "dimple_elements_per_radius",
        "dimple_steps_per_contact",
        "dimple_speeds",
        "cell_side_in_radii",
        "cell_elements_per_side",
        "cell_load_steps",
        "cell_force_tolerance",
        "coverage_points_per_radius",
        "stamp_points_per_radius",
    )
    assert {name: tuple(getattr(p, f) for f in fields) for name, p in PRESETS.items()} == {
        "fast": (1.0, 1.0, 3, 90.0, 3, 4.0, 6, 2, 2e-2, 12.0, 12.0),
        "balanced": (1.0, 1.0, 6, 90.0, 5, 4.8, 8, 2, 1e-2, 20.0, 16.0),
        "reference": (0.3, 1.0, 12, 90.0, 9, 6.4, 12, 4, 2e-3, 40.0, 24.0),
    }
    assert all(p.preset == name for name, p in PRESETS.items())
