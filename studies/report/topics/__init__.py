"""One module for each topic of the documents.

What a topic has of these is taken:

- `rows()`: what the topic's study says, as `Row`s, from the tables that it left under docs/;
- `values(rows)`: names of numbers in prose, and the numbers;
- `tables(rows)`: names of tables, and functions that make their lines;
- `pages()`: the study's own pages by their path, made of its tables alone.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

from ..store import Row, Rows, Value
from . import coupling, fluid, fsi3, reliability, rod, running, speed, vein

TOPICS = (fsi3, rod, fluid, speed, coupling, vein, running, reliability)


def _of_each(part: str) -> Iterator[Callable]:
    return (getattr(topic, part) for topic in TOPICS if hasattr(topic, part))


def rows() -> Iterator[Row]:
    for part in _of_each("rows"):
        yield from part()


def values(rows: Rows) -> dict[str, Value]:
    return {key: value for part in _of_each("values") for key, value in part(rows)}


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {name: lines for part in _of_each("tables") for name, lines in part(rows).items()}


def pages() -> dict[Path, str]:
    return {path: text for part in _of_each("pages") for path, text in part().items()}
