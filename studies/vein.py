"""The flapping vein's limits and convergence, and docs/vein of it; with the table of the sweep over its stiffness, which
`make vein-study` runs before.

    python scripts/studies/vein.py                 run what is missing, then write docs/vein/*.md, *.csv and *.png
    python scripts/studies/vein.py --list          the cases and what is known of them
    python scripts/studies/vein.py --only 'dt/*'   run only those

A case is known in results/vein-study/results.csv by its scene and the libraries, and is run again only when one of them has
changed. Its series is kept beside that table. Cases that were never run here stay in docs/vein/*.csv as they are. The limits and the jumps, which
take seconds, are run each time (`--only limits`, `--only jumps`).
"""

import csv
import hashlib
import json
import sys
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatch
from pathlib import Path
from time import process_time
from typing import Annotated

import numpy as np
import typer



from nervure import master, simulation
from nervure.evaluate import flapping, statistics
from nervure.pack import package
from nervure.files import write_csv, write_whole
from nervure.report import evaluate
from nervure.resources import ROOT
from nervure.scene import load, override
from nervure.unit import Unit
from studies import tables, vein_limits
from studies.vein_limits import FORCE_WIDTH, FORCES, LIMITS, PITCHING, STIFF

RESULTS = ROOT / "results" / "vein-study"
DOCS = ROOT / "docs" / "vein"
SWEEP, STIFFNESS = ROOT / "results" / "vein-flexibility", "rod.material.section.bending_stiffness"

FORWARD, HOVER, SPACE, CYLINDER = (
    "vein-forward-384x192",
    "vein-hover-288x256",
    "vein-3d",
    "cylinder-oscillating-460x100",
)

END, PERIODS = 3.02, 1
"""End of the pitching runs, s, and the periods at their end that are averaged: the tip is settled in the third."""

COUPLED_END, AT = 2.05, 1.5
"""End of the runs under other couplings, s, and the time at which their tips are compared."""

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

THICK, DIRECTIONS = "coupling/thickness-0.05", 20
"""The case whose iteration stops at a step that is looked into, and the random ways in which its stations are moved."""


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
    end = {"time.end": COUPLED_END}
    jump, light = {"coupling": {"load": "pressure_jump"}}, {"beam.thickness": 0.05}
    loose = {"coupling": {"scheme": {"iterated": {"tolerance": 1e-3}}}}
    found += [
        Case("coupling/as-shipped", PITCHING, end),
        Case("coupling/pressure-jump", PITCHING, end | jump),
        Case("coupling/pressure-jump-8e-4", PITCHING, end | jump | on_grid(320, 240, 8e-4)),
        Case(THICK, PITCHING, end | light),
        Case("coupling/thickness-0.05-tolerance-1e-3", PITCHING, end | light | loose),
    ]
    plate = {"time.end": 2.0, "beam.thickness": 0.06, "rod.material.section.line_density": 0.06}
    found += [
        Case(f"noise/{nx}x{ny}", PITCHING, plate | on_grid(nx, ny, 1e-3 * 128 / nx), prescribed=True)
        for nx, ny in ((128, 96), (192, 144))
    ]
    return found


def run(case: Case) -> dict:
    """Run a case, keep its series, and return its row."""
    scene = case.built()
    recorder, scheme, outcome = vein_limits.execute(scene, RESULTS, rigid=case.prescribed)
    recorded = {name: recorder.column(name) for name in recorder.columns}
    write_whole(case.series, lambda path: np.savez_compressed(path.open("wb"), **recorded))
    row = {"case": case.name, "key": case.key, "wall_s": round(outcome.wall, 1), "cpu_s": round(outcome.cpu, 1), "steps": outcome.steps}
    time, group = recorded["time"], case.name.split("/")[0]
    row["iterations"] = round(float(recorded["iterations"][1:].mean()), 2)
    if group == "coupling":
        row["reached_s"] = outcome.simulated
        if outcome.simulated > AT:
            row["tip_uy"] = float(np.interp(AT, time, recorded["tip_uy"]))
    if outcome.error is not None:
        last = scheme.logs()["convergence"]
        return row | {"error": outcome.error, "residual": float(last["residual"][last["step"] == last["step"][-1]].min())}
    if group == "noise":
        smooth, later = statistics.box_filter(time, recorded["beam_drag"], FORCE_WIDTH), (time > 1.0) & (time < time[-1] - FORCE_WIDTH)
        row["noise"] = float((recorded["beam_drag"] - smooth)[later].std() / np.sqrt(np.mean(smooth[later] ** 2)))
        return row
    _, window, _ = evaluate(recorder, scene["name"])
    found = flapping.evaluate(scene, recorder, statistics.Window(0.0, time[-1], case.periods) if case.periods else window)
    if found:
        balance = found["energy_balance"]
        names = ("thrust", "lift", "power_in", "efficiency", "thrust_by_power", "tip_amplitude", "tip_by_rigid_tip")
        row |= {name: found[name] for name in names if name in found}
        row |= {"phase_lag_deg": found["phase_lag_deg"], "periods": found["periods"], "missing": balance["missing"]}
        if "fluid" in balance:
            lost = balance["root"] + balance["fluid"] - balance["damping"] - balance["gained"]
            row["missing_by_fluid"] = lost / balance["root"]
    return row


def measure_jumps() -> list[dict]:
    """Where the iteration of the thick vein stops: how much the pressure jump of the step changes when the stations of the last guess
    are moved by 1e-13 to 1e-6 in `DIRECTIONS` random ways, with the velocities that go with that, relative to the norm of it."""
    case = next(case for case in cases() if case.name == THICK)
    with ExitStack() as stack:
        scene = case.built()
        fmus = {kind: package.pack(kind, scene, RESULTS) for kind in package.KINDS}
        for path in fmus.values():
            stack.callback(path.unlink)
        units, scheme, clock, recorder = simulation.assemble(scene, fmus, stack)
        outcome = master.run(scheme, clock, recorder)
        assert outcome.error, f"{THICK} reached its end: there is no step to look into"
        fluid, chance, h = units["fluid"], np.random.default_rng(1), clock.communication_step
        guess = fluid.inputs.copy()

        def pressure(stations: np.ndarray) -> np.ndarray:
            fluid.restore()
            fluid.inputs[:] = stations
            fluid.step(outcome.simulated, h)
            return fluid.exchanged.copy()

        there, rows = pressure(guess), []
        for power in range(-13, -5):
            changes = []
            for _ in range(DIRECTIONS):
                way = chance.standard_normal(guess.size // 2)
                way *= 10.0**power / np.linalg.norm(way)
                changes.append(np.linalg.norm(pressure(guess + np.r_[way, way / h]) - there) / np.linalg.norm(there))
            rows.append({"moved": 10.0**power, "median": np.median(changes), "largest": max(changes)})
    return rows


def measure_limits() -> list[dict]:
    """What `vein_limits` finds, one row a quantity."""
    rows = []
    for name, limit in LIMITS.items():
        before = process_time()
        found = limit(lambda scene, **how: vein_limits.record(scene, RESULTS, **how))
        cpu = round(process_time() - before, 1)
        rows += [{"limit": name} | asdict(one) | {"error": one.error, "cpu_s": cpu} for one in found]
    return rows


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


def read(path: Path) -> dict[str, dict[str, str]]:
    """Rows of a table by case."""
    if not path.is_file():
        return {}
    with open(path, encoding="utf-8", newline="") as file:
        return {row["case"]: row for row in csv.DictReader(file)}


def main(
    only: Annotated[str, typer.Option(help="Run only the cases whose names match, such as 'dt/*'.")] = "*",
    listing: Annotated[bool, typer.Option("--list", help="List the cases and run nothing.")] = False,
) -> None:
    """Run what is missing and write docs/vein."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    table, rows = RESULTS / "results.csv", read(RESULTS / "results.csv")
    for case in cases():
        there = case.name in rows and rows[case.name]["key"] == case.key and case.series.is_file()
        if listing:
            typer.echo(f"{case.name:48} {rows[case.name]['cpu_s'] + ' s' if there else 'to be run'}")
        elif not there and fnmatch(case.name, only):
            row = run(case)
            rows = read(table) | {case.name: row}
            write_csv(table, list(rows.values()))
            typer.echo(f"{case.name:48} {row['cpu_s']} s")
    if listing:
        return
    if fnmatch("parts", only) and f"parts/{next(iter(PARTS))}" not in rows:
        rows = read(table) | {row["case"]: row for row in measure_parts()}
        write_csv(table, list(rows.values()))
    if fnmatch("limits", only):
        write_csv(DOCS / "limits.csv", measure_limits())
    if fnmatch("jumps", only):
        write_csv(DOCS / "jumps.csv", measure_jumps())
    write_docs(rows)


def write_docs(rows: dict[str, dict]) -> None:
    """The tables of docs/vein with what is new in `rows`, its figures and its pages."""
    every = [case.name for case in cases()] + [f"parts/{name}" for name in PARTS]
    rows = {name: {k: v for k, v in row.items() if k != "key"} for name, row in (read(DOCS / "vein.csv") | rows).items()}
    write_csv(DOCS / "vein.csv", [rows[name] for name in every if name in rows])
    ran = {case.name: dict(np.load(case.series)) for case in cases() if case.series.is_file()}
    if (SWEEP / "sweep.csv").is_file():
        flexibility()
    if {"stiff/coupled", "stiff/prescribed"} <= ran.keys():
        write_csv(DOCS / "stiff.csv", stiff_limit(ran["stiff/coupled"], ran["stiff/prescribed"]))
    names = [case.name for case in cases() if case.name.startswith("cylinder/")]
    if all(name in ran for name in names):
        oscillating_cylinder({name: ran[name] for name in names})
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")


def flexibility() -> None:
    """Thrust, efficiency, tip and phase lag over the stiffness of the vein in a stream."""
    rows = sorted(tables.read(SWEEP, "sweep"), key=lambda row: row[STIFFNESS])
    columns = ("thrust", "power_in", "efficiency", "tip_amplitude", "tip_by_rigid_tip", "phase_lag_deg")
    write_csv(DOCS / "flexibility.csv", [{name: row[name] for name in (STIFFNESS, *columns)} for row in rows])
    stiffness = [row[STIFFNESS] for row in rows]
    figure, axes = tables.plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    shown = {"thrust": "thrust [N/m]", "efficiency": "efficiency", "phase_lag_deg": "phase lag of the tip [degrees]"}
    for axis, (name, label) in zip(axes, shown.items()):
        axis.plot(stiffness, [row[name] for row in rows], "o-", markersize=4)
        axis.set(xscale="log", xlabel="EI [N m]", ylabel=label)
        axis.grid(True, linewidth=0.4, alpha=0.6)
    write_whole(DOCS / "flexibility.png", lambda path: figure.savefig(path, dpi=130))
    tables.plt.close(figure)


def stiff_limit(coupled: dict, prescribed: dict) -> list[dict]:
    """How far the forces of a stiff rod are from those of the prescribed motion."""
    time, rows = coupled["time"], []
    later = time > 1.0
    for name in FORCES:
        raw = np.abs(coupled[name] - prescribed[name]).max() / np.abs(prescribed[name]).max()
        stiff, rigid = (vein_limits.filtered(time, series[name]) for series in (coupled, prescribed))
        means = [np.trapezoid(series[name][later], time[later]) for series in (coupled, prescribed)]
        rows.append({
            "force": name, "rms": np.sqrt(np.mean((stiff - rigid) ** 2) / np.mean(rigid**2)),
            "largest": np.abs(stiff - rigid).max() / np.abs(rigid).max(), "largest_without_filter": raw,
            "mean_coupled": means[0], "mean_prescribed": means[1],
        })  # fmt: skip
    return rows


def oscillating_cylinder(ran: dict[str, dict]) -> None:
    """Drag over the grid: first harmonic, amplitude and noise, and the series."""
    rows, curves = [], {}
    for name, series in ran.items():
        time, drag = series["time"], series["drag"]
        window = statistics.Window(4.0, 8.0, 1)
        part = window.of(time)
        smooth = statistics.box_filter(time, statistics.box_filter(time, drag, NOISE_WIDTH), NOISE_WIDTH)
        inside = (time > 4.0) & (time < 8.0 - 2 * NOISE_WIDTH)
        amplitude, noise = np.ptp(smooth[part]) / 2, (drag - smooth)[inside]
        harmonic = flapping.harmonic(time, drag, window)
        curves[name.split("/")[1]] = (time[part], drag[part])
        rows.append({
            "case": name, "amplitude": amplitude, "harmonic": abs(harmonic), "phase_deg": np.degrees(np.angle(harmonic)),
            "noise_largest": np.abs(noise).max() / amplitude, "noise_rms": noise.std() / amplitude,
            "lift": np.abs(series["lift"][part]).max() / amplitude,
        })  # fmt: skip
    write_csv(DOCS / "cylinder.csv", rows)
    axes, save = tables.figure(DOCS, "cylinder", ("time [s]", "drag [N/m]"), log=False)
    for grid, (time, drag) in curves.items():
        axes.plot(time, drag, linewidth=0.8, label=grid)
    save()


def pages() -> dict[Path, str]:
    """docs/vein/*.md by path, from the tables there."""
    rows = {row["case"]: row for row in tables.read(DOCS, "vein")}
    group = lambda name: [case for case in rows if case.startswith(f"{name}/")]
    number = lambda case, column, digits=4: f"{rows[case][column]:.{digits}g}" if rows[case].get(column) is not None else ""
    percent = lambda value, digits=2: f"{100 * value:+.{digits}g} %" if value is not None else ""
    spent = lambda case: number(case, "cpu_s", 3)
    made = {}

    def page(name: str, title: str, header: list[str], lines: list[list], note: str = "") -> None:
        made[DOCS / f"{name}.md"] = tables.page(title, header, lines, note)

    columns = ("thrust", "lift", "power_in", "efficiency", "tip_amplitude", "tip_by_rigid_tip", "phase_lag_deg")
    page(
        "scenes", "The shipped scenes", ["scene", *(c.replace("_", " ") for c in columns), "energy missing", "by the fluid", "CPU, s"],
        [[n[6:], *(number(n, c) for c in columns), percent(rows[n]["missing"]), percent(rows[n]["missing_by_fluid"]), spent(n)]
         for n in group("scene")],
        "Means over whole periods after the tip has settled, per metre of depth where there is a fluid. Energy missing: power "
        "in at the root and that of the loads, less what the rod's energy gained and the damping took, by what came in; once with the loads "
        "that the rod took and once with what the fluid says it exerted.",
    )  # fmt: skip
    for name, what in (("grid", "grid, the step in proportion"), ("dt", "step, s, on 320 x 240")):
        columns, finest = ("thrust", "power_in", "tip_amplitude", "phase_lag_deg"), rows[group(name)[-1]]
        page(
            name, f"The pitching vein over the {what.split(',')[0]}", [what, *(c.replace("_", " ") for c in columns), "thrust", "tip", "CPU, s"],
            [[n.split("/")[1], *(number(n, c, 5) for c in columns),
              *(f"{100 * (rows[n][c] / finest[c] - 1):+.2f} %" for c in ("thrust", "tip_amplitude")), spent(n)] for n in group(name)],
            "The two last but one columns: against the last line.",
        )  # fmt: skip
    own = rows[group("parts")[0]]
    page(
        "parts", "What the parts cost that the pitching vein has not", ["fluid", "a step, ms", "more time", "more variables"],
        [[n[6:], number(n, "step_ms"), f"{100 * (rows[n]['step_ms'] / own['step_ms'] - 1):+.1f} %", f"{rows[n]['variables'] - own['variables']:+.0f}"]
         for n in group("parts")],
        f"320 x 240 points; the least of {ROUNDS} rounds of {STEPS} steps each, one fluid beside the other on a busy machine; still stations in a flow.",
    )  # fmt: skip
    columns = ("thrust", "power_in", "efficiency", "tip_amplitude", "tip_by_rigid_tip", "phase_lag_deg")
    page(
        "flexibility", "The vein in a stream over its stiffness", ["EI, N m", *(c.replace("_", " ") for c in columns)],
        [[f"{row[STIFFNESS]:g}", *(f"{row[c]:.4g}" for c in columns)] for row in tables.read(DOCS, "flexibility")],
    )  # fmt: skip
    page(
        "stiff", "The stiff limit", ["force", "rms", "largest", "largest, no filter", "mean, stiff rod", "mean, prescribed"],
        [[row["force"], *(f"{100 * row[c]:.2g} %" for c in ("rms", "largest", "largest_without_filter")),
          *(f"{row[c]:.5g}" for c in ("mean_coupled", "mean_prescribed"))] for row in tables.read(DOCS, "stiff")],
        f"The pitching vein with EI = {STIFF['bending_stiffness']:g} on 320 x 240 against the fluid alone with the stations of a rigid rod, to t = "
        f"2: differences by the rms and the largest of the prescribed run, under a box filter of {FORCE_WIDTH:g} periods.",
    )  # fmt: skip
    lines = tables.read(DOCS, "cylinder")
    last = lines[-1]
    page(
        "cylinder", "A cylinder that oscillates in a closed channel",
        ["grid", "amplitude, N/m", "first harmonic, N/m", "its phase, °", "noise, largest", "noise, rms", "largest lift", "CPU, s"],
        [[row["case"].split("/")[1], *(f"{row[c]:.5f} ({100 * (row[c] / last[c] - 1):+.2f} %)" for c in ("amplitude", "harmonic")),
          f"{row['phase_deg']:.2f}", *(f"{100 * row[c]:.2g} %" for c in ("noise_largest", "noise_rms", "lift")), spent(row["case"])] for row in lines],
        "The drag of the second period, unsteady term included; in brackets against the last line. Noise is what two passes of a box "
        f"filter of {NOISE_WIDTH:g} s, a fiftieth of the period, take away, by the amplitude; the lift, by the drag's amplitude, comes from the channel's middle being at 0.205 m.",
    )  # fmt: skip
    page(
        "coupling", "The pitching vein under other couplings",
        ["case", "reached, s", "iterations a step", f"tip at t = {AT:g}", "least residual of the last step", "CPU, s"],
        [[n.split("/", 1)[1], number(n, "reached_s", 3), number(n, "iterations", 3), number(n, "tip_uy", 3), number(n, "residual", 2), spent(n)]
         for n in group("coupling")],
        f"`{PITCHING}` to t = {COUPLED_END:g}; the residual is relative to what the stations move in the step, and stands where the iteration stopped.",
    )  # fmt: skip
    page(
        "jumps", "The pressure jump where the iteration stops", ["stations moved by", "change, median", "change, largest"],
        [[f"{row['moved']:.0e}", *(f"{100 * row[c]:.2g} %" for c in ("median", "largest"))] for row in tables.read(DOCS, "jumps")],
        f"The step at which `{THICK}` stops: its stations moved by so much (the norm over all) in {DIRECTIONS} random ways, and their velocities with them; change of the pressure jump "
        "along the vein, relative.",
    )  # fmt: skip
    page(
        "noise", "Noise of a thin moving plate", ["grid", "noise of the drag", "CPU, s"],
        [[n.split("/")[1], f"{100 * rows[n]['noise']:.2g} %", spent(n)] for n in group("noise")],
        f"A rigid plate that pitches as the vein does, 0.06 thick: rms of what a box filter of {FORCE_WIDTH:g} periods takes away, by the rms of what it leaves.",
    )  # fmt: skip
    page(
        "limits", "Where the answer is known", ["limit", "quantity", "found", "should be", "off by", "asked", "CPU of the limit, s"],
        [[row["limit"], row["quantity"], f"{row['value']:.5g} {row['unit'] or ''}".strip(), f"{row['expected']:.5g} {row['unit'] or ''}".strip(),
          f"{100 * row['error']:+.2g} %", f"{100 * row['asked']:g} %", f"{row['cpu_s']:g}"] for row in tables.read(DOCS, "limits")],
        "`scripts/studies/vein_limits.py` has the scenes and the derivations; tests/test_flapping.py asks for the same.",
    )  # fmt: skip
    return made


if __name__ == "__main__":
    typer.run(main)
