"""What one reads off a residual-stress profile: surface value, largest compression, sign change, balance."""

from __future__ import annotations

import math

import numpy as np

from glue.errors import InputError

FADING = 0.01  # tension below this share of the largest compression is no sign change


def profile_metrics(depth_m, sigma_Pa) -> dict:
    """Metrics of a residual-stress profile ``sigma_Pa`` (n,), tension positive, at rising ``depth_m`` (n,).

    surface_Pa: the value at depth 0, else extrapolated on the line through the first two points.
    max_compressive_Pa (negative), max_compressive_depth_m: vertex of the parabola through the lowest point
    and its two neighbours (any spacing); the lowest point itself at an end of the profile.  An extrapolated
    surface that is lower still counts as a point of the profile, for the following depths too.
    compressive_depth_m: where the stress, below its minimum, first turns to tension, by linear interpolation; not
    where it only fades, never rising above FADING of the largest compression.
    tenth_depth_m: where it has first fallen to a tenth of the largest compression.
    force_balance_N_m: integral of sigma dz over the profile (trapezoid), force_balance_relative: over that of
    |sigma|.  A free plate has 0; a profile cut off inside the plate, or of a constrained cell, has not.

    What the profile does not show is None with a sibling ``<key>_reason``.  Raises InputError.
    """
    z, sigma = np.asarray(depth_m, dtype=float), np.asarray(sigma_Pa, dtype=float)
    _check(z, sigma)
    surface = _surface(z, sigma)
    result = {"surface_Pa": surface}
    force = _trapezoid(sigma, z)
    # |sigma| of a polygon, exactly: the trapezoid rule with the crossings put in
    z_all, sigma_all = _with_crossings(z, sigma)
    gross = _trapezoid(np.abs(sigma_all), z_all)
    lowest = int(np.argmin(sigma))
    if z[0] > 0.0 and surface < _vertex(z, sigma, lowest)[1]:
        z, sigma, lowest = np.r_[0.0, z], np.r_[surface, sigma], 0
    if sigma[lowest] >= 0.0:
        reason = "no compressive stress anywhere in the profile"
        for key in ("max_compressive_Pa", "max_compressive_depth_m", "compressive_depth_m", "tenth_depth_m"):
            result |= {key: None, f"{key}_reason": reason}
    else:
        depth, stress = _vertex(z, sigma, lowest)
        result |= {"max_compressive_Pa": stress, "max_compressive_depth_m": depth}
        result |= _sign_change(z, sigma, lowest)
        result |= _crossing("tenth_depth_m", z, sigma, lowest, 0.1 * sigma[lowest])
    result |= {"force_balance_N_m": force, "force_balance_relative": force / gross if gross > 0.0 else 0.0}
    return result


def xray_weighted_Pa(depth_m, sigma_Pa, attenuation_m: float) -> float:
    """What X-rays see at the surface: int sigma e^(-z/t) dz / int e^(-z/t) dz over the profile, t = ``attenuation_m``.

    The profile is the broken line through its points, carried on to the surface and beyond its end as its last value;
    the integral of that is exact.
    """
    z, s = np.asarray(depth_m, dtype=float), np.asarray(sigma_Pa, dtype=float)
    _check(z, s)
    if not (math.isfinite(attenuation_m) and attenuation_m > 0.0):
        raise InputError(f"xray_depth_m = {attenuation_m}: must be positive and finite")
    if z[0] > 0.0:
        z, s = np.r_[0.0, z], np.r_[_surface(z, s), s]
    # By parts: int_0^inf s' e^(-z/t) dz + s(0), s' constant between points.
    slope = np.diff(s) / np.diff(z)
    return float(s[0] + attenuation_m * (slope * -np.diff(np.exp(-z / attenuation_m))).sum())


def deviation(depth_m, sigma_Pa, measured_depth_m, measured_Pa) -> dict:
    """Computed stress less measured, at the measured depths inside the profile: mean, rms and largest (signed), and how many.

    points 0 (and None with reasons) when none of them lies inside.
    """
    z, at = np.asarray(depth_m, dtype=float), np.asarray(measured_depth_m, dtype=float)
    inside = at <= z[-1]
    keys = ("mean_Pa", "rms_Pa", "largest_Pa")
    if not inside.any():
        reason = f"every measured depth lies below the computed profile's end, {z[-1]:g} m"
        return {"points": 0} | {key: None for key in keys} | {f"{key}_reason": reason for key in keys}
    off = np.interp(at[inside], z, np.asarray(sigma_Pa, dtype=float)) - np.asarray(measured_Pa, dtype=float)[inside]
    largest = off[np.argmax(np.abs(off))]
    return {"points": int(inside.sum())} | dict(zip(keys, map(float, (off.mean(), np.sqrt((off**2).mean()), largest))))


def plate_balance(depth_m, sigma_Pa) -> tuple[float, float]:
    """Force and moment of a stress profile over a plate's whole thickness h: integrals of sigma dz and sigma z dz.

    Of the polygon through the points (depth_m (n,), from 0 to h), over max|sigma| h and max|sigma| h^2; 0 of a free plate.
    """
    z, sigma = np.asarray(depth_m, dtype=float), np.asarray(sigma_Pa, dtype=float)
    _check(z, sigma)
    h, most = z[-1] - z[0], np.abs(sigma).max()
    if most == 0.0:
        return 0.0, 0.0
    step, a, b = np.diff(z), sigma[:-1], sigma[1:]
    moment = np.sum(step / 6.0 * (a * (2 * z[:-1] + z[1:]) + b * (z[:-1] + 2 * z[1:])))  # exact for linear pieces
    return float(_trapezoid(sigma, z) / (most * h)), float(moment / (most * h * h))


def _check(z, sigma):
    problems = []
    if z.ndim != 1 or z.shape != sigma.shape or z.size < 2:
        problems.append(
            f"stress profile: shapes {z.shape} and {sigma.shape}: two equal columns of at least 2 rows"
        )
    elif not (np.isfinite(z).all() and np.isfinite(sigma).all()):
        problems.append("stress profile: holds values that are not finite")
    elif z[0] < 0.0 or (np.diff(z) <= 0.0).any():
        problems.append("stress profile: depths must start at 0 or below the surface and rise")
    if problems:
        raise InputError(problems)


def _surface(z, sigma) -> float:
    return float(sigma[0] - z[0] * (sigma[1] - sigma[0]) / (z[1] - z[0]))


def _vertex(z, sigma, i) -> tuple[float, float]:
    """(depth, stress) of the parabola's vertex around the lowest point ``i``."""
    if i in (0, z.size - 1):
        return float(z[i]), float(sigma[i])
    left, right = z[i - 1] - z[i], z[i + 1] - z[i]
    slope_left, slope_right = (sigma[i - 1] - sigma[i]) / left, (sigma[i + 1] - sigma[i]) / right
    curvature = (slope_right - slope_left) / (right - left)
    if curvature <= 0.0:  # three equal stresses
        return float(z[i]), float(sigma[i])
    slope = slope_left - curvature * left
    return float(z[i] - slope / (2.0 * curvature)), float(sigma[i] - slope**2 / (4.0 * curvature))


def _sign_change(z, sigma, lowest) -> dict:
    limit = FADING * abs(sigma[lowest])
    if sigma[lowest:].max() <= limit and abs(sigma[-1]) <= limit:
        reason = "the stress fades to zero with depth and never turns to tension: a part too thick to stretch or bend"
        return {"compressive_depth_m": None, "compressive_depth_m_reason": reason}
    return _crossing("compressive_depth_m", z, sigma, lowest, 0.0)


def _crossing(key: str, z, sigma, lowest: int, level: float) -> dict:
    """Depth below the minimum at which the stress first rises to ``level``."""
    above = np.flatnonzero(sigma[lowest:] >= level)
    if above.size == 0:
        reason = f"still compressive ({sigma[-1] / 1e6:.0f} MPa) at the profile's end, {z[-1] * 1e3:.3f} mm"
        return {key: None, f"{key}_reason": reason}
    k = lowest + int(above[0])
    share = (sigma[k - 1] - level) / (sigma[k - 1] - sigma[k])
    return {key: float(z[k - 1] + share * (z[k] - z[k - 1]))}


def _with_crossings(z, sigma):
    k = np.flatnonzero(sigma[:-1] * sigma[1:] < 0.0)
    crossing = z[k] + sigma[k] / (sigma[k] - sigma[k + 1]) * (z[k + 1] - z[k])
    return np.insert(z, k + 1, crossing), np.insert(sigma, k + 1, 0.0)


def _trapezoid(values, z) -> float:
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(z)))
