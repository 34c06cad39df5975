"""The reference impact in CalculiX (Debian package calculix-ccx): an independent code for the dimple benchmark.

Quasi-static: a rigid sphere is pressed to the penetration that FreeFEM's impact reached, and taken off again.
Axisymmetric CAX4 (full integration), NLGEOM, *PLASTIC with a table of the same law, surface-to-surface contact with a
linear penalty.  Its nodes prescribed one by one, the sphere is a band of elements that cannot deform.
Lengths mm, stress MPa, force N.
"""

from __future__ import annotations

import os
import re
import resource
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.solvers import process

LOAD_STEP = 1.0 / 50  # largest increment of the way down, and up
HELD = 5.0  # contact stiffness over E/h
UP = 0.02  # the sphere is taken up by this part of its radius beyond where it began


@dataclass(frozen=True)
class CalculixImpact:
    """What CalculiX found; arrays as in glue.target.reduced_impact, but in mm and MPa."""

    h_mm: float
    wall_s: float
    processor_s: float
    nodes: int
    peak_force_N: float
    surface_r_mm: np.ndarray  # (n,) deformed
    surface_z_mm: np.ndarray  # (n,)
    r_mm: np.ndarray  # (m,) element centres, undeformed
    z_mm: np.ndarray  # (m,)
    s_rr_MPa: np.ndarray  # (m,) means over the element's points
    peeq: np.ndarray  # (m,)

    @property
    def depth_mm(self) -> float:
        """On the axis of the parabola through the second and third node: the node on the axis hangs back (artefact)."""
        (r1, r2), (z1, z2) = self.surface_r_mm[1:3] ** 2, self.surface_z_mm[1:3]
        return float(-(z1 - r1 * (z2 - z1) / (r2 - r1)))

    @property
    def radius_mm(self) -> float:
        """Where the surface first rises through the undeformed one."""
        r, z = self.surface_r_mm, self.surface_z_mm
        i = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))[0]
        return float(r[i] - z[i] * (r[i + 1] - r[i]) / (z[i + 1] - z[i]))


def graded(h: float, core: float, size: float, growth: float = 1.2) -> np.ndarray:
    """Coordinates from 0 to ``size``: steps of ``h`` up to ``core``, then each ``growth`` times the one before."""
    x = list(np.arange(round(core / h) + 1) * h)
    step = h
    while x[-1] < size:
        step *= growth
        x.append(x[-1] + step)
    return np.array(x)


def write_deck(path: Path, *, E: float, nu: float, table: np.ndarray, R: float, h: float, penetration: float,
               core: float, size: float) -> int:  # fmt: skip
    """Write CalculiX's input; returns the number of nodes.  table: (n, 2) stress [MPa], plastic strain."""
    x = graded(h, core, size)
    depth = -graded(h, core, size)
    nx, nz = len(x), len(depth)
    lines = ["*NODE, NSET=TARGET"]

    def node(i, j):
        return 1 + i + nx * j

    lines += [f"{node(i, j)},{x[i]:.12g},{depth[j]:.12g},0." for j in range(nz) for i in range(nx)]
    lines.append("*ELEMENT, TYPE=CAX4, ELSET=BLOCK")
    number = 0
    top, near = [], []
    for j in range(nz - 1):
        for i in range(nx - 1):
            number += 1
            lines.append(f"{number},{node(i, j + 1)},{node(i + 1, j + 1)},{node(i + 1, j)},{node(i, j)}")
            if j == 0 and x[i] < 1.6 * core:
                top.append(number)
            if x[i] < 1.01 * core and -depth[j] < 1.0:
                near.append(number)
    # the sphere: a band along its lower arc, facets a third of the target's
    angles = np.arange(0.0, np.pi / 2.2, h / R / 3)
    first = nx * nz + 1
    lines.append("*NODE, NSET=SPHERE")
    for k, angle in enumerate(angles):
        for m, radius in enumerate((R, 0.8 * R)):
            lines.append(f"{first + 2 * k + m},{radius * np.sin(angle):.12g},{R - radius * np.cos(angle):.12g},0.")
    lines.append("*ELEMENT, TYPE=CAX4, ELSET=SHOT")
    shot = number + 1
    for k in range(len(angles) - 1):
        a = first + 2 * k
        lines.append(f"{shot + k},{a},{a + 2},{a + 3},{a + 1}")
    lines += ["*SURFACE, NAME=SLAVE, TYPE=ELEMENT", *(f"{e},S3" for e in top),
              "*SURFACE, NAME=MASTER, TYPE=ELEMENT", *(f"{shot + k},S1" for k in range(len(angles) - 1))]  # fmt: skip
    for name, members in (("AXIS", [node(0, j) for j in range(nz)]),
                          ("BOTTOM", [node(i, nz - 1) for i in range(nx)]),
                          ("SIDE", [node(nx - 1, j) for j in range(nz)]),
                          ("TOP", [node(i, 0) for i in range(nx) if x[i] < 2 * core])):  # fmt: skip
        lines += [f"*NSET, NSET={name}", *(f"{n}," for n in members)]
    lines += ["*ELSET, ELSET=NEAR", *(f"{e}," for e in near)]
    lines += ["*MATERIAL, NAME=TARGET", "*ELASTIC", f"{E:.12g},{nu:.12g}", "*PLASTIC",
              *(f"{s:.12g},{p:.12g}" for s, p in table),
              "*MATERIAL, NAME=SHOT", "*ELASTIC", f"{E:.12g},{nu:.12g}",
              "*SOLID SECTION, ELSET=BLOCK, MATERIAL=TARGET", "*SOLID SECTION, ELSET=SHOT, MATERIAL=SHOT",
              "*SURFACE INTERACTION, NAME=TOUCH", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
              f"{HELD * E / h:.6g},1e-3",
              "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE", "SLAVE,MASTER",
              "*BOUNDARY", "AXIS,1,1", "BOTTOM,1,2", "SIDE,1,2"]  # fmt: skip
    for goal in (-penetration, UP * R):
        lines += ["*STEP, NLGEOM, INC=5000", "*STATIC", f"{LOAD_STEP / 2},1.,1e-6,{LOAD_STEP}",
                  "*BOUNDARY", "SPHERE,1,1", f"SPHERE,2,2,{goal:.12g}",
                  "*NODE PRINT, NSET=SPHERE, TOTALS=ONLY", "RF",
                  "*NODE PRINT, NSET=TOP, FREQUENCY=5000", "U",
                  "*EL PRINT, ELSET=NEAR, FREQUENCY=5000", "S,PEEQ", "*END STEP"]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")
    return nx * nz


def solve(folder: Path, h: float, *, E: float, nu: float, table: np.ndarray, R: float, penetration: float, core: float,
          size: float, timeout_s: float = 900.0) -> CalculixImpact:  # fmt: skip
    """Run CalculiX in ``folder``; raises RuntimeError with the end of its log when it does not finish."""
    folder.mkdir(parents=True, exist_ok=True)
    nodes = write_deck(folder / "impact.inp", E=E, nu=nu, table=table, R=R, h=h, penetration=penetration, core=core,
                       size=size)  # fmt: skip
    env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = process.run([find(), "-i", "impact"], cwd=folder, log=folder / "ccx.log", env=env, timeout_s=timeout_s)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    text = (folder / "impact.dat").read_text()
    if done.exit_code != 0 or text.count("total force") != 2:
        raise RuntimeError(f"CalculiX did not finish (exit code {done.exit_code}): {process.tail(done.log)}")
    x = graded(h, core, size)
    blocks = _blocks(text)
    surface = blocks["displacements"][-1]
    centre = 0.5 * (x[1:] + x[:-1])
    stress, strain = (_element_means(blocks[name][-1]) for name in ("stresses", "equivalent plastic strain"))
    index = stress[:, 0].astype(int) - 1
    i, j = index % (len(x) - 1), index // (len(x) - 1)
    start = x[surface[:, 0].astype(int) - 1]
    order = np.argsort(start)
    return CalculixImpact(
        h_mm=h, wall_s=done.wall_s,
        processor_s=after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, nodes=nodes, peak_force_N=180.0 * abs(blocks["total force"][0][0, 1]),
        surface_r_mm=(start + surface[:, 1])[order], surface_z_mm=surface[order, 2],
        r_mm=centre[i], z_mm=-centre[j], s_rr_MPa=stress[:, 2], peeq=strain[:, 2],
    )  # fmt: skip


def _blocks(text: str) -> dict[str, list[np.ndarray]]:
    """Tables of CalculiX's .dat by the words before their bracket; one array of numbers per print."""
    found: dict[str, list[np.ndarray]] = {}
    for part in re.split(r"\n(?= [a-z])", text):
        head, _, body = part.strip("\n").partition("\n")
        name = head.strip().partition(" (")[0]
        rows = [[float(v) for v in line.split()] for line in body.splitlines() if line.strip()]
        found.setdefault(name, []).append(np.array(rows))
    return found


def _element_means(table: np.ndarray) -> np.ndarray:
    """Rows (element, point, values…) to one row an element, its points averaged."""
    _, where = np.unique(table[:, 0], return_inverse=True)
    return np.column_stack([np.bincount(where, column) / np.bincount(where) for column in table.T])


def find() -> str | None:
    """Path of CalculiX, or None."""
    return shutil.which("ccx")
