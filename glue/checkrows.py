"""Rows of a check: each prints PASS or FAIL with its measured value and limit; together they decide the exit code.

Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path


class Rows:
    """Collects rows of one check; ``finish`` ends the process with 0 when all passed, else 1."""

    def __init__(self, title: str):
        parser = argparse.ArgumentParser(description=title)
        parser.add_argument("--json", type=Path, metavar="FILE", help="also write the rows here")
        self.json = parser.parse_args(sys.argv[1:]).json
        self.title, self.rows, self.begun = title, [], time.monotonic()
        print(title, flush=True)

    def near(self, name: str, value: float, expected: float, relative: float, note: str = "") -> None:
        """``value`` must lie within ``relative`` of ``expected``."""
        off = abs(value / expected - 1.0)
        self._add(
            name, value, f"{expected:.6g} within {relative:.2%}", off <= relative, f"off {off:.3%}  {note}"
        )

    def within(self, name: str, value: float, expected: float, band: float, note: str = "") -> None:
        """``value`` must lie within ``band`` of ``expected``, absolutely."""
        self._add(name, value, f"{expected:.6g} +- {band:.6g}", abs(value - expected) <= band, note)

    def below(self, name: str, value: float, limit: float, note: str = "") -> None:
        """``value`` must not exceed ``limit``."""
        self._add(name, value, f"at most {limit:.6g}", value <= limit, note)

    def true(self, name: str, holds: bool, note: str = "") -> None:
        self._add(name, float(holds), "true", bool(holds), note)

    def _add(self, name, value, limit, passed, note):
        self.rows.append(
            {"name": name, "value": value, "limit": limit, "passed": bool(passed), "note": note.strip()}
        )
        print(
            f"{'PASS' if passed else 'FAIL'}  {name:<58} {value:<12.6g} {limit:<26} {note}".rstrip(),
            flush=True,
        )

    def finish(self):
        passed = sum(r["passed"] for r in self.rows)
        if self.json:
            record = {"check": self.title, "wall_s": time.monotonic() - self.begun, "rows": self.rows}
            self.json.write_text(json.dumps(record, indent=1) + "\n")
        print(f"{passed}/{len(self.rows)} passed", flush=True)
        sys.exit(0 if passed == len(self.rows) else 1)
