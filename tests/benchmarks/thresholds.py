"""Thresholds of optional physics: each piece swept over its number, off and on; where it starts to matter (make thresholds).

    python tests/benchmarks/thresholds.py [--only NAME ...] [--json FILE]

A row per piece: the largest change of its metric among the points whose number lies within the threshold that the code
decides by, against the tolerance; its note says at which number the change reaches the tolerance, and what the piece costs.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "flow")]

from scenes import bare_scene

from glue.checkrows import Rows
from glue.flow import regime as flow_regime
from glue.flow.arrivals import draw_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.drag import drag_number
from glue.flow.event_driven import run_event
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.catalogue import material, shot
from glue.scene.consistency import estimated_dimple_radius_m
from glue.scene.effects import AirDrag, Gravity
from glue.scene.model import CombinedHardening, Friction, HardeningTable
from glue.study import pieces
from glue.target import regime
from glue.target.dimple import zero_height_radius
from glue.target.layers import layer_profile, layer_shape
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import Numerics, ReducedImpact, solve_reduced
from glue.theory.plate import released_stress

AL2024, STEEL = material("al2024-t351"), shot("S390")
PLANE = TargetSurface()


class Point(NamedTuple):
    """One point of a sweep: the piece's number, change of its metric when it is left out, cost on over cost off."""

    number: float
    change: float
    cost: float = math.nan
    label: str = ""


def reaches(points: list[Point], tolerance: float) -> float:
    """Number at which the change first reaches ``tolerance``: straight in logarithms; inf when none does."""
    points = sorted(points)
    for low, high in zip(points, points[1:]):
        if low.change < tolerance <= high.change:
            share = math.log(tolerance / max(low.change, 1e-9)) / math.log(high.change / max(low.change, 1e-9))
            return low.number * (high.number / low.number) ** share
    return points[0].number if points and points[0].change >= tolerance else math.inf


# --- the shot stream -------------------------------------------------------------------------------------------------
def _energy(impacts: np.ndarray) -> float:
    return float((impacts["vz_in_m_s"] ** 2).mean())


def _event(scene, e: float = 0.5) -> tuple[np.ndarray, float]:
    arrivals = draw_arrivals(scene)
    begun = time.perf_counter()
    impacts, _ = run_event(scene, arrivals, RestitutionLaw(e), PLANE)
    return impacts, time.perf_counter() - begun


def _ballistic(scene, e: float = 0.5) -> tuple[np.ndarray, float]:
    arrivals = draw_arrivals(scene)
    begun = time.perf_counter()
    impacts, _ = run_ballistic(scene, arrivals, RestitutionLaw(e), PLANE)
    return impacts, time.perf_counter() - begun


def collisions() -> Iterator[Point]:
    """Mean normal energy and impacts per shot of streams whose shots meet, against those whose do not; number: pi_eff."""
    for flow in (0.003, 0.01, 0.02, 0.05, 0.1, 0.3):
        scene = bare_scene(mass_flow_kg_s=flow / 60.0)
        scene = dataclasses.replace(scene, exposure_time_s=20_000 / scene.shot_rate_1_s)
        (met, on_s), (alone, off_s) = _event(scene), _ballistic(scene)
        number = flow_regime.collision_number(scene, 0.5)["pi_eff"]
        yield Point(number, abs(_energy(met) / _energy(alone) - 1.0), on_s / off_s, f"{flow:g} kg/min")


def gravity() -> Iterator[Point]:
    """Mean normal energy of a jet shot straight down, and the sag of a level one over its radius."""
    for speed in (3.0, 8.0, 15.0, 30.0, 60.0):
        for angle in (90.0, 30.0):
            plain = bare_scene(speed_m_s=speed, impact_angle_deg=angle, mass_flow_kg_s=1e-3, exposure_time_s=0.2)
            with_it = dataclasses.replace(plain, gravity=Gravity(9.81))
            (a, on_s), (b, off_s) = _ballistic(with_it), _ballistic(plain)
            energy = abs(_speed2(a) / _speed2(b) - 1.0)
            moved = float(np.hypot(a["x_m"] - b["x_m"], a["y_m"] - b["y_m"]).max() / (0.5 * plain.nozzle.jet_diameter_m))
            moved *= math.sin(math.radians(angle))  # across the jet, not along the plane it meets
            yield Point(flow_regime.gravity_number(with_it), max(energy, moved), on_s / off_s, f"{speed:g} m/s, {angle:g} deg")


def _speed2(impacts: np.ndarray) -> float:
    return float(sum(impacts[f"v{a}_in_m_s"] ** 2 for a in "xyz").mean())


def drag() -> Iterator[Point]:
    """Energy of the impacts of glass and steel of many sizes, still air."""
    for diameter, density in ((5e-3, 7800.0), (1e-3, 7800.0), (0.3e-3, 7800.0), (0.1e-3, 7800.0), (0.1e-3, 2500.0), (0.05e-3, 2500.0)):
        plain = bare_scene(diameter_m=diameter, density_kg_m3=density, mass_flow_kg_s=1e-3)
        plain = dataclasses.replace(plain, exposure_time_s=50 / plain.shot_rate_1_s)
        with_it = dataclasses.replace(plain, air_drag=AirDrag(1.204, 1.81e-5))
        (a, on_s), (b, off_s) = _ballistic(with_it), _ballistic(plain)
        yield Point(2.0 * drag_number(with_it), abs(_speed2(a) / _speed2(b) - 1.0), on_s / off_s, f"{diameter * 1e3:g} mm")


def friction() -> Iterator[Point]:
    """Mean normal energy of impacts with friction and spin against smooth shots; number: ``pieces.friction_number``."""
    for mu in (0.02, 0.05, 0.1, 0.2, 0.5):
        for flow, angle in ((0.1, 90.0), (1.0, 90.0), (1.0, 45.0), (5.0, 45.0)):
            scene = bare_scene(mass_flow_kg_s=flow / 60.0, impact_angle_deg=angle)
            scene = dataclasses.replace(scene, exposure_time_s=20_000 / scene.shot_rate_1_s, friction=Friction(mu, mu))
            smooth = dataclasses.replace(scene, friction=Friction(0.0, 0.0))
            (rough, on_s), (even, off_s) = _event(scene), _event(smooth)
            yield Point(pieces.friction_number(scene, 0.5), abs(_energy(rough) / _energy(even) - 1.0), on_s / off_s, f"mu {mu:g}, {flow:g} kg/min, {angle:g} deg")


# --- the single impact -----------------------------------------------------------------------------------------------
def _impact(target, shots, speed: float, law=None, numerics: Numerics = Numerics(), **physics) -> ReducedImpact:  # noqa: B008 - frozen
    return solve_reduced(target, law or target.single_law, speed_m_s=speed, density_kg_m3=shots.density_kg_m3, elements_per_radius=3,
                         numerics=numerics, physics=ImpactPhysics(**physics))  # fmt: skip


def _change(number: float, on: ReducedImpact, off: ReducedImpact, label: str) -> Point:
    """Relative change of restitution or of the dimple's radius, the larger."""
    radius = abs(zero_height_radius(on) / zero_height_radius(off) - 1.0)
    return Point(number, max(abs(on.restitution / off.restitution - 1.0), radius), on.wall_s / off.wall_s, label)


def elastic_shot() -> Iterator[Point]:
    """Shots from very stiff to steel on 2024."""
    off = _impact(AL2024, STEEL, 60.0)
    for modulus in (8e12, 4e12, 2e12, 1e12, 210e9):
        shots = dataclasses.replace(STEEL, E_Pa=modulus)
        on = _impact(AL2024, shots, 60.0, elastic_shot=(modulus, 0.3))
        yield _change(regime.elastic_shot_number(AL2024, shots), on, off, f"E {modulus * 1e-9:g} GPa")


def target_inertia() -> Iterator[Point]:
    """Targets from light (their waves are fast) to 2024's own density, in a block three times as wide as usual.

    The usual one's dashpots hold it less than its clamped sides do, which alone changes e by 3 % where inertia does nothing.
    """
    wide = Numerics(domain_radii=60.0)
    off = _impact(AL2024, STEEL, 60.0, numerics=wide)
    for density in (30.0, 60.0, 150.0, 700.0, 2780.0):
        target = dataclasses.replace(AL2024, density_kg_m3=density)
        on = _impact(target, STEEL, 60.0, numerics=wide, inertia=True)
        yield _change(regime.inertia_number(target, STEEL, 60.0), on, off, f"{density:g} kg/m3")


def strain_rate() -> Iterator[Point]:
    """Rate constants from a tenth of 2024's on."""
    off = _impact(AL2024, STEEL, 60.0)
    for C in (0.001, 0.002, 0.004, 0.008, 0.015):
        target = dataclasses.replace(AL2024, johnson_cook=dataclasses.replace(AL2024.johnson_cook, C=C))
        on = _impact(target, STEEL, 60.0, rate=True, radius_m=0.5e-3)
        yield _change(regime.rate_number(target, STEEL, 60.0), on, off, f"C {C:g}")


def heating() -> Iterator[Point]:
    """2024 at speeds; against the rate term alone."""
    for speed in (5.0, 30.0, 60.0, 120.0, 200.0, 300.0):
        on = _impact(AL2024, STEEL, speed, rate=True, thermal=True, radius_m=0.5e-3)
        off = _impact(AL2024, STEEL, speed, rate=True, radius_m=0.5e-3)
        yield _change(regime.heat_number(AL2024, STEEL, speed), on, off, f"{speed:g} m/s")


def friction_in_dimple() -> Iterator[Point]:
    """Coulomb's coefficient while the dimple is pressed."""
    off = _impact(AL2024, STEEL, 60.0)
    for mu in (0.02, 0.05, 0.1, 0.2, 0.5):
        yield _change(mu, _impact(AL2024, STEEL, 60.0, friction=mu), off, f"mu {mu:g}")


def kinematic_hardening() -> Iterator[Point]:
    """A bounded law whose hardening is shared out between backstresses and the isotropic part: the same monotonic curve."""
    strain = np.concatenate([[0.0], np.geomspace(1e-5, 5.0, 45)])
    for share in (0.05, 0.1, 0.2, 0.35, 0.5):
        top, rate = 540e6, 20.0
        law = CombinedHardening((1.0 - share) * top, 0.0, 1.0, ((share * top, rate),))
        curve = HardeningTable(tuple(strain), tuple(law.flow_stress_Pa(p) for p in strain))
        on, off = _impact(AL2024, STEEL, 60.0, law), _impact(AL2024, STEEL, 60.0, curve)
        yield _change(pieces.backstress_share(law), on, off, f"X {share:g} of the strength")


def finite_strain() -> Iterator[Point]:
    """Speeds: at finite strain, and as if nothing had moved.  Number: Tabor's strain of the estimated dimple."""
    for speed in (1.0, 4.0, 8.0, 15.0, 30.0, 60.0):
        radius = estimated_dimple_radius_m(STEEL, speed, AL2024) / (0.5 * STEEL.diameter_m)
        on, off = _impact(AL2024, STEEL, speed), _impact(AL2024, STEEL, speed, small_strain=True)
        yield _change(regime.TABOR * radius, on, off, f"{speed:g} m/s")


# --- residual stress -------------------------------------------------------------------------------------------------
def overlap() -> Iterator[Point]:
    """Largest stress of the layer model against the sum of lone impacts; number: exposure."""
    impact = _impact(AL2024, STEEL, 60.0, AL2024.combined)
    shape = layer_shape(impact, AL2024.combined)
    for exposure in (1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0):
        area = 100 * math.pi * 0.2e-3**2 / exposure
        got = layer_profile(shape, AL2024, np.full(100, 0.2e-3), area)
        yield Point(exposure, float(abs(np.abs(got.linear_Pa).max() / np.abs(got.sigma_xx_Pa).max() - 1.0)), 1.0, f"exposure {exposure:g}")


def thickness() -> Iterator[Point]:
    """Largest compression of a plate let go against one too thick to stretch; number: peened depth over thickness."""
    depth = 3.0 * 0.227e-3
    for ratio in (1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3):
        h = depth / ratio
        z = np.unique(np.r_[np.linspace(0.0, depth, 300), np.linspace(depth, h, 300)])
        held = -3e8 * np.where(z < depth, 1.0 - (z / depth) ** 2, 0.0)  # falls to nought at the peened depth
        free = released_stress(z, held, h)
        yield Point(ratio, abs(free.min() / held.min() - 1.0), 1.0, f"{h * 1e3:.3g} mm")


SWEEPS = {
    "collisions": (collisions, "change of mean normal energy"),
    "gravity": (gravity, "change of energy, or way off over the jet's radius"),
    "air_drag": (drag, "change of energy"),
    "friction": (friction, "change of mean normal energy"),
    "elastic_shot": (elastic_shot, "change of e or radius"),
    "target_inertia": (target_inertia, "change of e or radius"),
    "strain_rate": (strain_rate, "change of e or radius"),
    "heating": (heating, "change of e or radius"),
    "friction_in_dimple": (friction_in_dimple, "change of e or radius"),
    "kinematic_hardening": (kinematic_hardening, "change of e or radius"),
    "finite_strain": (finite_strain, "change of e or radius"),
    "overlap": (overlap, "change of the largest stress"),
    "thickness": (thickness, "change of the largest stress"),
}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", nargs="+", choices=SWEEPS)
    options, sys.argv[1:] = parser.parse_known_args()
    rows = Rows("thresholds of optional physics")
    names = options.only or list(SWEEPS)
    begun = time.monotonic()
    for k, name in enumerate(names):
        sweep, metric = SWEEPS[name]
        points = sorted(sweep())
        limit, tolerance = pieces.THRESHOLDS[name], pieces.TOLERANCES[name]
        inside = [p.change for p in points if p.number <= limit]
        costs = [p.cost for p in points if math.isfinite(p.cost)]
        told = "; ".join(f"{p.number:.3g}: {p.change:.2%} ({p.label})" for p in points)
        rows.below(f"{name}: {metric}, number up to {limit:g}", max(inside, default=0.0), tolerance,
                   f"reaches {tolerance:.1%} at {reaches(points, tolerance):.3g}; costs {np.median(costs):.2f} times; {told}")  # fmt: skip
        rows.true(f"{name}: points on both sides of the threshold", bool(inside) and len(inside) < len(points), f"{len(points)} points")
        left = (time.monotonic() - begun) / (k + 1) * (len(names) - k - 1)
        print(f"thresholds: {k + 1} of {len(names)} pieces, about {left:.0f} s left", file=sys.stderr, flush=True)
    rows.finish()


if __name__ == "__main__":
    main()
