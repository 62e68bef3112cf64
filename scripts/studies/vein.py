"""The flapping vein's limits and convergence, and docs/vein of it; with the table of the sweep over its stiffness, which
`make vein-study` runs before.

    python scripts/studies/vein.py                 run what is missing, then write docs/vein/*.md, *.csv and *.png
    python scripts/studies/vein.py --list          the cases and what is known of them
    python scripts/studies/vein.py --only 'dt/*'   run only those

A case is known in results/vein-study/results.csv by its scene and the libraries, and is run again only when one of them has
changed. Its series is kept beside that table.
"""

import csv
import hashlib
import json
import sys
from contextlib import ExitStack
from dataclasses import dataclass, field
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

sys.path.insert(0, str(Path(__file__).parents[1]))

from studies import tables
from cosim import coupling, flapping, master, package, statistics
from cosim.recorder import Recorder
from cosim.files import write_whole
from cosim.report import evaluate
from cosim.scene import ROOT, load, override
from cosim.unit import Unit

RESULTS = ROOT / "results" / "vein-study"
DOCS = ROOT / "docs" / "vein"
SWEEP, STIFFNESS = ROOT / "results" / "vein-flexibility", "rod.material.section.bending_stiffness"

PITCHING, FORWARD, HOVER, SPACE, CYLINDER = (
    "vein-pitching-320x240",
    "vein-forward-384x192",
    "vein-hover-288x256",
    "vein-3d",
    "cylinder-oscillating-460x100",
)

END, PERIODS = 3.02, 1
"""End of the pitching runs, s, and the periods at their end that are averaged: the tip is settled in the third."""

STIFF = {"bending_stiffness": 1e5, "axial_stiffness": 1e8}
FORCE_WIDTH = 0.02
"""Box filter over the forces that are compared in the stiff limit, s: a fiftieth of the period."""

NOISE_WIDTH = 0.08
"""Width of the box filter, s, applied twice, whose remainder is called noise of the oscillating cylinder: a fiftieth of its
period, in which it passes one to six cells where it is fast."""


PARTS = {
    "as shipped": {},
    "without the sponge": {"fluid.sponge": None},
    "with walls": {"fluid.channel": {"y": [-0.95, 0.95]}},
    "with a zone": {
        "fluid.inflow": {"x": [-0.667, -0.567], "profile": "uniform", "mean_velocity": {"steady": 0.0}, "c_eta": 1e-4}
    },
    "with a cylinder, still": {"fluid.cylinders": [{"center": [-0.4, 0.6], "radius": 0.15}]},
    "with a cylinder, moving": {
        "fluid.cylinders": [
            {"center": [-0.4, 0.6], "radius": 0.15, "motion": {"x": {"sine": {"amplitude": 0.05, "frequency": 1.0}}}}
        ]
    },
}
"""The parts that the pitching vein has not, as the keys that would bring them in."""
ROUNDS, STEPS = 40, 10
"""Rounds over all of `PARTS`, and steps of the fluid in each of them: the least time of a round counts."""


@dataclass
class Case:
    """One run of a scene file with keys replaced."""

    name: str
    scene: str
    keys: dict = field(default_factory=dict)
    periods: int | None = None
    """How many periods at the end are averaged, if not all that are settled."""
    prescribed: bool = False
    """Whether the stations are those of a rigid rod that follows the scene's root, with no rod."""

    def built(self) -> dict:
        scene = load(ROOT / "scenes" / f"{self.scene}.json")
        for key, value in {"name": self.name.replace("/", "-"), **self.keys}.items():
            override(scene, f"{key}={json.dumps(value)}")
        return scene

    @property
    def key(self) -> str:
        libraries = b"".join(package.library(kind).read_bytes() for kind in package.KINDS)
        text = package.scene_text(self.built()) + str(self.prescribed)
        return hashlib.sha256(text.encode() + libraries).hexdigest()[:16]

    @property
    def series(self) -> Path:
        return RESULTS / f"{self.name.replace('/', '-')}.npz"


def on_grid(nx: int, ny: int, step: float) -> dict:
    return {"fluid.box.cells": [nx, ny], "time.communication_step": step, "fluid.time_stepping.max_step": step}


def cases() -> list[Case]:
    found = [Case(f"scene/{scene}", scene) for scene in (SPACE, FORWARD, HOVER, PITCHING)]
    grids = ((230, 50, 4e-3), (345, 75, 2.5e-3), (460, 100, 2e-3), (690, 150, 1.6e-3), (920, 200, 1e-3))
    found += [Case(f"cylinder/{nx}x{ny}", CYLINDER, {"time.end": 8.0} | on_grid(nx, ny, h)) for nx, ny, h in grids]
    stiff = {"time.end": 2.0, "rod.material.section": {"line_density": 0.024} | STIFF} | on_grid(320, 240, 2e-4)
    found += [Case("stiff/coupled", PITCHING, stiff), Case("stiff/prescribed", PITCHING, stiff, prescribed=True)]
    found += [
        Case(f"dt/{step:g}", PITCHING, {"time.end": END} | on_grid(320, 240, step), PERIODS) for step in (8e-4, 4e-4, 2e-4, 1e-4)
    ]
    found += [
        Case(f"grid/{nx}x{ny}", PITCHING, {"time.end": END} | on_grid(nx, ny, 4e-4 * 320 / nx), PERIODS)
        for nx, ny in ((240, 180), (320, 240), (480, 360), (640, 480))
    ]
    return found


def run(case: Case) -> dict:
    """Run a case, keep its series, and return its row."""
    scene = case.built()
    if case.prescribed:
        rotation = scene.pop("rod")["root_motion"]["laws"]["rotations"][0]["angle"]["sine"]
    with ExitStack() as stack:
        units = {}
        for kind in package.kinds(scene):
            units[kind] = Unit(package.pack(kind, scene, RESULTS), kind, scene["time"]["end"])
            stack.callback(units[kind].close)
            (RESULTS / f"{scene['name']}-{kind}.fmu").unlink()
        if case.prescribed:
            scheme = Prescribed(units["fluid"], rotation, scene["beam"])
        else:
            scheme = coupling.couple(units, scene.get("coupling"))
        clock = master.Clock(scene["time"]["end"], scene["time"]["communication_step"])
        recorder = Recorder(units, clock.steps)
        outcome = master.run(scheme, clock, recorder)
    recorded = {name: recorder.column(name) for name in recorder.columns}
    write_whole(case.series, lambda path: np.savez_compressed(path.open("wb"), **recorded))
    row = {"case": case.name, "key": case.key, "wall_s": round(outcome.wall, 1), "steps": outcome.steps}
    if outcome.error is not None:
        return row | {"error": outcome.error}
    row["iterations"] = round(float(recorded["iterations"][1:].mean()), 2)
    _, window, _ = evaluate(recorder, scene["name"])
    found = flapping.evaluate(scene, recorder, statistics.Window(0.0, clock.end, case.periods) if case.periods else window)
    if found:
        balance = found["energy_balance"]
        names = ("thrust", "lift", "power_in", "efficiency", "thrust_by_power", "tip_amplitude", "tip_by_rigid_tip")
        row |= {name: found[name] for name in names if name in found}
        row |= {"phase_lag_deg": found["phase_lag_deg"], "periods": found["periods"], "missing": balance["missing"]}
        if "fluid" in balance:
            lost = balance["root"] + balance["fluid"] - balance["damping"] - balance["gained"]
            row["missing_by_fluid"] = lost / balance["root"]
    return row


def measure_parts() -> list[dict]:
    """Time of a step of the fluid, variables of its unit, with and without `PARTS`, one beside the other in one process."""
    with ExitStack() as stack:
        fluids, least = {}, {}
        for number, (name, keys) in enumerate(PARTS.items()):
            # The vein stands still in a flow: a fluid at rest has numbers so small that the processor is slow with them.
            scene = Case(f"parts/{number}", PITCHING, keys | {"fluid.initial_velocity": [1.0, 0.3]}).built()
            fluid = Unit(package.pack("fluid", scene, RESULTS), "fluid", 10.0)
            stack.callback(fluid.close)
            (RESULTS / f"{scene['name']}-fluid.fmu").unlink()
            fluid.get()
            fluid.start()
            fluids[name], least[name] = fluid, np.inf
        h = scene["time"]["communication_step"]
        for i in range(ROUNDS):
            for name, fluid in fluids.items():
                before = fluid.seconds
                for k in range(STEPS):
                    fluid.step((i * STEPS + k) * h, h)
                least[name] = min(least[name], (fluid.seconds - before) / STEPS)
        count = {name: sum(v.size for v in fluid.variables.values()) for name, fluid in fluids.items()}
    return [{"case": f"parts/{name}", "step_ms": round(1e3 * least[name], 4), "variables": count[name]} for name in PARTS]


class Prescribed(coupling.Single):
    """A fluid whose stations are those of a rigid rod along x that pitches about the origin."""

    def __init__(self, fluid: Unit, law: dict, beam: dict):
        fluid.connect(["x", "y", "vx", "vy"], [])
        self.unit, self.law, self.drive = fluid, law, None
        self.s = np.linspace(0, beam["length"], beam["segments"] + 1)

    def step(self, t: float, h: float) -> int:
        law, t = self.law, t + h
        omega, part = 2 * np.pi * law["frequency"], np.pi * min(t / law["ramp"], 1.0)
        share, growth = (1 - np.cos(part)) / 2, np.pi / law["ramp"] * np.sin(part) / 2
        angle = law["amplitude"] * share * np.sin(omega * t)
        rate = law["amplitude"] * (share * omega * np.cos(omega * t) + growth * np.sin(omega * t))
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        self.unit.inputs[:] = np.concatenate([np.outer(along, self.s).ravel(), np.outer(rate * across, self.s).ravel()])
        return super().step(t - h, h)


def known() -> dict[str, dict[str, str]]:
    """Rows of results.csv by case."""
    if not (RESULTS / "results.csv").is_file():
        return {}
    with open(RESULTS / "results.csv", encoding="utf-8", newline="") as file:
        return {row["case"]: row for row in csv.DictReader(file)}


def write_rows(path: Path, rows: list[dict]) -> None:
    columns = list(dict.fromkeys(name for row in rows for name in row))

    def writer(path: Path) -> None:
        with open(path, "w", encoding="utf-8", newline="") as file:
            out = csv.DictWriter(file, columns, lineterminator="\n", restval="")
            out.writeheader()
            out.writerows(rows)

    write_whole(path, writer)


def main(
    only: Annotated[str, typer.Option(help="Run only the cases whose names match, such as 'dt/*'.")] = "*",
    listing: Annotated[bool, typer.Option("--list", help="List the cases and run nothing.")] = False,
) -> None:
    """Run what is missing and write docs/vein."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    rows = known()
    for case in cases():
        there = case.name in rows and rows[case.name]["key"] == case.key and case.series.is_file()
        if listing:
            typer.echo(f"{case.name:32} {rows[case.name]['wall_s'] + ' s' if there else 'to be run'}")
        elif not there and fnmatch(case.name, only):
            row = run(case)
            rows = known() | {case.name: row}
            write_rows(RESULTS / "results.csv", list(rows.values()))
            typer.echo(f"{case.name:32} {row['wall_s']} s")
    if not listing and fnmatch("parts", only) and f"parts/{next(iter(PARTS))}" not in rows:
        rows = known() | {row["case"]: row for row in measure_parts()}
        write_rows(RESULTS / "results.csv", list(rows.values()))
    if not listing:
        write_docs(known())


def write_docs(rows: dict[str, dict[str, str]]) -> None:
    """Tables and figures of the cases that there are."""
    DOCS.mkdir(parents=True, exist_ok=True)
    ran = {case.name: case for case in cases() if case.name in rows and case.series.is_file()}
    kept = [row for name, row in rows.items() if name in ran or name.startswith("parts/")]
    write_rows(DOCS / "vein.csv", [{name: value for name, value in row.items() if name != "key"} for row in kept])
    names = lambda group: [name for name in ran if name.startswith(f"{group}/")]
    number = lambda name, column, digits=4: f"{float(rows[name][column]):.{digits}g}" if rows[name].get(column) else ""
    percent = lambda name, column: f"{100 * float(rows[name][column]):+.2g} %" if rows[name].get(column) else ""

    if names("scene"):
        columns = ("thrust", "lift", "power_in", "efficiency", "tip_amplitude", "tip_by_rigid_tip", "phase_lag_deg")
        header = ["scene", *(c.replace("_", " ") for c in columns), "energy missing", "by the fluid", "wall, s"]
        tables.write(
            DOCS, "scenes", "The shipped scenes", header,
            [[n[6:], *(number(n, c) for c in columns), percent(n, "missing"), percent(n, "missing_by_fluid"), number(n, "wall_s", 3)]
             for n in names("scene")],
            "Means over whole periods after the tip has settled, per metre of depth where there is a fluid. Energy missing: power "
            "in at the root and that of the loads, less what the rod's energy gained and the damping took, by what came in; once with the loads "
            "that the rod took and once with what the fluid says it exerted.",
        )  # fmt: skip
    for group, what in (("grid", "grid, the step in proportion"), ("dt", "step, s, on 320 x 240")):
        if names(group):
            columns = ("thrust", "power_in", "tip_amplitude", "phase_lag_deg")
            finest = names(group)[-1]
            change = lambda n, c: f"{100 * (float(rows[n][c]) / float(rows[finest][c]) - 1):+.2f} %"
            tables.write(
                DOCS, group, f"The pitching vein over the {what.split(',')[0]}", [what, *(c.replace("_", " ") for c in columns), "thrust", "tip", "wall, s"],
                [[n.split("/")[1], *(number(n, c, 5) for c in columns), change(n, "thrust"), change(n, "tip_amplitude"), number(n, "wall_s", 3)]
                 for n in names(group)],
                "The two last but one columns: against the last line.",
            )  # fmt: skip
    parts = [name for name in PARTS if f"parts/{name}" in rows]
    if parts:
        own, count = (float(rows[f"parts/{parts[0]}"][column]) for column in ("step_ms", "variables"))
        tables.write(
            DOCS, "parts", "What the parts cost that the pitching vein has not", ["fluid", "a step, ms", "more time", "more variables"],
            [[name, number(f"parts/{name}", "step_ms"), f"{100 * (float(rows[f'parts/{name}']['step_ms']) / own - 1):+.1f} %",
              f"{float(rows[f'parts/{name}']['variables']) - count:+.0f}"] for name in parts],
            f"320 x 240 points; the least of {ROUNDS} rounds of {STEPS} steps each, one fluid beside the other on a busy machine; still stations in a flow.",
        )  # fmt: skip
    if (SWEEP / "sweep.csv").is_file():
        flexibility()
    if {"stiff/coupled", "stiff/prescribed"} <= ran.keys():
        stiff_limit(ran)
    if names("cylinder"):
        oscillating_cylinder({name.split("/")[1]: ran[name] for name in names("cylinder")}, rows)


def flexibility() -> None:
    """Thrust, efficiency, tip and phase lag over the stiffness of the vein in a stream."""
    rows = sorted(tables.read(SWEEP, "sweep"), key=lambda row: row[STIFFNESS])
    columns = ("thrust", "power_in", "efficiency", "tip_amplitude", "tip_by_rigid_tip", "phase_lag_deg")
    write_rows(DOCS / "flexibility.csv", [{name: row[name] for name in (STIFFNESS, *columns)} for row in rows])
    tables.write(
        DOCS, "flexibility", "The vein in a stream over its stiffness", ["EI, N m", *(c.replace("_", " ") for c in columns)],
        [[f"{row[STIFFNESS]:g}", *(f"{row[c]:.4g}" for c in columns)] for row in rows],
    )  # fmt: skip
    stiffness = [row[STIFFNESS] for row in rows]
    figure, axes = tables.plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    shown = {"thrust": "thrust [N/m]", "efficiency": "efficiency", "phase_lag_deg": "phase lag of the tip [degrees]"}
    for axis, (name, label) in zip(axes, shown.items()):
        axis.plot(stiffness, [row[name] for row in rows], "o-", markersize=4)
        axis.set(xscale="log", xlabel="EI [N m]", ylabel=label)
        axis.grid(True, linewidth=0.4, alpha=0.6)
    write_whole(DOCS / "flexibility.png", lambda path: figure.savefig(path, dpi=130))
    tables.plt.close(figure)


def stiff_limit(ran: dict[str, Case]) -> None:
    """How far the forces of a stiff rod are from those of the prescribed motion."""
    coupled, prescribed = (dict(np.load(ran[f"stiff/{name}"].series)) for name in ("coupled", "prescribed"))
    time, lines = coupled["time"], []
    later = time > 1.0
    for name in ("beam_drag", "beam_lift", "beam_moment"):
        raw = np.abs(coupled[name] - prescribed[name]).max() / np.abs(prescribed[name]).max()
        both = [statistics.box_filter(time, series[name], FORCE_WIDTH)[50:-50] for series in (coupled, prescribed)]
        largest = np.abs(both[0] - both[1]).max() / np.abs(both[1]).max()
        rms = np.sqrt(np.mean((both[0] - both[1]) ** 2) / np.mean(both[1] ** 2))
        means = [np.trapezoid(series[name][later], time[later]) for series in (coupled, prescribed)]
        lines.append([name, f"{100 * rms:.2g} %", f"{100 * largest:.2g} %", f"{100 * raw:.2g} %", *(f"{m:.5g}" for m in means)])
    header = ["force", "rms", "largest", "largest, no filter", "mean, stiff rod", "mean, prescribed"]
    note = (
        f"The pitching vein with EI = {STIFF['bending_stiffness']:g} on 320 x 240 against the fluid alone with the stations of a rigid rod, to t = "
        f"2: differences by the rms and the largest of the prescribed run, under a box filter of {FORCE_WIDTH:g} periods."
    )
    tables.write(DOCS, "stiff", "The stiff limit", header, lines, note)


def oscillating_cylinder(cases: dict[str, Case], rows: dict) -> None:
    """Drag over the grid: first harmonic, amplitude and noise, and the series."""
    lines, curves = [], {}
    for grid, case in cases.items():
        series = dict(np.load(case.series))
        time, drag = series["time"], series["drag"]
        window = statistics.Window(4.0, 8.0, 1)
        part = window.of(time)
        smooth = statistics.box_filter(time, statistics.box_filter(time, drag, NOISE_WIDTH), NOISE_WIDTH)
        inside = (time > 4.0) & (time < 8.0 - 2 * NOISE_WIDTH)
        amplitude, noise = np.ptp(smooth[part]) / 2, (drag - smooth)[inside]
        harmonics = [flapping.harmonic(time, drag, window)]
        lift = np.abs(series["lift"][part]).max()
        curves[grid] = (time[part], drag[part])
        lines.append([grid, amplitude, abs(harmonics[0]), np.degrees(np.angle(harmonics[0])), np.abs(noise).max() / amplitude,
                      noise.std() / amplitude, lift / amplitude, rows[case.name]["wall_s"]])  # fmt: skip
    last = lines[-1]
    shown = [
        [grid, f"{a:.5f} ({100 * (a / last[1] - 1):+.2f} %)", f"{h:.5f} ({100 * (h / last[2] - 1):+.2f} %)", f"{phase:.2f}",
         f"{100 * largest:.2g} %", f"{100 * rms:.2g} %", f"{100 * lift:.2g} %", wall]
        for grid, a, h, phase, largest, rms, lift, wall in lines
    ]  # fmt: skip
    header = ["grid", "amplitude, N/m", "first harmonic, N/m", "its phase, °", "noise, largest", "noise, rms", "largest lift", "wall, s"]
    note = (
        "The drag of the second period, unsteady term included; in brackets against the last line. Noise is what two passes of a box "
        f"filter of {NOISE_WIDTH:g} s, a fiftieth of the period, take away, by the amplitude; the lift, by the drag's amplitude, comes from the channel's middle being at 0.205 m."
    )
    tables.write(DOCS, "cylinder", "A cylinder that oscillates in a closed channel", header, shown, note)
    axes, save = tables.figure(DOCS, "cylinder", ("time [s]", "drag [N/m]"), log=False)
    for grid, (time, drag) in curves.items():
        axes.plot(time, drag, linewidth=0.8, label=grid)
    save()


if __name__ == "__main__":
    typer.run(main)
