"""Files that appear only when they are complete, and numbers that JSON has."""

import csv
import json
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO

from nervure.errors import InputError

LOCK = ".running"  # File in a folder that a run writes into


def read_json(path: Path) -> Any:
    """Return what a file holds; raise `OSError` where it cannot be read, and `ValueError` where it is not JSON."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise ValueError("lists and objects are nested too deep") from None


def write_together(folder: Path, writers: dict[str, Callable[[Path], object]]) -> None:
    """Write files into `folder` under other names, then rename all of them; if one writer fails, no file changes."""
    unfinished = {name: folder / f"unfinished-{name}" for name in writers}
    try:
        for name, writer in writers.items():
            writer(unfinished[name])
    except BaseException:
        for path in unfinished.values():
            path.unlink(missing_ok=True)
        raise
    for name, path in unfinished.items():
        path.replace(folder / name)


def write_whole(path: Path, writer: Callable[[Path], object]) -> None:
    """Write a file under another name, then rename it to `path`."""
    write_together(path.parent, {path.name: writer})


def unwritable(folder: Path, error: OSError) -> InputError:
    """Return what to say where `error` stops the writing of results into `folder`, whichever file it is about."""
    if error.filename is not None:
        path, place = Path(os.fsdecode(error.filename)).resolve(), folder.resolve()
        if path not in place.parents and not path.is_relative_to(place):
            return InputError(f"cannot use {error.filename}: {error.strerror}")
    return InputError(f"cannot write into the result folder {folder}: {error.strerror or error}")


@contextmanager
def undone_on_error(folder: Path) -> Iterator[Callable[[], None]]:
    """Remove the new files in `folder`, and the folders that did not exist, where an error leaves the block before the
    function that this yields is called."""
    before = set(folder.iterdir()) if folder.is_dir() else set()
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    kept = False

    def keep() -> None:
        nonlocal kept
        kept = True

    try:
        yield keep
    except BaseException:
        if not kept:
            for path in set(folder.iterdir()) - before if folder.is_dir() else ():
                path.unlink() if path.is_file() else None
            for path in missing:
                with suppress(OSError):  # Another program may use it
                    path.rmdir()
        raise


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Make `folder` and keep other processes out of it; raise `InputError` where one of them is in it. The system
    releases it at the end of the process, whatever ends it. Folders that are still empty then are removed."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = _locked(folder / LOCK)
    except OSError as error:
        raise unwritable(folder, error) from error
    if lock is None:
        raise InputError(f"another run is writing into {folder}: wait for its end, or give another --output")
    try:
        yield
    finally:
        if sys.platform == "win32":
            lock.close()  # before, nothing removes it
        with suppress(OSError):
            (folder / LOCK).unlink()
        lock.close()
        for path in missing:
            with suppress(OSError):  # It has content
                path.rmdir()


def _locked(path: Path) -> TextIO | None:
    """Open and lock a file; return None where another process has locked it. A file system without locks keeps nobody
    out."""
    while True:
        file = open(path, "a", encoding="utf-8")  # noqa: SIM115
        try:
            if sys.platform == "win32":
                import msvcrt

                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            else:
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            file.close()
            return None
        except OSError:
            return file
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        file.close()  # Its owner has just removed it


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write a table; columns stand in the order of their first mention in the rows."""

    def writer(path: Path) -> None:
        with open(path, "w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
            table.writeheader()
            table.writerows(rows)

    write_whole(path, writer)


def json_numbers(value: Any) -> Any:
    """Return `value` with None for infinities and NaN, which JSON does not have; a failed run can leave them."""
    if isinstance(value, dict):
        return {key: json_numbers(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [json_numbers(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
