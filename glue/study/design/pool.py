"""Runs of a design, one at a time in this process, or several in processes of their own."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import queue
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from glue import stopping
from glue.errors import SolverFailed
from glue.study.design.evaluate import Evaluation

_POLL_S = 0.5
News = tuple[str, float | None, str]  # of one run: stage, fraction of it, text
_common: tuple = ()
_put: Callable = print


class Pool:
    """Does runs ``jobs`` at a time until its block ends; ``common`` goes to each process once, as do the models' imports."""

    def __init__(self, jobs: int, common: tuple):
        self._jobs, self._common = jobs, common
        self._executor: ProcessPoolExecutor | None = None

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, kind, *_) -> None:
        if self._executor is None:
            return
        self._executor.shutdown(wait=kind is None, cancel_futures=True)
        if kind is not None:
            for child in multiprocessing.active_children():
                child.terminate()  # noticed by the run, which stops its solver and leaves what can be gone on with

    def run(
        self,
        task: Callable[..., Evaluation],
        orders: Sequence[tuple],
        tell: Callable[[Evaluation], None],
        progress: Callable[[list[News]], None],
    ) -> None:
        """``tell(task(*common, *order, progress of that run))`` of every order.

        ``progress`` gets the latest news of the runs at work.  Raises SolverFailed when a process dies.
        """
        if self._jobs == 1 or (len(orders) == 1 and self._executor is None):
            for order in orders:
                stopping.check()
                tell(task(*self._common, *order, lambda *news: progress([news])))
            return
        if self._executor is None:
            context = multiprocessing.get_context("spawn")  # numba's threads do not survive a fork
            self._told = context.Queue()
            self._executor = ProcessPoolExecutor(self._jobs, context, _begin, (self._common, self._told))
        try:
            with _interrupt_waits():  # the executor starts its processes here, and only here
                waiting = {self._executor.submit(_one, task, order): order for order in orders}
            self._follow(waiting, tell, progress)
        except BrokenProcessPool as problem:
            raise SolverFailed("an evaluation's process died", cause=str(problem), advice="fewer --jobs: memory?") from None

    def _follow(self, waiting: dict, tell, progress) -> None:
        latest: dict[str, News] = {}
        while waiting:
            stopping.check()
            done, _ = wait(waiting, timeout=_POLL_S, return_when=FIRST_COMPLETED)
            with contextlib.suppress(queue.Empty):
                while True:
                    name, news = self._told.get_nowait()
                    latest[name] = news
            for run in done:
                latest.pop(_name(waiting.pop(run)), None)
                tell(run.result())
            at_work = [latest[name] for order in waiting.values() if (name := _name(order)) in latest]
            if at_work:
                progress(at_work)


@contextlib.contextmanager
def _interrupt_waits() -> Iterator[None]:
    """Ctrl-C is delivered after the block; processes started in it are deaf to it from their first instruction on."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _name(order: tuple) -> str:
    return repr(order)


def _begin(common: tuple, told) -> None:
    global _common, _put
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all; the parent tells its children when to end
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # blocked since the start; not for the solvers
    from glue.target.cache import cache_root

    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_root() / "numba"))
    _common, _put = common, told.put


def _one(task, order: tuple) -> Evaluation:
    try:
        with stopping.noticed():
            return task(*_common, *order, lambda *news: _put((_name(order), news)))
    except SystemExit:  # told to end; the executor would wait for more, on a lock that a dead process holds
        os._exit(128 + signal.SIGTERM)
