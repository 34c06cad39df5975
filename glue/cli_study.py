"""``peen sweep``: its options, and what it prints."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

_DESCRIPTION = """Run a STUDY: a TOML file that names a scene, axes along which it changes (lists, ranges, Latin hypercube or Sobol
points) and repetitions with other shots; or a shipped study's name. Every run is an ordinary run directory in
OUT/runs; what they found is in OUT/table.csv and OUT/report.html, what they cost in OUT/costs.csv. Dimples are solved once for all runs. The same
command again goes on: a finished run is never computed twice. A run that fails is recorded, and the others go on."""

_EPILOG = """a study, in full: glue/study/sweep/examples/coverage-lhs.toml

examples:
  peen sweep my-study.toml --dry-run                  the runs, and what they would cost
  peen sweep coverage-lhs --out studies/mine --jobs 2
  peen sweep coverage-lhs --executor snakemake        through Snakemake on this machine
  peen sweep coverage-lhs --executor snakemake --profile glue/study/sweep/profiles/slurm     on a cluster

exit codes: 0 every valid run is done; else that of the first run that failed (tables are written all the same)"""


def add_sweep(commands, progress: Callable) -> None:
    """Add the command to the parser's ``commands``; ``progress()`` makes what tells of progress."""
    sweep = commands.add_parser(
        "sweep", help="run a parametric study: many runs of one scene along axes, into one table", description=_DESCRIPTION,
        epilog=_EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    sweep.set_defaults(command=lambda args: _sweep(args, progress()))
    sweep.add_argument("study", metavar="STUDY")
    sweep.add_argument("--out", metavar="DIR", type=Path, help="default studies/<name>-<8 hex of the inputs>")
    jobs = "runs at a time (default: one per core; with a profile: its own)"
    sweep.add_argument("--jobs", metavar="N", type=int, help=jobs)
    sweep.add_argument("--executor", choices=("local", "snakemake"), default="local", help="default %(default)s")
    sweep.add_argument("--profile", metavar="DIR", type=Path, help="a folder of Snakemake's settings, for --executor snakemake")
    sweep.add_argument("--retry-failed", action="store_true", help="try runs again that failed before")
    sweep.add_argument("--runs", metavar="N", type=int, help="only the first N runs of the design; the others wait")
    sweep.add_argument("--dry-run", action="store_true", help="list the runs and their estimated cost; run nothing")
    sweep.add_argument("--json", action="store_true", help="print study.json (with --dry-run: the runs) as JSON")


def _sweep(args, progress) -> int:
    from glue.errors import InputError

    if args.runs is not None and args.runs < 1:
        raise InputError(f"--runs {args.runs}: allowed from 1 up")
    if args.profile is not None and args.executor != "snakemake":
        raise InputError("--profile: is Snakemake's; allowed with --executor snakemake")
    if args.dry_run:
        return _dry_run(args)
    from glue.study.sweep import table
    from glue.study.sweep.run import exit_code, run_study

    out = run_study(
        args.study, args.out, args.jobs, progress, executor=args.executor, profile=args.profile,
        retry_failed=args.retry_failed, first=args.runs,
    )  # fmt: skip
    from glue.report.study_page import write_study_report

    write_study_report(out)
    study = json.loads((out / table.STUDY).read_text(encoding="utf-8"))
    print(json.dumps(study, indent=2) if args.json else _summary(out, study))
    return exit_code(out)


def _summary(out: Path, study: dict) -> str:
    """Counts, the first failures and where everything is."""
    import csv

    from glue.study.sweep import table
    from glue.study.sweep.warned import distinct

    counts = study["runs"]
    states = ", ".join(f"{n} {state}" for state, n in counts.items() if state != "all" and n)
    lines = [f"{study['name']}: {counts['all']} runs, {states}"]
    with open(out / table.TABLE, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    causes = [(row["run"], row["state"], row["cause"]) for row in rows if row["cause"]]
    lines += [f"  {run} {state}: {cause}" for run, state, cause in causes[:5]]
    if len(causes) > 5:
        lines.append(f"  … and {len(causes) - 5} more, in the table")
    cells = [row["warnings"] for row in rows if row["warnings"]]
    if told := distinct(cells):
        others = f" … and {len(told) - 1} other warnings, in the report" if told[1:] else ""
        lines.append(f"  {len(cells)} {'run warns' if len(cells) == 1 else 'runs warn'}: {told[0][0]}{others}")
    files = {"table": table.TABLE, "costs": table.COSTS, "report": "report.html"}
    return "\n".join([*lines, *(f"{what}: {out / name}" for what, name in files.items())])


def _dry_run(args) -> int:
    from glue.study.sweep.dry import dry_run, dry_text

    found = dry_run(args.study, args.out, args.jobs, args.retry_failed, args.runs)
    print(json.dumps(found, indent=1) if args.json else dry_text(found))
    for sentence in found["remarks"]:
        print(f"peen: {sentence}", file=sys.stderr)
    return 0
