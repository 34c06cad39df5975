"""Bands warn and do not judge where they are not known."""

from __future__ import annotations

import dataclasses

from glue.scene.asked import Specification
from glue.scene.reader import example_path, read_scene
from glue.study.plausibility import roughness_warnings, stress_warnings

SCENE = read_scene(example_path("al2024-s390"))
ASKED = dataclasses.replace(SCENE, specification=Specification(("8A",), (None,), 200.0, None))
GOOD = {"surface_Pa": -230e6, "max_compressive_Pa": -300e6, "max_compressive_depth_m": 0.1e-3, "compressive_depth_m": 0.3e-3}


def test_a_usual_profile_is_not_remarked_upon():
    assert stress_warnings(ASKED, GOOD) == [] == roughness_warnings(ASKED, {"Ra_m": 4e-6})


def test_what_is_unusual_is_told_with_its_band():
    told = stress_warnings(ASKED, GOOD | {"surface_Pa": -100e6, "compressive_depth_m": 0.7e-3})
    assert len(told) == 2 and "-280 to -180 MPa" in told[0] and "0.2 to 0.45 mm" in told[1]
    assert "2 to 6 um" in roughness_warnings(ASKED, {"Ra_m": 20e-6})[0]


def test_depths_and_roughness_are_judged_only_at_intensities_of_which_they_are_known():
    assert stress_warnings(SCENE, GOOD | {"compressive_depth_m": 0.7e-3}) == []
    assert roughness_warnings(SCENE, {"Ra_m": 20e-6}) == []


def test_more_than_the_strength_and_a_value_that_is_not_there():
    steel = read_scene(example_path("steel4340-s390"))
    assert "beyond the flow stress" in stress_warnings(steel, {"max_compressive_Pa": -2e9})[0]
    assert stress_warnings(steel, {"max_compressive_Pa": None}) == []


def test_an_initial_stress_out_of_balance_is_told():
    target = dataclasses.replace(ASKED.target, thickness_m=5e-3, initial_stress=((0.0, 50e6), (1e-3, 50e6)))
    (told,) = stress_warnings(dataclasses.replace(ASKED, target=target), GOOD)
    assert "not in balance" in told
