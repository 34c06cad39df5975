"""The stage ``coverage``: counted on sample points, beside what random impacts would give (Avrami)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from glue.flow.impacts import normal_speed_m_s
from glue.scene.model import Scene
from glue.study.exposure import dimple_areas_m2, expected_hits
from glue.study.results import load_dimple, load_impacts, plain, write_columns
from glue.study.stage import Work
from glue.study.target_surface import target_triangles
from glue.surface.coverage import coverage_history, dimple_semi_axes, time_to
from glue.surface.window import check_window

FULL_COVERAGE = 0.98  # the level at which the trade calls a surface fully covered
_CURVE_POINTS = 200


def coverage_stage(work: Work) -> tuple[dict, list[str]]:
    """Coverage against time by the count of sample points, beside Avrami's.

    ``avrami`` takes from the log how many impacts fell into the window and how large their dimples are, and from
    the nozzles how they are spread over place and time; ``avrami_mass_flow`` takes their number from the mass
    flow too, and ``avrami_undisturbed`` also their dimples, from the speed at the nozzle: what shots that meet no
    other and no air would do.
    """
    scene, dimple = work.scene, load_dimple(work.path)
    impacts, window = load_impacts(work.path, scene), scene.target.window_m
    major, minor, azimuth = dimple_semi_axes(dimple, impacts)
    spacing = dimple.radius_m / scene.accuracy.coverage_points_per_radius
    history = coverage_history(
        impacts["x_m"], impacts["y_m"], impacts["time_s"], major, minor, azimuth, window, spacing
    )

    inside = (abs(impacts["x_m"]) <= 0.5 * window[0]) & (abs(impacts["y_m"]) <= 0.5 * window[1])
    count, area = int(inside.sum()), math.pi * major * minor
    by_mass = expected_hits(scene, dimple_areas_m2(scene, dimple, impacts[inside], area[inside]))
    counted = by_mass.scaled_to(float(area[inside].sum()) / scene.target.window_area_m2)
    # The last shots land after the nozzle has closed, so that the curve ends with them.
    end = max(scene.exposure_time_s, float(history.time_s[-1]) if history.time_s.size else 0.0)
    time_98 = time_to(history.time_s, history.coverage, FULL_COVERAGE)
    times = np.union1d(np.linspace(0.0, end, _CURVE_POINTS + 1), [] if time_98 is None else [time_98])
    # Avrami speaks of exposure: it stops rising when the nozzle closes.
    expected = counted.coverage(np.minimum(times, scene.exposure_time_s))
    write_columns(work.path / "coverage.csv", time_s=times, coverage=history.at(times), avrami=expected)

    final = float(history.coverage[-1]) if history.coverage.size else 0.0
    metrics = {"final": final, "time_98_s": time_98}
    # the trade counts on from full coverage by time: 200 % is twice the time to 98 %
    metrics["percent"] = 100.0 * final if time_98 is None else 100.0 * max(1.0, scene.exposure_time_s / time_98)
    if time_98 is None:
        metrics["time_98_s_reason"] = (
            f"coverage reaches {final:.4f} in {scene.exposure_time_s:g} s; a longer exposure_time_s is needed"
        )
    if count:
        metrics["avrami_final"] = float(expected[-1])
        metrics["avrami_time_98_s"] = counted.time_to(FULL_COVERAGE)
        if metrics["avrami_time_98_s"] is None:
            metrics["avrami_time_98_s_reason"] = (
                f"the expected coverage ends at {expected[-1]:.4f}, with the feed or beside the jet; more passes are needed"
            )
        metrics["avrami_mass_flow_final"] = float(by_mass.coverage([scene.exposure_time_s])[0])
        undisturbed = expected_hits(scene, dimple_areas_m2(scene, dimple, impacts[:0], area[:0]))
        for key, hits in (("avrami_mass_flow_time_98_s", by_mass), ("avrami_undisturbed_time_98_s", undisturbed)):
            metrics[key] = hits.time_to(FULL_COVERAGE)
            if metrics[key] is None:
                metrics[f"{key}_reason"] = "the expected coverage ends below that, with the feed or beside the jet"
    else:
        nothing = "no impact inside the window"
        times_98 = ("avrami_time_98_s", "avrami_mass_flow_time_98_s", "avrami_undisturbed_time_98_s")
        for key in ("avrami_final", *times_98, "avrami_mass_flow_final"):
            metrics |= {key: None, f"{key}_reason": nothing}
    if count:
        speed = normal_speed_m_s(impacts)
        beyond = dimple.beyond_table(impacts["diameter_m"], speed, impacts["density_kg_m3"])[inside]
        metrics["beyond_table_share"] = float(beyond.mean())
        metrics["beyond_table_area_share"] = float(area[inside][beyond].sum() / area[inside].sum())
    metrics |= {
        "impacts_in_window": count,
        "peeq_final": None,
        "peeq_final_reason": "the target stage was not run",
    }
    return {"coverage": plain(metrics)}, ["coverage.csv"]


def refuse_window(scene: Scene, scene_file: Path) -> None:
    """Raise InputError for a window that cannot be rolled out on the target's surface."""
    check_window(scene, target_triangles(scene, scene_file))
