"""From what a drawing says to what a scene needs: speeds from intensities or machine settings, time from coverage.

Speeds come from the strip model (``glue.target.strip``: layers, preset fast); the exposure from one solved dimple of the
target, the nozzles' footprints and Avrami.  All that was found is told with its uncertainty.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable
from pathlib import Path

from glue.errors import InputError
from glue.scene.consistency import estimated_dimple_radius_m
from glue.scene import schema
from glue.scene.model import Nozzle, Scene
from glue.scene.reader import read_bytes, read_scene
from glue.scene.specification import INFERRED
from glue.scene.measured import beside
from glue.study.coverage_stage import FULL_COVERAGE
from glue.study.dimple_stage import ready_kernels
from glue.study.exposure import estimated_areas_m2, expected_hits
from glue.study.machine import Calibrated, calibrate, exit_speed
from glue.study.measured import read_profile
from glue.study.reference import reference_impact
from glue.study.shot_stream import energy_lost, stream_of
from glue.target.dimple import zero_height_radius
from glue.target.reduced_impact import solve_reduced
from glue.target.strip import ELEMENTS, MODEL_ERROR, IntensityCurve, Stream, StripLibrary, strip_library
from glue.theory.almen import mils, read_intensity

Progress = Callable[[str, float | None, str], None]
RADIUS_ERROR = 0.01  # of a dimple at preset fast; area and time follow with its double


def read_specified(
    path: Path, *, preset: str | None = None, content: bytes | None = None, progress: Progress = lambda *_: None
) -> tuple[Scene, dict[str, bytes]]:
    """A scene with all that it only specifies found, and the files that must lie beside it to be read again.

    Errors are those of ``read_scene``, of intensities, curves and coverages out of reach (InputError), and of the
    solver (SolverFailed, NotConverged).
    """
    content = read_bytes(path) if content is None else content
    scene = read_scene(path, preset=preset, content=content, provisional=True)
    files = {}
    if scene.measured is not None and scene.measured.stress_file:
        source = beside(path, scene.measured.stress_file)
        read_profile(source)  # its mistakes are told before anything runs
        files[source.name] = source.read_bytes()
    if scene.specification is None:
        return scene, files
    found = infer(scene, path, progress) | {"schema": 1, "scene_sha256": hashlib.sha256(content).hexdigest()}
    files |= {INFERRED: (json.dumps(found, indent=2) + "\n").encode()}
    machine = scene.specification.machine
    for curve in machine.curves if machine else ():
        source = beside(path, curve.file)
        files[Path(curve.file).name] = source.read_bytes()
    return read_scene(path, preset=preset, content=content, inferred=found), files


def infer(scene: Scene, scene_file: Path, progress: Progress) -> dict:
    """{speed_m_s by nozzle, exposure_time_s, text, …} for a scene read with stand-ins."""
    said, text, problems = scene.specification, [], []
    library = None
    if any(said.intensities) or (said.machine and said.machine.curves):
        ready_kernels()
        library = strip_library(lambda share, line: progress("strip", share, line))
    machine = None
    try:
        machine = _machine(scene, scene_file, library)
    except InputError as problem:
        problems += problem.problems
    nozzles = list(scene.nozzles)
    for k, nozzle in enumerate(scene.nozzles):
        key = "nozzle" if len(nozzles) == 1 else f"nozzle[{k + 1}]"
        try:
            if said.intensities[k]:
                nozzles[k] = _by_intensity(scene, k, said.intensities[k], library, machine, key, text)
            elif said.settings[k] is not None and machine is not None:
                nozzles[k] = _by_setting(nozzle, said.settings[k], machine, key, text)
        except InputError as problem:
            problems += [f"{scene_file}: {key}.intensity: {sentence}" for sentence in problem.problems]
    if problems:
        raise InputError(problems)
    if machine is not None:
        text[:0] = machine.text
    scene = dataclasses.replace(scene, nozzles=tuple(nozzles))
    found = {"speed_m_s": [n.speed_m_s for n in nozzles], "exposure_time_s": scene.exposure_time_s}
    if said.coverage_percent is not None:
        found |= _exposure(scene, scene_file, said.coverage_percent, progress, text)
    return found | {"text": text}


def _machine(scene: Scene, scene_file: Path, library: StripLibrary | None) -> Calibrated | None:
    machine = scene.specification.machine
    if machine is None:
        return None
    k = next((k for k, at in enumerate(scene.specification.settings) if at is not None), 0)

    def arriving(speed_m_s: float) -> Stream:
        nozzle = dataclasses.replace(scene.nozzles[k], speed_m_s=speed_m_s)
        return stream_of(dataclasses.replace(scene, nozzles=(nozzle,)))

    return calibrate(machine, scene_file, library, arriving)


def _round(value: float) -> float:
    """Four digits: far finer than anything here is known, and the same again next time."""
    return float(f"{value:.4g}")


def _by_intensity(
    scene: Scene, k: int, written: str, library: StripLibrary, machine: Calibrated | None, key: str, text: list[str]
) -> Nozzle:
    wanted, nozzle = read_intensity(written), scene.nozzles[k]

    def arriving(speed_m_s: float) -> Stream:
        return stream_of(dataclasses.replace(scene, nozzles=(dataclasses.replace(nozzle, speed_m_s=speed_m_s),)))

    heights, ends, start = {wanted.low_m, wanted.aim_m, wanted.high_m}, {}, nozzle.speed_m_s
    for _ in range(1 if scene.air_drag is None else 2):  # drag changes how the speeds of large and small shots compare
        stream = arriving(start)
        curves = IntensityCurve(library, wanted.strip, stream)
        for height in heights:
            ends[height] = exit_speed(float(stream.normal_speed_m_s.mean()) * curves.factor(height), arriving)
        start = ends[wanted.aim_m]
    speed = _round(ends[wanted.aim_m])
    exponent = curves.exponent(curves.factor(wanted.aim_m, polish=False))
    slow, fast = ends[wanted.low_m], ends[wanted.high_m]
    window = f", {mils(wanted.low_m):g} to {mils(wanted.high_m):g} at {slow:.4g} to {fast:.4g} m/s"
    alone = dataclasses.replace(scene, nozzles=(dataclasses.replace(nozzle, speed_m_s=speed),))
    stream, lost = stream_of(alone), energy_lost(alone)
    hits, _ = library.saturation(wanted.strip, stream)
    off = MODEL_ERROR / exponent
    text.append(
        f"{key}.speed_m_s = {speed:g} from intensity {wanted} on strip {wanted.strip.letter}"
        f"{window if wanted.low_m < wanted.high_m else ''}, collisions taking {lost:.1%} of the energy (estimate);"
        f" ± {off:.0%} by the strip model (± {MODEL_ERROR:.0%} of the arc height, which goes with speed^{exponent:.2f}), and by"
        f" the strip steel's law, grade {library.material.grade}"
    )
    text.append(
        f"{key}: the strip saturates after about {hits / library.hits_1_s(stream):.3g} s of this jet at rest"
        f" ({hits:.2f} hits per point)"
    )
    if machine is not None:
        setting = machine.setting_for(speed)
        low, high = machine.machine.range
        text.append(
            f"{key}: {machine.machine.setting} = {setting:.4g} on the machine"
            if setting is not None
            else f"{key}: no {machine.machine.setting} within the calibration ({low:g} to {high:g}) gives that speed"
        )
    return dataclasses.replace(nozzle, speed_m_s=speed)


def _by_setting(nozzle: Nozzle, setting: float, machine: Calibrated, key: str, text: list[str]) -> Nozzle:
    found = machine.speed(setting)
    sure = f"{found.low:.4g} to {found.high:.4g} m/s"
    kind, note = "95 %", ""
    if machine.machine.table:
        kind = "the table's own curvature"
    if machine.law is not None:
        kind = "95 %, by the curves' own scatter"
        note = f"; besides ± {MODEL_ERROR:.0%} of the arc height by the strip model, the same for all intensities"
    said = f"{machine.machine.setting} = {setting:g}"
    text.append(f"{key}.speed_m_s = {_round(found.value):g} from {said}: {sure} ({kind}){note}")
    return dataclasses.replace(nozzle, speed_m_s=_round(found.value))


def _exposure(scene: Scene, scene_file: Path, percent: float, progress: Progress, text: list[str]) -> dict:
    """The exposure that covers ``percent``: 100 is 98 %, beyond it multiples of that; {"exposure_time_s", "passes" of a feed}."""
    nozzle, shots = reference_impact(scene)
    material, speed = scene.target.material, nozzle.normal_speed_m_s
    ready_kernels()
    progress("dimple", 0.0, f"impact on the target at {speed:.4g} m/s, preset fast")
    impact = solve_reduced(
        material, material.single_law, speed_m_s=speed, density_kg_m3=shots.density_kg_m3, elements_per_radius=ELEMENTS
    )
    radius = zero_height_radius(impact) * 0.5 * shots.diameter_m
    areas = estimated_areas_m2(scene) * (radius / estimated_dimple_radius_m(shots, speed, material)) ** 2
    level, times, lost = min(0.01 * percent, FULL_COVERAGE), max(1.0, 0.01 * percent), energy_lost(scene)
    off = math.hypot(2.0 * RADIUS_ERROR, 0.5 * lost / (1.0 - lost))
    expected = (
        f"expected (Avrami) for dimples of {radius * 1e6:.4g} µm radius at {speed:.4g} m/s, collisions taking {lost:.1%}"
    )
    travels = any(n.feed for n in scene.nozzles)
    once = scene if travels else dataclasses.replace(scene, exposure_time_s=1.0)
    hits = expected_hits(once, areas)._replace(goes_on=True)  # the same pass, or second, again and again
    end = hits.time_to(level)
    if end is None:
        raise InputError(
            f"{scene_file}: coverage_percent: the jets leave a part of the window bare however long it lasts; allowed: a wider"
            " jet_diameter_m, or a smaller window"
        )
    full = end / (1.0 - lost)
    if travels:
        return _passes(scene, scene_file, percent, full / once.exposure_time_s, times, off, expected, text)
    found = _round(full * times)
    said = f"{percent:g} %" + (f" is {times:g} times the {full:.4g} s to 98 %" if percent >= 100.0 else "")
    text.append(f"exposure_time_s = {found:g} ± {off:.0%} from coverage_percent: {said}; {expected}")
    return {"exposure_time_s": found}


def _passes(scene, scene_file, percent, full: float, times: float, off: float, expected: str, text: list[str]) -> dict:
    """Whole passes; ``full``: their real number to 98 % (or less, where less is asked for), dwells not counted."""
    passes = max(1, math.ceil(full * times * (1.0 - 1e-9)))
    most = schema.FEED["passes"].high
    if passes > most:
        raise InputError(
            f"{scene_file}: coverage_percent: takes {passes} passes; allowed up to {most:g}: a lower feed_speed_m_s or more"
            " mass_flow_kg_s"
        )
    feeds = [dataclasses.replace(n.feed, passes=passes) for n in scene.nozzles if n.feed]
    said = f" is {times:g} times the {full:.3g} to 98 %" if percent >= 100.0 else ""
    text.append(
        f"passes = {passes}, {feeds[0].duration_s:.4g} s, from coverage_percent: {percent:g} %{said}: {full * times:.3g} ± {off:.0%},"
        f" the next whole number; {expected}"
    )
    return {"exposure_time_s": feeds[0].duration_s, "passes": passes}
