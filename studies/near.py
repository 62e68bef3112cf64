"""Two bodies so near to each other that their masks or kernels overlap, beside the same on finer cells."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

from nervure.evaluate.statistics import Series
from studies import simulate
from studies.engine import FLUID, Case
from studies.store import Data

SCENE = "plate-pitched-288x384"
CELLS, FINE = 12, 48  # Cells a diameter or chord of 1 m, and those of the reference
GAPS = (12, 4, 2, 1, 0)  # Cells
CFL = 2 / 15  # Of the stream of 1 m/s
CLOSING = 0.5  # Speed of the approach, m/s
LEFT = 0.02  # Gap at its end, m
CENTER = (0.013, 0.029)  # Between the two, on no point or line of the grid, m
SHAPES: dict[str, dict[str, Any]] = {"disks": {"circle": {"radius": 0.5}}, "plates": {"plate": {"length": 1.0}}}
QUANTITIES = {"drag": "drag", "between": "force between them", "behind": "velocity behind them"}


def changes(kind: str, gap: float, approach: bool, cells: int) -> dict[str, Any]:
    """Return the changes to two bodies with a gap (m), abreast in a stream or driven towards each other in still
    fluid."""
    step, end = 1 / round(cells / CFL), (gap - LEFT) / CLOSING if approach else 4.0
    across, bodies = 0.5 * (gap + (kind == "disks")), []
    for sign in (1, -1):
        way = [-0.5 * sign * CLOSING * t for t in (0.0, end / 2, end)]
        table = {"times": [0.0, end / 2, end], "values": way, "end_slopes": [-0.5 * sign * CLOSING] * 2}
        motion = {"motion": {"y": {"table": table}}} if approach else {}
        bodies.append({"shape": SHAPES[kind], "position": [CENTER[0], CENTER[1] + sign * across]} | motion)
    absent = ["beam", "rod", "fluid.sponge", *(["fluid.initial_velocity", "fluid.mean_flow"] if approach else [])]
    return dict.fromkeys(absent, "absent") | simulate.on_grid(8 * cells, 6 * cells, step) | {
        "time.end": round(end / step) * step,
        "fluid.box.x": [-3.0, 5.0],
        "fluid.box.y": [-3.0, 3.0],
        "fluid.kinematic_viscosity": 0.01,
        "fluid.mask.log_linear.c_eta": 5e-5,
        "fluid.bodies": bodies,
        "fluid.probes": [{"name": "behind", "position": [1.0, CENTER[1]]}],
    }  # fmt: skip


def cases() -> Iterator[Case]:
    for kind in SHAPES:
        for gap in (gap for gap in GAPS if gap or kind == "disks"):
            yield case(kind, "abreast in a stream", gap, gap / CELLS, False)
        yield case(kind, "driven together", "all", 1.0, True)


def case(kind: str, flow: str, label: int | str, gap: float, approach: bool) -> Case:
    finer = changes(kind, gap, approach, FINE)
    about = {"pair": f"{kind} {flow}", "gap": label}
    options = {"finer": finer, "gaps": GAPS}
    coarse = changes(kind, gap, approach, CELLS)
    return Case(f"near/{kind} {flow}, {label}", FLUID, SCENE, coarse, options, beside, about)


def beside(case: Case, folder: Path) -> dict[str, Any]:
    """Return the values of a pair, and those on the finer cells."""
    begin, values = process_time(), dict[str, float]()
    for end, scene in (("", case.built()), (" finer", simulate.changed(SCENE, case.options["finer"]))):
        found = measured(simulate.completed(scene, folder), case.about["gap"] == "all")
        values |= {f"{name}{end}": float(value) for name, value in found.items()}
    return {"values": values, "times": {"cpu_s": process_time() - begin}}


def measured(series: Series, approach: bool) -> dict[str, float]:
    """Return drag and repulsion of one of the bodies, N/m, and the velocity behind them by the stream's, means over
    t = 1 to 4 s; of an approach the repulsion at each gap, the mean over a cell."""
    time, between = series["time"], 0.5 * (series["body_1_lift"] - series["body_2_lift"])
    if approach:
        gap = CELLS * (1 - CLOSING * time)
        return {f"between {own}": between[abs(gap - own) < 0.5].mean() for own in GAPS if 0 < own < CELLS}
    drag = 0.5 * (series["body_1_drag"] + series["body_2_drag"])
    found = {"drag": drag, "between": between, "behind": series["probe_behind_u"]}
    return {name: values[time > 1 - 1e-6].mean() for name, values in found.items()}


def rows(data: Data) -> list[dict[str, Any]]:
    """Return for each pair and quantity the differences from the finer cells: of forces by these, of velocities by that
    of the stream."""
    found: dict[tuple[str, str], dict[str, Any]] = {}
    for record in data.of("contact/near/*"):
        for name in (name for name in record.values if not name.endswith(" finer")):
            what, _, gap = name.partition(" ")
            value, finer = record[name], record[f"{name} finer"]
            off = value - finer if what == "behind" else value / finer - 1
            row = found.setdefault((record["pair"], what), {"pair": f"two {record['pair']}", "what": QUANTITIES[what]})
            row[gap or str(record["gap"])] = off
    return [dict.fromkeys(map(str, GAPS)) | row for row in found.values()]
