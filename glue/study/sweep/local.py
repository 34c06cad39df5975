"""Runs of a study side by side on this machine: worker processes that take one after another from a queue."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from pathlib import Path

from glue import stopping
from glue.atomic import write_text_atomic
from glue.errors import SolverFailed
from glue.solvers import run_module
from glue.solvers.process import tail
from glue.study.sweep.plan import Run
from glue.study.sweep.records import QUEUE, failure_file, record_failure

_POLL_S = 0.5
Tell = Callable[[float, str], None]


def run_local(out: Path, runs: Sequence[Run], jobs: int, tell: Tell) -> None:
    """Do the runs, ``jobs`` at a time; ``tell(share done, text)`` of each.  Failures are recorded, not raised.

    Raises SolverFailed when no worker can start at all.  Ctrl-C stops the workers.
    """
    write_text_atomic(out / QUEUE, "\n".join(run.name for run in runs))
    news: queue.Queue = queue.Queue()
    pace = Pace({run.name: sum(cost[0] for cost in run.costs.values()) for run in runs}, min(jobs, len(runs)))
    with ThreadPoolExecutor(min(jobs, len(runs))) as pool:  # threads: the work is that of the processes they wait for
        workers = [pool.submit(copy_context().run, _work, out, k, news.put) for k in range(min(jobs, len(runs)))]
        try:
            while not all(worker.done() for worker in workers) or not news.empty():
                stopping.check()
                try:
                    word, name = news.get(timeout=_POLL_S)
                except queue.Empty:
                    continue
                pace.ended(name)
                tell(pace.share, f"{pace.text()}: {name} {word}")
        except BaseException:
            write_text_atomic(out / QUEUE, "")  # no worker begins another
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    for worker in workers:
        worker.result()


class Pace:
    """How far the runs are and how long the rest will take, from what they were estimated to cost and took so far."""

    def __init__(self, estimates_s: dict[str, float], at_a_time: int):
        self._left, self._all = dict(estimates_s), sum(estimates_s.values())
        self._count, self._at_a_time, self._begun = len(estimates_s), at_a_time, time.monotonic()

    def ended(self, name: str) -> None:
        self._left.pop(name, None)

    @property
    def share(self) -> float:
        return 1.0 - len(self._left) / self._count

    def left_s(self) -> float:
        """Seconds until the last run ends."""
        left = sum(self._left.values())
        ended, took = self._all - left, time.monotonic() - self._begun
        return left * (took / ended if ended > 0.0 else 1.0 / self._at_a_time)

    def text(self) -> str:
        left = self.left_s()
        return f"{self._count - len(self._left)} of {self._count}, {f'{left:.0f} s' if left < 90 else f'{left / 60:.0f} min'} left"


def _work(out: Path, number: int, put: Callable[[tuple[str, str]], None]) -> None:
    """Keep one worker at work until the queue is empty; one that dies leaves its run failed, and another goes on."""
    while (out / QUEUE).read_text(encoding="utf-8"):
        stopping.check()
        now = {"run": None, "any": False}

        def on_line(line: str) -> None:
            stopping.check()
            word, _, rest = line.partition(" ")
            if word == "run":
                now.update(run=rest, any=True)
            elif word in ("done", "failed", "busy") and now["run"] == rest.split(" ")[0]:
                put((word, now["run"]))
                now["run"] = None

        log = out / "logs" / f"worker-{number}.log"
        ended = run_module("glue.study.sweep.worker", [out], log=log, on_line=on_line)
        stopping.check()
        if ended.exit_code == 0:
            return
        cause = f"the process that ran it ended with exit code {ended.exit_code}"
        if now["run"] is not None:
            if not failure_file(out, now["run"]).exists():
                record_failure(out, now["run"], SolverFailed.exit_code, "", f"{cause}; log {log}")
            put(("failed", now["run"]))
        elif not now["any"]:
            raise SolverFailed("no run of the study could be started", cause=cause, log=log, tail=tail(log))
