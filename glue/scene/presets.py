"""Accuracy presets: what "fast", "balanced" and "reference" stand for.  Numerics only, never physics."""

from __future__ import annotations

from glue.scene.model import Accuracy

DEFAULT_PRESET = "balanced"
CELL_DEPTH_IN_RADII = 6.0  # of the target cell, every preset: plastic strain of full coverage ends near 4
PEENED_DEPTH_IN_RADII = 3.0  # a part thinner than this ends inside the peened layer (the target stage looks closer)

PRESETS: dict[str, Accuracy] = {
    accuracy.preset: accuracy
    for accuracy in (
        Accuracy(
            preset="fast",
            flow_tolerance=0.02,
            flow_dt_over_P=1.0,
            flow_stiffness_scale=1.0,
            dimple_elements_per_radius=3,
            dimple_steps_per_contact=90.0,
            dimple_speeds=3,
            cell_side_in_radii=4.0,
            cell_elements_per_side=6,
            cell_load_steps=2,
            cell_force_tolerance=2e-2,
            coverage_points_per_radius=12.0,
            stamp_points_per_radius=12.0,
        ),
        Accuracy(
            preset="balanced",
            flow_tolerance=0.005,
            flow_dt_over_P=1.0,
            flow_stiffness_scale=1.0,
            dimple_elements_per_radius=6,
            dimple_steps_per_contact=90.0,
            dimple_speeds=5,
            cell_side_in_radii=4.8,
            cell_elements_per_side=8,  # the cell's error is that of its elements; load steps hardly change it
            cell_load_steps=2,
            cell_force_tolerance=1e-2,
            coverage_points_per_radius=20.0,
            stamp_points_per_radius=16.0,
        ),
        Accuracy(
            preset="reference",
            flow_tolerance=0.002,
            flow_dt_over_P=0.3,
            flow_stiffness_scale=1.0,
            dimple_elements_per_radius=12,
            dimple_steps_per_contact=90.0,
            dimple_speeds=9,
            cell_side_in_radii=6.4,
            cell_elements_per_side=12,
            cell_load_steps=4,
            cell_force_tolerance=2e-3,
            coverage_points_per_radius=40.0,
            stamp_points_per_radius=24.0,
        ),
    )
}
