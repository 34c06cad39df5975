"""The shape of the target's surface."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from glue.scene.model import Surface
from glue.scene.reader import read_scene
from glue.scene.measured import beside

STL_ALLOWED = "allowed: an STL file that can be read, its name from the scene file's folder"


def test_a_plane_is_the_default_and_said_so(write_scene):
    scene = read_scene(write_scene())
    assert scene.target.surface == Surface()
    assert 'target.surface = "plane" (a flat target; choice of this project)' in scene.defaults_used
    assert read_scene(write_scene({"target.surface": '{kind = "plane"}'})) == scene


def test_a_cylinder(write_scene):
    scene = read_scene(write_scene({"target.surface": '{kind = "cylinder", radius_m = 0.02}'}))
    assert scene.target.surface == Surface("cylinder", 0.02, "y")
    assert "target.surface.axis = " in "\n".join(scene.defaults_used)
    along_x = {"target.surface": '{kind = "cylinder", radius_m = 0.02, axis = "x"}'}
    assert read_scene(write_scene(along_x)).target.surface.axis == "x"


def test_a_cylinder_must_be_flat_for_a_shot_and_as_wide_as_the_window(write_scene, problems_of):
    def cylinder(radius, axis="y"):
        return {"target.surface": f'{{kind = "cylinder", radius_m = {radius}, axis = "{axis}"}}'}

    assert problems_of(cylinder("0.0024")) == [
        "target.surface.radius_m: 0.0024 m is less than five times the largest shot's, whose contact law takes the target "
        "as flat; allowed from 0.0025 m up"
    ]
    read_scene(write_scene(cylinder("0.0025")))
    wide = {"target.window_m": "[0.004, 0.008]"}  # 8 mm across an axis along x
    assert problems_of(wide | cylinder("0.0039", "x")) == [
        "target.surface.radius_m: 0.0039 m is less than half the window's side across the axis; allowed from 0.004 m up"
    ]
    read_scene(write_scene(wide | cylinder("0.0039", "y")))


def test_an_stl_is_found_beside_the_scene_and_known_by_its_content(write_scene, tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "blade.stl").write_bytes(b"solid blade")
    changes = {"target.surface": '{kind = "stl", file = "parts/blade.stl"}'}
    scene = read_scene(write_scene(changes))
    assert scene.target.surface == Surface(
        "stl", None, "y", "parts/blade.stl", hashlib.sha256(b"solid blade").hexdigest()
    )
    # A copy of the scene with its STL beside it, as in a run directory, is the same scene; another content is not.
    (tmp_path / "parts" / "blade.stl").rename(tmp_path / "blade.stl")
    assert read_scene(write_scene(changes)) == scene
    assert beside(tmp_path / "trial.toml", "parts/blade.stl") == tmp_path / "blade.stl"
    (tmp_path / "blade.stl").write_bytes(b"solid other")
    assert read_scene(write_scene(changes)) != scene


@pytest.mark.parametrize(
    "surface, expected",
    [
        ("{}", ['kind: missing, and required; allowed "plane", "cylinder", "stl"']),
        ('{kind = "sphere"}', ['kind: unknown value "sphere"; allowed "plane", "cylinder", "stl"']),
        ('{kind = "cylinder"}', ["radius_m: missing, and required; allowed 0.0001..100 m"]),
        (
            '{kind = "cylinder", radius_m = 20, file = "a.stl"}',
            ['file: has no effect with kind = "cylinder"; allowed: kind = "stl", or no file'],
        ),
        (
            '{kind = "plane", radius_m = 1, axis = "x"}',
            [
                'radius_m: has no effect with kind = "plane"; allowed: kind = "cylinder", or no radius_m',
                'axis: has no effect with kind = "plane"; allowed: kind = "cylinder", or no axis',
            ],
        ),
        ('{kind = "cylinder", radius_m = 0.02, axis = "z"}', ['axis: unknown value "z"; allowed "x", "y"']),
        (
            '{kind = "cylinder", radius_m = 1000}',
            ["radius_m: 1000 is 1e6 mm; this key is in metres (1000 mm is written 1); allowed 0.0001..100 m"],
        ),
        ('{kind = "stl"}', ["file: missing, and required; allowed: the name of an STL file, from the scene file's folder"]),
        ('{kind = "stl", file = "none.stl"}', [f'file: no file "none.stl" in FOLDER; {STL_ALLOWED}']),
        ('{kind = "stl", file = "."}', [f'file: no file "." in FOLDER; {STL_ALLOWED}']),
        (
            '{kind = "stl", file = "nul\\u0000.stl"}',
            ['file: "nul\0.stl" is no valid text; allowed: the name of an STL file, from the scene file\'s folder'],
        ),
        ('{kind = "plane", radius = 1}', ['radius: unknown key; did you mean "radius_m"? allowed: kind, radius_m, axis, file']),
    ],
)  # fmt: skip
def test_wrong_surfaces(surface, expected, problems_of, tmp_path):
    expected = [f"target.surface.{sentence.replace('FOLDER', str(tmp_path))}" for sentence in expected]
    assert problems_of({"target.surface": surface}) == expected


def test_a_surface_that_is_no_table(problems_of):
    assert problems_of({"target.surface": '"stl"'}) == [
        'target.surface: must be a table [target.surface], not the text "stl"'
    ]


def test_an_stl_that_cannot_be_read(problems_of, tmp_path, monkeypatch):
    (tmp_path / "shut.stl").write_bytes(b"solid")

    read_bytes = Path.read_bytes

    def refuse(path):  # tests may run as root, whom no file mode stops
        if path.suffix == ".stl":
            raise PermissionError(13, "Permission denied")
        return read_bytes(path)

    monkeypatch.setattr(Path, "read_bytes", refuse)
    assert problems_of({"target.surface": '{kind = "stl", file = "shut.stl"}'}) == [
        f'target.surface.file: "shut.stl" cannot be read: Permission denied; {STL_ALLOWED}'
    ]
