"""A pipeline of stub stages, for the tests of the engine."""

from __future__ import annotations

import pytest

from glue.atomic import write_text_atomic
from glue.study import pipeline
from glue.study.stage import Stage


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
