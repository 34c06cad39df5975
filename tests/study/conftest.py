"""A pipeline of stub stages, for the tests of the engine; one of real stages behind a stand-in dimple."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path

import pytest

from glue.atomic import write_text_atomic
from glue.study import pipeline
from glue.study.stage import Stage

sys.path.insert(0, str(Path(__file__).parent))

from flow_runs import SCENE, dimple  # noqa: E402


class Stubs:
    """Stages a -> b -> c and a report d of whatever is there; each writes ``<name>.txt``."""

    def __init__(self):
        self.ran, self.fail, self.salt = [], {}, {}
        self.stages = (
            self._stage("a", ()),
            self._stage("b", ("a",)),
            self._stage("c", ("b",)),
            self._stage("d", (), uses=("a", "b", "c")),
        )

    def _stage(self, name, needs, uses=(), solvers=()):
        def run(work):
            self.ran.append(name)
            if name in self.fail:
                (work.path / f"{name}.half").write_text("half")
                raise self.fail[name]
            text = (
                name + self.salt.get(name, "") + "".join((work.path / f"{n}.txt").read_text() for n in needs)
            )
            write_text_atomic(work.path / f"{name}.txt", text)
            return {name: {"value": len(text)}}, [f"{name}.txt"]

        return Stage(name, needs, (), (f"{name}.txt", f"{name}.half"), run, uses, solvers)

    def go(self, out, **options):
        self.ran.clear()
        pipeline.run("al2024-s390", out, stages=self.stages, **options)
        return self.ran


@pytest.fixture
def stubs():
    return Stubs()


@pytest.fixture
def go(tmp_path):
    """go(model, nozzle="", target="", flow=...): runs dimple (stand-in), flow, coverage, surface; (run, metrics)."""

    from glue.study.stages import STAGES

    def stand_in(work):
        dimple().save(work.path / "dimple" / "dimple.npz")
        return {"dimple": {"radius_m": 0.22e-3}}, ["dimple/dimple.npz"]

    def run(model, nozzle="", target="", flow=0.01, name="run", impacts=None):
        scene = SCENE.format(model=model, nozzle=nozzle, target=target, flow=flow)
        if "feed_speed" in nozzle:
            scene = scene.replace("exposure_time_s = 0.2\n", "")
        (tmp_path / "scene.toml").write_text(scene)
        chosen = {s.name: s for s in STAGES}
        stages = (
            Stage("dimple", (), (), ("dimple",), stand_in),
            *(dataclasses.replace(chosen[n], code=()) for n in ("flow", "coverage", "surface")),
        )
        out = pipeline.run(str(tmp_path / "scene.toml"), tmp_path / name, stages=stages, impacts=impacts)
        return out, json.loads((out / "metrics.json").read_text())

    return run
