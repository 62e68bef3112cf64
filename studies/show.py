"""Figures, Markdown, and the tables that studies make: `<!--table:KEY-->` … `<!--end-->` in a document."""

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from nervure.files import write_whole
from nervure.resources import ROOT

DOCS = ROOT / "docs"

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
"""Colours of Okabe & Ito, distinct without colour vision and in print."""
MARKERS = "osv^Dp*hX"

plt.rcParams["axes.prop_cycle"] = matplotlib.rcsetup.cycler(color=COLOURS)

SPECS: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_name("tables.toml").read_text(encoding="utf-8"))
"""Columns of the tables, by key."""
SOURCES = ("of", "table", "like", "only")  # Keys of a table that say where its rows and columns come from

TABLE = re.compile(r"<!--table:(\S+)-->\n(.*?)<!--end-->", re.DOTALL)


# Text


def markdown(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Return the lines of a table."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]


FIELD = re.compile(r"\{([^:{}]*):([^{}]*)\}")
OPTIONAL = re.compile(r"<([^<>]*)>")


def form(text: str, values: Mapping[str, Any]) -> str:
    """Return `text` with numbers of `values` in place of `{name:format}`; `%` gives per cent, `name[mm]` millimetres. A
    part in `<>` with a missing number is left out; without `<>` the whole text is."""

    def one(match: re.Match[str]) -> str:
        name, _, unit = match[1].partition("[")
        value = values[name]
        if value is None:
            raise KeyError(name)
        if match[2].endswith("%"):
            spec = match[2][:-1]
            return format(100 * value, spec if spec.endswith("g") else spec + "f") + " %"
        return format(value * 1e3 if unit == "mm]" else value, match[2])

    def filled(text: str, inner: Callable[[re.Match[str]], str] | None = None) -> str:
        try:
            return FIELD.sub(one, OPTIONAL.sub(inner, text) if inner else text)
        except KeyError:
            return ""

    return filled(text, lambda match: filled(match[1]))


def table(key: str, rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a table of tables.toml."""
    spec = SPECS[key]
    forms = {name: text for name, text in SPECS[spec.get("like", key)].items() if name not in SOURCES}
    return markdown(list(forms), [[form(text, row) for text in forms.values()] for row in rows])


def cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value).replace("|", "\\|")


def listing(records: Sequence[Any]) -> list[str]:
    """Return the lines of a table with every value of `store.Record`s, and of their own tables and timed rows."""
    names = dict.fromkeys(name for record in records for name in record.values)
    rows = [
        [r["label"], *(cell(r.values.get(name)) for name in names), cell(r.get("cpu_s")), r.error or ""]
        for r in records
    ]
    text = markdown(["case", *names, "CPU, s", "error"], rows)
    for record in records:
        timed = {
            key: part for key, part in record.times.items() if isinstance(part, list) and isinstance(part[0], dict)
        }
        for name, part in (record.tables | timed).items():
            columns = dict.fromkeys(column for row in part for column in row)
            text += ["", f"**{record['label']}**, {name}", ""]
            text += markdown(list(columns), [[cell(row.get(column)) for column in columns] for row in part])
    return text


def matrix(corner: str, rows: Mapping[str, Any], columns: Mapping[str, Any], cell: Callable[..., str]) -> list[str]:
    """Return the lines of a table of `cell(row, column)`; rows and columns are given by their headings."""
    body = [[name, *(cell(row, column) for column in columns.values())] for name, row in rows.items()]
    return markdown([corner, *columns], body)


def documents() -> list[Path]:
    """Return the documents that may have tables."""
    return [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


# Figures


def panel(rows: int = 1, columns: int = 1, size: tuple[float, float] = (6.4, 4.4), **how: Any) -> tuple[Figure, Any]:
    """Return a figure and its axes `[rows, columns]`."""
    figure, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", squeeze=False, **how)
    for axis in axes.flat:
        axis.grid(True, which="major", linewidth=0.4, alpha=0.6)
    return figure, axes


def save(figure: Figure, name: str, dpi: int = 110) -> None:
    """Write docs/NAME.png."""
    path = DOCS / f"{name}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, lambda new: figure.savefig(new, dpi=dpi, metadata={"Software": None}, format="png"))
    plt.close(figure)


def curves(name: str, labels: tuple[str, str], lines: Iterable[dict[str, Any]], **legend: Any) -> None:
    """Draw docs/NAME.png of lines: each has `x`, `y`, and options of `plot`."""
    figure, axes = panel()
    axis = axes[0, 0]
    for line in lines:
        axis.plot(line.pop("x"), line.pop("y"), **({"linewidth": 1.2, "markersize": 5, "fillstyle": "none"} | line))
    axis.set(xlabel=labels[0], ylabel=labels[1], ylim=legend.pop("ylim", None))
    axis.legend(fontsize=8, **legend)
    save(figure, name, 130)


def few_labels(axis: Any) -> None:
    """Label a logarithmic axis at 1, 2 and 5 times powers of ten if it has few decades."""
    low, high = axis.get_view_interval()
    decades = np.log10(high / low)
    subs: Any = (1.0,) if decades > 2 else (1.0, 2.0, 5.0) if decades > 0.5 else np.arange(1.0, 10.0, 0.5)
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_minor_formatter(NullFormatter())
    if decades <= 2:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 1e3:g} k" if value >= 1e4 else f"{value:g}"))


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the slope of the straight line through log y over log x."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def grouped(rows: Iterable[Any], *keys: str) -> dict[Any, list[Any]]:
    """Return rows grouped by their value of one key, or by their values of several."""
    groups: dict[Any, list[Any]] = {}
    for row in rows:
        groups.setdefault(row[keys[0]] if len(keys) == 1 else tuple(row[key] for key in keys), []).append(row)
    return groups
