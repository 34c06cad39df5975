"""Drivers say what they were asked to say, to the last digit, and refuse what FreeFEM would misread."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import dimple

from glue.errors import InputError
from glue.scene.catalogue import material
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook
from glue.scene.presets import PRESETS
from glue.solvers import compile_freefem
from glue.target import reduced_impact
from glue.target.cell import cell_driver
from glue.target.driver import Parameter, law_table, write_driver
from glue.target.patch import Patch

GOLDEN = Path(__file__).parents[1] / "golden"
AL2024 = material("al2024-t351")


def single_impact_text() -> str:
    parameters = reduced_impact._parameters(AL2024, AL2024.johnson_cook, 60.0, 7800.0, 6, reduced_impact.Numerics())
    head = [
        Parameter("string", "outDir", ".", "folder of the results"),
        Parameter("string", "statusFile", "status", "written last"),
    ]
    return write_driver(
        "golden single impact", head + parameters, ["points_axisym_kernel.idp", "single_impact.edp"]
    )


def cell_text() -> str:
    place = np.array([0.1e-3, 0.55e-3])
    patch = Patch(
        place,
        place[::-1],
        np.array([7.35e-3, 3.1e-3]),
        np.array([0.5e-3, 0.5e-3]),
        (0.0, 0.0),
        0.3,
        0.3,
        0,
        0.0,
    )
    law = law_table(AL2024.E_Pa, AL2024.nu, AL2024.combined)
    return cell_driver("golden", law, PRESETS["balanced"], dimple(), patch, 4.8 * 227e-6)


@pytest.mark.parametrize(("name", "text"), [("single_impact", single_impact_text), ("cell", cell_text)])
def test_golden_driver(name, text):
    """A driver changes only on purpose: PEEN_UPDATE_GOLDEN=1 pytest tests/target rewrites them."""
    path = GOLDEN / f"{name}.edp"
    if os.environ.get("PEEN_UPDATE_GOLDEN") == "1":
        path.write_text(text())
    assert text() == path.read_text()


@pytest.mark.solver
@pytest.mark.parametrize("text", [single_impact_text, cell_text], ids=["single_impact", "cell"])
@pytest.mark.parametrize("flavour", ["kernel", "script"])
def test_a_driver_compiles_with_and_without_kernels(text, flavour, tmp_path, monkeypatch):
    monkeypatch.setenv("PEEN_KERNEL", flavour)
    driver = tmp_path / "driver with a space.edp"
    driver.write_text(text().replace("_kernel.idp", f"_{flavour}.idp"))
    assert ("cell_small.edp" in driver.read_text()) == (flavour == "script" and text is cell_text)
    compile_freefem(driver)


def test_numbers_read_back_exactly():
    value = 0.1 + 0.2
    line = Parameter("real", "a", value, "m").line()
    assert float(re.search(r"= (\S+);", line).group(1)) == value


@pytest.mark.parametrize("value", [math.nan, math.inf, [1.0, -math.inf]])
def test_a_number_that_is_not_finite_never_reaches_a_driver(value):
    with pytest.raises(ValueError, match="finite"):
        Parameter("real", "a", value, "").line()


@pytest.mark.parametrize("path", ['a"b', "a\\b", "a\nb"])
def test_paths_that_would_end_the_string_are_refused(path):
    with pytest.raises(InputError, match="path"):
        Parameter("string", "p", path, "").line()


def test_law_table_is_in_MPa_in_the_kernels_order():
    none = [0] * 8
    assert law_table(73.1e9, 0.33, AL2024.johnson_cook) == pytest.approx(
        [73100, 0.33, 369, 684, 0.73, 0, 0, 0, 0, 0, 0, *none]
    )
    assert law_table(73.1e9, 0.33, AL2024.combined) == pytest.approx(
        [73100, 0.33, 270, 0, 1, 80, 12, 130, 300, 60, 12, *none]
    )


def test_rate_and_heat_in_the_units_of_the_shot():
    """Reference rate 1/s with R = .5 mm: 5e-4 in R/(1 m/s); heat: kelvins per MPa of plastic work, .9/(2780 . 875)."""
    law = AL2024.johnson_cook
    plain = law_table(73.1e9, 0.33, law)
    assert law_table(73.1e9, 0.33, law, radius_m=0.5e-3, rate=True)[12:14] == pytest.approx([0.0083, 5e-4])
    hot = law_table(73.1e9, 0.33, law, density_kg_m3=2780.0, thermal=True)
    assert hot[12:] == pytest.approx([0, 0, 1.7, 293, 775, 0.9e6 / (2780 * 875), 0])
    assert hot[:12] == plain[:12]
    # A rise of 1 K takes 2.7 MPa of plastic work: 2780 kg/m3 . 875 J/kg/K = 2.43 MJ/m3/K, over .9.
    assert 1 / hot[17] == pytest.approx(2.703, abs=1e-3)


def test_a_table_and_a_cap_in_the_array():
    table = HardeningTable((0.0, 0.1), (300e6, 400e6))
    assert law_table(73.1e9, 0.33, table)[2:] == pytest.approx([0, 0, 1] + [0] * 13 + [2, 0, 0.1, 300, 400])
    assert law_table(73.1e9, 0.33, replace(AL2024.johnson_cook, saturation_Pa=470e6))[11] == pytest.approx(470)


@pytest.mark.parametrize(
    ("law", "wanted", "said"),
    [
        (JohnsonCook(300e6, 0.0, 1.0), {"rate": True, "radius_m": 1e-3}, "no rate term; allowed: johnson_cook with C"),
        (AL2024.combined, {"rate": True, "radius_m": 1e-3}, "no rate term"),
        (AL2024.johnson_cook, {"rate": True}, "radius"),
        (material("in718").johnson_cook, {"thermal": True, "density_kg_m3": 8220.0}, "melting_K"),
        (AL2024.johnson_cook, {"thermal": True}, "density"),
        (CombinedHardening(300e6, 0.0, 1.0, ((1e6, 1.0),) * 3), {}, "at most two"),
    ],
)
def test_a_law_without_what_is_asked_of_it_is_refused(law, wanted, said):
    with pytest.raises(InputError, match=said):
        law_table(73.1e9, 0.33, law, **wanted)
