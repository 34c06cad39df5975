"""README blocks: replaced whole, never left behind."""

from __future__ import annotations

import json

import pytest

from glue.errors import InputError
from glue.report.readme import BENCHMARKS, bench_table, replace_block, verification_table
from glue.solvers import repo_root

MARKED = "a\n<!-- begin x -->\nold\nlines\n<!-- end x -->\nb\n"


def test_a_block_is_replaced_between_its_markers():
    assert replace_block(MARKED, "x", "new \\1") == "a\n<!-- begin x -->\nnew \\1\n<!-- end x -->\nb\n"


@pytest.mark.parametrize("text", ["no marker", MARKED + MARKED])
def test_a_block_without_its_place_is_refused(text):
    with pytest.raises(InputError, match="README.md"):
        replace_block(text, "x", "new")


def test_the_readme_has_every_place_and_failures_show(tmp_path):
    text = (repo_root() / "README.md").read_text(encoding="utf-8")
    for name in ("output", "trade", "verification", *(f"bench {name}" for name in BENCHMARKS)):
        assert text != replace_block(text, name, "unlikely")
    row = {"name": "n", "value": 1.0, "limit": "at most 0", "passed": False, "note": ""}
    (tmp_path / "freefem.json").write_text(json.dumps({"check": "c", "wall_s": 1, "rows": [row]}))
    assert "**0/1**" in verification_table(tmp_path)
    assert "**FAIL**" in verification_table(tmp_path)


def test_no_checks_no_table(tmp_path):
    with pytest.raises(InputError, match="make checks"):
        verification_table(tmp_path)


def test_a_benchmark_shows_its_misses_and_notes(tmp_path):
    rows = [
        {"name": "a|b", "value": 1.5, "limit": "at least 15", "passed": False, "note": "why"},
        {"name": "c", "value": 2.0, "limit": "at most 3", "passed": True, "note": ""},
    ]
    (tmp_path / "flow.json").write_text(json.dumps({"check": "c", "wall_s": 1, "rows": rows}))
    table = bench_table(tmp_path / "flow.json")
    assert "| a\\|b | 1.5 | at least 15 | **FAIL** | why |" in table
    assert "| c | 2 | at most 3 | pass |  |" in table


def test_no_benchmark_no_table(tmp_path):
    with pytest.raises(InputError, match="make bench-flow"):
        bench_table(tmp_path / "flow.json")
