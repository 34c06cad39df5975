"""What the flow is told: restitution from the dimple or the scene, solvers only where they run."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.restitution import RestitutionLaw
from glue.scene.model import Choice, Restitution, SpotHardening
from glue.scene.reader import example_path, read_scene
from glue.study.flow_stage import (
    RESTITUTION_GUESS,
    flow_solvers,
    refuse_flow,
    restitution_estimate,
    restitution_law,
)

DIMPLE = SimpleNamespace(
    restitution=0.34, restitution_exponent=0.25, speed_m_s=60.0, radius_m=0.2e-3, density_kg_m3=7800.0,
    table_speed_m_s=np.empty(0), table_restitution=np.empty(0),
)  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    return read_scene(example_path("al2024-s390"))


def with_restitution(scene, value, hardening=None):
    return dataclasses.replace(scene, restitution=Restitution(value, 0.8, hardening))


def test_the_dimples_rebound_falls_with_the_speed(scene):
    law = restitution_law(with_restitution(scene, "from_dimple"), DIMPLE)
    assert law.at(60.0) == pytest.approx(0.34) and law.at(30.0) == pytest.approx(0.34 * 2**0.25)
    assert law.at(0.01) == 0.94  # the contact law's cap
    assert law.spot_radius_m == 0.2e-3


def test_the_dimples_table_goes_to_the_law_and_never_rises(scene):
    table = SimpleNamespace(**{
        **vars(DIMPLE), "table_speed_m_s": np.array([3.75, 15.0, 30.0, 60.0]), "table_restitution": np.array([0.5, 0.42, 0.425, 0.34])
    })  # fmt: skip
    law = restitution_law(with_restitution(scene, "from_dimple"), table)
    assert [law.at(v) for v in (3.75, 15.0, 30.0, 60.0)] == pytest.approx([0.5, 0.42, 0.42, 0.34])
    # as dense as glass: as if slower by the root of the ratio
    assert law.at(60.0, 2500.0) == pytest.approx(law.at(60.0 * (2500 / 7800) ** 0.5))
    assert law.at(60.0, 2500.0) > 0.36
    assert RestitutionLaw.from_dict(json.loads(json.dumps(law.as_dict()))) == law


def test_a_number_is_constant_and_may_be_anything_up_to_one(scene):
    for e in (0.6, 0.97, 1.0):
        law = restitution_law(with_restitution(scene, e), DIMPLE)
        assert law.at(1.0) == law.at(100.0) == e


def test_hardening_goes_to_the_law(scene):
    law = restitution_law(with_restitution(scene, "from_dimple", SpotHardening(0.6, 3.0)), DIMPLE)
    assert law.at_spot(0.34, 0) == pytest.approx(0.34) and 0.34 < law.at_spot(0.34, 3) < 0.6


@pytest.mark.parametrize("change", [{"restitution": 1.2}, {"restitution_exponent": 1.5}, {"restitution_exponent": -0.5}])
def test_a_rebound_that_cannot_be_is_told(scene, change):
    with pytest.raises(InputError, match="write a number into the scene"):
        restitution_law(with_restitution(scene, "from_dimple"), SimpleNamespace(**{**vars(DIMPLE), **change}))


def test_a_trace_of_rise_with_speed_is_no_error(scene):
    rising = SimpleNamespace(**{**vars(DIMPLE), "restitution_exponent": -1e-3})
    assert restitution_law(with_restitution(scene, "from_dimple"), rising).exponent == 0.0


def test_the_estimate_knows_where_it_is_from(scene, tmp_path):
    assert restitution_estimate(with_restitution(scene, 0.7), tmp_path) == (0.7, "the scene")
    e, source = restitution_estimate(with_restitution(scene, "from_dimple"), tmp_path)
    assert e == RESTITUTION_GUESS and "guess" in source


def asking(scene, model):
    return dataclasses.replace(scene, models=dataclasses.replace(scene.models, flow=Choice(model, "test")))


def test_yade_is_needed_only_for_contacts(scene):
    assert flow_solvers(asking(scene, "dem"), Path("none")) == ("yade",)
    assert flow_solvers(asking(scene, "event"), Path("none")) == flow_solvers(asking(scene, "ballistic"), Path("none")) == ()


def test_what_only_contacts_refuse_is_told_before_the_dimple(scene):
    high = with_restitution(scene, 0.97)
    with pytest.raises(InputError, match="restitution on the target 0.970"):
        refuse_flow(asking(high, "dem"), Path("scene.toml"))
    refuse_flow(asking(high, "event"), Path("scene.toml"))
