"""Which measured rung speaks for a run's numbers: one that is as coarse or coarser in every number of the stage."""

from __future__ import annotations

from collections.abc import Iterable

from glue.scene.model import Scene
from glue.scene.presets import PRESETS, Accuracy
from glue.study.tradeoff.errors import bound

# Numbers of each stage; +1: more is finer, -1: less is finer.
_FINER = {
    "dimple": {"dimple_elements_per_radius": 1, "dimple_steps_per_contact": 1, "dimple_speeds": 1},
    "flow": {"flow_dt_over_P": -1, "flow_stiffness_scale": 1},
    "coverage": {"coverage_points_per_radius": 1},
    "target": {"element_in_radii": -1, "cell_load_steps": 1, "cell_force_tolerance": -1},
    "surface": {"stamp_points_per_radius": 1},
}
MODEL_STAGES = ("flow", "target")


def settings_of(accuracy: Accuracy) -> dict[str, float]:
    """The numbers of a run, with the cell's element size among them."""
    numbers = {k: v for k, v in vars(accuracy).items() if k != "preset"}
    return numbers | {"element_in_radii": accuracy.cell_side_in_radii / accuracy.cell_elements_per_side}


def row_settings(row: dict) -> dict[str, float]:
    """The numbers that a row was measured with."""
    stated = {k.removeprefix("accuracy."): v for k, v in row["changes"].items() if k.startswith("accuracy.")}
    numbers = vars(PRESETS[stated.pop("preset", "balanced")]) | stated
    numbers["element_in_radii"] = numbers["cell_side_in_radii"] / numbers["cell_elements_per_side"]
    return numbers


def stage_rows(entry: dict, stage: str) -> list[dict]:
    """Rows of the stage's group that were measured and are no physics, reference left out."""
    return [
        r for r in entry["rows"]
        if r["group"] == stage and r["factor"] != "reference" and not r["physics"] and not r["failed"] and r["quantities"]
    ]  # fmt: skip


def speaking(entry: dict, stage: str, numbers: dict[str, float], model: str | None = None) -> list[dict]:
    """The rows whose error bounds that of ``numbers`` (see ``settings_of``) with ``model`` of a flow or target.

    Of those that are no finer in any number, the ones that no other of them refines; all of the model's where the run is
    coarser than every rung.
    """
    rows = stage_rows(entry, stage)
    if stage in MODEL_STAGES:
        rows = [r for r in rows if r["changes"].get(f"models.{stage}") == model]
        if model in ("ballistic", "event", "layers"):  # they have no numbers of their own
            return rows
    keys = _FINER[stage]

    def no_finer(a: dict[str, float], b: dict[str, float]) -> bool:
        return all(sign * (a[key] - b[key]) <= 1e-9 * abs(b[key]) for key, sign in keys.items())

    known = [(r, row_settings(r)) for r in rows]
    coarser = [(r, s) for r, s in known if no_finer(s, numbers)]
    nearest = [r for r, s in coarser if not any(no_finer(s, other) and not no_finer(other, s) for _, other in coarser)]
    return nearest or rows


def numerical(entry: dict, scene: Scene, models: dict[str, str], stages: Iterable[str] = _FINER) -> dict[str, float]:
    """{quantity: relative error bound}: root of the sum over stages of the largest bound among the rows that speak for the run.

    ``models``: that of flow and target as they ran.  A quantity on which no stage was measured is left out.
    """
    numbers, squares = settings_of(scene.accuracy), {}
    for stage in stages:
        rows = speaking(entry, stage, numbers, models.get(stage))
        for name in {n for r in rows for n in r["quantities"]}:
            known = [b for r in rows if name in r["quantities"] and (b := bound(r["quantities"][name])) is not None]
            if known:
                squares[name] = squares.get(name, 0.0) + max(known) ** 2
    return {name: square**0.5 for name, square in squares.items()}
