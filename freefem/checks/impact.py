"""The single impact: Hertz, the reference impact, what its numerics do, how it scales."""

from __future__ import annotations

import time
from pathlib import Path

from glue.checkrows import Rows
from glue.scene.catalogue import material
from glue.scene.model import JohnsonCook
from glue.target.dimple import solve_dimple, to_si, zero_height_radius
from glue.target.reduced_impact import Numerics, solve_reduced
from glue.theory import hertz

AL2024 = material("al2024-t351")
STEEL = 7800.0  # kg/m3


def elastic_impact(rows: Rows, scratch: Path) -> None:
    """A target that cannot yield: Hertz with a rigid shot; errors fall with the mesh."""
    hard = JohnsonCook(1e15, 0.0, 1.0)
    errors = []
    for elements in (3, 6, 12):
        got = solve_reduced(AL2024, hard, speed_m_s=1.0, density_kg_m3=STEEL, elements_per_radius=elements)
        exact = hertz.impact(0.5e-3, STEEL, 1.0, hertz.effective_modulus_Pa(AL2024.E_Pa, AL2024.nu))
        force, duration = got.peak_force * 1e6 * 0.25e-6, got.duration * 0.5e-3
        errors.append(
            (
                abs(force / exact.force_N - 1),
                abs(duration / exact.contact_time_s - 1),
                abs(got.restitution - 1),
            )
        )
    rows.below(
        "Hertz impact 1 m/s: force, a/12",
        errors[2][0],
        0.02,
        f"a/3 {errors[0][0]:.2%}, a/6 {errors[1][0]:.2%}",
    )
    rows.below(
        "Hertz impact 1 m/s: duration, a/12",
        errors[2][1],
        0.02,
        f"a/3 {errors[0][1]:.2%}, a/6 {errors[1][1]:.2%}",
    )
    rows.below(
        "Hertz impact 1 m/s: |e - 1|, a/12",
        errors[2][2],
        0.01,
        f"a/3 {errors[0][2]:.2%}, a/6 {errors[1][2]:.2%}",
    )


def reference_impact(rows: Rows, scratch: Path) -> None:
    """Two independent codes agree on these values (not measurements): 1 mm steel, 60 m/s, 2024 without rate term."""
    start = time.monotonic()
    impact = solve_reduced(
        AL2024, AL2024.johnson_cook, speed_m_s=60.0, density_kg_m3=STEEL, elements_per_radius=6
    )
    elapsed = max(time.monotonic() - start, impact.wall_s)
    d = to_si(impact, 60.0, STEEL, 1e-3, (0.5, 0.25), impact.wall_s)
    rows.near("reference impact: depth [m]", d.depth_m, 52.4e-6, 0.02)
    rows.near("reference impact: zero-height radius [m]", d.radius_m, 227e-6, 0.02)
    rows.near("reference impact: peak force [N]", d.peak_force_N, 261.0, 0.02)
    rows.within("reference impact: restitution", d.restitution, 0.34, 0.02)
    rows.near("reference impact: largest compressive [Pa]", float(d.layer_stress_Pa.min()), -472e6, 0.05,
              f"at {d.layer_depth_m[d.layer_stress_Pa.argmin()] * 1e6:.0f} um")  # fmt: skip
    rows.below("reference impact: time [s]", elapsed, 10.0, f"{impact.dofs} dofs")
    rows.below("reference impact: energy balance at every step", d.energy_error, 0.005)
    coarse = solve_reduced(
        AL2024, AL2024.johnson_cook, speed_m_s=60.0, density_kg_m3=STEEL, elements_per_radius=3
    )
    fine = solve_reduced(
        AL2024, AL2024.johnson_cook, speed_m_s=60.0, density_kg_m3=STEEL, elements_per_radius=12
    )
    for name, read in (
        ("radius", zero_height_radius),
        ("depth", lambda i: -i.surface_z[0]),
        ("e", lambda i: i.restitution),
    ):
        change = [abs(read(i) / read(fine) - 1.0) for i in (coarse, impact)]
        rows.below(f"mesh: {name} at a/6 against a/12", change[1], 0.02, f"at a/3 {change[0]:.2%}")


def numerics(rows: Rows, scratch: Path) -> None:
    """What no preset changes, each made finer or coarser alone: radius and restitution must hardly move (at a/3)."""

    def solve(**changed):
        return solve_reduced(
            AL2024,
            AL2024.johnson_cook,
            speed_m_s=60.0,
            density_kg_m3=STEEL,
            elements_per_radius=3,
            numerics=Numerics(**changed),
        )

    base = solve()
    for name, changed in (
        ("block twice as large", {"domain_R": 20.0, "domain_radii": 40.0}),
        ("mesh grows half as fast", {"growth": 0.15}),
        ("twice the time steps", {"steps_per_contact": 180.0}),
        ("contact four times as stiff", {"penalty": 80.0}),
        ("contact toe half as wide", {"toe": 0.001}),
        ("Newton a hundred times tighter", {"newton": 1e-7}),
    ):
        got = solve(**changed)
        radius, e = (
            abs(read(got) / read(base) - 1.0) for read in (zero_height_radius, lambda impact: impact.restitution)
        )
        rows.below(f"{name}: change of radius", radius, 0.01)
        rows.below(f"{name}: change of e", e, 0.02, f"peak force {got.peak_force / base.peak_force - 1:+.2%}")


def laws(rows: Rows, scratch: Path) -> None:
    """One dent cannot tell the bounded law from Johnson-Cook: what it may not be chosen by."""
    plain, bounded = (
        solve_reduced(AL2024, law, speed_m_s=60.0, density_kg_m3=STEEL, elements_per_radius=6)
        for law in (AL2024.johnson_cook, AL2024.combined)
    )
    change = zero_height_radius(bounded) / zero_height_radius(plain) - 1.0
    rows.below("combined law against Johnson-Cook: dimple radius", abs(change), 0.02, f"{change:+.2%}")
    change = bounded.surface_z[0] / plain.surface_z[0] - 1.0
    rows.below("combined law against Johnson-Cook: dimple depth", abs(change), 0.02, f"{change:+.2%}")


def scaling(rows: Rows, scratch: Path) -> None:
    """The speed exponent of the dimple radius, printed beside the band that dent measurements give (.42-.5)."""
    d = solve_dimple(
        AL2024,
        speed_m_s=60.0,
        density_kg_m3=STEEL,
        diameter_m=1e-3,
        elements_per_radius=6,
        workdir=scratch / "dimple",
    )
    rows.within("dimple radius ~ speed^n: n", d.speed_exponent, 0.46, 0.04, f"edge strain {d.edge_peeq:.3f}")


CHECKS = (elastic_impact, reference_impact, numerics, laws, scaling)
