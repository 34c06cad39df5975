"""Which impact stands for a mixture."""

from __future__ import annotations

import dataclasses

from glue.scene.reader import example_path, read_scene
from glue.study.reference import reference_impact


def test_the_largest_dimple_of_all_nozzles_and_media():
    scene = read_scene(example_path("al2024-s390"))
    assert reference_impact(scene) == (scene.nozzle, scene.shots)
    small = dataclasses.replace(scene.shots, diameter_m=0.5e-3, mass_fraction=0.9)
    large = dataclasses.replace(scene.shots, mass_fraction=0.1)
    light = dataclasses.replace(large, density_kg_m3=2500.0)
    fast = dataclasses.replace(scene.nozzle, speed_m_s=70.0)
    slanted = dataclasses.replace(fast, impact_angle_deg=30.0)  # 35 m/s normal
    mixed = dataclasses.replace(scene, media=(small, light, large), nozzles=(scene.nozzle, slanted))
    assert reference_impact(mixed) == (scene.nozzle, large)
    assert reference_impact(dataclasses.replace(mixed, nozzles=(scene.nozzle, fast))) == (fast, large)
