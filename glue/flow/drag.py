"""Air drag and gravity on a flying shot, as kicks between stretches of straight flight.

A sphere moving at u relative to the gas obeys

    du/dt = g - k(|u|) u,   k = 3/4 C_D rho_gas |u| / (rho d),   Re = rho_gas |u| d / mu
    C_D = 24/Re (1 + 0.15 Re^0.687) below Re = 1000, 0.44 above       (Schiller and Naumann, 1933)

Without gravity both branches have closed solutions for |u(t)|: above, 1/|u| grows linearly in time; below,
w = |u|^0.687 obeys Bernoulli's equation w' = -n a w (1 + b w), so that w/(1 + b w) decays exponentially.
``slowed`` uses them and puts half of gravity's share before and half after (error of third order in tau).

How to fly with it: shots fly straight at constant velocity; every ``kick_interval_s`` the velocity is
replaced.  Begin every free flight (exit, rebound) with a kick of half an interval, then kick by a whole one
at the end of each: then the velocity of every stretch is that in its middle and positions are right to
second order.  At a touch between kicks the velocity is that of the middle of the stretch, off by at most
half of ``KICK_LOSS``; who wants better calls ``slowed`` with the (signed) time from the middle to the touch.

Scalar functions on floats, which numba compiles unchanged.  Standard library only: YADE's interpreter
imports this too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from glue.scene.sizes import smallest_m

KICK_LOSS = 1e-3  # change of velocity between two kicks over the nozzle's speed
KICK_BEND = 1e-3  # distance from the bent path to its straight stretches, over the smallest diameter
_POWER = 0.687
_FACTOR = 0.15
_TURBULENT_RE = 1000.0
_TURBULENT_CD = 0.44


class Surroundings(NamedTuple):
    """Gas and gravity around the shots; gas density 0: no drag. Plain floats, so that numba takes it too."""

    gas_density_kg_m3: float
    gas_viscosity_Pa_s: float
    gas_vx_m_s: float
    gas_vy_m_s: float
    gas_vz_m_s: float
    gravity_x_m_s2: float
    gravity_y_m_s2: float
    gravity_z_m_s2: float


def surroundings(scene) -> Surroundings:
    """Gas and gravity of a scene; an "auto" block counts as present (the regime resolves it before)."""
    density = viscosity = speed = 0.0
    if scene.air_drag is not None:
        drag = scene.air_drag
        density, viscosity, speed = drag.gas_density_kg_m3, drag.gas_viscosity_Pa_s, drag.gas_speed_m_s
    gravity = scene.gravity.vector if scene.gravity is not None else (0.0, 0.0, 0.0)
    gas = (speed * c for c in scene.nozzle.direction)
    return Surroundings(density, viscosity, *gas, *(float(g) for g in gravity))


def drag_coefficient(reynolds: float) -> float:
    """C_D of a sphere (Schiller and Naumann), ``reynolds`` > 0."""
    if reynolds >= _TURBULENT_RE:
        return _TURBULENT_CD
    return 24.0 / reynolds * (1.0 + _FACTOR * reynolds**_POWER)


def drag_rate_1_s(
    relative_speed_m_s: float,
    diameter_m: float,
    density_kg_m3: float,
    gas_density_kg_m3: float,
    gas_viscosity_Pa_s: float,
) -> float:
    """k [1/s] of the deceleration k u; Stokes' 18 mu / (rho d^2) for speed 0, 0 without gas."""
    if gas_density_kg_m3 == 0.0:
        return 0.0
    reynolds = gas_density_kg_m3 * relative_speed_m_s * diameter_m / gas_viscosity_Pa_s
    if reynolds >= _TURBULENT_RE:
        return 0.75 * _TURBULENT_CD * gas_density_kg_m3 * relative_speed_m_s / (density_kg_m3 * diameter_m)
    return 18.0 * gas_viscosity_Pa_s / (density_kg_m3 * diameter_m**2) * (1.0 + _FACTOR * reynolds**_POWER)


def acceleration(
    vx: float, vy: float, vz: float, diameter_m: float, density_kg_m3: float, around: Surroundings
) -> tuple[float, float, float]:
    """Acceleration [m/s^2] of a sphere of velocity v [m/s] by drag and gravity (buoyancy neglected)."""
    ux, uy, uz = vx - around.gas_vx_m_s, vy - around.gas_vy_m_s, vz - around.gas_vz_m_s
    k = drag_rate_1_s(
        math.sqrt(ux * ux + uy * uy + uz * uz),
        diameter_m,
        density_kg_m3,
        around.gas_density_kg_m3,
        around.gas_viscosity_Pa_s,
    )
    return (
        around.gravity_x_m_s2 - k * ux,
        around.gravity_y_m_s2 - k * uy,
        around.gravity_z_m_s2 - k * uz,
    )


def slowed(vx, vy, vz, tau_s, diameter_m, density_kg_m3, around):
    """Velocity (vx, vy, vz) [m/s] of a sphere ``tau_s`` later; ``around`` as from ``surroundings``.

    Exact for drag alone and for gravity alone.  ``tau_s`` may be negative (back in time) by up to about a
    kick interval.  Calls nothing but math: numba compiles it as it is.
    """
    rho, mu, gas_x, gas_y, gas_z, gx, gy, gz = around
    half = 0.5 * tau_s
    ux, uy, uz = vx + half * gx - gas_x, vy + half * gy - gas_y, vz + half * gz - gas_z
    speed = math.sqrt(ux * ux + uy * uy + uz * uz)
    if rho > 0.0 and speed > 0.0:
        left = tau_s
        now = speed
        change_over = _TURBULENT_RE * mu / (rho * diameter_m)  # speed at which Re = 1000
        if now > change_over:
            c = 0.75 * _TURBULENT_CD * rho / (density_kg_m3 * diameter_m)
            turbulent = min(left, (1.0 / change_over - 1.0 / now) / c)
            now = now / (1.0 + c * now * turbulent)
            left -= turbulent
        if left != 0.0:
            a = 18.0 * mu / (density_kg_m3 * diameter_m * diameter_m)
            b = _FACTOR * (rho * diameter_m / mu) ** _POWER
            w = now**_POWER
            q = w / (1.0 + b * w) * math.exp(-_POWER * a * left)
            now = (q / (1.0 - b * q)) ** (1.0 / _POWER)
        scale = now / speed
        ux, uy, uz = scale * ux, scale * uy, scale * uz
    return gas_x + ux + half * gx, gas_y + uy + half * gy, gas_z + uz + half * gz


def kick_interval_s(scene, loss: float = KICK_LOSS, bend: float = KICK_BEND) -> float:
    """Time [s] between kicks; inf without drag and gravity.

    In it no shot changes its velocity by more than ``loss`` times the slowest nozzle's speed, nor leaves its
    straight stretch by more than ``bend`` smallest diameters (under an acceleration a by a T^2 / 8).
    """
    around = surroundings(scene)
    strongest = math.hypot(around.gravity_x_m_s2, around.gravity_y_m_s2, around.gravity_z_m_s2)
    if around.gas_density_kg_m3 > 0.0:
        # the drag of a shot of full speed against the gas, of the medium that feels it most
        speed = scene.fastest_m_s + abs(scene.air_drag.gas_speed_m_s)
        strongest += speed * max(
            drag_rate_1_s(speed, smallest_m(shots), shots.density_kg_m3, *around[:2]) for shots in scene.media
        )
    if strongest == 0.0:
        return math.inf
    by_speed = loss * min(nozzle.speed_m_s for nozzle in scene.nozzles) / strongest
    return min(by_speed, math.sqrt(8.0 * bend * scene.smallest_diameter_m / strongest))


def speed_after_flight(
    speed_m_s: float, distance_m: float, diameter_m: float, density_kg_m3: float, around: Surroundings
) -> float:
    """Speed [m/s] after flying ``distance_m`` along the gas's axis without gravity; 0 if it never arrives.

    ``around`` gives the gas; its velocity component along the flight is its whole speed.
    """
    gas = math.hypot(around.gas_vx_m_s, around.gas_vy_m_s, around.gas_vz_m_s)
    line = Surroundings(around.gas_density_kg_m3, around.gas_viscosity_Pa_s, gas, 0.0, 0.0, 0.0, 0.0, 0.0)

    def later(v, tau):
        return slowed(v, 0.0, 0.0, tau, diameter_m, density_kg_m3, line)[0]

    def way(v, tau):
        return tau * (v + 4.0 * later(v, 0.5 * tau) + later(v, tau)) / 6.0  # Simpson

    v, left = speed_m_s, distance_m
    while v > 1e-6 * speed_m_s:
        pull = abs(v - gas) * drag_rate_1_s(abs(v - gas), diameter_m, density_kg_m3, *around[:2])
        step = 0.02 * v / pull if pull > 0.0 else math.inf
        if step * v > 0.9 * left:  # the last one: as long as it takes
            last = left / v
            for _ in range(10):
                last *= left / way(v, last)
            if last <= step:
                return later(v, last)
        v, left = later(v, step), left - way(v, step)
    return 0.0


def drag_number(scene) -> float:
    """Share of its speed that a shot loses (or gains) to the gas on its way over the stand-off: the worst of
    all media and nozzles, mean shot size; 0 without air drag."""
    around = surroundings(scene)
    if around.gas_density_kg_m3 == 0.0:
        return 0.0
    return max(
        abs(
            1.0
            - speed_after_flight(n.speed_m_s, n.stand_off_m, m.diameter_m, m.density_kg_m3, around)
            / n.speed_m_s
        )
        for n in scene.nozzles
        for m in scene.media
    )
