"""What a good scene reads as, and how whole files go wrong."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest

from glue.errors import InputError
from glue.scene.model import Choice, CombinedHardening, JohnsonCook
from glue.scene.presets import PRESETS
from glue.scene.reader import example_names, example_path, read_scene, resolved_dict

REPO = Path(__file__).resolve().parents[2]
DEBIAN_PYTHON = Path("/usr/bin/python3")


def test_the_shortest_scene_and_its_printed_defaults(write_scene):
    scene = read_scene(write_scene())
    assert (scene.name, scene.seed, scene.exposure_time_s) == ("trial", 1, 3.0)
    assert (scene.shots.grade, scene.shots.size, scene.shots.size_cv) == ("S390", "mono", 0.0)
    assert (scene.shots.diameter_m, scene.shots.density_kg_m3) == (1e-3, 7800.0)
    assert scene.nozzle.normal_speed_m_s == 60.0
    assert scene.target.window_m == (0.004, 0.004)
    assert scene.target.material.key == "al2024-t351"
    assert (scene.restitution.shot_target, scene.restitution.shot_shot) == ("from_dimple", 0.8)
    assert (scene.friction.shot_target, scene.friction.shot_shot) == (0.2, 0.2)
    assert scene.accuracy == PRESETS["balanced"]
    assert scene.defaults_used == (
        'arrivals = "poisson" (shots leave independently of each other; choice of this project)',
        'shots.size = "mono" (every shot of the same size; choice of this project)',
        "nozzle.azimuth_deg = 0 (shots fly towards +x; choice of this project)",
        "nozzle.aim_m = [0, 0] (the middle of the window; choice of this project)",
        'nozzle.profile = "uniform" (evenly over the exit; choice of this project)',
        "nozzle.divergence_half_angle_deg = 0 (a parallel jet; choice of this project)",
        "nozzle.speed_cv = 0 (every shot at the same speed; choice of this project)",
        "nozzle.feed_speed_m_s = 0 (a nozzle at rest; choice of this project)",
        'nozzle.mass_flow_pattern = "steady" (an even flow; choice of this project)',
        'target.thickness_m = "none" (a part too thick to stretch or bend; choice of this project)',
        'target.surface = "plane" (a flat target; choice of this project)',
        'restitution.shot_target = "from_dimple" (computed by the single impact of this scene; grade D)',
        "restitution.shot_shot = 0.8 (steel on steel, .6-.9; grade C)",
        "friction.shot_target = 0.2 (used in an open peening chain; grade A)",
        "friction.shot_shot = 0.2 (steel on steel, .1-.3; grade C)",
        "friction.in_dimple = false (the dimple is pressed without friction; choice of this project)",
        'gravity = "none" (straight flights: an absent block is not modelled)',
        'air_drag = "none" (flights in vacuum: an absent block is not modelled)',
        'strain_rate = "none" (laws that know no rate and no heat: an absent block is not modelled)',
        'target_inertia = "none" (a quasi-static target: an absent block is not modelled)',
        'elastic_shot = "none" (rigid shots in the dimple model: an absent block is not modelled)',
        'models.flow = "auto" (the cheapest that is accurate enough)',
        'models.dimple = "auto" (the models that this version has)',
        'models.target = "auto" (the layer model at preset fast, else the periodic cell)',
        'accuracy.preset = "balanced" (choice of this project)',
        "accuracy.target_patches = 1 (one patch of the window stands for all; choice of this project)",
    )


def test_auto_takes_the_models_that_exist_and_says_so(write_scene):
    models = read_scene(write_scene()).models
    # which flow model is cheap and accurate enough only the flow's own numbers tell
    assert (models.flow.model, models.dimple.model, models.target.model) == ("auto", "axisymmetric", "cell")
    asked_for = [("flow", word) for word in ("ballistic", "event", "dem")]
    for stage, word in (*asked_for, ("dimple", "axisymmetric"), ("target", "cell")):
        assert getattr(models, stage).why.startswith("auto: ")
        asked = read_scene(write_scene({f"models.{stage}": f'"{word}"'})).models
        assert getattr(asked, stage) == Choice(word, "asked for in the scene")


def test_integers_stand_for_floats_and_zero_feed_and_divergence_are_accepted(write_scene):
    scene = read_scene(
        write_scene(
            {
                "exposure_time_s": "3",
                "nozzle.speed_m_s": "60",
                "nozzle.impact_angle_deg": "90",
                "nozzle.divergence_half_angle_deg": "0",
                "nozzle.feed_speed_m_s": "0.0",
                "restitution.shot_shot": "1",
            }
        )
    )
    assert scene.nozzle.speed_m_s == 60.0 and isinstance(scene.nozzle.speed_m_s, float)
    assert scene.restitution.shot_shot == 1.0 and isinstance(scene.exposure_time_s, float)
    assert resolved_dict(scene) == resolved_dict(read_scene(write_scene({"restitution.shot_shot": "1.0"})))


@pytest.mark.parametrize("value", ["1e-3", "0.94", "1", "1.0"])
def test_the_ends_of_the_allowed_restitution(value, write_scene):
    assert read_scene(write_scene({"restitution.shot_target": value})).restitution.shot_target == float(value)


def test_shots_by_distribution(write_scene):
    """S390 spreads about 1.1 mm with a CV of .09; E[d^3] by numerical integration of the normal cut at 2.5 sd."""
    scene = read_scene(write_scene({"shots.size": '"distribution"'}))
    assert scene.shots.diameter_m == pytest.approx(1.1e-3, rel=1e-15)
    assert scene.shots.size_cv == 0.09
    t = np.linspace(-2.5, 2.5, 200_001)
    weight = np.exp(-0.5 * t**2)
    mass = 7800.0 * math.pi / 6.0 * np.average((1.1e-3 * (1.0 + 0.09 * t)) ** 3, weights=weight)
    assert scene.shot_rate_1_s == pytest.approx(0.01667 / mass, rel=1e-6)
    assert any(line.startswith("shots.size_cv = 0.09 (") for line in scene.defaults_used)
    assert any(line.startswith("shots.diameter_m = 0.0011 (mean of the") for line in scene.defaults_used)
    own = read_scene(write_scene({"shots.size": '"distribution"', "shots.size_cv": "0.05"}))
    assert own.shots.size_cv == 0.05
    assert not any(line.startswith("shots.size_cv") for line in own.defaults_used)


def test_own_shots_take_steel_constants_by_default_and_say_so(write_scene):
    scene = read_scene(write_scene({"shots": "{diameter_m = 0.001, density_kg_m3 = 7800}"}))
    assert (scene.shots.E_Pa, scene.shots.nu, scene.shots.medium) == (210e9, 0.3, "own")
    assert (scene.shots.grade, scene.shots.evidence) == (None, "C")
    assert "shots.E_Pa = 2.1e11 (steel; grade C)" in scene.defaults_used


def test_own_material_given_in_full(write_scene):
    changes = {
        "target.material": None,
        "target.material.E_Pa": "205e9",
        "target.material.nu": "0.29",
        "target.material.density_kg_m3": "7850",
        "target.material.johnson_cook": "{A_Pa = 350e6, B_Pa = 275e6, n = 0.36}",
        "target.material.combined": "{R0_Pa = 240e6, Q_Pa = 85e6, b = 12, "
        "backstresses = [{X_Pa = 115e6, gamma = 300}, {X_Pa = 65e6, gamma = 12}]}",
    }
    material = read_scene(write_scene(changes)).target.material
    assert material.johnson_cook == JohnsonCook(350e6, 275e6, 0.36, 0.0, 1.0)
    assert material.combined == CombinedHardening(240e6, 85e6, 12.0, ((115e6, 300.0), (65e6, 12.0)))
    assert (material.key, material.grade, material.combined_source) == ("own", "C", "given in the scene")

    del changes["target.material.combined"]
    scene = read_scene(write_scene(changes))
    assert "hardening.py" in scene.target.material.combined_source
    assert any(
        line.startswith('target.material.combined = "bounded law" (derived') for line in scene.defaults_used
    )


@pytest.mark.parametrize("preset", PRESETS)
def test_presets_change_numerics_and_the_target_left_to_auto_only(preset, write_scene):
    plain = read_scene(write_scene())
    target = {"fast": "layers", "balanced": "cell", "reference": "cell"}[preset]
    by_file = read_scene(write_scene({"accuracy.preset": f'"{preset}"'}))
    assert by_file.models.target.model == target
    models = dataclasses.replace(plain.models, target=by_file.models.target)
    assert by_file == dataclasses.replace(plain, accuracy=PRESETS[preset], models=models)
    asked = read_scene(write_scene({"accuracy.preset": f'"{preset}"', "models.target": '"contact"'}))
    assert asked.models.target.model == "contact"
    assert read_scene(write_scene({"accuracy.preset": '"fast"'}), preset=preset) == by_file
    given = read_scene(write_scene({"accuracy": "{}"}), preset=preset)
    assert given == by_file
    assert not any(line.startswith("accuracy.preset") for line in given.defaults_used)  # it was not a default


def test_a_wrong_preset_argument_is_named_as_such(problems_of):
    assert problems_of({}, preset="fats") == [
        'accuracy preset given for this run: unknown value "fats"; did you mean "fast"? '
        'allowed "fast", "balanced", "reference"'
    ]
    # An argument does not hide a wrong file.
    (problem,) = problems_of({"accuracy.preset": '"best"'}, preset="fast")
    assert problem.startswith('accuracy.preset: unknown value "best"')


def test_all_problems_at_once(problems_of):
    problems = problems_of(
        {
            "schema": "3",
            "seed": None,
            "exposure_time_s": "nan",
            "coverage_percent": "98",
            "nozle": "1",
            "gravity": '"on"',
            "shots.grade": '"S391"',
            "nozzle.speed_m_s": "6000.0",
            "nozzle.stand_off_m": "0.001",
            "target.material": '"al2025"',
            "target.window_m": "[0.004, nan]",
            "restitution.shot_shot": "0.99",
            "models.flow": '"events"',
            "accuracy.preset": '"best"',
        },
        preset="worst",
    )
    assert [problem.split(":")[0] for problem in problems] == [
        "nozle",
        "schema",
        "seed",
        "exposure_time_s",
        "coverage_percent",
        "shots.grade",
        "nozzle.speed_m_s",
        "target.material",
        "target.window_m",
        "restitution.shot_shot",
        "gravity",
        "models.flow",
        "accuracy.preset",
        "accuracy preset given for this run",
    ]


def test_the_error_carries_every_problem_with_the_file_in_its_text(write_scene):
    path = write_scene({"seed": "-1", "name": "1"})
    with pytest.raises(InputError) as caught:
        read_scene(path)
    assert len(caught.value.problems) == 2 and caught.value.exit_code == 2
    assert all(line.startswith(f"{path}: ") for line in str(caught.value).splitlines())


@pytest.mark.parametrize(
    "content, sentence",
    [
        (b"schema = 1\nname = trial\n", "line 2"),
        (b"schema = 1\nschema = 1\n", "Cannot overwrite a value (at line 2"),
        (b"schema = 1\n\n[shots\n", "line 3"),
        (b'schema = 1\nname = "open', "line 2, the end of the file"),
        (b"schema = 1\nsize_cv = .1\n", "Invalid value (at line 2, column 11): size_cv = .1"),
        (b"schema = 1\nname = 'caf\xe9'\n", "line 2: byte 0xe9 is not UTF-8; allowed: text saved as UTF-8"),
        (b"seed = " + b"[" * 20000, "nested too deeply"),
        (b"seed = " + b"9" * 5000, "is not valid TOML"),
    ],
)
def test_a_broken_file_names_the_line(content, sentence, tmp_path):
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_scene(path)
    (problem,) = caught.value.problems
    assert problem.startswith(f"{path}: ") and sentence in problem


def test_a_missing_file_and_a_folder(tmp_path):
    with pytest.raises(
        InputError, match="no such file; allowed: a scene file, or one of al2024-s110, al2024-s230-6-8a, "
    ):
        read_scene(tmp_path / "nowhere.toml")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_scene(tmp_path)


def test_an_empty_file_lists_what_is_required(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    with pytest.raises(InputError) as caught:
        read_scene(tmp_path / "empty.toml")
    keys = [problem.split(": ")[1] for problem in caught.value.problems]
    assert keys == ["schema", "name", "seed", "exposure_time_s", "shots", "nozzle", "target"]


def test_byte_order_mark_and_dos_line_ends_are_read(write_scene):
    path = write_scene()
    plain = read_scene(path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert read_scene(path) == plain


def test_resolved_values_are_plain_complete_and_blind_to_who_wrote_a_default(write_scene):
    scene = read_scene(write_scene())
    resolved = resolved_dict(scene)
    assert json.loads(json.dumps(resolved, allow_nan=False)) == resolved
    assert "defaults_used" not in resolved
    assert set(resolved) == {"schema"} | {f.name for f in dataclasses.fields(scene)} - {
        "defaults_used", "inferred", "specification", "measured",
    }  # fmt: skip
    assert resolved["target"]["material"]["combined"]["backstresses"] == [[130e6, 300.0], [60e6, 12.0]]
    assert resolved_dict(read_scene(write_scene({"friction.shot_shot": "0.2"}))) == resolved
    assert resolved_dict(read_scene(write_scene({"friction.shot_shot": "0.25"}))) != resolved


@pytest.mark.skipif(not DEBIAN_PYTHON.exists(), reason="no /usr/bin/python3 here")
def test_debians_python_reads_the_same_scenes_with_nothing_but_its_standard_library():
    program = (
        "import json, sys; sys.path.insert(0, sys.argv[1])\n"
        "from glue.scene.reader import example_names, example_path, read_scene, resolved_dict\n"
        "print(json.dumps({n: resolved_dict(read_scene(example_path(n), provisional=True)) for n in example_names()}))\n"
        "assert not {'numpy', 'scipy'} & set(sys.modules)\n"
    )
    done = subprocess.run(  # -I: no site packages of the user, no PYTHONPATH
        [str(DEBIAN_PYTHON), "-I", "-c", program, str(REPO)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    here = {name: resolved_dict(read_scene(example_path(name), provisional=True)) for name in example_names()}
    assert json.loads(done.stdout) == here


def test_a_thickness_is_read_and_its_absence_is_a_thick_part(write_scene):
    assert read_scene(write_scene()).target.thickness_m is None
    assert read_scene(write_scene({"target.thickness_m": "0.005"})).target.thickness_m == 0.005


def test_a_plate_thinner_than_the_peened_layer_is_refused(problems_of):
    (problem,) = problems_of({"target.thickness_m": "0.0005"})
    assert problem == (
        "target.thickness_m: 0.0005 m is thinner than the peened layer of 3 dimple radii (about 0.000226778 m "
        "each, estimate); allowed from 0.000680335 m up, or no thickness"
    )


def test_a_preset_number_stated_in_the_file_holds_with_any_preset(write_scene):
    stated = write_scene({"accuracy": '{preset = "fast", cell_load_steps = 5}'})
    for preset in (None, "balanced"):
        expected = dataclasses.replace(PRESETS[preset or "fast"], cell_load_steps=5)
        assert read_scene(stated, preset=preset).accuracy == expected


def test_preset_numbers_out_of_range_are_refused(problems_of):
    found = problems_of({"accuracy": "{cell_load_steps = 0, flow_dt_over_P = 13.0}"})
    assert found == [
        "accuracy.flow_dt_over_P: 13.0 is out of range; allowed 0.01..12",
        "accuracy.cell_load_steps: 0 is out of range; allowed 1..40",
    ]
