"""The laws at points and in one body: Hill's sphere against its exact solution, cycles against the law's own."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from glue.checkrows import Rows
from glue.scene.catalogue import material
from glue.solvers import run_freefem
from glue.target.driver import Parameter, law_table, write_driver
from glue.target.tables import read_table
from glue.theory import cyclic, hill

AL2024 = material("al2024-t351")


def run_check(folder: Path, name: str, parameters: list[Parameter], includes: list[str]) -> None:
    """Write and run a driver in ``folder``."""
    folder.mkdir(parents=True)
    paths = [
        Parameter("string", "outDir", ".", "results"),
        Parameter("string", "statusFile", "status", "written last"),
    ]
    driver = folder / "driver.edp"
    driver.write_text(write_driver(name, paths + parameters, includes))
    run_freefem(driver, cwd=folder, log=folder / "log", status=folder / "status")


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


def uniaxial_cycle(rows: Rows, scratch: Path) -> None:
    """Five reversals of the bounded law against its exact solution."""
    law, amplitude, steps = AL2024.combined, 0.015, 40
    folder = scratch / "cycle"
    run_check(folder, "uniaxial cycle of the combined law",
              [Parameter("real[int]", "law", law_table(AL2024.E_Pa, AL2024.nu, law), "MPa"),
               Parameter("real", "amplitude", amplitude, "strain"), Parameter("int", "stepsPerReversal", steps, ""),
               Parameter("int", "reversals", 5, "")],
              ["points_small_kernel.idp", "checks/uniaxial_cycle.edp"])  # fmt: skip
    table = read_table(folder / "cycle.csv")
    exact = np.array(cyclic.uniaxial_stress_Pa(AL2024.E_Pa, law, table["strain"])) * 1e-6
    rows.below(
        "uniaxial cycle: largest error [MPa]",
        float(abs(table["stress"] - exact).max()),
        0.01,
        f"{len(exact)} states, peeq {table['peeq'][-1]:.3f}",
    )


CHECKS = (uniaxial_cycle, hill_sphere)
