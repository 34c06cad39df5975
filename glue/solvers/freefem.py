"""Runs FreeFem++ drivers and builds the compiled kernels they load."""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import shutil
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from glue.errors import NotConverged, SolverFailed
from glue.solvers import diagnose, process
from glue.solvers.blas import blas_environment
from glue.solvers.find import find_compiler, find_freefem, package, repo_root, require_checkout

_PLUGINS = "/usr/lib/freefem++"  # Debian's binary looks in /usr/lib/ff++, where nothing is
_INCLUDES = "/usr/include/freefem++/idp"
_NOT_FINITE = re.compile(r"(?<![\w.])[-+]?(?:nan|inf)(?:inity)?(?![\w.])", re.IGNORECASE)


def run_freefem(
    driver: Path,
    *,
    cwd: Path,
    log: Path,
    status: Path,
    timeout_s: float | None = None,
    on_line: Callable[[str], None] | None = None,
    defines: Sequence[str] = (),
) -> process.Finished:
    """Run ``FreeFem++ -nw -ne -v 0 driver defines…`` on one thread and return when its results are sound.

    A driver writes ``status`` as the last thing it does: first line ``ok`` or ``failed: <cause>``,
    then any numbers of its own checks. The file is removed first, so that an older run's cannot
    speak for this one; without it, with a NaN or infinity in it, or with a singular matrix in the
    log, the results are refused although FreeFem++ ends with 0.

    Raises NotConverged for ``failed: …``, SolverFailed for everything else.
    """
    status.unlink(missing_ok=True)
    argv = [find_freefem(), "-nw", "-ne", "-v", "0", driver.resolve(), *defines]
    done = _run(argv, driver.name, cwd=cwd, log=log, timeout_s=timeout_s, on_line=on_line)
    first, rest = _read_status(status)
    if first is not None and first.startswith("failed"):
        cause = first.partition(":")[2].strip() or "no cause given"
        raise _failed(
            driver.name,
            log,
            cause,
            "another preset (--accuracy); is the scene within the models' range? peen check",
            NotConverged,
        )
    if done.exit_code != 0:
        raise _failed(driver.name, log, *diagnose.explain(done, diagnose.FREEFEM))
    fatal = diagnose.match(log, diagnose.FREEFEM, fatal_only=True)
    if fatal:
        raise _failed(driver.name, log, *fatal)
    if first is None:
        raise _failed(
            driver.name,
            log,
            f"exit code 0, but it did not write {status.name}",
            "the last lines tell how far it came",
        )
    if first != "ok":
        raise _failed(
            driver.name,
            log,
            f"{status.name} begins with {first!r} instead of 'ok'",
            "read the log" if first else f"is the disk full ({status.parent})? then the log",
        )
    if _NOT_FINITE.search(rest):
        raise _failed(
            driver.name,
            log,
            f"{status.name} holds a value that is not finite",
            "a smaller step or another preset",
        )
    return done


def compile_freefem(driver: Path) -> None:
    """Compile a driver without running it (``FreeFem++ -jc``); raises SolverFailed with its complaint."""
    with tempfile.TemporaryDirectory(prefix="peen-jc-") as scratch:
        log = Path(scratch) / "compile.log"
        argv = [find_freefem(), "-nw", "-ne", "-v", "0", "-jc", driver.resolve()]
        done = _run(argv, driver.name, cwd=driver.resolve().parent, log=log, timeout_s=60)
        if done.exit_code != 0:
            cause, advice = diagnose.explain(done, diagnose.FREEFEM)
            # The log goes with the scratch folder, so the error carries the lines and no path.
            raise SolverFailed(
                f"{driver.name} does not compile", cause=cause, tail=process.tail(log), advice=advice
            )


def _run(argv, name: str, *, cwd, log, timeout_s=None, on_line=None) -> process.Finished:
    root = require_checkout()
    env = {
        **os.environ,
        # No ";;" at the end: with it FreeFem++ 4.9 reads only the first folder of a list.
        "FF_LOADPATH": f"{plugin_dir()};{_PLUGINS}",
        "FF_INCLUDEPATH": f"{root / 'freefem'};{root / 'freefem' / 'lib'};{_INCLUDES}",
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
        **blas_environment(),
    }
    try:
        return process.run(
            argv, cwd=cwd, log=log, env=env, timeout_s=timeout_s, on_line=on_line, line_buffered=True
        )
    except process.TimedOut:
        raise _failed(
            name, log, f"not finished after {timeout_s:g} s", "a coarser preset (--accuracy fast)"
        ) from None
    except OSError as problem:
        raise _failed(name, log, f"could not be started: {problem}", "peen doctor") from None


def _read_status(status: Path) -> tuple[str | None, str]:
    try:
        first, _, rest = status.read_text(errors="replace").partition("\n")
    except OSError:
        return None, ""
    return first.strip(), rest


def _failed(
    name: str, log: Path, cause: str, advice: str, kind: type[SolverFailed] = SolverFailed
) -> SolverFailed:
    what = f"FreeFem++ did not converge in {name}" if kind is NotConverged else f"FreeFem++ failed in {name}"
    return kind(what, cause=cause, log=log, tail=process.tail(log), advice=advice)


def plugin_dir(sources: Path | None = None) -> Path:
    """Folder of the compiled kernels, ``build/plugin/<hash of the sources and of FreeFEM's version>``."""
    folder = sources or repo_root() / "freefem" / "plugin"
    digest = hashlib.sha256((package("freefem++") or "unknown").encode())
    for path in sorted(p for p in folder.glob("*") if p.suffix in {".cpp", ".hpp", ".h"}):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return repo_root() / "build" / "plugin" / digest.hexdigest()[:16]


def build_plugin(force: bool = False, sources: Path | None = None) -> Path:
    """Compile every ``freefem/plugin/*.cpp`` with ``ff-c++``, unless done before; return ``plugin_dir()``.

    A source names the libraries it needs in a comment, ``// ff-c++: -lcholmod -lopenblas``.
    Raises SolverFailed with the compiler's first error. The folder appears only when all are built.
    """
    final = plugin_dir(sources)
    if final.is_dir() and not force:
        return final
    folder = sources or require_checkout() / "freefem" / "plugin"
    compiler = find_compiler()
    final.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="building-", dir=final.parent) as scratch:
        built = Path(scratch) / "done"
        built.mkdir()
        for header in [*folder.glob("*.hpp"), *folder.glob("*.h")]:
            shutil.copy(header, scratch)
        for source in sorted(folder.glob("*.cpp")):
            shutil.copy(source, scratch)
            wanted = re.search(r"^// ff-c\+\+: (.*)$", source.read_text(), re.MULTILINE)
            log = final.parent / f"{source.stem}.log"
            # -w: FreeFEM's own headers alone print a thousand lines of deprecation warnings.
            env = {**os.environ, "CXX": os.environ.get("CXX", "g++") + " -w"}
            argv = [compiler, *shlex.split(wanted.group(1) if wanted else ""), source.name]
            what = f"the kernel {source.name} did not build"
            try:
                done = process.run(argv, cwd=Path(scratch), log=log, env=env, timeout_s=300)
            except process.TimedOut:
                raise SolverFailed(what, cause="the compiler did not end within 300 s", log=log) from None
            library = Path(scratch) / f"{source.stem}.so"
            if (
                done.exit_code != 0 or not library.exists()
            ):  # ff-c++ passes on the linker's code, not always the compiler's
                cause, advice = diagnose.explain(done, diagnose.COMPILER)
                raise SolverFailed(what, cause=cause, log=log, tail=process.tail(log), advice=advice)
            shutil.move(library, built / library.name)
        if force:
            shutil.rmtree(final, ignore_errors=True)
        try:
            built.rename(final)
        except OSError:
            if (
                not final.is_dir()
            ):  # else another process built the same meanwhile: the same sources, the same kernels
                raise
    return final
