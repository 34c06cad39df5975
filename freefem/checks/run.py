"""FreeFEM against exact solutions, and the reference impact: one PASS/FAIL line a row, exit 1 on any miss.

.venv/bin/python freefem/checks/run.py [--only CHECK] [--json FILE]
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

import contact
import impact
import kernel
import plasticity

from glue.checkrows import Rows

CHECKS = (*kernel.CHECKS, *plasticity.CHECKS, *impact.CHECKS, *contact.CHECKS)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", choices=[check.__name__ for check in CHECKS])
    chosen, sys.argv[1:] = parser.parse_known_args()
    rows = Rows("FreeFEM against exact solutions, and the reference impact")
    with tempfile.TemporaryDirectory(prefix="peen-checks-") as scratch:
        os.environ["PEEN_CACHE"] = str(Path(scratch) / "cache")  # nothing here may come from an earlier run
        for check in CHECKS:
            if chosen.only in (None, check.__name__):
                check(rows, Path(scratch))
    sys.exit(rows.finish())
