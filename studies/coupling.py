"""The map of the coupling's stability: FSI3 with rods of other densities, over C_eta, H and scheme, and docs/coupling of it.

    python scripts/studies/coupling.py                    run what is missing, then write docs/fsi3/stability.md
    python scripts/studies/coupling.py --list             the cells, what is known of them and what the others will cost
    python scripts/studies/coupling.py --only 'default/*' run only those

Every cell is FSI3 on 325 x 72 points whose start-up takes 0.2 s; the results are collected in results/coupling-study/results.csv. A cell is known there by its scene and the libraries, and is run
again only when one of them has changed.
"""

import csv
import hashlib
import json
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated

import numpy as np
import typer



from nervure import coupling, master
from nervure.pack import package
from nervure.files import write_csv, write_whole
from nervure.recorder import Recorder
from nervure.report import interface
from nervure.resources import ROOT
from nervure.scene import SceneError, load, override
from nervure.unit import Unit

RESULTS = ROOT / "results" / "coupling-study"
DOCS = ROOT / "docs" / "fsi3"

RATIOS = (0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0, 1000.0)
"""Density of the rod over that of the fluid."""

RAMP = 0.2
"""Start-up of the inflow, s; 2 s in FSI3."""

END, END_OTHER, END_ITERATED, END_LONG = 1.5, 1.0, 0.6, 3.0
"""End of the runs, s, with the default explicit scheme, other explicit ones, iterated ones, and of one at full amplitude: an
iteration that does not hold fails at once, an explicit scheme may take its time."""

MOST_NOISE = 0.25
"""A run whose lift changes its slope by more than this part of its own spread from step to step is bad. The mask's way
through the grid alone makes 0.16 on this grid when the tip swings by 40 mm, from 5 to 10 s as from 25 to 30 s."""

SCHEMES = {
    "default": {},
    "momentum": {"load": "momentum", "scheme": "explicit"},
    "momentum, parallel": {"load": "momentum", "scheme": "parallel_explicit"},
    "pressure jump": {"load": "pressure_jump", "scheme": "explicit"},
    "pressure jump, parallel": {"load": "pressure_jump", "scheme": "parallel_explicit"},
    "IQN-ILS": {"load": "pressure_jump", "scheme": {"iterated": {"acceleration": "iqn_ils"}}},
    "Aitken": {"load": "pressure_jump", "scheme": {"iterated": {"acceleration": "aitken"}}},
}

COST = 1.2e-3
"""Wall time for a step of fluid and rod, s, and iterations in a step: for the estimate in the list only."""
ITERATIONS = 6


@dataclass(frozen=True)
class Cell:
    """One run."""

    scheme: str
    ratio: float
    c_eta: float
    step: float
    max_step: float
    end: float

    @property
    def name(self) -> str:
        long = "-long" if self.end == END_LONG else ""
        return f"{self.scheme}/{self.ratio:g}-{self.c_eta:g}-{self.step:g}{long}".replace(", ", "-").replace(" ", "-")

    def scene(self) -> dict:
        scene = load(ROOT / "scenes" / "fsi3-325x72.json")
        for key, value in {
            "name": self.name.replace("/", "-"),
            "time.end": self.end,
            "time.communication_step": self.step,
            "fluid.time_stepping.max_step": self.max_step,
            "fluid.inflow.mean_velocity.cosine_ramp.duration": RAMP,
            "fluid.mask.log_linear.c_eta": self.c_eta,
            "rod.material.plane_strain.density": self.ratio * scene["fluid"]["density"],
            "coupling": SCHEMES[self.scheme],
        }.items():
            override(scene, f"{key}={json.dumps(value)}")
        return scene

    @property
    def key(self) -> str:
        """What decides whether a known result still holds."""
        libraries = b"".join(package.library(kind).read_bytes() for kind in package.KINDS)
        return hashlib.sha256(package.scene_text(self.scene()).encode() + libraries).hexdigest()[:16]

    @property
    def cost(self) -> float:
        """Estimated wall time, s."""
        iterated = self.scheme in ("IQN-ILS", "Aitken") or self.scheme == "default" and self.end == END_ITERATED
        return self.end / min(self.step, self.max_step) * COST * (ITERATIONS if iterated else 1)


def cells() -> Iterator[Cell]:
    """All of them, scheme by scheme."""

    def cell(scheme: str, ratio: float, c_eta: float, step: float = 4e-4, end: float = END, max_step: float | None = None):
        return Cell(scheme, ratio, c_eta, step, max_step or min(step, 4e-4), end)

    c_etas = (1e-3, 1e-4, 1e-5)
    heavy, light = [r for r in RATIOS if r >= 1], [r for r in RATIOS if r < 1]
    for ratio in heavy:
        for c_eta in c_etas:
            yield cell("default", ratio, c_eta)
    for ratio in light:
        for c_eta in c_etas:
            yield cell("default", ratio, c_eta, end=END_ITERATED)
    for c_eta in c_etas:
        yield cell("default", 1.0, c_eta, 2e-4)
    for ratio in RATIOS:
        for c_eta in c_etas:
            if ratio >= 1:
                yield cell("momentum, parallel", ratio, c_eta, end=END_OTHER)
            yield cell("pressure jump", ratio, c_eta, end=END_OTHER)
        yield cell("pressure jump, parallel", ratio, 1e-4, end=END_OTHER)
    for ratio in (1.0, 1000.0):
        yield cell("momentum", ratio, 1e-4, 1.6e-3, END_OTHER, 4e-4)
    for ratio in (0.1, 1.0, 1000.0):
        yield cell("default", ratio, 1e-4, 1.6e-3, END_ITERATED, 4e-4)
    for ratio in (0.1, 1.0, 10.0, 1000.0):
        yield cell("Aitken", ratio, 1e-4, end=END_ITERATED)
    for ratio in (1.0, 1000.0):
        yield cell("IQN-ILS", ratio, 1e-4, end=END_ITERATED)
    yield cell("default", 0.1, 1e-4, 2e-4, END_ITERATED)
    yield cell("default", 1.0, 1e-4, end=END_LONG)


@dataclass
class Row:
    """A cell and what came out of it, as it stands in results.csv."""

    cell: str
    key: str
    scheme: str
    ratio: float
    c_eta: float
    step: float
    end: float
    outcome: str
    """`ok`, `error` (with the message) or `bad`: it went on to the end, and what came out is noise."""
    message: str = ""
    chosen: str = ""
    reached: float | None = None
    """Simulated time, s."""
    iterations: float | None = None
    noise: float | None = None
    """Second difference of the lift by its spread, over the last third."""
    amplitude: float | None = None
    """Of the tip's uy over the last third, m."""
    imbalance: float | None = None
    """Work of the rod less that of the fluid by the work exchanged."""
    wall_s: float | None = None


def known() -> dict[str, dict[str, str]]:
    """Rows of results.csv by cell."""
    if not (RESULTS / "results.csv").is_file():
        return {}
    with open(RESULTS / "results.csv", encoding="utf-8", newline="") as file:
        return {row["cell"]: row for row in csv.DictReader(file)}


def run(cell: Cell) -> Row:
    """Run a cell."""
    scene = cell.scene()
    row = Row(cell.name, cell.key, cell.scheme, cell.ratio, cell.c_eta, cell.step, cell.end, "ok")
    with ExitStack() as stack:
        try:
            units = {}
            for kind in package.KINDS:
                units[kind] = Unit(package.pack(kind, scene, RESULTS), kind, cell.end)
                stack.callback(units[kind].close)
                (RESULTS / f"{scene['name']}-{kind}.fmu").unlink()
        except SceneError as error:
            row.outcome, row.message = "error", str(error)
            return row
        scheme = coupling.couple(units, scene["coupling"])
        clock = master.Clock(cell.end, cell.step)
        recorder = Recorder(units, clock.steps)
        outcome = master.run(scheme, clock, recorder)
    row.chosen = f"{scheme.choice['load']}, {scheme.choice['scheme']}"
    row.reached, row.wall_s = outcome.simulated, round(outcome.wall, 1)
    if outcome.error is not None:
        row.outcome, row.message = "error", outcome.error
        return row
    row.iterations = float(recorder.column("iterations")[1:].mean())
    row.imbalance = interface(recorder)["imbalance"]
    last = slice(-(recorder.rows // 3), None)
    lift, uy = recorder.column("lift")[last], recorder.column("tip_uy")[last]
    row.noise, row.amplitude = float(np.std(np.diff(lift, 2)) / np.std(lift)), float(np.ptp(uy) / 2)
    if not row.noise < MOST_NOISE:
        row.outcome = "bad"
    return row


def main(
    only: Annotated[str, typer.Option(help="Run only the cells whose names match, such as 'default/*'.")] = "*",
    listing: Annotated[bool, typer.Option("--list", help="List the cells and run nothing.")] = False,
) -> None:
    """Run what is missing and write docs/fsi3/stability.md and stability.csv."""
    everything = list(cells())
    rows = known()
    if listing:
        for cell in everything:
            there = cell.name in rows and rows[cell.name]["key"] == cell.key
            typer.echo(f"{cell.name:48} {rows[cell.name]['outcome'] if there else f'{cell.cost:.0f} s'}")
        return
    RESULTS.mkdir(parents=True, exist_ok=True)
    for cell in everything:
        if not fnmatch(cell.name, only) or cell.name in rows and rows[cell.name]["key"] == cell.key:
            continue
        row = run(cell)
        rows = known()
        rows[cell.name] = {name: "" if value is None else value for name, value in asdict(row).items()}
        write_csv(RESULTS / "results.csv", list(rows.values()))
        typer.echo(f"{cell.name:48} {row.outcome} {row.message[:90]} ({row.wall_s} s)")
    write_docs([rows[cell.name] for cell in everything if cell.name in rows])


def write_docs(rows: list[dict]) -> None:
    """docs/fsi3/stability.csv and stability.md."""
    DOCS.mkdir(parents=True, exist_ok=True)
    kept = [{name: value for name, value in row.items() if name != "key"} for row in rows]
    write_csv(DOCS / "stability.csv", kept)
    for path, text in pages().items():
        write_whole(path, lambda new: new.write_text(text, encoding="utf-8"))


def pages() -> dict[Path, str]:
    """docs/fsi3/stability.md, of stability.csv."""
    with open(DOCS / "stability.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    text = [
        "# Which coupling holds where",
        "",
        "Made by `make coupling-study` ([coupling.md](../coupling.md) says what the schemes are): FSI3 on 325 x 72 points, "
        f"start-up {RAMP:g} s, rods of other densities. `ok`: it went to the time given; with the mean number of "
        "iterations where there are any. A time: it ended there with an error. `bad`: it went to the end, and the lift changes its "
        f"slope from step to step by more than {MOST_NOISE:g} of its spread. All numbers and messages are in "
        "[stability.csv](stability.csv).",
    ]
    groups = {}
    for row in rows:
        groups.setdefault((row["scheme"], row["step"], row["end"]), []).append(row)
    for (scheme, step, end), members in groups.items():
        ends = sorted({float(row["end"]) for row in members})
        c_etas = sorted({float(row["c_eta"]) for row in members}, reverse=True)
        text += ["", f"**{scheme}**, H = {float(step):g} s, to t = {ends[-1]:g} s", ""]
        text += ["| density ratio | " + " | ".join(f"C_eta = {c:g} s" for c in c_etas) + " |", "|---|" + "---|" * len(c_etas)]
        for ratio in sorted({float(row["ratio"]) for row in members}):
            at = {float(row["c_eta"]): row for row in members if float(row["ratio"]) == ratio}
            text.append(f"| {ratio:g} | " + " | ".join(shown(at.get(c)) for c in c_etas) + " |")
    counts = {what: sum(row["outcome"] == what for row in rows) for what in ("ok", "error", "bad")}
    text += ["", f"{len(rows)} of {len(list(cells()))} cells were run: " + ", ".join(f"{n} {what}" for what, n in counts.items()) + "."]
    return {DOCS / "stability.md": "\n".join(text) + "\n"}


def shown(row: dict | None) -> str:
    """One cell of the tables."""
    if row is None:
        return ""
    if row["outcome"] == "error":
        return f"error, t = {float(row['reached']):.3g} s" if row["reached"] != "" else "refused"
    iterations = float(row["iterations"])
    return row["outcome"] + (f", {iterations:.1f}" if iterations > 1 else "")


if __name__ == "__main__":
    typer.run(main)
