"""The points of a design: a grid of every combination, a Latin hypercube, or Sobol's points."""

from __future__ import annotations

import hashlib
import itertools
import warnings

import numpy as np

from glue.study.sweep.study import Study


def points(study: Study) -> list[dict[str, object]]:
    """{key path: value} of every point, in order; of a grid the last axis changes fastest.

    Sources: ``scipy.stats.qmc`` (Latin hypercube; Sobol's sequence with Owen's scrambling), the same from the same seed.
    """
    if study.kind == "grid":
        stands = list(itertools.product(*(axis.steps() for axis in study.axes)))
    else:
        stands = [[axis.at(u) for axis, u in zip(study.axes, row, strict=True)] for row in _unit_cube(study)]
    found = []
    for values in stands:
        changes: dict[str, object] = {}
        for axis, value in zip(study.axes, values, strict=True):
            changes |= axis.changes(value)
        found.append(changes)
    return found


def remarks(study: Study) -> list[str]:
    """What is to be said of the design, in words."""
    n = study.samples
    if study.kind != "sobol" or n & (n - 1) == 0:
        return []
    below = 1 << (n.bit_length() - 1)
    return [
        f"samples = {n}: Sobol's points fill the space evenly in powers of two; {below} or {2 * below} would, {n} lie a little"
        " less evenly"
    ]


def run_seed(study: Study, scene_seed: int, point: int, replicate: int) -> int:
    """Seed of the scene for a replicate of a point: other shots for each, unless the study shares them over points."""
    if study.seeds == "shared":
        return (scene_seed + replicate) % 2**32
    text = f"{scene_seed} {study.seed} {point} {replicate}"
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")


def _unit_cube(study: Study) -> np.ndarray:
    """Points in the unit cube, (samples, axes)."""
    from scipy.stats import qmc  # here: a grid does without it

    kind = {"lhs": qmc.LatinHypercube, "sobol": qmc.Sobol}[study.kind]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*balance properties")  # said by remarks()
        return kind(len(study.axes), seed=np.random.default_rng(study.seed)).random(study.samples)
