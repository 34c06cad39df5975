"""Flight and contact of hard spheres: the closed forms of the event-driven flow, for numba.

Free flight is straight, or bent by a gravity that all shots share, so that one flies straight as seen from
another.  A contact is an instant: the impulse along the normal is J_n = (1 + e) m |g_n|, m the effective mass
m_i m_j / (m_i + m_j), and the impulse across it, against the slip of the touching points, is that of
``tangential.impulse_across``.  Between shots the normal is that in the middle of their contact
(``pair_contact``); on the target it does not turn.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.flow import drag, pair_contact, restitution, tangential
from glue.flow.event_compile import part
from glue.flow.event_state import SPOT_BUCKETS

restitution_at = part(restitution.restitution_at)
equivalent_speed = part(restitution.equivalent_speed)
hardened = part(restitution.hardened)
impulse_across = part(tangential.impulse_across)
slip_on_target = part(tangential.slip_on_target)
change_on_target = part(tangential.change_on_target)
parting = part(pair_contact.parting)
slowed = part(drag.slowed)
drag_rate_1_s = part(drag.drag_rate_1_s)
turned_normal = part(pair_contact.turned_normal)

# A shot that gravity lets rise by less than this share of its radius after an impact has come to rest.
REST_RISE = 1e-3


class Physics(NamedTuple):
    """Constants of a run, SI. Of the same types, so that one compiled kernel serves every scene."""

    e_shots: float
    mu_shots: float
    e_target: float
    e_speed_m_s: float
    e_exponent: float
    e_largest: float
    e_logs: np.ndarray  # (n, 2) the law as a table; (0, 2): the power law
    e_density_kg_m3: float  # of the shots it holds for; 0: all
    mu_target: float
    saturated: float
    hits: float
    spot_radius_m: float  # 0: no hardening
    elastic_within_s: float  # the guard: a contact sooner after the last one loses nothing
    gravity: tuple[float, float, float]  # bends the free flight
    pull: tuple[float, float, float]  # gravity, whether it bends the flight or comes by kicks
    # Between two kicks: the change of velocity, how far the path bends off its straight stretch over the diameter;
    # both inf: no kicks.  And the share of its speed against the gas that drag alone may take.
    kick_loss_m_s: float
    kick_bend: float
    kick_share: float
    around: drag.Surroundings  # what the kicks bring
    compliance: np.ndarray  # (1 - nu^2) / E [1/Pa] by medium


@part
def advance_shot(shot, gravity, t):
    """Move the record ``shot`` along its free flight to time ``t``."""
    s = t - shot.since
    gx, gy, gz = gravity
    shot.x += (shot.vx + 0.5 * gx * s) * s
    shot.y += (shot.vy + 0.5 * gy * s) * s
    shot.z += (shot.vz + 0.5 * gz * s) * s
    shot.vx += gx * s
    shot.vy += gy * s
    shot.vz += gz * s
    shot.since = t


@part
def meeting(a, b, gravity):
    """(time, overlap) of shots ``a`` and ``b``: time of their touch, inf if they never meet.

    ``overlap`` is how deep shots that approach are inside one another at the later of their two reference
    times, over the sum of their radii; 0 if they are apart.  The result does not depend on the order of the
    two nor on the time of asking, so that every way to search for partners finds the same events.
    """
    t = max(a.since, b.since)
    sa, sb = t - a.since, t - b.since
    gx, gy, gz = gravity
    x = (a.x + (a.vx + 0.5 * gx * sa) * sa) - (b.x + (b.vx + 0.5 * gx * sb) * sb)
    y = (a.y + (a.vy + 0.5 * gy * sa) * sa) - (b.y + (b.vy + 0.5 * gy * sb) * sb)
    z = (a.z + (a.vz + 0.5 * gz * sa) * sa) - (b.z + (b.vz + 0.5 * gz * sb) * sb)
    u = (a.vx + gx * sa) - (b.vx + gx * sb)
    v = (a.vy + gy * sa) - (b.vy + gy * sb)
    w = (a.vz + gz * sa) - (b.vz + gz * sb)
    approach = x * u + y * v + z * w
    if approach >= 0.0:
        return math.inf, 0.0
    reach = a.radius + b.radius
    apart2 = x * x + y * y + z * z
    c = apart2 - reach * reach
    root2 = approach * approach - (u * u + v * v + w * w) * c
    if root2 <= 0.0:
        return math.inf, 0.0
    if c < 0.0:
        return t, 1.0 - math.sqrt(apart2) / reach
    return t + c / (math.sqrt(root2) - approach), 0.0


@part
def energy(shot):
    """Kinetic energy of flight and spin [J]; a solid sphere's inertia is 2/5 m r^2."""
    v2 = shot.vx**2 + shot.vy**2 + shot.vz**2
    w2 = shot.wx**2 + shot.wy**2 + shot.wz**2
    return 0.5 * shot.mass * (v2 + 0.4 * shot.radius**2 * w2)


@part
def _impulse(slip, n, m, e, mu, approach):
    """Impulse (x, y, z) [N s] on the body that the unit normal ``n`` points at.

    ``slip`` is its touching point's velocity [m/s] relative to the other's, ``m`` the effective mass, ``approach``
    [m/s] the speed that the size follows from; no impulse unless they approach.
    """
    nx, ny, nz = n
    gn = slip[0] * nx + slip[1] * ny + slip[2] * nz
    if gn >= 0.0 or approach <= 0.0:
        return 0.0, 0.0, 0.0
    tx, ty, tz = slip[0] - gn * nx, slip[1] - gn * ny, slip[2] - gn * nz
    gt = math.sqrt(tx * tx + ty * ty + tz * tz)
    along = (1.0 + e) * m * approach
    across = m * impulse_across(approach, gt, e, mu) / gt if gt > 0.0 else 0.0
    return along * nx - across * tx, along * ny - across * ty, along * nz - across * tz


@part
def _push(shot, px, py, pz, arm, n):
    """Give the shot an impulse p at the touched point ``arm`` times its radius along ``n`` from its centre."""
    nx, ny, nz = n
    shot.vx += px / shot.mass
    shot.vy += py / shot.mass
    shot.vz += pz / shot.mass
    k = arm / (0.4 * shot.mass * shot.radius)
    shot.wx += k * (ny * pz - nz * py)
    shot.wy += k * (nz * px - nx * pz)
    shot.wz += k * (nx * py - ny * px)


@part
def collide(a, b, e, mu):
    """Let touching shots collide; (relative gain of energy, relative change of momentum) should be <= 0, 0."""
    x, y, z = a.x - b.x, a.y - b.y, a.z - b.z
    distance = math.sqrt(x * x + y * y + z * z)
    n = (x / distance, y / distance, z / distance)  # from b to a
    u = (a.vx - b.vx, a.vy - b.vy, a.vz - b.vz)
    reach = a.radius + b.radius
    m = a.mass * b.mass / (a.mass + b.mass)
    compliance = a.compliance + b.compliance
    modulus = 1.0 / compliance if compliance > 0.0 else math.inf
    x, y, z, approach = turned_normal(n, u, e, reach, m, a.radius * b.radius / reach, modulus)
    q = (x, y, z)
    sx = a.radius * a.wx + b.radius * b.wx
    sy = a.radius * a.wy + b.radius * b.wy
    sz = a.radius * a.wz + b.radius * b.wz
    slip = (
        u[0] - (sy * q[2] - sz * q[1]),
        u[1] - (sz * q[0] - sx * q[2]),
        u[2] - (sx * q[1] - sy * q[0]),
    )
    before = energy(a) + energy(b)
    qx, qy, qz = _momentum(a, b)
    px, py, pz = _impulse(slip, q, m, e, mu, approach)
    _push(a, px, py, pz, -1.0, q)
    _push(b, -px, -py, -pz, 1.0, q)
    dx, dy, dz = parting(n, (a.vx - b.vx, a.vy - b.vy, a.vz - b.vz))
    share = m / a.mass
    a.vx, a.vy, a.vz = a.vx + share * dx, a.vy + share * dy, a.vz + share * dz
    share = m / b.mass
    b.vx, b.vy, b.vz = b.vx - share * dx, b.vy - share * dy, b.vz - share * dz
    rx, ry, rz = _momentum(a, b)
    off = math.sqrt((rx - qx) ** 2 + (ry - qy) ** 2 + (rz - qz) ** 2)
    scale = math.sqrt(2.0 * before * max(a.mass, b.mass))
    return (energy(a) + energy(b) - before) / before, off / scale


@part
def _momentum(a, b):
    return (
        a.mass * a.vx + b.mass * b.vx,
        a.mass * a.vy + b.mass * b.vy,
        a.mass * a.vz + b.mass * b.vz,
    )


@part
def strike(shot, n, e, mu):
    """Let a shot that touches the resting target bounce off its outward normal ``n``; relative gain of energy."""
    nx, ny, nz = n
    gn, tx, ty, tz, gt = slip_on_target(shot.vx, shot.vy, shot.vz, shot.wx, shot.wy, shot.wz, nx, ny, nz, shot.radius)
    if gn <= 0.0:
        return 0.0
    before = energy(shot)
    across = impulse_across(gn, gt, e, mu)
    vx, vy, vz, wx, wy, wz = change_on_target(gn, tx, ty, tz, gt, nx, ny, nz, shot.radius, e, across)
    shot.vx, shot.vy, shot.vz = shot.vx + vx, shot.vy + vy, shot.vz + vz
    shot.wx, shot.wy, shot.wz = shot.wx + wx, shot.wy + wy, shot.wz + wz
    return (energy(shot) - before) / before


@part
def on_spot(world, physics, x, y, z):
    """Number of earlier impacts within the spot around a touched point; the point then counts for later ones."""
    clock, edge = world.clock[0], physics.spot_radius_m
    cx, cy, cz = math.floor(x / edge), math.floor(y / edge), math.floor(z / edge)
    earlier = 0
    for ix in range(cx - 1, cx + 2):
        for iy in range(cy - 1, cy + 2):
            for iz in range(cz - 1, cz + 2):
                k = world.buckets[_bucket(ix, iy, iz)]
                while k >= 0:
                    spot = world.spots[k]
                    # other cells share the bucket: count a spot only in its own cell
                    if (
                        math.floor(spot.x / edge) == ix
                        and math.floor(spot.y / edge) == iy
                        and math.floor(spot.z / edge) == iz
                        and (spot.x - x) ** 2 + (spot.y - y) ** 2 + (spot.z - z) ** 2 <= edge * edge
                    ):
                        earlier += 1
                    k = spot.following
    spot = world.spots[clock.spots]
    spot.x, spot.y, spot.z = x, y, z
    home = _bucket(cx, cy, cz)
    spot.following = world.buckets[home]
    world.buckets[home] = clock.spots
    clock.spots += 1
    return earlier


@part
def _bucket(ix, iy, iz):
    return ((int(ix) * 92821 + int(iy)) * 92821 + int(iz)) & (SPOT_BUCKETS - 1)
