"""Drivers say what they were asked to say, to the last digit, and refuse what FreeFEM would misread."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path

import numpy as np
import pytest
from helpers import dimple

from glue.errors import InputError
from glue.scene.catalogue import material
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
@pytest.mark.parametrize("name", ["single_impact", "cell"])
@pytest.mark.parametrize("flavour", ["kernel", "script"])
def test_golden_driver_compiles(name, flavour, tmp_path):
    text = (GOLDEN / f"{name}.edp").read_text()
    assert "_kernel.idp" in text
    driver = tmp_path / "driver with a space.edp"
    driver.write_text(text.replace("_kernel.idp", f"_{flavour}.idp"))
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
