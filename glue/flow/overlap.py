"""How often shots meet to first order: the overlap of the incoming jets with the cloud of their own rebounds.

A *cloud* is the steady stream of shots that leaves one nozzle (incoming) or rebounds from the plane z = 0
below it (outgoing), undisturbed by collisions.  At height z its shots fill an ellipse, an affine image of the
unit disc u in which the jet's profile is given: x(u, z) = centre(z) + matrix(z) u.  Two clouds A, B meet at

    collisions per second = sigma |v_A - v_B| integral n_A n_B dV,   n(x, z) = rate profile(u) / (|v_z| det matrix)

with sigma = pi/4 E[(d_1 + d_2)^2] the cross-section (kinetic theory of dilute hard spheres).  For one parallel
jet of width W at normal incidence this is the closed form 6 m H (1 + e) / (rho d A v e) per shot; at an oblique
angle both ellipses are equal and shifted against each other along the lean by z (cot a_in + cot a_out); a
diverging jet's rebounds spread on, faster per height by 1/e than they came.

Linear in u: exact for parallel jets, to first order in the half-angle for diverging ones.
Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.flow.tangential import impulse_across
from glue.scene import sizes
from glue.scene.model import Nozzle, Pulse, Scene

NEARLY_NORMAL_DEG = 89.9  # stands for all steeper angles where a tangential speed is divided by
_HEIGHTS = 64  # midpoints over the heights at which two clouds overlap
_SUNFLOWER = 256  # points of equal share of the unit disc
_GAUSSIAN_RATE = 2.0  # profile exp(-2 u^2): standard deviation a quarter of the width, cut at the edge


class Cloud(NamedTuple):
    """Shots in steady undisturbed flight; an affine map of the unit disc at every height (see the module)."""

    nozzle: Nozzle
    rate_1_s: float  # shots per second
    velocity_m_s: np.ndarray  # (3,), on the axis
    origin_m: np.ndarray  # (2,): centre at z = 0
    slope: np.ndarray  # (2,): d centre / dz
    axes: np.ndarray  # (2, 2): columns are unit vectors along the lean and across
    semi_m: np.ndarray  # (2,): semi-axes along them at z = 0
    spread: np.ndarray  # (2,): d semi-axes / dz
    age_s: float  # flight time from the exit to z = 0
    ageing_s_m: float  # d (flight time) / dz

    def centre_m(self, z):
        """Shape (n, 2) at heights ``z`` (n,)."""
        return self.origin_m + z[:, None] * self.slope

    def semi_axes_m(self, z):
        """Shape (n, 2)."""
        return self.semi_m + z[:, None] * self.spread


def incoming(nozzle: Nozzle, rate_1_s: float) -> Cloud:
    """The jet of ``nozzle`` on its way to the target."""
    a = math.radians(nozzle.impact_angle_deg)
    sine, cosine = math.sin(a), (math.cos(a) if nozzle.impact_angle_deg != 90.0 else 0.0)
    lean, across = _axes(nozzle)
    tangent = math.tan(math.radians(nozzle.divergence_half_angle_deg))
    radius = 0.5 * nozzle.jet_diameter_m + nozzle.stand_off_m * tangent
    v = nozzle.speed_m_s
    return Cloud(
        nozzle,
        rate_1_s,
        v * np.array([*(cosine * lean), -sine]),
        np.array(nozzle.aim_m),
        -cosine / sine * lean,
        np.column_stack([lean, across]),
        np.array([radius / sine, radius]),
        -tangent * np.array([1.0 / sine**2, 1.0 / sine]),
        nozzle.stand_off_m / v,
        -1.0 / (v * sine),
    )


def outgoing(nozzle: Nozzle, rate_1_s: float, restitution: float, kept: float) -> Cloud:
    """The rebounds of ``nozzle``'s jet: normal speed times ``restitution``, tangential speed times ``kept``."""
    jet = incoming(nozzle, rate_1_s)
    factor = np.array([kept, kept, -restitution])
    velocity = jet.velocity_m_s * factor
    return jet._replace(
        velocity_m_s=velocity,
        slope=-kept / restitution * jet.slope,
        spread=-kept / restitution * jet.spread,
        ageing_s_m=1.0 / velocity[2],
    )


def kept_tangential_speed(nozzle: Nozzle, restitution: float, friction: float) -> float:
    """Share of the tangential speed that a shot without spin keeps on the target (``tangential.py``).

    At normal incidence that of a shot just off it: what a diverging jet's rebounds have.
    """
    a = math.radians(min(nozzle.impact_angle_deg, NEARLY_NORMAL_DEG))
    normal, tangential = math.sin(a), math.cos(a)
    return 1.0 - impulse_across(normal, tangential, restitution, friction) / tangential


def meetings_1_s(
    a: Cloud, b: Cloud, cross_section_m2: float, relative_speed_m_s: float | None = None
) -> float:
    """Expected collisions per second between the shots of two clouds; their own velocities unless told otherwise.

    Two shots touch on average 2/3 d before their centres would pass each other, when a rebound must already
    have left the target: so much of the height above it does not count, a few d / W of all at oblique angles.
    """
    if relative_speed_m_s is None:
        relative_speed_m_s = float(np.linalg.norm(a.velocity_m_s - b.velocity_m_s))
    if relative_speed_m_s == 0.0:
        return 0.0
    early_s = 2.0 / 3.0 * math.sqrt(cross_section_m2 / math.pi) / relative_speed_m_s
    rising_m_s = max(a.velocity_m_s[2], b.velocity_m_s[2], 0.0)
    z, dz = _common_heights(a, b, rising_m_s * early_s)
    if dz == 0.0:
        return 0.0
    u, share = _disc(a.nozzle.profile)
    semi_a, semi_b = a.semi_axes_m(z), b.semi_axes_m(z)
    # where the shots of a are, (heights, points, 2), and where in b's unit disc that is
    at = a.centre_m(z)[:, None] + np.einsum("ij,zj,kj->zki", a.axes, semi_a, u)
    in_b = np.einsum("ij,zki->zkj", b.axes, at - b.centre_m(z)[:, None]) / semi_b[:, None]
    density = _profile(in_b, b.nozzle.profile) * _inside(a, z, u) * _inside(b, z, in_b)
    per_height = (density * share).sum(axis=1) / (semi_b.prod(axis=1) * abs(b.velocity_m_s[2]))
    pulsed = _together(a, b, z)
    overlap = a.rate_1_s / abs(a.velocity_m_s[2]) * b.rate_1_s * float((per_height * pulsed).sum()) * dz
    return cross_section_m2 * relative_speed_m_s * overlap


def cross_section_m2(scene: Scene) -> float:
    """pi/4 E[(d_1 + d_2)^2] over pairs of shots of the mixture, by number."""
    mean = square = 0.0
    for shots in scene.media:
        share = shots.mass_fraction / shots.mean_mass_kg / scene.shots_per_kg
        mean += share * sizes.mean_m(shots)
        drawn = [sizes.quantile_m(shots, (i + 0.5) / 64.0) for i in range(64)]
        square += share * sum(d * d for d in drawn) / len(drawn)
    return math.pi / 4.0 * 2.0 * (square + mean**2)


def _axes(nozzle: Nozzle) -> tuple[np.ndarray, np.ndarray]:
    p = math.radians(nozzle.azimuth_deg)
    return np.array([math.cos(p), math.sin(p)]), np.array([-math.sin(p), math.cos(p)])


def _common_heights(a: Cloud, b: Cloud, lowest_m: float) -> tuple[np.ndarray, float]:
    """Midpoints (n,) of the heights from ``lowest_m`` up at which the clouds can overlap, their spacing (0: none)."""
    top = min(_top_m(a), _top_m(b))
    edges = np.linspace(min(lowest_m, top), top, 1025)
    apart = np.linalg.norm(a.centre_m(edges) - b.centre_m(edges), axis=1)
    near = np.flatnonzero(apart < a.semi_axes_m(edges).max(axis=1) + b.semi_axes_m(edges).max(axis=1))
    if not len(near):
        return edges[:1], 0.0
    low, high = edges[max(near[0] - 1, 0)], edges[min(near[-1] + 1, 1024)]
    dz = (high - low) / _HEIGHTS
    return low + dz * (np.arange(_HEIGHTS) + 0.5), dz


def _top_m(cloud: Cloud) -> float:
    """Height of the exit disc's highest point: shots exist below it only."""
    n = cloud.nozzle
    a = math.radians(n.impact_angle_deg)
    return n.stand_off_m * math.sin(a) + 0.5 * n.jet_diameter_m * max(math.cos(a), 0.0)


def _inside(cloud: Cloud, z: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Whether points ``u`` at heights ``z`` are below the exit plane, where the shots are; shape (heights, points).

    A point of the exit disc lies p R cos a above its centre; an incoming shot keeps its p.
    """
    n = cloud.nozzle
    if (
        cloud.velocity_m_s[2] > 0.0
    ):  # a rebound: dropped when it passes the exit plane, high above where it meets
        return np.ones(1)
    a = math.radians(n.impact_angle_deg)
    exit_m = n.stand_off_m * math.sin(a) + 0.5 * n.jet_diameter_m * math.cos(a) * u[..., 0]
    return (z[:, None] <= exit_m).astype(float)


def _disc(profile: str) -> tuple[np.ndarray, np.ndarray]:
    """Points of the unit disc (n, 2) and their shares of the shots (n,), which sum to 1."""
    k = np.arange(_SUNFLOWER) + 0.5
    r, phi = np.sqrt(k / _SUNFLOWER), math.pi * (1.0 + math.sqrt(5.0)) * k
    u = np.column_stack([r * np.cos(phi), r * np.sin(phi)])
    share = _profile(u, profile)
    return u, share / share.sum()


def _profile(u: np.ndarray, profile: str) -> np.ndarray:
    """Shots per area of the unit disc at ``u`` (..., 2); its integral over the disc is 1."""
    square = (u**2).sum(axis=-1)
    if profile == "gaussian":
        norm = math.pi / _GAUSSIAN_RATE * -math.expm1(-_GAUSSIAN_RATE)
        return np.where(square <= 1.0, np.exp(-_GAUSSIAN_RATE * square) / norm, 0.0)
    return np.where(square <= 1.0, 1.0 / math.pi, 0.0)


def _together(a: Cloud, b: Cloud, z: np.ndarray) -> np.ndarray:
    """Mean of p_a(t - age_a) p_b(t - age_b) over time: pulses meet what left the nozzle earlier; shape of ``z``.

    Nozzles of different rhythm meet in all phases alike: 1.
    """
    pulse = a.nozzle.pulse
    if pulse is None or pulse != b.nozzle.pulse:
        return np.ones_like(z)
    return autocorrelation(pulse, (a.age_s - b.age_s) + z * (a.ageing_s_m - b.ageing_s_m))


def autocorrelation(pulse: Pulse, lag_s: np.ndarray) -> np.ndarray:
    """Mean over time of p(t) p(t + lag), p of mean 1 (see ``Pulse``)."""
    cycles = np.asarray(lag_s) * pulse.frequency_Hz
    if pulse.pattern == "sinusoidal":
        return 1.0 + 0.5 * pulse.amplitude**2 * np.cos(2.0 * math.pi * cycles)
    phase = np.abs(cycles - np.round(cycles))
    both_on = np.maximum(pulse.duty - phase, 0.0) + np.maximum(pulse.duty - (1.0 - phase), 0.0)
    return both_on / pulse.duty**2
