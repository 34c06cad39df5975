"""Contact and the optional physics of the single impact: Hertz, waves, friction, shot, penalty, energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.checkrows import Rows
from glue.scene.catalogue import material
from glue.scene.model import JohnsonCook
from glue.target.dimple import zero_height_radius
from glue.target.physics import STEEL_SHOT, ImpactPhysics, shot_yield_warning
from glue.target.reduced_impact import Numerics, ReducedImpact, solve_hits, solve_reduced
from glue.target.tables import read_table
from glue.theory import hertz, radiation

AL2024 = material("al2024-t351")
STEEL = 7800.0  # kg/m3
SHOT = (210e9, 0.3)  # E [Pa], nu of a steel shot
ELASTIC = JohnsonCook(1e15, 0.0, 1.0)  # cannot yield


def solve(law=AL2024.johnson_cook, speed=60.0, elements=3, numerics=None, **physics) -> ReducedImpact:
    """Steel on 2024; coarse unless told."""
    return solve_reduced(AL2024, law, speed_m_s=speed, density_kg_m3=STEEL, elements_per_radius=elements,
                         numerics=numerics or Numerics(), physics=ImpactPhysics(**physics))  # fmt: skip


def hertz_impact(rows: Rows, scratch: Path) -> None:
    """Elastic impacts, rigid and elastic shot: force, duration, contact radius, restitution; the radius converges.

    The radius is known to the distance of contact points only, so that a coarse mesh may hit it by luck: of both speeds
    the worse one has to halve with the mesh.
    """
    for name, shot, meshes in (("rigid", None, (3, 6, 12)), ("elastic", SHOT, (3, 6))):
        modulus = hertz.effective_modulus_Pa(AL2024.E_Pa, AL2024.nu, *(shot or ()))
        worst = np.zeros(len(meshes))
        for speed in (1.0, 0.1):
            exact = hertz.impact(0.5e-3, STEEL, speed, modulus)
            radius_errors = []
            for elements in meshes:
                got = solve(ELASTIC, speed, elements, elastic_shot=shot)
                radius = read_table(got.log.with_name("result.csv"))["contact_radius"][0]
                radius_errors.append(abs(radius * 0.5e-3 / exact.contact_radius_m - 1.0))
            told = f"Hertz {speed:g} m/s, {name} shot, a/{meshes[-1]}"
            rows.near(f"{told}: force [N]", got.peak_force * 0.25, exact.force_N, 0.02)
            rows.near(f"{told}: duration [s]", got.duration * 0.5e-3, exact.contact_time_s, 0.02)
            coarse = ", ".join(f"a/{n} {error:.2%}" for n, error in zip(meshes, radius_errors, strict=True))
            rows.below(f"{told}: contact radius", radius_errors[-1], 0.02, coarse)
            worst = np.maximum(worst, radius_errors)
            rows.below(f"{told}: |e - 1|", abs(got.restitution - 1.0), 0.002, f"energy {got.energy_error:.1e}")
        rows.true(f"Hertz, {name} shot: contact radius at least 1.7 times better with each mesh",
                  bool((worst[1:] < worst[:-1] / 1.7).all()), ", ".join(f"{error:.2%}" for error in worst))  # fmt: skip


def penalty(rows: Rows, scratch: Path) -> None:
    """A penalty stores energy and gives it back: e errs by a multiple of h/penalty and by nothing else."""
    values = np.array([5.0, 10.0, 20.0, 40.0])
    for elements in (3,):
        got = [solve(elements=elements, numerics=Numerics(penalty=p, toe=0.04 / p)) for p in values]
        e = np.array([g.restitution for g in got])
        limit = np.polyfit(1.0 / values, e, 1)[1]
        rows.below(f"penalty 20 E/h at a/{elements}: e above its limit", e[2] - limit, 0.004,
                   f"5, 10, 20, 40: {', '.join(f'{v:.4f}' for v in e)}, limit {limit:.4f}")  # fmt: skip
        rate = np.log2((e[0] - e[1]) / (e[1] - e[2]))
        rows.within(f"penalty at a/{elements}: rate of e in 1/penalty", float(rate), 1.0, 0.15)
        force = [g.peak_force for g in got]
        rows.below(f"penalty at a/{elements}: peak force, 20 against 40 E/h", abs(force[2] / force[3] - 1.0), 0.005)


def target_inertia(rows: Rows, scratch: Path) -> None:
    """Waves: what an elastic impact loses against the closed form; restitution and dimple at 60 m/s; size of the block."""
    wide = Numerics(domain_R=20.0, domain_radii=40.0)
    for speed, limit in ((10.0, 0.03), (1.0, 0.05)):
        got = solve(ELASTIC, speed, 6, wide, inertia=True)
        history = read_table(got.log.with_name("history.csv"))
        closed = radiation.radiated_J(history["time"], history["force"], AL2024.E_Pa * 1e-6, AL2024.nu,
                                      AL2024.density_kg_m3 * 1e-6) / got.energy.initial  # fmt: skip
        rows.near(f"elastic impact {speed:g} m/s: 1 - e^2 against Lamb", 1 - got.restitution**2, closed, limit)
    still, moving = solve(), solve(inertia=True)
    rows.below("target inertia, 60 m/s: energy balance at every step", moving.energy_error, 0.005)
    rows.within("target inertia, 60 m/s: e", moving.restitution, 0.306, 0.005, f"without {still.restitution:.4f}")
    for name, read in (("depth", lambda i: i.surface_z[0]), ("radius", zero_height_radius)):
        rows.below(f"target inertia, 60 m/s: change of {name}", abs(read(moving) / read(still) - 1.0), 0.01)
    larger = solve(numerics=Numerics(domain_R=15.0, domain_radii=30.0), inertia=True)
    rows.within("target inertia: e in a block 1.5 times the size", larger.restitution, moving.restitution, 0.002)
    flow = AL2024.johnson_cook.flow_stress_Pa(0.08)
    share = radiation.expected_share(AL2024.E_Pa, AL2024.nu, AL2024.density_kg_m3, shot_density_kg_m3=STEEL,
                                     flow_stress_Pa=flow, restitution=still.restitution)  # fmt: skip
    told = radiation.restitution_with_waves(still.restitution, share)
    rows.within("regime number: e with waves, told beforehand", told, moving.restitution, 0.01, f"share {share:.4f}")


def friction(rows: Rows, scratch: Path) -> None:
    """None at mu = 0, in stick an elastic impact loses nothing and stiffens less than a glued flat punch would."""
    plain, least, some = solve(), solve(friction=1e-9), solve(friction=0.2)
    rows.below("friction: e at mu = 1e-9 against none", abs(least.restitution - plain.restitution), 1e-6)
    rows.below("friction .2: energy balance at every step", some.energy_error, 0.005,
               f"e {plain.restitution:.4f} -> {some.restitution:.4f}, work {some.energy.friction / some.energy.initial:.2%}")  # fmt: skip
    rows.true("friction .2: takes work", some.energy.friction > 0.0)
    free, stuck = solve(ELASTIC, 1.0, 6), solve(ELASTIC, 1.0, 6, friction=1.0)
    nu = AL2024.nu
    glued = ((1 - nu) * np.log(3 - 4 * nu) / (1 - 2 * nu)) ** 0.4 - 1.0  # D. A. Spence (1968): flat punch; F ~ E*^(2/5)
    rise = stuck.peak_force / free.peak_force - 1.0
    rows.below("elastic impact in stick: |e - 1|", abs(stuck.restitution - 1.0), 0.001)
    rows.true("elastic impact in stick: force rises, less than glued", 0.0 < rise < glued, f"{rise:.2%} of {glued:.2%}")


def elastic_shot(rows: Rows, scratch: Path) -> None:
    """The shot's own give: more restitution, nearly the same dimple; and when it would itself yield."""
    rigid, elastic = solve(), solve(elastic_shot=SHOT)
    ratio = elastic.restitution / rigid.restitution
    rows.within("elastic shot, 60 m/s: e over that of a rigid shot", ratio, 1.09, 0.09, f"e {elastic.restitution:.4f}")
    rows.below("elastic shot: energy balance at every step", elastic.energy_error, 0.005)
    rows.below("elastic shot: change of radius", abs(zero_height_radius(elastic) / zero_height_radius(rigid) - 1.0), 0.02)
    stiff = solve(elastic_shot=(1e17, 0.3))
    rows.below("elastic shot, E a million times: e against rigid", abs(stiff.restitution - rigid.restitution), 1e-4)
    for name, law, expected in (("2024", AL2024.johnson_cook, False), ("A = 2500 MPa", JohnsonCook(2500e6, 0.0, 1.0), True)):
        got = solve(law)
        told = shot_yield_warning(got.centre_pressure * 1e6, got.mean_pressure * 1e6, STEEL_SHOT.yield_Pa)
        rows.true(f"steel shot on {name}: {'warns' if expected else 'no warning'}", (told is not None) == expected, told or "")


def energy(rows: Rows, scratch: Path) -> None:
    """Stored and spent, each from the points, against the work of the internal forces: .5 % of the shot's energy."""
    for name, law in (("Johnson-Cook", AL2024.johnson_cook), ("combined", AL2024.combined)):
        got = solve(law)
        split = got.energy
        total = split.rebound + split.elastic + split.plastic
        rows.near(f"energy split, {name}: rebound + elastic + plastic", total, split.initial, 0.005,
                  f"{split.rebound / split.initial:.1%}, {split.elastic / split.initial:.1%}, {split.plastic / split.initial:.1%}")  # fmt: skip
        rows.below(f"energy split, {name}: worst at any step", split.points_error, 0.005)


def repeated_hits(rows: Rows, scratch: Path) -> None:
    """Five hits at one spot, both laws: restitution, radius and depth rise, each by less than before."""
    for name, law in (("Johnson-Cook", AL2024.johnson_cook), ("combined", AL2024.combined)):
        got = solve_hits(AL2024, law, hits=5, speed_m_s=60.0, density_kg_m3=STEEL, elements_per_radius=3)
        for what in ("restitution", "radius", "depth"):
            rise = np.diff(getattr(got, what))
            rows.true(f"five hits, {name}: {what} rises", bool((rise > 0).all()),
                      ", ".join(f"{v:.4f}" for v in getattr(got, what)))  # fmt: skip
        rows.true(f"five hits, {name}: depth rises by less each time", bool((np.diff(got.depth, 2) < 0).all()))
        rows.below(f"five hits, {name}: energy balance of the worst", got.energy_error.max(), 0.005)


CHECKS = (hertz_impact, penalty, target_inertia, friction, elastic_shot, energy, repeated_hits)
