"""``peen design``: its options and what it prints."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

from glue.errors import NotConverged

HELP = "search a scene's process window for the setting that meets targets at the least cost, and confirm it"
_TEXT = """Searches the process window of a SCENE with the fast models (preset fast, event-driven shots, layer target) for the
setting that surely meets every target, with the unfavourable end of its 95 % interval, and is best in the objective.
The winner is run again at a finer preset with three other seeds; one that does not hold gives way to the next.

Targets and objectives name metrics: coverage, time_98, max_compressive, surface_stress, compressive_depth, Sa, Sz, …, a key
path of metrics.json such as residual_stress.max_compressive_Pa, or exposure_time and shot_mass of the setting itself.
Compression is negative: max_compressive<=-250MPa asks for 250 MPa and more. Quote them: a shell reads < and >.

Coverage is searched by its expectation (Avrami for the dimples found in the window), with the interval that one window's
count has. The interval holds chance and numerics: what a re-run may change. The material law's own uncertainty, which moves
all settings alike, is in design.json beside it."""
_EXAMPLES = """examples:
  peen design al2024-s390 --target 'coverage>=0.98' --target 'max_compressive<=-250MPa' --minimise Sa \\
      --vary nozzle.speed_m_s=20:100 --vary nozzle.mass_flow_kg_s=0.005:0.05:log --vary exposure_time_s=0.5:10:log
  peen design my.toml --target 'coverage>=98%' --minimise exposure_time --vary shots.grade=S110,S230,S390 \\
      --vary nozzle.speed_m_s=20:80 --vary exposure_time_s=1:20:log --evaluations 100 --jobs 2
The same command goes on where it was stopped and tries again what failed; a larger --evaluations adds to it.

exit codes: 0 a setting was found (and confirmed, where asked), 2 bad input, 3 a solver failed, 4 no setting meets the
targets, or none that was tried held when run again; 130 stopped by Ctrl-C"""


def add_parser(commands, does: Callable) -> None:
    """Add the command to the parser's ``commands``."""
    sub = commands.add_parser(
        "design", help=HELP, description=_TEXT, epilog=_EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    sub.set_defaults(command=does)
    sub.add_argument("--json", action="store_true", help="print the result as JSON")
    sub.add_argument("scene", metavar="SCENE")
    sub.add_argument("--target", metavar="GOAL", action="append", default=[], help="such as 'coverage>=98%%'; may be repeated")
    sub.add_argument("--minimise", metavar="NAME", action="append", default=[], help="such as Sa; several make a front")
    sub.add_argument("--maximise", metavar="NAME", action="append", default=[], help="such as compressive_depth")
    sub.add_argument("--vary", metavar="KEY=RANGE", action="append", default=[],
                     help="a key of the scene and FROM:TO, FROM:TO:log, FROM:TO:int or A,B,C; may be repeated")  # fmt: skip
    sub.add_argument("--evaluations", type=int, metavar="N", default=64, help="settings to try (default %(default)s)")
    sub.add_argument("--confirm", metavar="PRESET", default="balanced", help="a preset, or none (default %(default)s)")
    sub.add_argument("--out", type=Path, metavar="DIR", help="default runs/design-<scene>-<8 hex of what was asked>")
    sub.add_argument("--jobs", type=int, metavar="N", help="settings run at a time, up to 4 (default: one per core)")


def run_design(args, progress) -> int:
    """Do it; 0, or 4 where no setting meets the targets."""
    from glue.errors import InputError
    from glue.study.design.axes import read_axes
    from glue.study.design.design import VERDICTS, as_dict, design
    from glue.study.design.goals import read_goals
    from glue.study.design.problem import read_problem
    from glue.study.design.text import design_text

    problems, read = [], []
    for reader, words in ((read_goals, (args.target, args.minimise, args.maximise)), (read_axes, (args.vary,))):
        try:
            read.append(reader(*words))
        except InputError as problem:
            problems += problem.problems
    if problems:
        raise InputError(problems)
    preset = None if args.confirm == "none" else args.confirm
    result = design(
        read_problem(args.scene, *read), args.out, evaluations=args.evaluations, preset=preset, jobs=args.jobs, progress=progress
    )
    from glue.report.design import front_plot  # here: loads matplotlib

    picture = front_plot(result)
    print(json.dumps(as_dict(result), indent=2) if args.json else f"{design_text(result)}\n  {picture}")
    if result.succeeded:
        return 0
    print(f"peen: design: {VERDICTS[result.verdict][1]}", file=sys.stderr)
    return NotConverged.exit_code
