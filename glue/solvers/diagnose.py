"""From an exit code and a log to a cause and to what one can do about it.

FreeFem++ ends with 0 in spite of a singular matrix or a NaN, so an exit code alone proves nothing;
the patterns below are what the two codes of Debian 12 (YADE 2023.02a, FreeFEM 4.11) print.
"""

from __future__ import annotations

import re
import signal
from pathlib import Path
from typing import NamedTuple

from glue.solvers import process


class Pattern(NamedTuple):
    """``regex`` in the log means ``cause`` (with its groups as {0}, {1}); fatal even with exit code 0?"""

    regex: str
    cause: str
    advice: str
    fatal: bool = False


_MEMORY = Pattern(
    r"bad_alloc|[Oo]ut of memory|Cannot allocate memory|MemoryError",
    "out of memory",
    "a coarser preset (--accuracy fast) or a machine with more memory",
)

FREEFEM = (
    Pattern(r"Load error ?: ?(peen\S*)", "the compiled kernel {0} was not found", "make plugin"),
    Pattern(
        r"Load error ?: ?(\S+)",
        "the FreeFEM plugin {0} was not found",
        "make setup (package libfreefem++), then peen doctor",
    ),
    Pattern(
        r"lex: Error input opening file[\s\S]*?line number ?: ?\d+, (\S+)",
        "the include file {0} was not found",
        "run from a complete checkout: the .idp files are in freefem/lib",
    ),
    Pattern(
        r"Error (?:umpfack )?(umfpack_\w+)\s+status\s+(\S+)",
        "singular matrix ({0}, status {1}): the values are meaningless",
        "look for a missing boundary condition or an empty mesh region; the log shows where",
        fatal=True,
    ),
    Pattern(
        r"CHOLMOD (?:warning|error)[^\n]*not positive definite",
        "the matrix is not positive definite",
        "a smaller step or a finer mesh (--accuracy reference)",
    ),
    Pattern(
        r"current line = (\d+)\s+Exec error : Out of bound",
        "array index out of bounds at line {0} of the script",
        "the results may stem from another version; remove the stage's folder and run again",
    ),
    Pattern(
        r"current line = (\d+)\s+Exec error : exec assert",
        "an assertion of the script failed at line {0}",
        "the lines above it in the log say what was checked",
    ),
    Pattern(
        r"Erreur ouverture du fichier (\S+)",
        "cannot open the mesh file {0}",
        "is the run directory complete and readable?",
    ),
    Pattern(
        r"Error opening file (\S+)",
        "cannot open the file {0}",
        "is the run directory writable and the disk not full?",
    ),
    Pattern(
        r"Compile error : ([^\n]*)[\s\S]*?line number ?:(\d+)",
        "the script does not compile ({0}, line {1})",
        "an edited .edp or .idp: FreeFem++ -jc FILE checks it alone",
    ),
    _MEMORY,
)

YADE = (
    Pattern(
        r"ModuleNotFoundError: No module named '([^']+)'",
        "YADE's Python lacks the module {0}",
        "YADE runs Debian's Python: only numpy and the standard library may be imported there",
    ),
    _MEMORY,
    Pattern(
        r"Traceback \(most recent call last\):[\s\S]*\n(\w[\w.]*(?:Error|Exception|Interrupt|Failed)[^\n]*)",
        "{0}",
        "the log shows where the script stopped",
    ),
    Pattern(
        r"SyntaxError: ([^\n]*)",
        "the script does not compile: {0}",
        "an edited script: python3 -m py_compile FILE",
    ),
)

COMPILER = (
    Pattern(
        r"\S*?([^/\s]+:\d+:\d+): (?:fatal )?error: ([^\n]*)",
        "{0}: {1}",
        "mend the kernel's source, or make setup if a header is missing",
    ),
    Pattern(r"cannot find (-l\S+)", "the library {0} is missing", "make setup"),
)

_EXIT_CODES = {  # FreeFem++, measured; used when no pattern explains the end
    1: "syntax error or missing include",
    2: "missing plugin",
    6: "array sizes do not match",
    8: "assertion, index out of bounds, or a file that cannot be opened",
}


class Diagnosis(NamedTuple):
    cause: str
    advice: str


def match(log: Path, table: tuple[Pattern, ...], *, fatal_only: bool = False) -> Diagnosis | None:
    """The first pattern of ``table`` found in the log."""
    try:
        text = log.read_text(errors="replace")
    except OSError:
        return None
    for p in table:
        found = None if fatal_only and not p.fatal else re.search(p.regex, text)
        if found:
            return Diagnosis(p.cause.format(*found.groups()), p.advice)
    return None


def explain(done: process.Finished, table: tuple[Pattern, ...]) -> Diagnosis:
    """Why a process that did not end well did so: signal, then log, then exit code."""
    if done.exit_code < 0:
        number = -done.exit_code
        name = signal.Signals(number).name if number in set(signal.Signals) else "unknown"
        advice = {
            signal.SIGKILL: "most often memory ran out (dmesg tells): a coarser preset, fewer runs at once",
            signal.SIGSEGV: "a crash inside the solver: peen doctor; report it with the log if it stays",
        }.get(number, "who or what stopped it? run the same command again to continue")
        found = match(done.log, table)
        return Diagnosis(
            f"killed by signal {number} ({name})" + (f"; {found.cause}" if found else ""), advice
        )
    found = match(done.log, table)
    if found:
        return found
    meaning = _EXIT_CODES.get(done.exit_code, "") if table is FREEFEM else ""
    return Diagnosis(f"exit code {done.exit_code}" + (f" ({meaning})" if meaning else ""), "read the log")
