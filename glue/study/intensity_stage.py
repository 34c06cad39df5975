"""The intensity that a scene asks for, confirmed by periodic cells of strip steel; the layer model found the speed.

Runs where a nozzle says an intensity and the preset is finer than fast.  The cells of a stream are kept in the cache.
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np

from glue.scene.model import Scene
from glue.scene.presets import Accuracy
from glue.study.dimple_stage import ready_kernels
from glue.study.results import plain
from glue.study.shot_stream import stream_of
from glue.study.stage import Work
from glue.study.strip_cells import MULTIPLES, PATCHES, CellCurve, cell_curve
from glue.surface.saturation import Saturation, fit_saturation
from glue.target.cache import cached_folder, content_key
from glue.target.strip import MODEL_ERROR, StripLibrary, Stream, strip_library
from glue.theory.almen import Strip, mils, read_intensity

_SOURCES = (
    "glue/study/strip_cells.py", "glue/target/*.py", "freefem/cell*.edp", "freefem/single_impact.edp", "freefem/lib/*.idp",
    "freefem/plugin/*",
)  # fmt: skip
_NUMBERS = ("dimple_elements_per_radius", "cell_side_in_radii", "cell_elements_per_side", "cell_load_steps", "cell_force_tolerance")


def confirms(scene: Scene) -> bool:
    """Does a run of this scene hold its intensities against cells?"""
    said = scene.specification
    return said is not None and any(said.intensities) and scene.accuracy.preset != "fast"


def intensity_solvers(scene: Scene, path: Path) -> tuple[str, ...]:
    return ("freefem",) if confirms(scene) else ()


def intensity_stage(work: Work) -> tuple[dict, list[str]]:
    """The saturation curve of the strip at the speed found, by cells: is its intensity the one asked for?

    Of several nozzles that say one, each alone; metrics.json has the one that is furthest off.
    """
    if not confirms(work.scene):
        return {}, []
    ready_kernels()
    library = strip_library(lambda share, text: work.progress(None, f"strip steel: {text}"))
    asked = [(k, text) for k, text in enumerate(work.scene.specification.intensities) if text]
    found = []
    for number, (k, text) in enumerate(asked):

        def tell(share, line, number=number):
            work.progress((number + share) / len(asked), line)

        found.append({"nozzle": k, **_confirm(work.scene, k, text, library, tell)})
    worst = max(found, key=lambda each: abs(each["over_asked"]) if each["over_asked"] is not None else np.inf)
    return {"intensity": plain(worst)}, []


def cells_of_stream(library: StripLibrary, strip: Strip, stream: Stream, accuracy: Accuracy, seed: int, progress=None) -> CellCurve:
    """``cell_curve``, from the cache where it was solved before."""
    numbers = {key: getattr(accuracy, key) for key in _NUMBERS}
    shots = [np.asarray(column).tolist() for column in stream]
    steel = dataclasses.asdict(library.material)
    key = content_key({"strip": strip, "stream": shots, "numbers": numbers, "seed": seed, "steel": steel}, _SOURCES)

    def make(folder: Path) -> None:
        curve = cell_curve(library, strip, stream, accuracy, seed=seed, progress=progress)
        (folder / "curve.json").write_text(json.dumps([np.asarray(column).tolist() for column in curve]))

    folder, _ = cached_folder("strip-cells", key, make)
    return CellCurve(*(np.array(column) for column in json.loads((folder / "curve.json").read_text())))


def _confirm(scene: Scene, k: int, text: str, library: StripLibrary, progress) -> dict:
    wanted = read_intensity(text)
    stream = stream_of(dataclasses.replace(scene, nozzles=(scene.nozzles[k],)))
    curve = cells_of_stream(library, wanted.strip, stream, scene.accuracy, scene.seed, progress)
    found: Saturation = fit_saturation(curve.hits / library.hits_1_s(stream), curve.arc_height_m)
    told = {
        "asked_m": wanted.aim_m, "asked_low_m": wanted.low_m, "asked_high_m": wanted.high_m, "strip": wanted.strip.letter,
        "speed_m_s": scene.nozzles[k].speed_m_s, "layers_m": library.intensity_m(wanted.strip, stream),
        "cells": PATCHES, "exposures": len(curve.hits),
    }  # fmt: skip
    if found.problem:
        return told | {"cells_m": None, "cells_m_reason": found.problem, "over_asked": None, "confirmed": None,
                       "over_asked_reason": found.problem, "confirmed_reason": found.problem}  # fmt: skip
    error = float(np.max(curve.standard_error_m / curve.arc_height_m))
    off = found.intensity_m / wanted.aim_m - 1.0
    sure = bool(abs(off) <= MODEL_ERROR + 2.0 * error)
    inside = wanted.low_m * (1.0 - MODEL_ERROR) <= found.intensity_m <= wanted.high_m * (1.0 + MODEL_ERROR)
    told |= {
        "cells_m": found.intensity_m, "cells_standard_error_relative": error, "over_asked": off, "confirmed": sure or inside,
        "saturation_exposure_s": found.best.saturation,
    }  # fmt: skip
    if not told["confirmed"]:
        letter = wanted.strip.letter
        told["warning"] = (
            f"cells find {mils(found.intensity_m):.2f}{letter} where {wanted} was asked for ({off:+.0%}; layers and cells agree to"
            f" {MODEL_ERROR:.0%}): take the speed as that uncertain, or calibrate [machine] with measured curves"
        )
    return told


def seconds(scene: Scene, each_s: float) -> float:
    """Rough wall time [s] of the confirmation; ``each_s``: of one impact in the cell."""
    if not confirms(scene):
        return 0.0
    per_hit = scene.accuracy.cell_side_in_radii**2 / np.pi
    return sum(map(bool, scene.specification.intensities)) * PATCHES * max(MULTIPLES) * per_hit * each_s

