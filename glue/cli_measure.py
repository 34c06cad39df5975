"""``peen dimple``, ``peen tradeoff`` and ``peen intensity``: what is measured apart from a run."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from glue.cli_progress import Progress
from glue.errors import InputError


def add_commands(add, accuracy) -> None:
    """Add the commands; ``add(name, does, help)`` makes a subparser, ``accuracy(sub)`` its option, see ``glue.cli``."""
    dimple = add(
        "dimple", _dimple, "solve normal impacts of a rigid sphere on a flat target: one, or a library of speeds"
    )
    dimple.add_argument("--material", required=True, help="key of the catalogue, such as al2024-t351")
    wanted = dimple.add_mutually_exclusive_group(required=True)
    wanted.add_argument("--speed", type=float, metavar="M_S", help="normal speed [m/s] of one impact")
    wanted.add_argument("--speeds", metavar="FROM:TO", help="a library over these speeds [m/s], such as 1:120")
    dimple.add_argument("--points", type=int, default=12, metavar="N", help="how many speeds (default %(default)s)")
    dimple.add_argument("--jobs", type=int, metavar="N", help="impacts solved at a time (default: one per core)")
    dimple.add_argument("--out", type=Path, metavar="FILE", help="write the library as JSON, too")
    dimple.add_argument(
        "--compare", action="store_true", help="the library beside closed forms (Kirk, Al-Hassani, Shen-Atluri, Nguyen)"
    )
    dimple.add_argument(
        "--shot", default="S390", metavar="GRADE", help="gives diameter and density (default %(default)s)"
    )
    dimple.add_argument("--diameter", type=float, metavar="M", help="shot diameter [m] instead of the grade's")
    accuracy(dimple)

    tradeoff = add(
        "tradeoff", _tradeoff, "measure what every choice costs and how far off it is: a scene, or four built-in ones"
    )
    tradeoff.add_argument("scene", metavar="SCENE", nargs="?")
    tradeoff.add_argument("--out", metavar="DIR", type=Path, default=Path("build/tradeoff"), help="default %(default)s")
    tradeoff.add_argument("--only", metavar="GROUP", nargs="+", default=[], help="these groups, such as dimple flow")
    tradeoff.add_argument("--jobs", type=int, metavar="N", default=1, help="runs at a time (default %(default)s)")
    tradeoff.add_argument("--quick", action="store_true", help="two cheap groups: what chance and the raster do")

    almen = add(
        "intensity", _intensity, "Almen intensity from a saturation curve: a measured one, or a strip in a scene's jet"
    )
    almen.add_argument("scene", metavar="SCENE", nargs="?")
    almen.add_argument(
        "--curve", metavar="FILE.csv", type=Path,
        help="measured: exposure_min|_s|_passes, arc_height_in|_mm|_m; with SCENE: beside it",
    )  # fmt: skip
    almen.add_argument("--strip", metavar="N|A|C", help="Almen strip (default: the scene's intensity's, else A)")
    almen.add_argument("--target", metavar="MODEL", default="layers", help="layers (milliseconds) or cell (minutes)")
    almen.add_argument("--figure", metavar="FILE.png", type=Path, help="draw the saturation curve")
    accuracy(almen)


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
        raise InputError(
            "--diameter: a library is in units of the shot and serves every diameter; allowed with --speed"
        )
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
        print(f"peen: {result.get('file') or result['scene']}: {found.problem}", file=sys.stderr)
        return InputError.exit_code
    return 0
