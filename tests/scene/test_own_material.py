"""One wrong number at a time in a material given in the scene."""

from __future__ import annotations

import pytest

from glue.scene.laws import CombinedHardening, HardeningTable
from glue.scene.reader import read_scene

JC_KEYS = (
    "A_Pa, B_Pa, n, C, rate_ref_1_s, m, reference_K, taylor_quinney, melting_K, specific_heat_J_kg_K, saturation_Pa"
)
OWN_MATERIAL = {
    "target.material": None,
    "target.material.E_Pa": "205e9",
    "target.material.nu": "0.29",
    "target.material.density_kg_m3": "7850.0",
    "target.material.johnson_cook": "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36}",
}
IN_MATERIAL = {
    ("E_Pa", "205"): "E_Pa: 205 is out of range; this key is in pascals (205 GPa is written 2.05e11); "
    "allowed 1e9..1e12 Pa",
    ("nu", "0.4999"): "nu: 0.4999 is out of range; allowed 0..0.49 "
    "(towards 0.5 the elements lock and the surface stress is wrong)",
    (
        "density_kg_m3",
        "2.78",
    ): "density_kg_m3: 2.78 is out of range; this key is in kilograms per cubic metre "
    "(2.78 g/cm3 is written 2780); allowed 500..25000 kg/m3",
    ("Epa", "1.0"): 'Epa: unknown key; did you mean "E_Pa"? '
    "allowed: name, source, E_Pa, nu, density_kg_m3, johnson_cook, voce, table, combined",
    (
        "johnson_cook",
        None,
    ): "johnson_cook: missing, and required; write a table [target.material.johnson_cook] "
    f"with {JC_KEYS}; or voce, or table",
    (
        "johnson_cook",
        "{A_Pa = 350, B_Pa = 275e6, n = 0.36}",
    ): "johnson_cook.A_Pa: 350 is out of range; this key is "
    "in pascals (350 MPa is written 3.5e8); allowed 1e6..5e9 Pa",
    (
        "johnson_cook",
        "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36, melt_K = 1.0}",
    ): f'johnson_cook.melt_K: unknown key; did you mean "melting_K"? allowed: {JC_KEYS}',
    (
        "johnson_cook",
        "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36, melting_K = 290}",
    ): "johnson_cook.melting_K: 290 is no more than reference_K; allowed above 293 K",
    (
        "johnson_cook",
        "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36, saturation_Pa = 350e6}",
    ): "johnson_cook.saturation_Pa: 3.5e8 is no more than A_Pa, so that nothing hardens; allowed above 3.5e8, "
    "or B_Pa = 0 without a saturation",
    (
        "johnson_cook",
        "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36, specific_heat_J_kg_K = 0.46}",
    ): "johnson_cook.specific_heat_J_kg_K: 0.46 is out of range; this key is in joules per kilogram and kelvin "
    "(0.46 kJ/kg/K is written 460); allowed 50..5000 J/kg/K",
    ("voce", "{R0_Pa = 300e6, Q_Pa = 100e6, b = 10}"): "voce: stands beside johnson_cook; "
    "allowed: one monotonic curve, of johnson_cook, voce, table",
    ("combined", "1"): "combined: must be a table [target.material.combined], not the integer 1",
    (
        "combined",
        "{R0_Pa = 270, Q_Pa = 80e6, b = 12}",
    ): "combined.R0_Pa: 270 is out of range; this key is in pascals "
    "(270 MPa is written 2.7e8); allowed 100000..5e9 Pa",
    (
        "combined",
        "{R0_Pa = 270e6, Q_Pa = 80e6, b = 12, backstresses = [1]}",
    ): "combined.backstresses: is no list of "
    "backstresses; allowed: an array of up to 2 tables { X_Pa = …, gamma = … }",
    (
        "combined",
        "{R0_Pa = 270e6, Q_Pa = 80e6, b = 12, backstresses = [{X_Pa = 1e6, gamma = 0}]}",
    ): "combined.backstresses[1].gamma: 0 is out of range; allowed 0.01..100000",
}


@pytest.mark.parametrize("case", IN_MATERIAL, ids=lambda case: f"{case[0]} = {str(case[1])[:40]}")
def test_one_wrong_number_in_an_own_material(case, problems_of):
    key, value = case
    assert problems_of(OWN_MATERIAL | {f"target.material.{key}": value}) == [
        f"target.material.{IN_MATERIAL[case]}"
    ]


WITHOUT_CURVE = OWN_MATERIAL | {"target.material.johnson_cook": None}
ROWS = "allowed: 2 to 50 rows [plastic strain, stress in Pa], the first at strain 0"


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("1", f"table: is no list of pairs, the integer 1; {ROWS}"),
        ("[[0, 300e6], [0.1]]", f"table: is no list of pairs, an array; {ROWS}"),
        ("[[0, 300e6]]", f"table: has 1 rows; {ROWS}"),
        ("[[0, 300], [0.1, 400]]", "table[1]: 300 is out of range; this key is in pascals (300 MPa is written 3e8); "
         "allowed 100000..1e10 Pa"),
        ("[[0, 300e6], [nan, 400e6]]", "table[2]: must be a finite number, not nan; allowed 0..10"),
        ("[[0.002, 300e6], [0.1, 400e6]]", f"table[1]: begins at strain 0.002; {ROWS}"),
        ("[[0, 300e6], [0.1, 400e6], [0.1, 410e6]]", "table[3]: strain 0.1 does not rise; allowed above 0.1"),
        ("[[0, 300e6], [0.1, 290e6]]", "table[2]: 2.9e8 Pa softens: the answer would hang on the mesh; "
         "allowed 3e8 Pa or more"),
    ],
)  # fmt: skip
def test_a_wrong_table(table, expected, problems_of):
    assert problems_of(WITHOUT_CURVE | {"target.material.table": table}) == [f"target.material.{expected}"]


def test_a_table_is_linear_between_its_points_and_constant_beyond(write_scene):
    scene = read_scene(write_scene(WITHOUT_CURVE | {"target.material.table": "[[0, 300e6], [0.1, 400e6], [0.5, 420e6]]"}))
    material = scene.target.material
    assert material.single_law == HardeningTable((0.0, 0.1, 0.5), (300e6, 400e6, 420e6))
    assert material.johnson_cook is None
    stress = [material.single_law.flow_stress_Pa(p) for p in (0.0, 0.05, 0.1, 0.3, 0.5, 7.0)]
    assert stress == pytest.approx([300e6, 350e6, 400e6, 410e6, 420e6, 420e6])
    assert "derived from table" in material.combined_source


def test_voce_is_a_law_without_backstresses(write_scene):
    scene = read_scene(write_scene(WITHOUT_CURVE | {"target.material.voce": "{R0_Pa = 300e6, Q_Pa = 100e6, b = 10}"}))
    assert scene.target.material.single_law == CombinedHardening(300e6, 100e6, 10.0, ())
    assert "derived from voce" in scene.target.material.combined_source


def test_a_saturation_caps_the_power_law(write_scene):
    curve = "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36, saturation_Pa = 500e6}"
    law = read_scene(write_scene(OWN_MATERIAL | {"target.material.johnson_cook": curve})).target.material.single_law
    assert law.flow_stress_Pa(0.1) == pytest.approx(350e6 + 275e6 * 0.1**0.36)
    assert law.flow_stress_Pa(1.0) == 500e6
