"""What a stage costs: time and memory, of this process and of the solvers that it runs."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from glue import solvers


@contextlib.contextmanager
def watched(folder: Path) -> Iterator[Callable[[], dict]]:
    """A block that may ask what it has cost so far; the logs of its solvers are told relative to ``folder``.

    The cost: {"wall_s", "cpu_s": of all processes, "peak_memory_bytes": of the largest, "processes": the solvers' own}.
    """
    start, own_cpu = time.monotonic(), time.process_time()
    with solvers.watch() as ended:
        _forget_peak_memory()

        def cost() -> dict:
            jobs = [
                {"program": name, "log": _relative(done.log, folder), "exit_code": done.exit_code,
                 "wall_s": done.wall_s, "cpu_s": done.cpu_s, "peak_memory_bytes": done.peak_memory_bytes}
                for name, done in ended
            ]  # fmt: skip
            peak = max([_peak_memory_bytes(), *(j["peak_memory_bytes"] for j in jobs)])
            cpu_s = time.process_time() - own_cpu + sum(j["cpu_s"] for j in jobs)
            return {"wall_s": time.monotonic() - start, "cpu_s": cpu_s, "peak_memory_bytes": peak, "processes": jobs}

        yield cost


def _relative(path: Path, start: Path) -> str:
    return str(path.relative_to(start)) if path.is_relative_to(start) else str(path)


def _forget_peak_memory() -> None:
    """Let the largest resident size be counted from here on (Linux)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")  # resets VmHWM, which otherwise never falls


def _peak_memory_bytes() -> int:
    """This process's largest resident size [bytes] since it was last forgotten (Linux; 0 elsewhere)."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return 0
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:")), 0)
