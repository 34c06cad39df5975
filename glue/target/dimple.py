"""The representative dimple: a finite-element impact in SI units, and a table of slower and faster ones beside it.

A rate-free material scales exactly with the diameter, and for a rigid shot on a quasi-static target radius over
diameter depends on density x speed^2 alone; where that is not so, the dimple refuses to be scaled.  Over the normal
speed radius and restitution are monotone curves through the table, in logarithms (radius about v^.47 for steel on
2024; restitution v^-.13 at 1 m/s, v^-.25 at 100: no power law).
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError, NotConverged
from glue.scene.model import Material
from glue.target.physics import FIRST_YIELD, ImpactPhysics
from glue.target.reduced_impact import Numerics, ReducedImpact, copy_record
from glue.target.speeds import Curve, outside, solve_speeds
from glue.theory import hertz

STRESS_DISC = (
    0.44  # layer stresses are means over a disc of this many dimple radii (r < .1 mm of the reference)
)
_SCHEMA = 3
RATE_TOLERANCE = 0.005  # of the flow stress: so far other diameters may move a rate-dependent target's


@dataclass(frozen=True)
class Dimple:
    """One dimple.  Sections run outwards from the axis; depths are those of the undeformed material."""

    radius_m: float  # where the profile crosses the undeformed surface
    depth_m: float
    crest_radius_m: float
    restitution: float
    peak_force_N: float
    contact_time_s: float
    speed_m_s: float
    diameter_m: float
    density_kg_m3: float
    speed_exponent: float  # radius ~ speed^exponent
    restitution_exponent: float  # restitution ~ speed^-exponent
    edge_peeq: float  # equivalent plastic strain just under the surface at the dimple's edge
    largest_peeq: float
    energy_error: float
    dofs: int
    wall_s: float
    profile_r_m: np.ndarray  # (n,) deformed surface
    profile_z_m: np.ndarray  # (n,) < 0 in the dent, > 0 in the pile-up
    layer_depth_m: np.ndarray  # (m,)
    layer_stress_Pa: np.ndarray  # (m,) radial stress, mean over STRESS_DISC
    points_m: np.ndarray  # (3 k, 2) deformed corners of the section's triangles (r, z)
    triangles: np.ndarray  # (k, 3)
    peeq: np.ndarray  # (k,)
    sigma_rr_Pa: np.ndarray  # (k,)
    table_speed_m_s: np.ndarray = field(default_factory=lambda: np.empty(0))  # (t,) rising, speed_m_s among them
    table_radius_m: np.ndarray = field(default_factory=lambda: np.empty(0))  # (t,)
    table_restitution: np.ndarray = field(default_factory=lambda: np.empty(0))  # (t,)
    only_this_density: bool = False  # target inertia, an elastic shot or a rate: not density x speed^2 alone
    largest_size_ratio: float = np.inf  # of diameters to this one and back, so far the table may be scaled
    centre_pressure_Pa: float = 0.0  # over the inner half of the contact at peak force
    mean_pressure_Pa: float = 0.0
    section_speed_m_s: float = 0.0  # of the solved impact whose section it is, stretched to radius_m; 0: speed_m_s

    def equivalent_speed(self, diameter_m, normal_speed_m_s, density_kg_m3=None) -> np.ndarray:
        """Speed [m/s] at which a shot of the dimple's density leaves the same dimple (in radii); 0 for none.

        Raises InputError for a size or density to which this dimple cannot be scaled.
        """
        speed = np.maximum(np.asarray(normal_speed_m_s, dtype=float), 0.0)
        ratio = np.asarray(diameter_m, dtype=float) / self.diameter_m
        if np.maximum(ratio, 1.0 / ratio).max(initial=1.0) > self.largest_size_ratio * (1 + 1e-9):
            raise InputError(
                f"strain_rate: a rate-dependent dimple of {self.diameter_m:g} m belongs to its diameter; allowed within a"
                f" factor {self.largest_size_ratio:.3g}, which changes the flow stress by {RATE_TOLERANCE:.1%}"
            )
        if density_kg_m3 is None:
            return speed
        heavier = np.asarray(density_kg_m3, dtype=float) / self.density_kg_m3
        if self.only_this_density and (abs(heavier - 1.0) > 1e-6).any():
            raise InputError(
                "strain_rate, target_inertia and elastic_shot make the dimple depend on the shot's density by itself:"
                f" allowed {self.density_kg_m3:g} kg/m3, the reference shot's"
            )
        return speed * np.sqrt(heavier)

    @cached_property
    def radius_curve(self) -> Curve:
        return Curve("dimple radius", self.table_speed_m_s, self.table_radius_m)

    def beyond_table(self, diameter_m, normal_speed_m_s, density_kg_m3=None) -> np.ndarray:
        """Which impacts are slower or faster than any that was solved: their dimples are extrapolated by power laws."""
        speed = self.equivalent_speed(diameter_m, normal_speed_m_s, density_kg_m3)
        return outside(speed, self.table_speed_m_s) if self.table_speed_m_s.size else speed != self.speed_m_s

    def radius_for(self, diameter_m, normal_speed_m_s, density_kg_m3=None):
        """Dimple radius [m] of a shot of ``diameter_m`` at ``normal_speed_m_s`` (floats or arrays; 0 for none).

        ``density_kg_m3`` of the shot, default the dimple's: as if faster by the root of the densities' ratio.  Beyond
        the table (see ``beyond_table``) power laws with the slopes of its ends; without a table ``speed_exponent``.
        Raises InputError for what ``equivalent_speed`` refuses.
        """
        speed = self.equivalent_speed(diameter_m, normal_speed_m_s, density_kg_m3)
        size = np.asarray(diameter_m, dtype=float) / self.diameter_m
        if self.table_speed_m_s.size > 1:
            return size * self.radius_curve.with_tails(speed)
        return size * self.radius_m * (speed / self.speed_m_s) ** self.speed_exponent

    def save(self, path: Path) -> None:
        """Write all fields to ``path`` (.npz)."""
        with atomic_path(path) as part, open(part, "wb") as f:
            np.savez_compressed(f, schema=_SCHEMA, **{x.name: getattr(self, x.name) for x in fields(self)})

    @classmethod
    def load(cls, path: Path) -> Dimple:
        """Read what ``save`` wrote; raises InputError for a missing file or another schema."""
        try:
            with np.load(path) as data:
                if int(data["schema"]) != _SCHEMA:
                    raise InputError(
                        f"{path}: schema {int(data['schema'])}, this version reads {_SCHEMA}; run the dimple stage again"
                    )
                return cls(
                    **{
                        x.name: data[x.name] if data[x.name].ndim else data[x.name].item()
                        for x in fields(cls)
                    }
                )
        except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile) as problem:
            raise InputError(
                f"{path}: not a dimple of this version ({problem}); run the dimple stage again"
            ) from None


def solve_dimple(
    material: Material,
    *,
    speed_m_s: float,
    density_kg_m3: float,
    diameter_m: float,
    elements_per_radius: int,
    workdir: Path,
    steps_per_contact: float = Numerics.steps_per_contact,
    other_speeds_m_s: Sequence[float] = (),
    physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
    jobs: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Dimple:
    """The dimple of a shot at normal ``speed_m_s`` on ``material`` (its ``single_law``), and its table over the speed.

    The table holds ``speed_m_s`` and ``other_speeds_m_s``, by default half of it; those at which nothing yields are
    left out.  All come from the cache when they were solved before, else ``jobs`` at a time (all cores).  ``workdir``
    receives their drivers and logs.  Raises SolverFailed, NotConverged.
    """
    speeds = sorted({float(speed_m_s), *(float(v) for v in other_speeds_m_s or (0.5 * speed_m_s,))})
    runs = solve_speeds(
        material, speeds, density_kg_m3=density_kg_m3, elements_per_radius=elements_per_radius, physics=physics,
        numerics=Numerics(steps_per_contact=steps_per_contact), jobs=jobs, progress=progress,
    )  # fmt: skip
    nominal = runs[speeds.index(float(speed_m_s))]
    for speed, run in zip(speeds, runs, strict=True):
        copy_record(run, workdir, "impact" if run is nominal else f"impact-{speed:g}")
    return tabulated(dict(zip(speeds, runs, strict=True)), material, float(speed_m_s), density_kg_m3, diameter_m, physics)


def tabulated(
    runs: dict[float, ReducedImpact],
    material: Material,
    speed_m_s: float,
    density_kg_m3: float,
    diameter_m: float,
    physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
) -> Dimple:
    """The dimple of ``runs[speed_m_s]``, with a table of all ``runs`` (by rising speed) that left one."""
    table = []
    for speed, run in runs.items():
        try:
            table.append((speed, zero_height_radius(run), run.restitution))
        except NotConverged as problem:
            if speed >= speed_m_s:  # one that is slower and only springs is no failure, this one's would be
                raise no_dimple(problem, material, density_kg_m3) from None
    if len(table) < 2:
        try:
            zero_height_radius(next(iter(runs.values())))  # raises: the speeds beside it leave no dimple
        except NotConverged as problem:
            raise no_dimple(problem, material, density_kg_m3) from None
    speed, radius, e = (np.array(column) for column in zip(*table, strict=True))
    here = int(np.flatnonzero(speed == speed_m_s)[0])
    slower, faster = (here - 1, here) if here else (0, 1)
    step = np.log(speed[faster] / speed[slower])
    exponents = float(np.log(radius[faster] / radius[slower]) / step), float(np.log(e[slower] / e[faster]) / step)
    wall_s = sum(run.wall_s for run in runs.values())
    nominal = runs[speed_m_s]
    return replace(
        to_si(nominal, speed_m_s, density_kg_m3, diameter_m, exponents, wall_s),
        table_speed_m_s=speed, table_radius_m=radius * 0.5 * diameter_m, table_restitution=e,
        centre_pressure_Pa=nominal.centre_pressure * 1e6, mean_pressure_Pa=nominal.mean_pressure * 1e6,
        **scaling_limits(physics, material),
    )  # fmt: skip


def tied_to_density(physics: ImpactPhysics) -> bool:
    """Does more than density x speed^2 of the shot count?"""
    return physics.rate or physics.inertia or physics.elastic_shot is not None


def scaling_limits(physics: ImpactPhysics, material: Material) -> dict:
    """The fields of a Dimple that say to which other shots it may be scaled."""
    ratio = float(np.exp(RATE_TOLERANCE / material.single_law.C)) if physics.rate else np.inf
    return {"only_this_density": tied_to_density(physics), "largest_size_ratio": ratio}


def first_yield_speed_m_s(material: Material, density_kg_m3: float) -> float:
    """Normal speed at which a rigid shot first makes ``material`` yield: Hertz's largest pressure, which goes by v^(2/5),
    at FIRST_YIELD times the yield stress."""
    modulus = hertz.effective_modulus_Pa(material.E_Pa, material.nu)
    at_one = hertz.impact(1.0, density_kg_m3, 1.0, modulus).peak_pressure_Pa
    return (FIRST_YIELD * material.single_law.flow_stress_Pa(0.0) / at_one) ** 2.5


def no_dimple(problem: NotConverged, material: Material, density_kg_m3: float) -> NotConverged:
    """``problem`` with the speed from which on shots of ``density_kg_m3`` can leave a dimple."""
    least = first_yield_speed_m_s(material, density_kg_m3)
    return NotConverged(problem.what, cause=problem.cause, log=problem.log,
                        advice=f"{problem.advice}; nothing yields below about {least:.3g} m/s, a dent with an edge takes a "
                        "few times that")  # fmt: skip


def to_si(
    impact: ReducedImpact,
    speed_m_s: float,
    density_kg_m3: float,
    diameter_m: float,
    exponents: tuple[float, float],
    wall_s: float,
) -> Dimple:
    """``impact`` for a shot of ``diameter_m``, with what is read off its fields; exponents of radius, restitution."""
    R = 0.5 * diameter_m
    radius = zero_height_radius(impact)
    depth, stress = layer_stress(impact, STRESS_DISC * radius)
    count = len(impact.triangles)
    return Dimple(
        radius_m=radius * R,
        depth_m=float(-impact.surface_z[0]) * R,
        crest_radius_m=float(impact.surface_r[np.argmax(impact.surface_z)]) * R,
        restitution=impact.restitution,
        peak_force_N=impact.peak_force * 1e6 * R**2,
        contact_time_s=impact.duration * R,
        speed_m_s=float(speed_m_s),
        diameter_m=float(diameter_m),
        density_kg_m3=float(density_kg_m3),
        speed_exponent=exponents[0],
        restitution_exponent=exponents[1],
        edge_peeq=edge_peeq(impact, radius),
        largest_peeq=largest_peeq(impact),
        energy_error=impact.energy_error,
        dofs=impact.dofs,
        wall_s=wall_s,
        profile_r_m=impact.surface_r * R,
        profile_z_m=impact.surface_z * R,
        layer_depth_m=depth * R,
        layer_stress_Pa=stress * 1e6,
        points_m=impact.triangles.reshape(-1, 2) * R,
        triangles=np.arange(3 * count).reshape(count, 3),
        peeq=impact.points["peeq"].reshape(count, 3).mean(axis=1),
        sigma_rr_Pa=impact.points["s_rr"].reshape(count, 3).mean(axis=1) * 1e6,
    )


def zero_height_radius(impact: ReducedImpact) -> float:
    """Radius [R] at which the deformed surface first rises through the undeformed one.

    Raises NotConverged when it never does: no dent, one as wide as the block, or one that is only solver noise because
    nothing yielded.
    """
    r, z = impact.surface_r, impact.surface_z
    crossing = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    if z[0] >= 0 or crossing.size == 0 or largest_peeq(impact) == 0.0:
        raise NotConverged(
            "the impact left no dimple with an edge",
            cause=f"height on the axis {z[0]:.2e} R, largest equivalent plastic strain {largest_peeq(impact):.2e}",
            log=impact.log,
            advice="a higher speed: below the yield speed the target only springs",
        )
    i = crossing[0]
    return float(r[i] - z[i] * (r[i + 1] - r[i]) / (z[i + 1] - z[i]))


def largest_peeq(impact: ReducedImpact) -> float:
    """Largest equivalent plastic strain at any Gauss point."""
    return float(impact.points["peeq"].max(initial=0.0))


def layer_stress(
    impact: ReducedImpact, disc_radius: float, levels: int = 80
) -> tuple[np.ndarray, np.ndarray]:
    """Mean radial stress [MPa] over the disc r < ``disc_radius`` [R] against depth [R]: two arrays (levels,).

    The stress is interpolated linearly between Gauss points, mirrored at the axis; depths are those of the
    undeformed material, from the surface (the value of the topmost Gauss points) to eight times the disc's radius.
    """
    from scipy.interpolate import LinearNDInterpolator  # here: half a second that reading a dimple does without

    p = impact.points
    near = (p["r"] < 4 * disc_radius) & (p["z"] > -12 * disc_radius)
    r, z, s = p["r"][near], p["z"][near], p["s_rr"][near]
    field = LinearNDInterpolator(np.column_stack([np.r_[r, -r], np.r_[z, z]]), np.r_[s, s])
    depth = np.linspace(0.0, min(8 * disc_radius, 0.95 * float(-z.min())), levels)
    # Areas of equal size: r at the middles of equal steps of r^2.
    radii = disc_radius * np.sqrt((np.arange(24) + 0.5) / 24)
    topmost = float(-p["z"][near & (p["r"] < disc_radius)].max())
    values = field(np.broadcast_to(radii, (levels, 24)), -np.maximum(depth, 1.5 * topmost)[:, None])
    mean = np.nanmean(values, axis=1)
    return depth, mean


def edge_peeq(impact: ReducedImpact, radius: float) -> float:
    """Equivalent plastic strain at the dimple's edge: mean of the Gauss points within .15 radii of it."""
    p = impact.points
    r, z = p["r"] + p["u_r"], p["z"] + p["u_z"]
    near = np.hypot(r - radius, np.minimum(z, 0)) < 0.15 * radius
    if not near.any():
        near = np.argsort(np.hypot(r - radius, z))[:3]
    return float(np.average(p["peeq"][near], weights=p["volume"][near]))
