"""Takes the tables of the other studies, and finished runs of FSI3, into the schema of the report."""

import csv
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cosim import statistics
from cosim.scene import ROOT, SCENES, load

from .cases import QUANTITIES, TOLERANCE, references
from .measure import unit_of
from .store import Row
from .values import SIMULATED


SAMPLES = 240
"""Points of a series in results.json."""

SHOWN_PERIODS = 2

CITED = (
    ("FLUSI", "325 x 72", 325, 34.0, {"tip_uy.amplitude": 42.5e-3, "tip_uy.frequency_hz": 6.5}),
    ("FLUSI", "650 x 144", 650, 259.0, {"tip_uy.amplitude": 44.6e-3, "tip_uy.frequency_hz": 5.9}),
    ("deal.II, monolithic", "as cited", None, 1280.0, {}),
    ("nutils", "as cited", None, 5300.0, {}),
)
"""Other solvers of FSI3, not measured here: wall time a simulated second, s."""


def rows_of(path: Path) -> list[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def number(text: str) -> float | None:
    return float(text) if text else None


def rod() -> Iterator[Row]:
    """docs/rod: error over n, error over the step and run time, cost of an iteration, stiff cells, situations."""
    folder, command = ROOT / "docs" / "rod", "make rod-study"
    for row in rows_of(folder / "order_in_n.csv"):
        if row["plane"] == "xz":
            setting = f"g = {row['gravity']}, n = {row['n']}"
            yield Row(
                "rod-elastica",
                row["calibration"],
                setting,
                "tip",
                discretisation=float(row["error"]),
                size=float(row["n"]),
                command=command,
                source="docs/rod/order_in_n.csv",
            )
    for row in rows_of(folder / "order_in_dt.csv"):
        yield Row(
            f"rod-swing, {row['case']}",
            row["scheme"],
            f"dt = {float(row['dt']):g} s",
            "tip",
            discretisation=float(row["error"]),
            step=float(row["dt"]),
            wall_s=float(row["seconds"]),
            command=command,
            source="docs/rod/order_in_dt.csv",
        )
    for row in rows_of(folder / "runtime.csv"):
        for name in ("iteration_2d", "iteration_3d", "banded", "sparse", "dense"):
            if row[name]:
                yield Row(
                    "rod-cost",
                    name,
                    f"n = {row['n']}",
                    "time of one",
                    float(row[name]) * 1e6,
                    "µs",
                    size=float(row["n"]),
                    command=command,
                    source="docs/rod/runtime.csv",
                )
    for row in rows_of(folder / "extreme.csv"):
        setting = ", ".join(f"{name} = {float(row[name]):g}" for name in ("n", "k_e", "EI", "dt"))
        yield Row(
            "map rod",
            "TR-BDF2",
            setting,
            "outcome",
            size=float(row["n"]),
            step=float(row["dt"]),
            **ended(row["result"]),
            source="docs/rod/extreme.csv",
        )
    for row in rows_of(folder / "situations.csv"):
        yield Row(
            "map rod situations",
            row["scheme"],
            row["situation"],
            "outcome",
            **ended(row["result"]),
            source="docs/rod/situations.csv",
        )


def ended(result: str) -> dict[str, str]:
    """Outcome and reason: a gain of energy is what a rod must not have without saying so."""
    if result == "ok":
        return {}
    return {"outcome": "bad" if result.startswith("gain") else "error", "reason": result}


def fluid() -> Iterator[Row]:
    """docs/fluid: cylinders, and the map of stability."""
    for row in rows_of(ROOT / "docs" / "fluid" / "results.csv"):
        case, group = f"cylinder-{row['flow'].lower().replace('-', '')}", row["case"].partition("/")[0]
        published = references(case)
        setting = f"{row['nx']} x {row['ny']}, {row['case']}"
        shared = {
            "size": float(row["nx"]),
            "step": float(row["dt"]),
            "wall_s": number(row["wall_s"]),
            "source": "docs/fluid/results.csv",
            "command": f"make fluid-study ARGS=\"--only '{row['case']}'\"",
        }
        method = f"{group}: {row['mask']}, {row['scheme']}"
        if row["result"] != "ok":
            yield Row(case, method, setting, "all", outcome="error", reason=row["result"], **shared)
        for quantity in QUANTITIES[case]:
            value = number(row[quantity])
            if value is not None and row["result"] == "ok":
                expected, scale = published[quantity]
                yield Row(
                    case,
                    method,
                    setting,
                    quantity,
                    value,
                    unit_of(quantity),
                    expected,
                    (value - expected) / scale,
                    **shared,
                )
    yield from fluid_map((ROOT / "docs" / "fluid" / "stability.md").read_text(encoding="utf-8"))


def fluid_map(text: str) -> Iterator[Row]:
    """The cells of docs/fluid/stability.md; its errors are letters that are explained below the tables."""
    reasons = dict(re.findall(r"^([A-Z]) \(first case\): (.*)$", text, re.M))
    method, header = "", []
    for line in text.splitlines():
        if line.startswith("## "):
            method, header = line[3:], []
        if not line.startswith("| "):
            continue
        cells = [cell.strip() for cell in line.strip("| ").split("|")]
        if not header:
            header = cells
            continue
        fixed = 2 if header[0] == "Re" else 1
        where = ", ".join(
            f"{name} {cell}" if name != "scene" else cell for name, cell in zip(header[:fixed], cells[:fixed])
        )
        for name, cell in zip(header[fixed:], cells[fixed:]):
            row = Row(
                "map fluid", method, f"{where}, {name}", "largest speed", source="docs/fluid/stability.md", unit="m/s"
            )
            letter = re.match(r"([A-Z]) at", cell)
            if letter:
                row.outcome, row.reason = "error", f"{cell}: {reasons.get(letter[1], '')}"
            elif cell.startswith("**wild**"):
                row.outcome, row.reason, row.value = (
                    "bad",
                    "wild: ten times the inflow or more",
                    float(cell.split()[-1]),
                )
            else:
                row.value = float(cell)
            yield row


def coupling() -> Iterator[Row]:
    """docs/fsi3/stability.csv."""
    for row in rows_of(ROOT / "docs" / "fsi3" / "stability.csv"):
        ratio, c_eta, step, end = (float(row[name]) for name in ("ratio", "c_eta", "step", "end"))
        setting = f"density ratio {ratio:g}, C_eta {c_eta:g}, H {step:g}, to {end:g} s"
        reason = (
            row["message"]
            if row["outcome"] == "error"
            else f"noise of the lift {float(row['noise']):.2f}"
            if row["outcome"] == "bad"
            else ""
        )
        yield Row(
            "map coupling",
            row["scheme"],
            setting,
            "noise of the lift",
            number(row["noise"]),
            step=float(row["step"]),
            wall_s=number(row["wall_s"]),
            outcome=row["outcome"],
            reason=reason,
            source="docs/fsi3/stability.csv",
            command=f"make coupling-study ARGS=\"--only '{row['cell']}'\"",
        )


def speed() -> Iterator[Row]:
    """The phases of a step in docs/fluid-speed.md."""
    text = (ROOT / "docs" / "fluid-speed.md").read_text(encoding="utf-8")
    part = text.split("Where the time of a step goes", 1)[1].split("A step on one", 1)[0]
    for phase, micro in re.findall(r"^\| ([^|]+) \| (\d+) \|", part, re.M):
        yield Row(
            "phases of a fluid step",
            "FSI3, the bar swinging",
            "650 x 144",
            phase,
            float(micro),
            "µs",
            source="docs/fluid-speed.md",
            command="make bench-fluid",
        )
    for scene, grid, micro in re.findall(r"^\| ([\w-]+) \| (\d+x\d+) \| \d+ \| (\d+) \|", text, re.M):
        nx, ny = map(int, grid.split("x"))
        yield Row(
            "cost of a fluid step",
            scene,
            f"{nx} x {ny}",
            "step",
            float(micro),
            "µs",
            size=nx * ny,
            source="docs/fluid-speed.md",
            command="make bench-fluid",
        )


def cited() -> Iterator[Row]:
    published = references("fsi3")
    for method, setting, size, wall, values in CITED:
        for quantity, value in (values or {"wall time": None}).items():
            expected, scale = published.get(quantity, (None, None))
            error = (value - expected) / scale if expected is not None and value is not None else None
            yield Row(
                "fsi3",
                method,
                setting,
                quantity,
                value,
                unit_of(quantity) if value else "",
                expected,
                error,
                size=size,
                wall_s=SIMULATED * wall,
                source="cited",
                reason=f"{wall:g} s a simulated second, on another machine",
            )


def changes_between(shipped: dict, own: dict, prefix: str = "") -> list[str]:
    """What `fsi.py run --set` has to be given to make one scene of the other; a part with other keys is named as a
    whole."""
    found = []
    for key in [*own, *(key for key in shipped if key not in own)]:
        before, after = shipped.get(key), own.get(key)
        both = isinstance(before, dict) and isinstance(after, dict)
        if both and (set(after) <= set(before) or set(before) <= set(after)):
            found += changes_between(before, after, f"{prefix}{key}.")
        elif before != after:
            found.append(f"{prefix}{key}={json.dumps(after, separators=(',', ':'))}")
    return found


def fsi3(folder: Path) -> tuple[list[Row], dict]:
    """Rows and series of a finished run of an FSI3 scene."""
    summary, scene = (
        json.loads((folder / name).read_text(encoding="utf-8")) for name in ("summary.json", "scene.json")
    )
    nx, ny = scene["fluid"]["box"]["cells"]
    base = SCENES / f"fsi3-{nx}x{ny}.json"
    shipped = load(base) if base.is_file() else scene
    named = ("$schema", "name", "description")
    changes = changes_between(*({k: v for k, v in of.items() if k not in named} for of in (shipped, scene)))
    setting = f"{nx} x {ny}" + "".join(f", {change}" for change in changes)
    sets = " ".join(f"--set '{change}'" for change in changes)
    rows = []
    published = references("fsi3")
    for quantity in QUANTITIES["fsi3"]:
        name, what = quantity.split(".")
        value = summary["quantities"][name][what]
        expected, scale = published[quantity]
        rows.append(
            Row(
                "fsi3",
                "momentum load" if not changes else "one change",
                setting,
                quantity,
                value,
                unit_of(quantity),
                expected,
                (value - expected) / scale,
                size=nx,
                step=scene["time"]["communication_step"],
                wall_s=summary["wall_s"],
                repeats=1,
                command=f"python scripts/fsi.py run scenes/fsi3-{nx}x{ny}.json {sets}".strip(),
                tolerance=TOLERANCE["fsi3"],
                source="run of scripts/fsi.py",
            )
        )
    for phase, seconds in summary["phases_s"].items():
        rows.append(
            Row(
                "phases fsi3",
                "momentum load",
                setting,
                phase,
                seconds / summary["wall_s"],
                "share of wall time",
                size=nx,
                source="run of scripts/fsi.py",
            )
        )
    return rows, {} if changes else {setting: series(folder)}


def series(folder: Path) -> dict:
    """The last whole periods of a run from an upward crossing of uy on, by the fundamental frequency."""
    table = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
    time, uy = table["time"], table["tip_uy"]
    window = statistics.find_window(time, uy)
    period = (window.end - window.begin) / window.periods
    at = np.linspace(window.end - SHOWN_PERIODS * period, window.end, SAMPLES)
    width = statistics.force_filter_width(window)
    found = {"phase": ((at - at[0]) / period).tolist(), "period_s": period}
    for name in ("tip_ux", "tip_uy", "drag", "lift"):
        values = statistics.box_filter(time, table[name], width) if name in ("drag", "lift") else table[name]
        found[name] = np.interp(at, time, values).tolist()
    return found


def record(folder: Path) -> tuple[str, dict]:
    """Machine and versions of a finished run, and their key."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    about = summary["machine"] | {"packages": summary["versions"], "git": summary["git"]}
    return f"runs, {summary['git']['revision'][:9]}" if summary["git"] else "runs, no git", about


def everything(data: dict, folders: list[Path]) -> None:
    """Replace what was imported before; runs stay where no folder has them anew, and do not replace what was
    measured."""
    kept = [row for row in data["rows"] if row.source in ("measured", "run of scripts/fsi.py")]
    timed = {(row.case, row.method, row.setting) for row in kept if row.source == "measured"}
    for folder in folders:
        found, lines = fsi3(folder)
        key, about = record(folder)
        data["machine"][key] = about
        for row in found:
            row.machine = key
        data["series"] |= lines
        keys = {(row.case, row.method, row.setting) for row in found}
        found = [row for row in found if (row.case, row.method, row.setting) not in timed]
        kept = [row for row in kept if (row.case, row.method, row.setting) not in keys - timed] + found
    data["rows"] = kept + [row for part in (rod, fluid, coupling, speed, cited) for row in part()]
