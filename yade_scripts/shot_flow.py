"""The shot stream, simulated: every shot from the nozzle to the target and away, every impact logged.

    yade -n -x yade_scripts/shot_flow.py SCENE OUT [--restitution E] [--arrivals FILE] [--accuracy PRESET]

writes OUT/impacts.csv (the impact log), OUT/flow.json (status, numbers, checks) and, when it draws the
arrivals itself, OUT/arrivals.csv.  Progress on stdout: ``progress 0.42 eta_s 37``.  Exit 0 well, 2 bad
input, 3 a check failed or the run broke; then stderr ends with the cause, flow.json has it as "cause",
and what was logged stays as OUT/impacts.csv.part.

Axes and units: SI; target z = 0, below; jet axis through the origin in the x-z plane.
"""

from __future__ import annotations

import argparse
import json
import math
import signal
import sys
import time
from pathlib import Path

HERE = Path(sys.argv[0]).resolve().parent  # under yade, __file__ is that of yade itself
sys.path[:0] = [str(HERE), str(HERE.parent)]

import session  # noqa: E402

session.close_listeners()

import numpy as np  # noqa: E402

from contact_model import build  # noqa: E402
from flow_checks import audit, postflight  # noqa: E402
from glue.atomic import write_text_atomic  # noqa: E402
from glue.errors import InputError  # noqa: E402
from glue.flow import arrivals as shots_leaving  # noqa: E402
from glue.flow.impacts import impact_writer  # noqa: E402
from glue.flow.restitution import RestitutionLaw  # noqa: E402
from glue.scene.reader import read_scene  # noqa: E402
from bodies import Bodies  # noqa: E402
from flight import Fleet, FlowFailed  # noqa: E402
from impact_logger import ImpactLogger  # noqa: E402
from leaps import Leaps  # noqa: E402
from plain_steps import PlainSteps  # noqa: E402
from run_plan import plan_run  # noqa: E402
from shot_stream import DROPS_PER_FLIGHT, Stream  # noqa: E402
from target_plane import PlaneTarget  # noqa: E402

# Shots that meet others may leave with any speed below this times the nozzle's: two equal shots can at most
# reach sqrt 2, sizes within 2.5 x 10 % some 1.6.  One that met none must stay below 1.1 (ImpactLogger).
SPEED_LIMIT = 2.0
TAIL_FLIGHTS = 20.0  # give up on slow stragglers after this many flights of the stand-off at nozzle speed


def parse(argv):
    p = argparse.ArgumentParser(prog="shot_flow.py", description="The shot stream of a scene in YADE.")
    p.add_argument("scene", type=Path, metavar="SCENE")
    p.add_argument("out", type=Path, metavar="OUT")
    p.add_argument(
        "--restitution",
        type=float,
        metavar="E",
        help="shot on target; needed when the scene says from_dimple",
    )
    p.add_argument("--arrivals", type=Path, metavar="FILE", help="arrivals.csv to read instead of drawing")
    p.add_argument("--accuracy", metavar="PRESET", help="in place of the scene's accuracy.preset")
    p.add_argument("--exposure", type=float, metavar="S", help="stop feeding at this time [s] (for trials)")
    p.add_argument("--dt-over-P", type=float, metavar="X", help="time step in place of the preset's")
    p.add_argument(
        "--jet-margin", type=float, metavar="RADII", help="drop rising shots this far beside the jet"
    )
    p.add_argument(
        "--plain", action="store_true", help="make every single step instead of leaping over free flight"
    )
    p.add_argument(
        "--unguarded", action="store_true", help="skip what refuses a bad time step before the run (tests)"
    )
    return p.parse_args(argv)


def restitution_of(scene, given: float | None) -> float:
    if given is not None:
        return given
    if isinstance(scene.restitution.shot_target, str):
        raise InputError("restitution.shot_target is from_dimple: give its value with --restitution E")
    return scene.restitution.shot_target


def arrivals_of(scene, args) -> np.ndarray:
    """Read or draw the arrivals; those read must be of this scene."""
    if args.arrivals is None:
        arrivals = shots_leaving.draw_arrivals(scene)
        shots_leaving.write_arrivals(args.out / "arrivals.csv", arrivals, shots_leaving.scene_hash(scene))
    else:
        arrivals, header = shots_leaving.read_arrivals(args.arrivals)
        if header.get("scene_hash") != shots_leaving.scene_hash(scene):
            raise InputError(f"{args.arrivals}: drawn for another scene or accuracy preset than {args.scene}")
    if args.exposure is not None:
        arrivals = arrivals[arrivals["time_s"] < args.exposure]
    if not len(arrivals):
        raise InputError(
            f"no shot leaves the nozzle: {scene.expected_shots:.3g} expected; raise exposure_time_s"
            " or mass_flow_kg_s"
        )
    return arrivals


def simulate(stream: Stream, writer, end_s: float, flight_s: float) -> None:
    """Feed and step until every shot has struck or gone, at most ``TAIL_FLIGHTS`` after the last arrival."""
    logger, mover = stream.logger, stream.mover
    stride = max(1, round(flight_s / DROPS_PER_FLIGHT / logger.dt))
    begun = said = time.monotonic()
    look = logger.step  # the step of the next look through all shots
    while True:
        if logger.step >= look:
            stream.drop()
            look += stride
            now = time.monotonic()
            if now - said > 1.0:
                audit(mover)
                writer.flush()
                done = min(max(logger.clock() / end_s, 1e-6), 0.999)
                print(f"progress {done:.3f} eta_s {(now - begun) * (1.0 / done - 1.0):.0f}", flush=True)
                said = now
        stream.feed()
        wait = stream.steps_to_next()
        if wait is None and (not stream.falling() or logger.clock() > end_s + TAIL_FLIGHTS * flight_s):
            break
        mover.advance(look - logger.step if wait is None else min(wait, look - logger.step))
    stream.drop()
    audit(mover)
    logger.flush()


def summary(plan, stream, impacts: int) -> dict:
    """The numbers of flow.json that come from the run; SI."""
    logger, live = stream.logger, stream.fleet.shots
    return {
        "stepping": stream.mover.name,
        "dt_s": plan.dt_s,
        "dt_over_P": plan.dt_over_P,
        "calibration": {"shot_target": plan.shot_target._asdict(), "shot_shot": plan.shot_shot._asdict()},
        "steps": logger.step - stream.first_step,
        "executed_steps": logger.executed,
        "simulated_s": logger.clock(),
        "peak_live_shots": stream.peak_live,
        "arrived": stream.next,
        "impacts": impacts,
        "dropped": stream.dropped,
        "in_flight": len(live),
        "shots_that_never_struck": stream.never_struck + sum(s.impacts == 0 for s in live),
        "shot_shot_collisions": logger.collisions,
        "top_speed_m_s": logger.top_speed,
    }


def run(args, report: dict) -> None:
    scene = read_scene(args.scene, preset=args.accuracy)
    restitution = restitution_of(scene, args.restitution)
    plan = plan_run(
        scene, RestitutionLaw(restitution), args.dt_over_P or scene.accuracy.flow_dt_over_P, guarded=not args.unguarded
    )
    arrivals = arrivals_of(scene, args)
    scene_hash = shots_leaving.scene_hash(scene)
    report.update(scene_hash=scene_hash, seed=scene.seed, restitution=restitution)

    material = build(plan.media[0], plan.target, *plan.laws, dt_s=plan.dt_s, sweep_m=0.5 * scene.shots.diameter_m)
    writer = impact_writer(
        args.out / "impacts.csv",
        {"scene_hash": scene_hash, "model": "dem", "restitution": restitution, "dt_over_P": plan.dt_over_P},
    )

    def emit(rows):
        writer.write((writer.rows_written + i, *row) for i, row in enumerate(rows))

    target = PlaneTarget()
    bodies, fleet = Bodies([material], target), Fleet()
    logger = ImpactLogger(
        emit, bodies, target, dt_s=plan.dt_s, speed_limit_m_s=SPEED_LIMIT * scene.nozzle.speed_m_s
    )
    stream = Stream(
        scene,
        arrivals,
        (PlainSteps if args.plain else Leaps)(fleet, bodies, logger),
        plan.dt_s,
        **({} if args.jet_margin is None else {"jet_margin": args.jet_margin}),
    )
    flight_s = scene.nozzle.stand_off_m / scene.nozzle.speed_m_s
    try:
        simulate(stream, writer, float(arrivals["time_s"][-1]) + flight_s, flight_s)
        checks = postflight(plan, stream)
        report["checks"] = [row._asdict() for row in checks]
        failed = [row for row in checks if not row.passed]
        if failed:
            raise FlowFailed("; ".join(f"{r.name}: {r.value:.6g}, limit {r.limit:.6g}" for r in failed))
        writer.finish()
    except BaseException:
        writer.abandon()
        raise
    finally:
        report.update(summary(plan, stream, writer.rows_written))


def main() -> int:
    args = parse(sys.argv[1:])
    report = {"schema": 1, "model": "dem", "status": "failed", "kind": "stopped", "cause": "stopped"}
    begun = time.monotonic()
    code = 3
    try:
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / "impacts.csv").unlink(missing_ok=True)  # an older run's must not pass for this one's
        write_text_atomic(args.out / "flow.json", json.dumps(report) + "\n")
    except OSError as e:
        print(f"shot_flow: {args.out} cannot be written: {e}", file=sys.stderr)
        return InputError.exit_code
    try:
        run(args, report)
        report.update(status="ok", kind=None, cause=None)
        code = 0
    except InputError as e:
        report.update(kind="input", cause="; ".join(e.problems))
        code = e.exit_code
    except FlowFailed as e:
        report.update(kind="check", cause=str(e))
    except Exception as e:
        report.update(kind="defect", cause=f"{type(e).__name__}: {e}")
        raise  # a defect of this program: the traceback belongs in the log
    finally:
        report["wall_s"] = time.monotonic() - begun
        write_text_atomic(args.out / "flow.json", json.dumps(_plain(report), indent=1) + "\n")
        if report["cause"]:
            print(f"shot_flow: {report['cause']}", file=sys.stderr, flush=True)
    if code == 0:
        print("progress 1.000 eta_s 0", flush=True)
    return code


def _plain(value):
    """JSON has no nan or inf: null instead."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


if __name__ == "__main__":
    for number in (
        signal.SIGTERM,
        signal.SIGINT,
    ):  # leave through `finally`: the log so far and flow.json stay
        signal.signal(number, lambda *_: sys.exit(3))
    sys.exit(main())
