"""The impulse between two shots, along the line of centres that they have in the middle of their contact.

Shots that meet obliquely move past one another while they touch: the line between their centres turns, at
60 m/s by up to .2 rad.  To first order the impulse acts along the line as it is at the impulse's centroid, and its
size (1 + e) m (approach) follows from the approach along the line as it is at half of the contact.  With the
approach g_n, the sideways speed g_t of the centres, d the sum of the radii and m the effective mass,

    n' = (n + tan(turn) t) / |..|,   tan(turn) = tau g_t / d

and tau the time from touch to centroid, or to half of the contact.  Without losses the two are one, by symmetry.

- Hertz's impact takes tau = 1.4716 depth / g_n to its deepest point.
- Moving past, the centres also move apart, with g_t^2 / d: the contact is shorter, and never deepens longer than
  a free flight does, g_n d / g_t^2.  With x = 1.4716 depth g_t^2 / (g_n^2 d) of the two times their mean
  tau / (1 + x^1.5)^(2/3) is right to 1 % up to x = .4 (numerical integral).
- A dashpot that gives the restitution e at any speed (that of Antypov and Elliott, 2011) puts the centroid at
  e / (1 + e) of the contact, because the depth returns to 0 (integrate t F over it), and makes the contact longer
  by 1 + L/10 + L^2/20, L = -ln e (numerical integral, within 1 % down to e = .1).

Against that contact integrated in time the velocities after are off by less than .5 % of the closing speed for e
from .6 to 1 and 1.5 % at .3, up to impact parameters of .95 (tests/flow/test_pair_contact.py); shots that graze,
beyond that, are not judged.

Nothing is fitted to collisions; yade_scripts/checks/pairs.py compares with them.  What is left out: the centres'
way during the contact, some .1 mm, so that lines of flight are off by that much and the orbital angular
momentum by that times the momentum; linear momentum is exact and energy never rises.

Scalar functions, for numba too.  Standard library only: YADE's interpreter imports this.
"""

from __future__ import annotations

import math

TO_DEEPEST = 0.4 * math.gamma(0.4) * math.gamma(0.5) / math.gamma(0.9)  # 1.4716, times depth over speed
# What separates a pair that would still approach along its first normal, over its speed.
APART = 1e-9


def turned_normal(n, u, e, reach_m, mass_kg, radius_m, modulus_Pa):
    """n' (x, y, z) and the approach [m/s] that decides the impulse's size.

    n itself and -u.n for rigid shots (modulus inf) and for a central collision.  An approach of 0 or less: the shots
    slide past without a push.

    ``n`` unit normal from b to a, ``u`` velocity of a relative to b [m/s], towards it; ``reach_m`` sum of the
    radii, ``mass_kg`` and ``radius_m`` the effective ones (product over sum), ``modulus_Pa`` E*.
    """
    nx, ny, nz = n
    gn = -(u[0] * nx + u[1] * ny + u[2] * nz)
    tx, ty, tz = u[0] + gn * nx, u[1] + gn * ny, u[2] + gn * nz
    past = tx * tx + ty * ty + tz * tz
    if not gn > 0.0 or past == 0.0 or modulus_Pa == math.inf:
        return nx, ny, nz, gn
    depth = (15.0 * mass_kg * gn * gn / (16.0 * math.sqrt(radius_m) * modulus_Pa)) ** 0.4
    tau = TO_DEEPEST * depth / gn
    tau /= (1.0 + (tau * past / (reach_m * gn)) ** 1.5) ** (2.0 / 3.0)
    loss = -math.log(e)
    tau *= 1.0 + 0.1 * loss + 0.05 * loss * loss
    half = tau / reach_m
    approach = (gn - half * past) / math.sqrt(1.0 + half * half * past)
    way = 2.0 * e / (1.0 + e) * half
    x, y, z = nx + way * tx, ny + way * ty, nz + way * tz
    size = math.sqrt(x * x + y * y + z * z)
    return x / size, y / size, z / size, approach


def parting(n, out):
    """What to add to the relative velocity ``out`` [m/s] after the impulse so that the pair parts along ``n``.

    Shots that graze are past one another when they part; at the moment to which the impulse is put they are
    not yet.  They leave sideways then, at the speed that they have.  Mostly (0, 0, 0).
    """
    rise = out[0] * n[0] + out[1] * n[1] + out[2] * n[2]
    if rise >= 0.0:
        return 0.0, 0.0, 0.0
    x, y, z = out[0] - rise * n[0], out[1] - rise * n[1], out[2] - rise * n[2]
    flat2 = x * x + y * y + z * z
    speed = math.sqrt(flat2 + rise * rise)
    k = speed * math.sqrt((1.0 - APART * APART) / flat2) if flat2 > 0.0 else 0.0
    up = APART * speed
    return k * x + up * n[0] - out[0], k * y + up * n[1] - out[1], k * z + up * n[2] - out[2]
