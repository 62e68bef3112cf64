"""Files that appear only when they are complete, and numbers that JSON has."""

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any


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
