"""Nozzles of a scene: where they aim, how they spread, travel and pulse, and how long that takes."""

from __future__ import annotations

import pytest

from glue.scene.model import Feed, Nozzle, Pulse
from glue.scene.reader import read_scene

MOVING = {
    "exposure_time_s": None,
    "nozzle.feed_speed_m_s": "0.02",
    "nozzle.stroke_m": "0.03",
}
JET = "speed_m_s = 60, mass_flow_kg_s = 0.01, jet_diameter_m = 0.02, stand_off_m = 0.1, impact_angle_deg = 90"
REST = "has no effect on a nozzle at rest; allowed: feed_speed_m_s above 0, or no"


def nozzles(*extra):
    return {"nozzle": "[" + ", ".join(f"{{{', '.join(filter(None, (JET, own)))}}}" for own in extra) + "]"}


def test_every_key_of_a_jet_at_rest(write_scene):
    given = {
        "nozzle.azimuth_deg": "-30",
        "nozzle.aim_m": "[0.001, -0.002]",
        "nozzle.profile": '"gaussian"',
        "nozzle.divergence_half_angle_deg": "5",
        "nozzle.speed_cv": "0.05",
        "nozzle.impact_angle_deg": "60",
    }
    assert read_scene(write_scene(given)).nozzle == Nozzle(
        60.0, 0.01667, 0.02, 0.1, 60.0, -30.0, (0.001, -0.002), "gaussian", 5.0, 0.05
    )


def test_several_nozzles(write_scene):
    scene = read_scene(write_scene(nozzles("", "azimuth_deg = 180, speed_cv = 0.1")))
    assert [n.azimuth_deg for n in scene.nozzles] == [0.0, 180.0]
    assert scene.mass_flow_kg_s == 0.02
    assert scene.fastest_m_s == pytest.approx(75.0, rel=1e-12)
    assert any(line.startswith("nozzle[2].profile = ") for line in scene.defaults_used)


def test_one_nozzle_written_either_way_is_the_same_scene(write_scene):
    by_block = read_scene(write_scene({"nozzle.mass_flow_kg_s": "0.01"}))
    assert read_scene(write_scene(nozzles(""))) == by_block


def test_the_exposure_follows_from_the_path(write_scene):
    """Three strokes of 30 mm at 20 mm/s and two dwells of .25 s: 4.5 + .5 s."""
    scene = read_scene(
        write_scene(MOVING | {"nozzle.passes": "3", "nozzle.dwell_s": "0.25", "nozzle.pitch_m": "0.004"})
    )
    assert scene.nozzle.feed == Feed(0.02, 0.03, 3, 0.004, 0.25, 0.0)
    assert scene.exposure_time_s == pytest.approx(5.0, rel=1e-12)
    line = "exposure_time_s = 5 (derived: passes x stroke over feed speed and the dwells between, of nozzle)"
    assert line in scene.defaults_used


def test_the_stroke_follows_from_the_exposure(write_scene):
    path = {"exposure_time_s": "5", "nozzle.stroke_m": None, "nozzle.passes": "3", "nozzle.dwell_s": "0.25"}
    scene = read_scene(write_scene(MOVING | path))
    assert scene.nozzle.feed.stroke_m == pytest.approx(0.03, rel=1e-12)
    assert (
        "nozzle.stroke_m = 0.03 (derived: feed speed x (exposure - dwells) / passes)" in scene.defaults_used
    )
    # both written down is the same scene
    assert read_scene(write_scene(MOVING | path | {"nozzle.stroke_m": "0.03"})) == scene


def test_a_nozzle_at_rest_beside_one_that_moves(write_scene):
    scene = read_scene(
        write_scene(nozzles("", "feed_speed_m_s = 0.02, stroke_m = 0.03") | {"exposure_time_s": None})
    )
    assert scene.exposure_time_s == pytest.approx(1.5)
    assert scene.nozzles[0].feed is None and scene.nozzles[1].feed.passes == 1


@pytest.mark.parametrize(
    "pattern, keys, pulse, peak",
    [
        ("pulsed", {"pulse_duty": "0.25"}, Pulse("pulsed", 20.0, duty=0.25), 4.0),
        ("sinusoidal", {"pulse_amplitude": "0.8"}, Pulse("sinusoidal", 20.0, amplitude=0.8), 1.8),
    ],
)
def test_pulses(pattern, keys, pulse, peak, write_scene):
    keys = {"mass_flow_pattern": f'"{pattern}"', "pulse_frequency_Hz": "20"} | keys
    scene = read_scene(write_scene({f"nozzle.{key}": value for key, value in keys.items()}))
    assert scene.nozzle.pulse == pulse
    assert scene.nozzle.pulse.peak == peak


@pytest.mark.parametrize("word", ["poisson", "exact_mass"])
def test_arrivals(word, write_scene):
    assert read_scene(write_scene({"arrivals": f'"{word}"'})).arrivals == word


WRONG = {
    "at rest with a path": (
        {f"nozzle.{key}": value for key, value in (("passes", "2"), ("pitch_m", "0"), ("dwell_s", "1"), ("stroke_m", "9"))},
        [f"nozzle.{key}: {REST} {key}" for key in ("stroke_m", "passes", "pitch_m", "dwell_s")],
    ),
    "at rest with a stroke for an exposure": (
        {"exposure_time_s": None, "nozzle.stroke_m": "0.03"},
        ["exposure_time_s: missing, and required; allowed 1e-6..3600 s", f"nozzle.stroke_m: {REST} stroke_m"],
    ),
    "at rest, said so": (
        {"nozzle.feed_speed_m_s": "0", "nozzle.feed_direction_deg": "90"},
        [f"nozzle.feed_direction_deg: {REST} feed_direction_deg"],
    ),
    "stroke and exposure": (
        MOVING | {"exposure_time_s": "3"},
        [
            "nozzle.stroke_m: its passes and dwells take 1.5 s, but exposure_time_s says 3 s; allowed: the same within "
            "1e-6, or one of the two left out"
        ],
    ),
    "two paths": (
        nozzles("feed_speed_m_s = 0.02, stroke_m = 0.03", "feed_speed_m_s = 0.03, stroke_m = 0.03") | {"exposure_time_s": None},
        [
            "nozzle[2].stroke_m: its passes and dwells take 1 s, but nozzle[1] takes 1.5 s; allowed: the same within 1e-6, "
            "or one of the two left out"
        ],
    ),
    "one path, neither exposure nor stroke for the other": (
        nozzles("feed_speed_m_s = 0.02, stroke_m = 0.03", "feed_speed_m_s = 0.03") | {"exposure_time_s": None},
        ["nozzle[2].stroke_m: missing, and required without exposure_time_s; allowed 0.0001..10 m"],
    ),
    "no exposure and no stroke": (
        MOVING | {"nozzle.stroke_m": None},
        ["exposure_time_s: missing, and required; allowed 1e-6..3600 s"],
    ),
    "a path of hours": (
        MOVING | {"nozzle.stroke_m": "0.03125", "nozzle.feed_speed_m_s": "7.62939453125e-06"},  # 2^-5 over 2^-17
        [
            "exposure_time_s: as long as the feed of nozzle takes: 4096.0 is out of range; this key is in seconds (4096.0 "
            "ms is written 4.096); allowed 1e-6..3600 s"
        ],
    ),
    "a path without an end": (
        MOVING | {"nozzle.feed_speed_m_s": "1e-320"},
        ["exposure_time_s: as long as the feed of nozzle takes: must be a finite number, not inf; allowed 1e-6..3600 s"],
    ),
    "one pass": (
        MOVING | {"nozzle.pitch_m": "0.001", "nozzle.dwell_s": "0.1"},
        [f"nozzle.{key}: has no effect with one pass; allowed 0, or passes from 2 up" for key in ("pitch_m", "dwell_s")],
    ),
    "nothing but dwells": (
        MOVING | {"exposure_time_s": "3", "nozzle.stroke_m": None, "nozzle.passes": "4", "nozzle.dwell_s": "1"},
        ["nozzle.dwell_s: 3 dwells of 1 s leave no time to move in 3 s; allowed below 1 s"],
    ),
    "a stroke out of range": (
        MOVING | {"exposure_time_s": "3", "nozzle.stroke_m": None, "nozzle.feed_speed_m_s": "1e-6"},
        [
            "nozzle.stroke_m: feed speed x (exposure - dwells) / passes: 3e-06 is 0.003 mm; this key is in metres; "
            "allowed 0.0001..10 m"
        ],
    ),
    "faster than slow": (
        {"nozzle.feed_speed_m_s": "1.5", "nozzle.speed_m_s": "20", "exposure_time_s": "0.1"},
        [
            "nozzle.feed_speed_m_s: 1.5 m/s is not slow against the shots: they leave as from a nozzle at rest; allowed up "
            "to 1 m/s with this speed_m_s"
        ],
    ),
    "passes": (
        MOVING | {"nozzle.passes": "1.5"},
        ["nozzle.passes: must be a whole number, not the number 1.5; allowed 1..1000"],
    ),
    "feed speed": (
        {"nozzle.feed_speed_m_s": "20"},
        ["nozzle.feed_speed_m_s: 20 is out of range; this key is in metres per second (20 mm/s is written 0.02); allowed 0..2 m/s"],
    ),
    "a steady flow with a frequency": (
        {"nozzle.pulse_frequency_Hz": "20", "nozzle.pulse_duty": "0.5"},
        [
            'nozzle.pulse_frequency_Hz: has no effect with mass_flow_pattern = "steady"; allowed: mass_flow_pattern = '
            '"pulsed" or "sinusoidal", or no pulse_frequency_Hz',
            'nozzle.pulse_duty: has no effect with mass_flow_pattern = "steady"; allowed: mass_flow_pattern = "pulsed", '
            "or no pulse_duty",
        ],
    ),
    "a pulse without a frequency": (
        {"nozzle.mass_flow_pattern": '"pulsed"', "nozzle.pulse_amplitude": "0.5"},
        [
            'nozzle.pulse_amplitude: has no effect with mass_flow_pattern = "pulsed"; allowed: mass_flow_pattern = '
            '"sinusoidal", or no pulse_amplitude',
            "nozzle.pulse_frequency_Hz: missing, and required; allowed 0.001..100000 Hz",
            "nozzle.pulse_duty: missing, and required; allowed 0.01..1",
        ],
    ),
    "pulses out of range": (
        {"nozzle.mass_flow_pattern": '"sinusoidal"', "nozzle.pulse_frequency_Hz": "1e6", "nozzle.pulse_amplitude": "1.1"},
        [
            "nozzle.pulse_frequency_Hz: 1000000.0 is out of range; this key is in hertz (1000000.0 1/min is written "
            "16666.7); allowed 0.001..100000 Hz",
            "nozzle.pulse_amplitude: 1.1 is out of range; this key is a share of one (1.1 % is written 0.011); "
            "allowed 0..1 (a flow never runs backwards)",
        ],
    ),
    "less than one pulse": (
        {"nozzle.mass_flow_pattern": '"pulsed"', "nozzle.pulse_frequency_Hz": "0.3", "nozzle.pulse_duty": "0.1"},
        [
            "nozzle.pulse_frequency_Hz: 0.3 Hz is less than one period in 3 s, over which mass_flow_kg_s is no mean; "
            "allowed from 0.333333 Hz up"
        ],
    ),
    "a jet that shoots level": (
        {"nozzle.impact_angle_deg": "20", "nozzle.divergence_half_angle_deg": "18.5", "nozzle.stand_off_m": "0.2"},
        [
            "nozzle.divergence_half_angle_deg: 18.5 deg sends the jet's upper edge off less than 2 deg below level at this "
            "impact angle, so that shots pass over the target; allowed 0..18 deg"
        ],
    ),
    "spread": (
        {"nozzle.speed_cv": "0.3", "nozzle.divergence_half_angle_deg": "31", "nozzle.azimuth_deg": "181", "nozzle.profile": '"flat"'},
        [
            "nozzle.azimuth_deg: 181 is out of range; this key is in degrees; allowed -180..180 deg",
            'nozzle.profile: unknown value "flat"; allowed "uniform", "gaussian"',
            "nozzle.divergence_half_angle_deg: 31 is out of range; this key is in degrees; allowed 0..30 deg",
            "nozzle.speed_cv: 0.3 is out of range; this key is a share of one (0.3 % is written 0.003); allowed 0..0.2",
        ],
    ),
    "aim": (
        {"nozzle.aim_m": "[2, true]"},
        [
            "nozzle.aim_m: x: 2 is 2000 mm; this key is in metres (2 mm is written 0.002); allowed -1..1 m; "
            "y: must be a number, not the boolean true; allowed -1..1 m"
        ],
    ),
    "arrivals": (
        {"arrivals": '"exact"'},
        ['arrivals: unknown value "exact"; did you mean "exact_mass"? allowed "poisson", "exact_mass"'],
    ),
    "gas across the second jet": (
        {
            "nozzle": nozzles("", "")["nozzle"].replace("impact_angle_deg = 90", "impact_angle_deg = 60", 1),
            "air_drag": "{gas_speed_m_s = 30}",
        },
        [
            "air_drag.gas_speed_m_s: 30 m/s blows along the first nozzle's axis everywhere, across the jets of the others; "
            "allowed 0 (still gas), or nozzles of one direction"
        ],
    ),
    "no nozzles": ({"nozzle": "[]"}, ["nozzle: must not be empty; allowed: one table [nozzle], or several written [[nozzle]]"]),
    "too many": (nozzles(*17 * [""]), ["nozzle: must be at most 16 tables, not 17; allowed 1..16"]),
    "the second one": (
        nozzles("", "speed = 60"),
        [
            'nozzle[2].speed: unknown key; did you mean "speed_m_s"? allowed: speed_m_s, mass_flow_kg_s, jet_diameter_m, '
            "stand_off_m, impact_angle_deg, intensity, air_pressure_Pa, wheel_speed_m_s, azimuth_deg, aim_m, profile, "
            "divergence_half_angle_deg, speed_cv, "
            "feed_speed_m_s, stroke_m, passes, pitch_m, dwell_s, feed_direction_deg, mass_flow_pattern, "
            "pulse_frequency_Hz, pulse_duty, pulse_amplitude"
        ],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_wrong_nozzles(case, problems_of):
    changes, expected = WRONG[case]
    assert problems_of(changes) == expected


@pytest.mark.parametrize(
    "extra, most",
    [
        ({}, 0.0588106),  # 15 % of 7800 x 5.02655e-5 x 1
        (
            {"nozzle.profile": '"gaussian"'},
            0.0588106 * 0.8646647 / 2.0,
        ),  # the middle holds 2 / (1 - e^-2) of the mean
        (
            {
                "nozzle.mass_flow_pattern": '"pulsed"',
                "nozzle.pulse_frequency_Hz": "20",
                "nozzle.pulse_duty": "0.2",
            },
            0.0588106 / 5.0,
        ),
    ],
)
def test_the_densest_moment_and_place_of_the_jet_count(extra, most, write_scene, problems_of):
    slow = {
        "nozzle.speed_m_s": "1",
        "nozzle.jet_diameter_m": "0.008",
        "target.window_m": "[0.002, 0.002]",
    } | extra
    read_scene(write_scene(slow | {"nozzle.mass_flow_kg_s": f"{most * 0.9999}"}))
    (problem,) = problems_of(slow | {"nozzle.mass_flow_kg_s": f"{most * 1.0001}"})
    assert problem.startswith("nozzle.mass_flow_kg_s: shots would fill 15.0015 % of the jet's volume")
    assert ("where and when it is densest" in problem) == bool(extra)
