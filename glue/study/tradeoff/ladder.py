"""The ladder: every choice of a stage that has a price, as data.

A *group* is a stage judged by itself: its rungs and its reference differ in that stage's choices only, everything else is
the cheap ``base``.  A rung changes one factor of the group's own start, or is a whole preset.  A reference shares no mesh,
step or raster with any rung of its group.  Dimple and arrivals are inputs of what comes after them: the same for all.
"""

from __future__ import annotations

from dataclasses import dataclass, field

STAGES = ("dimple", "flow", "coverage", "target", "surface")


@dataclass(frozen=True)
class Rung:
    """One choice: ``changes`` {key path of the scene: value} on top of its group's."""

    factor: str
    level: str
    changes: dict
    seeds: int | None = None  # default: the group's
    physics: bool = False  # adds or removes physics: what is measured is that physics, no numerical error
    dear: bool = False  # on the first scene of a set alone


@dataclass(frozen=True)
class Group:
    """``reference`` and ``rungs`` on the same scene, seeds and exposure."""

    name: str
    stage: str  # that is judged; "whole": all
    base: dict
    reference: dict
    rungs: tuple[Rung, ...]
    hits: float | None = None  # mean hits per point that the exposure is shortened to; None: the scene's exposure
    seeds: int = 3
    paired: bool = True  # rung and reference have the same seeds: what their arrivals share drops out
    own: tuple[str, ...] = field(default=STAGES)  # stages that are run
    reference_seeds: int | None = None
    short_seeds: int | None = None  # on the other scenes of a set than the first, 0: not there; default: as on the first


def _accuracy(**numbers) -> dict:
    return {f"accuracy.{key}": value for key, value in numbers.items()}


# Cheap, and the same for rungs and reference: what a group does not judge.
_CHEAP = {
    "models.flow": "event", "models.target": "layers", "accuracy.preset": "fast",
    **_accuracy(dimple_elements_per_radius=6, coverage_points_per_radius=20.0, stamp_points_per_radius=8.0),
}  # fmt: skip
_CELL = {"models.target": "cell", **_accuracy(cell_side_in_radii=4.8, cell_elements_per_side=7, cell_load_steps=3,
                                              cell_force_tolerance=1e-2)}  # fmt: skip

DIMPLE = Group(
    "dimple", "dimple", _CHEAP | _accuracy(dimple_speeds=3),
    reference=_accuracy(dimple_elements_per_radius=16, dimple_steps_per_contact=140.0, dimple_speeds=4),
    rungs=(
        *(Rung("mesh", f"a/{n}", _accuracy(dimple_elements_per_radius=n)) for n in (3, 4, 6, 8, 12)),
        *(Rung("steps per contact", f"{n:g}", _accuracy(dimple_steps_per_contact=n)) for n in (45.0, 180.0)),
        Rung("speeds solved", "2", _accuracy(dimple_speeds=2)),
        Rung("speeds solved", "5", _accuracy(dimple_speeds=5)),
        Rung("physics", "small strain", {"models.dimple": "small_strain"}, physics=True),
        Rung("physics", "target inertia", {"target_inertia": {}}, physics=True),
        Rung("physics", "strain rate", {"strain_rate": {}}, physics=True),
        Rung("physics", "elastic shot", {"elastic_shot": {}}, physics=True),
    ),
    hits=1.2,
)  # fmt: skip
FLOW = Group(
    "flow", "flow", _CHEAP,
    reference={"models.flow": "dem", **_accuracy(flow_dt_over_P=0.1)},
    rungs=(
        Rung("flow model", "ballistic", {"models.flow": "ballistic"}),
        Rung("flow model", "event", {"models.flow": "event"}),
        *(Rung("dt/P", f"{x:g}", {"models.flow": "dem", **_accuracy(flow_dt_over_P=x)}) for x in (1.0, 0.5, 0.3)),
        *(Rung("stiffness scale", f"{s:g}", {"models.flow": "dem", **_accuracy(flow_dt_over_P=1.0, flow_stiffness_scale=s)})
          for s in (0.3, 0.1)),
    ),
    hits=1.2,
)  # fmt: skip
COVERAGE = Group(
    "coverage", "coverage", _CHEAP, reference=_accuracy(coverage_points_per_radius=90.0),
    rungs=tuple(
        Rung("raster points per radius", f"{n:g}", _accuracy(coverage_points_per_radius=n)) for n in (6.0, 12.0, 20.0, 40.0)
    ),
    own=("dimple", "flow", "coverage"),
)  # fmt: skip
SURFACE = Group(
    "surface", "surface", _CHEAP, reference=_accuracy(stamp_points_per_radius=40.0),
    rungs=tuple(
        Rung("stamp points per radius", f"{n:g}", _accuracy(stamp_points_per_radius=n)) for n in (6.0, 12.0, 16.0, 24.0)
    ),
    own=("dimple", "flow", "surface"), hits=2.5,
)  # fmt: skip
TARGET = Group(
    "target", "target", _CHEAP | _CELL,
    reference=_accuracy(cell_elements_per_side=12, cell_load_steps=8, cell_force_tolerance=1e-3),
    rungs=(
        Rung("target model", "layers", {"models.target": "layers"}),
        Rung("cell elements per side", "5", _accuracy(cell_elements_per_side=5)),
        Rung("cell elements per side", "7", {}),
        Rung("cell elements per side", "9", _accuracy(cell_elements_per_side=9)),
        Rung("cell elements, load steps", "8, 2", _accuracy(cell_elements_per_side=8, cell_load_steps=2)),
        *(Rung("cell load steps", f"{n}", _accuracy(cell_load_steps=n)) for n in (1, 2, 6)),
        *(Rung("cell force tolerance", f"{x:g}", _accuracy(cell_force_tolerance=x)) for x in (5e-2, 3e-3)),
        Rung("cell side", "4.0 radii", _accuracy(cell_side_in_radii=4.0, cell_elements_per_side=6, cell_load_steps=2,
                                                 cell_force_tolerance=2e-2)),
        Rung("cell side", "6.4 radii", _accuracy(cell_side_in_radii=6.4, cell_elements_per_side=10)),
    ),
    hits=1.2, seeds=2, own=("dimple", "flow", "target"), short_seeds=1,
)  # fmt: skip
BLOCK = Group(
    "block", "target", _CHEAP | _CELL, reference={"models.target": "contact"},
    rungs=(
        Rung("against the block", "layers", {"models.target": "layers"}),
        Rung("against the block", "cell 4.0, 6 elements",
             _accuracy(cell_side_in_radii=4.0, cell_elements_per_side=6, cell_load_steps=2, cell_force_tolerance=2e-2)),
        Rung("against the block", "cell 4.8, 8 elements", _accuracy(cell_elements_per_side=8, cell_load_steps=2)),
    ),
    hits=0.6, seeds=1, own=("dimple", "flow", "target"), short_seeds=0,
)  # fmt: skip
# Chance: one window, half of it, a fast cell under other arrivals.  The reference is the mean of other seeds.
CHANCE = Group(
    "chance", "seeds", _CHEAP, reference={"seed_offset": 1000},
    rungs=(
        Rung("window", "whole", {}),
        Rung("window", "half the sides", {"window_scale": 0.5}),
    ),
    seeds=8, paired=False, own=("dimple", "flow", "coverage", "surface"),
)  # fmt: skip
_PATCH_SIDE = 4.8


def _patches(name: str, hits: float) -> Group:
    return Group(
        name, "seeds", _CHEAP | _CELL | _accuracy(cell_side_in_radii=_PATCH_SIDE, cell_elements_per_side=5, cell_load_steps=2),
        reference={"seed_offset": 1000}, rungs=(Rung("patch of the cell", f"{_PATCH_SIDE:g} radii, {hits:g} hits", {}),),
        hits=hits, seeds=6, paired=False, own=("dimple", "flow", "target"),
    )  # fmt: skip


PATCHES = (_patches("patches", 1.2), _patches("patches-full", 4.0))
WHOLE = Group(
    "whole", "whole", {},
    reference={
        "models.flow": "dem", "models.target": "cell", "accuracy.preset": "reference",
        **_accuracy(flow_dt_over_P=0.2, dimple_elements_per_radius=16, dimple_steps_per_contact=140.0, dimple_speeds=4,
                    coverage_points_per_radius=60.0, stamp_points_per_radius=32.0, cell_side_in_radii=4.8,
                    cell_elements_per_side=11, cell_load_steps=8, cell_force_tolerance=1e-3),
    },
    rungs=(
        Rung("preset", "fast", {"accuracy.preset": "fast"}),
        Rung("preset", "balanced", {"accuracy.preset": "balanced"}),
        Rung("preset", "reference", {"accuracy.preset": "reference"}, seeds=1, dear=True),
    ),
    hits=1.2, seeds=2,
)  # fmt: skip

GROUPS = (COVERAGE, SURFACE, CHANCE, *PATCHES, FLOW, DIMPLE, TARGET, WHOLE, BLOCK)
PATCH_SIDE_IN_RADII = _PATCH_SIDE
BUILT_IN = ("al2024-s390", "al2024-s110", "steel4340-s390", "mixed-s230-s390-traverse")
QUICK = ("coverage", "chance")
