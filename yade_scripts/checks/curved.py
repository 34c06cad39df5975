"""Impacts on curved and tessellated targets: one contact each, the rebound and the force of the flat target.

The trap: on facets that tile the surface, a shot that strikes a shared edge or vertex has several contacts at
once (restitution .61 instead of .70, peak force 25 % high, more at a vertex).  Here every contact has a facet
of its own (``target_curved.py``).  Shots at 60 m/s, e .7, no friction, on a block whose top is tessellated,
aimed at faces, edges and vertices, and on a cylinder of 20 mm radius, at its apex and up to 40 degrees down
its side.  The flat target under the same shots is the yardstick; 1.0 P, 40 sub-step phases each.

    yade -n -x yade_scripts/checks/curved.py [--json FILE]
"""

import dataclasses
import math
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import SCRIPTS, Rows

import numpy as np

from flow_run import FlowRun
from glue.flow.arrivals import COLUMNS
from glue.flow.impacts import read_impacts
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.model import Friction
from glue.scene.reader import read_scene
from run_plan import plan_run

SCENE = dataclasses.replace(
    read_scene(SCRIPTS.parent / "glue" / "scene" / "examples" / "al2024-s390.toml"),
    friction=Friction(0.0, 0.0),
)
RADIUS = 0.02  # of the cylinder [m]
CELL = 0.005  # side of the squares, each of two triangles, that tile the block's top [m]
COUNT = 40


def block(half: int = 4, depth_m: float = 0.01) -> np.ndarray:
    """Triangles (m, 3, 3) of a block 2 ``half`` cells wide, its top at z = 0: every face a grid of squares."""
    corners = np.arange(-half, half + 1) * CELL
    triangles = []

    def face(at):
        for i in range(2 * half):
            for j in range(2 * half):
                a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
                triangles.extend([(a, b, c), (a, c, d)])

    def side(at):
        for i in range(2 * half):
            a, b, c, d = at(i, 1), at(i + 1, 1), at(i + 1, 0), at(i, 0)
            triangles.extend([(a, c, b), (a, d, c)])

    low = -depth_m
    face(lambda i, j: (corners[i], corners[j], 0.0))
    face(lambda i, j: (corners[j], corners[i], low))
    heights = (0.0, low)
    end = corners[-1]
    side(lambda i, k: (corners[i], -end, heights[1 - k]))
    side(lambda i, k: (corners[-1 - i], end, heights[1 - k]))
    side(lambda i, k: (-end, corners[-1 - i], heights[1 - k]))
    side(lambda i, k: (end, corners[i], heights[1 - k]))
    return np.array(triangles)


def impacts(surface: TargetSurface, place: np.ndarray, *, at_once: int = 1) -> np.ndarray:
    """The impacts of shots straight down at ``place`` (n, 2) [m], ``at_once`` of them together, in their order."""
    n = len(place)
    arrivals = np.zeros(n, COLUMNS)
    arrivals["shot_id"] = np.arange(n)
    arrivals["time_s"] = 0.01 * (np.arange(n) // at_once) + 1e-7 * np.linspace(0.0, 1.0, n)  # all phases
    arrivals["x_m"], arrivals["y_m"], arrivals["z_m"] = *place.T, SCENE.nozzle.stand_off_m
    arrivals["vz_m_s"] = -60.0
    arrivals["diameter_m"], arrivals["density_kg_m3"] = SCENE.shots.diameter_m, SCENE.shots.density_kg_m3
    with tempfile.TemporaryDirectory() as folder:
        plan = plan_run(SCENE, RestitutionLaw(0.7), 1.0)
        FlowRun(SCENE, plan, arrivals, surface, Path(folder), {}).run({})
        log = read_impacts(Path(folder) / "impacts.csv")[0]
    return log[np.argsort(log["shot_id"], kind="stable")]


def components(log):
    """(normal speed in, normal speed out, change of the tangential velocity) against the logged normals."""
    normal = np.stack([log[c] for c in ("nx", "ny", "nz")], 1)
    v, w = (np.stack([log[f"v{c}_{when}_m_s"] for c in "xyz"], 1) for when in ("in", "out"))
    v_n, w_n = (v * normal).sum(1), (w * normal).sum(1)
    slip = np.linalg.norm((w - w_n[:, None] * normal) - (v - v_n[:, None] * normal), axis=1)
    return -v_n, w_n, slip


rows = Rows("curved and tessellated targets, dt 1.0 P")
rng = np.random.default_rng(3)
lattice = CELL * rng.integers(-2, 3, (COUNT, 2))
along = rng.uniform(0.2, 0.8, COUNT) * CELL
aims = {
    "faces": lattice + CELL * np.array((0.7, 0.3)),
    "edges": lattice + np.stack([along, 0.0 * along], 1),
    "diagonals": lattice + np.stack([along, along], 1),
    "vertices": lattice,
    "a hair beside edges": lattice + np.stack([along, rng.uniform(-1e-6, 1e-6, COUNT)], 1),
}
flat = impacts(TargetSurface(), aims["faces"])
e_flat, force_flat = flat["vz_out_m_s"].mean() / 60.0, flat["peak_force_N"].mean()
tiled = TargetSurface("triangles", triangles=block())
for name, place in aims.items():
    log = impacts(tiled, place)
    rows.true(f"block, {name}: one impact per shot", len(log) == COUNT and len(set(log["shot_id"])) == COUNT)
    v, w, slip = components(log)
    rows.near(f"block, {name}: restitution as on the plane", (w / v).mean(), e_flat, 1e-4)
    rows.near(f"block, {name}: peak force as on the plane [N]", log["peak_force_N"].mean(), force_flat, 1e-3)
    rows.below(f"block, {name}: sideways push [m/s]", slip.max(), 1e-3)
    off = np.hypot(*(np.stack([log["x_m"], log["y_m"]]) - place.T)) + np.abs(log["z_m"])
    rows.below(f"block, {name}: touched point off [m]", off.max(), 1e-9)

round_bar = TargetSurface("cylinder", RADIUS, "y")
for degrees in (0.0, 20.0, 40.0):
    x = (RADIUS + 0.5e-3) * math.sin(math.radians(degrees))
    place = np.stack([np.full(COUNT, x), rng.uniform(-4e-3, 4e-3, COUNT)], 1)
    log = impacts(round_bar, place)
    v, w, slip = components(log)
    tilt = np.degrees(np.arctan2(log["nx"], log["nz"]))
    rows.true(
        f"cylinder, {degrees:g} deg: one impact per shot", len(log) == COUNT == len(set(log["shot_id"]))
    )
    rows.below(f"cylinder, {degrees:g} deg: normal off [deg]", np.abs(tilt - degrees).max(), 1e-9)
    rows.near(
        f"cylinder, {degrees:g} deg: normal speed", v.mean(), 60.0 * math.cos(math.radians(degrees)), 1e-9
    )
    rows.near(f"cylinder, {degrees:g} deg: restitution", (w / v).mean(), 0.7, 0.005)
    rows.near(
        f"cylinder, {degrees:g} deg: peak force, Hertz's v^1.2 [N]",
        log["peak_force_N"].mean(),
        force_flat * math.cos(math.radians(degrees)) ** 1.2,
        0.005,
    )

# two shots on one vertex, one diameter and a bit apart and overlapping in time: each has its own facet only
pair = np.stack([np.tile([-0.51e-3, 0.51e-3], COUNT // 2), np.zeros(COUNT)], 1)
log = impacts(tiled, pair, at_once=2)
v, w, _ = components(log)
rows.true("two at once beside a vertex: one impact each", len(log) == COUNT == len(set(log["shot_id"])))
rows.near("two at once beside a vertex: restitution", (w / v).mean(), e_flat, 1e-3)
rows.finish()
