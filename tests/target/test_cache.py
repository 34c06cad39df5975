"""The shared cache: complete or absent, never half, and keyed by all that went in."""

from __future__ import annotations

import pytest

from glue.errors import InputError, SolverFailed
from glue.target.cache import cached_folder, content_key


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_made_once(cache):
    calls = []

    def make(folder):
        calls.append(folder)
        (folder / "r").write_text("1")

    first, second = cached_folder("kind", "key", make), cached_folder("kind", "key", make)
    assert [first[1], second[1]] == [False, True]
    assert len(calls) == 1
    assert (second[0] / "r").read_text() == "1"


def test_a_failure_leaves_its_log_where_the_error_says(cache):
    def make(folder):
        (folder / "freefem.log").write_text("why")
        raise SolverFailed("it broke", log=folder / "freefem.log")

    with pytest.raises(SolverFailed) as caught:
        cached_folder("kind", "key", make)
    kept = cache / "kind" / "key-failed" / "freefem.log"
    assert kept.read_text() == "why"
    assert str(kept) in str(caught.value)
    assert not (cache / "kind" / "key").exists()


def test_an_interrupt_leaves_nothing(cache):
    def make(folder):
        (folder / "half").write_text("")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cached_folder("kind", "key", make)
    assert list((cache / "kind").iterdir()) == []


def test_a_cache_that_cannot_be_made_is_bad_input(cache):
    cache.write_text("a file where the folder should be")
    with pytest.raises(InputError, match="PEEN_CACHE"):
        cached_folder("kind", "key", lambda folder: None)


def test_the_key_follows_inputs_and_sources():
    key = content_key({"a": 1}, ("freefem/*.edp",))
    assert key == content_key({"a": 1}, ("freefem/*.edp",))
    assert key != content_key({"a": 2}, ("freefem/*.edp",))
    assert key != content_key({"a": 1}, ("freefem/lib/*.idp",))
