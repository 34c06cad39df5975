"""Small scenes, a stand-in for the dimple, and solids as STL, for the tests of whole flow runs."""

from __future__ import annotations

import math
import struct

import numpy as np

from glue.target.dimple import Dimple

SCENE = """
schema = 1
name = "small"
seed = 3
exposure_time_s = 0.2
[shots]
grade = "S390"
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = {flow}
jet_diameter_m = 0.008
stand_off_m = 0.05
impact_angle_deg = 90.0
{nozzle}
[target]
material = "al2024-t351"
window_m = [0.003, 0.003]
{target}
[restitution]
shot_target = "from_dimple"
[models]
flow = "{model}"
[accuracy]
preset = "fast"
"""
FEED = "feed_speed_m_s = 0.06\nfeed_direction_deg = 0.0\nstroke_m = 0.013\npasses = 2\ndwell_s = 0.0\n"
STL = '[target.surface]\nkind = "stl"\nfile = "{}"'


def dimple() -> Dimple:
    """The reference impact in round numbers: a dent 50 um deep, .22 mm wide, with a small rim."""
    r = np.linspace(0.0, 1.2e-3, 200)
    one = np.zeros(1)
    z = np.where(r < 0.22e-3, -50e-6 * (1 - (r / 0.22e-3) ** 2), 8e-6 * np.exp(-r / 0.2e-3) * (r - 0.22e-3) / 0.1e-3)
    return Dimple(
        radius_m=0.22e-3, depth_m=50e-6, crest_radius_m=0.25e-3, restitution=0.34, peak_force_N=261.0,
        contact_time_s=2.1e-6, speed_m_s=60.0, diameter_m=1e-3, density_kg_m3=7800.0, speed_exponent=0.47,
        restitution_exponent=0.25, edge_peeq=0.2, largest_peeq=0.4, energy_error=0.0, dofs=1, wall_s=0.0,
        profile_r_m=r, profile_z_m=z, layer_depth_m=one, layer_stress_Pa=one,
        points_m=np.array([[0.0, 0.0], [2e-3, 0.0], [0.0, -2e-3]]), triangles=np.array([[0, 1, 2]]),
        peeq=np.array([0.1]), sigma_rr_Pa=one,
    )  # fmt: skip


def box(size, top=0.0, tilt=0.0):
    """Triangles (12, 3, 3) of a box below z = ``top``, outwards, turned by ``tilt`` about y through the origin."""
    s = size / 2
    v = np.array([(x, y, z) for x in (-s, s) for y in (-s, s) for z in (top - size, top)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    c, n = math.cos(tilt), math.sin(tilt)
    turned = v @ np.array([[c, 0, n], [0, 1, 0], [-n, 0, c]])
    return np.array([turned[list(t)] for q in quads for t in ((q[0], q[1], q[2]), (q[0], q[2], q[3]))])


def write_stl(path, triangles):
    with open(path, "wb") as f:
        f.write(b"\0" * 80 + struct.pack("<I", len(triangles)))
        for t in triangles:
            n = np.cross(t[1] - t[0], t[2] - t[0])
            f.write(struct.pack("<12fH", *(n / np.linalg.norm(n)), *t.ravel(), 0))
