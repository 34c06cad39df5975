"""Ctrl-C and a plain kill (SIGTERM), remembered until the command ends.

An exception raised by a signal while a library calls back into Python (numba compiling) is printed and lost;
whoever runs something long asks :func:`check` between its parts.
"""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator

_received: int | None = None


@contextlib.contextmanager
def noticed() -> Iterator[None]:
    """Inside the block both signals raise, at once and again from ``check``; only for the main thread.

    A signal that the caller's environment ignores (nohup, a shell's background job) stays ignored.
    """
    global _received
    _received = None
    numbers = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    before = {number: signal.signal(number, _receive) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _received = None


def check() -> None:
    """Raises KeyboardInterrupt after SIGINT, SystemExit (128 + 15) after SIGTERM, nothing otherwise."""
    if _received == signal.SIGINT:
        raise KeyboardInterrupt
    if _received is not None:
        raise SystemExit(128 + _received)


def _receive(number, frame) -> None:
    global _received
    _received = number
    check()
