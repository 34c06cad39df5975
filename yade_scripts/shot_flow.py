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
session.remove_scratch_at_exit()

import numpy as np  # noqa: E402

from flight import FlowFailed  # noqa: E402
from flow_run import FlowRun  # noqa: E402
from glue.atomic import write_text_atomic  # noqa: E402
from glue.errors import InputError  # noqa: E402
from glue.flow import arrivals as shots_leaving  # noqa: E402
from glue.flow import surface  # noqa: E402
from glue.flow.regime import resolve_physics  # noqa: E402
from glue.flow.restitution import RestitutionLaw  # noqa: E402
from glue.scene.reader import read_scene  # noqa: E402
from glue.scene.softened import softened  # noqa: E402
from run_plan import plan_run  # noqa: E402


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
    p.add_argument("--law", type=Path, metavar="FILE", help="in place of --restitution: its law as JSON")
    p.add_argument("--surface", type=Path, metavar="FILE", help="triangles of a target given as STL (.npz)")
    p.add_argument("--arrivals", type=Path, metavar="FILE", help="arrivals.csv to read instead of drawing")
    p.add_argument("--accuracy", metavar="PRESET", help="in place of the scene's accuracy.preset")
    p.add_argument("--exposure", type=float, metavar="S", help="stop feeding at this time [s] (for trials)")
    p.add_argument("--dt-over-P", type=float, metavar="X", help="time step in place of the preset's")
    p.add_argument(
        "--jet-margin", type=float, metavar="RADII", help="drop rising shots this far beside the jet"
    )
    p.add_argument(
        "--continue", dest="go_on", action="store_true", help="from OUT's checkpoint, if a stopped run left one"
    )
    p.add_argument(
        "--checkpoint", type=float, default=2.0, metavar="S", help="wall time between checkpoints (default 2)"
    )
    p.add_argument(
        "--plain", action="store_true", help="make every single step instead of leaping over free flight"
    )
    p.add_argument(
        "--unguarded", action="store_true", help="skip what refuses a bad time step before the run (tests)"
    )
    return p.parse_args(argv)


def law_of(scene, args) -> RestitutionLaw:
    """Restitution on the target, as given or as the scene says."""
    if args.law is not None:
        try:
            return RestitutionLaw.from_dict(json.loads(args.law.read_text()))
        except (OSError, ValueError) as e:
            raise InputError(f"{args.law}: cannot be read as a restitution law ({e})") from None
    e = scene.restitution.shot_target if args.restitution is None else args.restitution
    if isinstance(e, str):
        raise InputError("restitution.shot_target is from_dimple: give its value with --restitution E")
    hardening = scene.restitution.hardening
    if hardening is not None:
        raise InputError("restitution.hardening needs the radius of a spot: give it with --law FILE")
    return RestitutionLaw(e)


def surface_of(scene, args) -> surface.TargetSurface:
    if args.surface is None:
        return surface.from_scene(scene)
    return surface.load(args.surface)


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


def run(args, report: dict) -> None:
    scene = read_scene(args.scene, preset=args.accuracy)
    law, shape = law_of(scene, args), surface_of(scene, args)
    arrivals = arrivals_of(scene, args)
    decided = softened(resolve_physics(scene).scene)
    dt_over_P = args.dt_over_P or scene.accuracy.flow_dt_over_P
    plan = plan_run(decided, law, dt_over_P, guarded=not args.unguarded)
    identity = {
        "scene_hash": shots_leaving.scene_hash(scene),
        "restitution": law.as_dict(),
        "dt_over_P": plan.dt_over_P,
        "stiffness_scale": scene.accuracy.flow_stiffness_scale,
        "arrivals": len(arrivals),
        "jet_margin": args.jet_margin,
    }
    report.update(scene_hash=identity["scene_hash"], seed=scene.seed, restitution=law.as_dict())
    FlowRun(
        decided,
        plan,
        arrivals,
        shape,
        args.out,
        identity,
        plain=args.plain,
        jet_margin=args.jet_margin,
        checkpoint_s=args.checkpoint,
        go_on=args.go_on,
    ).run(report)


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
