"""Flow benchmark: speed and agreement of all flow models, one PASS or FAIL row each (make bench-flow).

    python tests/benchmarks/bench_flow.py [--only NAME ...] [--quick] [--json FILE] [--without-liggghts]

Every seed was fixed before the first run.  Times are of one process on one core; where two are compared they
are taken in turns.  Rows that need LIGGGHTS (Debian package liggghts) fail without it unless told otherwise.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.stats import chi2

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import collision_fit
import flow_cases
import liggghts_case

from glue.checkrows import Rows
from glue.flow import surface
from glue.flow.arrivals import draw_arrivals
from glue.flow.ballistic import run_ballistic
from glue.flow.footprint import expected_impacts
from glue.scene.reader import EXAMPLES, read_scene
from glue.solvers import repo_root

WORK = repo_root() / "build" / "bench"
SKINS_M = (0.003, 0.004, 0.006, 0.008)  # neighbour skins tried in LIGGGHTS; slower on both sides


def stepping(rows: Rows, quick: bool) -> None:
    """Contact-aware against plain YADE: same impacts, less time."""
    runs = flow_cases.stepping(WORK / "stepping", "1-2" if quick else "1-10")
    ours, plain = (sum(r["wall_s"][k] for r in runs) for k in (0, 1))
    rows.below(
        "contact-aware over plain stepping, wall time",
        ours / plain,
        1.0 / 6.0,
        f"{plain / ours:.1f} x less, {ours / (0.02 * len(runs)):.2f} against"
        f" {plain / (0.02 * len(runs)):.1f} s per peening second, {len(runs)} seeds",
    )
    rows.below("uncollided shots, place off [m]", max(r["uncollided_place_off_m"] for r in runs), 1e-6)
    rows.true("uncollided shots, velocity exact", all(r["uncollided_speed_exact"] for r in runs))
    rows.below(
        "shots with other collisions, first 20 ms, worst seed",
        1.0 - min(r["same_collisions"] for r in runs),
        0.1,
    )
    for name, band in (("collided_fraction", 0.01), ("mean_normal_energy_fraction", 0.015)):
        off = np.mean([r[name][0] - r[name][1] for r in runs])
        rows.within(f"{name}, off plain", float(off), 0.0, band, f"mean of {len(runs)} seeds")


def event_cost(rows: Rows, quick: bool) -> None:
    """Wall time of event-driven peening, after compilation."""
    flow_cases.event(flow_cases.scene_file(WORK / "cost", kg_min=5.0, exposure_s=0.01, seed=1))
    for kg_min, exposure_s, limit_s in ((5.0, 1.0, 0.3), (10.0, 0.5, 1.0), (100.0, 0.1, 10.0)):
        exposure_s *= 0.2 if quick else 1.0
        path = flow_cases.scene_file(WORK / "cost", kg_min=kg_min, exposure_s=exposure_s, seed=1)
        taken = [flow_cases.event(path) for _ in range(2)]
        wall_s = min(info["wall_s"] for _, info, _ in taken) / exposure_s
        info = taken[0][1]
        rows.below(
            f"event-driven, {kg_min:g} kg/min, wall s per peening s",
            wall_s,
            limit_s,
            f"{info['events']} events, at most {info['peak_live_shots']} shots alive",
        )


def event_agreement(rows: Rows, quick: bool) -> None:
    """Collided share and mean normal energy of event-driven runs against YADE on the same arrivals."""
    # about 20 000 shots each: two standard deviations of chance are .007 of the share and .006 of the energy
    cases = (
        ("1 kg/min", 1.0, 0.8, {}),
        ("5 kg/min", 5.0, 0.2, {}),
        ("10 kg/min", 10.0, 0.1, {}),
        ("5 kg/min, 45 degrees", 5.0, 0.2, {"angle_deg": 45.0}),
        ("5 kg/min, 5 degrees half angle", 5.0, 0.2, {"half_angle_deg": 5.0}),
    )
    for k, (name, kg_min, exposure_s, changes) in enumerate(cases):
        event, dem = [], []
        for seed in (11,) if quick else (11, 12, 13, 14, 15):
            path = flow_cases.scene_file(
                WORK / "agreement", kg_min=kg_min, exposure_s=exposure_s, seed=seed, **changes
            )
            event.append(flow_cases.stream_of(flow_cases.event(path)[0]))
            dem.append(flow_cases.stream_of(flow_cases.dem(path)[0]))
            say(f"agreement: case {k + 1} of {len(cases)}, seed {seed}")
        a, b = flow_cases.pooled(event), flow_cases.pooled(dem)
        share, energy = a.collided_share - b.collided_share, a.energy_share - b.energy_share
        rows.within(
            f"event-driven, {name}: collided share off YADE's",
            share,
            0.0,
            0.01,
            f"{a.collided_share:.4f} against {b.collided_share:.4f}, {b.first} shots",
        )
        rows.within(
            f"event-driven, {name}: mean normal energy off YADE's",
            energy,
            0.0,
            0.015,
            f"{a.energy_share:.4f} against {b.energy_share:.4f}",
        )


def liggghts(rows: Rows, quick: bool) -> None:
    """The same arrivals and contact step in LIGGGHTS, at its best settings, against contact-aware YADE."""
    if liggghts_case.available() is None:
        rows.true(
            "contact-aware YADE over LIGGGHTS", False, "LIGGGHTS is not installed (Debian package liggghts)"
        )
        return
    path = flow_cases.scene_file(WORK / "liggghts", kg_min=5.0, exposure_s=0.1, seed=1)
    scene = read_scene(path)
    arrivals, dt_s = draw_arrivals(scene), flow_cases.contact_step_s(scene)
    best, yade_s, yade = None, math.inf, {}
    for skin_m in SKINS_M:
        text = liggghts_case.script(scene, arrivals, dt_s=dt_s, window_s=0.03, skin_m=skin_m)
        for processes in (1,) if quick else (1, 2):
            try:
                cost = liggghts_case.run(
                    WORK / "liggghts",
                    text,
                    dt_s=dt_s,
                    skip=20,
                    processes=processes,
                    settings=f"skin {skin_m * 1e3:g} mm, {processes} process{'es' * (processes > 1)}",
                )
            except (RuntimeError, OSError) as e:
                if processes == 1:
                    raise
                say(f"liggghts on {processes} processes: {e}")
                continue
            say(f"liggghts: {cost.settings}: {cost.per_peening_s:.1f} s per peening second")
            if best is None or cost.step_s < best.step_s:
                best = cost
        _, info, exposure_s = flow_cases.dem(path)  # in turns, so that both meet the same noise
        if info["stepping_wall_s"] / exposure_s < yade_s:
            yade_s, yade = info["stepping_wall_s"] / exposure_s, info
    rows.below(
        "contact-aware YADE over LIGGGHTS, cost per peening second",
        yade_s / best.per_peening_s,
        1.0 / 15.0,
        f"{best.per_peening_s / yade_s:.1f} x ahead: {yade_s:.2f} s (at most {yade['peak_live_shots']} shots) against"
        f" {best.per_peening_s:.1f} s ({best.step_s * 1e6:.2f} us per step, {best.live_shots:.0f} shots,"
        f" {best.settings})",
    )


def mixed(rows: Rows, quick: bool) -> None:
    """S230 and S390 by mass at 45 degrees, three passes: mass to one shot, impacts against the footprint."""
    scene = read_scene(EXAMPLES / "mixed-s230-s390-traverse.toml")
    arrivals = draw_arrivals(scene)
    impacts, _ = run_ballistic(scene, arrivals, flow_cases.LAW, surface.from_scene(scene))
    mass = math.pi / 6.0 * arrivals["density_kg_m3"] * arrivals["diameter_m"] ** 3
    for k, medium in enumerate(scene.media):
        of = arrivals["medium"] == k
        wanted = medium.mass_fraction * scene.mass_flow_kg_s * scene.exposure_time_s
        off = abs(mass[of].sum() - wanted) / mass[of].max()
        rows.below(f"{medium.grade}: mass fed, off in shots", off, 1.0, f"{of.sum()} shots, {wanted:.4g} kg")
    for pass_id in range(scene.nozzle.feed.passes):
        here = impacts[impacts["pass_id"] == pass_id]
        counted, expected = binned(scene, here, pass_id)
        statistic = float(((counted - expected) ** 2 / expected).sum())
        rows.below(
            f"pass {pass_id + 1}: impacts per area against the footprint, chi2",
            statistic,
            float(chi2.ppf(0.99, len(expected) - 1)),
            f"{len(here)} impacts, {len(expected)} bins, 1 % limit",
        )


def binned(scene, impacts: np.ndarray, pass_id: int) -> tuple[np.ndarray, np.ndarray]:
    """Impacts of one pass and what the footprint expects, in squares of 2 mm; those with fewer than 10 as one bin.

    The footprint is that of the centres' flights on z = 0; a shot touches before, when its centre is a radius high.
    """
    radius = 0.5 * impacts["diameter_m"]
    x, y = (impacts[f"{c}_m"] - radius * impacts[f"v{c}_in_m_s"] / impacts["vz_in_m_s"] for c in "xy")
    reach = np.abs(np.concatenate([x, y])).max()
    edges = 2e-3 * np.arange(-math.ceil(reach / 2e-3), math.ceil(reach / 2e-3) + 1)
    counted = np.histogram2d(x, y, (edges, edges))[0].ravel()
    expected = np.array(
        [
            expected_impacts(scene, x, x + 2e-3, y, y + 2e-3, pass_id=pass_id)
            for x in edges[:-1]
            for y in edges[:-1]
        ]
    )
    many = expected >= 10.0
    counted = np.append(counted[many], counted[~many].sum())
    return counted, np.append(expected[many], expected[~many].sum())


def fit(rows: Rows, quick: bool) -> None:
    """Collisions per shot on scenes that were in no fit."""
    samples = collision_fit.run_all(collision_fit.HELD_OUT_SEED, 20 if quick else 200, "collision number")
    errors = collision_fit.errors(samples)
    rows.below(
        "collisions per shot, fit off event-driven runs, rms",
        errors["collisions_rms"],
        0.10,
        f"{errors['scenes']} other scenes, worst {errors['collisions_worst']:.1%},"
        f" energy loss {errors['energy_loss_rms']:.1%}",
    )


def air(rows: Rows, quick: bool) -> None:
    """Speed at the target, and terminal speed, against the equation of motion."""
    models = {"ballistic": flow_cases.ballistic, "event-driven": flow_cases.event, "YADE": flow_cases.dem}
    for name in flow_cases.AIR_CASES:
        path = flow_cases.air_file(WORK / "air", name)
        wanted = speed_by_ode(read_scene(path))
        for model, run in models.items():
            impacts = run(path)[0]
            free = impacts[impacts["collisions_before"] == 0]
            first = np.unique(free["shot_id"], return_index=True)[1]
            speed = float(-free["vz_in_m_s"][first].mean())
            rows.near(f"drag, {model}: speed {name} [m/s]", speed, wanted, 1e-3, f"{len(first)} shots")


def speed_by_ode(scene) -> float:
    """Speed [m/s] after the stand-off straight down in still air, by an explicit Runge-Kutta method of order 8.

    Written out here, because the flow models share one drag law: C_D = 24/Re (1 + .15 Re^.687), .44 from Re 1000.
    """
    diameter, density, gas = scene.shots.diameter_m, scene.shots.density_kg_m3, scene.air_drag
    g = scene.gravity.acceleration_m_s2 if scene.gravity else 0.0

    def rates(_, state):
        re = gas.gas_density_kg_m3 * abs(state[1]) * diameter / gas.gas_viscosity_Pa_s
        coefficient = 0.44 if re >= 1000.0 else 24.0 / re * (1.0 + 0.15 * re**0.687)
        drag = 0.75 * coefficient * gas.gas_density_kg_m3 * state[1] ** 2 / (density * diameter)
        return [state[1], drag - g]

    def touches(_, state):
        return state[0] - 0.5 * diameter

    touches.terminal = True
    start = [scene.nozzle.stand_off_m, -scene.nozzle.speed_m_s]
    found = solve_ivp(rates, (0.0, 100.0), start, method="DOP853", events=touches, rtol=1e-10, atol=1e-12)
    return -float(found.y_events[0][0][1])


CASES = {
    "stepping": stepping,
    "event-cost": event_cost,
    "event-agreement": event_agreement,
    "liggghts": liggghts,
    "mixed": mixed,
    "fit": fit,
    "drag": air,
}


def say(text: str) -> None:
    """One line of progress, on a terminal only: it is written over."""
    if not sys.stderr.isatty():
        return
    print(f"\r{text:<78}", end="", file=sys.stderr, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", action="append", choices=CASES, metavar="NAME", help=", ".join(CASES))
    parser.add_argument("--quick", action="store_true", help="short runs: does it run, not does it hold")
    parser.add_argument("--json", type=Path, default=WORK / "flow.json", metavar="FILE")
    parser.add_argument("--without-liggghts", action="store_true", help="leave its row out")
    args = parser.parse_args()
    args.json.parent.mkdir(parents=True, exist_ok=True)
    sys.argv[1:] = ["--json", str(args.json)]  # what Rows reads
    rows = Rows("flow benchmark")
    names = [n for n in args.only or CASES if not (n == "liggghts" and args.without_liggghts)]
    begun = time.monotonic()
    for i, name in enumerate(names):
        say(f"{name} ({i + 1} of {len(names)}), {time.monotonic() - begun:.0f} s so far")
        CASES[name](rows, args.quick)
    say("")
    rows.finish()


if __name__ == "__main__":
    main()
