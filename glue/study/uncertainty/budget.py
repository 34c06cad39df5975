"""The error budget of a run: for each metric a 95 % interval and how much of it comes from what.

Causes: *statistical* (other arrivals of the same stream), *numerical* (meshes, steps, rasters and models, from the
measured table at the most similar scene), *material_law* (other sets of the alloy, bounded or not) and
*restitution_friction* (through the collisions of the stream).  They are independent: half widths add by squares.
"""

from __future__ import annotations

import json
import math

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import read_impacts
from glue.scene.model import Scene
from glue.study.coverage_stage import FULL_COVERAGE
from glue.study.results import load_dimple
from glue.study.rows import CAUSES
from glue.study.stage import Work
from glue.study.tradeoff.table import nearest, packaged
from glue.study.uncertainty import statistical as chance
from glue.study.uncertainty.metrics import METRICS, Metric
from glue.study.uncertainty.mesh_errors import mesh_errors
from glue.study.uncertainty.model_causes import energy_spread, law_spread, strain_at
from glue.surface.coverage import dimple_semi_axes
from glue.surface.window import in_window_coordinates

_LOWER_E = 0.11  # see model_causes: what the default single impact leaves out moves its restitution so far
_FAR = 1.0  # from the nearest measured scene: a factor e in one number


def budget(work: Work) -> dict:
    """The section ``uncertainty`` of metrics.json.

    {"coverage.final": {value, half_width_95, by_cause, mostly}, …, "table", "stress_by_law"}; half widths in the
    metric's unit; a cause that nothing is known of is null.  "source": whose relative interval it has.
    """
    metrics = json.loads((work.path / "metrics.json").read_text(encoding="utf-8"))
    scene = work.scene
    entry, told = _measured(scene)
    by_chance = _chances(work, metrics, entry)
    e = min(metrics.get("dimple", {}).get("restitution") or 0.34, 1.0)
    by_mesh = mesh_errors(entry, scene, metrics, e, work.complete) if entry else {}
    law = law_spread(scene, _strain(work, metrics))
    energy = energy_spread(scene, e) if "flow" in metrics else 0.0
    found = {}
    for metric in METRICS:
        value = metrics.get(metric.section, {}).get(metric.key)
        if value is None:
            continue
        causes = {
            "statistical": by_chance.get(metric.name),
            "numerical": _numerical(metric, by_mesh, metrics),
            "material_law": _law(metric, value, law, metrics),
            "restitution_friction": _restitution(metric, value, energy, metrics),
        }
        if metric.name == "flow.impacts" or metric.name == "coverage.impacts_in_window":
            causes |= {"numerical": 0.0}
        known = {name: c for name, c in causes.items() if c is not None and math.isfinite(c)}
        found[metric.name] = {
            "value": value, "half_width_95": math.sqrt(sum(c**2 for c in known.values())),
            "by_cause": {name: known.get(name) for name in CAUSES},
            "mostly": max(known, key=known.get) if any(known.values()) else None,
        }  # fmt: skip
        if metric.chance_of:
            found[metric.name]["source"] = f"the relative interval of {metric.chance_of}"
    return found | {"table": told, "stress_by_law": law.stresses}


def _measured(scene: Scene) -> tuple[dict | None, dict]:
    """The most similar scene's entry of the measured table, and what to say of it."""
    try:
        table = packaged()
    except InputError as problem:
        return None, {"scene": None, "reason": str(problem)}
    name, far = nearest(scene, table)
    told = {"scene": name, "distance": far, "date": table["provenance"]["date"]}
    if far > _FAR:
        told["warning"] = f"no measured scene is like this one (nearest {name}): numerical errors are a guess"
    return table["scenes"][name], told


def _hits(metrics: dict) -> float | None:
    """Hits per point in the window that its Avrami coverage stands for."""
    expected = metrics.get("coverage", {}).get("avrami_final")
    return None if expected is None or not 0.0 < expected < 1.0 else -math.log1p(-expected)


def _chances(work: Work, metrics: dict, entry: dict | None) -> dict[str, float | None]:
    """{metric: half width by chance}."""
    found: dict[str, float | None] = {}
    scene, window = work.scene, work.scene.target.window_m
    if "dimple" in metrics:
        found |= {m.name: 0.0 for m in METRICS if m.section == "dimple"}
    if "flow" not in work.complete or "dimple" not in work.complete:
        return found
    impacts, dimple = read_impacts(work.path / "flow" / "impacts.csv")[0], load_dimple(work.path)
    for key, half in chance.flow_halves(impacts, metrics["flow"], scene.arrivals == "poisson").items():
        found[f"flow.{key}"] = half
    seen = in_window_coordinates(impacts, scene.target.surface)
    major, minor, _ = dimple_semi_axes(dimple, seen)
    inside = (abs(seen["x_m"]) <= 0.5 * window[0]) & (abs(seen["y_m"]) <= 0.5 * window[1]) & (minor > 0.0)
    if not inside.any():
        return found
    radii, count = np.sqrt(major * minor)[inside], int(inside.sum())
    hits_half = chance.hits_relative_half(radii, count)
    found |= _coverage_chances(metrics, radii, count, hits_half, window)
    if "surface" in work.complete:
        with np.load(work.path / "surface.npz") as data:
            x, y, z = data["x_m"], data["y_m"], data["z_m"]
        halves = chance.surface_halves(z, x[1] - x[0], y[1] - y[0], dimple.radius_m, metrics["roughness"])
        found |= {f"roughness.{key}": half for key, half in halves.items()}
        found |= _lines_chances(metrics["roughness"], halves)
    if "target" in work.complete:
        found |= _stress_chances(scene, metrics, entry, hits_half)
    return found


def _lines_chances(roughness: dict, halves: dict[str, float | None]) -> dict[str, float]:
    """Of Ra and Rz: relative to their values those of Sa and Sz, from the same heights."""
    found = {}
    for metric in (m for m in METRICS if m.chance_of):
        half, over, own = halves.get(metric.chance_of), roughness.get(metric.chance_of), roughness.get(metric.key)
        if half is not None and over and own is not None:
            found[metric.name] = half / over * own
    return found


def _coverage_chances(
    metrics: dict, radii: np.ndarray, count: int, hits_half: float, window: tuple[float, float]
) -> dict[str, float | None]:
    c, hits = metrics.get("coverage", {}), _hits(metrics)
    found: dict[str, float | None] = {}
    if c.get("time_98_s") is not None:
        found["coverage.time_98_s"] = chance.time_half(c["time_98_s"], FULL_COVERAGE, radii, window)
    if c.get("avrami_time_98_s") is not None:
        found["coverage.avrami_time_98_s"] = hits_half * c["avrami_time_98_s"]
    if hits is None:
        return found
    expected = c["avrami_final"]
    found["coverage.final"] = found["coverage.peeq_final"] = chance.coverage_half(expected, radii, window)
    found["coverage.avrami_final"] = hits_half * hits * (1.0 - expected)
    by_mass = c.get("avrami_mass_flow_final")
    if by_mass is not None and 0.0 < by_mass < 1.0:
        area = radii**2  # only the mean dimple area is the log's own
        relative = chance.Z95 * float(area.std()) / float(area.mean()) / math.sqrt(count)
        found["coverage.avrami_mass_flow_final"] = relative * -math.log1p(-by_mass) * (1.0 - by_mass)
    found["coverage.impacts_in_window"] = chance.Z95 * math.sqrt(count)
    return found


def _stress_chances(scene: Scene, metrics: dict, entry: dict | None, hits_half: float) -> dict[str, float | None]:
    """Of the section ``residual_stress``: the layers follow the window's hits per point, the others one patch's."""
    model, hits = metrics["target"].get("model"), _hits(metrics)
    if model == "layers":
        if hits is None:
            return {}
        # Stress rises with the covered share until full coverage levels it off.
        relative = chance.answer(hits_half, lambda x: -math.expm1(-hits * x)) / -math.expm1(-hits)
        wanted = [m for m in METRICS if m.stress]
        return {m.name: relative * abs(metrics[m.section].get(m.key) or 0.0) for m in wanted}
    if entry is None:
        return {}
    patches = metrics["target"].get("patches") or 1
    ratio = scene.accuracy.cell_side_in_radii * math.sqrt(patches) / entry["patch_side_in_radii"]
    scatter = patch_scatter(entry, 1.0 if hits is None else hits)
    found = {}
    for metric in (m for m in METRICS if m.section == "residual_stress"):
        half = chance.stress_relative_half(scatter, metric.like, ratio)
        found[metric.name] = None if half is None else half * _scale(metric, metrics)
    return found


def patch_scatter(entry: dict, hits: float) -> dict:
    """Scatter of a patch's stress at ``hits`` per point, between the measured exposures (in logarithms)."""
    at = list(entry["patch_hits"].values())
    measured = [entry["patches"][name] for name in entry["patch_hits"]]
    if not at:
        return {}
    found = {}
    for name in measured[0]:
        sds = [m[name]["sd"] for m in measured if name in m]
        if len(sds) == len(at):
            found[name] = {"sd": float(np.exp(np.interp(math.log(hits), np.log(at), np.log(np.maximum(sds, 1e-9)))))}
    return found


def _scale(metric: Metric, metrics: dict) -> float:
    """What the measured relative errors of ``metric`` are relative to (see ``quantities.py``), in its unit."""
    own = metrics[metric.section]
    if metric.section == "coverage" and metric.exposure == "coverage" or metric.key == "collided_fraction":
        return 1.0
    other = {"surface_Pa": "max_compressive_Pa", "max_compressive_depth_m": "tenth_depth_m"}.get(metric.key, metric.key)
    return abs(own.get(other) or own.get(metric.key) or 0.0)


def _numerical(metric: Metric, by_mesh: dict, metrics: dict) -> float | None:
    if metric.exposure:  # the raster's own error, and that of the hits per point
        hits, raster = by_mesh.get("t98_avrami"), by_mesh.get(f"raster {metric.like}", 0.0)
        if hits is None:
            return None
        value = metrics[metric.section][metric.key]
        return math.hypot(raster * _scale(metric, metrics), _by_exposure(metric, value, hits, metrics))
    found = by_mesh.get(metric.like)
    return None if found is None else found * metric.share * _scale(metric, metrics)


def _law(metric: Metric, value: float, law, metrics: dict) -> float:
    """Response of the metric to the laws that might be true, by the exponents of ``metrics.py``."""
    if metric.exposure:
        return _by_exposure(metric, value, 2.0 * law.radius, metrics)
    relative = abs(metric.radius) * law.radius + abs(metric.strength) * law.flow_stress
    if metric.stress:
        return (relative + law.strength) * _scale(metric, metrics)
    return relative * abs(value)


def _restitution(metric: Metric, value: float, energy: float, metrics: dict) -> float:
    """Response to the stream's energy: hits per point as its root (a^2 goes with the speed), stress as the coverage."""
    if metric.name == "dimple.restitution":
        return _LOWER_E * value
    if metric.section == "dimple":
        return 0.0
    if metric.section == "flow":
        share = {"mean_normal_energy_fraction": 1.0, "mean_normal_speed_m_s": 0.5}.get(metric.key, 0.0)
        return share * energy * abs(value)
    if metric.exposure:
        return _by_exposure(metric, value, 0.5 * energy, metrics)
    if metric.stress:
        hits = _hits(metrics)
        if hits is None:
            return 0.0
        return chance.answer(0.5 * energy, lambda x: -math.expm1(-hits * x)) * _scale(metric, metrics)
    return 0.25 * abs(metric.radius) * energy * abs(value)  # a goes as energy^(1/4)


def _by_exposure(metric: Metric, value: float, relative: float, metrics: dict) -> float:
    """Change of a coverage or of a time when hits per point change by ``relative``."""
    if metric.exposure == "time":
        return relative * value
    hits = _hits(metrics)
    return 0.0 if hits is None else chance.answer(relative, lambda x: -math.expm1(-hits * x))


def _strain(work: Work, metrics: dict) -> float | None:
    """Mean plastic strain where the compression is largest, None without a profile."""
    at, path = metrics.get("residual_stress", {}).get("max_compressive_depth_m"), work.path / "stress_profile.csv"
    if "target" not in work.complete or at is None or not path.exists():
        return None
    table = np.genfromtxt(path, delimiter=",", names=True)
    return strain_at(np.atleast_1d(table["depth_m"]), np.atleast_1d(table["peeq"]), at)
