"""The ``peen`` command: results on standard output, progress and complaints on standard error."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from glue import cli_design, cli_files, cli_measure, stopping
from glue.cli_progress import Progress
from glue.cli_study import add_sweep
from glue.errors import InputError, PeenError
from glue.target.cache import cache_root

_STAGE_COMMANDS = {
    "flow": "simulate the shot stream (ballistic, event-driven or in YADE) and log every impact",
    "coverage": "count coverage over exposure time from the impact log",
    "target": "solve the target under the logged impacts in FreeFEM",
    "surface": "the peened surface's height map and roughness",
    "report": "draw the figures and write report.html, of what there is; of a study's folder the report of the study",
}

_DESCRIPTION = """Shot peening in numbers: YADE (or a cheaper model that is as good for the scene) simulates
the shot stream and logs every impact, FreeFEM solves what the impacts do to the target, and this command
carries the data between them and turns it into coverage, residual stress and roughness.

A SCENE is a TOML file or the name of a shipped example (peen check with a wrong name lists them). A RUN is
the directory that `peen run` makes; run again, it goes on from the last complete stage."""

_EXAMPLES = """examples:
  peen doctor                                    is everything installed, do both solvers answer
  peen check al2024-s390                         what would be modelled, how long would it take
  peen run al2024-s390                           from nozzle to metrics, into runs/al2024-s390-<inputs>
  peen run my.toml --out runs/mine --accuracy fast
  peen run my.toml --only dimple coverage        these stages and what they need
  peen run my.toml --impacts impacts.csv         with an impact log from elsewhere (peen import)
  peen export runs/mine                          STL, ParaView, stress and log as files for other codes
  peen report runs/mine                          one stage of a run, again if its inputs changed
  peen dimple --material al2024-t351 --speed 60  one impact
  peen tradeoff my.toml                          what each choice costs and how far off it is, on this scene
  peen dimple --material ti6al4v --speeds 1:120  a library of dimples over the speed
  peen sweep coverage-lhs --dry-run              a parametric study: its runs, and what they would cost
  peen intensity --curve arcs.csv                Almen intensity of a measured saturation curve
  peen intensity al2024-s390 --strip A           the same of a strip in the scene's jet, simulated
  peen design al2024-s390 --target 'coverage>=98%' --minimise Sa \\
      --vary nozzle.speed_m_s=20:100 --vary exposure_time_s=1:10

exit codes: 0 done, 2 bad input, 3 a solver failed, 4 a solver did not converge, 130 stopped by Ctrl-C"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # an ASCII terminal gets "?" for "µ", not a traceback
    args = _parser().parse_args(argv)
    # Else numba, where neither the checkout nor the home is writable, refuses to be imported.
    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_root() / "numba"))
    try:
        # A plain kill becomes an exception too, so that solvers are stopped and half-written files removed.
        with stopping.noticed():
            code = args.command(args)
            sys.stdout.flush()  # here, where a full disk can still be told
            return code
    except PeenError as problem:
        _complain("\n".join([str(problem), *getattr(problem, "__notes__", [])]))
        return problem.exit_code
    except KeyboardInterrupt:
        _complain("stopped; the same command goes on: from the last complete stage, the flow from its last checkpoint")
        return 130
    except BrokenPipeError:  # `peen … | head`
        _drop_output()
        return 1
    except RuntimeError as problem:
        if "no locator available" not in str(problem):  # numba's words when nowhere can its code be kept
            raise
        place = os.environ["NUMBA_CACHE_DIR"]
        _complain(f"{place}: cannot be written, and numba must keep its code; set PEEN_CACHE (or NUMBA_CACHE_DIR)")
        return InputError.exit_code
    except OSError as problem:
        _drop_output()
        place = os.fsdecode(problem.filename) if problem.filename else "a file or standard output"
        sentence = f"{place}: cannot be read or written ({problem.strerror or problem}): disk full? permissions?"
        _complain("\n".join([sentence, *getattr(problem, "__notes__", [])]))
        return InputError.exit_code


def _drop_output() -> None:
    """Output that cannot be delivered must not fail a second time when the interpreter flushes it at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _complain(text: str) -> None:
    print(f"peen: {text}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("peen", description=_DESCRIPTION, epilog=_EXAMPLES, formatter_class=raw)
    commands = parser.add_subparsers(metavar="COMMAND", required=True)

    def add(name: str, does, help_text: str) -> argparse.ArgumentParser:
        sub = commands.add_parser(name, help=help_text, description=help_text)
        sub.set_defaults(command=does)
        sub.add_argument("--json", action="store_true", help="print the result as JSON")
        return sub

    def accuracy(sub: argparse.ArgumentParser) -> None:
        sub.add_argument(
            "--accuracy",
            metavar="PRESET",
            help="fast, balanced or reference instead of the scene's own; numerics only",
        )

    check = add(
        "check", _check, "validate a scene; print its regime numbers, the models chosen and why, and the cost"
    )
    check.add_argument("scene", metavar="SCENE")
    accuracy(check)

    run = add("run", _run, "run a scene, or go on with it")
    run.add_argument("scene", metavar="SCENE")
    run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="the run directory (default runs/<scene name>-<8 hex of the inputs>)",
    )
    accuracy(run)
    run.add_argument("--only", metavar="STAGE", nargs="+", default=[], help="these stages and what they need")
    run.add_argument(
        "--impacts", metavar="FILE", type=Path, help="an impact log from elsewhere (peen import), not the flow's own"
    )
    run.add_argument(
        "--target-error", metavar="E", help="such as 5%%: the cheapest models and numbers whose measured error fits"
    )
    run.add_argument("--budget", metavar="T", help="such as 60s or 5min: the most exact that fits")

    for name, help_text in _STAGE_COMMANDS.items():
        stage = add(name, _stage, f"{help_text} (a stage of an existing run)")
        stage.add_argument("run", metavar="RUN", type=Path)
        stage.set_defaults(stage=name)

    cli_measure.add_commands(add, accuracy)
    cli_files.add_commands(add)
    cli_design.add_parser(commands, lambda args: cli_design.run_design(args, Progress()))
    add_sweep(commands, Progress)

    add("doctor", _doctor, "versions; do the plugins load, do both solvers answer; what to do when not")
    return parser


def _check(args) -> int:
    from glue.study.check import check
    from glue.study.check_text import check_text
    from glue.study.pipeline import find_scene
    from glue.study.specify import read_specified
    from glue.study.tradeoff.choose import preset_block

    scene_file = find_scene(args.scene)
    scene, _ = read_specified(scene_file, preset=args.accuracy, progress=Progress())
    if args.json:
        print(json.dumps(check(scene, scene_file) | {"preset_measured": preset_block(scene)}, indent=2))
    else:
        print(check_text(scene, scene_file))
    return 0


def _run(args) -> int:
    from glue.study import pipeline

    content = None
    if args.target_error is not None or args.budget is not None:
        from glue.study.tradeoff.wishes import chosen_scene

        content, told = chosen_scene(args.scene, args.target_error, args.budget, args.accuracy, args.only)
        print(told, file=sys.stderr, flush=True)
    path = pipeline.run(
        args.scene, args.out, args.accuracy, args.only, Progress(), content=content, impacts=args.impacts
    )
    return _show(path, args.json)


def _stage(args) -> int:
    from glue.study import pipeline

    if args.stage == "report" and (args.run / "study.json").is_file():
        from glue.report.study_page import write_study_report

        report = write_study_report(args.run)
        print(json.dumps({"report": str(report)}) if args.json else f"Report: {report}")
        return 0
    path = pipeline.rerun(args.run, [args.stage], Progress())
    return _show(path, args.json)


def _show(path: Path, as_json: bool) -> int:
    from glue.study.rundir import METRICS
    from glue.study.summary import summary

    text = (path / METRICS).read_text(encoding="utf-8")
    print(text.rstrip() if as_json else summary(path))
    for section, values in json.loads(text).items():
        if isinstance(values, dict) and "warning" in values:
            _complain(f"warning: {section}: {values['warning']}")
    return 0


def _doctor(args) -> int:
    from glue.solvers import doctor, versions

    rows = doctor()
    if args.json:
        print(json.dumps({"rows": [r._asdict() for r in rows], "versions": versions()}, indent=2))
    else:
        for row in rows:
            print(f"{'ok  ' if row.ok else 'FAIL'}  {row.what:<22} {row.detail}")
            if not row.ok:
                print(f"      {'':<22} try: {row.advice}")
        print(f"{sum(r.ok for r in rows)}/{len(rows)} passed")
    return 0 if all(r.ok for r in rows) else 3
