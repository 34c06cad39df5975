"""The impulse across a contact: Coulomb's friction, limited by the spring that the contact also is.

Two solid spheres, or a sphere and a resting body, touch with the approach speed g_n and the slip g_t of the
touching points; m is their effective mass.  With J_n = (1 + e) m g_n (Walton and Braun, 1986)

    J_t = min(mu J_n, share m g_t),   share = 2/7 (1 + beta)

2/7 m is what a rigid sphere answers to a slip with (moment of inertia 2/5 m r^2, any two sizes), and beta the
tangential restitution: 0 ends the slip, 1 reverses it.  A constant beta misses contact simulations by 7 % of
the slip and more, because what a contact returns depends on whether it slides in part (Maw, Barber and
Fawcett, 1976).  Here ``share`` is a table over psi = g_t / (mu (1 + e) g_n) and e, linear between its knots;
beyond the last psi the contact slides throughout.

Fitted to oblique impacts in YADE (Hertz-Mindlin, steel on aluminium, nu .30 on .33, 60 m/s, steps of .3 P) by
yade_scripts/checks/tangential.py, which fits again, prints the table, and holds this one against impacts
that were not in the fit.  A sphere's contact is taken at its full radius; in YADE the overlap shortens the
arm, so that spins there are 3-6 % smaller.

Scalar functions, for numba too.  Standard library only: YADE's interpreter imports this.
"""

from __future__ import annotations

import math

E_KNOTS = (0.2, 0.6, 0.94)
PSI_KNOTS = (0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
SHARES = (  # rows: e, columns: psi
    (0.4766, 0.5652, 0.4779, 0.3446, 0.2646, 0.2052, 0.1463, 0.1250),
    (0.2276, 0.3434, 0.4087, 0.4132, 0.3352, 0.2401, 0.1612, 0.1250),
    (0.0874, 0.1921, 0.3567, 0.4348, 0.3330, 0.2430, 0.1649, 0.1250),
)


def impulse_across(gn_m_s, gt_m_s, e, mu):
    """J_t over the effective mass [m/s], against the slip ``gt_m_s`` >= 0; ``gn_m_s`` > 0 is the approach.

    ``e`` beyond the knots counts as the nearest one.
    """
    sliding = mu * (1.0 + e) * gn_m_s
    if gt_m_s >= PSI_KNOTS[-1] * sliding:
        return sliding
    psi = gt_m_s / sliding
    i = 0
    while i < len(E_KNOTS) - 2 and e > E_KNOTS[i + 1]:
        i += 1
    j = 0
    while psi > PSI_KNOTS[j + 1]:
        j += 1
    u = min(max((e - E_KNOTS[i]) / (E_KNOTS[i + 1] - E_KNOTS[i]), 0.0), 1.0)
    w = (psi - PSI_KNOTS[j]) / (PSI_KNOTS[j + 1] - PSI_KNOTS[j])
    low = (1.0 - w) * SHARES[i][j] + w * SHARES[i][j + 1]
    high = (1.0 - w) * SHARES[i + 1][j] + w * SHARES[i + 1][j + 1]
    return min(sliding, ((1.0 - u) * low + u * high) * gt_m_s)


def slip_on_target(vx, vy, vz, wx, wy, wz, nx, ny, nz, radius_m):
    """(g_n, slip x, y, z, its size g_t) [m/s] of a sphere that touches the target; n outward unit normal.

    v velocity [m/s], w spin [rad/s]; the touching point is at -radius n from the centre.
    """
    sx = vx - radius_m * (wy * nz - wz * ny)
    sy = vy - radius_m * (wz * nx - wx * nz)
    sz = vz - radius_m * (wx * ny - wy * nx)
    gn = -(sx * nx + sy * ny + sz * nz)
    tx, ty, tz = sx + gn * nx, sy + gn * ny, sz + gn * nz
    return gn, tx, ty, tz, math.sqrt(tx * tx + ty * ty + tz * tz)


def change_on_target(gn, tx, ty, tz, gt, nx, ny, nz, radius_m, e, across):
    """Change of velocity [m/s] and spin [rad/s] (3 + 3) of a sphere that strikes the resting target.

    The first five as ``slip_on_target`` gives them, ``across`` [m/s] as ``impulse_across`` does.
    """
    up = (1.0 + e) * gn
    back = across / gt if gt > 0.0 else 0.0
    k = 2.5 / radius_m * back  # moment of inertia 2/5 m r^2; torque -radius n x impulse
    return (
        up * nx - back * tx,
        up * ny - back * ty,
        up * nz - back * tz,
        k * (ny * tz - nz * ty),
        k * (nz * tx - nx * tz),
        k * (nx * ty - ny * tx),
    )
