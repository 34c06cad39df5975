"""The impulse between two shots, along the line of centres that they have in the middle of their contact.

Shots that meet obliquely move past one another while they touch: the line between their centres turns, at
60 m/s by up to .2 rad.  To first order the whole impulse acts along the line as it is at the impulse's centroid.
With the approach g_n, the sideways speed g_t of the centres, d the sum of the radii and m the effective mass,

    n' = (n + tan(turn) t) / |..|,   tan(turn) = tau g_t / d

and tau the time from touch to centroid.  Without losses that is half of the contact, by symmetry, exactly.

- Hertz's impact takes tau = 1.4716 depth / g_n to its deepest point.
- Moving past, the centres also move apart, with g_t^2 / d: the contact is shorter, and never deepens longer than
  a free flight does, g_n d / g_t^2.  With x = 1.4716 depth g_t^2 / (g_n^2 d) of the two times their mean
  tau / (1 + x^1.5)^(2/3) is right to 1 % up to x = .4 (numerical integral).
- A dashpot that gives the restitution e at any speed (that of Antypov and Elliott, 2011) puts the centroid at
  e / (1 + e) of the contact, because the depth returns to 0 (integrate t F over it), and makes the contact longer
  by 1 + L/10 + L^2/20, L = -ln e (numerical integral, within 1 % down to e = .1).

Nothing is fitted to collisions; yade_scripts/checks/pairs.py compares with them.  What is left out: the centres'
way during the contact, some .1 mm, so that lines of flight are off by that much and the orbital angular
momentum by that times the momentum; linear momentum is exact and energy never rises.

Scalar functions, for numba too.  Standard library only: YADE's interpreter imports this.
"""

from __future__ import annotations

import math

from glue.flow.tangential import impulse_across

TO_DEEPEST = 0.4 * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)  # 1.4716, times depth over speed
# What separates a pair that the turned impulse would leave approaching along its first normal, over its speed.
APART = 1e-9


def tan_turn(gn_m_s, gt_m_s, reach_m, mass_kg, radius_m, modulus_Pa, e):
    """tan(turn) from the touch to the impulse's centroid; 0 for gn <= 0 and for rigid shots (modulus inf).

    ``reach_m`` sum of the radii; ``mass_kg``, ``radius_m`` effective ones (product over sum); ``modulus_Pa`` E*.
    """
    if not gn_m_s > 0.0:
        return 0.0
    depth = (15.0 * mass_kg * gn_m_s * gn_m_s / (16.0 * math.sqrt(radius_m) * modulus_Pa)) ** 0.4
    tau = TO_DEEPEST * depth / gn_m_s
    past = tau * gt_m_s * gt_m_s / (reach_m * gn_m_s)
    loss = -math.log(e)
    late = 2.0 * e / (1.0 + e) * (1.0 + 0.1 * loss + 0.05 * loss * loss)
    return late * tau * gt_m_s / (reach_m * (1.0 + past**1.5) ** (2.0 / 3.0))


def impulse_between(n, u, s, e, mu, reach_m, mass_kg, radius_m, modulus_Pa):
    """(impulse over the effective mass [m/s], turned normal), 3 + 3, of shot a that touches shot b.

    ``n`` unit normal from b to a; ``u`` velocity of a relative to b [m/s]; ``s`` sum of radius times spin of both
    [m/s]; the others as in ``tan_turn``.  Afterwards the two separate along ``n``.
    """
    nx, ny, nz = n
    ux, uy, uz = u
    gn = -(ux * nx + uy * ny + uz * nz)
    if not gn > 0.0:
        return 0.0, 0.0, 0.0, nx, ny, nz
    tx, ty, tz = ux + gn * nx, uy + gn * ny, uz + gn * nz
    gt = math.sqrt(tx * tx + ty * ty + tz * tz)
    mx, my, mz = nx, ny, nz
    if gt > 0.0 and modulus_Pa < math.inf:
        turn = tan_turn(gn, gt, reach_m, mass_kg, radius_m, modulus_Pa, e)
        size = math.sqrt(1.0 + turn * turn)
        share = turn / gt
        mx, my, mz = (nx + share * tx) / size, (ny + share * ty) / size, (nz + share * tz) / size
    slip_x = ux - (s[1] * mz - s[2] * my)
    slip_y = uy - (s[2] * mx - s[0] * mz)
    slip_z = uz - (s[0] * my - s[1] * mx)
    approach = max(-(ux * mx + uy * my + uz * mz), 0.0)
    slip_x, slip_y, slip_z = slip_x + approach * mx, slip_y + approach * my, slip_z + approach * mz
    slip = math.sqrt(slip_x * slip_x + slip_y * slip_y + slip_z * slip_z)
    along = (1.0 + e) * approach
    back = impulse_across(approach, slip, e, mu) / slip if slip > 0.0 and approach > 0.0 else 0.0
    px, py, pz = along * mx - back * slip_x, along * my - back * slip_y, along * mz - back * slip_z
    ox, oy, oz = ux + px, uy + py, uz + pz
    out = ox * nx + oy * ny + oz * nz
    if out < 0.0:
        # A grazing touch: they are past one another when they part.  Here they are not yet, so they leave
        # sideways, at the speed that they have.
        ax, ay, az = ox - out * nx, oy - out * ny, oz - out * nz
        whole = math.sqrt(ox * ox + oy * oy + oz * oz)
        flat = math.sqrt(ax * ax + ay * ay + az * az)
        k = whole / flat * math.sqrt(1.0 - APART * APART) if flat > 0.0 else 0.0
        rise = APART * whole if flat > 0.0 else e * gn
        px, py, pz = k * ax + rise * nx - ux, k * ay + rise * ny - uy, k * az + rise * nz - uz
    return px, py, pz, mx, my, mz
