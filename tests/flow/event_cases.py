"""What the tests of the event-driven flow share: arrivals by hand and a slow, independent reference."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from scenes import bare_scene

from glue.flow.arrivals import COLUMNS
from glue.flow.pair_contact import parting, turned_normal
from glue.flow.tangential import impulse_across

STEEL_MODULUS_PA = 210e9 / (2.0 * (1.0 - 0.3**2))  # E* of two shots of ``bare_scene``


def shots(*rows) -> np.ndarray:
    """Arrivals from rows (time, position, velocity) or (time, position, velocity, diameter, density)."""
    arrivals = np.zeros(len(rows), COLUMNS)
    for i, (time, position, velocity, *body) in enumerate(rows):
        diameter, density = body or (1e-3, 7800.0)
        arrivals[i] = (i, time, *position, *velocity, diameter, density, 0, 0, 0)
    return arrivals


def smooth_scene(mu=0.0, **changes):
    """``bare_scene`` with friction ``mu`` on both sides."""
    scene = bare_scene(**changes)
    return dataclasses.replace(
        scene, friction=dataclasses.replace(scene.friction, shot_target=mu, shot_shot=mu)
    )


def march(arrivals, e_target, e_shots, mu, until_s):
    """First impacts {shot_id: (time, velocity in, velocity out, spin out)} by searching all pairs at every event.

    Everything moves at every event, nothing is remembered, no shot is ever dropped: as simple as it can be.
    """
    n = len(arrivals)
    r = 0.5 * arrivals["diameter_m"]
    m = arrivals["density_kg_m3"] * 4.0 / 3.0 * math.pi * r**3
    v = np.column_stack([arrivals[c] for c in ("vx_m_s", "vy_m_s", "vz_m_s")])
    t_in = arrivals["time_s"] - 1.25 * 2.0 * r.max() / np.linalg.norm(v, axis=1)
    x = (
        np.column_stack([arrivals[c] for c in ("x_m", "y_m", "z_m")])
        + v * (t_in - arrivals["time_s"])[:, None]
    )
    w = np.zeros((n, 3))
    now, inside, impacts = t_in.min(), np.zeros(n, bool), []
    while now < until_s:
        best, what = until_s, None
        waiting = np.flatnonzero(~inside)
        if len(waiting):
            k = waiting[np.argmin(t_in[waiting])]
            best, what = t_in[k], ("enters", k, None)
        ids = np.flatnonzero(inside)
        for a, i in enumerate(ids):
            if v[i, 2] < 0.0 and now + (x[i, 2] - r[i]) / -v[i, 2] < best:
                best, what = now + (x[i, 2] - r[i]) / -v[i, 2], ("strikes", i, None)
            for j in ids[a + 1 :]:
                d, u = x[j] - x[i], v[j] - v[i]
                b = d @ u
                if b < 0.0 and (root := b * b - u @ u * (d @ d - (r[i] + r[j]) ** 2)) > 0.0:
                    t = now + (-b - math.sqrt(root)) / (u @ u)
                    if t < best:
                        best, what = t, ("meets", i, j)
        x[inside] += v[inside] * (best - now)
        now = best
        if what is None:
            break
        kind, i, j = what
        if kind == "enters":
            inside[i] = True
        elif kind == "strikes":
            before = v[i].copy()
            _bounce(i, None, np.array([0.0, 0.0, -1.0]), x, v, w, r, m, e_target, mu)
            impacts.append((int(arrivals["shot_id"][i]), now, *before, *v[i], *w[i]))
        else:
            d = x[j] - x[i]
            _bounce(i, j, d / np.linalg.norm(d), x, v, w, r, m, e_shots, mu)
    return np.array(impacts)


def _bounce(i, j, n, x, v, w, r, m, e, mu):
    """Instant contact of i with j (None: the resting target), n from i towards it."""
    m_j, r_j, v_j, w_j = (m[j], r[j], v[j], w[j]) if j is not None else (math.inf, math.inf, 0.0, np.zeros(3))
    reduced = 1.0 / (1.0 / m[i] + 1.0 / m_j)
    first, u, approach = n, v[i] - v_j, None
    if j is not None:
        radius = r[i] * r_j / (r[i] + r_j)
        *turned, approach = turned_normal(-n, u, e, r[i] + r_j, reduced, radius, STEEL_MODULUS_PA)
        n = -np.array(turned)
    slip = u + np.cross(w[i], r[i] * n) + (np.cross(w_j, r_j * n) if j is not None else 0.0)
    gt = slip - (slip @ n) * n
    gn = slip @ n if approach is None else approach
    size = np.linalg.norm(gt)
    change = -(1.0 + e) * gn * n
    if size > 0.0:
        change = change - impulse_across(gn, size, e, mu) * gt / size
    for body, sign in ((i, 1.0), (j, -1.0)):
        if body is not None:
            impulse = sign * reduced * change
            v[body] += impulse / m[body]
            w[body] += np.cross(r[body] * n, reduced * change) / (0.4 * m[body] * r[body] ** 2)
    if j is not None:
        extra = np.array(parting(-first, u + change))
        v[i] += reduced / m[i] * extra
        v[j] -= reduced / m[j] * extra
