"""Files that are whole or absent: written as ``<name>.part`` and renamed when complete.

Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def atomic_path(final: Path) -> Iterator[Path]:
    """Yield ``<final>.part``; rename it to ``final`` when the block ends well, remove it when it raises.

    The folder of ``final`` is made. The data reach the disk before the name does (fsync), so that a
    power cut does not leave an empty file under the final name either. Raises OSError when the place
    cannot be written, and FileNotFoundError when the block ends without having written the file.
    """
    final = Path(final)
    part = final.with_name(final.name + ".part")
    final.parent.mkdir(parents=True, exist_ok=True)
    try:
        yield part
        with open(part, "rb") as f:
            os.fsync(f.fileno())
        os.replace(part, final)
    except BaseException:  # KeyboardInterrupt too: Ctrl-C must not leave a .part behind
        part.unlink(missing_ok=True)
        raise


def write_text_atomic(path: Path, text: str) -> None:
    """Write ``text`` as UTF-8, newlines as they are; an old file stays until the new one is whole."""
    with atomic_path(Path(path)) as part:
        with open(part, "w", encoding="utf-8", newline="") as f:
            f.write(text)
