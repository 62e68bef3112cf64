"""FSI3: docs/fsi3.md, docs/fsi3/thesis.md, and what the README has of them."""

import json
from collections.abc import Callable, Iterator
from functools import partial

from cosim.scene import reference
from studies.fsi3 import COARSE, COSINE, FINE, NO_SHEAR, PRESSURE_JUMP, RUNS, VARIED

from ..cases import QUANTITIES, TOLERANCE, references
from ..measure import unit_of
from ..store import Row, Rows, Value, markdown, value

SIMULATED = 8.0
"""End of the FSI3 scenes, s."""

GRIDS = ("325 x 72", "650 x 144", "960 x 216", "1300 x 288")
SHIPPED = ("325 x 72", "650 x 144", "1300 x 288")

CITED = (
    ("FLUSI", "325 x 72", 325, 34.0, {"tip_uy.amplitude": 42.5e-3, "tip_uy.frequency_hz": 6.5}),
    ("FLUSI", "650 x 144", 650, 259.0, {"tip_uy.amplitude": 44.6e-3, "tip_uy.frequency_hz": 5.9}),
    ("deal.II, monolithic", "as cited", None, 1280.0, {}),
    ("nutils", "as cited", None, 5300.0, {}),
)
"""Other solvers of FSI3, not measured here: wall time a simulated second, s."""

SOURCE = "docs/fsi3/runs.json"


# Rows


def known() -> list[dict]:
    return json.loads(RUNS.read_text(encoding="utf-8"))


def machine_of(run: dict) -> str:
    """Key of the record of machine and versions of a run."""
    return f"runs, {run['machine']['git']['revision'][:9]}"


def machines() -> dict[str, dict]:
    return {machine_of(run): run["machine"] for run in known()}


def series() -> dict[str, dict]:
    """The last periods on each grid."""
    return {f"{run['cells'][0]} x {run['cells'][1]}": run["series"] for run in known() if "series" in run}


PLACES = {
    "grid": ("fsi3", "momentum load"),
    "still": ("cfd3", "bar held still"),
    "coarse": ("fsi3", "one change"),
    "fine": ("fsi3", "one change"),
}
"""Case and method of the groups that are compared with the benchmark."""


def rows() -> Iterator[Row]:
    for run in known():
        group, _, label = run["name"].partition("/")
        grid = f"{run['cells'][0]} x {run['cells'][1]}"
        case, method = PLACES.get(group, (f"fsi3, {group}", label))
        # A change of the box has other cells, but belongs to the scene's grid.
        changed = label if group not in PLACES or method != "one change" else f"{base_of(group)}, {label}"
        setting = changed if method == "one change" else grid
        shared = {
            "size": run["cells"][0],
            "step": run["step"],
            "wall_s": run["wall_s"],
            "cpu_s": run["cpu_s"],
            "repeats": 1,
            "command": run["command"],
            "machine": machine_of(run),
            "source": SOURCE,
        }
        if run["error"]:
            shared |= {"outcome": "error", "reason": run["error"]}
        published = references(case) if group in PLACES else {}
        for quantity, number in run["quantities"].items():
            if group in PLACES and quantity in QUANTITIES[case]:
                expected, scale = published.get(quantity, (None, None))
                yield Row(
                    case,
                    method,
                    setting,
                    quantity,
                    number,
                    unit_of(quantity),
                    expected,
                    None if expected is None else (number - expected) / scale,
                    tolerance=TOLERANCE[case],
                    **shared,
                )
            elif group not in PLACES or "." not in quantity or quantity.startswith("window"):
                about = case if group not in PLACES else f"{case}, the run"
                yield Row(about, method, setting, quantity, number, unit_of(quantity), **shared)
        if group == "iterations" and run["iterations"]:
            yield Row(case, method, setting, "iterations a step", run["iterations"], "1", **shared)
        yield Row(f"{case}, the run", method, setting, "reached", run["reached"], "s", **shared)
        if group == "grid":
            for phase, seconds in run["phases_s"].items():
                yield Row(
                    "phases fsi3",
                    method,
                    setting,
                    phase,
                    seconds / run["wall_s"],
                    "share of wall time",
                    size=run["cells"][0],
                    command=run["command"],
                    machine=machine_of(run),
                    source=SOURCE,
                )
    yield from cited()


def base_of(group: str) -> str:
    return {"coarse": "325 x 72", "fine": "650 x 144"}[group]


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


# Tables


def cells(rows: Rows, setting: str, method: str = "momentum load", fits: bool = False) -> list[str]:
    """ux, uy, (frequency,) drag and lift of a run."""
    found = {row.quantity: row.value * (1e3 if row.unit == "m" else 1) for row in rows.of("fsi3", method=method, setting=setting)}

    def pair(name: str, digits: int) -> str:
        return f"{found[f'{name}.mean']:.{digits}f} ± {found[f'{name}.amplitude']:.{digits}f}"

    if fits:
        forces = [f"{pair(q, 1)} ({found[f'{q}.fit']:.1f})" for q in ("drag", "lift")]
        return [pair("tip_ux", 2), pair("tip_uy", 2), f"{found['tip_uy.frequency_hz']:.2f}", *forces]
    tip = [f"{pair(q, 2)} [{found[f'{q}.frequency_hz']:.2f}]" for q in ("tip_ux", "tip_uy")]
    return [*tip, pair("drag", 1), pair("lift", 1)]


def reference_cells(fits: bool = False) -> list[str]:
    q = reference("fsi3")["primary"]["quantities"]
    pairs = [f"{1e3 * q[n]['mean']:.2f} ± {1e3 * q[n]['amplitude']:.2f}" for n in ("tip_ux", "tip_uy")]
    frequencies = [f"{q[n]['frequency_hz']:.2f}" for n in ("tip_ux", "tip_uy")]
    forces = [f"{q['drag']['mean']:.1f} ± {q['drag']['amplitude']:.2f}", f"{q['lift']['mean']:.2f} ± {q['lift']['amplitude']:.2f}"]
    if fits:
        return [*pairs, frequencies[1], *forces]
    return [f"{pair} [{f}]" for pair, f in zip(pairs, frequencies)] + forces


def spread_cells() -> list[str]:
    q = reference("fsi3")["spread"]["quantities"]

    def between(name: str, what: str, scale: float = 1.0) -> str:
        low, high = q[name][what]
        return f"{scale * low:g} to {scale * high:g}"

    return [
        between("tip_ux", "amplitude", 1e3),
        between("tip_uy", "amplitude", 1e3),
        between("tip_uy", "frequency_hz"),
        f"{between('drag', 'mean')}, {between('drag', 'amplitude')}",
        between("lift", "amplitude"),
    ]


HEADER = ["", "ux", "uy", "f", "drag", "lift"]


def readme(rows: Rows) -> list[str]:
    commands = {
        "1300 x 288": "`make fsi3 GRID=1300x288`",
        "650 x 144": "`make fsi3 GRID=650x144`",
        "325 x 72": "`make fsi3` (325 x 72)",
    }
    table = [["reference (FeatFlow, level 4)", *reference_cells()]]
    table += [[name, *cells(rows, grid)] for grid, name in commands.items()]
    return markdown(["", "ux", "uy", "drag", "lift"], table)


def grids(rows: Rows) -> list[str]:
    table = [[grid, *cells(rows, grid, fits=True)] for grid in GRIDS]
    table += [["FeatFlow, level 4", *reference_cells(fits=True)], ["published spread", *spread_cells()]]
    return markdown(HEADER, table)


def still(rows: Rows) -> list[str]:
    table = []
    for grid in ("650 x 144", "1300 x 288"):
        q = {row.quantity: row.value for row in rows.of("cfd3", setting=grid)}
        table.append(
            [
                grid,
                f"{q['drag.mean']:.1f} ± {q['drag.amplitude']:.2f} ({q['drag.fit']:.2f})",
                f"{q['lift.mean']:.1f} ± {q['lift.amplitude']:.1f} ({q['lift.fit']:.1f})",
                f"{q['lift.frequency_hz']:.3f}",
            ]
        )
    q = reference("cfd3")["primary"]["quantities"]
    drag, lift = (f"{q[n]['mean']:g} ± {q[n]['amplitude']:g}" for n in ("drag", "lift"))
    table.append(["Turek & Hron", drag, lift, f"{q['lift']['frequency_hz']:.3f}"])
    return markdown(["", "drag [N/m]", "lift [N/m]", "f [Hz]"], table)


def changes(rows: Rows, group: str) -> list[str]:
    """What one change does, on the grid of a group."""
    base = base_of(group)
    table = [["none", *cells(rows, base, fits=True)]]
    for changed in VARIED[{"coarse": COARSE, "fine": FINE}[group]]:
        setting = f"{base}, {', '.join(changed)}"
        if rows.of("fsi3", setting=setting):
            table.append([", ".join(f"`{change}`" for change in changed), *cells(rows, setting, "one change", fits=True)])
    return markdown(["change", *HEADER[1:]], table)


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {
        "fsi3": partial(readme, rows),
        "fsi3-grids": partial(grids, rows),
        "cfd3": partial(still, rows),
        "fsi3-coarse": partial(changes, rows, "coarse"),
        "fsi3-fine": partial(changes, rows, "fine"),
    }


# Values

AMPLITUDES = ("tip_ux.amplitude", "tip_uy.amplitude", "drag.amplitude", "lift.amplitude")
MAIN = (*AMPLITUDES, "tip_ux.mean", "tip_uy.frequency_hz", "drag.mean")
"""What is compared in one number: the means of uy and lift are near 0."""


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    def of(grid: str, quantity: str) -> Row:
        return rows.one("fsi3", "momentum load", grid, quantity)

    def changed(group: str, change: str, quantity: str) -> Row:
        return rows.one("fsi3", "one change", f"{base_of(group)}, {change}", quantity)

    def by(group: str, change: str, quantity: str) -> float:
        """What a change makes of a quantity, relative."""
        return changed(group, change, quantity).value / of(base_of(group), quantity).value - 1

    def percent(number: float, form: str, row: Row) -> Value:
        return Value(100 * number, form, "%", row.command)

    for grid in ("325 x 72", "650 x 144", "1300 x 288"):
        for quantity, form in ERRORS[grid].items():
            row = of(grid, quantity)
            yield f"fsi3.{grid.replace(' ', '')}.{quantity}.error", percent(abs(off(row)), form, row)
    finest = [of("1300 x 288", quantity) for quantity in ("tip_uy.amplitude", "tip_uy.frequency_hz", "drag.mean")]
    yield "fsi3.1300x288.uy_f_drag.error", percent(max(abs(off(row)) for row in finest), ".1f", finest[0])
    for grid in SHIPPED:
        row = of(grid, "tip_uy.amplitude")
        seconds = row.cpu_s / SIMULATED
        yield f"fsi3.{grid.replace(' ', '')}.time", Value(seconds, ".1f" if seconds < 20 else ".0f", "s", row.command)
    shares = [rows.one("phases fsi3", "momentum load", grid, "exchange_and_python") for grid in SHIPPED]
    for name, row in (("least", min(shares, key=value_of)), ("most", max(shares, key=value_of))):
        yield f"fsi3.exchange.{name}", value(row, ".0f", "%", 100)

    periods = [rows.one("fsi3, the run", "momentum load", grid, "periods") for grid in GRIDS[1:]]
    for name, row in (("least", min(periods, key=value_of)), ("most", max(periods, key=value_of))):
        yield f"fsi3.periods.{name}", value(row, ".0f")
    steps = [rows.one("fsi3, the run", "momentum load", grid, "cfl") for grid in SHIPPED]
    for name, row in (("least", min(steps, key=value_of)), ("most", max(steps, key=value_of))):
        yield f"fsi3.cfl.{name}", value(row, ".2f")
    last = {quantity: (of("960 x 216", quantity), of("1300 x 288", quantity)) for quantity in MAIN}
    row = last["drag.mean"][1]
    yield "fsi3.last.most", percent(max(abs(fine.value / coarse.value - 1) for coarse, fine in last.values()), ".1f", row)
    for name, quantity, form, scale, unit in (
        ("uy", "tip_uy.amplitude", ".3f", 1e3, "mm"),
        ("f", "tip_uy.frequency_hz", ".3f", 1.0, "Hz"),
        ("drag", "drag.mean", ".1f", 1.0, "N/m"),
        ("lift", "lift.amplitude", ".1f", 1.0, "N/m"),
    ):
        coarse, fine = last[quantity]
        yield f"fsi3.last.{name}", Value(scale * abs(fine.value - coarse.value), form, unit, fine.command)

    for grid in ("650 x 144", "1300 x 288"):
        for quantity in ("drag.mean", "lift.amplitude", "lift.frequency_hz"):
            row = rows.one("cfd3", "bar held still", grid, quantity)
            yield f"cfd3.{grid.replace(' ', '')}.{quantity}", percent(off(row), "+.1f", row)
    still = [rows.one("cfd3", "bar held still", "650 x 144", q) for q in ("drag.mean", "lift.amplitude", "lift.frequency_hz")]
    yield "cfd3.most", percent(max(abs(off(row)) for row in still), ".1f", still[0])

    row = changed("fine", NO_SHEAR, "lift.amplitude")
    for name, quantity in (("f", "tip_uy.frequency_hz"), ("lift", "lift.amplitude")):
        yield f"fsi3.shear.{name}", percent(1 / (1 + by("fine", NO_SHEAR, quantity)) - 1, "+.1f", row)
        yield f"fsi3.no_shear.{name}.error", percent(off(changed("fine", NO_SHEAR, quantity)), ".1f", row)
    row, base = changed("coarse", PRESSURE_JUMP, "lift.amplitude"), of("325 x 72", "lift.amplitude")
    yield "fsi3.pressure_jump.lift", percent(by("coarse", PRESSURE_JUMP, "lift.amplitude"), ".0f", row)
    yield "fsi3.pressure_jump.fit", percent(by("coarse", PRESSURE_JUMP, "lift.fit"), ".0f", row)
    yield "fsi3.pressure_jump.cost", Value(row.cpu_s / base.cpu_s, ".1f", "times", row.command)

    long = partial(rows.one, "fsi3, the run", "one change", f"325 x 72, {LONG}")
    yield "fsi3.long.begin", value(long("window.begin"), ".1f")
    yield "fsi3.long.end", value(long("window.end"), ".1f")
    yield "fsi3.long.drift", value(long("amplitude_drift"), "+.1f", "%", 100)

    harmless = [abs(by(group, change, q)) for group, change in HARMLESS for q in ("tip_uy.amplitude", "tip_uy.frequency_hz")]
    yield "fsi3.harmless", percent(max(harmless), ".1f", of("650 x 144", "drag.mean"))
    costs = [
        max(by(group, change, q) for q in ("tip_uy.amplitude", "drag.mean")) for group in ("coarse", "fine") for change in BOUNDARY
    ]
    yield "fsi3.boundary.least", percent(min(costs), ".0f", of("650 x 144", "drag.mean"))
    yield "fsi3.boundary.most", percent(max(costs), ".0f", of("650 x 144", "drag.mean"))
    soft, hard = (changed("fine", f"fluid.mask.log_linear.c_eta={c_eta}", "drag.mean") for c_eta in ("1e-4", "1e-6"))
    yield "fsi3.c_eta.drag", percent((hard.value / soft.value) ** 0.5 - 1, "+.1f", hard)
    all_hard = [changed("fine", "fluid.mask.log_linear.c_eta=1e-6", quantity) for quantity in MAIN]
    yield "fsi3.c_eta.hard", percent(max(abs(off(row)) for row in all_hard), ".1f", hard)
    heavy = "rod.material.plane_strain.density=1050"
    for name, quantity in (("f", "tip_uy.frequency_hz"), ("lift", "lift.amplitude")):
        yield f"fsi3.heavy.{name}", percent(by("fine", heavy, quantity), "+.1f", changed("fine", heavy, quantity))


ERRORS = {
    "325 x 72": {"tip_uy.amplitude": ".0f", "tip_uy.frequency_hz": ".0f", "drag.mean": ".0f", "lift.amplitude": ".0f"},
    "650 x 144": {
        "tip_uy.amplitude": ".1f",
        "tip_uy.frequency_hz": ".1f",
        "drag.mean": ".1f",
        "lift.amplitude": ".1f",
        "tip_ux.mean": ".1f",
        "tip_ux.amplitude": ".1f",
    },
    "1300 x 288": {
        "tip_uy.amplitude": ".1f",
        "tip_uy.frequency_hz": ".1f",
        "drag.mean": ".1f",
        "lift.amplitude": ".1f",
        "tip_ux.mean": ".0f",
        "tip_ux.amplitude": ".0f",
        "drag.amplitude": ".0f",
    },
}
"""Quantities whose distance from the published value is told, and how."""

LONG = "time.end=30"

HARMLESS = (
    *(("coarse", change) for change in ("time.communication_step=2e-4", "time.communication_step=1e-4", "beam.segments=84")),
    ("coarse", 'rod.scheme={"generalised_alpha":{"rho_inf":0.5}}'),
    *(("fine", ", ".join(changes)) for changes in VARIED[FINE] if changes[0].startswith("fluid.box")),
    ("fine", "beam.segments=60"),
)
BOUNDARY = ("fluid.filter=two_thirds", "fluid.mask.log_linear.target=none", COSINE)
"""Changes that move little, and those of the boundary."""


def off(row: Row) -> float:
    """Relative distance from the published value."""
    return row.value / row.reference - 1


def value_of(row: Row) -> float:
    return row.value
