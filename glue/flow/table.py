"""Logs as text: a commented header, one CSV row per record, a footer that proves the file is whole.

    # impact log, schema 1
    # units = "SI, in the column names"
    # scene_hash = "9f…"
    impact_id,shot_id,time_s,…
    0,17,0.0016651…
    # end n=1

Numbers are written with 17 significant digits, so that reading gives back the same doubles bit for
bit.  Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import numpy as np

from glue.errors import InputError

SCHEMA = 1
INTEGER, REAL = "i8", "f8"


class TableWriter:
    """Writes ``<path>.part`` row by row and gives it its final name in ``finish``.

    Unlike ``glue.atomic`` the ``.part`` stays when the writing program fails: hours of a simulation
    are worth reading (``read_table(..., allow_truncated=True)``), they just must not look whole.

    ``resume``: (rows, bytes) from ``mark`` of an earlier writer. Its ``.part`` is cut there and written on.
    Raises InputError when that is not possible.
    """

    def __init__(
        self,
        path: Path,
        title: str,
        dtype: np.dtype,
        header: dict,
        *,
        resume: tuple[int, int] | None = None,
    ):
        self.path = Path(path)
        self.part = self.path.with_name(self.path.name + ".part")
        self.rows_written = 0
        self._format = ",".join("%d" if dtype[name].kind == "i" else "%.17g" for name in dtype.names) + "\n"
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.unlink(missing_ok=True)  # a failed run must not leave an older run's log behind
        lines = [f"# {title}, schema {SCHEMA}"]
        lines += [
            f"# {key} = {json.dumps(value)}"
            for key, value in {"units": "SI, in the column names", **header}.items()
        ]
        start = "\n".join(lines) + "\n" + ",".join(dtype.names) + "\n"
        if resume is None:
            self._file = open(self.part, "w", encoding="utf-8", newline="")
            self._file.write(start)
        else:
            self._reopen(start.encode(), *resume)

    def _reopen(self, start: bytes, rows: int, size: int) -> None:
        try:
            with open(self.part, "r+b") as f:
                whole = os.fstat(f.fileno()).st_size >= size >= len(start)
                if not whole or f.read(len(start)) != start or size > 0 and _byte_at(f, size - 1) != b"\n":
                    raise InputError(f"{self.part}: does not begin as the log to be continued does")
                f.truncate(size)
            self._file = open(self.part, "a", encoding="utf-8", newline="")
        except OSError as e:
            raise InputError(f"{self.part}: cannot be continued: {e.strerror}") from None
        self.rows_written = rows

    def mark(self) -> tuple[int, int]:
        """(rows, bytes) written so far, handed to the operating system: where ``resume`` can go on."""
        self.flush()
        return self.rows_written, os.fstat(self._file.fileno()).st_size

    def write(self, rows) -> None:
        """Append ``rows``, an iterable of tuples in column order."""
        for row in rows:
            self._file.write(self._format % row)
            self.rows_written += 1

    def flush(self) -> None:
        """Hand what is written to the operating system: it survives this process."""
        self._file.flush()

    def finish(self) -> None:
        """Write the footer and rename ``.part`` to the final name."""
        self._file.write(f"# end n={self.rows_written}\n")
        self._file.flush()
        os.fsync(self._file.fileno())
        self._file.close()
        os.replace(self.part, self.path)

    def abandon(self) -> None:
        """Close the file and leave it as ``.part``: truncated, but nothing computed is lost."""
        self._file.close()


def _byte_at(file, place: int) -> bytes:
    file.seek(place)
    return file.read(1)


def write_table(path: Path, title: str, array: np.ndarray, header: dict) -> None:
    """Write the structured ``array``, shape (n,), in one go; see ``TableWriter`` for the format."""
    writer = TableWriter(path, title, array.dtype, header)
    writer.write(array.tolist())
    writer.finish()


def read_table(
    path: Path, title: str, dtype: np.dtype, *, allow_truncated: bool = False
) -> tuple[np.ndarray, dict]:
    """Read a table written by ``TableWriter``: (structured array of shape (n,), header dict).

    Raises InputError when the file is missing, of another kind or schema, has other columns, or is
    truncated (no footer, or another row count than the footer says).  ``allow_truncated`` accepts a
    file without footer and drops a half-written last row.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError) as e:
        raise InputError(f"{path}: cannot be read ({e})") from None
    lines = text.split("\n")
    if lines[0] != f"# {title}, schema {SCHEMA}":
        raise InputError(f"{path}: no {title} of schema {SCHEMA} (its first line is {lines[0][:60]!r})")
    first = next((i for i, line in enumerate(lines) if not line.startswith("#")), len(lines))
    header = _header(path, lines[1:first])
    columns = lines[first].split(",") if first < len(lines) else []
    if columns != list(dtype.names):
        raise InputError(
            f"{path}: columns are {', '.join(columns) or 'missing'}; expected {', '.join(dtype.names)}"
        )

    rows = lines[first + 1 :]
    last = rows.pop() if rows else ""  # what follows the last newline: empty unless a row was cut in writing
    footer = rows.pop() if rows and rows[-1].startswith("# end n=") else None
    if footer is None and not allow_truncated:
        raise InputError(f"{path}: truncated: no footer after {len(rows)} rows (its writer was stopped)")
    if footer is not None and (last or footer != f"# end n={len(rows)}"):
        raise InputError(f"{path}: damaged: the footer is {footer!r} but there are {len(rows)} rows")
    if not rows:
        return np.empty(0, dtype), header
    try:
        return np.loadtxt(
            io.StringIO("\n".join(rows)), dtype=dtype, delimiter=",", comments=None, ndmin=1
        ), header
    except ValueError as e:
        raise InputError(f"{path}: a row cannot be read: {e}") from None


def _header(path: Path, lines: list[str]) -> dict:
    header = {}
    for line in lines:
        key, sep, value = line[1:].partition(" = ")
        try:
            header[key.strip()] = json.loads(value)
        except ValueError:
            raise InputError(f"{path}: header line {line!r} is not '# key = value'") from None
    return header
