"""An impact log from elsewhere in place of the flow's own: held against the scene, then written as the scene's log."""

from __future__ import annotations

import hashlib
import json
import time
from pathlib import Path

import numpy as np

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.flow import regime
from glue.flow.arrivals import scene_hash
from glue.flow.impacts import read_impacts, stream_numbers, write_impacts
from glue.flow.log_checks import log_problems
from glue.flow.surface import PLANE, TargetSurface
from glue.scene import sizes
from glue.scene.fields import UNITS, show
from glue.scene.model import Scene

IMPORTED = "imported_impacts.csv"  # beside the scene in the run directory
_TOUCH = 0.05  # distance of a touched point from the surface over the shot's diameter: other codes overlap or sample in time
_OTHER = 0.05  # share by which a shot's diameter or density may lie beyond those of the scene's media: rounding, wear
_FEWER = 0.1  # by which the number of impacts may differ from that of the scene's shots before it is told


def content_of(path: Path) -> bytes:
    """The log's bytes.  Raises InputError when there is none."""
    try:
        return Path(path).read_bytes()
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from None


def sha256_of(path: Path) -> str:
    """sha256 (hex) of the log's content; errors as of ``content_of``."""
    return hashlib.sha256(content_of(path)).hexdigest()


def check_imported(scene: Scene, source: Path, surface: TargetSurface) -> tuple[np.ndarray, dict]:
    """(impacts, header) of the log ``source`` (from ``peen import``, or another run's), on the scene's surface.

    Raises InputError with everything in which it cannot be the scene's: speeds, places, nozzles and media it has not,
    shots of other sizes or densities than its media, no impact that reaches the window.
    """
    impacts, header = read_impacts(source)
    if surface.kind == PLANE:
        near = np.abs(impacts["z_m"]) <= _TOUCH * impacts["diameter_m"]
        impacts["z_m"] = np.where(near, 0.0, impacts["z_m"])
    problems = log_problems(scene, None, impacts, surface, touch=_TOUCH)
    for name, known in (("nozzle_id", len(scene.nozzles)), ("medium", len(scene.media))):
        if len(impacts) and not (0 <= impacts[name].min() and impacts[name].max() < known):
            problems.append(f"{name} goes to {impacts[name].max()}; allowed: 0 to {known - 1}, the scene has {known}")
    problems += _other_shots(scene, impacts) + _beside_window(scene, impacts)
    if problems:
        raise InputError([f"{source}: {sentence}" for sentence in problems])
    return impacts, header


def _other_shots(scene: Scene, impacts: np.ndarray) -> list[str]:
    """Sentences about shots that no medium of the scene has; both numbers, and the unit that they may be in."""
    spans = {
        "diameter_m": ("m", [(sizes.smallest_m(shots), sizes.largest_m(shots)) for shots in scene.media]),
        "density_kg_m3": ("kg/m3", [(shots.density_kg_m3, shots.density_kg_m3) for shots in scene.media]),
    }
    told = []
    for name, (unit, ranges) in spans.items():
        ranges = [((1.0 - _OTHER) * low, (1.0 + _OTHER) * high) for low, high in ranges]
        values = np.asarray(impacts[name])
        alien = values[~np.any([(low <= values) & (values <= high) for low, high in ranges], axis=0)]
        if not alien.size:
            continue
        first, last = float(alien.min()), float(alien.max())
        found = show(first) if first == last else f"{show(first)} to {show(last)}"
        allowed = " or ".join(f"{show(low)} to {show(high)}" for low, high in ranges)
        meant = [
            other
            for other, size in UNITS[unit][1]
            if any(low <= size * first and size * last <= high for low, high in ranges)
        ]
        hint = f"is it in {meant[0]} (unit in the map of peen import)?" if meant else "is its unit in the map right?"
        told.append(
            f"{alien.size} of {len(values)} impacts: {name} is {found}; allowed: {allowed} {unit}, that of the scene's"
            f" shots; {hint}"
        )
    return told


def _beside_window(scene: Scene, impacts: np.ndarray) -> list[str]:
    """A sentence when no impact reaches into the window: no dimple is wider than the largest shot."""
    reaches = np.ones(len(impacts), bool)
    for name, size in zip(("x_m", "y_m"), scene.target.window_m, strict=True):
        reaches &= np.abs(impacts[name]) <= 0.5 * (size + scene.largest_diameter_m)
    if reaches.any():
        return []
    if not len(impacts):
        return ["holds no impact"]
    where = ", ".join(f"{name} {show(impacts[name].min())} to {show(impacts[name].max())}" for name in ("x_m", "y_m"))
    window = " x ".join(show(size) for size in scene.target.window_m)
    return [
        f"none of {len(impacts)} impacts reaches the window of {window} m about (0, 0): {where}; is the table in mm"
        " (unit in the map of peen import), or its origin elsewhere (origin_m)?"
    ]


def use_imported(scene: Scene, source: Path, out: Path, surface: TargetSurface, restitution: float) -> dict:
    """Write ``impacts.csv`` and ``flow.json`` into ``out`` from the log ``source``; returns what ``run_flow`` tells as info.

    Raises InputError as ``check_imported`` does.
    """
    start = time.monotonic()
    impacts, header = check_imported(scene, source, surface)
    made = header.get("source") or header.get("model") or "unknown"
    digest = sha256_of(source)
    write_impacts(
        out / "impacts.csv", impacts,
        {"scene_hash": scene_hash(scene), "model": "imported", "source": made, "imported_sha256": digest},
    )  # fmt: skip
    info = {
        **stream_numbers(impacts, [nozzle.speed_m_s for nozzle in scene.nozzles]),
        "model": "imported",
        "why": f"peen run --impacts: from {made}, log of sha256 {digest[:12]}",
        "warnings": _warnings(scene, impacts),
        "collision_number": regime.collision_number(scene, restitution)["pi_eff"],
        "physics": {},
        "wall_s": time.monotonic() - start,
    }
    write_text_atomic(out / "flow.json", json.dumps(info, indent=2) + "\n")
    return info


def _warnings(scene: Scene, impacts: np.ndarray) -> list[str]:
    """Where the log and the scene's jet do not speak of the same peening."""
    told, last = [], float(impacts["time_s"].max()) if len(impacts) else 0.0
    shots = len(np.unique(impacts["shot_id"]))
    if abs(shots / scene.expected_shots - 1.0) > _FEWER:
        told.append(
            f"the log has {shots} shots, the scene's jet feeds {scene.expected_shots:.0f}: what is told of the jet (Avrami by"
            " mass flow, intervals) is the scene's, not the log's"
        )
    if last > 1.1 * scene.exposure_time_s:
        told.append(f"the log ends at {last:.3g} s, the scene's exposure_time_s is {scene.exposure_time_s:g}")
    return told
