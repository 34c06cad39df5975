"""The laws in a body and in cycles: Hill's sphere, a thick tube, uniaxial reversals, each against its exact solution."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from driving import run_check
from kernel import LAWS, TABLE

from glue.checkrows import Rows
from glue.scene.catalogue import material
from glue.scene.laws import CombinedHardening
from glue.target.driver import Parameter
from glue.target.tables import read_table
from glue.theory import cyclic, hill
from glue.theory import thick_tube as tube

AL2024 = material("al2024-t351")


def hill_sphere(rows: Rows, scratch: Path) -> None:
    """Loaded to c = 1.4 and unloaded: stresses near r = 1, 1.2, 1.4 on three meshes, and the elastic rate."""
    c, b, p0 = 1.4, 2.0, 0.5
    meshes = (4, 8, 16)
    worst = {state: [] for state in ("loaded", "residual")}
    elastic = []
    for n in meshes:
        folder = scratch / f"hill{n}"
        run_check(folder, f"Hill sphere, {n} elements across",
                  [Parameter("int", "elementsAcross", n, "elements through the wall"),
                   Parameter("real", "elasticLoad", p0, "pressure over yield stress"),
                   Parameter("real", "plasticLoad", float(hill.pressure_for_radius(c, b)), "brings the plastic zone to 1.4")],
                  ["points_axisym_kernel.idp", "checks/hill_sphere.edp"])  # fmt: skip
        r, radial, hoop, volume = spherical(read_table(folder / "elastic.csv"))
        exact = hill.elastic_stress(r, p0, b)
        elastic.append(
            math.sqrt(np.sum(volume * ((radial - exact[0]) ** 2 + 2 * (hoop - exact[1]) ** 2)) / volume.sum())
        )
        for state, solution in (("loaded", hill.loaded_stress), ("residual", hill.residual_stress)):
            r, radial, hoop, volume = spherical(read_table(folder / f"{state}.csv"))
            exact = solution(r, c, b)
            off = {}
            for radius in (1.0, 1.2, 1.4):
                near = abs(r - radius) < 0.5 / n
                off[radius] = max(abs(np.average(radial[near] - exact[0][near], weights=volume[near])),
                                  abs(np.average(hoop[near] - exact[1][near], weights=volume[near])))  # fmt: skip
            worst[state].append(off)
    for state, series in worst.items():
        for radius in (1.0, 1.2, 1.4):
            errors = [off[radius] for off in series]
            note = "coarser meshes " + ", ".join(f"{e:.4f}" for e in errors[:-1])
            rows.below(f"Hill sphere {state}, r = {radius}: error over Y", errors[-1], 0.01, note)
        total = [max(off.values()) for off in series]
        rows.true(
            f"Hill sphere {state}: error falls on three meshes",
            total[0] > total[1] > total[2],
            str([f"{e:.4f}" for e in total]),
        )
    rate = math.log2(elastic[-2] / elastic[-1])
    # P2 displacements: stresses converge with the square of the element size.
    rows.within(
        "Hill sphere elastic: stress rate (P2: 2)",
        rate,
        2.0,
        0.3,
        f"errors {', '.join(f'{e:.1e}' for e in elastic)}",
    )


def spherical(table: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    """Radius, radial stress, hoop stress, volume at the Gauss points of a section (r, z)."""
    radius = np.hypot(table["r"], table["z"])
    n_r, n_z = table["r"] / radius, table["z"] / radius
    radial = n_r**2 * table["s_rr"] + n_z**2 * table["s_zz"] + 2 * n_r * n_z * table["s_rz"]
    return radius, radial, table["s_tt"], table["volume"]


def tube_error(folder: Path, state: str, exact, n: int, at: float) -> float:
    """Worst of the three stresses [over Y], averaged over half an element about radius ``at``."""
    table = read_table(folder / f"{state}.csv")
    near = abs(table["r"] - at) < 0.5 / n
    stresses = exact(table["r"][near])
    return max(
        abs(float(np.average(table[name][near] - value, weights=table["volume"][near])))
        for name, value in zip(("s_rr", "s_tt", "s_zz"), stresses, strict=True)
    )


def run_tube(folder: Path, nu: float, n: int, loads: list[float]) -> None:
    run_check(folder, f"thick tube, nu {nu}, {n} elements across",
              [Parameter("int", "elementsAcross", n, "through the wall"), Parameter("real", "nu", nu, ""),
               Parameter("real[int]", "loads", loads, "elastic, plastic, collapse (0: not sought): pressure over yield stress")],
              ["points_axisym_kernel.idp", "checks/thick_tube.edp"])  # fmt: skip


def thick_tube(rows: Rows, scratch: Path) -> None:
    """Plane strain.  First yield and collapse are exact for any nu (.3 here); the stress at c = 1.4 for nu -> 1/2, which
    the computed one must approach in proportion to 1 - 2 nu."""
    b, c, nu, n = 2.0, 1.4, 0.3, 16
    first, limit, middle = tube.first_yield(b, nu), tube.collapse(b), tube.pressure_for_radius(c, b)
    run_tube(scratch / "tube", nu, n, [0.999 * first, middle, limit])
    rows.below("thick tube, nu .3: Lame stress at r = 1, error over Y",
               tube_error(scratch / "tube", "elastic", lambda r: tube.elastic_stress(r, 0.999 * first, b, nu), n, 1.0), 1e-3)  # fmt: skip
    rows.below("thick tube, nu .3: plastic strain at .999 of first yield",
               float(read_table(scratch / "tube" / "elastic.csv")["peeq"].max()), 0.0)  # fmt: skip
    found = float(read_table(scratch / "tube" / "limit.csv")["limit"][0])
    rows.near("thick tube, nu .3: collapse pressure over Y", found, limit, 0.005, "sought in steps of .0005")
    errors = {}
    for nu in (0.45, 0.49, 0.499):
        for n in (8, 16):
            folder = scratch / f"tube{nu}-{n}"
            run_tube(folder, nu, n, [0.999 * tube.first_yield(b, nu), middle, 0.0])
            errors[nu, n] = max(tube_error(folder, "loaded", lambda r: tube.loaded_stress(r, c, b), n, at)
                                for at in (1.0, 1.2, 1.4))  # fmt: skip
    rows.below("thick tube, nu .499: stress at r = 1, 1.2, 1.4, error over Y", errors[0.499, 16], 0.01,
               f"{errors[0.499, 8]:.4f} on half the elements")  # fmt: skip
    order = math.log(errors[0.45, 16] / errors[0.49, 16]) / math.log(0.1 / 0.02)
    rows.within("thick tube: distance to the solution of nu = 1/2, order in 1 - 2 nu", order, 1.0, 0.1,
                f"nu .45 {errors[0.45, 16]:.4f}, .49 {errors[0.49, 16]:.4f}")  # fmt: skip


CYCLED = {
    "Johnson-Cook": AL2024.johnson_cook,
    "Johnson-Cook, capped": replace(AL2024.johnson_cook, saturation_Pa=450e6),
    "table": TABLE,
    "Voce": CombinedHardening(369e6, 200e6, 12.0, ()),
    "combined": AL2024.combined,
}


def uniaxial_cycles(rows: Rows, scratch: Path) -> None:
    """Five reversals of each law against its exact integral."""
    amplitude, steps = 0.015, 40
    for number, (name, law) in enumerate(CYCLED.items()):
        folder = scratch / f"cycle{number}"
        run_check(folder, f"uniaxial cycle, {name}",
                  [Parameter("real[int]", "law", LAWS[name], "MPa"),
                   Parameter("real", "amplitude", amplitude, "strain"), Parameter("int", "stepsPerReversal", steps, ""),
                   Parameter("int", "reversals", 5, "")],
                  ["points_small_kernel.idp", "checks/uniaxial_cycle.edp"])  # fmt: skip
        table = read_table(folder / "cycle.csv")
        exact = np.array(cyclic.uniaxial_stress_Pa(AL2024.E_Pa, law, table["strain"])) * 1e-6
        rows.below(f"uniaxial cycle, {name}: largest error [MPa]", float(abs(table["stress"] - exact).max()), 1e-6,
                   f"{len(exact)} states, peeq {table['peeq'][-1]:.3f}")  # fmt: skip


CHECKS = (uniaxial_cycles, hill_sphere, thick_tube)
