"""The representative dimple: one finite-element impact, in SI units, with the law by which it scales.

A rate-free material scales exactly with the diameter, and for a rigid shot radius over diameter depends on
density x speed^2 alone.  With the normal speed the radius and the restitution follow power laws; their
exponents are measured by a second impact at half the speed (radius .46-.47 for steel on 2024).
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from glue.atomic import atomic_path
from glue.errors import InputError, NotConverged
from glue.scene.model import Material
from glue.target.reduced_impact import ReducedImpact, copy_record, solve_reduced

STRESS_DISC = (
    0.44  # layer stresses are means over a disc of this many dimple radii (r < .1 mm of the reference)
)
_SCHEMA = 2


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

    def radius_for(self, diameter_m, normal_speed_m_s, density_kg_m3=None):
        """Dimple radius [m] of a shot of ``diameter_m`` at ``normal_speed_m_s`` (floats or arrays; 0 for none).

        ``density_kg_m3`` of the shot, default the dimple's: as if faster by the root of the densities' ratio.
        """
        speed = np.maximum(np.asarray(normal_speed_m_s, dtype=float), 0.0) / self.speed_m_s
        if density_kg_m3 is not None:
            speed = speed * np.sqrt(np.asarray(density_kg_m3, dtype=float) / self.density_kg_m3)
        return (
            self.radius_m * np.asarray(diameter_m, dtype=float) / self.diameter_m * speed**self.speed_exponent
        )

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
    progress: Callable[[float, str], None] | None = None,
) -> Dimple:
    """The dimple of a rigid, frictionless shot at normal ``speed_m_s`` on ``material`` (its Johnson-Cook law).

    Two impacts are solved, at the speed asked for and at half of it; both come from the cache when they
    were solved before.  ``workdir`` receives their drivers and logs.  Raises SolverFailed, NotConverged.
    """
    runs: list[ReducedImpact] = []
    for k, (speed, name) in enumerate(((speed_m_s, "impact"), (0.5 * speed_m_s, "impact-half-speed"))):
        tell = (
            (lambda share, text="", k=k, speed=speed: progress(0.5 * (k + share), f"{speed:g} m/s: {text}"))
            if progress
            else None
        )
        runs.append(
            solve_reduced(material, material.johnson_cook, speed_m_s=speed, density_kg_m3=density_kg_m3,
                          elements_per_radius=elements_per_radius, progress=tell)
        )  # fmt: skip
        copy_record(runs[-1], workdir, name)
    full, half = runs
    exponents = (
        float(np.log2(zero_height_radius(full) / zero_height_radius(half))),
        float(np.log2(half.restitution / full.restitution)),
    )
    return to_si(full, speed_m_s, density_kg_m3, diameter_m, exponents, full.wall_s + half.wall_s)


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
