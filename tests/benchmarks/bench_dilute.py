"""The dilute limit: the product's own arrivals, flights and raster against Avrami; PASS or FAIL rows (make bench-dilute).

    python tests/benchmarks/bench_dilute.py [--json FILE]

Shots of one size, Poisson in count, from an even jet wider than window and dimple, flying alone (ballistic), leave equal
dimples: C(t) = 1 - exp(-n(t) pi r^2) exactly.  SEEDS and times were fixed before any run.

Mean of the seeds: its errors at ten times are nearly normal (a mean of a thousand) with the exact covariance of a Poisson
coverage process (``glue.theory.avrami.coverage_covariance``) over the number of seeds.  The simultaneous 1 % band is
+- z standard deviations with P(all ten within) = .99 for that covariance: z is between 2.58 (one time) and 3.29
(Bonferroni).  The same errors must also be less than .01 of coverage, and the band itself narrower, or it would show nothing.
Scatter of the seeds: their standard deviation over the exact one; of a thousand normal values it is itself known to 2.2 %,
so the limit of 10 % is 4.5 of its standard deviations.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scipy.optimize import brentq
from scipy.stats import multivariate_normal

from glue.checkrows import Rows
from glue.flow.arrivals import draw_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import from_scene
from glue.scene.derive import changed
from glue.scene.model import Scene
from glue.scene.reader import example_path, read_scene
from glue.surface.coverage import POINTS_PER_RADIUS, coverage_curve
from glue.theory.avrami import coverage_covariance, coverage_rate_form

SEEDS = range(1, 1001)
RADIUS_m, WINDOW_m, JET_m = 0.15e-3, (3e-3, 3e-3), 6e-3  # half the window's diagonal and a dimple: 2.27 mm
EXPOSURES = np.linspace(0.1, 1.0, 10) * -math.log(0.02)  # hits per point, up to 98 %
LEVEL, BAND, SCATTER, RASTER = 0.01, 0.01, 0.10, 0.1
FLOW_kg_s = 1e-5  # one shot in a cubic decimetre of jet: none finds another where it leaves


def dilute_scene() -> tuple[Scene, np.ndarray]:
    """The scene and the ten times [s] of EXPOSURES."""
    changes = {"nozzle.jet_diameter_m": JET_m, "nozzle.mass_flow_kg_s": FLOW_kg_s, "target.window_m": list(WINDOW_m)}
    file = example_path("al2024-s390")
    scene = read_scene(file, content=changed(file.read_bytes(), changes), preset="fast")
    per_area = scene.shot_rate_1_s / scene.nozzle.footprint_area_m2
    times = EXPOSURES / (math.pi * RADIUS_m**2 * per_area)
    flight = scene.nozzle.stand_off_m / scene.nozzle.speed_m_s
    # a shot lands a flight after it left: times are counted from the first landing on
    return dataclasses.replace(scene, exposure_time_s=float(times[-1])), times + flight


def counted(scene: Scene, times_s: np.ndarray, points_per_radius: float = POINTS_PER_RADIUS) -> np.ndarray:
    """Coverage (0-1) of one seed at ``times_s``."""
    impacts, _ = run_ballistic(scene, draw_arrivals(scene), RestitutionLaw(0.34), from_scene(scene))
    r, spacing = np.full(len(impacts), RADIUS_m), RADIUS_m / points_per_radius
    return coverage_curve(impacts["x_m"], impacts["y_m"], impacts["time_s"], r, r, np.zeros(len(r)), WINDOW_m, spacing, times_s)


def simultaneous(covariance: np.ndarray, level: float) -> float:
    """z such that normal variables of this covariance all lie within z of their standard deviations with 1 - ``level``."""
    sd = np.sqrt(np.diag(covariance))
    correlation = covariance / np.multiply.outer(sd, sd)

    def excess(z: float) -> float:
        inside = multivariate_normal.cdf(
            np.full(len(sd), z), cov=correlation, lower_limit=np.full(len(sd), -z), rng=np.random.default_rng(1)
        )
        return float(inside) - (1.0 - level)

    return float(brentq(excess, 2.0, 4.0, xtol=1e-4))


def main() -> None:
    sides = " x ".join(f"{1e3 * side:g}" for side in WINDOW_m)
    rows = Rows(f"dilute limit: {len(SEEDS)} seeds of a window of {sides} mm, dimple radius {1e3 * RADIUS_m:g} mm")
    scene, times = dilute_scene()
    expected = coverage_rate_form(RADIUS_m**2, 1.0, EXPOSURES / (math.pi * RADIUS_m**2))
    found = np.array([counted(dataclasses.replace(scene, seed=seed), times) for seed in SEEDS])
    covariance = coverage_covariance(expected, RADIUS_m, WINDOW_m)
    sd = np.sqrt(np.diag(covariance))
    z, error = simultaneous(covariance, LEVEL), found.mean(axis=0) - expected
    of_mean = sd / math.sqrt(len(SEEDS))
    rows.within(f"z of the simultaneous {LEVEL:.0%} band, ten correlated times", z, 2.93, 0.36, "2.58 one time, 3.29 Bonferroni")
    for k, C in enumerate(expected):
        note = f"off {error[k]:+.5f}, band {z * of_mean[k]:.5f}"
        rows.below(f"C = {C:.4f}: mean off Avrami [its sd]", abs(error[k]) / of_mean[k], z, note)
    rows.below("largest of the ten, as coverage", float(abs(error).max()), BAND)
    rows.below("widest half of the band, as coverage", float((z * of_mean).max()), BAND)
    for k, C in enumerate(expected):
        rows.near(f"C = {C:.4f}: scatter over the exact Poisson scatter", found[:, k].std(ddof=1) / sd[k], 1.0, SCATTER)
    seeds = SEEDS[:10]
    fine = np.array([counted(dataclasses.replace(scene, seed=seed), times, 5 * POINTS_PER_RADIUS) for seed in seeds])
    # of one seed against the scatter of one: errors of rasters of different seeds are as independent as the seeds
    off = abs(found[: len(seeds)] - fine).max(axis=0) / sd
    rows.below("raster: largest error of ten seeds over the scatter", float(off.max()), RASTER)
    rows.finish()


if __name__ == "__main__":
    main()
