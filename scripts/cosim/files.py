"""Files that appear only when they are complete."""

from collections.abc import Callable
from pathlib import Path


def write_together(folder: Path, writers: dict[str, Callable[[Path], object]]) -> None:
    """Let each of `writers` write a file beside its place in `folder`, then move them all there; where one fails none
    is moved."""
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
    """Let `writer` write a file beside `path`, then move it there."""
    write_together(path.parent, {path.name: writer})
