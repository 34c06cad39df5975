"""The three ways a run may fail, and their exit codes (``peen`` exits 0 when all is well).

Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations


class PeenError(Exception):
    """Base of every error that a user can do something about; its text is shown without a traceback."""

    exit_code = 1


class InputError(PeenError):
    """Bad input (exit 2). Collects every problem found, so that the user mends them all at once.

    ``problems`` is a list of sentences, each with the place (file, key path) and the allowed range.
    """

    exit_code = 2

    def __init__(self, problems):
        self.problems = [problems] if isinstance(problems, str) else list(problems)
        super().__init__("\n".join(self.problems))


class InUse(InputError):
    """Another process is at work in the folder: no fault of the input, and gone once that one ends."""


class SolverFailed(PeenError):
    """A solver did not do its work (exit 3): names the log, its parsed cause, its last lines and what to try."""

    exit_code = 3

    def __init__(self, what, *, cause="", log=None, tail="", advice=""):
        self.what, self.cause, self.log, self.tail, self.advice = what, cause, log, tail, advice
        parts = [what]
        if cause:
            parts.append(f"  cause: {cause}")
        if log:
            parts.append(f"  log:   {log}")
        if tail:
            parts.append("  last lines:\n" + "\n".join("    | " + line for line in tail.splitlines()))
        if advice:
            parts.append(f"  try:   {advice}")
        super().__init__("\n".join(parts))


class NotConverged(SolverFailed):
    """A solver ran, but its own checks say that the answer is not to be trusted (exit 4)."""

    exit_code = 4
