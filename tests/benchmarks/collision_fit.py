"""Collisions per shot as a function of their first-order number, fitted to event-driven runs and held against others.

    python tests/benchmarks/collision_fit.py [--scenes N] [--json FILE]

Scenes are Latin hypercube samples over mass flow, speed, diameter, stand-off, jet width, angle and restitution,
one set for the fit, another (other seed) to state its error.  A scene counts when it meets the rules of
``usable``, fixed before any run.  Prints the constants for glue/flow/regime.py and the errors of the ones there.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "flow"))

from scenes import bare_scene

from glue.flow import regime, surface
from glue.flow.arrivals import draw_arrivals
from glue.flow.event_driven import run_event
from glue.flow.restitution import RestitutionLaw
from glue.scene.consistency import volume_fraction

FIT_SEED, HELD_OUT_SEED = 20_240_501, 20_240_502
FIT_SCENES, HELD_OUT_SCENES = 150, 200
# (low, high, in logarithm): the ranges that scenes are drawn from
RANGES = {
    "mass_flow_kg_s": (0.2 / 60.0, 100.0 / 60.0, True),
    "speed_m_s": (20.0, 100.0, False),
    "diameter_m": (0.3e-3, 2e-3, True),
    "stand_off_m": (0.03, 0.25, False),
    "jet_diameter_m": (0.006, 0.04, True),
    "impact_angle_deg": (30.0, 100.0, False),  # beyond 90: 90, so that a seventh strikes at right angles
    "restitution": (0.3, 0.8, False),
}
PI_RANGE = (0.02, 2.0)  # of the first-order number
MAX_SOLIDS = 0.03  # of the jet's volume: denser streams are no dilute gas
MIN_JET_IN_DIAMETERS = 6.0
COLLISIONS = 1600  # expected: a Poisson error of 2.5 %
TRANSITS = 50.0  # least exposure in times from the nozzle to the target and back
MAX_SHOTS = 60_000


class Sample(NamedTuple):
    """One scene, and what the event-driven run of it gave."""

    scene: object
    restitution: float
    pi_eff: float
    collisions_per_shot: float
    energy_loss: float  # 1 - mean of (v_n / v_n of the nozzle)^2 over all impacts
    collided_share: float  # of first impacts


def drawn_scenes(seed: int, wanted: int) -> list:
    """The first ``wanted`` usable (scene, restitution) of a Latin hypercube of 16 times as many."""
    cube = qmc.LatinHypercube(len(RANGES), seed=seed).random(16 * wanted)
    found = []
    for i, row in enumerate(cube):
        values = {
            name: low * (high / low) ** u if log else low + (high - low) * u
            for (name, (low, high, log)), u in zip(RANGES.items(), row.tolist())
        }
        values["impact_angle_deg"] = min(values["impact_angle_deg"], 90.0)
        e = values.pop("restitution")
        exposed = with_exposure(bare_scene(**values, seed=seed + i), e)
        if exposed is not None:
            found.append((exposed, e))
            if len(found) == wanted:
                return found
    raise ValueError(f"only {len(found)} of {wanted} scenes are usable: draw more")


def with_exposure(scene, e: float):
    """``scene`` exposed long enough, or None when it is not usable; judged by first-order numbers alone."""
    nozzle = scene.nozzle
    pi_eff = regime.first_order_collisions(scene, e)
    above = nozzle.stand_off_m * math.sin(math.radians(nozzle.impact_angle_deg))
    if (
        not PI_RANGE[0] <= pi_eff <= PI_RANGE[1]
        or volume_fraction(scene.shots, nozzle) > MAX_SOLIDS
        or nozzle.jet_diameter_m < MIN_JET_IN_DIAMETERS * scene.shots.diameter_m
        or above < nozzle.jet_diameter_m
    ):
        return None
    shots = max(
        COLLISIONS * (1.0 + 1.3 * pi_eff) / pi_eff, TRANSITS * transit_s(nozzle, e) * scene.shot_rate_1_s
    )
    if shots > MAX_SHOTS:
        return None
    return dataclasses.replace(scene, exposure_time_s=shots / scene.shot_rate_1_s)


def transit_s(nozzle, e: float) -> float:
    """From the nozzle to the target and back [s]."""
    return nozzle.stand_off_m / nozzle.speed_m_s * (1.0 + 1.0 / e)


def measured(scene, e: float) -> Sample:
    """Run ``scene``; collisions per shot corrected to steady state by the share of the cloud's build-up.

    The first shots meet no cloud: one that leaves at t < transit meets the share t / transit of it, so that
    half a transit's shots are missing from the count (at most 1 % at ``TRANSITS``).
    """
    arrivals = draw_arrivals(scene)
    impacts, info = run_event(scene, arrivals, RestitutionLaw(e), surface.from_scene(scene))
    built_up = 1.0 - 0.5 * transit_s(scene.nozzle, e) / scene.exposure_time_s
    normal = np.abs(impacts["vz_in_m_s"]) / scene.nozzle.normal_speed_m_s
    return Sample(
        scene,
        e,
        regime.first_order_collisions(scene, e),
        info["shot_shot_collisions"] / len(arrivals) / built_up,
        1.0 - float((normal**2).mean()),
        info["collided_fraction"],
    )


def run_all(seed: int, wanted: int, label: str) -> list[Sample]:
    """All samples of one set, with the time left on stderr."""
    scenes, samples, begun = drawn_scenes(seed, wanted), [], time.monotonic()
    for i, (scene, e) in enumerate(scenes):
        samples.append(measured(scene, e))
        left = (time.monotonic() - begun) / (i + 1) * (len(scenes) - i - 1)
        if sys.stderr.isatty():  # one line, written over
            print(
                f"\r{label}: {i + 1}/{len(scenes)}, {left:.0f} s left ", end="", file=sys.stderr, flush=True
            )
    return samples


def fit(samples: list[Sample]) -> dict[str, float]:
    """The constants of ``regime.settled`` and of the energy loss that fit ``samples`` best, relative errors equal."""
    pi, crossing, sine, e, n, loss = columns(samples)

    def off_collisions(c):
        again = c[0] * crossing ** c[1] * sine**2 / np.sqrt(e)
        return np.log(pi * (1.0 + again) / (1.0 + c[2] * pi * sine**4) / n)

    def off_energy(c):
        return np.log(c[0] * n / (1.0 + c[1] * n) / loss)

    best = least_squares(off_collisions, (1.0, 1.0, 1.0), bounds=(0.0, np.inf)).x
    energy = least_squares(off_energy, (1.0, 1.0), bounds=(0.0, np.inf)).x
    names = ("CASCADE", "CASCADE_POWER", "THINNING", "ENERGY_LOSS", "ENERGY_LOSS_ENDS")
    return dict(zip(names, [*best.tolist(), *energy.tolist()]))


def columns(samples: list[Sample]) -> tuple[np.ndarray, ...]:
    """pi_eff, crossing number, sine of the angle, restitution, collisions per shot, energy loss; each (n,)."""
    rows = [
        (
            s.pi_eff,
            regime.crossing_number(s.scene),
            math.sin(math.radians(s.scene.nozzle.impact_angle_deg)),
            s.restitution,
            s.collisions_per_shot,
            s.energy_loss,
        )
        for s in samples
    ]
    return tuple(np.array(rows).T)


def errors(samples: list[Sample]) -> dict[str, float]:
    """How far ``regime`` as it stands is off: relative rms and worst, of collisions per shot and of energy loss."""
    n = np.array([regime.collision_number(s.scene, s.restitution)["collisions_per_shot"] for s in samples])
    off = n / np.array([s.collisions_per_shot for s in samples]) - 1.0
    measured_n = np.array([s.collisions_per_shot for s in samples])
    loss = regime.ENERGY_LOSS * measured_n / (1.0 + regime.ENERGY_LOSS_ENDS * measured_n)
    off_loss = loss / np.array([s.energy_loss for s in samples]) - 1.0
    return {
        "scenes": len(samples),
        "collisions_rms": float(np.sqrt(np.mean(off**2))),
        "collisions_worst": float(np.abs(off).max()),
        "collisions_mean": float(off.mean()),
        "energy_loss_rms": float(np.sqrt(np.mean(off_loss**2))),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=HELD_OUT_SCENES, help="held-out scenes (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers here")
    args = parser.parse_args()
    fitted = run_all(FIT_SEED, FIT_SCENES, "fit")
    constants = fit(fitted)
    for name, value in constants.items():
        print(f"{name:<18} fitted {value:.3f}   in regime.py {getattr(regime, name):.3f}")
    found = {"constants": constants, "fit": errors(fitted)}
    found["held_out"] = errors(run_all(HELD_OUT_SEED, args.scenes, "held out"))
    for label in ("fit", "held_out"):
        e = found[label]
        print(
            f"{label:<9} {e['scenes']} scenes: collisions per shot off by {e['collisions_rms']:.1%} rms,"
            f" {e['collisions_worst']:.1%} at worst, {e['collisions_mean']:+.1%} in the mean;"
            f" energy loss {e['energy_loss_rms']:.1%} rms"
        )
    if args.json:
        args.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
