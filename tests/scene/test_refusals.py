"""Every single way in which one key may be wrong: the whole sentence that the user sees."""

from __future__ import annotations

import pytest

from glue.scene.catalogue import material_keys, shot_grades
from glue.scene.schema import ACCURACY

TOP_KEYS = (
    "schema, name, seed, exposure_time_s, arrivals, coverage_percent, shots, nozzle, target, restitution, friction, gravity, "
    "air_drag, strain_rate, target_inertia, elastic_shot, models, accuracy, machine, measured"
)
NOZZLE_KEYS = (
    "speed_m_s, mass_flow_kg_s, jet_diameter_m, stand_off_m, impact_angle_deg, intensity, air_pressure_Pa, "
    "wheel_speed_m_s, azimuth_deg, aim_m, profile, "
    "divergence_half_angle_deg, speed_cv, feed_speed_m_s, stroke_m, passes, pitch_m, dwell_s, feed_direction_deg, "
    "mass_flow_pattern, pulse_frequency_Hz, pulse_duty, pulse_amplitude"
)
SHOT_KEYS = "grade, diameter_m, density_kg_m3, E_Pa, nu, size, size_cv, mass_fraction, sieve"
FLAT = "measured from the surface; a flatter jet grazes it and rolls along"

OUT_OF_RANGE = {
    # The unit mistake behind a number, where one explains it.
    ("shots.diameter_m", "1.0"): "1.0 is 1000 mm; this key is in metres (1.0 mm is written 0.001); "
    "allowed 2e-5..0.006 m",
    ("shots.diameter_m", "300"): "300 is 300000 mm; this key is in metres (300 um is written 0.0003); "
    "allowed 2e-5..0.006 m",
    ("shots.diameter_m", "1e-9"): "1e-09 is 1e-6 mm; this key is in metres; allowed 2e-5..0.006 m",
    ("shots.density_kg_m3", "7.8"): "7.8 is out of range; this key is in kilograms per cubic metre "
    "(7.8 g/cm3 is written 7800); allowed 1000..20000 kg/m3",
    ("shots.density_kg_m3", "7.8e-9"): "7.8e-09 is out of range; this key is in kilograms per cubic metre "
    "(7.8e-09 tonne/mm3 is written 7800); allowed 1000..20000 kg/m3",
    ("shots.E_Pa", "210"): "210 is out of range; this key is in pascals (210 GPa is written 2.1e11); "
    "allowed 1e9..1.2e12 Pa",
    ("shots.E_Pa", "210000.0"): "210000.0 is out of range; this key is in pascals "
    "(210000.0 MPa is written 2.1e11); allowed 1e9..1.2e12 Pa",
    ("shots.nu", "0.5"): "0.5 is out of range; allowed 0..0.49",
    ("nozzle.speed_m_s", "60000.0"): "60000.0 is out of range; this key is in metres per second "
    "(60000.0 mm/s is written 60); allowed 0.5..300 m/s",
    ("nozzle.speed_m_s", "-60.0"): "-60.0 is out of range; this key is in metres per second; "
    "allowed 0.5..300 m/s",
    ("nozzle.mass_flow_kg_s", "5"): "5 is out of range; this key is in kilograms per second "
    "(5 kg/min is written 0.0833333); allowed 1e-6..2 kg/s",
    ("nozzle.jet_diameter_m", "20"): "20 is 20000 mm; this key is in metres (20 mm is written 0.02); "
    "allowed 0.0001..0.5 m",
    ("nozzle.stand_off_m", "100.0"): "100.0 is 100000 mm; this key is in metres (100.0 mm is written 0.1); "
    "allowed 0.001..2 m",
    ("nozzle.impact_angle_deg", "1.57"): "1.57 is out of range; this key is in degrees "
    f"(1.57 rad is written 89.9544); allowed 10..90 deg ({FLAT})",
    ("nozzle.impact_angle_deg", "120"): "120 is out of range; this key is in degrees; "
    f"allowed 10..90 deg ({FLAT})",
    ("nozzle.impact_angle_deg", "9.9"): "9.9 is out of range; this key is in degrees; "
    f"allowed 10..90 deg ({FLAT})",
    ("exposure_time_s", "60000"): "60000 is out of range; this key is in seconds (60000 ms is written 60); "
    "allowed 1e-6..3600 s",
    ("exposure_time_s", "0"): "0 is out of range; this key is in seconds; allowed 1e-6..3600 s",
    ("exposure_time_s", "1" + 400 * "0"): f"1{56 * '0'}... is out of range; allowed 1e-6..3600 s",
    ("friction.shot_target", "20"): "20 is out of range; this key is a share of one (20 % is written 0.2); "
    "allowed 0..1",
    ("friction.shot_shot", "-0.1"): "-0.1 is out of range; this key is a share of one; allowed 0..1",
    ("schema", "2"): "2 is out of range; allowed 1",
    ("seed", "-1"): "-1 is out of range; allowed 0..4294967295",
    ("target.window_m", "[4, 0.004]"): "x: 4 is 4000 mm; this key is in metres (4 mm is written 0.004); "
    "allowed 2e-5..0.2 m",
}

WRONG_TYPE = {
    ("nozzle.speed_m_s", "true"): "must be a number, not the boolean true; allowed 0.5..300 m/s",
    ("nozzle.speed_m_s", '"60"'): 'must be a number, not the text "60" (write it without quotes); '
    "allowed 0.5..300 m/s",
    ("nozzle.speed_m_s", '"fast"'): 'must be a number, not the text "fast"; allowed 0.5..300 m/s',
    ("nozzle.speed_m_s", "[60.0]"): "must be a number, not an array; allowed 0.5..300 m/s",
    ("nozzle.speed_m_s", "{v = 60}"): "must be a number, not a table; allowed 0.5..300 m/s",
    (
        "nozzle.speed_m_s",
        "2024-01-01",
    ): "must be a number, not a date or time 2024-01-01; allowed 0.5..300 m/s",
    ("nozzle.speed_m_s", "nan"): "must be a finite number, not nan; allowed 0.5..300 m/s",
    ("nozzle.speed_m_s", "-inf"): "must be a finite number, not -inf; allowed 0.5..300 m/s",
    ("seed", "1.0"): "must be a whole number, not the number 1.0; allowed 0..4294967295",
    ("seed", "true"): "must be a whole number, not the boolean true; allowed 0..4294967295",
    ("schema", '"1"'): 'must be a whole number, not the text "1" (write it without quotes); allowed 1',
    ("name", "7"): "must be a text in quotes, not the integer 7; allowed: 1 to 64 letters, digits, dots, "
    "dashes and underscores, the first a letter or digit",
    ("name", '"../up"'): '"../up" is no valid text; allowed: 1 to 64 letters, digits, dots, '
    "dashes and underscores, the first a letter or digit",
    ("shots.size", "1"): 'must be a text in quotes, not the integer 1; allowed "mono", "distribution", "sieve"',
    ("shots.grade", "390"): "must be a text in quotes, not the integer 390; "
    "allowed: a grade of the catalogue, for example S390",
    ("target.material", "7"): "must be a text or a table, not the integer 7; "
    f"allowed: one of {', '.join(material_keys())}, or a table [target.material]",
    ("target.window_m", "0.004"): "must be two numbers, not the number 0.004; "
    "allowed: two numbers [x, y], each 2e-5..0.2 m",
    ("target.window_m", "[0.004]"): "must be two numbers, not 1; "
    "allowed: two numbers [x, y], each 2e-5..0.2 m",
    ("target.window_m", "[0.004, true]"): "y: must be a number, not the boolean true; allowed 2e-5..0.2 m",
    ("restitution", "0.5"): "must be a table [restitution], not the number 0.5",
    ("accuracy", '"fast"'): 'must be a table [accuracy], not the text "fast"',
    ("models", "[]"): "must be a table [models], not an array",
}

RATIO = "allowed above 0 up to 0.94, or exactly 1"
SATURATES = (
    "cannot be reached: above 0.94 the contact law of YADE saturates (0.97 rebounds at 0.965, 0.999 at 0.984)"
)
RESTITUTION = {
    ("restitution.shot_shot", "0.95"): f"0.95 {SATURATES}; {RATIO}",
    ("restitution.shot_target", "0.97"): f'0.97 {SATURATES}; {RATIO}, or "from_dimple"',
    ("restitution.shot_shot", "0"): f"0 is out of range: the contact law has no answer there; {RATIO}",
    ("restitution.shot_shot", "-0.5"): f"-0.5 is out of range: the contact law has no answer there; {RATIO}",
    ("restitution.shot_shot", "1.1"): f"1.1 is out of range: a rebound cannot gain energy; {RATIO}",
    ("restitution.shot_shot", "nan"): f"must be a finite number, not nan; {RATIO}",
    ("restitution.shot_shot", "false"): f"must be a number, not the boolean false; {RATIO}",
    ("restitution.shot_shot", '"from_dimple"'): f'must be a number, not the text "from_dimple"; {RATIO}',
    ("restitution.shot_target", '"dimple"'): f'unknown value "dimple"; {RATIO}, or "from_dimple"',
}

UNKNOWN = {
    ("sed", "1"): f'unknown key; did you mean "seed"? allowed: {TOP_KEYS}',
    ("zzz", "1"): f"unknown key; allowed: {TOP_KEYS}",
    ("speed_m_s", "60.0"): f"unknown key; it belongs in [nozzle]; allowed: {TOP_KEYS}",
    ("nozzle.window_m", "[1, 1]"): "unknown key; it belongs in [target]; "
    f"allowed: {NOZZLE_KEYS}",
    ("nozzle.speed", "60.0"): f'unknown key; did you mean "speed_m_s"? allowed: {NOZZLE_KEYS}',
    ("shots.diameter_mm", "1.0"): f'unknown key; did you mean "diameter_m"? allowed: {SHOT_KEYS}',
    ("target.materiel", '"in718"'): 'unknown key; did you mean "material"? '
    "allowed: material, window_m, thickness_m, surface, initial_stress, initial_roughness",
    ("restitution.shot_target_e", "0.4"): 'unknown key; did you mean "shot_target"? '
    "allowed: shot_target, shot_shot, hardening",
    ("friction.shotshot", "0.4"): 'unknown key; did you mean "shot_shot"? allowed: shot_target, shot_shot, '
    "in_dimple",
    ("models.flows", '"auto"'): 'unknown key; did you mean "flow"? allowed: flow, dimple, target',
    ("accuracy.prest", '"fast"'): 'unknown key; did you mean "preset"? allowed: ' + ", ".join(ACCURACY),
    ("accuracy.target_patches", "0"): "0 is out of range; allowed 1..64",
    ("accuracy.target_patches", "2.5"): "must be a whole number, not the number 2.5; allowed 1..64",
    ("accuracy.preset", '"Fast"'): 'unknown value "Fast"; did you mean "fast"? '
    'allowed "fast", "balanced", "reference"',
    ("models.target", '"cel"'): 'unknown value "cel"; did you mean "cell"? allowed "auto", "layers", "cell", "contact"',
    ("shots.size", '"zzz"'): 'unknown value "zzz"; allowed "mono", "distribution", "sieve"',
    ("shots.grade", '"s39"'): 'no shot grade "s39" in the catalogue; did you mean "S390"? '
    f"allowed: {', '.join(shot_grades())}",
    (
        "target.material",
        '"al2024-t3"',
    ): 'no material "al2024-t3" in the catalogue; did you mean "al2024-t351"? '
    f"allowed: {', '.join(material_keys())}",
}

SPECIFIED = {
    ("coverage_percent", "98"): "contradicts exposure_time_s, which says how long too; allowed one of them",
    ("nozzle.intensity", '"8A"'): "contradicts speed_m_s, from which the speed follows; allowed one of speed_m_s, intensity, "
    "air_pressure_Pa, wheel_speed_m_s",
}

CASES = OUT_OF_RANGE | WRONG_TYPE | RESTITUTION | UNKNOWN | SPECIFIED
OWN_SHOTS = {"shots": None, "shots.diameter_m": "0.001", "shots.density_kg_m3": "7800.0"}


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]} = {case[1][:30]}")
def test_one_wrong_key_gives_one_exact_sentence(case, problems_of):
    key, value = case
    # A shot of the catalogue has no numbers of its own to get wrong.
    own = key.startswith("shots.") and key.split(".")[1] in ("diameter_m", "density_kg_m3", "E_Pa", "nu")
    changes = (OWN_SHOTS if own else {}) | {key: value}
    assert problems_of(changes) == [f"{key}: {CASES[case]}"]


MISSING = {
    "schema": "missing, and required; allowed 1",
    "name": "missing, and required; allowed: 1 to 64 letters, digits, dots, dashes and underscores, "
    "the first a letter or digit",
    "seed": "missing, and required; allowed 0..4294967295",
    "exposure_time_s": "missing, and required; allowed 1e-6..3600 s",
    "shots": "missing, and required; write a table [shots] with grade, or diameter_m and density_kg_m3",
    "nozzle": "missing, and required; write a table [nozzle] with speed_m_s, mass_flow_kg_s, jet_diameter_m, "
    "stand_off_m, impact_angle_deg",
    "nozzle.speed_m_s": "missing, and required; allowed 0.5..300 m/s, or in its place one of intensity, air_pressure_Pa, "
    "wheel_speed_m_s",
    "nozzle.mass_flow_kg_s": "missing, and required; allowed 1e-6..2 kg/s",
    "nozzle.jet_diameter_m": "missing, and required; allowed 0.0001..0.5 m",
    "nozzle.stand_off_m": "missing, and required; allowed 0.001..2 m",
    "nozzle.impact_angle_deg": "missing, and required; allowed 10..90 deg",
    "target": "missing, and required; write a table [target] with material and window_m",
    "target.material": "missing, and required; allowed: one of "
    f"{', '.join(material_keys())}, or a table [target.material]",
    "target.window_m": "missing, and required; allowed: two numbers [x, y], each 2e-5..0.2 m",
}


@pytest.mark.parametrize("key", MISSING)
def test_each_required_key(key, problems_of):
    assert problems_of({key: None}) == [f"{key}: {MISSING[key]}"]


def test_shots_are_a_grade_or_own_numbers_but_not_both(problems_of):
    assert problems_of({"shots.diameter_m": "0.001", "shots.nu": "0.3"}) == [
        f"shots.{key}: is fixed by grade; allowed: grade alone, or your own numbers without grade"
        for key in ("diameter_m", "nu")
    ]
    assert problems_of({"shots": '{size = "mono"}'}) == [
        "shots.grade: missing, and required; allowed: a grade of the catalogue, "
        "or diameter_m and density_kg_m3"
    ]
    assert problems_of({"shots": "{diameter_m = 0.001}"}) == [
        "shots.density_kg_m3: missing, and required; allowed 1000..20000 kg/m3"
    ]


def test_a_spread_without_distribution_would_be_ignored_and_is_refused(problems_of):
    sentence = (
        'shots.size_cv: has no effect with size = "mono"; allowed: size = "distribution", or no size_cv'
    )
    assert problems_of({"shots.size_cv": "0.1"}) == [sentence]
    assert problems_of({"shots.size": '"distribution"', "shots.size_cv": "10"}) == [
        "shots.size_cv: 10 is out of range; this key is a share of one (10 % is written 0.1); "
        "allowed 0.001..0.3"
    ]
