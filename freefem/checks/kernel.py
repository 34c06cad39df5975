"""The stress update itself, law by law: its derivative, rigid rotations, rate and heat, patches, Newton's convergence."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from driving import run_check

from glue.checkrows import Rows
from glue.scene.catalogue import material
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook
from glue.target.driver import Parameter, law_table
from glue.target.tables import read_table

AL2024 = material("al2024-t351")
RADIUS = 0.5e-3  # m, of the shot that gives the rates their unit
STEP = 4e-5  # time step, R/(1 m/s): what a single impact takes
TABLE = HardeningTable((0.0, 0.02, 0.1, 0.5), (300e6, 380e6, 450e6, 600e6))
HOT = replace(AL2024.johnson_cook, melting_K=775.0, specific_heat_J_kg_K=875.0)


def _array(law, **factors) -> list[float]:
    return law_table(AL2024.E_Pa, AL2024.nu, law, radius_m=RADIUS, density_kg_m3=AL2024.density_kg_m3, **factors)


# Every law with what can be switched on beside it; the last is no material: all terms at once.
LAWS = {
    "perfectly plastic": _array(JohnsonCook(369e6, 0.0, 1.0)),
    "Johnson-Cook": _array(AL2024.johnson_cook),
    "Johnson-Cook, capped": _array(replace(AL2024.johnson_cook, saturation_Pa=450e6)),
    "Johnson-Cook, rate": _array(AL2024.johnson_cook, rate=True),
    "Johnson-Cook, rate and heat": _array(HOT, rate=True, thermal=True),
    "table": _array(TABLE),
    "Voce": _array(CombinedHardening(369e6, 200e6, 12.0, ())),
    "combined": _array(AL2024.combined),
}
LAWS["all terms"] = [*LAWS["combined"][:2], 270, 684, 0.73, *LAWS["combined"][5:11], 600,
                     *LAWS["Johnson-Cook, rate and heat"][12:]]  # fmt: skip


def update(folder: Path, law: list[float], rows: np.ndarray, flavour: str = "kernel", step: float = STEP):
    """Points through ``updatePoints``: rows (n, 24) of gradients and states -> new states (n, 14), P (n, 5),
    dP/dF (n, 5, 5)."""
    folder.mkdir(parents=True)
    np.savetxt(folder / "points.txt", rows, "%.17g")
    run_check(folder, "Gauss points alone",
              [Parameter("real[int]", "law", [float(v) for v in law], ""), Parameter("real", "stepTime", step, ""),
               Parameter("int", "points", len(rows), "")],
              [f"points_axisym_{flavour}.idp", "checks/points.edp"])  # fmt: skip
    new = read_table(folder / "new.csv")["value"].reshape(len(rows), 44)
    return new[:, :14], new[:, 14:19], new[:, 19:].reshape(-1, 5, 5)


def random_points(seed: int, count: int, law: list[float]) -> np.ndarray:
    """Rows for :func:`update`: strains of .1, increments of .003 or .03, hardened states, deviatoric backstresses."""
    rng = np.random.default_rng(seed)
    old = rng.normal(0, 0.1, (count, 5))
    new = old + rng.normal(0, 1, (count, 5)) * rng.choice([3e-3, 3e-2], (count, 1))
    stress, p = rng.normal(0, 150, (count, 4)), rng.uniform(0, 0.2, (count, 1))
    back = rng.normal(0, 30, (count, 2, 4))
    back[:, :, :3] -= back[:, :, :3].mean(axis=2, keepdims=True)
    back *= np.array([law[7] != 0, law[9] != 0])[:, None]
    heat = rng.uniform(0, 60, (count, 1)) * (law[14] != 0)
    return np.hstack([old, new, stress, p, back.reshape(count, 8), heat])


def tangents(rows: Rows, scratch: Path) -> None:
    """dP/dF against central differences of P (fourth order) in random plastic points of every law."""
    delta, worst = 1e-5, 0.0
    for number, (name, law) in enumerate(LAWS.items()):
        points = random_points(number, 60, law)
        state, _, exact = update(scratch / f"tangent{number}", law, points)
        moved = []
        for b in range(5):
            for k in (-2, -1, 1, 2):
                other = points.copy()
                other[:, 5 + b] += k * delta
                moved.append(other)
        _, stress, _ = update(scratch / f"difference{number}", law, np.vstack(moved))
        stress = stress.reshape(5, 4, len(points), 5)
        slope = (stress[:, 0] - 8 * stress[:, 1] + 8 * stress[:, 2] - stress[:, 3]) / (12 * delta)
        slope = np.moveaxis(slope, 0, 2)
        # Where the law has a corner (a table's points, the cap, the rate at which its term sets in) there is no slope.
        grown = state[:, 4] - points[:, 14]
        smooth = (grown > 1e-4) & away_from_corners(law, state[:, 4])
        error = np.abs(slope - exact).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))
        skew = np.abs(exact - exact.transpose(0, 2, 1)).max(axis=(1, 2)) / np.abs(exact).max(axis=(1, 2))
        rows.below(f"tangent, {name}: error against differences", float(error[smooth].max()), 1e-6,
                   f"{smooth.sum()} plastic points; not symmetric by {skew[smooth].max():.1%}")  # fmt: skip
        worst = max(worst, float(smooth.sum() < 20))
    rows.below("tangent: laws with fewer than 20 plastic points", worst, 0.0)


def away_from_corners(law: list[float], p: np.ndarray) -> np.ndarray:
    """Points whose plastic strain lies more than 2e-4 from every corner of the law's curve."""
    corners = law[19 : 19 + int(law[18])]
    if law[11] > 0:
        corners = [*corners, ((law[11] - law[2]) / law[3]) ** (1 / law[4])]
    return np.all([abs(p - corner) > 2e-4 for corner in corners], axis=0) if corners else np.ones(p.size, bool)


def rotations(rows: Rows, scratch: Path) -> None:
    """A plastically strained, prestressed point turned by 30 and by 90 degrees in one step, and by 90 in six."""
    law = LAWS["all terms"]
    old = np.zeros((1, 5))
    strained = np.array([[0.04, 0.05, -0.03, -0.06, 0.01]])
    # step = 0: with a rate term the stress would stand above the quasi-static surface, and relax while it turns.
    first, _, _ = update(scratch / "strained", law, np.hstack([old, strained, np.zeros((1, 14))]), step=0.0)
    for degrees, steps in ((30, 1), (90, 1), (90, 6)):
        state, gradient = first, strained
        for k in range(steps):
            turned = turn_gradient(strained[0], math.radians(degrees * (k + 1) / steps))[None]
            row = np.hstack([gradient, turned, state])
            state, _, _ = update(scratch / f"turn{degrees}-{steps}-{k}", law, row, step=0.0)
            gradient = turned
        worst = max(
            float(np.abs(state[0, o : o + 4] - turn_tensor(first[0, o : o + 4], math.radians(degrees))).max())
            for o in (0, 5, 9)
        )
        size = float(np.abs(first[0, :4]).max())
        name = f"turned by {degrees} degrees in {steps} step{'s' * (steps > 1)}"
        rows.below(f"{name}: stress, backstress", worst / size, 1e-12, f"stress {size:.0f} MPa")
        energy = [elastic_energy(law, s[0, :4]) for s in (first, state)]
        rows.below(f"{name}: elastic energy", abs(energy[1] / energy[0] - 1.0), 1e-12)
        rows.below(f"{name}: plastic strain, temperature", float(np.abs(state[0, [4, 13]] / first[0, [4, 13]] - 1).max()),
                   1e-12, f"peeq {first[0, 4]:.3f}, {first[0, 13]:.1f} K")  # fmt: skip


def turn_gradient(gradient: np.ndarray, angle: float) -> np.ndarray:
    """Displacement gradient (rr, rz, zr, zz, tt) of the same body turned further by ``angle`` in the r-z plane."""
    q = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    planar = q @ (np.eye(2) + gradient[:4].reshape(2, 2)) - np.eye(2)
    return np.r_[planar.ravel(), gradient[4]]


def turn_tensor(t: np.ndarray, angle: float) -> np.ndarray:
    """A symmetric tensor (rr, zz, tt, rz) turned likewise."""
    q = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    planar = q @ np.array([[t[0], t[3]], [t[3], t[1]]]) @ q.T
    return np.array([planar[0, 0], planar[1, 1], t[2], planar[0, 1]])


def elastic_energy(law: list[float], t: np.ndarray) -> float:
    """sigma : C^-1 : sigma / 2 [MPa] of a stress (rr, zz, tt, rz) [MPa]."""
    E, nu = law[:2]
    return float(((1 + nu) * (t[0] ** 2 + t[1] ** 2 + t[2] ** 2 + 2 * t[3] ** 2) - nu * t[:3].sum() ** 2) / (2 * E))


def strain_rates(rows: Rows, scratch: Path) -> None:
    """Pulled at constant rates, A + B p hardening: in the steady part dp/de = 1/(1 + B r/E), stress (A + B p) r, with
    r = 1 + C ln(rate of p/reference) constant: a closed form."""
    A, B, C = 369.0, 684.0, 0.02
    law = _array(JohnsonCook(A * 1e6, B * 1e6, 1.0, C), rate=True)
    E, increment, steps = law[0], 1e-4, 400
    for rate in (10.0, 1e3, 1e5):  # 1/s
        folder = scratch / f"rate{rate:g}"
        run_check(folder, f"pulled at {rate:g}/s",
                  [Parameter("real[int]", "law", law, ""), Parameter("real", "stepTime", increment / (rate * RADIUS), ""),
                   Parameter("real", "increment", increment, ""), Parameter("int", "steps", steps, "")],
                  ["points_axisym_kernel.idp", "checks/uniaxial_rate.edp"])  # fmt: skip
        path = read_table(folder / "path.csv")
        factor = 1.0
        for _ in range(50):
            factor = 1.0 + C * math.log(rate / (1.0 + B * factor / E))
        share = np.diff(path["peeq"])[-100:] / increment
        stress = (A + B * path["peeq"]) * factor
        name = f"Johnson-Cook pulled at {rate:g}/s"
        rows.below(f"{name}: stress", float(np.abs(path["stress"] / stress - 1)[-100:].max()), 1e-9,
                   f"{path['stress'][-1]:.2f} MPa, {factor:.4f} times quasi-static")  # fmt: skip
        rows.below(f"{name}: plastic share of the rate", float(np.abs(share * (1 + B * factor / E) - 1).max()), 1e-6)


def heating(rows: Rows, scratch: Path) -> None:
    """Perfectly plastic, m = 1, adiabatic: Y = A exp(-k p), tau = (Tm - T0)(1 - exp(-k p)), k = heat A/(Tm - T0)."""
    A, strain, errors = 600.0, 1.0, []
    law = _array(replace(HOT, A_Pa=A * 1e6, B_Pa=0.0, m=1.0), thermal=True)
    melt, heat = law[16] - law[15], law[17]
    for steps in (100, 200, 400):
        folder = scratch / f"heat{steps}"
        run_check(folder, f"adiabatic, {steps} steps",
                  [Parameter("real[int]", "law", law, ""), Parameter("real", "stepTime", 0.0, ""),
                   Parameter("real", "increment", strain / steps, ""), Parameter("int", "steps", steps, "")],
                  ["points_axisym_kernel.idp", "checks/uniaxial_rate.edp"])  # fmt: skip
        path = read_table(folder / "path.csv")
        k = heat * A / melt
        stress, tau = A * np.exp(-k * path["peeq"][-1]), melt * -np.expm1(-k * path["peeq"][-1])
        errors.append(abs(path["tau"][-1] / tau - 1.0))
        if steps == 400:
            rows.below("adiabatic heating to strain 1: temperature rise", errors[-1], 2e-3, f"{tau:.1f} K")
            rows.below("adiabatic heating to strain 1: stress", abs(path["stress"][-1] / stress - 1.0), 2e-3,
                       f"{stress:.1f} of {A:.0f} MPa left")  # fmt: skip
    rows.within("adiabatic heating: order in the step (implicit Euler: 1)", math.log2(errors[1] / errors[2]), 1.0, 0.1)


def patches(rows: Rows, scratch: Path) -> None:
    """Homogeneous stretch of a distorted mesh with free nodes inside: one and the same state in every point."""
    cases = (
        ("small strain, elastic", "perfectly plastic", 1e-5, -3e-5, 1),
        ("stretch .9 x 1.2, Johnson-Cook", "Johnson-Cook", -0.1, 0.2, 5),
        ("stretch .9 x 1.2, combined law", "combined", -0.1, 0.2, 5),
    )
    for number, (name, law, radial, axial, steps) in enumerate(cases):
        folder = scratch / f"patch{number}"
        run_check(folder, name,
                  [Parameter("real[int]", "law", LAWS[law], ""), Parameter("real", "stretchR", radial, ""),
                   Parameter("real", "stretchZ", axial, ""), Parameter("int", "steps", steps, "")],
                  ["points_axisym_kernel.idp", "checks/patch.edp"])  # fmt: skip
        got = np.column_stack(list(read_table(folder / "patch.csv").values()))
        # The same path for one point alone: u = stretch x, so that its gradient is the stretch.
        state, before = np.zeros((1, 14)), np.zeros((1, 5))
        for k in range(1, steps + 1):
            after = np.array([[radial, 0.0, 0.0, axial, radial]]) * k / steps
            state, _, _ = update(scratch / f"point{number}-{k}", LAWS[law], np.hstack([before, after, state]), step=0.0)
            before = after
        off = np.abs(got - state[0, :5]) / np.r_[[np.abs(state[0, :4]).max()] * 4, max(state[0, 4], 1.0)]
        rows.below(f"patch, {name}: largest error", float(off.max()), 1e-12,
                   f"{len(got)} points, stress {np.abs(state[0, :4]).max():.4g} MPa, peeq {state[0, 4]:.3g}")  # fmt: skip


def newton(rows: Rows, scratch: Path) -> None:
    """A frustum upset by 4 %: the residuals of each step's last iterations fall quadratically."""
    for number, (name, law) in enumerate(LAWS.items()):
        folder = scratch / f"newton{number}"
        run_check(folder, f"Newton, {name}",
                  [Parameter("real[int]", "law", [float(v) for v in law], ""), Parameter("real", "stepTime", STEP, ""),
                   Parameter("real", "increment", 0.01, ""), Parameter("int", "steps", 4, "")],
                  ["points_axisym_kernel.idp", "checks/newton.edp"])  # fmt: skip
        table = read_table(folder / "residuals.csv")
        orders, counts = [], []
        for step in (2.0, 3.0, 4.0):
            size = table["residual"][table["step"] == step]
            counts.append(len(size) - 1)
            # The last pair that rounding (some 5e-14) does not decide.
            pairs = [(a, b) for a, b in pairwise(size) if a < 1e-2 and b > 2e-13]
            orders += [math.log(b) / math.log(a) for a, b in pairs[-1:]]
        rows.true(f"Newton, {name}: log r(k+1) / log r(k) at least 1.8 at the end of every step",
                  len(orders) == 3 and min(orders) >= 1.8,
                  f"{', '.join(f'{o:.2f}' for o in orders)}; {counts} solves a step, peeq {table['largest_peeq'][-1]:.2f}")  # fmt: skip


CHECKS = (tangents, rotations, strain_rates, heating, patches, newton)
