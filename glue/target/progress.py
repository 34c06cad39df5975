"""What the FreeFEM drivers say while they run."""

from __future__ import annotations

import re
from collections.abc import Callable


def relay(progress: Callable[[float, str], None] | None) -> Callable[[str], None]:
    """A line handler that turns ``progress <share 0-1> <text>`` into ``progress(share, text)``."""

    def on_line(line: str) -> None:
        found = re.match(r"progress (\S+) ?(.*)", line)
        if found and progress:
            progress(float(found.group(1)), found.group(2))

    return on_line
