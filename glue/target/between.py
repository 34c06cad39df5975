"""Dimples and layer shapes at any speed between solved ones: scenes that differ in speed, angle or diameter then share impacts.

Impacts are solved at powers of a ratio, at an equal density of the shot wherever only density x speed^2 counts, so that
every scene with a material finds them in the cache.  Between two of them numbers go along the library's curves
(``glue.target.library``) and profiles are mixed by the logarithm of the speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from glue.errors import NotConverged
from glue.scene.model import Material
from glue.target.dimple import Dimple, edge_peeq, no_dimple, scaling_limits, tied_to_density, to_si, zero_height_radius
from glue.target.layers import LayerShape, layer_shape
from glue.target.library import Library
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import Numerics, copy_record, solve_reduced
from glue.target.speeds import solve_speeds

# Of neighbouring speeds.  Half way between, on 2024 and 4340 at a/3: radius and depth within .1 %, restitution .6 %, peak
# force .8 %, largest layer stress 1.5 %, most of it that mesh's scatter: .05, .3, .5 and .6 % at a/6 (make bench-dimple).
RATIO = math.sqrt(2.0)
DENSITY_KG_M3 = 7800.0  # of the shot of shared impacts: steel's, so that most scenes' speeds are their own


def grid(slowest_m_s: float, fastest_m_s: float, ratio: float = RATIO) -> list[float]:
    """Powers of ``ratio`` that enclose the range, rising; one alone where both ends are it.

    Rounded to 9 digits: cache entries for good.
    """
    first = math.floor(math.log(slowest_m_s) / math.log(ratio) + 1e-9)
    last = math.ceil(math.log(fastest_m_s) / math.log(ratio) - 1e-9)
    return [float(f"{ratio**k:.9g}") for k in range(first, last + 1)]


def shared_density_kg_m3(physics: ImpactPhysics, density_kg_m3: float) -> float:
    """Density of the shot for which impacts are solved: its own where more than density x speed^2 counts."""
    return density_kg_m3 if tied_to_density(physics) else DENSITY_KG_M3


def shared_speeds_m_s(
    slowest_m_s: float, fastest_m_s: float, density_kg_m3: float, physics: ImpactPhysics, ratio: float = RATIO
) -> list[float]:
    """Speeds to solve, at ``shared_density_kg_m3``, for shots of ``density_kg_m3`` at ``slowest_m_s`` to ``fastest_m_s``."""
    faster = math.sqrt(density_kg_m3 / shared_density_kg_m3(physics, density_kg_m3))
    return grid(faster * slowest_m_s, faster * fastest_m_s, ratio)


def solve_dimple_between(
    material: Material,
    *,
    speed_m_s: float,
    slowest_m_s: float,
    fastest_m_s: float,
    density_kg_m3: float,
    diameter_m: float,
    elements_per_radius: int,
    workdir: Path,
    steps_per_contact: float = Numerics.steps_per_contact,
    physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
    ratio: float = RATIO,
    jobs: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Dimple:
    """As ``glue.target.dimple.solve_dimple``, from impacts at shared speeds; its table spans ``slowest_m_s`` to ``fastest_m_s``.

    ``workdir`` receives drivers and logs of the impacts beside ``speed_m_s``.  The section is the nearest solved
    impact's, stretched to the dimple's radius.  Raises SolverFailed, NotConverged.
    """
    speeds = shared_speeds_m_s(slowest_m_s, fastest_m_s, density_kg_m3, physics, ratio)
    density = shared_density_kg_m3(physics, density_kg_m3)
    impacts = solve_speeds(
        material, speeds, density_kg_m3=density, elements_per_radius=elements_per_radius, physics=physics,
        numerics=Numerics(steps_per_contact=steps_per_contact), jobs=jobs, progress=progress,
    )  # fmt: skip
    least = shared_speeds_m_s(speed_m_s, speed_m_s, density_kg_m3, physics, ratio)[0]
    left = []
    for speed, impact in zip(speeds, impacts, strict=True):
        try:
            zero_height_radius(impact)
        except NotConverged as problem:
            if speed >= least:  # a slower one that only springs is no failure
                raise no_dimple(problem, material, density_kg_m3) from None
            continue
        left.append((speed, impact))
    library = Library(
        material, tuple(speed for speed, _ in left), tuple(impact for _, impact in left), density, elements_per_radius, physics
    )
    faster = math.sqrt(density_kg_m3 / density)
    for speed, impact in left:
        if abs(math.log(speed / (faster * speed_m_s))) < math.log(ratio):
            copy_record(impact, workdir, f"impact-{speed:g}")
    return dimple_between(library, speed_m_s, density_kg_m3, diameter_m)


def dimple_between(library: Library, speed_m_s: float, density_kg_m3: float, diameter_m: float) -> Dimple:
    """The dimple of this shot, with the whole library as its table.  Raises InputError outside the library's speeds."""
    R, faster = 0.5 * diameter_m, math.sqrt(density_kg_m3 / library.density_kg_m3)
    solved, v = np.asarray(library.speeds_m_s), faster * speed_m_s
    radius, depth, e, force, duration, largest = (
        float(library.at(name, v))
        for name in ("radius", "depth", "restitution", "peak_force", "contact_time", "largest_peeq")
    )
    own_place = np.isclose(solved, v, rtol=1e-9, atol=0.0)
    table = np.where(own_place, v, solved) if own_place.any() else np.sort(np.append(solved, v))
    table = np.clip(table, solved[0], solved[-1])  # a speed that is an end but for rounding
    table_radius, table_e = library.at("radius", table), library.at("restitution", table)
    here = int(np.argmin(np.abs(table - v)))
    low, high = (here - 1, here) if here else (0, 1)
    step = math.log(table[high] / table[low])
    exponents = math.log(table_radius[high] / table_radius[low]) / step, math.log(table_e[low] / table_e[high]) / step
    place = float(np.interp(math.log(v), np.log(solved), np.arange(solved.size)))
    below, above = (library.impacts[int(k)] for k in (math.floor(place), math.ceil(place)))

    def mixed(of: Callable) -> float:
        return float(of(below) + place % 1.0 * (of(above) - of(below)))

    r, z = library.profile(v)
    speed = table / faster
    speed[here] = speed_m_s
    nearest = math.floor(place + 0.5)
    near = to_si(library.impacts[nearest], speed_m_s, density_kg_m3, diameter_m, exponents, 0.0)
    stretch = radius * R / near.radius_m
    return replace(
        near, radius_m=radius * R, depth_m=depth * R, crest_radius_m=float(r[np.argmax(z)]) * R, restitution=e,
        peak_force_N=force * 1e6 * R**2, contact_time_s=duration * R * faster, largest_peeq=largest,
        edge_peeq=mixed(lambda i: edge_peeq(i, zero_height_radius(i))), energy_error=max(below.energy_error, above.energy_error),
        dofs=max(below.dofs, above.dofs), wall_s=sum(impact.wall_s for impact in library.impacts),
        profile_r_m=r * R, profile_z_m=z * R, layer_depth_m=near.layer_depth_m * stretch, points_m=near.points_m * stretch,
        section_speed_m_s=float(solved[nearest] / faster), table_speed_m_s=speed, table_radius_m=table_radius * R, table_restitution=table_e,
        centre_pressure_Pa=1e6 * mixed(lambda i: i.centre_pressure), mean_pressure_Pa=1e6 * mixed(lambda i: i.mean_pressure),
        **scaling_limits(library.physics, library.material),
    )  # fmt: skip


def layer_shape_between(
    material: Material,
    dimple: Dimple,
    *,
    elements_per_radius: int,
    ratio: float = RATIO,
    progress: Callable[[float, str], None] | None = None,
) -> LayerShape:
    """The layer model's one impact (``glue.target.layers``) for ``dimple``, between those at shared speeds.

    Raises SolverFailed, NotConverged.
    """
    # As the layer model itself solves it: without physics beside the law.
    speeds = shared_speeds_m_s(dimple.speed_m_s, dimple.speed_m_s, dimple.density_kg_m3, ImpactPhysics(), ratio)
    faster = math.sqrt(dimple.density_kg_m3 / DENSITY_KG_M3)
    shapes = []
    for speed in speeds:
        impact = solve_reduced(
            material, material.combined, speed_m_s=speed, density_kg_m3=DENSITY_KG_M3,
            elements_per_radius=elements_per_radius, progress=progress,
        )  # fmt: skip
        radius_R = float(dimple.radius_for(dimple.diameter_m, speed / faster)) / (0.5 * dimple.diameter_m)
        shapes.append(layer_shape(impact, material.combined, radius_R))
    return mixed_shape(speeds, shapes, faster * dimple.speed_m_s, dimple.radius_m / (0.5 * dimple.diameter_m))


def mixed_shape(speeds_m_s: list[float], shapes: list[LayerShape], speed_m_s: float, radius_R: float) -> LayerShape:
    """One shape, or two mixed by the logarithm of the speed, for a dimple of ``radius_R`` shot radii."""
    low, high = shapes[0], shapes[-1]
    ends = np.log(speeds_m_s)
    share = 0.0 if ends.size == 1 else float(np.clip((math.log(speed_m_s) - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0))
    s, p, h = ((1.0 - share) * getattr(low, name) + share * getattr(high, name) for name in ("s_Pa", "p", "h"))
    return LayerShape(low.zeta, s, p, h, radius_R)
