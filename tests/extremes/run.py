"""The stability map: every cell of the grid solved and judged; PASS or FAIL rows, JSON, a picture (make extremes).

    python tests/extremes/run.py [--short] [--only FAMILY ...] [--json FILE] [--picture FILE] [--again]

Each cell's verdict is kept in build/extremes under the hash of its inputs and of the sources that it runs through, so a
run that was stopped goes on, and a change of the code solves again what it touches.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import cells_cell
import cells_contact
import cells_dent
import cells_stream
import cells_surface
import picture
from grid import Cell, cells
from judges import REFUSED, RIGHT, WRONG, Finding, Verdict, judge

from glue.atomic import write_text_atomic
from glue.checkrows import Rows
from glue.solvers import build_plugin, repo_root
from glue.target.cache import content_key

KEPT = repo_root() / "build" / "extremes"
MOST_REFUSED = 0.3
LEAST_CELLS = 400

_FLOW = ("glue/errors.py", "glue/flow/*.py", "glue/scene/*.py", "glue/scene/*.toml", "glue/theory/*.py", "tests/extremes/judges.py")
_TARGET = ("glue/errors.py", "glue/target/*.py", "glue/scene/*.py", "glue/scene/*.toml", "glue/theory/*.py", "freefem/*.edp", "freefem/lib/*.idp",
           "freefem/plugin/*", "tests/extremes/judges.py")  # fmt: skip
_STREAM, _RIG = (*_FLOW, "tests/extremes/cells_stream.py"), ("yade_scripts/*.py", "tests/extremes/contact_rig.py")
_SURFACE = ("glue/surface/*.py", *_TARGET, "tests/extremes/cells_surface.py")
_DENT = (*_TARGET, "tests/extremes/cells_dent.py")

# family: (function of a cell's values that returns findings, sources of its verdict)
FAMILIES = {
    "stream": (cells_stream.stream, _STREAM),
    "collisions": (cells_stream.collisions, _STREAM),
    "flight": (cells_stream.single_flights, _STREAM),
    "contact": (None, (*_STREAM, *_RIG, "tests/extremes/cells_contact.py")),  # all in one YADE process
    "coverage": (cells_surface.coverage, _SURFACE),
    "stamp": (cells_surface.stamp, _SURFACE),
    "plate": (cells_surface.plate, _SURFACE),
    "laws": (cells_surface.strain_bound, _SURFACE),
    "layers": (cells_surface.layers, _SURFACE),
    "dent": (cells_dent.dent, _DENT),
    "effect": (cells_dent.effect, _DENT),
    "mesh": (cells_dent.mesh, _DENT),
    "order": (cells_dent.order, _DENT),
    "hits": (cells_dent.hits, _DENT),
    "no_dimple": (cells_dent.no_dimple, _DENT),
    "target_cell": (cells_cell.target_cell, (*_TARGET, "tests/extremes/cells_cell.py")),
}  # fmt: skip
# Seconds of one processor that a cell of a family takes, for the time left.
COST_S = {"stream": 0.15, "collisions": 2.0, "flight": 0.2, "contact": 0.15, "layers": 0.5, "dent": 3.5, "effect": 4.0, "mesh": 2.5,
          "order": 3.0, "hits": 9.0, "no_dimple": 2.0, "target_cell": 12.0}  # fmt: skip


def judged(cell: Cell) -> Verdict:
    """The verdict on one cell, solved now."""
    verdict = judge(lambda: FAMILIES[cell.family][0](cell.values))
    return ordinary_is_not_refused(cell, verdict)


def ordinary_is_not_refused(cell: Cell, verdict: Verdict) -> Verdict:
    """Inside normal use a refusal is wrong."""
    if verdict.verdict == REFUSED and cell.ordinary:
        return Verdict(WRONG, f"refused inside normal use: {verdict.text}", [])
    return verdict


@cache
def _digest(family: str) -> str:
    return content_key({}, FAMILIES[family][1])


class Kept:
    """Verdicts of earlier runs, a file each."""

    def __init__(self, folder: Path):
        self.folder = folder

    def path(self, cell: Cell) -> Path:
        key = content_key({"cell": cell.name, "values": cell.values, "ordinary": cell.ordinary, "sources": _digest(cell.family)}, ())
        return self.folder / f"{key}.json"

    def get(self, cell: Cell) -> Verdict | None:
        try:
            found = json.loads(self.path(cell).read_text())
        except (OSError, ValueError):
            return None
        return Verdict(found["verdict"], found["text"], [Finding(*f) for f in found["findings"]])

    def put(self, cell: Cell, verdict: Verdict) -> None:
        write_text_atomic(self.path(cell), json.dumps(verdict._asdict()) + "\n")


def solve_all(wanted: list[Cell], kept: Kept, again: bool = False) -> dict[str, Verdict]:
    """Verdicts of all cells by name; those of earlier runs are taken from ``kept``."""
    verdicts = {} if again else {c.name: found for c in wanted if (found := kept.get(c))}
    left = [c for c in wanted if c.name not in verdicts]
    clock = Clock(left)
    if len(left) < len(wanted):
        say(f"{len(wanted) - len(left)} of {len(wanted)} cells are known")

    def done(cell: Cell, verdict: Verdict) -> None:
        kept.put(cell, verdict)
        verdicts[cell.name] = verdict
        clock.done(cell)

    if any(c.family in ("layers", "dent", "effect", "mesh", "order", "hits", "no_dimple", "target_cell") for c in left):
        build_plugin()
    contacts = {c.name: c for c in left if c.family == "contact"}
    if contacts:
        cells_contact.run(
            [(name, c.values) for name, c in contacts.items()], kept.folder / "contact",
            lambda name, verdict: done(contacts[name], ordinary_is_not_refused(contacts[name], verdict)),
        )  # fmt: skip
    for cell in left:
        if cell.family != "contact":
            done(cell, judged(cell))
    return verdicts


class Clock:
    """Says how many cells are done and how long the rest will take."""

    def __init__(self, left: list[Cell]):
        self.whole = sum(COST_S.get(c.family, 0.05) for c in left)
        self.count, self.of, self.spent = 0, len(left), 0.0
        self.begun, self.said = time.monotonic(), time.monotonic()

    def done(self, cell: Cell) -> None:
        self.count += 1
        self.spent += COST_S.get(cell.family, 0.05)
        now = time.monotonic()
        if now - self.said > 10.0 or self.count == self.of:
            self.said = now
            rest = (now - self.begun) / self.spent * (self.whole - self.spent)
            say(f"{self.count} of {self.of} cells, {rest / 60:.1f} minutes left")


def say(text: str) -> None:
    print(f"extremes: {text}", file=sys.stderr, flush=True)


def rows_of(rows: Rows, wanted: list[Cell], verdicts: dict[str, Verdict], whole: bool) -> None:
    """A row per panel, then what holds of the whole map."""
    for panel in dict.fromkeys(c.panel for c in wanted):
        own = [(c, verdicts[c.name]) for c in wanted if c.panel == panel]
        wrong = [f"{c.row}, {c.column}: {v.text}" for c, v in own if v.verdict == WRONG]
        right, refused = (sum(v.verdict == kind for _, v in own) for kind in (RIGHT, REFUSED))
        rows.below(f"{panel}: wrong cells", len(wrong), 0, "; ".join(wrong) or f"{right} right, {refused} refused")
    ordinary = [c for c in wanted if c.ordinary]
    rows.true("inside normal use nothing is refused", not any(verdicts[c.name].verdict == REFUSED for c in ordinary),
              f"{len(ordinary)} cells")  # fmt: skip
    refused = sum(v.verdict == REFUSED for v in verdicts.values())
    if whole:
        rows.below("fewer cells than promised", LEAST_CELLS - len(wanted), 0, f"{len(wanted)} cells")
        rows.below("share of refusals", refused / len(wanted), MOST_REFUSED, f"{refused} of {len(wanted)}")


def record(wanted: list[Cell], verdicts: dict[str, Verdict]) -> list[dict]:
    """All cells for JSON."""
    return [
        {"name": c.name, "family": c.family, "values": c.values, "ordinary": c.ordinary, "verdict": verdicts[c.name].verdict,
         "text": verdicts[c.name].text, "findings": [f._asdict() for f in verdicts[c.name].findings]}
        for c in wanted
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--only", nargs="+", choices=sorted(FAMILIES))
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--cells", type=Path, help="all cells as JSON")
    parser.add_argument("--again", action="store_true")
    options, sys.argv[1:] = parser.parse_known_args()
    rows = Rows("stability map" + (", short" if options.short else ""))
    wanted = [c for c in cells(options.short) if not options.only or c.family in options.only]
    verdicts = solve_all(wanted, Kept(KEPT), options.again)
    if options.cells:
        write_text_atomic(options.cells, json.dumps(record(wanted, verdicts), indent=1) + "\n")
    if options.picture:
        picture.draw(wanted, verdicts, options.picture)
    rows_of(rows, wanted, verdicts, whole=not (options.short or options.only))
    rows.finish()


if __name__ == "__main__":
    main()
