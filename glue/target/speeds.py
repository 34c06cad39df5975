"""One material at many speeds: impacts solved side by side, and monotone curves through what they found."""

from __future__ import annotations

import contextvars
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from functools import cached_property

import numpy as np

from glue.errors import InputError, PeenError
from glue.scene.model import Material
from glue.target.physics import ImpactPhysics
from glue.target.reduced_impact import Numerics, ReducedImpact, solve_reduced

SMOOTHED_FROM = 8  # points; a solved value scatters with where its mesh's nodes fall (a/6: radius .4 %, e 1 %)
_POLL_S = 0.2


def spaced(slowest_m_s: float, fastest_m_s: float, points: int) -> list[float]:
    """``points`` speeds in equal ratios from end to end, rounded to 9 digits: cache entries for good."""
    return [float(f"{v:.9g}") for v in np.geomspace(slowest_m_s, fastest_m_s, points)]


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def solve_speeds(
    material: Material,
    speeds_m_s: Sequence[float],
    *,
    density_kg_m3: float,
    elements_per_radius: int,
    physics: ImpactPhysics = ImpactPhysics(),  # noqa: B008 - frozen
    numerics: Numerics = Numerics(),  # noqa: B008 - frozen
    jobs: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> list[ReducedImpact]:
    """The impacts of ``material.single_law`` at these speeds, in their order; ``jobs`` FreeFem++ at a time (all cores).

    Each is a cache entry of its own, so that a stopped call goes on where it was.  The first failure stops the rest
    and is raised (SolverFailed, NotConverged, with its speed in a note); Ctrl-C stops all.
    """
    shares, stop = [0.0] * len(speeds_m_s), threading.Event()

    def one(k: int, speed: float) -> ReducedImpact:
        def tell(share: float, text: str = "") -> None:
            shares[k] = share
            if stop.is_set():
                raise KeyboardInterrupt  # the one exception that leaves no trace in the cache

        tell(0.0)
        try:
            found = solve_reduced(
                material, material.single_law, speed_m_s=speed, density_kg_m3=density_kg_m3,
                elements_per_radius=elements_per_radius, physics=physics, numerics=numerics, progress=tell,
            )  # fmt: skip
        except PeenError as problem:
            problem.add_note(f"in the impact on {material.key} at {speed:g} m/s")
            raise
        shares[k] = 1.0
        return found

    with ThreadPoolExecutor(max(1, min(jobs or cores(), len(speeds_m_s)))) as pool:
        # Threads: the work is FreeFem++'s.  Each in a copy of this context, which knows who watches processes.
        runs = [pool.submit(contextvars.copy_context().run, one, k, v) for k, v in enumerate(speeds_m_s)]
        try:
            _follow(runs, shares, progress)
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [run.result() for run in runs]


def _follow(runs: list[Future], shares: list[float], progress) -> None:
    """Tell how far all are until they are done; raises the first failure.  ``progress`` is called by this thread."""
    waiting = set(runs)
    while waiting:
        done, waiting = wait(waiting, timeout=_POLL_S, return_when=FIRST_EXCEPTION)
        for run in done:
            run.result()
        if progress:
            ended = sum(run.done() for run in runs)
            progress(sum(shares) / len(shares), f"{ended} of {len(runs)} speeds")


class Curve:
    """A positive quantity over the speed: a monotone spline (PCHIP) in logarithms of both.

    From SMOOTHED_FROM points on it goes through the least-squares cubic's values at them, for the scatter of solved
    values is no part of the curve; the points themselves where that cubic does not rise or fall as they do.
    """

    def __init__(self, name: str, speed_m_s, values):
        self.name, self.speed_m_s = name, np.asarray(speed_m_s, dtype=float)
        self.values = np.asarray(values, dtype=float)
        if not (self.values > 0.0).all() or not (np.diff(self.speed_m_s) > 0.0).all() or self.speed_m_s.size < 2:
            raise InputError(f"{name}: a curve needs two and more rising speeds with values above 0")
        self._spline = _monotone(np.log(self.speed_m_s), np.log(self.values))

    @cached_property
    def error(self) -> float:
        """Largest relative miss of an inner point by the curve of all others; NaN below three points."""
        x, y = np.log(self.speed_m_s), np.log(self.values)
        inner = range(1, len(x) - 1)
        misses = [abs(np.expm1(_monotone(np.delete(x, k), np.delete(y, k))(x[k]) - y[k])) for k in inner]
        return float(max(misses, default=np.nan))

    def __call__(self, speed_m_s) -> np.ndarray:
        """Values at ``speed_m_s`` (any shape).  Raises InputError outside the speeds of the table."""
        v = np.asarray(speed_m_s, dtype=float)
        low, high = self.speed_m_s[[0, -1]]
        if not ((v >= low * (1 - 1e-9)) & (v <= high * (1 + 1e-9))).all():
            raise InputError(
                f"{self.name} at {v.min():g} to {v.max():g} m/s: the library does not extrapolate; allowed {low:g} to {high:g} m/s"
            )
        return np.exp(self._spline(np.log(np.clip(v, low, high))))

    def with_tails(self, speed_m_s) -> np.ndarray:
        """As a call, and beyond the table power laws with the slopes of its first and last step; 0 at speeds <= 0."""
        v = np.asarray(speed_m_s, dtype=float)
        x = np.log(self.speed_m_s)
        y = self._spline(x)
        at = np.log(np.maximum(v, 1e-300))
        found = self._spline(np.clip(at, x[0], x[-1]))
        found = found + np.minimum(at - x[0], 0.0) * (y[1] - y[0]) / (x[1] - x[0])
        found = found + np.maximum(at - x[-1], 0.0) * (y[-1] - y[-2]) / (x[-1] - x[-2])
        return np.where(v > 0.0, np.exp(found), 0.0)

    def exponent(self) -> float:
        """Slope of the least-squares straight line in logarithms."""
        return float(np.polyfit(np.log(self.speed_m_s), np.log(self.values), 1)[0])


def _monotone(x: np.ndarray, y: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    from scipy.interpolate import PchipInterpolator  # here: half a second that who asks for speeds only does without

    if len(x) >= SMOOTHED_FROM:
        middle = x.mean()
        smooth = np.polyval(np.polyfit(x - middle, y, 3), x - middle)
        if (np.diff(smooth) * (y[-1] - y[0]) > 0.0).all():
            y = smooth
    return PchipInterpolator(x, y)


def outside(speed_m_s, table_m_s) -> np.ndarray:
    """Which of ``speed_m_s`` lie beyond the ends of the table, bool."""
    v = np.asarray(speed_m_s, dtype=float)
    return (v < table_m_s[0] * (1 - 1e-9)) | (v > table_m_s[-1] * (1 + 1e-9))
