"""Cells of FreeFEM: single impacts far past any real one, ten on one spot, and the small periodic cell."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from judges import Finding, at_most, equal, near, rising, true

from glue.errors import InputError
from glue.scene.catalogue import material
from glue.scene.model import JohnsonCook, Material
from glue.target.dimple import largest_peeq, tabulated, to_si, zero_height_radius
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import DENT_LIMIT, Numerics, ReducedImpact, solve_hits, solve_reduced
from glue.target.tables import read_table
from glue.theory import hertz

AL2024 = material("al2024-t351")
STEEL = 7800.0
DIAMETER = 1e-3
ELEMENTS = 3  # per dimple radius: preset fast
SIMILAR = 2e-3  # two solutions of one problem in other units: what the solver's own tolerance (1e-5 of the forces) leaves
HERTZ = 0.03  # at a/3, as freefem/checks/impact.py finds (2 % at a/12)
HILL = 3.1  # mean pressure over flow stress: 2.8 to 3 at full plasticity (Tabor) where the shot is not half buried

LAWS = {
    "2024": AL2024.johnson_cook,
    "none": JohnsonCook(369e6, 0.0, 1.0),
    "linear": JohnsonCook(369e6, 2e9, 1.0),
    "steep": JohnsonCook(369e6, 10e9, 0.5),
}


def problem(values: dict) -> tuple[Material, JohnsonCook, float, dict]:
    """(target, law, speed, other inputs of ``solve_reduced``) of a cell."""
    law = LAWS[values.get("hardening", "2024")]
    if "yield_Pa" in values:
        law = JohnsonCook(values["yield_Pa"], values.get("B_Pa", 0.0), values.get("n", 1.0))
    if "C" in values:
        law = replace(law, C=values["C"])
    target = replace(AL2024, nu=values.get("nu", AL2024.nu), E_Pa=values.get("E_Pa", AL2024.E_Pa), johnson_cook=law)
    if values.get("material"):
        target = material(values["material"])
        law = target.single_law
    numerics = Numerics(**{k: values[k] for k in ("growth", "domain_R", "steps_per_contact") if k in values})
    radius = 0.5 * values.get("diameter_m", DIAMETER)
    known = {"inertia": True, "friction": values.get("friction", 0.2), "elastic_shot": (210e9, 0.3), "rate": True, "thermal": True}
    physics = {k: known[k] for k in values.get("physics", ())}
    if physics.get("thermal"):
        physics["rate"] = True
    inputs = {
        "density_kg_m3": values.get("density_kg_m3", STEEL), "elements_per_radius": values.get("elements", ELEMENTS),
        "numerics": numerics, "physics": ImpactPhysics(**physics, radius_m=radius if physics.get("rate") else None),
    }  # fmt: skip
    return target, law, values["speed_m_s"], inputs


def dent(values: dict) -> list[Finding]:
    """One impact by the balances of mechanics, and by its twin in other units."""
    target, law, speed, inputs = problem(values)
    got = solve_reduced(target, law, speed_m_s=speed, **inputs)
    found = [*mechanics(got, speed, inputs["density_kg_m3"])]
    if largest_peeq(got) == 0.0:
        return [*found, *elastic(got, target, speed, inputs["density_kg_m3"])]
    found += [*reading(got, speed, values.get("diameter_m", DIAMETER)), *plastic(got, law, bool(values.get("physics")))]
    return [*found, *twin(got, values)]


def mechanics(got: ReducedImpact, speed: float, density: float) -> list[Finding]:
    """Newton's second law and the energy, from the history of force and motion alone."""
    h = read_table(got.log.with_name("history.csv"))
    mass = density * 1e-6 * 4.0 / 3.0 * math.pi
    time, force = np.r_[0.0, h["time"]], np.r_[0.0, h["force"]]
    impulse = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(time)))
    centre = np.r_[1.0, h["centre"]]
    work = -float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(centre)))
    lost = 0.5 * mass * speed**2 * (1.0 - got.restitution**2)
    return [
        near("impulse is the change of momentum: e", impulse / (mass * speed) - 1.0, got.restitution, 1e-6),
        at_most("work of the force is the energy lost, over the first", abs(work / (0.5 * mass * speed**2) - lost / (0.5 * mass * speed**2)), 5e-3),
        at_most("energy balance at every step", got.energy_error, 5e-3),
        at_most("energy never rises: e", got.restitution, 1.0 + 5e-3),
        near("largest force of the history", np.max(force), got.peak_force, 1e-9),
    ]  # fmt: skip


def elastic(got: ReducedImpact, target: Material, speed: float, density: float) -> list[Finding]:
    """Nothing yielded: Hertz, and the program says that there is no dimple."""
    exact = hertz.impact(1.0, density, speed, hertz.effective_modulus_Pa(target.E_Pa, target.nu))
    return [
        near("Hertz's peak force", got.peak_force * 1e6, exact.force_N, HERTZ),
        near("Hertz's contact time", got.duration, exact.contact_time_s, HERTZ),
        near("elastic: all comes back", got.restitution, 1.0, 5e-3),
    ]


def reading(got: ReducedImpact, speed: float, diameter_m: float) -> list[Finding]:
    """What is read off the solution, in SI: the profile is at height 0 at the radius, lengths go by D, forces by D^2."""
    d = to_si(got, speed, STEEL, diameter_m, (0.5, 0.25), 0.0)
    height = float(np.interp(d.radius_m, d.profile_r_m, d.profile_z_m))
    R = 0.5 * diameter_m
    return [
        at_most("profile at height 0 at the dimple's radius, over its depth", abs(height) / d.depth_m, 1e-9),
        near("dimple's radius over R, whatever R", d.radius_m / R, zero_height_radius(got), 1e-12),
        near("force over R^2, whatever R", d.peak_force_N / R**2, got.peak_force * 1e6, 1e-12),
        true("0 < depth < radius", 0.0 < d.depth_m < d.radius_m),
        true("deepest on the axis or nearly", -float(d.profile_z_m.min()) <= 1.05 * d.depth_m),
        true("0 < e < 1", 0.0 < d.restitution < 1.0),
    ]


def plastic(got: ReducedImpact, law, more_physics: bool) -> list[Finding]:
    """Pressure within that of full plasticity; no dent below the shot."""
    went = float(read_table(got.log.with_name("result.csv"))["depth_max"][0])
    found = [at_most("depth of the dent over the shot's deepest", -got.surface_z.min() / went, 1.0 + DENT_LIMIT)]
    if not more_physics:
        most = law.flow_stress_Pa(largest_peeq(got)) * 1e-6
        found.append(at_most("mean pressure over flow stress at the largest strain", got.mean_pressure / most, HILL))
    return found


def twin(got: ReducedImpact, values: dict) -> list[Finding]:
    """The same problem with every stress 4 times and every speed twice, or with shots 4 times as dense at half the speed.

    Rate-free dimples in radii know density speed^2 / stress alone (Buckingham); with a rate term, also reference rate
    times radius over speed; heat, inertia and an elastic shot bring numbers of their own: no twin.
    """
    physics = values.get("physics", ())
    if {"thermal", "inertia", "elastic_shot"} & set(physics):
        return []
    target, law, speed, inputs = problem(values)
    k = 4.0
    if "rate" in physics:
        law = replace(law, rate_ref_1_s=law.rate_ref_1_s * 10.0)
        inputs |= {"physics": replace(inputs["physics"], radius_m=inputs["physics"].radius_m / 10.0)}
    elif values.get("twin") == "density":
        inputs |= {"density_kg_m3": inputs["density_kg_m3"] * k}
        speed /= math.sqrt(k)
    else:
        law = replace(law, A_Pa=law.A_Pa * k, B_Pa=law.B_Pa * k)
        target = replace(target, E_Pa=target.E_Pa * k)
        speed *= math.sqrt(k)
    other = solve_reduced(target, law, speed_m_s=speed, **inputs)
    return [
        near("similarity: radius of the same problem in other units", zero_height_radius(other), zero_height_radius(got), SIMILAR),
        near("similarity: depth of the same problem in other units", other.surface_z[0], got.surface_z[0], SIMILAR),
        near("similarity: e of the same problem in other units", other.restitution, got.restitution, SIMILAR),
    ]


def order(values: dict) -> list[Finding]:
    """Along one axis: radius and depth rise with the speed and fall with the yield stress, e the other way round."""
    axis, ends = values["axis"], values["values"]
    runs = []
    for value in ends:
        target, law, speed, inputs = problem({**values, axis: value})
        runs.append(solve_reduced(target, law, speed_m_s=speed, **inputs))
    sign = 1 if values["radius"] == "rises" else -1
    dents = [r for r in runs[::sign] if largest_peeq(r) > 0.0]
    return [
        rising("radius in its order", [zero_height_radius(r) for r in dents]),
        rising("depth in its order", [-r.surface_z[0] for r in dents]),
        rising("restitution in its order", [r.restitution for r in runs[::-sign]], 5e-3 if len(dents) < len(runs) else 0.0),
        true("some left a dimple", len(dents) >= 2),
    ]


def effect(values: dict) -> list[Finding]:
    """Physics added to the plain impact has the sign of the mechanics; the balances hold."""
    target, law, speed, inputs = problem(values)
    with_it = solve_reduced(target, law, speed_m_s=speed, **inputs)
    plain = solve_reduced(target, law, speed_m_s=speed, **(inputs | {"physics": ImpactPhysics()}))
    found = mechanics(with_it, speed, inputs["density_kg_m3"])
    if "elastic_shot" in values["physics"]:  # the shot's own energy is not the target's: the force works on both
        found = [f for f in found if "work" not in f.invariant]
    name = values["physics"][-1]
    e, e0 = with_it.restitution, plain.restitution
    signs = {"inertia": e < e0, "elastic_shot": e > e0, "friction": with_it.energy.friction >= 0.0, "rate": e > e0,
             "thermal": True}  # fmt: skip
    return [*found, true(f"{name}: restitution moves the right way", signs[name]),
            true(f"{name}: dimple no larger than half as much again", zero_height_radius(with_it) < 1.5 * zero_height_radius(plain))]  # fmt: skip


def mesh(values: dict) -> list[Finding]:
    """Another mesh against the preset's own: radius, depth and e within 4 %, the preset fast's limit."""
    target, law, speed, inputs = problem(values)
    got = solve_reduced(target, law, speed_m_s=speed, **inputs)
    fine = solve_reduced(target, law, speed_m_s=speed, **(inputs | {"numerics": Numerics(), "elements_per_radius": 6}))
    return [
        *mechanics(got, speed, inputs["density_kg_m3"]),
        near("radius against a/6", zero_height_radius(got), zero_height_radius(fine), 0.04),
        near("depth against a/6", got.surface_z[0], fine.surface_z[0], 0.04),
        near("restitution against a/6", got.restitution, fine.restitution, 0.04),
    ]


def hits(values: dict) -> list[Finding]:
    """Impacts on one spot: each deeper and by less, each gives more back, energy balanced every time."""
    target, law, speed, inputs = problem(values)
    law = target.combined if values.get("bounded") else law
    got = solve_hits(target, law, hits=values["hits"], speed_m_s=speed, **inputs)
    return [
        equal("as many hits as asked", len(got.depth), values["hits"]),
        rising("depth rises from hit to hit", got.depth),
        rising("it rises by less each time", -np.diff(got.depth), 0.02),
        rising("restitution rises from hit to hit", got.restitution, 0.02),
        at_most("energy balance of the worst", np.max(got.energy_error), 5e-3),
    ]


def no_dimple(values: dict) -> list[Finding]:
    """Below first yield the dimple stage has nothing to give: it must say from which speed on it has."""
    target, law, speed, inputs = problem(values)
    kept = {k: inputs[k] for k in ("density_kg_m3", "elements_per_radius")}
    runs = {v: solve_reduced(target, law, speed_m_s=v, **kept) for v in (0.5 * speed, speed)}
    d = tabulated(runs, replace(target, johnson_cook=law), speed, kept["density_kg_m3"], DIAMETER)
    raise InputError(f"a dimple of {d.radius_m} m where nothing should yield")
