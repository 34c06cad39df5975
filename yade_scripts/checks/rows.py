"""What the checks share: the way to the project's modules, YADE's listening sockets closed, and the rows."""

from __future__ import annotations

import sys
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(SCRIPTS), str(SCRIPTS.parent)]

import session  # noqa: E402

session.close_listeners()

from glue.checkrows import Rows  # noqa: E402, F401
