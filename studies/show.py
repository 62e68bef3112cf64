"""Markdown tables and pages, figures, and the blocks of documents that are generated.

Everything between `<!--table:KEY-->` and `<!--end-->` in a document is a table that a study makes.
"""

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, StrMethodFormatter

from nervure.files import write_whole
from nervure.resources import ROOT

DOCS = ROOT / "docs"

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
"""Okabe & Ito's, told apart without colour vision and in print."""
MARKERS = "osv^Dp*hX"

plt.rcParams["axes.prop_cycle"] = matplotlib.rcsetup.cycler(color=COLOURS)

LABELS = {
    "cd_mean": "$c_D$",
    "cl_mean": "$c_L$",
    "dp_mean": "$\\Delta p$",
    "cd_max": "$c_D$ max",
    "cl_peak_to_peak": "$c_L$ peak to peak",
    "st": "St",
    "tip_ux": "$u_x$",
    "tip_uy": "$u_y$",
    "frequency_hz": "frequency",
}

SPECS: dict[str, dict[str, str]] = tomllib.loads(Path(__file__).with_name("tables.toml").read_text(encoding="utf-8"))
"""Columns of the tables, by key."""

TABLE = re.compile(r"<!--table:(\S+)-->\n(.*?)<!--end-->", re.DOTALL)


def label(quantity: str) -> str:
    return " ".join(LABELS.get(part, part) for part in quantity.split("."))


# Text


def markdown(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Lines of a table."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]


FIELD = re.compile(r"\{([^:{}]*):([^{}]*)\}")
OPTIONAL = re.compile(r"<([^<>]*)>")


def form(text: str, values: Mapping[str, Any]) -> str:
    """`text` with the numbers of `values` in the place of `{name:format}`: a percentage where the format ends so, mm
    for `name[mm]`. Where
    one is missing the part of the text in `<>` around it is left out, or else all of it."""

    def one(match: re.Match[str]) -> str:
        name, _, unit = match[1].partition("[")
        value = values[name]
        if value is None:
            raise KeyError(name)
        if match[2].endswith("%"):
            spec = match[2][:-1]
            return format(100 * value, spec if spec.endswith("g") else spec + "f") + " %"
        return format(value * 1e3 if unit == "mm]" else value, match[2])

    def part(match: re.Match[str]) -> str:
        try:
            return FIELD.sub(one, match[1])
        except KeyError:
            return ""

    try:
        return FIELD.sub(one, OPTIONAL.sub(part, text))
    except KeyError:
        return ""


def columns(key: str) -> dict[str, str]:
    """Headings and forms of a table of tables.toml."""
    found: dict[str, str] = SPECS[key]
    return columns(found["like"]) if "like" in found else {name: text for name, text in found.items() if name != "of"}


def table(key: str, rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Lines of a table of tables.toml."""
    forms = columns(key)
    return markdown(list(forms), [[form(text, row) for text in forms.values()] for row in rows])


def percent(value: float | None, form: str = "+.2f") -> str:
    return "" if value is None else f"{100 * value:{form}} %"


def number(value: float | None, form: str = ".4g") -> str:
    return "" if value is None else format(value, form)


def documents() -> list[Path]:
    """Those that may have tables in them."""
    return [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


# Figures


def panel(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (6.4, 4.4), **how: Any
) -> tuple[Figure, np.ndarray[Any, Any]]:
    """A figure and its axes `[rows, columns]`."""
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


def curves(
    name: str,
    labels: tuple[str, str],
    lines: Iterable[dict[str, Any]],
    log: bool = True,
    ticks: Sequence[float] = (),
    **legend: Any,
) -> None:
    """Figure docs/NAME.png of lines, each `x`, `y` and what else `plot` takes; `ticks` are those of a logarithmic x."""
    figure, axes = panel()
    axis = axes[0, 0]
    limits = legend.pop("limits", {})
    for line in lines:
        axis.plot(line.pop("x"), line.pop("y"), **({"linewidth": 1.2, "markersize": 5, "fillstyle": "none"} | line))
    axis.set(xlabel=labels[0], ylabel=labels[1], **({"xscale": "log", "yscale": "log"} if log else {}), **limits)
    if ticks:
        axis.xaxis.set_major_locator(FixedLocator(list(ticks)))
        axis.xaxis.set_major_formatter(StrMethodFormatter("{x:.0f}"))
        axis.xaxis.set_minor_formatter(NullFormatter())
    axis.legend(fontsize=8, **legend)
    save(figure, name, 130)


def few_labels(axis: Any) -> None:
    """On a logarithmic axis: labels at 1, 2 and 5 times powers of ten where there are few decades, and no others."""
    low, high = axis.get_view_interval()
    decades = np.log10(high / low)
    subs: Any = (1.0,) if decades > 2 else (1.0, 2.0, 5.0) if decades > 0.5 else np.arange(1.0, 10.0, 0.5)
    axis.set_major_locator(LogLocator(subs=subs))
    axis.set_minor_formatter(NullFormatter())
    if decades <= 2:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 1e3:g} k" if value >= 1e4 else f"{value:g}"))


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Slope of the straight line through log y over log x."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def grouped(rows: Iterable[dict[str, Any]], *keys: str) -> dict[tuple[Any, ...], list[dict[str, Any]]]:
    """Rows by the values that they have in `keys`."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups
