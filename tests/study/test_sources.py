"""A stage is run again when, and only when, a file it is made by changes: each pattern must name files."""

from __future__ import annotations

import re

import pytest

from glue.solvers import repo_root
from glue.study.stages import STAGES


@pytest.mark.parametrize("stage", STAGES, ids=[s.name for s in STAGES])
def test_every_pattern_names_files(stage):
    for pattern in stage.code:
        assert list(repo_root().glob(pattern)), pattern


@pytest.mark.parametrize(("name", "driver"), [("dimple", "single_impact.edp"), ("target", "cell.edp")])
def test_all_that_a_driver_includes_is_a_source(name, driver):
    """The include statements, followed through: none may be missing among the stage's sources."""
    root = repo_root() / "freefem"
    (stage,) = (s for s in STAGES if s.name == name)
    sources = {p for pattern in stage.code for p in repo_root().glob(pattern)}
    kind = "axisym" if name == "dimple" else "small"
    pending = [driver, f"points_{kind}_kernel.idp", f"points_{kind}_script.idp"]
    while pending:
        path = next(p for p in (root / pending[-1], root / "lib" / pending[-1]) if p.exists())
        pending.pop()
        assert path in sources, path
        pending += re.findall(r'^\s*include "(\S+)"', path.read_text(), re.MULTILINE)
