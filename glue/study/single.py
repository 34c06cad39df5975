"""Impacts without a scene: ``peen dimple``, one of them or a library over the speed."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.scene import catalogue, schema
from glue.scene.model import Material
from glue.scene.presets import DEFAULT_PRESET, PRESETS
from glue.study.dimple_stage import dimple_metrics, law_text, ready_kernels
from glue.target.dimple import solve_dimple
from glue.target.library import FITTED, Library, build_library
from glue.theory import dimple_formulas as formulas
from glue.theory.impact_scale import REPRESENTATIVE_STRAIN

POINTS = 12
_MOST_POINTS = 200


def single_dimple(
    material: str, speed_m_s: float, grade: str, diameter_m: float | None, preset: str | None, progress
) -> dict:
    """Solve a normal impact; the values are those of metrics.json's section ``dimple``.

    material, grade: keys of the catalogue; ``diameter_m`` replaces the grade's. Raises InputError for
    a value out of range, SolverFailed or NotConverged.
    """
    problems = _speed_problems("--speed", speed_m_s)
    if diameter_m is not None and not 1e-5 <= diameter_m <= 1e-2:
        problems.append(f"--diameter {diameter_m:g}: must lie in 1e-5..1e-2 m (metres, not millimetres)")
    accuracy = _accuracy(preset, problems)
    shots, law = catalogue.shot(grade), catalogue.material(material)
    ready_kernels()
    with tempfile.TemporaryDirectory(prefix="peen-dimple-") as scratch:
        dimple = solve_dimple(
            law,
            speed_m_s=speed_m_s,
            density_kg_m3=shots.density_kg_m3,
            diameter_m=diameter_m or shots.diameter_m,
            elements_per_radius=accuracy.dimple_elements_per_radius,
            workdir=Path(scratch),
            progress=lambda fraction, text="": progress("dimple", fraction, text),
        )
    return dimple_metrics(dimple, shots.medium)


def dimple_library(
    material: str, speeds: str, points: int, grade: str, preset: str | None, jobs: int | None, out: Path | None, progress
) -> Library:
    """Build (or fetch) the library of a material over ``speeds``, "1:120" in m/s; ``out`` receives it as JSON.

    Raises InputError for a value out of range, SolverFailed or NotConverged.
    """
    problems, ends = [], (1.0, 120.0)
    try:
        slowest, fastest = ends = tuple(float(end) for end in speeds.split(":"))
    except ValueError:
        problems.append(f"--speeds {speeds}: must be SLOWEST:FASTEST in m/s, such as 1:120")
    else:
        problems += [*_speed_problems("--speeds", slowest), *_speed_problems("--speeds", fastest)]
        if not slowest < fastest:
            problems.append(f"--speeds {speeds}: the first must be below the second")
    if not 3 <= points <= _MOST_POINTS:
        problems.append(f"--points {points}: allowed 3 to {_MOST_POINTS}")
    if jobs is not None and jobs < 1:
        problems.append(f"--jobs {jobs}: allowed 1 and more")
    accuracy = _accuracy(preset, problems)
    shots, target = catalogue.shot(grade), catalogue.material(material)
    ready_kernels()
    library = build_library(
        target, *ends, points, density_kg_m3=shots.density_kg_m3,
        elements_per_radius=accuracy.dimple_elements_per_radius, jobs=jobs,
        progress=lambda fraction, text="": progress("library", fraction, text),
    )  # fmt: skip
    if out is not None:
        write_text_atomic(out, json.dumps(library.as_dict(), indent=2) + "\n")
    return library


def library_text(library: Library) -> str:
    """The library as a page of text: the table, and what its curves are good for."""
    law, formula = law_text(library.material)
    lines = [
        f"{library.material.name}: {law}, {formula} (grade {library.material.grade})",
        f"rigid shot of {library.density_kg_m3:g} kg/m3; lengths in shot radii R, energy shares of the shot's kinetic energy",
        "",
        f"{'speed m/s':>9} {'radius/R':>9} {'depth/R':>9} {'e':>7} {'rebound':>8} {'plastic':>8} {'left':>6} {'peeq':>6}",
    ]
    columns = {name: library.column(name) for name in library.curves}
    for k, speed in enumerate(library.speeds_m_s):
        row = {name: column[k] for name, column in columns.items()}
        lines.append(
            f"{speed:9.4g} {row['radius']:9.5f} {row['depth']:9.6f} {row['restitution']:7.4f} {row['restitution'] ** 2:8.4f}"
            f" {row['plastic_energy']:8.4f} {row['elastic_energy']:6.4f} {row['largest_peeq']:6.3f}"
        )
    low, high = library.speeds_m_s[0], library.speeds_m_s[-1]
    told = ", ".join(
        f"{name} ~ v^{library.curves[name].exponent():.3f} (error {library.curves[name].error:.2%})" for name in FITTED
    )
    return "\n".join([*lines, "", f"curves for {low:g} to {high:g} m/s, not beyond; {told};", "error: the worst inner point against the curve of all others"])  # fmt: skip


def formulas_table(library: Library) -> list[dict]:
    """Dimple radius by closed forms over the library's, a row per speed: keys ``speed_m_s``, ``radius_R``, formulas.

    Hardness is three times the flow stress at Tabor's strain, the yield stress that at .2 %, restitution the library's.
    """
    law, rho = library.material.single_law, library.density_kg_m3
    hardness = formulas.hardness_Pa(law.flow_stress_Pa(REPRESENTATIVE_STRAIN))
    yield_Pa = law.flow_stress_Pa(0.002)
    rows = []
    for v, radius, e in zip(library.speeds_m_s, library.column("radius"), library.column("restitution"), strict=True):
        found = {
            "kirk": formulas.kirk_radius(rho, v, hardness, e),
            "al-hassani": formulas.al_hassani_radius(rho, v, yield_Pa),
            "shen-atluri": formulas.shen_atluri_radius(rho, v, yield_Pa),
            "nguyen": formulas.nguyen_semi_axes(rho, v, 90.0, hardness, e)[1],
        }
        rows.append({"speed_m_s": v, "radius_R": float(radius)} | {k: float(x / radius) for k, x in found.items()})
    return rows


def formulas_text(material: Material, rows: list[dict]) -> str:
    """The table of ``formulas_table``, and the speeds at which each formula is within a twentieth."""
    names = list(formulas.GRADES)
    lines = [
        f"Dimple radius on {material.key} by closed forms over the computed one",
        f"{'speed m/s':>9} {'radius/R':>9} " + " ".join(f"{name:>12}" for name in names),
        *(f"{r['speed_m_s']:9.4g} {r['radius_R']:9.5f} " + " ".join(f"{r[name]:12.3f}" for name in names) for r in rows),
    ]
    for name in names:
        good = [r["speed_m_s"] for r in rows if abs(r[name] - 1.0) <= 0.05]
        where = f"{good[0]:.3g} to {good[-1]:.3g} m/s" if good else "nowhere here"
        lines.append(f"{name:<12} within 5 %: {where} (grade {formulas.GRADES[name]})")
    return "\n".join([*lines, "at 90 degrees; nguyen is kirk there, and differs for oblique shots"])


def _speed_problems(option: str, speed_m_s: float) -> list[str]:
    found = schema.NOZZLE["speed_m_s"].problem(speed_m_s)  # what a scene allows
    return [f"{option}: {found}"] if found else []


def _accuracy(preset: str | None, problems: list[str]):
    """The preset's numbers; raises InputError for ``problems`` found before, and for a preset that is none."""
    if preset is not None and preset not in PRESETS:
        problems.append(f"--accuracy {preset}: allowed {', '.join(PRESETS)}")
    if problems:
        raise InputError(problems)
    return PRESETS[preset or DEFAULT_PRESET]
