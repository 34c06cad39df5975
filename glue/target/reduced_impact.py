"""One impact in units of the shot: runs ``freefem/single_impact.edp``, reads it back, caches it.

Units: length R (shot radius), stress MPa, speed m/s, density 1e6 kg/m3, time R/(1 m/s), force MPa R^2.
Without a rate term nothing else depends on R, so one result serves every shot diameter.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError, NotConverged, PeenError
from glue.scene.model import CombinedHardening, HardeningTable, JohnsonCook, Material
from glue.solvers import run_freefem, versions
from glue.target.cache import cached_folder, content_key
from glue.target.driver import LAW_COMMENT, Parameter, kernel_flavour, law_table, write_driver
from glue.target.physics import MOST_HITS, ImpactPhysics
from glue.target.progress import relay
from glue.target.tables import read_table
from glue.theory.impact_scale import REPRESENTATIVE_STRAIN, expected_impact

ENERGY_ERROR_LIMIT = 0.005  # of the shot's kinetic energy, at any step
SPLIT_ERROR_LIMIT = 0.01  # of the same: stored and spent at the points against the work of the internal forces
UNBALANCED_LIMIT = 1e-3  # residual forces of the unloaded target over those before
# A dent cannot be deeper than the shot went.  Where the mesh stretches manifold under a deep one the axis runs ahead:
# 3 % for a shot .8 R deep at a/3, 11 % and more beyond.  Limit: the error of preset fast.
DENT_LIMIT = 0.04
BURIED = 1.0  # penetration [R] from which on the contact would have to close behind the shot's equator
LEAST_ELEMENTS = 2  # elements per dimple radius: at 1 restitution is off by 4 %
_SOURCES = (
    "freefem/single_impact.edp",
    "freefem/lib/*axisym*.idp",
    "freefem/lib/law_script.idp",
    "freefem/plugin/*",
    "glue/target/physics.py",
    "glue/target/reduced_impact.py",
    "glue/theory/impact_scale.py",
)

@dataclass(frozen=True)
class Numerics:
    """Numbers that no preset changes; freefem/checks/run.py varies each and prints what that does to the result."""

    domain_R: float = 10.0  # block of so many R, and at least domain_radii expected dimple radii
    domain_radii: float = 20.0
    growth: float = 0.3  # element size per unit of distance from the contact
    steps_per_contact: float = 90.0
    penalty: float = 20.0  # contact stiffness over E/h; what it stores comes back: at 5, .004 more restitution (a/6)
    toe: float = 0.002  # width of the contact's smooth toe over h
    newton: float = 1e-5  # out-of-balance over forces


@dataclass(frozen=True)
class ReducedImpact:
    """One solved impact; arrays in the units of the module."""

    restitution: float
    peak_force: float
    duration: float
    energy_error: float  # worst |kinetic + internal + contact - initial| over the initial kinetic energy
    failures: int  # time steps that had to be halved
    dofs: int
    wall_s: float
    surface_r: np.ndarray  # (n,) deformed radius of the surface's nodes, rising
    surface_z: np.ndarray  # (n,) their height, dent negative
    points: dict[
        str, np.ndarray
    ]  # (m,) each: r, z undeformed, u_r, u_z, volume, s_rr, s_zz, s_tt, s_rz, peeq
    triangles: np.ndarray  # (k, 3, 2) deformed corners; three points each, in order
    log: Path
    energy: EnergySplit | None = None
    centre_pressure: float = 0.0  # over the inner half of the contact, at peak force
    mean_pressure: float = 0.0  # force over contact area, at peak force
    hits: Hits | None = None  # each of several impacts at the same place; all above is then of the last


class EnergySplit(NamedTuple):
    """Where the shot's kinetic energy was when it left, MPa R^3; ``initial`` is their sum within the energy error."""

    initial: float
    rebound: float
    elastic: float  # left in the target, most of it locked in
    plastic: float
    target_kinetic: float
    radiated: float
    friction: float
    points_error: float  # worst |elastic + plastic of the points - work of the internal forces| over ``initial``


class Hits(NamedTuple):
    """Impact after impact at one place; arrays (hits,), in the units of the module."""

    restitution: np.ndarray
    peak_force: np.ndarray
    duration: np.ndarray
    depth: np.ndarray  # of the deepest point below the undeformed surface, unloaded
    radius: np.ndarray  # where the profile crosses the undeformed surface
    plastic: np.ndarray  # work of each impact
    energy_error: np.ndarray


def solve_hits(
    material: Material, law: JohnsonCook | CombinedHardening | HardeningTable, *, hits: int, physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
    **inputs,
) -> Hits:  # fmt: skip
    """``hits`` (2 to 10) equal shots on the same place, each on what the last one left; inputs as of solve_reduced."""
    if hits < 2:
        raise InputError(f"hits = {hits}: allowed 2 to {MOST_HITS}")
    return solve_reduced(material, law, physics=replace(physics, hits=hits), **inputs).hits


def solve_reduced(
    material: Material,
    law: JohnsonCook | CombinedHardening | HardeningTable,
    *,
    speed_m_s: float,
    density_kg_m3: float,
    elements_per_radius: int,
    numerics: Numerics = Numerics(),  # noqa: B008 - frozen
    physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
    progress: Callable[[float, str], None] | None = None,
) -> ReducedImpact:
    """Solve (or fetch from the cache) the normal impact of a sphere at ``speed_m_s``.

    elements_per_radius: expected dimple radius over surface element size; physics: rigid and frictionless on a
    quasi-static target unless told.  A rate-dependent result belongs to ``physics.radius_m`` alone, any other to every
    radius.  Raises InputError (too coarse), SolverFailed, NotConverged.
    """
    if not elements_per_radius >= LEAST_ELEMENTS:
        raise InputError(f"elements_per_radius = {elements_per_radius}: allowed from {LEAST_ELEMENTS} up")
    parameters = _parameters(material, law, speed_m_s, density_kg_m3, elements_per_radius, numerics, physics)
    flavour = kernel_flavour()
    solver = versions()["freefem"]["package"]
    inputs = {"parameters": [p.line() for p in parameters], "kernel": flavour, "freefem": solver}
    text = write_driver(
        f"One impact on {material.key}: {speed_m_s:g} m/s, a/h = {elements_per_radius}",
        [Parameter("string", "outDir", ".", "folder of the results"),
         Parameter("string", "statusFile", "status", "written last"), *parameters],
        [f"points_axisym_{flavour}.idp", "single_impact.edp"],
    )  # fmt: skip

    def make(folder: Path) -> None:
        (folder / "driver.edp").write_text(text)
        run_freefem(folder / "driver.edp", cwd=folder, log=folder / "freefem.log", status=folder / "status",
                    on_line=relay(progress))  # fmt: skip
        _check(folder)
        _read(folder)

    key = content_key(inputs, _SOURCES)
    folder, hit = cached_folder("impact", key, make)
    try:
        return _read(folder)
    except PeenError:
        if not hit:
            raise
        shutil.rmtree(folder)  # damaged since it was made: a cache may be thrown away, so it is
        return _read(cached_folder("impact", key, make)[0])


def copy_record(result: ReducedImpact, workdir: Path, name: str) -> None:
    """Put the driver and the log that made ``result`` into ``workdir`` as ``name.edp`` and ``name.log``."""
    workdir.mkdir(parents=True, exist_ok=True)
    for source, suffix in ((result.log.with_name("driver.edp"), ".edp"), (result.log, ".log")):
        with atomic_path(workdir / (name + suffix)) as part:
            shutil.copyfile(source, part)


def _parameters(
    material, law, speed, density_kg_m3, elements_per_radius, numerics, physics=ImpactPhysics(),  # noqa: B008 - frozen
) -> list[Parameter]:  # fmt: skip
    table = law_table(material.E_Pa, material.nu, law, radius_m=physics.radius_m if physics.rate else None,
                      density_kg_m3=material.density_kg_m3, rate=physics.rate, thermal=physics.thermal)  # fmt: skip
    modulus, ratio = physics.elastic_shot or (0.0, 0.3)
    density = density_kg_m3 * 1e-6
    flow_stress = law.flow_stress_Pa(REPRESENTATIVE_STRAIN) * 1e-6
    scale = expected_impact(table[0], table[1], flow_stress, density, speed)
    return [
        Parameter("real[int]", "law", table, LAW_COMMENT),
        Parameter("real", "shotDensity", density, "1e6 kg/m3"),
        Parameter("real", "speed", float(speed), "m/s, normal"),
        Parameter("real", "expectedRadius", scale.radius, "estimate of the dimple radius, R: sets the mesh"),
        Parameter(
            "real",
            "expectedDuration",
            scale.duration,
            "estimate of the contact time, R/(1 m/s): sets the step",
        ),
        Parameter(
            "real",
            "elementsPerRadius",
            float(elements_per_radius),
            "expected dimple radius over element size",
        ),
        Parameter("real", "meshGrowth", numerics.growth, "element size per distance beyond the contact"),
        Parameter("real", "domainSize", max(numerics.domain_R, numerics.domain_radii * scale.radius), "R"),
        Parameter("real", "stepsPerContact", numerics.steps_per_contact, "time steps per contact time"),
        Parameter("real", "penaltyFactor", numerics.penalty, "contact stiffness over E/h"),
        Parameter("real", "toeFraction", numerics.toe, "width of the contact's smooth toe over h"),
        Parameter("real", "newtonTolerance", numerics.newton, "residual over forces"),
        Parameter("real", "frictionCoefficient", float(physics.friction), "Coulomb, shot on target"),
        Parameter("bool", "targetInertia", int(physics.inertia), "waves in the target, and boundaries that let them out"),
        Parameter("real", "targetDensity", material.density_kg_m3 * 1e-6, "1e6 kg/m3"),
        Parameter("real", "shotModulus", modulus * 1e-6, "Young's modulus of the shot, MPa; 0: rigid"),
        Parameter("real", "shotNu", float(ratio), "its Poisson's ratio"),
        Parameter("bool", "smallStrain", int(physics.small_strain), "strains and stresses as if nothing had moved"),
        Parameter("int", "hits", physics.hits, "impacts one after the other at the same place"),
        # 1e-5 of the force at the expected penetration: what counts as no force at all.
        Parameter("real", "forceFloor", 1e-5 * 6 * math.pi * flow_stress * scale.penetration, "MPa R2"),
    ]


def _check(folder: Path) -> None:
    """Refuse a result whose energy or forces do not balance, or whose dent cannot be (NotConverged)."""
    result = read_table(folder / "result.csv")
    went, dent = result["depth_max"][0], -read_table(folder / "surface.csv")["u_z"].min()
    if went >= BURIED or dent > (1.0 + DENT_LIMIT) * went:
        raise NotConverged(
            "the shot sinks in too deep for this model",
            cause=f"it went {went:.2f} of its radius deep (allowed below {BURIED:g}) and left a dent of {dent:.2f} (allowed up "
            f"to {DENT_LIMIT:.0%} more than it went)",
            log=folder / "freefem.log",
            advice="a slower or lighter shot, a harder target; near the limit --accuracy reference",
        )
    problems = []
    if not result["energy_error"][0] <= ENERGY_ERROR_LIMIT:
        problems.append(
            f"energy balance off by {result['energy_error'][0]:.2%} (limit {ENERGY_ERROR_LIMIT:.1%})"
        )
    if not result["split_error"][0] <= SPLIT_ERROR_LIMIT:
        problems.append(
            f"elastic and plastic energy off by {result['split_error'][0]:.2%} from the work done "
            f"(limit {SPLIT_ERROR_LIMIT:.0%})"
        )
    if not result["unbalanced"][0] <= UNBALANCED_LIMIT:
        problems.append(
            f"unloaded target out of balance by {result['unbalanced'][0]:.1e} (limit {UNBALANCED_LIMIT:g})"
        )
    if problems:
        raise NotConverged("the single impact is not to be trusted", cause="; ".join(problems),
                           log=folder / "freefem.log", advice="a finer preset (--accuracy reference)")  # fmt: skip


def _read(folder: Path) -> ReducedImpact:
    result = {k: v[0] for k, v in read_table(folder / "result.csv").items()}
    surface = read_table(folder / "surface.csv")
    order = np.argsort(surface["r"])
    corners = np.column_stack(list(read_table(folder / "mesh.csv").values()))
    rows = read_table(folder / "hits.csv")
    hits = None
    if len(rows["hit"]) > 1:
        nodes = read_table(folder / "hit_surfaces.csv")
        radii = [_zero_radius({k: v[nodes["hit"] == hit] for k, v in nodes.items()}) for hit in rows["hit"]]
        hits = Hits(rows["restitution"], rows["peak_force"], rows["duration"], rows["depth"], np.array(radii),
                    rows["plastic"], rows["energy_error"])  # fmt: skip
    energy = EnergySplit(*(float(result[k]) for k in (
        "kinetic_start", "kinetic_end", "elastic_energy", "plastic_energy", "target_kinetic", "radiated", "friction_work",
        "split_error")))  # fmt: skip
    return ReducedImpact(
        restitution=float(result["restitution"]), peak_force=float(result["peak_force"]),
        duration=float(result["duration"]), energy_error=float(result["energy_error"]),
        failures=int(result["failures"]), dofs=int(result["dofs"]), wall_s=float(result["wall_s"]),
        surface_r=(surface["r"] + surface["u_r"])[order], surface_z=surface["u_z"][order],
        points=read_table(folder / "points.csv"), triangles=corners.reshape(-1, 3, 2), log=folder / "freefem.log",
        energy=energy, centre_pressure=float(result["centre_pressure"]), mean_pressure=float(result["mean_pressure"]),
        hits=hits,
    )  # fmt: skip


def _zero_radius(nodes: dict[str, np.ndarray]) -> float:
    """Innermost radius where the deformed surface of these nodes rises through its undeformed height."""
    order = np.argsort(nodes["r"])
    r, z = (nodes["r"] + nodes["u_r"])[order], nodes["u_z"][order]
    above = np.flatnonzero(z >= 0.0)
    if not above.size or above[0] == 0:
        raise NotConverged("the surface after an impact has no dent with an edge", cause="no sign change of the height",
                           advice="a finer preset (--accuracy reference)")  # fmt: skip
    k = above[0]
    return float(r[k - 1] - z[k - 1] * (r[k] - r[k - 1]) / (z[k] - z[k - 1]))
