"""Where the solvers are and which versions they have."""

from __future__ import annotations

import functools
import importlib.metadata
import os
import platform
import re
import shutil
import subprocess
from pathlib import Path

from glue.errors import SolverFailed

_LIBRARIES = ("numpy", "scipy", "numba", "meshio", "pyvista", "matplotlib")


def repo_root() -> Path:
    """The checkout's top folder; YADE's scripts and FreeFEM's are read from there."""
    return Path(__file__).resolve().parents[2]


def require_checkout() -> Path:
    """``repo_root()``; raises SolverFailed when the solvers' scripts are not beside the package."""
    root = repo_root()
    if not ((root / "freefem").is_dir() and (root / "yade_scripts").is_dir()):
        raise SolverFailed(
            "the scripts of YADE and FreeFEM were not found",
            cause=f"{root} is no checkout of the project: it was installed as a plain package",
            advice="run from the checkout: git clone …, then make setup (an editable install)",
        )
    return root


def find_yade() -> Path:
    """YADE's start script: ``$PEEN_YADE``, else ``yade`` on the path. Raises SolverFailed."""
    return _find("PEEN_YADE", "yade", "YADE", "yade")


def find_freefem() -> Path:
    """FreeFem++: ``$PEEN_FREEFEM``, else ``FreeFem++`` on the path. Raises SolverFailed."""
    return _find("PEEN_FREEFEM", "FreeFem++", "FreeFem++", "freefem++")


def find_compiler() -> Path:
    """FreeFEM's ``ff-c++``: ``$PEEN_FFCXX``, else on the path. Raises SolverFailed."""
    return _find("PEEN_FFCXX", "ff-c++", "FreeFEM's plugin compiler ff-c++", "libfreefem++-dev")


def _find(variable: str, program: str, what: str, package: str) -> Path:
    wanted = os.environ.get(variable)
    found = shutil.which(wanted or program)
    if found:
        return Path(found)
    cause = f"{variable}={wanted} is not a program" if wanted else f"no {program} on the path"
    advice = f"correct or unset {variable}" if wanted else f"make setup (Debian package {package})"
    raise SolverFailed(f"{what} was not found", cause=cause, advice=advice)


@functools.cache
def versions() -> dict:
    """Version of every code that has a part in a run; None where one cannot be told.

    Debian's FreeFEM package 4.11 calls its binary 4.9, so package and binary are both given.
    """
    return {
        "peen": _library("peen"),
        "peen_commit": _said(["git", "-C", repo_root(), "describe", "--always", "--dirty"], r"(\S+)"),
        "python": platform.python_version(),
        "yade": {"binary": _binary(find_yade, ["--version"], r"version: (\S+)"), "package": package("yade")},
        "freefem": {
            "binary": _binary(find_freefem, [], r"[Vv]ersion (\S+)"),
            "package": package("freefem++"),
        },
        **{name: _library(name) for name in _LIBRARIES},
    }


def package(name: str) -> str | None:
    """Version of an installed Debian package, None when it is not installed (or this is not Debian)."""
    return _said(["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", name], r"^installed (\S+)")


def _binary(find, args: list[str], pattern: str) -> str | None:
    try:
        return _said([find(), *args], pattern)
    except SolverFailed:
        return None


def _library(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _said(argv, pattern: str) -> str | None:
    """First group of ``pattern`` in what a short command prints, None when it fails to."""
    try:
        done = subprocess.run(
            [str(a) for a in argv], stdin=subprocess.DEVNULL, capture_output=True, timeout=30
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    found = re.search(pattern, (done.stdout + done.stderr).decode(errors="replace"))
    return found.group(1) if found else None
