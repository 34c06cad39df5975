"""Accuracy presets: what "fast", "balanced" and "reference" stand for.  Numerics only, never physics."""

from __future__ import annotations

from dataclasses import dataclass

DEFAULT_PRESET = "balanced"
CELL_DEPTH_IN_RADII = 6.0  # of the target cell, every preset: plastic strain of full coverage ends near 4
PEENED_DEPTH_IN_RADII = 3.0  # a part thinner than this ends inside the peened layer (the target stage looks closer)


@dataclass(frozen=True)
class Accuracy:
    """A preset expanded to the numbers it stands for (see ``PRESETS``), with those that the scene states itself in
    their place: numerics only, never physics."""

    preset: str
    flow_tolerance: float  # error of mean normal energy and collided share that auto may accept of a flow model
    flow_dt_over_P: float  # time step over the P-wave step of the smallest shot
    flow_stiffness_scale: float  # Young's moduli of the contact flow over the materials' own
    dimple_elements_per_radius: int  # a/h at the surface, a the expected dimple radius
    dimple_steps_per_contact: float  # time steps per expected contact time
    dimple_speeds: int  # solved, from the reference speed down; a faster one that a nozzle can shoot comes on top
    cell_side_in_radii: float  # periodic cell side over dimple radius
    cell_elements_per_side: int
    cell_load_steps: int  # penetration steps of one impact
    cell_force_tolerance: float  # out-of-balance forces over the contact force
    coverage_points_per_radius: float  # raster points per dimple radius
    stamp_points_per_radius: float
    target_patches: int = 1  # of the window, solved one after another by the cell or the block
    dimple_speed_ratio: float = 0.0  # the dimple lies between impacts at its powers, which scenes share; 0: own impact


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
