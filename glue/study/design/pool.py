"""Runs of a design, one at a time in this process, or several in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from glue import stopping
from glue.errors import SolverFailed
from glue.study.design.evaluate import Evaluation

_POLL_S = 0.5
_common: tuple = ()


def run_all(
    task: Callable[..., Evaluation],
    common: tuple,
    orders: Sequence[tuple],
    jobs: int,
    tell: Callable[[Evaluation], None],
    progress: Callable[[str, float | None, str], None],
) -> None:
    """``tell(task(*common, *order))`` of every order, ``jobs`` at a time; ``progress`` is the task's last argument when alone.

    ``common`` goes to each process once.  Ctrl-C stops them all.
    """
    if jobs == 1 or len(orders) == 1:
        for order in orders:
            stopping.check()
            tell(task(*common, *order, progress))
        return
    context = multiprocessing.get_context("spawn")  # numba's threads do not survive a fork
    with ProcessPoolExecutor(min(jobs, len(orders)), context, _begin, (common,)) as pool:
        waiting = {pool.submit(_one, task, order) for order in orders}
        try:
            while waiting:
                stopping.check()
                done, waiting = wait(waiting, timeout=_POLL_S, return_when=FIRST_COMPLETED)
                for run in done:
                    tell(run.result())
        except BrokenProcessPool as problem:
            raise SolverFailed("an evaluation's process died", cause=str(problem), advice="fewer --jobs: memory?") from None
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                child.terminate()  # noticed by the run, which stops its solver and leaves what can be gone on with
            raise


def _begin(common: tuple) -> None:
    global _common
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all; the parent tells its children when to end
    from glue.target.cache import cache_root

    os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_root() / "numba"))
    _common = common


def _one(task, order: tuple) -> Evaluation:
    with stopping.noticed():
        return task(*_common, *order)
