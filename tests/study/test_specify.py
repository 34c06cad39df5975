"""From a drawing's words to speeds and times, on stand-in impacts; and that a run directory keeps what was found."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from glue.errors import InputError
from glue.scene.reader import example_path, read_scene
from glue.scene.specification import INFERRED
from glue.study import pipeline, specify
from glue.study.shot_stream import energy_lost, stream_of
from glue.theory.almen import STRIPS, mils

sys.path.insert(0, str(Path(__file__).parents[1] / "target"))

from strips import stand_in  # noqa: E402

RADIUS_R = 0.27  # of the target's dimple at preset fast


@pytest.fixture
def library(monkeypatch):
    found = stand_in()
    monkeypatch.setattr(specify, "ready_kernels", lambda: None)
    monkeypatch.setattr(specify, "strip_library", lambda progress: found)
    monkeypatch.setattr(specify, "solve_reduced", lambda *args, **kind: "solved")
    monkeypatch.setattr(specify, "zero_height_radius", lambda impact: RADIUS_R)
    return found


def changed(tmp_path, **words):
    """The 8A example with texts replaced."""
    text = example_path("al2024-s230-8a").read_text()
    for old, new in words.values():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return path


def test_the_speed_found_peens_to_the_intensity_on_arrival(library):
    scene, _ = specify.read_specified(example_path("al2024-s230-8a"))
    assert mils(library.intensity_m(STRIPS["A"], stream_of(scene))) == pytest.approx(8.0, rel=1e-3)
    # collisions slow the stream: a speed that did not count them would be lower
    assert stream_of(scene).normal_speed_m_s[0] < 0.95 * scene.nozzle.speed_m_s
    assert re.search(r"speed_m_s = .* from intensity 8A .*collisions taking .*± \d+% by the strip model", scene.inferred[0])


def test_full_coverage_is_98_per_cent_and_200_twice_its_time(library, tmp_path):
    """Avrami by hand: t98 = ln 50 / (rate per area x pi a^2), longer by what collisions take."""
    scene, _ = specify.read_specified(example_path("al2024-s230-8a"))
    area = 3.14159265 * (RADIUS_R * 0.3e-3) ** 2
    per_s = scene.shot_rate_1_s / scene.nozzle.footprint_area_m2 * area
    expected = 2 * 3.912023 / per_s / (1 - energy_lost(scene))
    assert scene.exposure_time_s == pytest.approx(expected, rel=2e-3)
    half, _ = specify.read_specified(changed(tmp_path, c=("coverage_percent = 200", "coverage_percent = 50")))
    assert half.exposure_time_s == pytest.approx(expected / 2 * 0.693147 / 3.912023, rel=2e-3)


def test_of_a_travelling_nozzle_the_passes_are_found(library, tmp_path):
    """In the middle of its line a pass leaves per area what the jet at rest does in (width over feed speed) of time."""
    feed = "feed_speed_m_s = 0.05\nstroke_m = 0.04\n"
    narrow = ("window_m = [0.003, 0.003]", "window_m = [0.0012, 0.0012]")
    scene, files = specify.read_specified(changed(tmp_path, f=("impact_angle_deg = 90.0", f"{feed}impact_angle_deg = 90.0"), w=narrow))
    rest, _ = specify.read_specified(changed(tmp_path, w=narrow))
    # round jet of area A over a point on its middle line: in sight for 2R/v, rate per area q/A the same as at rest
    exact = rest.exposure_time_s / (0.010 / 0.05)
    passes = scene.nozzle.feed.passes
    assert exact * 0.995 <= passes <= exact * 1.005 + 1.0
    assert scene.exposure_time_s == pytest.approx(passes * 0.04 / 0.05)
    assert json.loads(files[INFERRED])["passes"] == passes
    assert any(f"passes = {passes}" in line for line in scene.inferred)


def test_a_window_aims_at_its_middle_and_the_machine_gets_its_setting(library, tmp_path):
    path = tmp_path / "window.toml"  # the stand-in reaches no 6A
    path.write_text(example_path("al2024-s230-6-8a").read_text().replace('"6-8A"', '"8-12A"'))
    scene, _ = specify.read_specified(path)
    assert mils(library.intensity_m(STRIPS["A"], stream_of(scene))) == pytest.approx(10.0, rel=1e-3)
    pressure = float(re.search(r"air_pressure_Pa = (\S+) on the machine", "\n".join(scene.inferred))[1])
    assert 0.5e5 < pressure < 4e5


def test_the_same_every_time(library):
    one, other = (specify.read_specified(example_path("al2024-s230-8a"))[1] for _ in range(2))
    assert one == other


def test_what_cannot_be_had_names_file_key_and_range(library, tmp_path):
    path = changed(tmp_path, i=('"8A"', '"23A"'))
    with pytest.raises(InputError, match=r"mine\.toml: nozzle\.intensity: 23A is out of reach of these shots: allowed .*A"):
        specify.read_specified(path)


def test_a_machine_by_its_own_curves(library, tmp_path):
    """Curves of the stand-in strip at 15 and 30 m/s on arrival: between them the power law through both."""
    from glue.target.strip import even_stream

    rows = []
    for pressure, speed in ((1e5, 15.0), (4e5, 30.0)):
        stream = even_stream(0.6e-3, 7800.0, speed)
        hits, _ = library.saturation(STRIPS["A"], stream)
        heights = [library.arc_height_m(STRIPS["A"], stream, hits * m) * 1e3 for m in (0.4, 0.9, 1.8, 3.6)]
        name = f"c{pressure:g}.csv"
        lines = [f"{t},{h:.9g}" for t, h in zip((1, 2.25, 4.5, 9), heights)]
        (tmp_path / name).write_text("\n".join(["exposure_min,arc_height_mm", *lines]) + "\n")
        rows.append(f'{{ air_pressure_Pa = {pressure:g}, file = "{name}", strip = "A" }}')
    path = changed(
        tmp_path, i=('intensity = "8A"', "air_pressure_Pa = 2e5"), m=("[target]", f"[machine]\ncurves = [{', '.join(rows)}]\n[target]")
    )
    scene, files = specify.read_specified(path)
    assert set(files) == {INFERRED, "c100000.csv", "c400000.csv"}
    # 15 x 2^.5 m/s on arrival; the share that collisions take differs a little between the speeds
    assert stream_of(scene).normal_speed_m_s[0] == pytest.approx(15.0 * 2**0.5, rel=0.01)
    (tmp_path / "c100000.csv").write_text("exposure_min,arc_height_mm\n1,.1\n2,.12\n3,.13\n")
    with pytest.raises(InputError, match=r"machine\.curves \(air_pressure_Pa = 100000\): .*only 3 points"):
        specify.read_specified(path)


def test_a_run_directory_keeps_what_was_found(library, stubs, tmp_path):
    out = pipeline.run(str(example_path("al2024-s230-8a")), tmp_path / "run", stages=stubs.stages)
    kept = read_scene(out / "scene.toml")  # as YADE reads it
    assert json.loads((out / INFERRED).read_text())["speed_m_s"] == [kept.nozzle.speed_m_s]
    manifest = json.loads((out / "manifest.json").read_text())
    assert any("from intensity 8A" in line for line in manifest["inferred"])
    stubs.ran.clear()
    pipeline.run(str(example_path("al2024-s230-8a")), out, stages=stubs.stages)
    pipeline.rerun(out, ["d"], lambda *told: None, stages=stubs.stages)
    assert stubs.ran == []
