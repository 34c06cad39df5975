"""``peen run --target-error`` and ``--budget``: the cheapest measured combination good enough, or the best in time.

A combination takes a rung for each stage, or a whole preset; its error is the root of the sum of the rungs' squared
error bounds (stages err independently), its cost theirs, scaled by the impacts that the scene brings.  For a scene that
was not measured itself a rung's bound is that on the most similar one and, on top, the standard deviation over all
scenes measured.  Scatter of one run is no part of it: no mesh mends that (see ``uncertainty`` in metrics.json).  A
model that the scene asks for is never replaced.
"""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from glue.errors import InputError
from glue.flow.regime import expected_errors
from glue.scene.model import Scene
from glue.study.check import check
from glue.study.flow_stage import restitution_estimate
from glue.study.tradeoff.errors import bound
from glue.study.tradeoff.ladder import STAGES
from glue.study.tradeoff.lookup import row_settings, stage_rows
from glue.study.tradeoff.quantities import QUANTITIES
from glue.study.tradeoff.table import nearest, packaged

_ASKED = "asked for in the scene"
_SAME = 1e-6  # distance of a scene from itself
_NUMBERS = {
    "dimple": ("dimple_elements_per_radius", "dimple_steps_per_contact", "dimple_speeds"),
    "flow": ("flow_dt_over_P", "flow_stiffness_scale"),
    "coverage": ("coverage_points_per_radius",),
    "target": ("cell_side_in_radii", "cell_elements_per_side", "cell_load_steps", "cell_force_tolerance"),
    "surface": ("stamp_points_per_radius",),
}


class Part(NamedTuple):
    """One stage of a combination: the rung, its cost [s] on the scene, and its error bounds by quantity."""

    stage: str
    label: str
    changes: dict
    cost_s: float
    errors: dict[str, float]


class Combination(NamedTuple):
    parts: tuple[Part, ...]
    measured: str  # name of the scene it was measured on
    distance: float

    @property
    def cost_s(self) -> float:
        return sum(part.cost_s for part in self.parts)

    @property
    def errors(self) -> dict[str, float]:
        """Relative error bound by quantity, headline quantities only."""
        names = {name for part in self.parts for name in part.errors}
        return {n: math.sqrt(sum(part.errors.get(n, 0.0) ** 2 for part in self.parts)) for n in names}

    @property
    def worst(self) -> tuple[str, float]:
        """(quantity, error) of the largest."""
        return max(self.errors.items(), key=lambda item: item[1], default=("", 0.0))

    @property
    def changes(self) -> dict:
        """Of the scene: see ``glue.scene.derive.changed``."""
        found: dict = {}
        for part in self.parts:
            found |= part.changes
        return found


def choose(
    scene: Scene, *, target_error: float | None = None, budget_s: float | None = None, stages: Iterable[str] = STAGES,
    table: dict | None = None,
) -> Combination:  # fmt: skip
    """The cheapest combination within ``target_error``, or the most exact within ``budget_s``; both: within both.

    The error is relative.  Only what ``stages`` find counts.  Raises InputError when nothing fits, with the nearest
    that there is.
    """
    table = packaged() if table is None else table
    name, far = nearest(scene, table)
    wanted = [s for s in STAGES if s in set(stages)]
    others = [] if far < _SAME else list(table["scenes"].values())
    options = [_thin(_parts(scene, table["scenes"][name], stage, others)) for stage in wanted]
    missing = [stage for stage, some in zip(wanted, options, strict=True) if not some]
    if missing:
        none = f"no rung of {', '.join(missing)} was measured on {name}"
        raise InputError(f"--target-error, --budget: {none}; run peen tradeoff {name}")
    all_of = [Combination(parts, name, far) for parts in itertools.product(*options)]
    good = all_of if target_error is None else [c for c in all_of if c.worst[1] <= target_error]
    if not good:
        best = min(all_of, key=lambda c: (c.worst[1], c.cost_s))
        told = f"nothing measured is as exact; the nearest: {sentence(best)}"
        raise InputError(f"--target-error {target_error:.3g}: {told}")
    fast = good if budget_s is None else [c for c in good if c.cost_s <= budget_s]
    if not fast:
        best = min(good, key=lambda c: c.cost_s)
        raise InputError(f"--budget {budget_s:g} s: nothing measured is as fast; the nearest: {sentence(best)}")
    if target_error is None:  # a hundredth of the error is no reason to wait
        return min(fast, key=lambda c: (float(f"{c.worst[1]:.2g}"), c.cost_s))
    return min(fast, key=lambda c: (c.cost_s, c.worst[1]))


def sentence(c: Combination) -> str:
    """The combination in a line."""
    rungs = ", ".join(f"{part.stage} {part.label}" for part in c.parts)
    name, error = c.worst
    return f"{rungs}: about {c.cost_s:.0f} s, error within {100 * error:.2g} % ({name.replace('_', ' ')} is the worst)"


def text(c: Combination) -> str:
    """What was chosen and why, for reading."""
    labels = {q.name: q.label for q in QUANTITIES}
    lines = [f"chosen by errors measured on {c.measured} (distance {c.distance:.2f}; 1: a factor e in one number)"]
    for part in c.parts:
        worst = max(part.errors.items(), key=lambda item: item[1], default=None)
        why = "" if worst is None else f"error within {100 * worst[1]:.2g} %, of {labels[worst[0]]}"
        lines.append(f"  {part.stage:<9} {part.label:<34} {part.cost_s:7.1f} s   {why}")
    name, error = c.worst
    why = f"error within {100 * error:.2g} %, of {labels.get(name, '')}"
    lines.append(f"  together  {'':<34} {c.cost_s:7.1f} s   {why}")
    return "\n".join(lines)


def _parts(scene: Scene, entry: dict, stage: str, others: Sequence[dict]) -> list[Part]:
    numbers = check_numbers(scene)
    asked = getattr(scene.models, stage, None) if stage in ("flow", "target") else None
    found = []
    for row in stage_rows(entry, stage):
        model = row["changes"].get(f"models.{stage}")
        if asked is not None and asked.why == _ASKED and asked.model != model:
            continue
        settings = row_settings(row)
        changes = {f"accuracy.{key}": settings[key] for key in _NUMBERS[stage]}
        if model is not None:
            changes[f"models.{stage}"] = model
        errors = {
            q.name: b + _spread(others, row, q.name) for q in QUANTITIES
            if q.headline and q.name in row["quantities"] and (b := bound(row["quantities"][q.name])) is not None
        }  # fmt: skip
        if stage == "flow":  # how often shots meet is the scene's own, whatever it was measured on
            errors["normal_energy"] = max(errors.get("normal_energy", 0.0), numbers["flow_errors"][model])
        label = f"{row['factor']} {row['level']}"
        if model and model != row["level"]:
            label = f"{model}, {label}"
        found.append(Part(stage, label, changes, _cost_s(row, stage, numbers), errors))
    return found


def _spread(entries: Sequence[dict], row: dict, name: str) -> float:
    """Standard deviation over scenes of the bound of the same rung; 0 where fewer than two were measured."""
    same = [
        r["quantities"][name] for entry in entries for r in entry["rows"]
        if all(r[key] == row[key] for key in ("group", "factor", "level")) and name in r["quantities"]
    ]  # fmt: skip
    known = [b for q in same if (b := bound(q)) is not None]
    return statistics.stdev(known) if len(known) > 1 else 0.0


def check_numbers(scene: Scene) -> dict:
    """What costs and flow errors are scaled by."""
    told, e = check(scene), restitution_estimate(scene)[0]
    per_area = told["expected_impacts_in_window"] / scene.target.window_area_m2
    return {
        "flow": told["expected_shots"], "window": told["expected_impacts_in_window"],
        "per_radius2": per_area * told["dimple_radius_estimate_m"] ** 2, "flow_errors": expected_errors(scene, e),
    }  # fmt: skip


def _cost_s(row: dict, stage: str, numbers: dict) -> float:
    """Processor seconds on the scene: those measured, by impacts."""
    cost, work = row["cpu_s"] or 0.0, row["work"]
    if stage == "dimple" or not cost:
        return cost
    if stage == "target":
        if row["changes"].get("models.target") != "cell" or not work.get("target"):
            return cost
        return cost * numbers["per_radius2"] * row_settings(row)["cell_side_in_radii"] ** 2 / work["target"]
    if stage in ("coverage", "surface") and work.get("window"):
        return cost * numbers["window"] / work["window"]
    return cost * numbers["flow"] / work["flow"] if work.get("flow") else cost


def _thin(parts: Sequence[Part]) -> list[Part]:
    """Without those that another beats in cost and in every error."""

    def beats(a: Part, b: Part) -> bool:
        no_worse = a.cost_s <= b.cost_s and all(a.errors.get(n, 0.0) <= e for n, e in b.errors.items())
        return no_worse and (a.cost_s, a.errors) != (b.cost_s, b.errors)

    return [p for p in parts if not any(beats(other, p) for other in parts)]


def preset_block(scene: Scene, table: dict | None = None) -> list[str]:
    """Lines for ``peen check``: cost and error of the scene's preset as measured at the most similar scene.

    [] without a table, or where the preset was not measured.
    """
    try:
        table = packaged() if table is None else table
    except InputError:
        return []
    name, far = nearest(scene, table)
    same = (r for r in table["scenes"][name]["rows"] if (r["factor"], r["level"]) == ("preset", scene.accuracy.preset))
    row = next((r for r in same if r["quantities"]), None)
    if row is None:
        return []
    told = [
        f"{q.label} {'<' if found['hidden'] else ''}{100 * bound(found):.2g} {'pt' if q.scale == 'one' else '%'}"
        for q in QUANTITIES
        if q.headline and (found := row["quantities"].get(q.name)) and found["error"] is not None
    ]
    wall = " + ".join(f"{stage} {row['stage_cpu_s'][stage]:.0f}" for stage in STAGES if stage in row["stage_cpu_s"])
    impacts = f"{row['work'].get('flow', 0):.0f} shots, {row['work'].get('target', 0):.0f} impacts in the target"
    return [
        f"  measured on {name} (distance {far:.2f}; {impacts}; {table['provenance']['date']})",
        f"  cost        {row['cpu_s']:.0f} s ({wall}), {row['memory_bytes'] / 1e6:.0f} MB",
        f"  error       {', '.join(told)}",
    ]

