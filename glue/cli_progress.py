"""A command's progress on standard error."""

from __future__ import annotations

import sys
import time


class Progress:
    """Tells a stage's progress and time left on standard error: in place on a terminal, else every 10 s."""

    def __init__(self):
        self._stage, self._start, self._shown = "", 0.0, 0.0

    def __call__(self, stage: str, fraction: float | None, text: str = "") -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._start, self._shown = stage, now, -1e9
        last = fraction is not None and fraction >= 1.0
        live = sys.stderr.isatty()
        if not last and now - self._shown < (0.2 if live else 10.0):
            return
        self._shown = now
        parts = [f"{stage:<9}"]
        if fraction is not None and 0.0 < fraction < 1.0 and now - self._start > 1.0:
            left_s = (now - self._start) / fraction * (1.0 - fraction)
            parts.append(
                f"{100 * fraction:3.0f} %"
                if "left" in text
                else f"{100 * fraction:3.0f} %, {left_s:.0f} s left"
            )
        if text:
            parts.append(text)
        if last and now - self._start > 0.05:
            parts.append(f"({now - self._start:.1f} s)")
        line = "  ".join(parts)
        end = "\n" if last or not live else ""
        print(f"\r\033[K{line}" if live else line, end=end, file=sys.stderr, flush=True)
