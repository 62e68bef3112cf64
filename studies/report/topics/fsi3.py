"""FSI3: docs/fsi3.md, docs/fsi3/thesis.md, and what the README has of them."""

import json
import textwrap
from collections.abc import Callable, Iterator
from functools import partial

from nervure.scene import reference
from studies.fsi3 import (
    COARSE,
    COSINE,
    FINE,
    NO_SHEAR,
    PRESSURE_JUMP,
    QUANTITIES as QUANTITIES_OF_A_RUN,
    RAMP,
    RUNS,
    THESIS_RUNS,
    VARIED,
    WAVES,
)
from studies.tables import markdown

from ..cases import QUANTITIES, TOLERANCE, references
from ..measure import unit_of
from ..store import Row, Rows, Value, value

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

THESIS = {
    "level 1": {"drag": (1107, 430), "lift": (506, -543), "tip_uy": (32.2e-3, -14.1e-3)},
    "level 2": {"drag": (719, 356), "lift": (276, -330), "tip_uy": (39.9e-3, -34.4e-3), "frequency": 5.555},
}
"""Table 4.2 of the thesis: largest and smallest values from t = 1.1 to 4.375 s, N/m and m; the frequency is in its
text, Hz."""

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
        ended = {"outcome": "error", "reason": run["error"]} if run["error"] else {}
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
            elif group not in PLACES or quantity.split(".")[0] not in QUANTITIES_OF_A_RUN or "," in quantity:
                about = case if group not in PLACES else f"{case}, the run"
                yield Row(about, method, setting, quantity, number, unit_of(quantity), **shared)
        if run["iterations"] not in (None, 1.0):
            yield Row(case, method, setting, "iterations a step", run["iterations"], "1", **shared)
        yield Row(f"{case}, the run", method, setting, "reached", run["reached"], "s", **shared, **ended)
        if group == "grid":
            for phase, seconds in run["phases_s"].items():
                yield Row(
                    "phases fsi3",
                    method,
                    setting,
                    phase,
                    seconds / run["wall_s"],
                    "by wall time of the loop",
                    size=run["cells"][0],
                    command=run["command"],
                    machine=machine_of(run),
                    source=SOURCE,
                )
    yield from cited()
    yield from thesis_rows()


def thesis_rows() -> Iterator[Row]:
    for level, found in THESIS.items():
        for quantity, numbers in found.items():
            named = {"": numbers} if quantity == "frequency" else dict(zip((".max", ".min"), numbers))
            for what, number in named.items():
                unit = "Hz" if quantity == "frequency" else unit_of(quantity)
                yield Row("fsi3, thesis", "as printed", level, f"{quantity}{what}", number, unit, source="cited")


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


LEVELS = {"level 1": ("none", "325 x 72"), "level 2": ("level 2", "650 x 144")}
"""Name of the thesis' runs, and their grids."""


def pairs(numbers: dict[str, tuple[float, float]]) -> list[str]:
    """Largest / smallest drag, lift and uy (mm)."""
    scaled = {name: [1e3 * v if name == "tip_uy" else v for v in pair] for name, pair in numbers.items()}
    return [f"{high:.{1 if name == 'tip_uy' else 0}f} / {low:.{1 if name == 'tip_uy' else 0}f}" for name, (high, low) in scaled.items()]


def extremes_of(rows: Rows, case: str, method: str, grid: str, begin: float) -> list[str]:
    def of(name: str, what: str) -> float:
        return rows.one(case, method, grid, f"{name}.{what}, from {begin:g} s").value

    return pairs({name: (of(name, "max"), of(name, "min")) for name in ("drag", "lift", "tip_uy")})


def published_extremes() -> list[str]:
    q = reference("fsi3")["primary"]["quantities"]
    return pairs({n: (q[n]["mean"] + q[n]["amplitude"], q[n]["mean"] - q[n]["amplitude"]) for n in ("drag", "lift", "tip_uy")})


def thesis_extremes(rows: Rows) -> list[str]:
    """Largest and smallest values over the thesis' window, printed and here."""
    table = []
    for level, (name, grid) in LEVELS.items():
        printed = THESIS[level]
        cells = pairs({name: printed[name] for name in ("drag", "lift", "tip_uy")})
        table.append([f"thesis, {level}", *cells, printed.get("frequency", "")])
        frequency = str(value(rows.one("fsi3, thesis", name, grid, "tip_uy.frequency_hz"), ".2f"))
        table.append([f"here, {level}", *extremes_of(rows, "fsi3, thesis", name, grid, 1.1), frequency])
    table.append(["here, level 2, from 3.5 s on", *extremes_of(rows, "fsi3, thesis", name, grid, 3.5), frequency])
    q = reference("fsi3")["primary"]["quantities"]
    table.append(["reference", *published_extremes(), f"{q['tip_uy']['frequency_hz']:.2f}"])
    return markdown(["", "drag [N/m]", "lift [N/m]", "uy [mm]", "f [Hz]"], table)


def thesis_changes(rows: Rows) -> list[str]:
    """One change of the thesis' settings at a time: extremes, and the settled motion."""

    def settled(q: dict[str, float]) -> list[str]:
        uy = f"{1e3 * q['tip_uy.mean']:.1f} ± {1e3 * q['tip_uy.amplitude']:.1f} [{q['tip_uy.frequency_hz']:.2f}]"
        return [uy, *(f"{q[f'{n}.mean']:.0f} ± {q[f'{n}.amplitude']:.0f}" for n in ("drag", "lift"))]

    table = []
    for name, changed in THESIS_RUNS.items():
        if name != "level 2":
            q = {row.quantity: row.value for row in rows.of("fsi3, thesis", method=name)}
            label = ", ".join(f"`{change}`" for change in changed) or "none"
            table.append([label, *extremes_of(rows, "fsi3, thesis", name, GRIDS[0], 1.1), *settled(q)])
    q = {row.quantity: row.value for row in rows.of("fsi3", method="momentum load", setting=GRIDS[0])}
    label = "the shipped `scenes/fsi3-325x72.json`"
    table.append([label, *extremes_of(rows, "fsi3, the run", "momentum load", GRIDS[0], 1.1), *settled(q)])
    q = {f"{n}.{what}": v for n, part in reference("fsi3")["primary"]["quantities"].items() for what, v in part.items()}
    table.append(["reference", *published_extremes(), *settled(q)])
    return markdown(["change", "drag", "lift", "uy", "settled uy", "drag", "lift"], table)


def thesis_waves(rows: Rows) -> list[str]:
    """Growth of short waves, and how the runs end."""
    table = []
    for name, changed in WAVES.items():
        if name == "bdf2, iterated":
            continue
        grid = GRIDS[1] if name == "level 2" else GRIDS[0]
        ended = rows.one("fsi3, waves, the run", name, grid, "reached")
        growth = {row.quantity: row.value for row in rows.of("fsi3, waves", method=name)}
        rate, there = "too fast for a rate", ""
        if "growth" in growth:
            rate = f"{growth['growth']:.1f} /s to {growth['growth.to']:.2f} s"
            there = f"{1e3 * growth['growth.size']:.1f} mm/s at {growth['growth.frequency_hz']:.0f} Hz"
        label = "a ramp of 2 s" if RAMP[0] in changed else ", ".join(f"`{c}`" for c in changed if not c.startswith("time.end"))
        outcome = f"{ended.value:.3f} s: {reason_of(ended)}" if ended.outcome == "error" else f"holds (to {ended.value:g} s)"
        table.append([label or "none, with the scene's own `bdf2`", rate, there, outcome])
    return markdown(["change", "growth", "what is there then", "the run ends"], table)


def reason_of(row: Row) -> str:
    """The kind of an error, in a few words."""
    kinds = {"singular": "a projected angle is singular", "converge": "no convergence", "unstable": "the load is unstable"}
    return next((said for word, said in kinds.items() if word in row.reason), row.reason[:60])


def thesis_error(rows: Rows) -> list[str]:
    return ["", *textwrap.wrap(rows.one("fsi3, waves, the run", "none", GRIDS[0], "reached").reason, 120, initial_indent="    ", subsequent_indent="    "), ""]


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {
        "fsi3": partial(readme, rows),
        "fsi3-grids": partial(grids, rows),
        "cfd3": partial(still, rows),
        "fsi3-coarse": partial(changes, rows, "coarse"),
        "fsi3-fine": partial(changes, rows, "fine"),
        "thesis-extremes": partial(thesis_extremes, rows),
        "thesis-changes": partial(thesis_changes, rows),
        "thesis-waves": partial(thesis_waves, rows),
        "thesis-error": partial(thesis_error, rows),
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
    insides = [[rows.one("phases fsi3", "momentum load", grid, unit) for unit in ("rod", "fluid")] for grid in SHIPPED]
    shares = sorted((1 - rod.value - fluid.value, fluid) for rod, fluid in insides)
    for name, (share, row) in (("least", shares[0]), ("most", shares[-1])):
        yield f"fsi3.exchange.{name}", percent(share, ".0f", row)

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

    for level, (name, grid) in LEVELS.items():
        for quantity in ("drag.max", "lift.max", "lift.min"):
            row = rows.one("fsi3, thesis", name, grid, f"{quantity}, from 1.1 s")
            printed = rows.one("fsi3, thesis", "as printed", level, quantity)
            yield f"fsi3.thesis.{name.replace(' ', '')}.{quantity}", percent(row.value / printed.value - 1, "+.0f", row)
    yield "fsi3.thesis.cfl", value(rows.one("fsi3, thesis", "none", GRIDS[0], "cfl"), ".3f")
    yield "fsi3.thesis.frequency", value(rows.one("fsi3, waves", "none", GRIDS[0], "growth.frequency_hz"), ".1f", "kHz", 1e-3)
    yield "fsi3.thesis.iterations", value(rows.one("fsi3, waves", "bdf2, iterated", GRIDS[0], "iterations a step"), ".1f")
    size = rows.one("fsi3, the run", "momentum load", GRIDS[0], "growth.size")
    yield "fsi3.thesis.shipped", value(size, ".0f", "mm/s", 1e3)
    row = rows.one("fsi3, the run", "momentum load", GRIDS[0], "growth.frequency_hz")
    yield "fsi3.thesis.shipped.frequency", value(row, ".0f")


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
