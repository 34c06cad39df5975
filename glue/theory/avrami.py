"""Coverage by circular dimples that fall at random (a Poisson process): mean, time to a level, scatter.

Coverage is the share (0-1) of a plane that at least one dimple covers.  For Poisson impacts a point stays
bare with probability exp(-lambda), lambda = impacts per area times the *mean of r^2* times pi (exact for
any mixture of sizes; the square of the mean radius would be wrong).  These are the paper's equations (2.1),
in the impact rate, and (2.2), in the mass flow; both are the Avrami equation of exponent 1.

Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math

import numpy as np

from glue.errors import InputError


def coverage_rate_form(radius2_mean_m2: float, rate_1_m2_s: float, time_s):
    """Expected coverage (2.1): 1 - exp(-pi <r^2> R t).

    radius2_mean_m2: mean of the squared dimple radius [m^2]; for ellipses the mean product of the semi-axes;
    rate_1_m2_s: impacts per area and time; time_s: float or array, the result has its shape.
    """
    return -np.expm1(-math.pi * radius2_mean_m2 * rate_1_m2_s * np.asarray(time_s, dtype=float))


def mass_flow_form(
    radius2_mean_m2: float,
    mass_flow_kg_s: float,
    area_m2: float,
    shot_radius3_mean_m3: float,
    density_kg_m3: float,
    time_s,
):
    """Expected coverage (2.2): 1 - exp(-3 mdot <r^2> t / (4 S <R^3> rho)), the flow spread over an area S.

    shot_radius3_mean_m3: mean of the cubed *shot* radius, for it is the mean shot mass that turns kilograms
    into impacts.  time_s: float or array, the result has its shape.
    """
    rate = mass_flow_kg_s / (area_m2 * density_kg_m3 * 4.0 / 3.0 * math.pi * shot_radius3_mean_m3)
    return coverage_rate_form(radius2_mean_m2, rate, time_s)


def time_to_coverage(coverage: float, radius2_mean_m2: float, rate_1_m2_s: float) -> float:
    """Time [s] at which the *expected* coverage reaches ``coverage`` (0 <= coverage < 1, else InputError)."""
    if not 0.0 <= coverage < 1.0:
        raise InputError(f"coverage = {coverage}: must lie in [0, 1); random impacts never reach 1")
    return -math.log1p(-coverage) / (math.pi * radius2_mean_m2 * rate_1_m2_s)


def disc_overlap_m2(radius_m, distance_m):
    """Area [m^2] common to two discs of one radius with centres ``distance_m`` apart (arrays broadcast)."""
    r, d = np.broadcast_arrays(np.asarray(radius_m, dtype=float), np.asarray(distance_m, dtype=float))
    half = np.minimum(0.5 * d / r, 1.0)
    return 2.0 * r**2 * (np.arccos(half) - half * np.sqrt(1.0 - half**2))


def coverage_sd(coverage: float, radius_m, window_m: tuple[float, float], *, points: int = 200) -> float:
    """Standard deviation of the coverage found in one rectangular window, exact for Poisson impacts.

    Arguments and errors of :func:`coverage_covariance`.
    """
    return math.sqrt(coverage_covariance([coverage], radius_m, window_m, points=points)[0, 0])


def coverage_covariance(coverage, radius_m, window_m: tuple[float, float], *, points: int = 200) -> np.ndarray:
    """Covariance (k, k) of the coverages found in one rectangular window when (k,) ``coverage`` are expected.

    They belong to k times of one growing process: the impacts of the earlier time are among those of the later.  Of two
    points at distance d, one bare at an exposure lambda_1 and one at lambda_2 >= lambda_1, both are so with probability
    exp(-lambda_2 - lambda_1 (1 - L(d)/<pi r^2>)), L the mean overlap of two discs at that distance (Robbins 1944, at one
    time).  So the bare shares have the covariance 1/A^2 * integral over both points of
    (1-C_1)(1-C_2)(exp(lambda_1 L(d)/<pi r^2>) - 1).  Only d < 2 r contributes, and over a rectangle the angle integrates
    in closed form.

    radius_m: one radius or a sample of equally likely radii [m]; window_m: (width, height), each at least
    twice the largest radius (InputError otherwise); points: Gauss points in distance.
    """
    radii = np.unique(np.atleast_1d(np.asarray(radius_m, dtype=float)), return_counts=True)
    radius, weight = radii[0], radii[1] / radii[1].sum()
    width, height = window_m
    expected = np.asarray(coverage, dtype=float)
    if not ((expected >= 0.0) & (expected < 1.0)).all():
        raise InputError(f"coverage = {coverage}: must lie in [0, 1)")
    if 2.0 * radius[-1] > min(width, height):
        raise InputError(
            f"window_m = {window_m}: each side must be at least twice the largest radius, {radius[-1]} m"
        )
    per_area = -np.log1p(-expected) / (math.pi * float(weight @ radius**2))  # impacts
    node, gauss = np.polynomial.legendre.leggauss(points)
    d = radius[-1] * (node + 1.0)  # 0 .. 2 r_max
    overlap = weight @ disc_overlap_m2(radius[:, None], d[None, :])
    shared = np.expm1(np.minimum.outer(per_area, per_area)[..., None] * overlap)
    pairs = d * (0.5 * math.pi * width * height - (width + height) * d + 0.5 * d**2)
    bare = np.multiply.outer(1.0 - expected, 1.0 - expected)
    return 4.0 / (width * height) ** 2 * radius[-1] * bare * (shared @ (gauss * pairs))
