"""CSV files of a laboratory: units from the header, and every mistake told with its line."""

from __future__ import annotations

import pytest

from glue import cli
from glue.errors import InputError
from glue.study.measured import read_curve, read_profile


def write(tmp_path, text):
    path = tmp_path / "measured.csv"
    path.write_text(text)
    return path


def test_units_and_order(tmp_path):
    path = write(tmp_path, "# strip A\narc_height_in, exposure_s\n.0070,12\n.0060,4\n\n.0069,6\n")
    curve = read_curve(path)
    assert curve.unit == "s" and curve.exposure.tolist() == [4, 6, 12]
    assert curve.arc_height_m == pytest.approx([0.0060 * 0.0254, 0.0069 * 0.0254, 0.0070 * 0.0254])
    profile = read_profile(write(tmp_path, "depth_um,stress_MPa,stress_sd_MPa\n50,-300,20\n0,-200,15\n"))
    assert profile.depth_m == pytest.approx([0.0, 50e-6]) and profile.stress_Pa.tolist() == [-200e6, -300e6]
    assert profile.stress_sd_Pa.tolist() == [15e6, 20e6]


def test_all_mistakes_at_once(tmp_path):
    path = write(tmp_path, "exposure_min,arc_height_mm\n4,0.1\n4,\nfive,0.1\n6,nan\n7\n")
    with pytest.raises(InputError) as caught:
        read_curve(path)
    told = [problem.removeprefix(f"{path}: ") for problem in caught.value.problems]
    assert [t.split(":")[0] for t in told] == ["line 3", "line 4", "line 5", "line 6"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("exposure_minutes,arc_height_mm\n1,1\n", 'unknown column or unit "exposure_minutes"; did you mean "exposure_min"'),
        ("exposure_min,arc_height_thou\n1,1\n", 'unknown column or unit "arc_height_thou"'),
        ("exposure_min,exposure_s,arc_height_mm\n1,1,1\n", "say the same"),
        ("exposure_min\n1\n", "no column for it; allowed one of arc_height_in"),
        ("", "is empty"),
        ("exposure_min,arc_height_mm\n", "no line of numbers"),
        ("exposure_min,arc_height_mm\n1,.1\n1,.2\n", "stands in line 2 too"),
        ("exposure_min,arc_height_m\n1,.1\n", "is the unit right"),
        ("exposure_min,arc_height_mm\n0,.1\n", "must be above 0"),
        ("exposure_min;arc_height_mm\n1;.1\n", "unknown column"),
    ],
)
def test_a_curve_that_is_none(tmp_path, text, says):
    with pytest.raises(InputError) as caught:
        read_curve(write(tmp_path, text))
    assert says in str(caught.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_curve(tmp_path / "none.csv")


def test_the_command_gives_intensity_and_saturation_exposure(tmp_path, capsys):
    import json

    path = write(tmp_path, "exposure_min,arc_height_in\n4,.0060\n6,.0069\n8,.0070\n12,.0070\n")
    assert cli.main(["intensity", "--curve", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["intensity_m"] / 0.0254 == pytest.approx(0.0064, abs=0.001)
    low, high = found["saturation_exposure_interval"]
    assert low < found["saturation_exposure"] < high and found["exposure_unit"] == "min"
    assert cli.main(["intensity", "--curve", str(path), "--strip", "A"]) == 0
    assert "6.41A" in capsys.readouterr().out


def test_the_command_says_when_the_points_do_not_allow_it(tmp_path, capsys):
    path = write(tmp_path, "exposure_min,arc_height_in\n4,.0060\n6,.0069\n8,.0070\n")
    assert cli.main(["intensity", "--curve", str(path)]) == 2
    assert "only 3 points" in capsys.readouterr().err
    for argv in ([], ["--curve", str(path), "--target", "contact"], ["--curve", str(path), "--strip", "B"]):
        assert cli.main(["intensity", *argv]) == 2
        assert "allowed" in capsys.readouterr().err


def test_a_scene_is_checked_before_impacts_are_solved(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("PEEN_FREEFEM", str(tmp_path / "none"))
    assert cli.main(["intensity", "al2024-s390", "--curve", str(write(tmp_path, "exposure_min\n1\n"))]) == 2
    assert "allowed one of arc_height_in" in capsys.readouterr().err
