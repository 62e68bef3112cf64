"""The rod: docs/rod.md and docs/rod."""

from collections.abc import Callable, Iterator
from pathlib import Path

from studies import rod as study
from studies.tables import exponent, grouped, markdown

from ..cases import references
from ..measure import unit_of
from ..store import Row, Rows, Value, csv_rows, number, value

COMMAND = "make rod-study"
SCHEMES = {"trapezoid": 1, "generalised-alpha 0.5": 1, "generalised-alpha 0.8": 1, "BDF2": 1, "TR-BDF2": 2}
"""Solves a step."""
FAMILY = {"csm1": "rod-static", "csm3": "csm3"}
"""Cases whose published values the scenes have."""
CALIBRATIONS = ("second order", "second order, inextensible")
PLANES = {"xz": "", "diagonal": ", diagonal plane"}
WEIGHTS = {"light": "0.7", "middle": "2", "heavy": "8"}
"""Of the elastica, m/s²."""


# Rows


def rows() -> Iterator[Row]:
    """docs/rod/*.csv, but for the shapes of the figure."""
    yield from accuracy()
    yield from energies()
    yield from costs()
    yield from maps()
    for row in csv_rows(study.DOCS / "clamp.csv"):
        setting = f"nu = {row['poisson']}, {row['elements']}"
        for name, quantity, unit in (
            ("by_moment", "set-back by the moment", "h"),
            ("by_force", "set-back by the force", "h"),
            ("shear_factor", "shear factor", "1"),
        ):
            cowper = 10 / (12 - float(row["poisson"])) if name == "shear_factor" else None
            found = float(row[name])
            error = found / cowper - 1 if cowper else None
            shared = {"command": "python scripts/studies/clamp.py", "source": "docs/rod/clamp.csv"}
            yield Row("rod-clamp", row["wall"], setting, quantity, found, unit, cowper, error, **shared)


def accuracy() -> Iterator[Row]:
    """Errors over n and over the step, of the projected model, and against CSM1 and CSM3."""
    for row in csv_rows(study.DOCS / "order_in_n.csv"):
        method, setting = row["calibration"] + PLANES[row["plane"]], f"g = {row['gravity']}, n = {row['n']}"
        shared = {"size": float(row["n"]), "command": COMMAND, "source": "docs/rod/order_in_n.csv"}
        yield Row("rod-elastica", method, setting, "tip", discretisation=float(row["error"]), **shared)
        yield Row("rod-elastica", method, setting, "angle of the tip", float(row["tip_angle"]), "°", **shared)
    for row in csv_rows(study.DOCS / "order_in_dt.csv"):
        yield Row(
            f"rod-swing, {row['case']}",
            row["scheme"],
            f"dt = {float(row['dt']):g} s",
            "tip",
            discretisation=float(row["error"]),
            step=float(row["dt"]),
            wall_s=float(row["seconds"]),
            command=COMMAND,
            source="docs/rod/order_in_dt.csv",
        )
    for row in csv_rows(study.DOCS / "bending_models.csv"):
        for name in ("invariant_diagonal", "projected_plane", "projected_diagonal"):
            yield Row(
                "rod-bending",
                name.replace("_", ", "),
                f"tip at {float(row['tip_angle']):.0f}°",
                "deflection",
                discretisation=float(row[name]),
                command=COMMAND,
                source="docs/rod/bending_models.csv",
            )
    for row in csv_rows(study.DOCS / "csm.csv"):
        expected, scale = references(FAMILY[row["scene"]]).get(row["quantity"], (None, None))
        found = float(row["value"])
        error = (found - expected) / scale if expected is not None else None
        shared = {"command": COMMAND, "source": "docs/rod/csm.csv"}
        unit = unit_of(row["quantity"])
        yield Row(f"rod-{row['scene']}", "TR-BDF2", row["rod"], row["quantity"], found, unit, expected, error, **shared)


def energies() -> Iterator[Row]:
    """The end of each run of CSM3."""
    ends = {(row["scheme"], row["n"], row["dt"]): row for row in csv_rows(study.DOCS / "csm3_energy.csv")}
    for (scheme, n, dt), row in ends.items():
        for name, quantity, unit in (
            ("energy", "energy at the end", "largest energy in gravity"),
            ("highest", "highest energy", "largest energy in gravity"),
            ("halvings", "halvings", "1"),
            ("time", "reached", "s"),
        ):
            yield Row(
                "rod-energy",
                scheme,
                f"n = {n}, dt = {dt} s",
                quantity,
                float(row[name]),
                unit,
                size=float(n),
                step=float(dt),
                command=COMMAND,
                source="docs/rod/csm3_energy.csv",
            )


def costs() -> Iterator[Row]:
    """Condition numbers, and what an iteration costs."""
    shared = {"command": COMMAND, "source": "docs/rod/condition.csv"}
    for (k_e, dt), group in grouped(csv_rows(study.DOCS / "condition.csv"), "k_e", "dt").items():
        for row, printed in zip(group, study.THESIS_CONDITION[float(k_e), float(dt)]):
            full, setting = float(row["full"]), f"k_e = {k_e}, dt = {dt} s, n = {row['n']}"
            size = float(row["n"])
            yield Row(
                "rod-condition",
                "full",
                setting,
                "1-norm",
                full,
                "1",
                printed,
                full / printed - 1,
                size=size,
                **shared,
            )
            eliminated = float(row["eliminated"])
            yield Row(
                "rod-condition", "velocities eliminated", setting, "1-norm", eliminated, "1", size=size, **shared
            )
    shared = {"command": COMMAND, "source": "docs/rod/runtime.csv"}
    for row in csv_rows(study.DOCS / "runtime.csv"):
        setting, size = f"n = {row['n']}", float(row["n"])
        for name in ("iteration_2d", "iteration_3d", *study.SOLVERS):
            if row[name]:
                micro = float(row[name]) * 1e6
                yield Row("rod-cost", name, setting, "time of one", micro, "µs", size=size, **shared)
        numbers = {name: number(cell) for name, cell in row.items()}
        for name in study.SOLVERS:
            seconds = study.run_seconds(numbers, name)
            if seconds:
                yield Row("rod-run", name, setting, f"{study.STEPS} steps", seconds, "s", size=size, **shared)
        for name in ("sparse", "dense"):
            if row[f"thesis_{name}"]:
                seconds = float(row[f"thesis_{name}"])
                yield Row("rod-run", f"thesis, {name}", setting, "run", seconds, "s", size=size, source="cited")


def maps() -> Iterator[Row]:
    """Stiff cells and situations: gain of energy, and time of the longest step."""
    for row in csv_rows(study.DOCS / "extreme.csv"):
        setting = ", ".join(f"{name} = {float(row[name]):g}" for name in ("n", "k_e", "EI", "dt"))
        shared = {"size": float(row["n"]), "step": float(row["dt"]), "source": "docs/rod/extreme.csv"}
        yield Row("map rod", "TR-BDF2", setting, "gain of energy", **ended(row), **shared)
    for row in csv_rows(study.DOCS / "situations.csv"):
        shared = {"source": "docs/rod/situations.csv"}
        yield Row("map rod situations", row["scheme"], row["situation"], "gain of energy", **ended(row), **shared)


def ended(row: dict[str, str]) -> dict:
    """Outcome, reason and gain: a gain of energy is what a rod must not have without saying so."""
    found = {"wall_s": float(row["worst_step_seconds"]), "command": COMMAND}
    if row["result"] == "ok":
        return found | {"value": float(row["gain"]), "unit": "largest energy"}
    bad = row["result"].startswith("gain")
    return found | {"outcome": "bad" if bad else "error", "reason": row["result"]}


# Values


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    def of_study(key: str, found: float, form: str, unit: str = "1") -> tuple[str, Value]:
        return f"rod.{key}", Value(found, form, unit, COMMAND)

    def least_and_most(key: str, found: list[float], form: str) -> Iterator[tuple[str, Value]]:
        yield of_study(f"{key}.least", min(found), form)
        yield of_study(f"{key}.most", max(found), form)

    def slope(found: Rows, field: str) -> float:
        return exponent([row.size or row.step for row in found], [getattr(row, field) for row in found])

    pushed = rows.of("rod-swing, soft rod, pushed")
    orders = []
    for scheme in SCHEMES:
        group = sorted((row for row in pushed if row.method == scheme), key=lambda row: -row.step)
        orders.append(slope(Rows(group[2:7]), "discretisation"))
    yield from least_and_most("order_dt", orders, ".2f")

    def energy(scheme: str, setting: str, quantity: str = "energy at the end") -> Row:
        return rows.one("rod-energy", scheme, setting, quantity)

    fine, coarse = "n = 32, dt = 0.01 s", "n = 32, dt = 0.02 s"
    yield "rod.energy.bdf2", value(energy("BDF2", fine), ".1f", "%", -100)
    yield "rod.energy.tr_bdf2", value(energy("TR-BDF2", fine), ".2f", "%", -100)
    resolved = [energy("trapezoid", setting, "highest energy") for setting in (fine, "n = 128, dt = 0.01 s")]
    yield "rod.trapezoid.highest", value(max(resolved, key=lambda row: row.value), ".1e")
    yield "rod.trapezoid.held", value(energy("trapezoid", coarse, "highest energy"), ".2f", "%", 100)
    yield "rod.trapezoid.halvings", value(energy("trapezoid", coarse, "halvings"), ".0f")
    yield "rod.unwatched.reached", value(energy("trapezoid, unwatched", coarse, "reached"), ".0f")
    yield "rod.unwatched.gain", value(energy("trapezoid, unwatched", coarse), ".0f", "%", 100)

    full = {row.setting: row for row in rows.of("rod-condition", method="full")}
    ratios = [1 + row.error for setting, row in full.items() if setting.startswith("k_e = 100000, dt = 0.001 ")]
    yield from least_and_most("condition", ratios, ".2f")
    yield of_study("condition.stiff", 1 + full["k_e = 200000, dt = 0.001 s, n = 32"].error, ".2f")
    yield of_study("condition.long", 1 + full["k_e = 100000, dt = 0.01 s, n = 512"].error, ".2f")
    eliminated = {row.setting: row.value for row in rows.of("rod-condition", method="velocities eliminated")}
    for key, dt in (("short", "0.001"), ("long", "0.01")):
        smaller = [row.value / eliminated[setting] for setting, row in full.items() if f"dt = {dt} " in setting]
        yield of_study(f"condition.eliminated.{key}", min(smaller), ".0f")

    def micro(name: str, n: int = 1024) -> float:
        return rows.one("rod-cost", name, f"n = {n}", "time of one").value

    yield "rod.run.banded", value(rows.one("rod-run", "banded", "n = 1024", f"{study.STEPS} steps"), ".1f")
    yield "rod.run.thesis", value(rows.one("rod-run", "thesis, sparse", "n = 1024", "run"), ".0f")
    yield of_study("cost.3d", micro("iteration_3d") / 1e3, ".2f", "ms")
    yield of_study("cost.2d", micro("iteration_2d") / 1e3, ".2f", "ms")
    yield of_study("cost.banded", micro("banded") / 1e3, ".3f", "ms")
    yield of_study("cost.3d_to_2d", micro("iteration_3d") / micro("iteration_2d"), ".2f")
    yield of_study("cost.sparse_to_banded", micro("sparse") / micro("banded"), ".1f")
    late = [row for row in rows.of("rod-cost", method="iteration_3d") if row.size >= 64]
    yield of_study("cost.exponent", slope(late, "value"), ".2f")

    def elastica(method: str, gravity: str, *segments: int) -> Rows:
        return Rows(rows.one("rod-elastica", method, f"g = {gravity}, n = {n}", "tip") for n in segments)

    exact = [method + plane for method in CALIBRATIONS for plane in PLANES.values()]
    for key, gravity in WEIGHTS.items():
        largest = max((elastica(method, gravity, 128)[0] for method in exact), key=lambda row: row.discretisation)
        yield f"rod.elastica.{key}", value(largest, ".1e", "deflection", field="discretisation")
        angle = rows.one("rod-elastica", exact[0], f"g = {gravity}, n = 128", "angle of the tip")
        yield f"rod.elastica.{key}.angle", value(angle, ".0f")
    found = [-slope(elastica(method, g, 32, 64, 128), "discretisation") for method in exact for g in WEIGHTS.values()]
    yield from least_and_most("elastica.order", found, ".2f")
    off = elastica("thesis k_e=1e3", "0.7", 32)[0]
    yield "rod.elastica.thesis", value(off, ".0f", "%", 100, "discretisation")
    off = slope(elastica("thesis k_e=1e6", "0.7", 32, 64, 128), "discretisation")
    yield of_study("elastica.thesis.order", -off, ".2f")
    for angle in (14, 48):
        row = rows.one("rod-bending", "projected, diagonal", f"tip at {angle}°", "deflection")
        yield f"rod.projected.{angle}", value(row, f".{1 if angle == 14 else 0}f", "%", -100, "discretisation")

    cells = rows.of("map rod")
    yield of_study("extreme.cells", len(cells), "d")
    yield of_study("extreme.ok", sum(row.outcome == "ok" for row in cells), "d")
    yield of_study("extreme.gain", max(row.value for row in cells if row.outcome == "ok"), ".1e", "largest energy")
    yield of_study("extreme.longest", max(row.wall_s for row in cells), ".2f", "s")
    cells = rows.of("map rod situations")
    yield of_study("situations.cells", len(cells), "d")
    yield of_study("situations.ok", sum(row.outcome == "ok" for row in cells), "d")
    yield of_study("situations.bad", sum(row.outcome == "bad" for row in cells), "d")
    for key, chosen in (("trapezoid", {"trapezoid"}), ("dissipative", set(SCHEMES) - {"trapezoid"})):
        gains = [row.value for row in cells if row.outcome == "ok" and row.method in chosen]
        yield of_study(f"situations.{key}", max(gains), ".1e", "largest energy")

    def against(scene: str, rod: str, quantity: str) -> Row:
        return rows.one(f"rod-{scene}", "TR-BDF2", rod, quantity)

    shipped, without = "as shipped", "without shear and set-back"
    for key, rod in (("shipped", shipped), ("without", without)):
        for quantity in ("tip_ux.mean", "tip_uy.mean"):
            yield f"rod.csm1.{key}.{quantity}", value(against("csm1", rod, quantity), ".2f", "%", 100, "error")
    published = [row for row in rows.of("rod-csm3", setting=without) if row.error is not None]
    most = max(published, key=lambda row: abs(row.error))
    yield "rod.csm3.without.most", value(most, ".2f", "%", 100 if most.error > 0 else -100, "error")
    for quantity in ("tip_uy.frequency_hz", "tip_uy.amplitude", "tip_ux.amplitude", "tip_uy.mean"):
        yield f"rod.csm3.shipped.{quantity}", value(against("csm3", shipped, quantity), "+.1f", "%", 100, "error")
    for key, rod in (("shipped", shipped), ("without", without)):
        yield f"rod.csm3.{key}.highest", value(against("csm3", rod, "tip_uy.highest"), ".2f", "mm", 1e3)
    above = sum(against("csm3", shipped, f"tip_uy.{what}").reference for what in ("mean", "amplitude"))
    yield "rod.csm3.published.highest", Value(1e3 * above, ".1f", "mm", "")

    clamps = rows.of("rod-clamp", quantity="shear factor")
    finest = [row for row in clamps if row.setting.endswith("36 x 8")]
    worst = max(finest, key=lambda row: abs(row.error))
    yield "rod.clamp.shear", value(worst, ".1e", "1", field="error")
    row = rows.one("rod-clamp", "cylinder, R = 2.5 h", "nu = 0.4, 36 x 8", "set-back by the moment")
    yield "rod.clamp.cylinder", value(row, ".3f")
    yield "rod.clamp.bar", value(row, ".2f", "mm", 20)


# Tables


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {"rod-schemes": lambda: schemes(rows), "rod-csm": lambda: csm(rows)}


def schemes(rows: Rows) -> list[str]:
    """What the schemes do to the energy."""

    def energy(scheme: str, setting: str) -> str:
        found = {row.quantity: row.value for row in rows.of("rod-energy", method=scheme, setting=setting)}
        halved = f", {found['halvings']:.0f} halvings" if found["halvings"] else ""
        ended = f", ended at {found['reached']:.0f} s" if found["reached"] < 59 else ""
        return f"{found['energy at the end']:+.1e}{halved}{ended}"

    table = []
    for scheme, solves in {"trapezoid, unwatched": 1, **SCHEMES}.items():
        cells = rows.of("map rod situations", method=scheme)
        count = f"{sum(row.outcome == 'ok' for row in cells)} of {len(cells)}" if cells else ""
        others = (f"{row.setting.split(':')[0]}: {row.reason.split(' in step')[0]}" for row in cells if row.reason)
        settings = (f"n = 32, dt = {dt} s" for dt in ("0.01", "0.02"))
        table.append([scheme, solves, *(energy(scheme, setting) for setting in settings), count, "; ".join(others)])
    header = ["scheme", "solves a step", "energy after 60 s of CSM3, n = 32, dt = 0.01 s", "dt = 0.02 s"]
    return markdown([*header, "situations that end well", "the others"], table)


def csm(rows: Rows) -> list[str]:
    """Against Turek & Hron."""
    names = {"tip_ux": "ux", "tip_uy": "uy"}
    table = []
    for scene in ("csm1", "csm3"):
        for row in rows.of(f"rod-{scene}", setting="as shipped"):
            if row.reference is None:
                continue
            other = rows.one(f"rod-{scene}", row.method, "without shear and set-back", row.quantity)
            name, _, what = row.quantity.partition(".")
            scale, unit, digits = (1, "Hz", 4) if row.unit == "Hz" else (1e3, "mm", 3)
            cells = [f"{scale * run.value:.{digits}f} ({100 * run.error:+.2f} %)" for run in (row, other)]
            label = f"{scene.upper()}, {names[name]}, {what.replace('_hz', '')}, {unit}"
            table.append([label, f"{scale * row.reference:.{digits}f}", *cells])
    return markdown(["", "Turek & Hron", "as shipped", "without shear and set-back"], table)


def pages() -> dict[Path, str]:
    return study.pages()
