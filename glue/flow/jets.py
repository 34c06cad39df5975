"""Which shots can no longer matter: those that leave, and will meet no jet and no target any more.

A jet is the cone of its undisturbed shots: axis from the exit along the nozzle's direction, radius R(s) =
W/2 + s tan(half angle) at the distance s from the exit, both widened by a margin.  For a shot in straight
flight the distance to the axis is convex in time and R(s) linear, so

    g(t) = distance - R(s)

is convex: once g > 0 and rising, it stays positive, and the shot never enters that jet again.  Nor does one
that flies away on the nozzle's side of the exit (s < 0), where no shot is yet.  Only collisions among dropped
shots are lost.

A jet that is fed along counts as at rest (mm/s against m/s).  Straight flight is taken for granted: rising
shots beside the jet that gravity, or gas blown at the target, would bring down again are dropped too.  They
would land outside the jet; at 60 m/s and e .5 metres away, light beads in a blast of gas close to it.

Scalar functions on floats and on rows of floats, for numba too.  Standard library only: YADE's interpreter
imports this.
"""

from __future__ import annotations

import math

# Measured at 5 kg/min (1 mm, 60 m/s, e .6, 2100 shots): margins of .2, 1, 3 and 10 jet radii give 1.0572,
# 1.0576, 1.0576 and 1.0572 impacts per shot, mean normal energy .727 and collided share .247 in all.
JET_MARGIN = 0.5
# Falling shots are kept until this many stand-offs beside every jet: 1 m off where the window is a few
# millimetres.  At 3 stand-offs 4 % of the shots went this way, at 10 it is .8 %.
FAR_STAND_OFFS = 10.0

KEEP, EXIT, BESIDE, FAR, PAST = 0, 1, 2, 3, 4
REASONS = ("", "exit", "beside", "far", "past")  # names of the codes above, keys of "dropped" in flow.json


def jet_rows(
    scene, time_s: float, margin: float = JET_MARGIN, body_m: float = math.inf
) -> list[tuple[float, ...]]:
    """One row per nozzle at ``time_s``: exit (3) [m], direction (3), radius at the exit [m], its growth per
    metre, distance [m] from the axis where falling shots are dropped, and from the exit where the jet ends.

    The radius holds the margin and the largest diameter, so that shots at the jet's edge are met too.
    ``body_m``: how far the target reaches beyond the aim point along the jet; inf where nothing flies past.
    """
    rows = []
    for nozzle in scene.nozzles:
        x, y, _ = nozzle.aim_at(time_s)
        dx, dy, dz = nozzle.direction
        h = nozzle.stand_off_m
        spread = math.tan(math.radians(nozzle.divergence_half_angle_deg))
        radius = 0.5 * nozzle.jet_diameter_m
        rows.append(
            (
                x - h * dx,
                y - h * dy,
                -h * dz,
                dx,
                dy,
                dz,
                radius * (1.0 + margin) + scene.largest_diameter_m,
                spread * (1.0 + margin),
                radius + h * spread + FAR_STAND_OFFS * h,
                h + body_m,
            )
        )
    return rows


def fate(px, py, pz, vx, vy, vz, leaves, jets):
    """KEEP, or why the shot at p [m] with velocity v [m/s] can be dropped; ``jets`` from ``jet_rows``.

    ``leaves``: in straight flight it strikes the target no more (on a plane: vz >= 0).
    EXIT: it leaves, upstream through an exit's plane.  BESIDE: it leaves, outside every jet for ever.  FAR:
    it will strike, but far beside every jet and moving away.  PAST: it missed a curved target and flies on.
    """
    upstream = past = 0
    beside = far = True
    for jet in jets:
        dx, dy, dz = jet[3], jet[4], jet[5]
        qx, qy, qz = px - jet[0], py - jet[1], pz - jet[2]
        s, drift = qx * dx + qy * dy + qz * dz, vx * dx + vy * dy + vz * dz
        qx, qy, qz = qx - s * dx, qy - s * dy, qz - s * dz
        off = math.sqrt(qx * qx + qy * qy + qz * qz)
        outward = qx * vx + qy * vy + qz * vz  # off d(off)/dt; q is already across the axis
        if s < 0.0 and drift < 0.0:
            upstream += 1
        elif s > jet[9] and drift > 0.0:
            past += 1
        elif not (off > jet[6] + s * jet[7] and outward > off * drift * jet[7]):
            beside = False
        if not (off > jet[8] and outward > 0.0):
            far = False
    if leaves and beside:
        if upstream > 0:
            return EXIT
        return PAST if past > 0 else BESIDE
    return FAR if far else KEEP
