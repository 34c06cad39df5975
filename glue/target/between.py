"""Dimples and layer shapes at any speed between solved ones: a study over the speed then solves no impact anew.

Impacts are solved on a fixed grid of speeds, a factor of root two apart, so that every study of a material shares them.
Between two of them numbers go along the library's curves (``glue.target.library``) and profiles are mixed by the logarithm
of the speed.  Holds for a rigid shot on a quasi-static target without a rate term, whose dimple in radii depends on
density x speed^2 alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from glue.errors import InputError, NotConverged
from glue.scene.model import Material
from glue.target.dimple import Dimple, edge_peeq, zero_height_radius
from glue.target.layers import LayerShape, layer_shape
from glue.target.library import Library
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import Numerics, solve_reduced
from glue.target.speeds import solve_speeds

# Of neighbouring speeds.  Against impacts solved at five speeds between, 24 to 88 m/s on 2024 at a/3: radius within .15 %,
# depth .1 %, dent's volume .4 %, restitution .8 %, peak force 1 %, largest layer stress .03 %.
RATIO = math.sqrt(2.0)
_CURVES = ("radius", "depth", "restitution", "peak_force", "contact_time", "largest_peeq")


@dataclass(frozen=True)
class Between:
    """``library``: impacts of the single-impact law; ``shapes``: (speed, layer shape) of the bounded law, by rising speed."""

    library: Library
    shapes: tuple[tuple[float, LayerShape], ...]

    def serves(self, physics: ImpactPhysics) -> bool:
        """Does it hold for impacts of this physics?"""
        return physics == self.library.physics

    def dimple(self, speed_m_s: float, diameter_m: float, density_kg_m3: float) -> Dimple:
        """The dimple of this shot with the whole library as its table; without the fields of a section.

        Raises InputError outside the library's speeds.
        """
        own, R = self.library, 0.5 * diameter_m
        heavier = math.sqrt(density_kg_m3 / own.density_kg_m3)
        at = {name: float(own.at(name, heavier * speed_m_s)) for name in _CURVES}
        solved = np.asarray(own.speeds_m_s)
        table = np.unique(np.append(solved, float(np.clip(heavier * speed_m_s, solved[0], solved[-1]))))
        radius, e = own.at("radius", table), own.at("restitution", table)
        r, z = own.profile(heavier * speed_m_s)
        here = int(np.searchsorted(table, heavier * speed_m_s * (1.0 - 1e-12)))
        low, high = (here - 1, here) if here else (0, 1)
        step = math.log(table[high] / table[low])
        place = float(np.interp(math.log(heavier * speed_m_s), np.log(solved), np.arange(solved.size)))
        near = [own.impacts[int(k)] for k in (math.floor(place), math.ceil(place))]
        beside = np.array([[i.centre_pressure, i.mean_pressure, edge_peeq(i, zero_height_radius(i))] for i in near])
        centre, mean, edge = map(float, beside[0] + place % 1.0 * (beside[1] - beside[0]))
        speed = table / heavier
        speed[here] = speed_m_s
        return Dimple(
            radius_m=at["radius"] * R, depth_m=at["depth"] * R, crest_radius_m=float(r[np.argmax(z)]) * R,
            restitution=at["restitution"], peak_force_N=at["peak_force"] * 1e6 * R**2,
            contact_time_s=at["contact_time"] * R * heavier, speed_m_s=float(speed_m_s), diameter_m=float(diameter_m),
            density_kg_m3=float(density_kg_m3), speed_exponent=float(math.log(radius[high] / radius[low]) / step),
            restitution_exponent=float(math.log(e[low] / e[high]) / step), edge_peeq=edge,
            largest_peeq=at["largest_peeq"], energy_error=max(i.energy_error for i in near), dofs=max(i.dofs for i in near),
            wall_s=0.0, profile_r_m=r * R, profile_z_m=z * R, layer_depth_m=np.empty(0), layer_stress_Pa=np.empty(0),
            points_m=np.empty((0, 2)), triangles=np.empty((0, 3), int), peeq=np.empty(0), sigma_rr_Pa=np.empty(0),
            table_speed_m_s=speed, table_radius_m=radius * R, table_restitution=e,
            centre_pressure_Pa=1e6 * centre, mean_pressure_Pa=1e6 * mean,
        )  # fmt: skip

    def layer_shape(self, speed_m_s: float, density_kg_m3: float) -> LayerShape:
        """The layer model's one impact at this speed.  Raises InputError outside the speeds of ``shapes``."""
        v = math.sqrt(density_kg_m3 / self.library.density_kg_m3) * speed_m_s
        speeds = [speed for speed, _ in self.shapes]
        if not speeds or not speeds[0] * (1 - 1e-9) <= v <= speeds[-1] * (1 + 1e-9):
            allowed = f"{speeds[0]:g} to {speeds[-1]:g} m/s" if speeds else "none, for none was solved"
            raise InputError(f"layer shape at {v:g} m/s: allowed {allowed}")
        k = int(np.clip(np.searchsorted(speeds, v), 1, len(speeds) - 1))
        (low, a), (high, b) = self.shapes[k - 1 : k + 1]
        share = float(np.clip(math.log(v / low) / math.log(high / low), 0.0, 1.0))
        s, p, h = ((1.0 - share) * getattr(a, name) + share * getattr(b, name) for name in ("s_Pa", "p", "h"))
        return LayerShape(a.zeta, s, p, h, float(self.library.at("radius", v)))


def grid(slowest_m_s: float, fastest_m_s: float) -> list[float]:
    """Powers of RATIO that enclose the range, at least two.  Rounded to 9 digits: cache entries for good."""
    first = math.floor(math.log(slowest_m_s) / math.log(RATIO) + 1e-9)
    last = max(math.ceil(math.log(fastest_m_s) / math.log(RATIO) - 1e-9), first + 1)
    return [float(f"{RATIO**k:.9g}") for k in range(first, last + 1)]


def solve_between(
    material: Material,
    slowest_m_s: float,
    nominal_m_s: tuple[float, float],
    fastest_m_s: float,
    *,
    density_kg_m3: float,
    elements_per_radius: int,
    steps_per_contact: float,
    physics: ImpactPhysics,
    layers: bool,
    jobs: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Between:
    """Solve, or fetch from the cache, all that is needed for speeds ``slowest_m_s`` to ``fastest_m_s``.

    nominal_m_s: the range of speeds at which dimples and layer shapes (only with ``layers``) are asked for; slower ones
    that leave no dimple are left out.  Raises InputError for physics that ties a dimple to one shot, SolverFailed,
    NotConverged.
    """
    if physics.rate or physics.inertia or physics.elastic_shot is not None:
        raise InputError("strain_rate, target_inertia, elastic_shot: tie a dimple to one shot; allowed: without them")
    speeds = grid(slowest_m_s, fastest_m_s)
    numerics = Numerics(steps_per_contact=steps_per_contact)
    impacts = solve_speeds(
        material, speeds, density_kg_m3=density_kg_m3, elements_per_radius=elements_per_radius, physics=physics,
        numerics=numerics, jobs=jobs, progress=progress,
    )  # fmt: skip
    least = grid(*nominal_m_s)[0]
    dented = []
    for speed, impact in zip(speeds, impacts, strict=True):
        try:
            zero_height_radius(impact)
            dented.append((speed, impact))
        except NotConverged:
            if speed >= least:
                raise
    library = Library(
        material, tuple(s for s, _ in dented), tuple(i for _, i in dented), density_kg_m3, elements_per_radius, physics
    )
    shapes = []
    for k, speed in enumerate(nominal := grid(*nominal_m_s) if layers else []):
        if progress:
            progress(k / len(nominal), f"{k} of {len(nominal)} speeds, bounded law")
        # As the layer model itself solves it: without physics beside the law.
        impact = solve_reduced(
            material, material.combined, speed_m_s=speed, density_kg_m3=density_kg_m3, elements_per_radius=elements_per_radius
        )
        shapes.append((speed, layer_shape(impact, material.combined, float(library.at("radius", speed)))))
    return Between(library, tuple(shapes))
