"""What decides a cell of the stability map: named invariants and exact values, and what counts as a refusal.

A cell is solved by a function that returns the findings of its invariants.  It is

    right    every finding holds,
    refused  the program said no (InputError, NotConverged: exit codes 2 and 4) and named what is allowed,
    wrong    anything else: a finding that does not hold, a refusal without a range, or any other exception.
"""

from __future__ import annotations

import math
import re
import traceback
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from glue.errors import InputError, NotConverged

RIGHT, REFUSED, WRONG = "right", "refused", "wrong"

# Words that a refusal says its range with; a number must stand in the same sentence.
_RANGE = re.compile(r"\b(allowed|must lie in|must be|at least|at most|up to|above|below|limit)\b[^\n]*\d", re.IGNORECASE)


class Finding(NamedTuple):
    """One invariant: its name, what was found, the most that it may be."""

    invariant: str
    value: float
    limit: float

    @property
    def holds(self) -> bool:
        return bool(self.value <= self.limit)  # a NaN does not


class Verdict(NamedTuple):
    verdict: str
    text: str  # the worst finding, the refusal's reason, or the error
    findings: list[Finding]


def at_most(invariant: str, value: float, limit: float) -> Finding:
    return Finding(invariant, float(value), float(limit))


def near(invariant: str, value, expected, relative: float) -> Finding:
    """Largest |value/expected - 1| of arrays that match, against ``relative``; 0 of empty ones."""
    off = np.abs(np.asarray(value, float) / np.asarray(expected, float) - 1.0)
    return Finding(invariant, float(np.max(off, initial=0.0)) if not np.isnan(off).any() else math.nan, relative)


def equal(invariant: str, value, expected, absolute: float = 0.0) -> Finding:
    """Largest |value - expected| of arrays that match, against ``absolute``; 0 of empty ones."""
    off = np.abs(np.asarray(value, float) - np.asarray(expected, float))
    return Finding(invariant, float(np.max(off, initial=0.0)) if not np.isnan(off).any() else math.nan, absolute)


def true(invariant: str, holds) -> Finding:
    """1 where it does not hold, against 0."""
    return Finding(invariant, float(not holds), 0.0)


def rising(invariant: str, values, slack: float = 0.0) -> Finding:
    """Largest fall from one of ``values`` to the next, relative, against ``slack``."""
    v = np.asarray(values, float)
    fall = np.max((v[:-1] - v[1:]) / np.maximum(np.abs(v[:-1]), 1e-300), initial=0.0)
    return Finding(invariant, float(fall) if np.isfinite(v).all() else math.nan, slack)


def judge(solve: Callable[[], list[Finding]]) -> Verdict:
    """The verdict on what ``solve`` does; it must find something, for a cell without an invariant is not judged."""
    try:
        findings = solve()
    except (InputError, NotConverged) as problem:
        return refusal(str(problem))
    except Exception as problem:  # a traceback is no way to refuse
        where = traceback.extract_tb(problem.__traceback__)[-1]
        text = f"{type(problem).__name__}: {problem} ({where.name}, line {where.lineno})"
        return Verdict(WRONG, " ".join(text.split())[:600], [])
    return verdict(findings)


def verdict(findings: list[Finding]) -> Verdict:
    """Right when all hold, and there is one."""
    if not findings:
        return Verdict(WRONG, "nothing was judged", [])
    broken = [f for f in findings if not f.holds]
    told = broken or [max(findings, key=lambda f: f.value / f.limit if f.limit else f.value)]
    text = "; ".join(f"{f.invariant}: {f.value:.3g}, limit {f.limit:.3g}" for f in told)
    return Verdict(WRONG if broken else RIGHT, text, findings)


def refusal(text: str) -> Verdict:
    """Refused when the sentence names a range, else wrong."""
    said = " ".join(text.split())
    if _RANGE.search(said):
        return Verdict(REFUSED, said[:600], [])
    return Verdict(WRONG, f"refused without saying what is allowed: {said[:600]}", [])
