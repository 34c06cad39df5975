"""One child process: its own process group, a log, live lines, a time limit, its peak memory."""

from __future__ import annotations

import contextlib
import os
import selectors
import shlex
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

_GRACE_S = 2.0  # between SIGTERM and SIGKILL: long enough for a solver to remove its own temporary files


class Finished(NamedTuple):
    """How a process ended; ``exit_code`` is minus the signal's number when a signal killed it."""

    exit_code: int
    log: Path
    wall_s: float
    peak_memory_bytes: int
    cpu_s: float = 0.0  # of all its threads


_watchers: ContextVar[list[tuple[str, Finished]] | None] = ContextVar("watchers", default=None)


@contextlib.contextmanager
def watch() -> Iterator[list[tuple[str, Finished]]]:
    """Collect (program name, how it ended) of every process that ends inside the block, for the manifest."""
    seen: list[tuple[str, Finished]] = []
    token = _watchers.set(seen)
    try:
        yield seen
    finally:
        _watchers.reset(token)


class TimedOut(Exception):
    """The process was killed because it reached its time limit."""


def run(
    argv: Sequence[str | Path],
    *,
    cwd: Path,
    log: Path,
    env: Mapping[str, str],
    timeout_s: float | None = None,
    on_line: Callable[[str], None] | None = None,
    line_buffered: bool = False,
    interrupt_s: float | None = None,
) -> Finished:
    """Run ``argv`` to its end, standard input closed, output (both streams, as it comes) in ``log``.

    ``line_buffered`` makes a program that fills a buffer before it writes to a pipe (FreeFem++) give
    its output line by line.

    ``interrupt_s``: seconds that the program gets to end by itself after SIGINT before it is killed like any other;
    for one that has work elsewhere to call off.

    The log's first line is the command as one would type it, with the variables in ``env`` that
    differ from this process's. ``on_line`` gets every complete line without its end.

    Raises FileNotFoundError when the program is missing, TimedOut after ``timeout_s`` seconds, and
    whatever ``on_line`` raises; in each case, and on Ctrl-C, the whole process group is gone by then.
    """
    argv = [str(a) for a in argv]
    log.parent.mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    with open(log, "wb") as log_file:
        log_file.write(os.fsencode(_as_typed(argv, cwd, env)) + b"\n")  # a path need not be UTF-8
        log_file.flush()
        child = subprocess.Popen(
            _wrapped(argv, line_buffered, interrupt_s is not None), cwd=cwd, env=dict(env), stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        try:
            deadline = None if timeout_s is None else start + timeout_s
            _pump(child, log_file, on_line, deadline)
            exit_code, peak, cpu_s = _reap(child, deadline)
        except BaseException:  # Ctrl-C and a failing callback included: no solver outlives its caller
            try:
                if interrupt_s is not None:
                    _interrupt(child, log_file, interrupt_s)
            finally:
                _kill_group(child)
            raise
        finally:
            child.stdout.close()
    done = Finished(exit_code, log, time.monotonic() - start, peak, cpu_s)
    seen = _watchers.get()
    if seen is not None:
        seen.append((Path(argv[0]).name, done))
    return done


def _as_typed(argv, cwd, env) -> str:
    changed = [f"{k}={shlex.quote(v)}" for k, v in sorted(env.items()) if os.environ.get(k) != v]
    return f"$ cd {shlex.quote(str(cwd))} && {' '.join([*changed, shlex.join(argv)])}"


def _wrapped(argv: list[str], line_buffered: bool, interruptible: bool = False) -> list[str]:
    """``argv`` behind some of Debian's essential tools, each of which becomes the program it starts."""
    if shutil.which(argv[0]) is None:  # a missing program must raise here, not in a tool
        return argv
    tools = []
    if shutil.which("setpriv"):  # the kernel kills the child if we are killed: SIGKILL leaves us no time to
        tools += ["setpriv", "--pdeathsig", "KILL", "--"]
    if line_buffered and shutil.which("stdbuf"):
        tools += ["stdbuf", "-oL"]
    if interruptible and shutil.which("env"):  # nohup and a shell's background have SIGINT ignored
        tools += ["env", "--default-signal=INT"]
    return tools + argv


def _pump(child, log_file, on_line, deadline) -> None:
    """Copy the child's output to the log and, line by line, to ``on_line`` until it closes."""
    pending = b""
    with selectors.DefaultSelector() as ready:
        ready.register(child.stdout, selectors.EVENT_READ)
        while True:
            left = None if deadline is None else deadline - time.monotonic()
            if left is not None and left <= 0:
                raise TimedOut
            if not ready.select(left):
                continue
            data = os.read(child.stdout.fileno(), 65536)
            if not data:
                break
            log_file.write(data)
            log_file.flush()  # so that `tail -f` on the log shows where a long run is
            if on_line is None:
                continue
            *lines, pending = (pending + data).split(b"\n")
            for line in lines:
                on_line(line.decode(errors="replace").rstrip("\r"))
    if pending and on_line is not None:
        on_line(pending.decode(errors="replace"))


def _reap(child, deadline) -> tuple[int, int, float]:
    """Wait for the child's end; its exit code, peak resident memory [bytes] and processor time [s]."""
    while True:
        # wait4 rather than Popen.wait: it alone reports the memory and the time of this very child.
        pid, status, usage = os.wait4(child.pid, os.WNOHANG if deadline else 0)
        if pid:
            child.returncode = os.waitstatus_to_exitcode(status)
            # Linux counts in KiB
            return child.returncode, usage.ru_maxrss * 1024, usage.ru_utime + usage.ru_stime
        if time.monotonic() > deadline:  # it closed its output, yet does not end
            raise TimedOut
        time.sleep(0.01)


def _interrupt(child, log_file, patience_s: float) -> None:
    """Send the program, not its children, SIGINT and wait for its end; another Ctrl-C ends the wait."""
    if child.returncode is not None:
        return
    with contextlib.suppress(ProcessLookupError):
        os.kill(child.pid, signal.SIGINT)
    with contextlib.suppress(KeyboardInterrupt, SystemExit):
        try:
            output = child.communicate(timeout=patience_s)[0]
        except subprocess.TimeoutExpired as problem:
            output = problem.output
        log_file.write(output or b"")


def _kill_group(child) -> None:
    for sig, patience_s in ((signal.SIGTERM, _GRACE_S), (signal.SIGKILL, _GRACE_S)):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, sig)
        if child.returncode is None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.wait(patience_s)


def tail(log: Path, lines: int = 12) -> str:
    """The last non-blank lines of a log; empty when there is none."""
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return ""
    return "\n".join([line for line in text.splitlines() if line.strip()][-lines:])
