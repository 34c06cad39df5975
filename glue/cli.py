"""The ``peen`` command: results on standard output, progress and complaints on standard error."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from glue import cli_design, cli_files, stopping
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
the shot stream and logs every impact, FreeFEM solves what the impacts do to the target, and this command carries the data between them and turns it into
coverage, residual stress and roughness.

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
  peen design al2024-s390 --target 'coverage>=98%' --minimise Sa --vary nozzle.speed_m_s=20:100 --vary exposure_time_s=1:10

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
    run.add_argument("--impacts", metavar="FILE", type=Path, help="an impact log from elsewhere (peen import), not the flow's own")
    run.add_argument("--target-error", metavar="E", help="such as 5%%: the cheapest models and numbers whose measured error fits")
    run.add_argument("--budget", metavar="T", help="such as 60s or 5min: the most exact that fits")

    for name, help_text in _STAGE_COMMANDS.items():
        stage = add(name, _stage, f"{help_text} (a stage of an existing run)")
        stage.add_argument("run", metavar="RUN", type=Path)
        stage.set_defaults(stage=name)

    dimple = add("dimple", _dimple, "solve normal impacts of a rigid sphere on a flat target: one, or a library of speeds")
    dimple.add_argument("--material", required=True, help="key of the catalogue, such as al2024-t351")
    wanted = dimple.add_mutually_exclusive_group(required=True)
    wanted.add_argument("--speed", type=float, metavar="M_S", help="normal speed [m/s] of one impact")
    wanted.add_argument("--speeds", metavar="FROM:TO", help="a library over these speeds [m/s], such as 1:120")
    dimple.add_argument("--points", type=int, default=12, metavar="N", help="speeds of the library (default %(default)s)")
    dimple.add_argument("--jobs", type=int, metavar="N", help="impacts solved at a time (default: one per core)")
    dimple.add_argument("--out", type=Path, metavar="FILE", help="write the library as JSON, too")
    dimple.add_argument(
        "--compare", action="store_true", help="the library beside closed forms (Kirk, Al-Hassani, Shen-Atluri, Nguyen)"
    )
    dimple.add_argument(
        "--shot", default="S390", metavar="GRADE", help="gives diameter and density (default %(default)s)"
    )
    dimple.add_argument(
        "--diameter", type=float, metavar="M", help="shot diameter [m] instead of the grade's"
    )
    accuracy(dimple)

    tradeoff = add("tradeoff", _tradeoff, "measure what every choice costs and how far off it is: a scene, or four built-in ones")
    tradeoff.add_argument("scene", metavar="SCENE", nargs="?")
    tradeoff.add_argument("--out", metavar="DIR", type=Path, default=Path("build/tradeoff"), help="default %(default)s")
    tradeoff.add_argument("--only", metavar="GROUP", nargs="+", default=[], help="these groups of rungs, such as dimple flow")
    tradeoff.add_argument("--jobs", type=int, metavar="N", default=1, help="runs at a time (default %(default)s)")
    tradeoff.add_argument("--quick", action="store_true", help="two cheap groups: what chance and the raster do")

    almen = add("intensity", _intensity, "Almen intensity from a saturation curve: a measured one, or a strip in a scene's jet")
    almen.add_argument("scene", metavar="SCENE", nargs="?")
    almen.add_argument("--curve", metavar="FILE.csv", type=Path, help="measured: exposure_min|_s|_passes, arc_height_in|_mm|_m; with SCENE: beside it")
    almen.add_argument("--strip", metavar="N|A|C", help="Almen strip (default: the scene's intensity's, else A)")
    almen.add_argument("--target", metavar="MODEL", default="layers", help="layers (milliseconds) or cell (minutes)")
    almen.add_argument("--figure", metavar="FILE.png", type=Path, help="draw the saturation curve")
    accuracy(almen)

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
    path = pipeline.run(args.scene, args.out, args.accuracy, args.only, Progress(), content=content, impacts=args.impacts)
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


def _dimple(args) -> int:
    from glue.study import single

    if args.speeds is None:
        for option, given in (("--out", args.out), ("--compare", args.compare)):
            if given:
                raise InputError(f"{option}: is of a library; allowed with --speeds")
        result = single.single_dimple(args.material, args.speed, args.shot, args.diameter, args.accuracy, Progress())
        if args.json:
            print(json.dumps(result, indent=2))
        else:
            for key, value in result.items():
                print(f"{key:<20} {value:.6g}" if isinstance(value, float) else f"{key:<20} {value}")
        return 0
    if args.diameter is not None:
        raise InputError("--diameter: a library is in units of the shot and serves every diameter; allowed with --speed")
    library = single.dimple_library(
        args.material, args.speeds, args.points, args.shot, args.accuracy, args.jobs, args.out, Progress()
    )
    table = single.formulas_table(library) if args.compare else None
    if args.json:
        print(json.dumps(library.as_dict() | ({"formulas": table} if table else {}), indent=2))
    else:
        print(single.library_text(library))
        if table:
            print("\n" + single.formulas_text(library.material, table))
    return 0


def _tradeoff(args) -> int:
    from glue.report import tradeoff as report
    from glue.study.tradeoff.ladders import groups_named, run_ladders

    if args.jobs < 1:
        raise InputError(f"--jobs {args.jobs}: allowed from 1 up, such as the number of cores")
    groups = groups_named(args.only, args.quick)
    table = run_ladders(args.scene, args.out, groups, lambda line: print(line, file=sys.stderr, flush=True), args.jobs)
    files = report.write_report(table, args.out)
    if args.json:
        print(json.dumps(table, indent=1))
    else:
        print("\n\n".join(report.markdown(table, scene) for scene in table["scenes"]))
        print("\n".join(["", "Files", *(f"  {file}" for file in files)]))
    return 0


def _intensity(args) -> int:
    from glue.study import intensity

    result, found = intensity.intensity(
        args.scene, args.curve, strip=args.strip, model=args.target, preset=args.accuracy, progress=Progress()
    )
    if args.figure is not None and found.problem is None:
        from glue.report.saturation import saturation_plot  # here: loads matplotlib

        measured = result.get("measured")
        saturation_plot(
            args.figure, found, unit=result["exposure_unit"], title=intensity.title(result),
            measured=measured and (measured["exposure"], measured["arc_height_m"]),
        )  # fmt: skip
    print(json.dumps(result, indent=2) if args.json else intensity.intensity_text(result))
    if found.problem:
        _complain(f"{result.get('file') or result['scene']}: {found.problem}")
        return InputError.exit_code
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


class Progress:
    """Tells a stage's progress and time left on standard error: in place on a terminal, else every 10 s."""

    def __init__(self):
        self._stage, self._start, self._shown = "", 0.0, 0.0

    def __call__(self, stage: str, fraction: float | None, text: str = "") -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._start, self._shown = stage, now, -1e9
        last = fraction is not None and fraction >= 1.0
        live = sys.stderr.isatty()
        if not last and now - self._shown < (0.2 if live else 10.0):
            return
        self._shown = now
        parts = [f"{stage:<9}"]
        if fraction is not None and 0.0 < fraction < 1.0 and now - self._start > 1.0:
            left_s = (now - self._start) / fraction * (1.0 - fraction)
            parts.append(
                f"{100 * fraction:3.0f} %"
                if "left" in text
                else f"{100 * fraction:3.0f} %, {left_s:.0f} s left"
            )
        if text:
            parts.append(text)
        if last and now - self._start > 0.05:
            parts.append(f"({now - self._start:.1f} s)")
        line = "  ".join(parts)
        end = "\n" if last or not live else ""
        print(f"\r\033[K{line}" if live else line, end=end, file=sys.stderr, flush=True)
