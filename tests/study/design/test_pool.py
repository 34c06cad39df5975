"""Runs side by side in processes of their own: all are told, their news arrive, an error ends the others."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from glue.errors import InputError  # noqa: E402
from glue.study.design.pool import Pool  # noqa: E402


def task(factor, number, progress):
    progress("flow", 0.5, f"run {number}")
    time.sleep(0.7)  # longer than the parent waits between two looks
    if number == 13:
        raise InputError("thirteen")
    return factor * number


@pytest.mark.parametrize("jobs", [1, 2])
def test_all_are_done_and_their_news_told(jobs):
    found, news = [], []
    with Pool(jobs, (10,)) as pool:
        for orders in ([(1,), (2,)], [(3,)]):
            pool.run(task, orders, found.append, news.extend)
    assert sorted(found) == [10, 20, 30]
    assert {("flow", 0.5, f"run {k}") for k in (1, 2, 3)} <= set(news)


def test_an_error_ends_all_processes():
    with pytest.raises(InputError, match="thirteen"), Pool(2, (10,)) as pool:
        pool.run(task, [(13,), (1,), (2,)], [].append, lambda news: None)
    ended = time.monotonic() + 10.0
    while multiprocessing.active_children() and time.monotonic() < ended:
        time.sleep(0.1)
    assert not multiprocessing.active_children()


STARTING = """
import os, signal, sys, threading, time
from glue import stopping
from glue.study.design.pool import Pool

if __name__ == "__mp_main__":
    time.sleep(60.0)  # a process that loads its models for long

def task(number, progress):
    return number

if __name__ == "__main__":
    threading.Timer(1.0, os.killpg, (0, signal.SIGINT)).start()  # as a terminal does
    try:
        with stopping.noticed(), Pool(2, ()) as pool:
            pool.run(task, [(1,), (2,)], print, print)
    except KeyboardInterrupt:
        sys.exit(130)
"""


def test_ctrl_c_while_processes_start_ends_at_once_and_in_silence(tmp_path):
    script = tmp_path / "starting.py"
    script.write_text(STARTING)
    ended = subprocess.run(
        [sys.executable, str(script)], start_new_session=True, capture_output=True, text=True, timeout=50.0,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )  # fmt: skip
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "", "")
