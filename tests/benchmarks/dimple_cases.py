"""What the dimple benchmark computes: impacts without a cache, in pairs; fields of two codes on the same points."""

from __future__ import annotations

import math
import resource
import tempfile
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from unittest import mock

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from glue.errors import PeenError
from glue.scene.catalogue import material
from glue.scene.model import JohnsonCook, Material
from glue.target.dimple import zero_height_radius
from glue.target.reduced_impact import Numerics, ReducedImpact, solve_reduced
from glue.target.tables import read_table

AL2024 = material("al2024-t351")
STEEL = 7800.0  # kg/m3
SPEED = 60.0  # m/s
R_MM = 0.5  # radius of the reference shot
EXTREME_SPEEDS = (1.0, 5.0, 20.0, 60.0, 100.0, 200.0, 300.0)
EXTREME_TARGETS: dict[str, tuple[Material, JohnsonCook]] = {
    "perfectly plastic": (AL2024, JohnsonCook(369e6, 0.0, 1.0)),
    "2024": (AL2024, AL2024.johnson_cook),
    "4340": (material("steel4340"), material("steel4340").johnson_cook),
    "A = 2500, hard": (AL2024, JohnsonCook(2500e6, 0.0, 1.0)),
}


@contextmanager
def no_cache() -> Iterator[None]:
    """Inside, nothing comes from an earlier run."""
    with tempfile.TemporaryDirectory(prefix="peen-bench-") as folder, mock.patch.dict("os.environ", PEEN_CACHE=folder):
        yield


def processor_time() -> float:
    """Seconds of processor that this process and its ended children have taken so far."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


@dataclass(frozen=True)
class Solved:
    """One impact without a cache."""

    impact: ReducedImpact
    wall_s: float  # all of it: Python, FreeFem++ starting, meshing, solving, reading
    processor_s: float  # of all its processes: the wall time on an idle machine, for they run one after the other
    penetration: float  # largest [R]

    def values(self) -> dict[str, float]:
        """What a dimple is judged by, in units of R and MPa."""
        return {
            "depth": float(-self.impact.surface_z[0]),
            "radius": zero_height_radius(self.impact),
            "peak force": self.impact.peak_force,
            "e": self.impact.restitution,
        }


def solve(elements: int, *, target: Material = AL2024, law: JohnsonCook | None = None, speed: float = SPEED,
          **numerics: float) -> Solved:  # fmt: skip
    """The impact at a/``elements`` on ``target``; ``numerics`` replace those of glue.target.reduced_impact."""
    with no_cache():
        begun, used = time.monotonic(), processor_time()
        impact = solve_reduced(target, law or target.johnson_cook, speed_m_s=speed, density_kg_m3=STEEL,
                               elements_per_radius=elements, numerics=Numerics(**numerics))  # fmt: skip
        wall, used = time.monotonic() - begun, processor_time() - used
        return Solved(impact, wall, used, float(read_table(impact.log.with_name("result.csv"))["depth_max"][0]))


def extreme(job: tuple[str, float]) -> dict:
    """One of the extremes at a/3: its numbers, or ``refused`` with the reason, or ``failed``."""
    name, speed = job
    target, law = EXTREME_TARGETS[name]
    try:
        got = solve(3, target=target, law=law, speed=speed).impact
    except PeenError as problem:
        return {"target": name, "speed": speed, "failed": " ".join(str(problem).split())[:400]}
    found = {"target": name, "speed": speed, "e": got.restitution, "energy": got.energy_error,
             "peeq": float(got.points["peeq"].max())}  # fmt: skip
    try:
        return {**found, "radius": zero_height_radius(got)}
    except PeenError as problem:
        return {**found, "refused": " ".join(str(problem).split())}


def extremes() -> Iterator[dict]:
    """All speeds on all targets, two at a time, in order."""
    jobs = [(name, speed) for name in EXTREME_TARGETS for speed in EXTREME_SPEEDS]
    with ProcessPoolExecutor(2) as pool:
        yield from pool.map(extreme, jobs)


def poisson(job: tuple[float, int]) -> tuple[float, int, Solved]:
    """The reference impact on 2024 with another Poisson's ratio."""
    nu, elements = job
    return nu, elements, solve(elements, target=replace(AL2024, nu=nu))


def all_poisson(ratios: Iterable[float], meshes: Iterable[int]) -> dict[tuple[float, int], Solved]:
    """Every ratio on every mesh, two at a time."""
    with ProcessPoolExecutor(2) as pool:
        return {(nu, n): got for nu, n, got in pool.map(poisson, [(nu, n) for n in meshes for nu in ratios])}


def order(errors: list[float]) -> float:
    """Observed order of convergence of values on meshes each twice as fine, from the last three differences."""
    first, second = abs(errors[-2] - errors[-3]), abs(errors[-1] - errors[-2])
    return math.log2(first / second) if first > 0 and second > 0 else math.inf


def layer_means(r, z, s, depths, inner: float, outer: float) -> np.ndarray:
    """Mean of ``s`` over the ring ``inner`` < r < ``outer`` at each depth, linear between the points given."""
    near = (r < 3 * outer) & (z > -14 * outer)
    r, z, s = r[near], z[near], s[near]
    field = LinearNDInterpolator(np.column_stack([np.r_[r, -r], np.r_[z, z]]), np.r_[s, s])
    radii = np.sqrt(inner**2 + (outer**2 - inner**2) * (np.arange(40) + 0.5) / 40)  # rings of equal area
    return np.nanmean(field(np.broadcast_to(radii, (len(depths), 40)), -np.asarray(depths)[:, None]), axis=1)


def sign_change(depths: np.ndarray, stress: np.ndarray) -> float:
    """Depth below the largest compression at which the stress turns tensile; NaN when it does not."""
    start = int(np.argmin(stress))
    i = start + np.flatnonzero((stress[start:-1] < 0) & (stress[start + 1 :] >= 0))
    return float(depths[i[0]] - stress[i[0]] * np.diff(depths)[i[0]] / np.diff(stress)[i[0]]) if i.size else math.nan


def element_pressure(impact: ReducedImpact) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners (k, 3, 2) [R, undeformed] of the elements, mean stress (k,) [MPa] in each, its volume (k,)."""
    p = impact.points
    at = np.stack([p["r"], p["z"]], axis=-1).reshape(-1, 3, 2)  # each point two thirds of the way to its corner
    mean = ((p["s_rr"] + p["s_zz"] + p["s_tt"]) / 3).reshape(-1, 3)
    w = p["volume"].reshape(-1, 3)
    return 2 * at - at.sum(axis=1, keepdims=True) / 3, np.average(mean, axis=1, weights=w), w.sum(axis=1)


def holders(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(n,) index of the triangle (k, 3, 2) that holds each of ``points`` (n, 2); of the nearest when none does."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    d = points[:, None] - a
    first = (d[..., 0] * v[:, 1] - d[..., 1] * v[:, 0]) / area
    second = (u[:, 0] * d[..., 1] - u[:, 1] * d[..., 0]) / area
    return np.minimum(np.minimum(first, second), 1 - first - second).argmax(axis=1)


def field_difference(coarse: ReducedImpact, fine: ReducedImpact, reach: float) -> float:
    """Rms difference of the elements' mean stress over its rms, within ``reach`` [R] of the contact's centre.

    The finer field is averaged over the elements whose centres lie in each element of the coarser: a pattern that
    alternates from element to element shows as a difference, and one that stays as one that does not fall with the mesh.
    """
    (xc, pc, vc), (xf, pf, vf) = element_pressure(coarse), element_pressure(fine)
    centres = xf.mean(axis=1)
    near = np.hypot(*centres.T) < 1.3 * reach
    owner = holders(xc, centres[near])
    volume = np.bincount(owner, vf[near], len(vc))
    inside = (np.hypot(*xc.mean(axis=1).T) < reach) & (volume > 0)
    mean = np.bincount(owner, vf[near] * pf[near], len(vc))[inside] / volume[inside]
    return float(np.sqrt(np.average((pc[inside] - mean) ** 2, weights=vc[inside]))
                 / np.sqrt(np.average(mean**2, weights=vc[inside])))  # fmt: skip


def hardening_table(law: JohnsonCook, points: int = 60) -> np.ndarray:
    """(points + 1, 2): yield stress [MPa] at plastic strains 0 to 3, dense where the curve bends."""
    p = np.concatenate([[0.0], np.geomspace(1e-4, 3.0, points)])
    return np.column_stack([(law.A_Pa + law.B_Pa * p**law.n) * 1e-6, p])


def scaled(folder: Path, diameter_m: float):
    """The fast dimple of a shot of ``diameter_m``, solved anew; its numbers over the diameter in a list."""
    from glue.target.dimple import solve_dimple

    with no_cache():
        d = solve_dimple(AL2024, speed_m_s=SPEED, density_kg_m3=STEEL, diameter_m=diameter_m, elements_per_radius=3,
                         workdir=folder)  # fmt: skip
    return np.concatenate([
        [d.radius_m / diameter_m, d.depth_m / diameter_m, d.crest_radius_m / diameter_m, d.restitution,
         d.peak_force_N / diameter_m**2, d.contact_time_s / diameter_m, d.edge_peeq],
        d.profile_z_m / diameter_m, d.layer_stress_Pa, d.sigma_rr_Pa, d.peeq,
    ])  # fmt: skip
