"""Cells of what is read off a log without a solver: coverage, roughness, layers of stress, plates; all against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
from judges import Finding, at_most, equal, near, rising, true

from glue.flow.impacts import COLUMNS
from glue.scene.catalogue import material
from glue.surface.coverage import coverage_history
from glue.surface.roughness import areal
from glue.surface.stamp import height_map, stamp_of
from glue.surface.stress import plate_balance
from glue.target.layers import LayerShape, layer_profile, layer_shape
from glue.target.reduced_impact import solve_reduced
from glue.target.strength import full_strength_Pa
from glue.theory import avrami
from glue.theory.plate import curvature_1_m, released_stress

WINDOW = 1.0  # side, in units of the case


def lattice_error(radius: float, spacing: float) -> float:
    """Largest error of a disc's area on a lattice over the disc's: its edge crosses 4 r / s cells, each off by half at most.

    Their errors are of both signs, so that the sum goes by the root of their number; 3 sigma of cells off by 1/sqrt(12).
    """
    cells = 2.0 * math.pi * radius / spacing
    return 3.0 * math.sqrt(cells / 12.0) * spacing**2 / (math.pi * radius**2)


def coverage(values: dict) -> list[Finding]:
    """Coverage of a window of side 1 by discs of ``radius``, with ``points`` sample points per radius."""
    r, s = values["radius"], values["radius"] / values["points"]
    case = values["case"]
    corner = 0.5 * WINDOW
    area = math.pi * r**2 / WINDOW**2
    exact = {
        "none": ([], 0.0), "one": ([(0.0, 0.0)], area), "on the edge": ([(corner, 0.0)], 0.5 * area),
        "in the corner": ([(corner, corner)], 0.25 * area), "just outside": ([(corner + 1.0001 * r, 0.0)], 0.0),
        "ten coincident": ([(0.1, -0.05)] * 10, area), "two apart": ([(-0.25, 0.0), (0.25, 0.0)], 2.0 * area),
        "two by half a radius": ([(0.0, 0.0), (0.5 * r, 0.0)], 2.0 * area - float(avrami.disc_overlap_m2(r, 0.5 * r)) / WINDOW**2),
    }  # fmt: skip
    if case in exact:
        centres, share = exact[case]
        x, y = np.array(centres, float).reshape(-1, 2).T
        n = len(x)
        got = coverage_history(x, y, np.arange(n), np.full(n, r), np.full(n, r), np.zeros(n), (WINDOW, WINDOW), s)
        final = float(got.coverage[-1]) if n else 0.0
        if share == 0.0:
            return [equal(f"coverage of {case}: none", final, 0.0)]
        discs = 1.0 if "two" not in case else 2.0
        return [near(f"coverage of {case}: area of the disc", final, share, 4.0 * discs * lattice_error(r, s)),
                equal("coincident impacts add nothing", np.ptp(got.coverage) if case == "ten coincident" else 0.0, 0.0),
                at_most("coverage within the window", final, 1.0)]  # fmt: skip
    if case == "ellipse":  # 8 to 1, turned: same area, whatever its direction
        got = [
            coverage_history([0.0], [0.0], [0.0], [r * math.sqrt(8.0)], [r / math.sqrt(8.0)], [turn], (WINDOW, WINDOW), s / 3.0).coverage[-1]
            for turn in (0.0, 0.4, 1.2, math.pi / 2)
        ]
        return [near("area of an ellipse, however turned", got, area, 8.0 * lattice_error(r / math.sqrt(8.0), s / 3.0))]
    return poisson(values, r, s)


def poisson(values: dict, r: float, s: float) -> list[Finding]:
    """Random impacts: Avrami within 4 of Robbins' exact standard deviations; coverage never falls; sizes mixed to ratio."""
    exposure, ratio = values["exposure"], values.get("ratio", 1.0)
    rng = np.random.default_rng(7)
    sizes = np.array([r, r / ratio]) if ratio > 1.0 else np.array([r])
    mean2 = float((sizes**2).mean())
    side = WINDOW + 2.0 * r
    n = rng.poisson(exposure * side**2 / (math.pi * mean2))
    radius = rng.choice(sizes, n)
    x, y = rng.uniform(-0.5 * side, 0.5 * side, (2, n))
    got = coverage_history(x, y, np.arange(n), radius, radius, np.zeros(n), (WINDOW, WINDOW), s)
    expected = float(-np.expm1(-exposure))
    sd = avrami.coverage_sd(expected, sizes, (WINDOW, WINDOW))
    final = float(got.coverage[-1]) if n else 0.0
    return [
        at_most("Avrami within 4 Poisson sigma", abs(final - expected), 4.0 * sd + lattice_error(r, s)),
        rising("coverage never falls", got.coverage),
        at_most("coverage within the window", final, 1.0),
    ]


@cache
def _made_up(radius: float = 0.2) -> SimpleNamespace:
    """A dimple with a parabolic dent and a pile-up; lengths in mm would do as well: no unit enters."""
    r = np.linspace(0.0, 6.0 * radius, 2000)
    depth = 0.25 * radius
    z = np.where(r < radius, -depth * (1.0 - (r / radius) ** 2), 0.1 * depth * np.exp(-((r / radius - 1.3) ** 2) / 0.05))
    return SimpleNamespace(
        radius_m=radius, depth_m=depth, profile_r_m=r, profile_z_m=z, restitution=0.3, speed_m_s=60.0, diameter_m=1.0,
        density_kg_m3=7800.0, radius_for=lambda d, v, rho: radius * np.asarray(d) * np.sqrt(np.asarray(v) / 60.0),
    )  # fmt: skip


def _log(x, y, diameter=1.0, speed=60.0) -> np.ndarray:
    log = np.zeros(len(x), COLUMNS)
    log["x_m"], log["y_m"], log["nz"], log["density_kg_m3"] = x, y, 1.0, 7800.0
    log["diameter_m"], log["vz_in_m_s"], log["time_s"] = diameter, -np.asarray(speed, float), np.arange(len(x))
    return log


def stamp(values: dict) -> list[Finding]:
    """Height maps of few impacts: volume and depth of one, ten coincident, edge and corner, any spacing and size."""
    d, points, case = _made_up(), values["points"], values["case"]
    size = values.get("size", 1.0)
    spacing, window = d.radius_m / points, (3.0 * size, 3.0 * size)
    soft = values.get("hardening", 0.0)
    one = stamp_of(d)
    places = {"none": [], "one": [(0.0, 0.0)], "ten coincident": [(0.0, 0.0)] * 10, "on the edge": [(1.5, 0.0)],
              "in the corner": [(1.5, 1.5)], "far outside": [(9.0, 0.0)]}[case]  # fmt: skip
    x, y = size * np.array(places, float).reshape(-1, 2).T
    log = _log(x, y, size)
    flow = lambda p: 1e9 + soft * p  # noqa: E731
    gx, gy, z = height_map(log, d, window, spacing * size, flow_stress_Pa=flow)
    cell = (gx[1] - gx[0]) * (gy[1] - gy[0])
    dug = float(-np.minimum(z, 0.0).sum() * cell)
    if case in ("none", "far outside"):
        flat = areal(z, gx[1] - gx[0], gy[1] - gy[0])
        return [equal("no impact, no height", np.abs(z).max(), 0.0), equal("Sa of a flat surface", flat["Sa_m"], 0.0)]
    # the stamp pays for its volume to 1e-12 on the grid; what of it lies in the window is the disc's share, to a grid line
    share = {"on the edge": 0.5, "in the corner": 0.25}.get(case, 1.0)
    first = height_map(_log([0.0], [0.0], size), d, window, spacing * size, flow_stress_Pa=flow)[2]
    # a spherical cap in place of the paraboloid: the same volume to (depth/radius)^2, and a rim of a cell
    rim = 2.0 / points + 0.05
    found = [near("volume dug by one impact", float(-np.minimum(first, 0.0).sum() * cell), one.volume_m3 * size**3, 0.02 + 1.0 / points**1.5)]
    if case == "ten coincident":
        depths = [float(-height_map(_log([0.0] * n, [0.0] * n, size), d, window, spacing * size, flow_stress_Pa=flow)[2].min()) for n in range(1, 11)]
        found += [rising("depth rises from hit to hit", depths), rising("it rises by less each time", -np.diff(depths), 1e-3)]
    else:
        found.append(near("share of the dent in the window", dug, share * one.volume_m3 * size**3, rim))
    rough = areal(z, gx[1] - gx[0], gy[1] - gy[0], "mean")
    found.append(near("Sz is the height between the extremes", rough["Sz_m"], z.max() - z.min(), 1e-12))
    found.append(at_most("Sa <= Sq <= Sz", max(rough["Sa_m"] / rough["Sq_m"], rough["Sq_m"] / rough["Sz_m"]), 1.0))
    return found


@cache
def _shape(key: str, speed: float) -> LayerShape:
    target = material(key)
    impact = solve_reduced(target, target.combined, speed_m_s=speed, density_kg_m3=7800.0, elements_per_radius=3)
    return layer_shape(impact, target.combined)


def layers(values: dict) -> list[Finding]:
    """The layer model: thin exposures exact, strength never exceeded, nothing but exposure and sizes in it."""
    target = material(values["material"])
    shape, exposure = _shape(values["material"], values["speed_m_s"]), values["exposure"]
    radius, count = 0.2e-3, values.get("count", 100)
    area = count * math.pi * radius**2 / exposure if exposure else 1.0
    radii = np.full(count if exposure else 0, radius)
    got = layer_profile(shape, target, radii, area)
    law = target.combined
    monotone = law.R0_Pa + law.Q_Pa + sum(x for x, _ in law.backstresses)
    half = layer_profile(shape, target, radii[: count // 2], area, got.depth_m)
    tenfold = layer_profile(shape, target, np.repeat(radii, 10), 10.0 * area, got.depth_m)
    larger = layer_profile(shape, target, 100.0 * radii, 1e4 * area, 100.0 * got.depth_m)
    peak = np.abs(got.sigma_xx_Pa).max()
    return [
        near("exposure is dimple areas over area", got.exposure, exposure, 1e-12),
        equal("same exposure, ten times the area and impacts: same stress", tenfold.sigma_xx_Pa / peak, got.sigma_xx_Pa / peak, 1e-9),
        equal("100 times the size: the same stress 100 times as deep", larger.sigma_xx_Pa / peak, got.sigma_xx_Pa / peak, 1e-9),
        at_most("stress within the law's full strength", peak, monotone),
        at_most("stress within what lone impacts would sum to", np.max(np.abs(got.sigma_xx_Pa) - np.abs(got.linear_Pa)) / peak, 1e-9),
        rising("twice the exposure, no less stress", [np.abs(half.sigma_xx_Pa).max(), peak], 1e-9),
        at_most("plastic strain not negative", -got.peeq.min(), 0.0),
        true("fades with depth", abs(got.sigma_xx_Pa[-1]) < 0.05 * peak),
        true("strength of the model is that of its law or less", full_strength_Pa(law, 93.4, 15.4) <= monotone),
    ]


def plate(values: dict) -> list[Finding]:
    """A clamped layer's stress let go: no force, no moment, and the curvature of the closed form."""
    h, depth, n = values["thickness_m"], values["layer_m"], values["points"]
    z = np.unique(np.r_[0.0, np.linspace(0.0, min(depth, h), n), np.linspace(min(depth, h), h, n)])
    shape = values["shape"]
    profile = {"uniform": np.ones_like(z), "step": (z <= depth).astype(float), "ramp": np.maximum(1.0 - z / depth, 0.0),
               "wave": np.cos(6.0 * z / depth) * np.exp(-z / depth)}[shape]  # fmt: skip
    clamped = -5e8 * profile
    free = released_stress(z, clamped, h)
    force, moment = plate_balance(z, free)
    kappa = curvature_1_m(z, clamped, h, 70e9, 0.33)
    found = [
        at_most("force of the free plate over max|s| h", abs(force), 1e-12 if shape != "uniform" else 1e-6),
        at_most("moment of the free plate over max|s| h2", abs(moment), 1e-12 if shape != "uniform" else 1e-6),
    ]
    if shape == "uniform":  # stretches, does not bend, keeps no stress
        return [at_most("uniform: nothing left, over the clamped stress", np.abs(free).max() / 5e8, 1e-9),
                at_most("uniform: no curvature, times the thickness", abs(kappa) * h, 1e-12)]  # fmt: skip
    if shape == "ramp" and depth < h:  # N = s d/2 at d/3: M about the middle
        exact = 12.0 * (1.0 - 0.33) / (70e9 * h**3) * 5e8 * 0.5 * depth * (0.5 * h - depth / 3.0)
        found.append(near("curvature in closed form", kappa, exact, 1e-9))
    return found


def strain_bound(values: dict) -> list[Finding]:
    """Hardening laws to any strain: rising, bounded where they say so, and the work's inverse."""
    from glue.target.strength import plastic_work_Pa, strain_of_work

    law = replace(material("al2024-t351").combined, b=values["b"], Q_Pa=values["Q_Pa"])
    p = np.geomspace(1e-8, values["strain"], 200)
    flow = np.array([law.flow_stress_Pa(float(x)) for x in p])
    top = law.R0_Pa + law.Q_Pa + sum(x for x, _ in law.backstresses)
    return [
        rising("flow stress rises with strain", flow, 1e-15),
        at_most("flow stress below its bound", flow.max(), top * (1.0 + 1e-12)),
        near("strain of the work of a strain", strain_of_work(law, plastic_work_Pa(law, p)), p, 1e-6),
    ]
