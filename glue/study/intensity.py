"""``peen intensity``: the saturation curve of a strip, measured or simulated, and the Almen intensity in it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.scene.model import Scene
from glue.study.dimple_stage import ready_kernels
from glue.study.measured import MeasuredCurve, read_curve
from glue.study.pipeline import find_scene
from glue.study.shot_stream import energy_lost, stream_of
from glue.study.specify import read_specified
from glue.study.strip_cells import cell_curve
from glue.surface.saturation import STATED, Saturation, fit_saturation
from glue.target.layers import CALIBRATED
from glue.target.strip import MODEL_ERROR, StripLibrary, strip_library
from glue.theory.almen import STRIPS, mils, read_intensity

# Exposures of a simulated curve over the saturation exposure: what a shop would peen, with twice and four times it.
MODELS = ("layers", "cell")
MULTIPLES = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)


def intensity(
    scene_argument: str | None, curve: Path | None, *, strip: str | None, model: str, preset: str | None, progress
) -> tuple[dict, Saturation]:
    """What ``peen intensity`` was asked for: of a measured ``curve``, or of a strip in the jet of a scene.

    ``found.problem`` says why a curve allows no intensity.  Raises InputError with all that is wrong in the arguments.
    """
    problems = []
    if scene_argument is None and curve is None:
        problems.append("intensity: nothing to read; allowed a SCENE, --curve FILE.csv, or both to compare them")
    if strip is not None and strip.upper() not in STRIPS:
        problems.append(f"--strip {strip}: unknown strip; allowed {', '.join(STRIPS)}")
    if model not in MODELS:
        problems.append(f"--target {model}: allowed {', '.join(MODELS)}")
    if problems:
        raise InputError(problems)
    letter = None if strip is None else strip.upper()
    if scene_argument is None:
        return curve_of_file(curve, letter)
    measured = None if curve is None else read_curve(curve)  # its mistakes first: they cost nothing
    scene, _ = read_specified(find_scene(scene_argument), preset=preset, progress=progress)
    ready_kernels()
    if letter is None and scene.specification is not None:  # the strip that the drawing names
        letter = next((read_intensity(text).strip.letter for text in scene.specification.intensities if text), None)
    library = strip_library(lambda share, text: progress("strip", share, text))
    result, found = scene_intensity(scene, letter or "A", library)
    if model == "cell":
        result, found = _by_cells(scene, result, library, progress)
    if measured is not None:
        result |= _beside(scene, measured, found)
    return result, found


def _beside(scene: Scene, curve: MeasuredCurve, found: Saturation) -> dict:
    """A measured curve beside a simulated one, exposures in seconds; deviations are simulated less measured, relative.

    Raises InputError for passes that no nozzle of the scene makes.
    """
    feed = next((n.feed for n in scene.nozzles if n.feed), None)
    if curve.unit == "passes" and feed is None:
        raise InputError(
            f"{curve.file}: exposure_passes, but no nozzle of the scene travels; allowed exposure_s, exposure_min"
        )
    second = {"s": 1.0, "min": 60.0, "passes": feed.duration_s / feed.passes if feed else 1.0}[curve.unit]
    own = fit_saturation(curve.exposure * second, curve.arc_height_m)
    result = {"measured": {"file": curve.file, **saturation_dict(own)}}
    if found.problem is None:
        off = found.best(own.exposure) / own.arc_height_m - 1.0
        result["measured"]["arc_height_mean_deviation"] = float(off.mean())
        result["measured"]["arc_height_rms_deviation"] = float(np.sqrt((off**2).mean()))
        if own.problem is None:
            result["measured"]["intensity_deviation"] = found.intensity_m / own.intensity_m - 1.0
            result["measured"]["saturation_exposure_deviation"] = found.best.saturation / own.best.saturation - 1.0
    return result


def title(result: dict) -> str:
    """Of the figure: what was peened, and what came out."""
    if "file" in result:
        name = Path(result["file"]).name
    else:
        name = f"{result['scene']}, strip {result['strip']}, {result['model']}"
    return f"{name}: {mils(result['intensity_m']):.2f}{result['strip'] or ' mil'}"


def curve_of_file(path: Path, strip: str | None = None) -> tuple[dict, Saturation]:
    """The intensity in a measured curve, as plain values; null with the reason where the points do not allow one.

    Raises InputError for a file that is no measurement.
    """
    curve = read_curve(path)
    found = fit_saturation(curve.exposure, curve.arc_height_m)
    result = {"file": curve.file, "strip": strip, "exposure_unit": curve.unit, **saturation_dict(found)}
    return result, found


def saturation_dict(found: Saturation) -> dict:
    """A fitted saturation curve as plain values; exposures in the unit of the points."""
    result = {
        "points": int(found.exposure.size),
        "exposure": found.exposure.tolist(),
        "arc_height_m": found.arc_height_m.tolist(),
    }
    keys = ("intensity_m", "intensity_half_width_m", "saturation_exposure", "saturation_exposure_half_width")
    if found.problem:
        reasons = {f"{key}_reason": found.problem for key in keys}
        return result | dict.fromkeys(keys) | reasons | {"warnings": []}
    best = found.best
    values = found.intensity_m, found.intensity_half_width_m, best.saturation, found.saturation_half_width
    result |= dict(zip(keys, map(float, values), strict=True))
    for key, centre, half in (("intensity_interval_m", *values[:2]), ("saturation_exposure_interval", *values[2:])):
        result[key] = [max(0.0, centre - half), centre + half]
    return result | {
        "confidence": STATED,
        "equation": best.form.text,
        "parameters": dict(zip("abc", best.parameters)),
        "residual_m": best.residual_m,
        "equations_tried": [
            {"equation": f.form.text, "residual_m": f.residual_m, "intensity_m": _plain(f.intensity_m),
             "saturation_exposure": _plain(f.saturation)}
            for f in found.fits
        ],
        "warnings": list(found.warnings),
    }  # fmt: skip


def scene_intensity(scene: Scene, letter: str, library: StripLibrary) -> tuple[dict, Saturation]:
    """The saturation curve of strip ``letter`` in place of the scene's target, by the layer model.

    Exposure per time comes from the nozzles' footprints at the middle of the window, collisions take an estimated
    share of the energy; a scene whose nozzles travel is repeated as a whole.  Raises InputError beyond what the models
    can do.
    """
    strip = STRIPS[letter]
    stream = stream_of(scene)
    hits_1_s = library.hits_1_s(stream)
    saturation_hits, exact_m = library.saturation(strip, stream)
    hits = saturation_hits * np.array(MULTIPLES)
    heights = [library.arc_height_m(strip, stream, float(h)) for h in hits]
    found = fit_saturation(hits / hits_1_s, heights)
    warnings = [*_beyond(hits), *library.layers(stream, saturation_hits, check=True).warnings]
    result = {
        "scene": scene.name,
        "strip": letter,
        "model": "layers",
        "exposure_unit": "s",
        "normal_speed_m_s": float(stream.normal_speed_m_s.mean()),
        "energy_lost_in_collisions": energy_lost(scene),
        "hits_per_point_1_s": hits_1_s,
        "saturation_hits": saturation_hits,
        "coverage_of_strip_at_saturation": -math.expm1(-saturation_hits),
        "arc_height_at_exact_saturation_m": exact_m,
        "exact_saturation_exposure_s": saturation_hits / hits_1_s,
        **saturation_dict(found),
        "model_error_relative": MODEL_ERROR,
        "material": library.material.name,
        "material_source": f"{library.material.source}; grade {library.material.grade}",
    }
    result["warnings"] = [*dict.fromkeys(warnings), *result["warnings"]]
    return result, found


def _by_cells(scene: Scene, layers: dict, library: StripLibrary, progress) -> tuple[dict, Saturation]:
    """The same curve by periodic cells, beside what the layers said."""
    strip, stream = STRIPS[layers["strip"]], stream_of(scene)
    curve = cell_curve(
        library, strip, stream, scene.accuracy, seed=scene.seed,
        progress=lambda share, text: progress("cells", share, text),
    )  # fmt: skip
    found = fit_saturation(curve.hits / library.hits_1_s(stream), curve.arc_height_m)
    kept = ("scene", "strip", "exposure_unit", "normal_speed_m_s", "hits_per_point_1_s", "material", "material_source")
    return {key: layers[key] for key in kept} | {
        "model": "cell",
        **saturation_dict(found),
        "arc_height_standard_error_m": curve.standard_error_m.tolist(),
        "layers_intensity_m": layers["intensity_m"],
        "over_layers_relative": None if found.problem else found.intensity_m / layers["intensity_m"] - 1.0,
    }, found


def _beyond(hits: np.ndarray):
    span = CALIBRATED["exposure"]
    if hits[0] < span.low or hits[-1] > span.high:
        yield (
            f"hits per point from {hits[0]:.2g} to {hits[-1]:.2g}; the layer model is calibrated"
            f" for {span.low:g} to {span.high:g}"
        )


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def intensity_text(result: dict) -> str:
    """The same for reading."""
    strip, unit = result["strip"] or "", result["exposure_unit"]
    name = result.get("file") or f"{result['scene']}: strip {strip} by {result['model']}"
    rows = [name, "", f"  {'exposure [' + unit + ']':>18} {'arc height [in]':>16} {'[mm]':>8}"]
    for t, h in zip(result["exposure"], result["arc_height_m"]):
        rows.append(f"  {t:>18.4g} {mils(h) * 1e-3:>16.5f} {h * 1e3:>8.4f}")
    rows.append("")
    if result["intensity_m"] is None:
        return "\n".join([*rows, f"  intensity not determined: {result['intensity_m_reason']}"])
    half, t_half = result["intensity_half_width_m"], result["saturation_exposure_half_width"]
    found = result["intensity_m"]
    rows += [
        _row("intensity", f"{mils(found):.2f}{strip or ' mil'}: {mils(found) * 1e-3:.5f} in ± {mils(half) * 1e-3:.5f},"
             f" {found * 1e3:.4f} mm ± {half * 1e3:.4f} ({result['confidence']:.0%} interval)"),
        _row("saturation exposure", f"{result['saturation_exposure']:.4g} {unit} ± {t_half:.2g}"),
        _row("equation", f"{result['equation']}, " + ", ".join(f"{k} {v:.4g}" for k, v in result["parameters"].items())
             + f"; residual {mils(result['residual_m']) * 1e-3:.5f} in"),
    ]  # fmt: skip
    if "layers_intensity_m" in result:
        error = max(e / h for e, h in zip(result["arc_height_standard_error_m"], result["arc_height_m"]))
        off, theirs = result["over_layers_relative"], f"{mils(result['layers_intensity_m']):.2f}{strip}"
        rows += [
            _row("against layers", f"{off:+.1%} of their {theirs}; arc heights are means over cells, standard error up"
                 f" to {error:.1%}"),
            _row("strip steel", result["material_source"]),
        ]  # fmt: skip
    if "saturation_hits" in result:
        rows += [
            _row("by the curve itself", f"{mils(result['arc_height_at_exact_saturation_m']):.2f}{strip} at"
                 f" {result['exact_saturation_exposure_s']:.4g} s, {result['saturation_hits']:.2f} hits per point"
                 f" ({result['coverage_of_strip_at_saturation']:.0%} coverage of the strip)"),
            _row("speed on arrival", f"{result['normal_speed_m_s']:.4g} m/s, normal to the strip; collisions take"
                 f" {result['energy_lost_in_collisions']:.1%} of the energy (estimate)"),
            _row("model error", f"about {result['model_error_relative']:.0%} of an arc height (layers against cells),"
                 " and what the strip steel's law is off"),
            _row("strip steel", result["material_source"]),
        ]  # fmt: skip
    if "measured" in result:
        m = result["measured"]
        if m["intensity_m"] is None:
            told = m["intensity_m_reason"]
        else:
            width = mils(m["intensity_half_width_m"])
            told = f"{mils(m['intensity_m']):.2f}{strip} ± {width:.2f} at {m['saturation_exposure']:.4g} s"
        rows.append(_row("measured", f"{m['file']}: {told}"))
        rows += [_row("simulated less it", f"{name} {m[key]:+.1%}") for key, name in (
            ("intensity_deviation", "intensity"), ("saturation_exposure_deviation", "saturation exposure"),
            ("arc_height_mean_deviation", "arc heights, mean"), ("arc_height_rms_deviation", "arc heights, rms"),
        ) if key in m]  # fmt: skip
    return "\n".join([*rows, *(_row("warning", text) for text in result["warnings"])])


def _row(what: str, text: str) -> str:
    return f"  {what:<20} {text}"
