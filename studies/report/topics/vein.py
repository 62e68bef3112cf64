"""The driven rod: docs/vein.md and docs/vein."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from nervure.resources import SCENES
from nervure.scene import load
from studies import vein as study
from studies.vein_limits import CANTILEVER, PITCHING
from studies.tables import markdown

from ..store import Row, Rows, Value, csv_rows, number, value

NAMES = {
    "pitching": f"scene/{PITCHING}",
    "forward": f"scene/{study.FORWARD}",
    "hover": f"scene/{study.HOVER}",
    "in space": f"scene/{study.SPACE}",
}
"""The shipped scenes, as the page calls them, and their cases."""

SHIPPED_CYLINDER = "cylinder/460x100"
"""The shipped scene of the oscillating cylinder."""

UNITS = {
    "thrust": "N/m",
    "lift": "N/m",
    "power_in": "W/m",
    "tip_amplitude": "m",
    "phase_lag_deg": "°",
    "reached_s": "s",
    "tip_uy": "m",
    "step_ms": "ms",
    "amplitude": "N/m",
    "harmonic": "N/m",
    "phase_deg": "°",
    "mean_coupled": "N s/m",
    "mean_prescribed": "N s/m",
}
"""Of the columns of the tables; the others are ratios and counts."""

SWEEP = "python nervure sweep scenes/vein-forward-384x192.json --end-time 8 --vary {}={}"


def command(only: str) -> str:
    return f"python scripts/studies/vein.py --only '{only}'"


# Rows


def rows() -> Iterator[Row]:
    """Every number of the tables in docs/vein, and what follows from a scene alone."""
    cases = {case.name: case for case in study.cases()}
    for row in csv_rows(study.DOCS / "vein.csv"):
        name = row["case"]
        shared = {time: number(row.pop(time)) for time in ("wall_s", "cpu_s")}
        shared |= {"command": command("parts" if name.startswith("parts/") else name)}
        if error := row.pop("error"):
            shared |= {"outcome": "error", "reason": error}
        yield from line("vein.csv", "run", name, row, **shared)
        if name in (*NAMES.values(), SHIPPED_CYLINDER):
            spent = shared["cpu_s"] / cases[name].built()["time"]["end"]
            yield from line("vein.csv", "run", name, {"cpu_by_simulated": str(spent)}, command=shared["command"])
        if name == NAMES["hover"]:
            drive = load(SCENES / f"{study.HOVER}.json")["rod"]["root_motion"]["laws"]["y"]["sine"]
            pressure = (2 * np.pi * drive["frequency"] * drive["amplitude"]) ** 2 / 2
            coefficient = float(row["thrust"]) / pressure
            yield from line("vein.csv", "run", name, {"lift_coefficient": str(coefficient)}, **shared)
    for row in csv_rows(study.DOCS / "flexibility.csv"):
        stiffness = float(row.pop(study.STIFFNESS))
        varied = SWEEP.format(study.STIFFNESS, f"{stiffness:g}")
        yield from line("flexibility.csv", "flexibility", f"EI = {stiffness:g}", row, command=varied)
    for row in csv_rows(study.DOCS / "stiff.csv"):
        yield from line("stiff.csv", "stiff limit", row.pop("force"), row, command=command("stiff/*"))
    for row in csv_rows(study.DOCS / "cylinder.csv"):
        name = row.pop("case")
        yield from line("cylinder.csv", "oscillating cylinder", name, row, command=command(name))
    for row in csv_rows(study.DOCS / "jumps.csv"):
        yield from line("jumps.csv", "jumps", f"{float(row.pop('moved')):.0e}", row, command=command("jumps"))
    for row in csv_rows(study.DOCS / "limits.csv"):
        yield Row(
            "vein",
            row["limit"],
            "",
            row["quantity"],
            float(row["value"]),
            row["unit"],
            reference=float(row["expected"]),
            error=float(row["error"]),
            cpu_s=float(row["cpu_s"]),
            command=command("limits"),
            source="docs/vein/limits.csv",
        )
    section = load(SCENES / f"{PITCHING}.json")["rod"]["material"]["section"]
    first = CANTILEVER[0] ** 2 * np.sqrt(section["bending_stiffness"] / section["line_density"]) / (2 * np.pi)
    yield Row("vein", "cantilever", PITCHING, "frequency", float(first), "Hz", source=f"scenes/{PITCHING}.json")


def line(table: str, method: str, setting: str, cells: dict[str, str], **shared) -> Iterator[Row]:
    """A row for each number of a line of docs/vein/TABLE."""
    for quantity, text in cells.items():
        if text and quantity != "case":
            unit = UNITS.get(quantity, "s" if quantity == "cpu_by_simulated" else "")
            yield Row("vein", method, setting, quantity, float(text), unit, source=f"docs/vein/{table}", **shared)


# Values


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    def of(name: str, quantity: str) -> Row:
        return rows.one("vein", "run", name, quantity)

    def group(method: str, quantity: str, *settings: str) -> list[Row]:
        found = rows.of("vein", method=method, quantity=quantity)
        return [row for row in found if not settings or row.setting in settings]

    def largest(found: list[Row], field: str = "value") -> Row:
        return max(found, key=lambda row: abs(getattr(row, field)))

    def change(of: Row, to: Row, form: str) -> Value:
        """By how much `of` differs from `to`, per cent."""
        return Value(100 * (of.value / to.value - 1), form, "%", of.command)

    for key, name in {**NAMES, "cylinder": SHIPPED_CYLINDER}.items():
        yield f"vein.time.{key.removeprefix('in ')}", value(of(name, "cpu_by_simulated"), ".2g")
    parts = [row for row in group("run", "step_ms") if not row.setting.endswith(("as shipped", "without the sponge"))]
    own = of("parts/as shipped", "step_ms")
    yield "vein.parts.least", change(min(parts, key=lambda row: row.value), own, ".0f")
    yield "vein.parts.most", change(max(parts, key=lambda row: row.value), own, ".0f")

    yield "vein.hover.lift_coefficient", value(of(NAMES["hover"], "lift_coefficient"), ".2f")
    yield "vein.vacuum.frequency", value(rows.one("vein", "cantilever", PITCHING, "frequency"), ".2f")
    lag = of(NAMES["pitching"], "phase_lag_deg")
    yield "vein.pitching.behind", Value(lag.value % 360, ".0f", "°", lag.command)

    def bending(quantity: str, *stiffness: int) -> list[Row]:
        return group("flexibility", quantity, *(f"EI = {ei}" for ei in stiffness))

    yield "vein.flexibility.thrust", change(*bending("thrust", 16, 128), ".0f")
    lags = sorted(bending("phase_lag_deg", 8, 16), key=lambda row: row.value)
    yield "vein.flexibility.lag.least", value(lags[0], ".0f")
    yield "vein.flexibility.lag.most", value(lags[1], ".0f")
    best = min(bending("efficiency", 8, 16), key=lambda row: row.value)
    yield "vein.flexibility.efficiency", value(best, ".1f", "%", 100)
    yield "vein.flexibility.efficiency.stiff", value(*bending("efficiency", 128), ".1f", "%", 100)

    yield "vein.stiff.rms", value(largest(group("stiff limit", "rms")), ".2f", "%", 100)
    yield "vein.stiff.largest", value(largest(group("stiff limit", "largest")), ".2f", "%", 100)
    yield "vein.stiff.raw", value(largest(group("stiff limit", "largest_without_filter")), ".0f", "%", 100)
    means = [rows.one("vein", "stiff limit", "beam_drag", f"mean_{name}") for name in ("coupled", "prescribed")]
    yield "vein.stiff.mean", Value(100 * abs(means[0].value / means[1].value - 1), ".3f", "%", means[0].command)

    limit = partial(rows.one, "vein")
    stiff = [row for row in rows.of("vein", method="stiff limit") if row.source.endswith("limits.csv")]
    yield "vein.limits.stiff", value(largest(stiff), ".1f", "%", 100)
    transfer = limit("transfer function", "", "tip by root")
    yield "vein.limits.transfer", value(transfer, ".5f")
    yield "vein.limits.transfer.exact", value(transfer, ".5f", field="reference")
    yield "vein.limits.transfer.error", value(transfer, ".2f", "%", 100, "error")
    vibration = limit("free vibration", "", "frequency")
    yield "vein.limits.vibration", value(vibration, ".3f")
    yield "vein.limits.vibration.expected", value(vibration, ".3f", field="reference")
    yield "vein.limits.vibration.error", value(vibration, "+.1f", "%", 100, "error")
    yield "vein.limits.vibration.share", value(limit("free vibration", "", "frequency by that in vacuum"), ".0f", "%", 100)

    scenes = [of(name, "missing") for name in NAMES.values()] + [limit("energy", "", "by the loads")]
    yield "vein.energy.loads", value(largest(scenes), ".3f", "%", 100)
    for name, form in (("forward", "+.2f"), ("pitching", "+.1f"), ("hover", "+.1f")):
        yield f"vein.energy.{name}", value(of(NAMES[name], "missing_by_fluid"), form, "%", 100)

    coarse, *fine = group("oscillating cylinder", "noise_largest")
    yield "vein.cylinder.noise.coarse", value(coarse, ".1f", "%", 100)
    yield "vein.cylinder.noise.least", value(min(fine, key=lambda row: row.value), ".2g", "%", 100)
    yield "vein.cylinder.noise.most", value(max(fine, key=lambda row: row.value), ".2g", "%", 100)
    harmonics = {row.setting: row for row in group("oscillating cylinder", "harmonic")}
    for key, name in (("coarse", "cylinder/230x50"), ("shipped", SHIPPED_CYLINDER)):
        yield f"vein.cylinder.harmonic.{key}", change(harmonics[name], harmonics["cylinder/920x200"], "+.2f")

    tips = [row for row in group("run", "tip_amplitude") if row.setting.startswith("grid/")]
    yield "vein.grid.tip", change(max(tips, key=lambda row: abs(row.value - tips[-1].value)), tips[-1], ".1f")
    steps = [row for row in group("run", "thrust") if row.setting.startswith("dt/")]
    for key, before, after in zip(("first", "second", "third"), steps, steps[1:]):
        yield f"vein.dt.{key}", change(after, before, ".1f")

    momentum, jump = "coupling/as-shipped", "coupling/pressure-jump"
    taken = of(jump, "tip_uy")
    yield "vein.jump.iterations", value(of(jump, "iterations"), ".2f")
    yield "vein.jump.cost", Value(taken.cpu_s / of(momentum, "tip_uy").cpu_s, ".0f", "times", taken.command)
    yield "vein.jump.tip", value(taken, ".3f")
    yield "vein.momentum.tip", value(of(momentum, "tip_uy"), ".3f")
    yield "vein.jump.long_step.stops", value(of(f"{jump}-8e-4", "reached_s"), ".2f")
    yield "vein.thick.stops", value(of(study.THICK, "reached_s"), ".2f")
    yield "vein.thick.residual", value(of(study.THICK, "residual"), ".2g", "%", 100)
    yield "vein.thick.loose.stops", value(of(f"{study.THICK}-tolerance-1e-3", "reached_s"), ".2f")
    small = group("jumps", "largest", "1e-13", "1e-12", "1e-11", "1e-10", "1e-09")
    yield "vein.jumps", value(largest(small), ".1f", "%", 100)
    for key, grid in (("coarse", "128x96"), ("fine", "192x144")):
        yield f"vein.noise.{key}", value(of(f"noise/{grid}", "noise"), ".1f", "%", 100)


# Tables


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {"vein-scenes": partial(scenes, rows), "vein-convergence": partial(convergence, rows)}


def scenes(rows: Rows) -> list[str]:
    """What the shipped scenes give."""
    table = []
    for label, name in NAMES.items():
        found = {row.quantity: row.value for row in rows.of("vein", method="run", setting=name)}
        table.append(
            [
                label,
                f"{found['thrust']:.3g}" if "thrust" in found else "",
                f"{found['power_in']:.4g}" + ("" if "thrust" in found else " W"),
                f"{100 * found['efficiency']:.1f} %" if "efficiency" in found else "",
                f"{found['tip_amplitude']:.3g}",
                f"{found['tip_by_rigid_tip']:.2f}",
                f"{found['phase_lag_deg']:.1f}°",
            ]
        )
    header = ["", "thrust", "power in", "efficiency", "tip's amplitude", "tip by rigid tip", "phase lag"]
    return markdown(header, table)


def convergence(rows: Rows) -> list[str]:
    """Thrust and tip of the pitching vein over grid and step, against the last of each."""
    halves = []
    for group in ("grid", "dt"):
        found = [
            [row for row in rows.of("vein", method="run", quantity=quantity) if row.setting.startswith(f"{group}/")]
            for quantity in ("thrust", "tip_amplitude")
        ]
        half = []
        for pair in zip(*found):
            name = pair[0].setting.split("/")[1].replace("x", " x ")
            last = pair[0] is found[0][-1]
            off = [f"{100 * (row.value / of[-1].value - 1):+.1f}" for row, of in zip(pair, found)]
            cells = [f"{row.value:.4g}" for row in pair] if last else off
            half.append([name if group == "grid" else name, *cells])
        halves.append(half)
    table = [[*left, "", *right] for left, right in zip(*halves)]
    return markdown(["grid", "thrust", "tip", "", "step, s", "thrust", "tip"], table)


def pages() -> dict[Path, str]:
    return study.pages()
