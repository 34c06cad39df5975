"""The dimple library of one material: everything of an impact as a curve over the speed, in units of the shot.

Curves are monotone splines in logarithms with a stated error and do not extrapolate (``glue.target.speeds``).  A
library for rigid shots on a quasi-static target without a rate term serves every shot: sizes scale exactly, and of
density and speed only density x speed^2 counts.  Target inertia or an elastic shot tie it to one density, a strain
rate to one shot; then it refuses others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property

import numpy as np

from glue.errors import InputError
from glue.scene.model import Material
from glue.target.dimple import Dimple, edge_peeq, largest_peeq, tabulated, to_si, zero_height_radius
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import ReducedImpact
from glue.target.speeds import Curve, solve_speeds, spaced

# name: (unit, what of the impact); energies are shares of the shot's kinetic energy
_QUANTITIES: dict[str, tuple[str, Callable[[ReducedImpact], float]]] = {
    "radius": ("R", zero_height_radius),
    "depth": ("R", lambda i: float(-i.surface_z[0])),
    "restitution": ("", lambda i: i.restitution),
    "peak_force": ("MPa R2", lambda i: i.peak_force),
    "contact_time": ("R/(1 m/s)", lambda i: i.duration),
    "plastic_energy": ("of the shot's", lambda i: i.energy.plastic / i.energy.initial),
    "elastic_energy": ("of the shot's, left in the target", lambda i: i.energy.elastic / i.energy.initial),
    "largest_peeq": ("", largest_peeq),
}
FITTED = ("radius", "depth", "restitution")  # those whose error is held against a limit


@dataclass(frozen=True)
class Library:
    """Impacts of ``material`` at rising speeds, and curves through them."""

    material: Material
    speeds_m_s: tuple[float, ...]
    impacts: tuple[ReducedImpact, ...]
    density_kg_m3: float
    elements_per_radius: int
    physics: ImpactPhysics

    @cached_property
    def curves(self) -> dict[str, Curve]:
        """A curve of every quantity (keys of ``as_dict()["columns"]``)."""
        return {name: Curve(name, self.speeds_m_s, self.column(name)) for name in _QUANTITIES}

    def column(self, name: str) -> np.ndarray:
        """The solved values of a quantity, (n,)."""
        return np.array([_QUANTITIES[name][1](impact) for impact in self.impacts])

    def speed_for(self, speed_m_s, density_kg_m3: float | None = None, radius_m: float | None = None):
        """Speed of the library at which a shot of this density and radius leaves the same dimple in radii.

        Raises InputError where the library does not hold for such a shot.
        """
        physics = self.physics
        if physics.rate and radius_m is not None and abs(radius_m / physics.radius_m - 1.0) > 1e-9:
            raise InputError(
                f"a rate-dependent library belongs to its shot: radius {radius_m:g} m asked for, allowed {physics.radius_m:g} m"
            )
        if density_kg_m3 is None or density_kg_m3 == self.density_kg_m3:
            return speed_m_s
        if physics.rate or physics.inertia or physics.elastic_shot is not None:
            raise InputError(
                f"a library with a strain rate, target inertia or an elastic shot holds for one density:"
                f" {density_kg_m3:g} kg/m3 asked for, allowed {self.density_kg_m3:g} kg/m3"
            )
        return np.asarray(speed_m_s, dtype=float) * np.sqrt(density_kg_m3 / self.density_kg_m3)

    def at(self, name: str, speed_m_s, density_kg_m3: float | None = None, radius_m: float | None = None) -> np.ndarray:
        """A quantity in the units of its column at ``speed_m_s`` (any shape).  Raises InputError outside the table."""
        return self.curves[name](self.speed_for(speed_m_s, density_kg_m3, radius_m))

    def profile(self, speed_m_s: float, density_kg_m3: float | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The dimple's profile (r, z) [R] at ``speed_m_s`` from the two solved speeds beside it.

        Their profiles, r over the dimple's radius and z over its depth, are mixed by the logarithm of the speed.
        """
        v = float(self.speed_for(speed_m_s, density_kg_m3))
        radius, depth = (float(self.curves[name](v)) for name in ("radius", "depth"))
        k = int(np.clip(np.searchsorted(self.speeds_m_s, v), 1, len(self.speeds_m_s) - 1))
        low, high = self.speeds_m_s[k - 1 : k + 1]
        share = np.log(v / low) / np.log(high / low)
        r = np.linspace(0.0, 4.0, 401)
        z = np.zeros_like(r)
        for weight, j in ((1.0 - share, k - 1), (share, k)):
            impact = self.impacts[j]
            z += weight * np.interp(
                r, impact.surface_r / zero_height_radius(impact), impact.surface_z / -impact.surface_z[0]
            )
        return r * radius, z * depth

    def impact_at(self, speed_m_s: float, progress=None) -> ReducedImpact:
        """All fields at any speed of the library's density, solved for it unless they were before."""
        return solve_speeds(
            self.material, [speed_m_s], density_kg_m3=self.density_kg_m3, elements_per_radius=self.elements_per_radius,
            physics=self.physics, progress=progress,
        )[0]  # fmt: skip

    def dimple(self, speed_m_s: float, diameter_m: float) -> Dimple:
        """The dimple at one of the library's speeds, with all of them as its table, in SI units."""
        if speed_m_s not in self.speeds_m_s:
            impact = self.impact_at(speed_m_s)
            exponents = self.curves["radius"].exponent(), -self.curves["restitution"].exponent()
            return to_si(impact, speed_m_s, self.density_kg_m3, diameter_m, exponents, impact.wall_s)
        runs = dict(zip(self.speeds_m_s, self.impacts, strict=True))
        return tabulated(runs, self.material, speed_m_s, self.density_kg_m3, diameter_m, self.physics)

    def as_dict(self) -> dict:
        """Plain values for JSON."""
        return {
            "schema": 1,
            "kind": "dimple library",
            "material": self.material.key,
            "density_kg_m3": self.density_kg_m3,
            "elements_per_radius": self.elements_per_radius,
            "physics": asdict(self.physics),
            "speed_m_s": list(self.speeds_m_s),
            "units": {name: unit for name, (unit, _) in _QUANTITIES.items()},
            "columns": {name: self.column(name).tolist() for name in _QUANTITIES},
            "edge_peeq": [edge_peeq(i, zero_height_radius(i)) for i in self.impacts],
            "energy_error": [i.energy_error for i in self.impacts],
            "wall_s": [i.wall_s for i in self.impacts],
            "error": {name: float(curve.error) for name, curve in self.curves.items()},
            "exponent": {name: self.curves[name].exponent() for name in FITTED},
        }


def build_library(
    material: Material,
    slowest_m_s: float,
    fastest_m_s: float,
    points: int,
    *,
    density_kg_m3: float,
    elements_per_radius: int,
    physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
    jobs: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Library:
    """Solve ``points`` speeds in equal ratios, ``jobs`` at a time; what was solved before comes from the cache.

    Raises InputError for a range or a number of points that make no curve, SolverFailed, NotConverged (a speed at which
    nothing yields among them, named in a note).
    """
    if not 0.0 < slowest_m_s < fastest_m_s or points < 3:
        raise InputError(f"speeds {slowest_m_s:g}:{fastest_m_s:g} in {points} points: allowed rising, 3 and more points")
    speeds = spaced(slowest_m_s, fastest_m_s, points)
    impacts = solve_speeds(
        material, speeds, density_kg_m3=density_kg_m3, elements_per_radius=elements_per_radius, physics=physics,
        jobs=jobs, progress=progress,
    )  # fmt: skip
    return Library(material, tuple(speeds), tuple(impacts), density_kg_m3, elements_per_radius, physics)
