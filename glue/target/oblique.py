"""Oblique impacts in three dimensions: runs ``freefem/oblique_impact.edp`` and measures the dimples it leaves.

The pipeline takes an oblique impact by its normal component.  These runs say how right that is: dimple, restitution and
tangential speed of a rigid sphere at any angle, against the normal impact at the same normal speed on the same mesh.

FreeFEM works in units of a, an estimate of the dimple radius: one mesh, one elastic factor and one contact compliance
then serve every shot, speed and angle on one material.  Results are in units of the shot radius R, as in
``glue.target.reduced_impact``; the speed stands for density x speed^2, and nothing else depends on R.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CloughTocher2DInterpolator

from glue.errors import InputError, NotConverged
from glue.scene.model import JohnsonCook, Material
from glue.solvers import run_freefem
from glue.target.cache import cached_folder, content_key
from glue.target.driver import Parameter, kernel_flavour, law_table, write_driver
from glue.target.progress import relay
from glue.target.tables import read_table
from glue.theory.impact_scale import (
    CONTACT_OVER_LOADING,
    REPRESENTATIVE_STRAIN,
    expected_impact,
)

ENERGY_ERROR_LIMIT = 0.02  # of the shot's kinetic energy, at any step
_SOURCES = (
    "freefem/oblique_impact.edp",
    *(f"freefem/lib/{name}.idp" for name in ("anderson", "contact_lcp", "contact_half", "law_script", "mesh_oblique",
                                             "points_finite_small", "points_small_*", "solid_half")),
    "freefem/plugin/*",
)  # fmt: skip
_RAYS, _REACH = 180, 3.5  # of the contour; rays as far as so many expected radii


@dataclass(frozen=True)
class ObliqueNumerics:
    """Numbers of the solution; tests/benchmarks/oblique.py varies them."""

    elements_per_radius: int = 3
    shells: int = 4  # of elements around the fine box: at most 4, the block ends 17 dimple radii off
    steps_per_contact: float = 30.0
    unloading_factor: float = 2.0  # steps are so much shorter once the shot rises
    force_tolerance: float = 1.5e-3  # out-of-balance over contact force
    gap_tolerance: float = 2e-4  # a
    slip_speed_m_s: float = 1.0  # below it friction falls off in proportion
    finite_strain: bool = True
    max_iterations: int = 150


@dataclass(frozen=True)
class Throw:
    """One impact: speed along the flight, angle from the surface, Coulomb friction of the sliding contact."""

    speed_m_s: float
    angle_deg: float
    friction: float = 0.0

    @property
    def normal_m_s(self) -> float:
        return self.speed_m_s * math.sin(math.radians(self.angle_deg))

    @property
    def tangential_m_s(self) -> float:
        return 0.0 if self.angle_deg == 90.0 else self.speed_m_s * math.cos(math.radians(self.angle_deg))


@dataclass(frozen=True)
class ObliqueImpact:
    """One solved impact; lengths in R, forces in MPa R^2, times in R/(1 m/s)."""

    throw: Throw
    restitution: float  # of the normal speed
    tangential_out_m_s: float
    spin_out_m_s: float  # times R
    peak_force: float  # normal to the undeformed surface
    duration: float
    energy_error: float
    length: float  # extent along the flight of the contour at zero height
    width: float  # extent across
    front: float  # contour's foremost point from the point first struck
    area: float  # inside the contour
    depth: float
    volume: float  # below zero inside the contour
    pile_front: float  # highest point ahead of the deepest
    pile_rear: float
    iterations: int
    dofs: int
    wall_s: float


def solve_oblique(
    material: Material,
    law: JohnsonCook,
    throws: Sequence[Throw],
    *,
    density_kg_m3: float,
    numerics: ObliqueNumerics = ObliqueNumerics(),
    measure: bool = True,
    progress: Callable[[float, str], None] | None = None,
) -> list[ObliqueImpact]:
    """Solve (or fetch from the cache) ``throws`` on virgin ``material``, one after another on one mesh.

    measure: False leaves the dimple's sizes nan (an elastic target keeps none).
    Raises InputError (angle outside 15-90 degrees, a law with backstresses), SolverFailed, NotConverged.
    """
    problems = [
        f"angle_deg = {t.angle_deg:g}: must be 15 to 90" for t in throws if not 15.0 <= t.angle_deg <= 90.0
    ]
    problems += [f"speed_m_s = {t.speed_m_s:g}: must be positive" for t in throws if not t.speed_m_s > 0.0]
    problems += [f"friction = {t.friction:g}: must be 0 to 1" for t in throws if not 0.0 <= t.friction <= 1.0]
    table = law_table(material.E_Pa, material.nu, law)
    if any(table[7:11]):
        problems.append("law: backstresses are not turned at finite strain; take one without")
    if problems:
        raise InputError(problems)
    scales = [_scale(table, law, density_kg_m3, t.normal_m_s) for t in throws]
    # Where the leading edge comes to lie: one radius and the slide, of which 1.4 times that of the loading time were seen.
    front = max(1.2 + 0.75 * 2.0 * t.tangential_m_s * s.duration / CONTACT_OVER_LOADING / s.radius
                for t, s in zip(throws, scales, strict=True))  # fmt: skip
    n = numerics.elements_per_radius
    parameters = [*_parameters(table, density_kg_m3, numerics),
                  Parameter("real", "fineFront", math.ceil(front * n) / n, "a, how far ahead the fine mesh reaches")]
    loads = [
        [1.0 / s.radius, t.tangential_m_s, t.normal_m_s, t.friction, s.duration / s.radius]
        for t, s in zip(throws, scales, strict=True)
    ]
    text = write_driver(f"Oblique impacts on {material.key}", parameters,
                        [f"points_small_{kernel_flavour()}.idp", "oblique_impact.edp"], loads,
                        "shot radius a, tangential, normal speed m/s, friction, expected contact time a/(1 m/s)")  # fmt: skip

    def make(folder: Path) -> None:
        driver = folder / "driver.edp"
        driver.write_text(text)
        run_freefem(
            driver, cwd=folder, log=folder / "freefem.log", status=folder / "status", on_line=relay(progress)
        )
        _check(folder)

    folder, _ = cached_folder("oblique", content_key({"driver": text}, _SOURCES), make)
    return _read(folder, throws, [s.radius for s in scales], measure)


def _scale(table, law, density_kg_m3: float, normal_m_s: float):
    flow_stress = law.flow_stress_Pa(REPRESENTATIVE_STRAIN) * 1e-6
    return expected_impact(table[0], table[1], flow_stress, density_kg_m3 * 1e-6, normal_m_s)


def _parameters(table, density_kg_m3: float, numerics: ObliqueNumerics) -> list[Parameter]:
    return [
        Parameter("string", "outDir", ".", "folder of the results"),
        Parameter("string", "statusFile", "status", "written last"),
        Parameter("real[int]", "law", table, "E nu | A B n | Q b | X1 g1 X2 g2, stresses in MPa"),
        Parameter("int", "finiteStrain", int(numerics.finite_strain), "1; 0: small strain, contact on the deformed surface"),
        Parameter("real", "shotDensity", density_kg_m3 * 1e-6, "1e6 kg/m3"),
        Parameter("int", "elementsPerRadius", numerics.elements_per_radius, "cubes of six tetrahedra per expected radius"),
        Parameter("int", "shells", numerics.shells, "around the box of cubes"),
        Parameter("real", "stepsPerContact", numerics.steps_per_contact, "per expected contact time"),
        Parameter("real", "unloadingFactor", numerics.unloading_factor, "shorter steps when the shot rises"),
        Parameter("real", "forceTolerance", numerics.force_tolerance, "out-of-balance over contact force"),
        Parameter("real", "gapTolerance", numerics.gap_tolerance, "a"),
        Parameter("real", "slipSpeed", numerics.slip_speed_m_s, "m/s, below it friction falls off in proportion"),
        Parameter("int", "maxIterations", numerics.max_iterations, "per step"),
    ]  # fmt: skip


def _check(folder: Path) -> None:
    result = read_table(folder / "result.csv")
    worst = result["energy_error"].max()
    if not worst <= ENERGY_ERROR_LIMIT:
        raise NotConverged("an oblique impact is not to be trusted", log=folder / "freefem.log", advice="more steps",
                           cause=f"energy balance off by {worst:.2%} (limit {ENERGY_ERROR_LIMIT:.1%})")  # fmt: skip


def _read(folder: Path, throws: Sequence[Throw], radii: Sequence[float], measure: bool) -> list[ObliqueImpact]:
    result, surface = read_table(folder / "result.csv"), read_table(folder / "surface.csv")
    out = []
    for k, (throw, a) in enumerate(zip(throws, radii, strict=True)):
        mine = surface["run"] == k
        x, y, u, v, z = (surface[name][mine] for name in ("x", "y", "u_x", "u_y", "u_z"))
        got = {name: float(column[k]) for name, column in result.items()}
        shape = measure_dimple(x + u, y + v, z) if measure else dict.fromkeys(_SIZES, math.nan)
        out.append(ObliqueImpact(
            throw=throw, restitution=got["vz_out"] / got["vz_in"], tangential_out_m_s=got["vx_out"],
            spin_out_m_s=got["spin_out"] / a, peak_force=got["peak_force"] * a**2, duration=got["duration"] * a,
            energy_error=got["energy_error"], **{name: value * a ** _POWER.get(name, 1) for name, value in shape.items()},
            iterations=int(got["iterations"]), dofs=int(got["dofs"]), wall_s=got["wall_s"],
        ))  # fmt: skip
    return out


_SIZES = ("length", "width", "front", "area", "depth", "volume", "pile_front", "pile_rear")
_POWER = {"area": 2, "volume": 3}  # of a; the others 1


def measure_dimple(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> dict[str, float]:
    """Size of the dimple in half a deformed surface: nodes (n,) of y >= 0, any unit of length of the order of its radius.

    The surface between the nodes is a C1 cubic; on rays from the middle of the dimple the contour is where the height
    first passes zero.  Keys: length, width, front (from x = 0), area, depth, volume, pile_front, pile_rear.
    Raises NotConverged when a ray finds no edge.
    """
    near = np.hypot(x, y) < 1.5 * _REACH
    x, y, z = x[near], y[near], z[near]
    above = y > 1e-9
    height = CloughTocher2DInterpolator(np.column_stack([np.r_[x, x[above]], np.r_[y, -y[above]]]), np.r_[z, z[above]])
    line = np.linspace(-2.0, 4.5, 2601)
    profile = height(line, np.zeros_like(line))
    deepest = int(np.nanargmin(profile))
    low, high = (_crossing(line, profile, deepest, step) for step in (-1, 1))
    middle = 0.5 * (low + high)
    angle = np.pi * (np.arange(_RAYS) + 0.5) / _RAYS
    radius = np.linspace(0.0, _REACH, 401)
    grid = height(middle + np.outer(np.cos(angle), radius), np.outer(np.sin(angle), radius))
    edge, volume = np.empty(_RAYS), 0.0
    for k, ray in enumerate(grid):
        edge[k] = _crossing(radius, ray, 0, 1)
        inside = radius < edge[k]
        r, below = np.r_[radius[inside], edge[k]], np.r_[-ray[inside], 0.0]
        volume += np.trapezoid(below * r, r) * 2.0 * np.pi / _RAYS
    ahead, behind = profile[line > high], profile[line < low]
    return {
        "length": high - low, "width": 2.0 * float((edge * np.sin(angle)).max()), "front": high,
        "area": float(np.mean(edge**2)) * np.pi, "depth": float(-np.nanmin(profile)), "volume": float(volume),
        "pile_front": float(np.nanmax(ahead)), "pile_rear": float(np.nanmax(behind)),
    }  # fmt: skip


def _crossing(at: np.ndarray, values: np.ndarray, start: int, step: int) -> float:
    """Where ``values`` first rise through zero going from index ``start`` by ``step``."""
    i = start
    while 0 <= i + step < len(values) and np.isfinite(values[i + step]):
        if values[i] < 0.0 <= values[i + step]:
            return float(at[i] + (at[i + step] - at[i]) * values[i] / (values[i] - values[i + step]))
        i += step
    raise NotConverged("an oblique impact left no dimple with an edge", cause="the surface does not rise to its old height",
                       advice="a higher speed: below the yield speed the target only springs")  # fmt: skip
