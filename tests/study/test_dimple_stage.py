"""Which impacts stand for a scene, what its dimple is refused for, what is warned of."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from flow_runs import dimple

from glue.errors import InputError
from glue.scene import catalogue
from glue.scene.effects import StrainRate, Switch
from glue.scene.laws import HardeningTable
from glue.scene.reader import example_path, read_scene
from glue.scene.presets import PRESETS
from glue.study.choices import choices
from glue.study.dimple_stage import dimple_metrics, law_text, other_speeds, refuse_dimple
from glue.study.single import dimple_library, formulas_table, formulas_text, library_text
from glue.target.library import Library
from glue.target.physics import ImpactPhysics


@pytest.fixture(scope="module")
def scene():
    return read_scene(example_path("al2024-s390"))


def with_nozzle(scene, **changes):
    return dataclasses.replace(scene, nozzles=(dataclasses.replace(scene.nozzle, **changes),))


def with_medium(scene, **changes):
    return dataclasses.replace(scene, media=(*scene.media, dataclasses.replace(scene.shots, mass_fraction=0.5, **changes)))


@pytest.mark.parametrize("preset", PRESETS)
def test_speeds_halve_or_so_down_to_a_sixteenth(preset):
    speeds = other_speeds(read_scene(example_path("al2024-s390"), preset=preset))
    assert len(speeds) == PRESETS[preset].dimple_speeds - 1 and speeds[0] == 3.75 and max(speeds) < 60.0
    np.testing.assert_allclose(np.diff(np.log([*speeds, 60.0])), np.log(16.0) / len(speeds), rtol=1e-8)


def test_the_fastest_shot_of_any_nozzle_and_medium_is_solved_too(scene):
    assert other_speeds(with_nozzle(scene, speed_cv=0.1))[-1] == pytest.approx(with_nozzle(scene, speed_cv=0.1).fastest_m_s)
    small_and_heavy = with_medium(scene, diameter_m=0.2e-3, density_kg_m3=4 * 7800.0)
    assert other_speeds(small_and_heavy)[-1] == pytest.approx(120.0)  # as fast as 120 m/s of steel
    oblique = with_nozzle(scene, speed_cv=0.1, impact_angle_deg=30.0)
    assert other_speeds(oblique)[-1] == pytest.approx(0.5 * oblique.fastest_m_s)


def test_shots_to_which_the_dimple_cannot_be_scaled_are_refused_before_anything_runs(scene):
    small, glass = with_medium(scene, diameter_m=0.3e-3), with_medium(scene, density_kg_m3=2500.0)
    for fine in (scene, small, glass, dataclasses.replace(small, target_inertia=Switch())):
        refuse_dimple(fine)
    with pytest.raises(InputError, match=r"strain_rate: .* 0.3 to 1 times that; allowed within a factor 1.83"):
        refuse_dimple(dataclasses.replace(small, strain_rate=StrainRate()))
    for block in ("target_inertia", "elastic_shot"):
        with pytest.raises(InputError, match="media of one density"):
            refuse_dimple(dataclasses.replace(glass, **{block: Switch()}))


def test_choices_name_the_physics_and_the_law(scene):
    told = choices(dataclasses.replace(scene, strain_rate=StrainRate(), elastic_shot=Switch(auto=True)))
    assert told["strain rate"]["model"] == told["elastic shot"]["model"] == "on"
    assert "with rate term" in told["dimple law"]["why"]
    assert "no rate term" in choices(scene)["dimple law"]["why"]
    material = scene.target.material
    table = dataclasses.replace(material, johnson_cook=None, table=HardeningTable((0.0, 0.2), (3e8, 5e8)))
    assert law_text(table) == ("table", "2 points to 500 MPa at strain 0.2")
    assert law_text(dataclasses.replace(material, voce=material.combined))[0] == "voce"
    assert choices(dataclasses.replace(scene, target=dataclasses.replace(scene.target, material=table)))


def test_warnings_of_strain_and_of_a_shot_that_yields():
    assert "warning" not in dimple_metrics(dimple(), "cast-steel")
    torn = dataclasses.replace(dimple(), largest_peeq=1.5)
    assert "plastic strain reaches 1.5" in dimple_metrics(torn)["warning"]
    soft = dataclasses.replace(dimple(), centre_pressure_Pa=4e9, mean_pressure_Pa=2.5e9)
    assert "the shot yields inside" in dimple_metrics(soft, "cast-steel")["warning"]
    assert "warning" not in dimple_metrics(soft, "ceramic")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("60", 12, None), "must be SLOWEST:FASTEST"),
        (("60:20", 12, None), "the first must be below the second"),
        (("0.1:60", 12, None), r"0.5..300 m/s"),
        (("1:nan", 12, None), r"0.5..300 m/s"),
        (("1:60", 2, None), "--points 2: allowed 3 to"),
        (("1:60", 12, 0), "--jobs 0"),
    ],
)
def test_bad_libraries_are_refused_in_words(arguments, says):
    speeds, points, jobs = arguments
    with pytest.raises(InputError, match=says):
        dimple_library("al2024-t351", speeds, points, "S390", None, jobs, None, None)


def test_the_printed_library_and_its_comparison(monkeypatch):
    class Shown(Library):
        def column(self, name):
            v = np.array(self.speeds_m_s)
            return {"radius": 0.06 * v**0.5, "restitution": 0.7 * v**-0.2}.get(name, 0.002 * v)

    shown = Shown(catalogue.material("al2024-t351"), (1.0, 4.0, 16.0, 64.0), (), 7800.0, 6, ImpactPhysics())
    text = library_text(shown)
    assert "radius ~ v^0.500 (error 0.00%)" in text and "curves for 1 to 64 m/s, not beyond" in text
    rows = formulas_table(shown)
    assert [r["speed_m_s"] for r in rows] == [1.0, 4.0, 16.0, 64.0]
    # all go with the root of the speed, apart from Kirk's by 1 - e^2
    assert rows[0]["al-hassani"] == pytest.approx(rows[3]["al-hassani"], rel=1e-12)
    kirks = (1 - 0.49) / (1 - (0.7 * 64**-0.2) ** 2)
    assert rows[0]["kirk"] / rows[3]["kirk"] == pytest.approx(kirks**0.25, rel=1e-12)
    assert "al-hassani   within 5 %" in formulas_text(shown.material, rows)
