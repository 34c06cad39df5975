"""The table of optional physics: complete, decided by its numbers, and nothing in the solvers' inputs for what is left out."""

from __future__ import annotations

import dataclasses
import json
import math

import pytest

from glue.flow.drag import kick_interval_s, surroundings
from glue.flow.event_setup import physics_of
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.catalogue import material
from glue.scene.effects import AirDrag, Gravity, StrainRate, Switch
from glue.scene.laws import CombinedHardening
from glue.scene.model import Friction
from glue.scene.reader import EXAMPLES, example_path, read_scene
from glue.study import pieces
from glue.study.check import check
from glue.study.check_text import check_text
from glue.target import regime
from glue.target.driver import law_table
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import Numerics, _parameters

# The pieces that the table's task names.
NAMED = ("shot-shot collisions", "gravity", "drag", "spin and friction", "shot elasticity", "target inertia", "strain rate", "heating",
         "finite strain", "kinematic hardening", "edges of the part", "thickness of the part", "overlap of dimples")  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    return read_scene(example_path("al2024-s390"))


def table(scene, e: float = 0.34, hits: float = 2.0) -> dict[str, pieces.Piece]:
    return {row.piece: row for row in pieces.pieces(scene, e, hits)}


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_every_example_has_the_whole_table(path):
    rows = table(read_scene(path, provisional=True))
    assert set(NAMED) <= set(rows)
    for row in rows.values():
        assert row.decision in ("on", "off") and row.why and row.saving and row.source
        assert row.number is None or (math.isfinite(row.number) and row.number >= 0.0)
        assert (row.threshold is None) or row.source.startswith("make ")


def test_check_shows_it_and_json_holds_it(scene):
    found = json.loads(json.dumps(check(scene), allow_nan=False))["pieces"]
    assert set(NAMED) <= {row["piece"] for row in found}
    text = check_text(scene)
    assert all(name in text for name in NAMED)
    assert "left out, though by its number it matters" in text and "target inertia" in text


def test_decisions_follow_what_runs(scene):
    off = table(scene)
    assert off["gravity"].decision == off["drag"].decision == off["target inertia"].decision == off["heating"].decision == "off"
    on = table(dataclasses.replace(
        scene, gravity=Gravity(9.81), air_drag=AirDrag(1.2, 1.8e-5), target_inertia=Switch(), elastic_shot=Switch(),
        strain_rate=StrainRate(thermal=True), friction=Friction(0.2, 0.2, in_dimple=True),
    ))  # fmt: skip
    names = ("gravity", "drag", "target inertia", "shot elasticity", "strain rate", "heating", "friction in the dimple", "spin and friction")
    assert {on[name].decision for name in names} == {"on"}
    assert not any(row.misfit for row in on.values())


def test_auto_decides_by_the_number(scene):
    light = regime.THRESHOLDS["elastic_shot"]
    for modulus, decision in ((210e9, "on"), (1.2e12, "on"), (9e12, "off")):
        media = (dataclasses.replace(scene.shots, E_Pa=modulus),)
        row = table(dataclasses.replace(scene, media=media, elastic_shot=Switch(auto=True)))["shot elasticity"]
        assert row.decision == decision == ("on" if row.number > light else "off")


def test_a_piece_left_out_that_matters_is_marked(scene):
    rows = table(scene)
    assert rows["target inertia"].misfit and not rows["gravity"].misfit
    slow = dataclasses.replace(scene, nozzles=(dataclasses.replace(scene.nozzle, speed_m_s=2.0),))
    assert table(slow)["gravity"].misfit


def test_numbers_of_hardening_and_heat():
    assert pieces.backstress_share(CombinedHardening(300e6, 100e6, 10.0, ((100e6, 50.0),))) == pytest.approx(0.2)
    al, steel = material("al2024-t351"), read_scene(example_path("al2024-s390")).shots
    numbers = [regime.heat_number(al, steel, v) for v in (5.0, 20.0, 60.0)]
    assert numbers == sorted(numbers) and 0.0 < numbers[0] < numbers[-1] < 0.01
    cold = dataclasses.replace(al, johnson_cook=dataclasses.replace(al.johnson_cook, melting_K=None))
    assert regime.heat_number(cold, steel, 60.0) == 0.0


def test_physics_left_out_is_in_no_input_of_the_flow(scene):
    """No gas, no gravity, no spots: flights in one step, and nothing kept of where shots struck."""
    around = surroundings(scene)
    assert around == type(around)(*[0.0] * len(around)) and kick_interval_s(scene) == math.inf
    physics = physics_of(scene, RestitutionLaw(0.5), TargetSurface())
    assert physics.kick_loss_m_s == math.inf and physics.spot_radius_m == 0.0 and not any(physics.pull)


def test_physics_left_out_is_in_no_input_of_the_impact():
    """The driver of a plain impact has neither mass of the target nor modulus of the shot, friction, rate or heat."""
    al = material("al2024-t351")
    lines = {p.name: p.value for p in _parameters(al, al.johnson_cook, 60.0, 7800.0, 3, Numerics(), ImpactPhysics())}
    assert lines["targetInertia"] == 0 and lines["shotModulus"] == 0.0 and lines["frictionCoefficient"] == 0.0 and lines["hits"] == 1
    table = law_table(al.E_Pa, al.nu, al.johnson_cook)
    with_it = law_table(al.E_Pa, al.nu, al.johnson_cook, radius_m=0.5e-3, density_kg_m3=al.density_kg_m3, rate=True, thermal=True)
    changed = [k for k, (a, b) in enumerate(zip(table, with_it, strict=True)) if a != b]
    assert len(changed) == 6 and all(table[k] == 0.0 for k in changed)


def test_thresholds_are_those_that_decide():
    assert {k: pieces.THRESHOLDS[k] for k in regime.THRESHOLDS} == regime.THRESHOLDS
    assert set(pieces.THRESHOLDS) == set(pieces.TOLERANCES)
