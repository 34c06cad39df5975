"""From the files of a run directory to its figures: reads, calls the figure functions, writes captions."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.report import figures, section
from glue.report.jets import jets_of
from glue.report.slider import impact_slider, in_part
from glue.scene.measured import beside
from glue.scene.model import Scene
from glue.study.measured import read_profile
from glue.study.results import load_impacts
from glue.surface.coverage import dimple_semi_axes
from glue.target.dimple import Dimple
from glue.theory import avrami


class Figure(NamedTuple):
    """A drawn figure: its file and what it shows, for the page."""

    path: Path
    title: str
    caption: str


def draw_figures(run: Path, scene: Scene, complete: frozenset[str], metrics: dict) -> list[Figure]:
    """Every figure whose data the stages in ``complete`` have left, into ``run/figures``, in reading order.

    metrics: content of metrics.json.  Raises InputError for a damaged file.
    """
    drawn, out = [], run / "figures"
    dimple = Dimple.load(run / "dimple" / "dimple.npz") if "dimple" in complete else None
    if dimple is not None and "flow" in complete:
        drawn.append(_impacts(out / "impact_map.png", run, scene, dimple))
    if dimple is not None and "coverage" in complete:
        drawn.append(_coverage(out / "coverage.png", run, scene, dimple, metrics.get("coverage", {})))
    if "target" in complete:
        drawn.append(_stress(out / "residual_stress.png", run, scene, metrics.get("residual_stress")))
    if "surface" in complete:
        drawn.append(_height(out / "height_map.png", run, metrics.get("roughness")))
    if dimple is not None:
        drawn.append(_section(out / "dimple.png", dimple))
    return drawn


def draw_slider(run: Path, scene: Scene, complete: frozenset[str]) -> str:
    """HTML of the impact map with a time slider, "" before there are impacts.  Raises InputError for a damaged file."""
    if not {"dimple", "flow"} <= complete:
        return ""
    impacts, window = load_impacts(run, scene), scene.target.window_m
    axes = dimple_semi_axes(Dimple.load(run / "dimple" / "dimple.npz"), impacts)
    dimples = in_part(impacts["x_m"], impacts["y_m"], *axes, impacts["time_s"], window)
    curve = None
    if "coverage" in complete:
        table = _columns(run / "coverage.csv")
        curve = table["time_s"], table["coverage"]
    return impact_slider(dimples, window, max([scene.exposure_time_s, *dimples.time_s[-1:]]), curve)


def _impacts(path, run, scene, dimple) -> Figure:
    impacts = load_impacts(run, scene)
    figures.impact_map(
        path, impacts["x_m"], impacts["y_m"], *dimple_semi_axes(dimple, impacts), impacts["time_s"],
        scene.target.window_m, jets_of(scene),
    )  # fmt: skip
    text = "Every logged impact with its dimple to scale, and the window."
    if any(nozzle.feed for nozzle in scene.nozzles):
        text += " Thin line: the way of the jet's axis over the target, from the dot to the arrow."
    if scene.target.surface.kind == "cylinder":
        text += " The cylinder is rolled out; dashed is the jet as it would strike a plane."
    return Figure(path, "Impacts", text)


def _coverage(path, run, scene, dimple, metrics) -> Figure:
    table = _columns(run / "coverage.csv")
    # scatter of one window's coverage: exact for the impacts' own mixture of sizes where they fall evenly
    window, sizes = scene.target.window_m, dimple_semi_axes(dimple, load_impacts(run, scene))[1]
    radius = np.quantile(sizes, (np.arange(16) + 0.5) / 16) if sizes.size else dimple.radius_m
    wide_enough = 2 * np.max(radius) <= min(window)
    levels = np.minimum(table["avrami"], 1 - 1e-12)
    figures.coverage_plot(
        path, table["time_s"], table["coverage"], table["avrami"],
        avrami_sd=[avrami.coverage_sd(c, radius, window) for c in levels] if wide_enough else None,
        time_98_s=metrics.get("time_98_s"), avrami_time_98_s=metrics.get("avrami_time_98_s"),
    )  # fmt: skip
    text = "Share of the window's sample points that an impact has covered, beside Avrami's expectation."
    return Figure(path, "Coverage against exposure time", text)


def _stress(path, run, scene, metrics) -> Figure:
    table = _columns(run / "stress_profile.csv")
    spread = {key: table[key] for key in ("sigma_xx_std_Pa", "sigma_yy_std_Pa") if key in table}
    figures.stress_plot(
        path,
        table["depth_m"],
        table["sigma_xx_Pa"],
        table["sigma_yy_Pa"],
        peeq=table["peeq"],
        marks=metrics,
        measured=_measured(run, scene),
        **spread,
    )
    text = "Means over layers; the marked points belong to the mean of σxx and σyy. Tension is positive."
    if metrics and metrics.get("over_measured_rms_Pa") is not None:
        rms, mean = (1e-6 * metrics[f"over_measured_{key}_Pa"] for key in ("rms", "mean"))
        text += f" Squares: measured; computed less measured is {mean:+.0f} MPa on average, {rms:.0f} MPa rms."
    return Figure(path, "Residual stress against depth", text)


def _measured(run, scene):
    """(depth, stress, sd) from the measured profile that the scene names, None without one."""
    if scene.measured is None or not scene.measured.stress_file:
        return None
    path = beside(run / "scene.toml", scene.measured.stress_file)
    return None if path is None else tuple(read_profile(path)[:3])


def _height(path, run, metrics) -> Figure:
    with np.load(run / "surface.npz") as data:
        figures.height_map_plot(path, data["x_m"], data["y_m"], data["z_m"], roughness=metrics)
    text = "The window after the last impact, by the energy stamp; roughness after levelling."
    return Figure(path, "Surface", text)


def _section(path, dimple) -> Figure:
    section.dimple_section(
        path, dimple.points_m, dimple.triangles, dimple.peeq, radius_m=dimple.radius_m,
        shot_diameter_m=dimple.diameter_m, profile_r_m=dimple.profile_r_m, profile_z_m=dimple.profile_z_m,
    )  # fmt: skip
    text = f"A single normal impact at {dimple.speed_m_s:.0f} m/s after rebound, plastic strain, outline of the shot."
    if dimple.section_speed_m_s:
        text += f" The strain is that of the impact solved at {dimple.section_speed_m_s:.3g} m/s, stretched to this dimple."
    return Figure(path, "One dimple", text)


def _columns(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file with a header line, each (n,)."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: np.atleast_1d(table[name]) for name in table.dtype.names}
