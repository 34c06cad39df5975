"""Runs a ladder's jobs, those that are done already for nothing, and tells how long the rest will take."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from glue import stopping
from glue.study.tradeoff.jobs import Job, run_jobs

# Seconds a run takes, for the time left until enough was measured; references by REFERENCE_TIMES.
_GUESS_S = {"coverage": 3, "chance": 4, "surface": 3, "patches": 5, "patches-full": 15, "flow": 8, "dimple": 12, "target": 15, "block": 40, "whole": 60}
_POLL_S, _BATCH_S = 0.5, 60.0
_REFERENCE_TIMES = {"flow": 4.0, "dimple": 12.0, "target": 4.0, "block": 4.0, "whole": 5.0}


def guess_s(job: Job) -> float:
    """Rough wall time [s] of a run."""
    return _GUESS_S[job.group.name] * (_REFERENCE_TIMES.get(job.group.name, 1.0) if job.rung is None else 1.0)


def measure(
    jobs: Sequence[Job], progress: Callable[[str], None] = lambda line: None, run: Callable = run_jobs, at_a_time: int = 1
) -> list[dict]:
    """What each job measured, in their order, ``at_a_time`` side by side.  Ctrl-C stops; the same call again goes on there.

    ``run(jobs, tell)`` does some of them, see ``run_jobs``.
    """
    begun, pace, left = time.monotonic(), _Pace(), sum(map(guess_s, jobs))
    found: list[dict | None] = [None] * len(jobs)
    news: queue.Queue = queue.Queue()

    def batch(numbers: list[int]) -> None:
        run([jobs[k] for k in numbers], lambda k, result, took: news.put((numbers[k], result, took)))

    with ThreadPoolExecutor(at_a_time) as pool:  # threads: the work is that of the processes they wait for
        running = [pool.submit(batch, numbers) for numbers in _batches(jobs)]
        try:
            while None in found:
                stopping.check()
                try:
                    k, result, took = news.get(timeout=_POLL_S)
                except queue.Empty:
                    for future in running:
                        if future.done():
                            future.result()  # raises what stopped it
                    continue
                found[k] = result
                left -= guess_s(jobs[k])
                pace.add(guess_s(jobs[k]), took)
                number = sum(f is not None for f in found)
                progress(f"{number} of {len(jobs)}, {_minutes(left * pace.factor / at_a_time)} left: {jobs[k].name}, {took:.1f} s")
                if result["failed"]:
                    progress(f"   failed: {result['failed']}")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    progress(f"{len(jobs)} runs in {_minutes(time.monotonic() - begun)}")
    return found


def _batches(jobs: Sequence[Job]) -> list[list[int]]:
    """Numbers of jobs that one process does in turn, about _BATCH_S each: starting one costs some seconds.

    Seed by seed: what the seeds of a rung share (its dimple) is in the cache when the second one comes.
    """
    batches, filled = [[]], 0.0
    for k in sorted(range(len(jobs)), key=lambda k: jobs[k].seed):
        if filled >= _BATCH_S:
            batches.append([])
            filled = 0.0
        batches[-1].append(k)
        filled += guess_s(jobs[k])
    return batches


class _Pace:
    """How long runs really take over how long was guessed."""

    def __init__(self):
        self.guessed, self.took = 0.0, 0.0

    def add(self, guessed: float, took: float) -> None:
        if took > 0.2 * guessed:  # else it was there already, and tells nothing of those that are not
            self.guessed, self.took = self.guessed + guessed, self.took + took

    @property
    def factor(self) -> float:
        return self.took / self.guessed if self.guessed > 0.0 else 1.0


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
