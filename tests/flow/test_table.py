"""A table that is written on where an earlier writer stopped."""

import numpy as np
import pytest

from glue.errors import InputError
from glue.flow.table import TableWriter, read_table

DTYPE = np.dtype([("n", "i8"), ("x", "f8")])
ROWS = [(i, i / 3.0) for i in range(50)]


def writer(path, header=None, **how):
    return TableWriter(path, "a table", DTYPE, header or {"made": "here"}, **how)


def stopped(path, at=20, more=7):
    """A writer that dies ``more`` rows after its mark; returns the mark."""
    w = writer(path)
    w.write(ROWS[:at])
    mark = w.mark()
    w.write((-1, -1.0) for _ in range(more))
    w.abandon()
    return mark


@pytest.mark.parametrize("at, more", [(20, 7), (0, 3), (50, 0)])
def test_resumed_is_as_written_in_one_go(tmp_path, at, more):
    whole = writer(tmp_path / "whole.csv")
    whole.write(ROWS)
    whole.finish()
    mark = stopped(tmp_path / "t.csv", at, more)
    assert mark[0] == at
    on = writer(tmp_path / "t.csv", resume=mark)
    assert on.rows_written == at
    on.write(ROWS[at:])
    on.finish()
    assert (tmp_path / "t.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    assert read_table(tmp_path / "t.csv", "a table", DTYPE)[0].tolist() == ROWS


def test_a_half_written_row_goes(tmp_path):
    mark = stopped(tmp_path / "t.csv")
    with open(tmp_path / "t.csv.part", "a") as f:
        f.write("77,1.")
    on = writer(tmp_path / "t.csv", resume=mark)
    on.finish()
    assert read_table(tmp_path / "t.csv", "a table", DTYPE)[0].tolist() == ROWS[:20]


@pytest.mark.parametrize("harm", ["missing", "shorter", "other header", "not at a row's end"])
def test_what_cannot_be_continued_is_refused(tmp_path, harm):
    path = tmp_path / "t.csv"
    rows, size = stopped(path)
    part = tmp_path / "t.csv.part"
    if harm == "missing":
        part.unlink()
    elif harm == "shorter":
        part.write_bytes(part.read_bytes()[: size - 1])
    before = part.read_bytes() if part.exists() else None
    header = {"made": "there"} if harm == "other header" else None
    with pytest.raises(InputError, match="cannot be continued|does not begin as"):
        writer(path, header, resume=(rows, size - 1 if harm == "not at a row's end" else size))
    assert (part.read_bytes() if part.exists() else None) == before, "a refused log stays as it was"
