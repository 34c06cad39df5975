"""Does runs of a study in a process of its own, which pays once for loading the models.

    python -m glue.study.sweep.worker OUT               runs of OUT/queue, one after another, until none is left
    python -m glue.study.sweep.worker OUT --run RUN --stage STAGE    one stage of one run, then the mark OUT/done/RUN/STAGE
    python -m glue.study.sweep.worker OUT --library K --jobs N       the K-th library of dimples, then OUT/done/library-K

Prints ``run NAME``, ``tell NAME STAGE SHARE``, ``done NAME SECONDS``, ``failed NAME CODE`` or ``busy NAME``.  A run
that fails leaves ``OUT/failures/NAME.json``; its later stages are passed over.  One in whose folder another process is
still at work after some waiting is busy, not failed: it leaves ``OUT/busy/NAME``, and ``--run`` ends with exit code 75 (try
again).  Every start and end of a stage goes to ``OUT/journal.csv``.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import time
import traceback
from pathlib import Path

from glue import stopping
from glue.errors import InputError, InUse, PeenError
from glue.study.sweep.plan import PLAN
from glue.study.sweep.records import BUSY, DONE, QUEUE, claim, failure_file, mark, note, record_failure

_TELL_EVERY_S = 1.0
_WAIT_S, _LOOK_EVERY_S = 20.0, 0.5  # for another process to leave a run's folder: one just stopped is soon gone
_TRY_AGAIN = 75  # EX_TEMPFAIL of sysexits.h


def main(argv: list[str]) -> int:
    """Run the command line of this process."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--run")
    parser.add_argument("--stage")
    parser.add_argument("--library", type=int)
    parser.add_argument("--jobs", type=int)
    args = parser.parse_args(argv)
    plan = json.loads((args.out / PLAN).read_text(encoding="utf-8"))
    os.environ["PEEN_CACHE"] = plan["cache"]  # on a cluster's machine too
    os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(plan["cache"]) / "numba"))
    runs = {run["run"]: run for run in plan["runs"]}
    try:
        with stopping.noticed():
            if args.library is not None:
                _library(plan, runs, args.library, args.jobs)
                mark(args.out / DONE / f"library-{args.library}")
            elif args.run is not None:
                if not failure_file(args.out, args.run).exists():
                    do_run(args.out, plan, runs[args.run], [args.stage])
                mark(args.out / DONE / args.run / args.stage)
            else:
                while (name := claim(args.out / QUEUE)) is not None:
                    _say(f"run {name}")
                    with contextlib.suppress(InUse):
                        do_run(args.out, plan, runs[name], plan["stages"])
    except KeyboardInterrupt:
        return 130
    except InUse as problem:
        print(f"peen: {problem}", file=sys.stderr)
        return _TRY_AGAIN
    return 0


def do_run(out: Path, plan: dict, run: dict, stages: list[str]) -> None:
    """Bring stages of a run up to date; a failure is recorded and told.

    Raises InUse when another process does not leave the run's folder.
    """
    from glue.study import pipeline

    name, begun, at = run["run"], time.monotonic(), {"stage": "", "told": 0.0}

    def progress(stage: str, fraction: float | None, text: str) -> None:
        at["stage"] = stage
        if fraction == 0.0 and (text == "starts" or text.startswith("goes on")):
            note(out, name, stage, "starts" if text == "starts" else "goes on")
        elif fraction == 1.0:
            note(out, name, stage, "done" if text == "done" else "was done")
        if time.monotonic() > at["told"] + _TELL_EVERY_S:
            at["told"] = time.monotonic()
            _say(f"tell {name} {stage} {fraction or 0.0:.3f}")

    def patient() -> None:
        while True:
            try:
                pipeline.run(
                    plan["scene_file"], out / "runs" / name, only=stages, progress=progress,
                    content=run["scene"].encode(),
                )  # fmt: skip
                return
            except InUse:
                if time.monotonic() > begun + _WAIT_S:
                    raise
                stopping.check()
                time.sleep(_LOOK_EVERY_S)

    (out / BUSY / name).unlink(missing_ok=True)  # of an attempt before this one
    try:
        patient()
    except InUse:
        mark(out / BUSY / name)
        _say(f"busy {name}")
        raise
    except PeenError as problem:
        code, cause = problem.exit_code, str(problem)
    except OSError as problem:
        place = problem.filename or "a file"
        code, cause = InputError.exit_code, f"{place}: cannot be read or written ({problem.strerror or problem})"
    except (KeyboardInterrupt, SystemExit):
        raise
    except Exception as problem:  # a mistake in a model must not end the other runs
        traceback.print_exc()
        code, cause = 1, f"{type(problem).__name__}: {problem}"
    else:
        _say(f"done {name} {time.monotonic() - begun:.3f}")
        return
    record_failure(out, name, code, at["stage"], cause)
    note(out, name, at["stage"], "failed")
    _say(f"failed {name} {code}")


def _say(line: str) -> None:
    """To whoever started this process; that nobody reads it any more is no failure of the run."""
    with contextlib.suppress(BrokenPipeError):
        print(line, flush=True)


def _library(plan: dict, runs: dict, number: int, jobs: int | None) -> None:
    from glue.scene.reader import read_scene
    from glue.study.sweep.library import solve_libraries

    library = plan["library"][number]
    scene = read_scene(Path(plan["scene_file"]), content=runs[library["run"]]["scene"].encode(), provisional=True)
    solve_libraries([(scene, library)], jobs)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
