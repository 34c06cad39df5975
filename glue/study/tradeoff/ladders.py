"""``peen tradeoff``: the ladders of one scene or of the built-in set, measured and written into a table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from glue.errors import InputError
from glue.scene.derive import changed
from glue.scene.reader import example_path, read_scene
from glue.study.pipeline import find_scene
from glue.study.tradeoff.choose import choose, sentence
from glue.study.tradeoff.errors import rows_of, scatter_of
from glue.study.tradeoff.jobs import jobs_of
from glue.study.tradeoff.ladder import BUILT_IN, CHANCE, GROUPS, PATCHES, QUICK, Group
from glue.study.tradeoff.measure import measure
from glue.study.tradeoff.table import read_table, scene_entry, write_table

TABLE = "measured.json"
RECOMMENDED = (0.1, 0.05, 0.02, 0.01)


def groups_named(names: Sequence[str], quick: bool) -> tuple[Group, ...]:
    """The groups of these names, all where none is given.  Raises InputError for a name that is none."""
    known = {g.name: g for g in GROUPS}
    if unknown := [n for n in names if n not in known]:
        raise InputError(f"--only: no group {', '.join(unknown)}; allowed: {', '.join(known)}")
    wanted = names or (QUICK if quick else known)
    return tuple(g for g in GROUPS if g.name in wanted)


def run_ladders(
    scene: str | None, out: Path, groups: tuple[Group, ...], progress: Callable[[str], None] = lambda line: None,
    at_a_time: int = 1,
) -> dict:  # fmt: skip
    """Measure the ladders into ``out``, scene by scene, and return the table ``out``/measured.json.

    Groups and scenes measured before stay in the table.  Raises InputError for a scene that cannot be read.
    """
    files = [find_scene(scene)] if scene else [example_path(name) for name in BUILT_IN]
    ladders = [jobs_of(file, groups, out, short=k > 0) for k, file in enumerate(files)]  # all of them first: a bad scene must cost no time
    for file, jobs in zip(files, ladders, strict=True):
        found = measure(jobs, progress, at_a_time=at_a_time)
        old, measured = _old(out / TABLE, file.stem), {g.name for g in groups}
        rows = [r for r in old["rows"] if r["group"] not in measured] + rows_of(jobs, found)
        scatter = scatter_of(jobs, found, CHANCE.name) or old["scatter"]
        patches = {g.name: s for g in PATCHES if (s := scatter_of(jobs, found, g.name) or old["patches"].get(g.name))}
        entry = scene_entry(file, rows, scatter, patches)
        write_table(out / TABLE, {file.stem: entry | {"recommended": recommended(file, entry)}})
    return read_table(out / TABLE)


def recommended(scene_file: Path, entry: dict) -> dict[str, str]:
    """{promised error: the cheapest combination of rungs that keeps it on the scene itself}, any model allowed."""
    scene = read_scene(scene_file, content=changed(scene_file.read_bytes(), {"models": {}}))
    table, found = {"scenes": {scene_file.stem: entry}}, {}
    for share in RECOMMENDED:
        try:
            found[f"{100 * share:g} %"] = sentence(choose(scene, target_error=share, table=table))
        except InputError as refused:
            found[f"{100 * share:g} %"] = str(refused)
    return found


def _old(table: Path, scene: str) -> dict:
    nothing = {"rows": [], "scatter": {}, "patches": {}}
    return read_table(table)["scenes"].get(scene, nothing) if table.exists() else nothing
