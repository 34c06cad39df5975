"""A study of stub stages, its workers in this process: for tests of the sweep itself, without solvers."""

from __future__ import annotations

import contextlib
import csv
import json
from pathlib import Path

import pytest

from glue import stopping
from glue.atomic import write_text_atomic
from glue.study.stage import Stage

STUDY = """schema = 1
name = "small"
scene = "al2024-s390"
stages = ["coverage", "uncertainty"]
[design]
kind = "grid"
{design}
[[axis]]
key = "nozzle.mass_flow_kg_s"
values = [0.01, 0.02, 0.03]
[[axis]]
key = "nozzle.speed_m_s"
range = [40.0, 60.0]
points = 2
name = "shot speed"
{more}"""


class Sweep:
    """Runs the study; stage ``coverage`` gives 10 times the mass flow, and fails or kills the worker where told to."""

    def __init__(self, folder: Path):
        self.folder, self.ran, self.fail, self.warn, self.out = folder, [], {}, {}, folder / "out"
        self.stages = (
            Stage("dimple", (), (), ("dimple.txt",), self._dimple),
            Stage("coverage", ("dimple",), (), ("coverage.txt",), self._coverage),
            Stage("uncertainty", (), (), (), self._uncertainty, uses=("coverage",)),
        )

    def file(self, design: str = "", more: str = "") -> Path:
        path = self.folder / "study.toml"
        path.write_text(STUDY.format(design=design, more=more))
        return path

    def go(self, study: Path | None = None, **options) -> list[tuple[str, str]]:
        """(stage, run) of every stage that really ran."""
        from glue.study.sweep import run_study  # here and below: the tests of a study's file do without the models

        self.ran.clear()
        run_study(study or self.file(), self.out, 1, **options)
        return list(self.ran)

    def rows(self) -> list[dict]:
        """Rows of table.csv."""
        with open(self.out / "table.csv", newline="") as file:
            return list(csv.DictReader(file))

    def study(self) -> dict:
        """Content of study.json."""
        return json.loads((self.out / "study.json").read_text())

    def _dimple(self, work):
        self.ran.append(("dimple", work.path.name))
        write_text_atomic(work.path / "dimple.txt", "dimple")
        return {"dimple": {"radius_m": 2e-4, "wall_s": 3.0}}, ["dimple.txt"]

    def _coverage(self, work):
        self.ran.append(("coverage", work.path.name))
        problem = self.fail.get(work.path.name.split("-")[0])
        if problem:
            raise problem
        write_text_atomic(work.path / "coverage.txt", "coverage")
        share = 10.0 * work.scene.nozzle.mass_flow_kg_s
        warning = self.warn.get(work.path.name.split("-")[0])
        told = {"warning": warning} if warning else {}
        found = {"final": share, "time_98_s": None, "time_98_s_reason": "too short"} | told
        return {"coverage": found}, ["coverage.txt"]

    def _uncertainty(self, work):
        self.ran.append(("uncertainty", work.path.name))
        return {"uncertainty": {"coverage.final": {"value": 0.1, "half_width_95": 0.01}, "table": {"scene": None}}}, []


@pytest.fixture
def sweep(tmp_path, monkeypatch):
    from glue.study import stages
    from glue.study.sweep import library, local

    found = Sweep(tmp_path)
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(stages, "STAGES", found.stages)
    monkeypatch.setattr(library, "solve_libraries", lambda wanted, jobs, progress: 0)
    monkeypatch.setattr(stopping, "noticed", contextlib.nullcontext)  # signals belong to the main thread
    monkeypatch.setattr(local, "run_module", _in_this_process)
    return found


class _Lines:
    def __init__(self, on_line):
        self.on_line = on_line

    def write(self, text):
        for line in filter(None, text.split("\n")):
            self.on_line(line)

    def flush(self):
        pass


def _in_this_process(module, args, *, log, on_line):
    from glue.solvers import Finished
    from glue.study.sweep import worker

    assert module == "glue.study.sweep.worker"
    log.parent.mkdir(exist_ok=True)
    log.write_text("the worker's log\n")
    with contextlib.redirect_stdout(_Lines(on_line)):
        try:
            code = worker.main([str(a) for a in args])
        except SystemExit as died:
            code = died.code
    return Finished(code, log, 0.0, 0)
