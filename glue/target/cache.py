"""Results shared by all runs, kept under the content hash of what went into them."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from glue.atomic import write_text_atomic
from glue.errors import InputError
from glue.solvers import repo_root, versions


def cache_root() -> Path:
    """``$PEEN_CACHE``, else ``peen`` in the user's cache folder."""
    wanted = os.environ.get("PEEN_CACHE")
    return (
        Path(wanted) if wanted else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "peen"
    )


def refuse_unwritable() -> None:
    """Raise InputError when nothing can be kept in the cache."""
    root = cache_root()
    try:
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root):
            pass
    except OSError as problem:
        raise _not_writable(root, problem) from None


def content_key(inputs: dict, sources: tuple[str, ...]) -> str:
    """Hash of ``inputs`` (JSON-able) and of the files of the checkout that match ``sources`` (globs)."""
    digest = hashlib.sha256(json.dumps(inputs, sort_keys=True).encode())
    root = repo_root()
    for path in sorted({p for pattern in sources for p in root.glob(pattern)}):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:20]


def cached_folder(kind: str, key: str, make: Callable[[Path], None]) -> tuple[Path, bool]:
    """Folder ``<cache>/<kind>/<key>``, made by ``make(empty folder)`` when missing; and whether it was there.

    The folder appears under its name only when ``make`` has returned, so one that exists is complete; what a
    failed ``make`` left stays beside it as ``<key>-failed`` for its log.  Of several processes that want the same at a
    time one makes it and the others wait.  Raises InputError when the cache is not writable.
    """
    final = cache_root() / kind / key
    if final.is_dir():
        return final, True
    try:
        final.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise _not_writable(final.parent, problem) from None
    with _one_at_a_time(final.with_name(f"{key}.lock")):
        return (final, True) if final.is_dir() else (_made(final, make), False)


def _made(final: Path, make: Callable[[Path], None]) -> Path:
    """``final``, made in a folder of another name and renamed."""
    key = final.name
    try:
        scratch = Path(tempfile.mkdtemp(prefix=f"{key}-", suffix=".part", dir=final.parent))
        scratch.chmod(0o755)  # a cache may be shared; mkdtemp's folders are their owner's alone
    except OSError as problem:
        raise _not_writable(final.parent, problem) from None
    try:
        make(scratch)
    except (KeyboardInterrupt, SystemExit):
        shutil.rmtree(scratch, ignore_errors=True)
        raise
    except Exception as problem:
        failed = final.with_name(f"{key}-failed")
        shutil.rmtree(failed, ignore_errors=True)
        scratch.rename(failed)
        if getattr(problem, "log", None):  # the error names the log: let it name the place where it now is
            problem.args = (str(problem).replace(str(scratch), str(failed)),)
        raise
    try:
        scratch.rename(final)
    except OSError:
        if not final.is_dir():  # else another process made the same meanwhile, where files cannot be locked
            raise
        shutil.rmtree(scratch, ignore_errors=True)
    return final


def _not_writable(folder: Path, problem: OSError) -> InputError:
    return InputError(f"the cache folder {folder} cannot be written ({problem}); set PEEN_CACHE")


@contextlib.contextmanager
def _one_at_a_time(lock: Path) -> Iterator[None]:
    """Only one process or thread is inside the block with this lock file; no lock where the file system has none."""
    handle = None
    try:
        while handle is None:
            handle = os.open(lock, os.O_CREAT | os.O_RDWR, 0o644)
            fcntl.flock(handle, fcntl.LOCK_EX)
            if not _is_open_at(handle, lock):  # whoever held it has removed it: another may hold a new one
                os.close(handle)
                handle = None
    except OSError:  # the block itself tells of a place that cannot be written
        pass
    try:
        yield
    finally:
        if handle is not None:
            lock.unlink(missing_ok=True)
            os.close(handle)


def _is_open_at(handle: int, path: Path) -> bool:
    try:
        there, here = path.stat(), os.fstat(handle)
    except FileNotFoundError:
        return False
    return (there.st_dev, there.st_ino) == (here.st_dev, here.st_ino)


def finished_key(driver: str, sources: tuple[str, ...]) -> str:
    """Hash of all that decides the tables of a FreeFEM run: its driver's text, the ``sources`` it includes, the solver."""
    return content_key({"driver": driver, "freefem": versions()["freefem"]["package"]}, sources)


def is_finished(folder: Path, key: str) -> bool:
    """Did a run of this key end well in ``folder``, and are its tables still there?"""
    try:
        lines = (folder / "finished").read_text().splitlines()
    except OSError:
        return False
    return lines[:1] == [key] and all((folder / name).is_file() for name in lines[1:])


def mark_finished(folder: Path, key: str) -> None:
    """Note that the run of this key ended well; call when its results have been read and checked."""
    names = sorted(p.name for p in folder.iterdir() if p.suffix in (".csv", ".edp"))
    write_text_atomic(folder / "finished", "\n".join([key, *names]) + "\n")
