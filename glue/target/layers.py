"""The target in milliseconds: residual stress over the depth from one impact and the list of all impacts.

One axisymmetric impact with the target's bounded law gives three functions of the depth z in dimple radii a, zeta =
z/a: integrals over the whole plane at that (undeformed) depth, per dimple area,

    s(zeta) = -1/(pi a^2) int (s_rr + s_tt)/2 dA            [Pa]                                         (1)
    p(zeta) =  1/(pi a^2) int peeq dA                       [-]                                          (2)
    h(zeta) =  1/(pi a^2) int (1 - exp(-b peeq)) dA         [-]   b: rate of the isotropic hardening      (3)

The block's sides are clamped, so s is E/(1-nu) times the in-plane plastic strain, the stress that this strain means
in a part too thick to stretch; it vanishes where p does.  Impacts with dimple radii a_i on an area A:

    w_i = pi a_i^2/A,   lambda = sum w_i                               the exposure                      (4)
    lin(z) = sum w_i s(z/a_i)                                          if none met another's strain      (5)
    W(pbar) = sum w_i r_i W(p(z/a_i))                                  plastic work is additive          (6)
    Y(z) = R0 + Q (1 - exp(-sum w_i h(z/a_i))) + sum phi_j X_j (1 - exp(-g_j pbar))                      (7)
    cap(z) = Y [R - D <exp(-zeta/d)>] [1 - exp(-m/c)]                  what full coverage leaves         (8)
    |sigma| = (|lin|^-k + cap^-k)^(-1/k),   k = k0 + k1 m                                                (9)
    m(z) = |lin|/(lambda max s)                                        share of an impact felt there

r_i is impact i's energy over a_i^3, relative to that of the impact solved: slow ones strain less in their dimple.
<> is the mean with weights w_i.  (7), W and phi: see ``glue.target.strength``.  Isotropic hardening stays where it was
made; its mean over places hit at random, plastic strains adding, is exact (Campbell's theorem of Poisson processes).
Backstresses turn everywhere with the first strains, so they go by pbar.  (8): the surface is free, and below the plastic
zone there is nothing to cap.  It all needs a bounded law.

Source: (1), (2), (4)-(6), (9), the bracket with R, D, d and the idea of phi were found on cells of an earlier code (2024
and variations of its law, 27-80 m/s); the rest came from the training cases of tests/benchmarks/layers_fit.py, to which
all constants are fitted and which judges them on other materials, laws, speeds and exposures.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow.impacts import normal_speed_m_s
from glue.scene.model import CombinedHardening, Material, Scene
from glue.scene.presets import CELL_DEPTH_IN_RADII
from glue.target.dimple import Dimple, zero_height_radius
from glue.target.patch import normal_energy_J
from glue.target.plane_integrals import plane_integrals
from glue.target.reduced_impact import ReducedImpact, solve_reduced
from glue.target.strength import full_strength_Pa, held, plastic_work_Pa, refuse_unbounded, strain_of_work


class Constants(NamedTuple):
    """Of equations (8), (9) and phi in (7), all dimensionless."""

    R: float
    D: float
    d: float
    c: float
    k0: float
    k1: float
    g0: float
    g1: float


CONSTANTS = Constants(R=0.760, D=0.180, d=0.175, c=0.119, k0=1.272, k1=2.304, g0=93.4, g1=15.4)


class Range(NamedTuple):
    """``low`` to ``high``: what the cases of the fit and its judging span.  A warning beyond, a refusal past the rest."""

    least: float
    low: float
    high: float
    most: float


CALIBRATED = {
    "exposure": Range(0.0, 0.136, 8.05, 24.0),  # (5) is exact for 0; plateaus were seen to stay up to 24
    "full strength over E": Range(0.0013, 0.0026, 0.0096, 0.0144),
    "full strength over R0": Range(0.9, 1.16, 2.78, 4.0),
    "dimple radius over shot radius": Range(0.11, 0.22, 0.594, 0.75),
}

_BINS, _PLANES = 96, 12  # of the depth, finer towards the surface; planes a bin
_NO_STRAIN = 1e-3  # of the largest p: there the plastic zone has ended
_CLASSES = 48  # more different dimple radii than that are put together in classes


@dataclass(frozen=True)
class LayerShape:
    """Equations (1) to (3) of one impact; no size of a shot in it."""

    zeta: np.ndarray  # (n,) depth in dimple radii, rising
    s_Pa: np.ndarray  # (n,) above 0: compression
    p: np.ndarray  # (n,)
    h: np.ndarray  # (n,) belongs to the law of the impact
    radius_R: float  # dimple radius over shot radius


@dataclass(frozen=True)
class LayersResult:
    """As ``CellResult`` where names are the same: a part too thick to stretch or bend, compression below 0."""

    depth_m: np.ndarray  # (n,) rising
    sigma_xx_Pa: np.ndarray  # (n,)
    sigma_yy_Pa: np.ndarray
    peeq: np.ndarray  # (n,) pbar of (6)
    linear_Pa: np.ndarray  # (n,) of (5), above 0: compression
    cap_Pa: np.ndarray  # (n,) of (8)
    exposure: float
    impacts: int  # that left a dimple
    floor_m: float  # depth below which all is nought
    warnings: tuple[str, ...]
    wall_s: float
    sigma_xx_std_Pa: np.ndarray = field(init=False)  # (n,) nan: the model knows no scatter over position
    sigma_yy_std_Pa: np.ndarray = field(init=False)
    peeq_std: np.ndarray = field(init=False)

    def __post_init__(self):
        for name in ("sigma_xx_std_Pa", "sigma_yy_std_Pa", "peeq_std"):
            object.__setattr__(self, name, np.full(self.depth_m.shape, np.nan))


def solve_layers(
    scene: Scene, impacts: np.ndarray, dimple: Dimple, progress: Callable[[float, str], None] | None = None,
    shape: LayerShape | None = None,
) -> LayersResult:  # fmt: skip
    """The model for ``scene``'s target under the logged ``impacts`` (structured) that fall into its window.

    Solves one impact with the bounded law, or takes it from the cache, unless its ``shape`` is given.  Depths scale with the radii that ``dimple``
    gives each impact.  Raises InputError (see ``layer_profile``), SolverFailed, NotConverged.
    """
    material, (width, height) = scene.target.material, scene.target.window_m
    here = impacts[(np.abs(impacts["x_m"]) <= 0.5 * width) & (np.abs(impacts["y_m"]) <= 0.5 * height)]
    radii = dimple.radius_for(here["diameter_m"], normal_speed_m_s(here), here["density_kg_m3"])
    energy = normal_energy_J(here) / (0.5 * dimple.density_kg_m3 * math.pi / 6.0 * dimple.diameter_m**3 * dimple.speed_m_s**2)
    left = radii > 0.0
    if shape is None:
        impact = solve_reduced(
            material, material.combined, speed_m_s=dimple.speed_m_s, density_kg_m3=dimple.density_kg_m3,
            elements_per_radius=scene.accuracy.dimple_elements_per_radius, progress=progress,
        )  # fmt: skip
        shape = layer_shape(impact, material.combined, dimple.radius_m / (0.5 * dimple.diameter_m))
    ratio = energy[left] * (dimple.radius_m / radii[left]) ** 3
    return layer_profile(shape, material, radii[left], width * height, work_ratio=ratio)


def layer_shape(impact: ReducedImpact, law: CombinedHardening, radius_R: float | None = None) -> LayerShape:
    """Equations (1) to (3) of ``impact``, solved with ``law``; a = ``radius_R`` [R], or its own zero-height radius.

    Give the radius by which a log's impacts are measured: N impacts equal to this one then bring exactly N times (1).
    Raises NotConverged for an impact without a dimple.
    """
    a = zero_height_radius(impact) if radius_R is None else radius_R
    edges = CELL_DEPTH_IN_RADII * (np.arange(_BINS + 1) / _BINS) ** 1.5
    planes = edges[:-1, None] + np.diff(edges)[:, None] * (np.arange(_PLANES) + 0.5) / _PLANES
    points = impact.points
    fields = [-0.5e6 * (points["s_rr"] + points["s_tt"]), points["peeq"], -np.expm1(-law.b * points["peeq"])]
    found = plane_integrals(points["r"], points["z"], np.stack(fields), -a * planes.ravel()) / (math.pi * a**2)
    s, p, h = found.reshape(3, _BINS, _PLANES).mean(axis=2)
    # Without plastic strain the mean stress of a layer is nought; what is left there is error of the solution.
    yielded = p > _NO_STRAIN * p.max()
    return LayerShape(0.5 * (edges[:-1] + edges[1:]), *(np.where(yielded, v, 0.0) for v in (s, p, h)), float(a))


def layer_profile(
    shape: LayerShape, material: Material, radii_m: np.ndarray, area_m2: float, depth_m: np.ndarray | None = None,
    *, work_ratio: np.ndarray | float = 1.0, constants: Constants = CONSTANTS, check: bool = True,
) -> LayersResult:  # fmt: skip
    """Equations (4) to (9): dimple radii (n,) of the impacts on ``area_m2``, ``shape`` of one on ``material.combined``.

    work_ratio: r of (6), (n,); 1 for impacts at the speed of the one solved.
    depth_m: (m,), any; by default the middles of 60 layers, finer towards the surface, down to CELL_DEPTH_IN_RADII of the largest
    dimple.  Raises InputError: no dimple, a law without bound, beyond what ``CALIBRATED`` allows (when ``check``).
    """
    begun, law, c = time.perf_counter(), material.combined, constants
    refuse_unbounded(law)
    radii_m = np.asarray(radii_m, dtype=float)
    if not (radii_m.size and (radii_m > 0.0).all()):
        raise InputError("target = layers: no impact in the window that leaves a dimple (at least 1): a longer exposure_time_s is needed")
    sizes, areas, ratio = _classes(radii_m, np.broadcast_to(work_ratio, radii_m.shape))
    weight = areas / area_m2
    exposure, floor = float(weight.sum()), CELL_DEPTH_IN_RADII * float(sizes.max())
    warnings = _outside(law, material.E_Pa, shape, exposure) if check else ()
    depth = floor * ((np.arange(60) + 0.5) / 60) ** 1.5 if depth_m is None else np.asarray(depth_m, dtype=float)
    zeta = depth[:, None] / sizes

    def total(values: np.ndarray, factor: np.ndarray | float = 1.0) -> np.ndarray:
        return np.interp(zeta, shape.zeta, values, right=0.0) @ (weight * factor)

    linear = total(shape.s_Pa)
    peeq = strain_of_work(law, total(plastic_work_Pa(law, shape.p), ratio))
    strength = law.R0_Pa - law.Q_Pa * np.expm1(-total(shape.h))
    strength = strength - sum(x * np.expm1(-g * peeq) for x, g in held(law, c.g0, c.g1))
    felt = np.abs(linear) / (exposure * np.abs(shape.s_Pa).max())
    cap = strength * (c.R - c.D * (np.exp(-zeta / c.d) @ weight) / exposure) * -np.expm1(-felt / c.c)
    sigma = -np.sign(linear) * _smaller(np.abs(linear), cap, c.k0 + c.k1 * felt)
    return LayersResult(depth, sigma, sigma.copy(), peeq, linear, cap, exposure, radii_m.size, floor, warnings,
                        time.perf_counter() - begun)  # fmt: skip


def _smaller(a: np.ndarray, b: np.ndarray, k: np.ndarray) -> np.ndarray:
    """(a^-k + b^-k)^(-1/k) of values of 0 and more, without overflow; 0 where either is."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    return low * (1.0 + (low / np.where(high > 0.0, high, 1.0)) ** k) ** (-1.0 / k)


def _classes(radii_m: np.ndarray, ratio: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Different radii, the dimple area that each brings and its mean ``ratio``; very many go into classes of mean radius."""
    area = math.pi * radii_m**2
    different, which = np.unique(radii_m, return_inverse=True)
    if different.size > _CLASSES:
        edges = np.geomspace(different[0], different[-1], _CLASSES + 1)
        which = np.searchsorted(edges[1:-1], radii_m, side="right")
    total = np.bincount(which, area)
    used = total > 0.0
    size, mean_ratio = (np.bincount(which, area * v)[used] / total[used] for v in (radii_m, ratio))
    return size, total[used], mean_ratio


def _outside(law: CombinedHardening, E_Pa: float, shape: LayerShape, exposure: float) -> tuple[str, ...]:
    """Sentences for what lies outside ``CALIBRATED``; raises InputError for what is not allowed."""
    full = full_strength_Pa(law, CONSTANTS.g0, CONSTANTS.g1)
    values = exposure, full / E_Pa, full / law.R0_Pa, shape.radius_R
    told, refused = [], []
    for (name, span), value in zip(CALIBRATED.items(), values, strict=True):
        if not span.low <= value <= span.high:
            text = f"target = layers: {name} is {value:.3g}, calibrated {span.low:g} to {span.high:g}"
            allowed = span.least <= value <= span.most
            (told if allowed else refused).append(f"{text}, allowed {span.least:g} to {span.most:g}")
    if refused:
        raise InputError([f"{text}; target = cell has no such limit" for text in refused])
    return tuple(told)
