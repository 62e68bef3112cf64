"""docs/report and the marked numbers of the documents, from results.json alone."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from nervure.scene import reference
from studies.fsi3 import COSINE, PRESSURE_JUMP
from studies.tables import exponent, markdown

from . import documents, figures, leave_out, topics
from .cases import QUANTITIES, SCHEMES
from .convergence import MOST_ORDER, limit
from .store import DOCS, Row, Value
from .topics import speed
from .topics.fsi3 import GRIDS, SHIPPED, SIMULATED, cells, reference_cells

PEERS = ("PyElastica", "NGSolve, Taylor–Hood")

MAIN = {
    "rod-static": "tip_uy.mean",
    "csm3": "tip_uy.frequency_hz",
    "cylinder-2d1": "cd_mean",
    "cylinder-2d2": "cl_peak_to_peak",
}
"""The quantity by which methods are compared in one line."""


def c_eta_of(setting: str) -> str:
    """C_eta in the name of a case such as `450 x 90, c_eta/curvature-1e-05`."""
    return f"{float(setting.split('/')[-1].split('-', 1)[1]):g}"


def wall_of(row: Row) -> str:
    """Median and quartiles of the wall time, s."""
    return f"{row.wall_s:.3g}" + (
        f" ({row.wall_q1:.3g} – {row.wall_q3:.3g})" if row.wall_q1 and row.repeats != 1 else ""
    )


FSI3_METHODS = {
    "bare profile": "fluid.mask.log_linear.target=none",
    "cosine mask": COSINE,
    "two-thirds filter": "fluid.filter=two_thirds",
    "pressure jump, iterated": PRESSURE_JUMP,
}
"""Changes of FSI3 that have a line of their own beside the shipped scenes."""

PHASES = ("rod", "fluid", "fmi", "python", "recording", "exchange_and_python", "output")


class Report:
    """What the pages are made of."""

    def __init__(self, data: dict):
        self.data, self.rows = data, data["rows"]

        self.of = self.rows.of

    # Pages

    def sequences(self) -> list[list]:
        """Observed order and extrapolation of every sequence of sizes or steps."""
        found = []

        def add(name: str, rows: list[Row], key) -> None:
            for quantity in dict.fromkeys(row.quantity for row in rows):
                part = sorted((row for row in rows if row.quantity == quantity and row.value is not None), key=key)
                part = list({key(row): row for row in part}.values())
                if len(part) < 3:
                    continue
                got = limit(
                    [key(row) for row in part], [row.value for row in part], 8.0 if "NGSolve" in name else MOST_ORDER
                )
                factor, unit = (
                    (1e3, " mm")
                    if part[0].unit == "m"
                    else (1.0, "" if part[0].unit in ("", "1") else f" {part[0].unit}")
                )
                published, extrapolated = (
                    part[0].reference,
                    "" if got.value is None else f"{got.value * factor:.5g}{unit}",
                )
                finest = part[-1]
                discretisation = (
                    "" if got.value is None else f"{100 * (finest.value - got.value) / abs(got.value):+.2f} %"
                )
                model = (
                    ""
                    if got.value is None or not published
                    else f"{100 * (got.value - published) / abs(published):+.2f} %"
                )
                found.append(
                    [
                        name,
                        figures.label(quantity),
                        ", ".join(f"{row.value * factor:.5g}" for row in part),
                        "" if got.order is None else f"{got.order:.2f}",
                        extrapolated,
                        discretisation,
                        model,
                        got.verdict,
                    ]
                )

        for method in ("rod", "rod with shear", "PyElastica"):
            add(f"rod at rest, {method}, n", self.of("rod-static", method=method), lambda row: row.size)
        add("CSM3, n (H = 1 ms)", self.of("csm3", method="TR-BDF2, H = 1 ms"), lambda row: row.size)
        for scheme in SCHEMES:
            add(f"CSM3, 1/H, {scheme} (n = 32)", self.of("csm3", method=scheme), lambda row: 1 / row.step)
        add("CSM3, PyElastica, n", self.of("csm3", method="PyElastica"), lambda row: row.size)
        for case in ("cylinder-2d1", "cylinder-2d2"):
            for mask in ("curvature", "cosine"):
                add(f"{case}, {mask}, nx", self.of(case, method=f"grid: {mask}, sbdf2"), lambda row: row.size)
            add(f"{case}, NGSolve, √dofs", self.of(case, method="NGSolve, Taylor–Hood"), lambda row: row.size**0.5)
        add("cylinder-2d2, 1/step", self.of("cylinder-2d2", method="dt: curvature, sbdf2"), lambda row: 1 / row.step)
        fsi3 = [
            row
            for row in self.of("fsi3", method="momentum load")
            if row.quantity in figures.quantities_of("fsi3") and row.outcome == "ok"
        ]
        add("FSI3, nx", fsi3, lambda row: row.size)
        return found

    def error_time(self) -> list[str]:
        text = ["## 1. Error against run time", ""]
        records = Counter(row.machine for row in self.rows if row.source == "measured")
        machine = self.data["machine"][records.most_common(1)[0][0]]
        text += [
            f"Measured on {machine['cpu']}, {machine['cores']} cores, {machine['system']}, "
            f"{machine['rustc'].split(' (')[0]}, Python {machine['python']}; one thread. Wall and CPU time of the "
            f"loop over the steps, medians "
            "of repeats after a warm-up, bars from quartile to quartile. The machine was shared with other work: "
            "**CPU time is the one to "
            "compare**; wall times of rows from the studies are of other days. PyElastica's "
            "and NGSolve's times "
            "include what they need to set up, and not imports and compilation.",
            "",
        ]
        for case, title, kind in (
            (
                "rod-static",
                "The rod at rest (CSM1's bar without the set-back of the clamp) against the exact beam of Reissner: "
                "discretisation error",
                "discretisation",
            ),
            ("rod-static", "The same against CSM1 of Turek and Hron: discretisation and model error together", "error"),
            ("csm3", "CSM3, the swinging bar, against Turek and Hron", "error"),
            ("cylinder-2d1", "The cylinder 2D-1", "error"),
            ("cylinder-2d2", "The cylinder 2D-2", "error"),
            ("fsi3", "FSI3", "error"),
        ):
            name = f"{case.replace('-', '_')}_{kind}.png"
            rows = self.plotted(case)
            self.draw(figures.error_time, name, rows, figures.quantities_of(case), kind)
            failed = sorted({(row.method, row.setting, row.reason[:120]) for row in rows if row.outcome != "ok"})
            text += [f"**{title}**", "", f"![{title}]({name})", ""]
            text += [f"- failed: {method}, {setting}: {reason}" for method, setting, reason in failed] + [""] * bool(
                failed
            )
        text += ["Best of each method, by CPU time where it was measured:", "", *self.best(), ""]
        text += [
            "### Orders and extrapolations",
            "",
            "Order and extrapolation are those of the last three values. *Discretisation* is the finest value against "
            "the extrapolated "
            "one, *model* the extrapolated one against the published value: for the cylinder what penalization "
            "leaves, for the rod what a beam "
            "is not of a two-dimensional body. Where a sequence is not asymptotic there is no extrapolation.",
            "",
        ]
        header = ["sequence", "quantity", "values", "order", "extrapolated", "discretisation", "model", "verdict"]
        text += [*markdown(header, self.sequences()), "", *self.penalization(), ""]
        return text

    def penalization(self) -> list[str]:
        """Errors of 2D-2 over C_eta, grid and step held."""
        names, table = QUANTITIES["cylinder-2d2"], []
        for method in ("curvature", "cosine", "sharp"):
            rows = self.of("cylinder-2d2", method=f"c_eta: {method}, sbdf2")
            for setting in dict.fromkeys(row.setting for row in rows):
                found = {row.quantity: row for row in rows if row.setting == setting}
                errors = [f"{100 * found[name].error:+.2f} %" if name in found else "" for name in names]
                table.append([method, setting.split(", ")[0], c_eta_of(setting), *errors])
        return [
            "The model error of penalization alone, 2D-2 over C_eta on one grid with one step:",
            "",
            *markdown(["mask", "grid", "C_eta, s", *map(figures.label, names)], table),
            "",
            "CSM3's mean and amplitude are the extremes of a motion with several modes: they jump from one crest to "
            "another with step and n, which is why its sequences do not settle. On the cylinder the wall keeps its "
            "place within a few hundredths of a cell only ([fluid.md](../fluid.md)), and differently on each grid.",
        ]

    def plotted(self, case: str) -> list[Row]:
        if case == "fsi3":
            rows = [row for row in self.of("fsi3") if row.method in ("momentum load", "FLUSI")]
            for name, change in FSI3_METHODS.items():
                changed = self.of("fsi3", method="one change")
                rows += [replace(row, method=name) for row in changed if row.setting.endswith(f", {change}")]
            return rows
        rows = self.of(case)
        if case.startswith("cylinder"):
            others = ("grid: cosine, s", "grid: none", "thesis", *PEERS)
            return [row for row in rows if row.method.startswith(others)] + self.wall_target(case)
        return rows

    def wall_target(self, case: str) -> list[Row]:
        """The shipped mask over the grid, from the fluid's study."""
        rows = self.of(case, method="grid: curvature, sbdf2")
        return [replace(row, method="wall target", setting=row.setting.split(",")[0]) for row in rows]

    def best(self) -> list[str]:
        table = []
        for case in ("rod-static", "csm3", "cylinder-2d1", "cylinder-2d2"):
            main = MAIN[case]
            plotted = [row for row in self.plotted(case) if row.quantity == main and row.error is not None]
            for method in dict.fromkeys(row.method for row in plotted):
                rows = [row for row in plotted if row.method == method]
                if rows:
                    kind = "discretisation" if rows[0].discretisation is not None else "error"
                    row = min(rows, key=lambda row: abs(getattr(row, kind)))
                    table.append(
                        [
                            case,
                            method,
                            row.setting,
                            figures.label(main),
                            f"{100 * getattr(row, kind):+.3f} %",
                            kind,
                            f"{row.cpu_s:.3g}" if row.cpu_s else "",
                            wall_of(row),
                            row.repeats or 1,
                        ]
                    )
        return markdown(["case", "method", "setting", "quantity", "error", "of", "CPU, s", "wall, s", "runs"], table)

    def fsi3(self) -> list[str]:
        self.draw(
            figures.bands,
            "fsi3_bands.png",
            {g: self.data["series"][g] for g in SHIPPED if g in self.data["series"]},
            reference("fsi3")["spread"]["quantities"],
        )
        rows = [["FeatFlow, level 4", *reference_cells(), ""]]
        for grid in GRIDS:
            row = next(iter(self.of("fsi3", method="momentum load", setting=grid, quantity="tip_uy.amplitude")), None)
            if row:
                rows.append([grid, *cells(self.rows, grid), f"{row.cpu_s / SIMULATED:.1f}"])
        text = [
            "### FSI3 in the reference bands",
            "",
            *markdown(["", "ux", "uy", "drag", "lift", "CPU s a simulated s"], rows),
            "",
            "Mean ± amplitude [frequency], mm, N/m, Hz. What one change at a time does is in [fsi3.md](../fsi3.md).",
            "",
            "![two periods](fsi3_bands.png)",
            "",
            "Vorticity at four phases of a period, 325 x 72 (`make report-pictures`):",
            "",
            "![four phases](fsi3_phases.png)",
            "",
            "![animation](fsi3_vorticity.gif)",
            "",
        ]
        table = [
            [
                f"{row.method}, {row.setting}",
                ""
                if row.value is None
                else f"{row.value * (1e3 if row.unit == 'm' else 1):.3g} {'mm' if row.unit == 'm' else row.unit}",
                f"{row.wall_s / SIMULATED:g}",
            ]
            for row in self.of("fsi3", source="cited")
        ]
        text += [
            "Other solvers, as cited (not measured here, other machines):",
            "",
            *markdown(["", "value", "wall s a simulated s"], table),
            "",
        ]
        return text

    def stability(self) -> list[str]:
        self.draw(figures.maps, "maps.png", self.rows)
        text = ["## 2. Stability on stiff and extreme cases", "", "![maps](maps.png)", ""]
        table, bad = [], []
        for name, what in (
            ("map rod", "stiffness, bending, segments and step"),
            ("map rod situations", "snap, folding back, buckling, blows"),
            ("map fluid", "Reynolds number, CFL number, C_eta, scheme, mask, hard scenes"),
            ("map coupling", "density ratio, C_eta, communication step, scheme"),
        ):
            rows = self.of(name)
            count = Counter(row.outcome for row in rows)
            table.append([name, what, len(rows), count["ok"], count["error"], count["bad"], rows[0].source])
            bad += [[name, row.method, row.setting, row.reason] for row in rows if row.outcome == "bad"]
        text += [
            *markdown(["map", "over", "cells", "ok", "error", "bad", "from"], table),
            "",
            "*ok*: it went to the end and what came out is sound; *error*: it stopped and said why; *bad*: neither. "
            "Every cell with its "
            "reason is in [results.csv](results.csv).",
            "",
            f"Bad cells are left: {len(bad)}.",
            "",
            *((*markdown(["map", "method", "cell", "why"], bad), "") if bad else ()),
        ]
        errors = [
            [row.case, row.method, row.setting, row.reason[:110]]
            for row in self.rows
            if row.case.startswith("map") and row.outcome == "error"
        ]
        page = [
            "# Cells that ended in an error",
            "",
            "From results.json; reasons are cut after 110 characters there they are longer in results.csv.",
            "",
            *markdown(["map", "method", "cell", "reason"], errors),
        ]
        self.write("stability.md", page)
        return [*text, "The cells that ended in an error: [stability.md](stability.md).", ""]

    def leave_out(self) -> list[str]:
        text = [
            "## 3. What a scene leaves out",
            "",
            *markdown(
                ["scene", "has not"],
                [[row.method, row.reason] for row in self.of(leave_out.CASE, quantity="absent parts")],
            ),
            "",
            "None of these has a variable, an array or a loop there. Each of the following parts is put into the "
            "scene so that it has no effect; the numbers are what it adds to XML, variables, memory (growth of the "
            "resident "
            "set), and CPU time a step (one and the same scene gives up to a fifth more or less on this machine), and "
            "the "
            "largest relative change of tip and forces. The library is the same file for every scene: a "
            "part that is left out saves nothing of the binary's size.",
            "",
        ]
        table = []
        for scene in dict.fromkeys(row.method for row in self.of(leave_out.CASE)):
            rows = self.of(leave_out.CASE, method=scene)
            for setting in dict.fromkeys(row.setting for row in rows):
                found = {row.quantity: row for row in rows if row.setting == setting}
                if "all" in found:
                    table.append([scene, setting, "refused: " + found["all"].reason[:80], "", "", "", ""])
                    continue
                shipped, value = setting == "as shipped", {k: row.value for k, row in found.items()}
                change = (
                    ""
                    if shipped
                    else "none"
                    if value["change of the result"] == 0
                    else f"{value['change of the result']:.0e}"
                )
                table.append(
                    [
                        scene,
                        setting,
                        f"{value['xml'] / 1e3:{'' if shipped else '+'}.1f} kB",
                        f"{value['variables']:{'' if shipped else '+'}.0f}",
                        f"{value['memory']:{'' if shipped else '+'}.1f} MB",
                        f"{value['cpu per step']:.1f} µs" if shipped else f"{100 * value['cpu per step']:+.0f} %",
                        change,
                    ]
                )
        header = ["scene", "part", "XML", "variables", "memory", "CPU a step", "change of the result"]
        return [
            *text,
            *markdown(header, table),
            "",
            "Not comparable this way, because they cannot be there without an effect: a second beam (a scene has "
            "one), a beam beside the flow "
            "(it is a body wherever it stands), inflow together with mean flow (refused), a filter that does nothing, "
            "shear of a rod in space "
            "(the model is for the plane).",
            "",
        ]

    def cost(self) -> list[str]:
        groups = {}
        fluid = [(row.size, row.value) for row in self.of("cost of a fluid step", quantity="step")]
        rod = [(row.size, row.value) for row in self.of("rod-cost", method="iteration_2d") if row.size >= 64]
        groups["a step of the fluid"] = ("points of the grid", fluid)
        groups["a Newton iteration of the rod in the plane"] = ("segments n", rod)
        for title, quantity, method, x in (
            ("a step of FSI3, all of it", "step", "grid", "points of the grid"),
            ("a step of FSI3, the rod's part", "rod", "stations", "segments"),
        ):
            points = [(row.size, row.value) for row in self.of("cost", method=method, quantity=quantity)]
            if points:
                groups[title] = (x, points)
        bar = speed.found(self.rows, "motion")["fsi3-650x144", "650 x 144"]
        groups["the bar in a step of the fluid, 650 x 144"] = ("cells that its stations move in it", speed.moved(bar))
        self.draw(figures.cost, "cost.png", groups)
        text = [
            "## Where the time goes",
            "",
            "![cost](cost.png)",
            "",
            "Fitted exponents: "
            + "; ".join(f"{name} {exponent(*zip(*points)):.2f} in the {x}" for name, (x, points) in groups.items())
            + " ([fluid-speed.md](../fluid-speed.md) has more).",
            "",
        ]
        text += [
            "A Newton iteration of the rod (residual, matrix, solve, update), and the banded solve in it, µs (`make "
            "rod-study`):",
            "",
            *markdown(["n", "in space", "of that the solve", "in the plane"], self.iterations()),
            "",
        ]
        text += [
            "A step of the fluid, bars swinging (`make bench-fluid`), µs of processor time, and shares:",
            "",
            *speed.phases(self.rows),
            "",
        ]
        table = []
        for method, setting in dict.fromkeys((row.method, row.setting) for row in self.of("cost")):
            found = {row.quantity: row.value for row in self.of("cost", method=method, setting=setting)}
            parts = ("step", "rod", "fmi", "python", "recording")
            table.append([method, setting, *(f"{found[part]:.1f}" if part in found else "" for part in parts)])
        text += [
            "A step of FSI3 by number of stations (325 x 72 points), with the bar still, and by grid (steps of 0.1 "
            "ms), µs: median CPU time of the step, shortest wall times of its parts; "
            "the rest is the fluid:",
            "",
            *markdown(["varied", "setting", "step", "rod", "FMI", "Python", "recording"], table),
            "",
        ]
        table = []
        for case in ("rod-static", "csm3", "cylinder-2d1", "cylinder-2d2", "fsi3"):
            for setting in dict.fromkeys((row.method, row.setting) for row in self.of(f"phases {case}")):
                if case == "fsi3" and setting[1] not in GRIDS or case == "csm3" and "0.001" not in setting[1]:
                    continue
                found = {
                    row.quantity: row.value for row in self.of(f"phases {case}", method=setting[0], setting=setting[1])
                }
                table.append(
                    [
                        case,
                        *setting,
                        *(f"{100 * found[k]:.1f} %" if k in found else "" for k in PHASES),
                    ]
                )
        text += [
            "Of a run, by the wall time of its loop: the units' steps; their inputs and outputs through FMI (with the "
            "pressure of probes, which is made when it is read); the master's own Python; the table that it keeps; and, "
            "after the loop, writing the tables. Runs of the study have the middle three as one, exchange and Python:",
            "",
            *markdown(["case", "method", "setting", *(phase.replace("_", " ") for phase in PHASES)], table),
            "",
        ]
        return text

    def iterations(self) -> list[list]:
        found = {(row.method, row.size): row.value for row in self.of("rod-cost")}
        sizes = sorted(size for method, size in found if method == "banded")
        methods = ("iteration_3d", "banded", "iteration_2d")
        return [[f"{size:.0f}", *(f"{found[method, size]:.3g}" for method in methods)] for size in sizes]

    def beaten(self) -> list[str]:
        """CPU time of ours and of the peers for the largest error over all quantities of a case: a single one may
        pass through zero."""
        lines = []
        for case in MAIN:
            kind = "discretisation" if case == "rod-static" else "error"
            worst: dict[tuple[str, str], tuple[float, float]] = {}
            for row in self.plotted(case):
                if row.cpu_s and "thesis" not in row.method and getattr(row, kind) is not None:
                    error = abs(getattr(row, kind))
                    worst[row.method, row.setting] = (
                        max(error, worst.get((row.method, row.setting), (0.0, 0.0))[0]),
                        row.cpu_s,
                    )
            peers = [(error, cpu, *name) for name, (error, cpu) in worst.items() if name[0] in PEERS]
            ours = [(error, cpu, *name) for name, (error, cpu) in worst.items() if name[0] not in PEERS]
            if not peers or not ours:
                continue

            def said(run: tuple) -> str:
                return f"{run[2]} ({run[3]}) {100 * run[0]:.2g} % in {run[1]:.2g} s"

            best = min(peers)
            # The cheapest of ours that is at least as exact, or else the most exact one.
            enough = [run for run in ours if run[0] <= best[0]]
            mine = min(enough, key=lambda run: run[1]) if enough else min(ours)
            if not enough:
                verdict = "**ours does not reach the peer's error on any grid here**"
            elif mine[1] < best[1]:
                share = best[1] / mine[1]
                verdict = f"ours is at least as exact in 1/{share:.{0 if share > 10 else 1}f} of the CPU time"
            else:
                verdict = f"ours needs {mine[1] / best[1]:.1f} times the CPU time for that error"
            lines.append(f"- {case}: {said(best)}; {said(mine)}: {verdict}.")
        return lines

    def errors(self, case: str) -> str:
        """Errors on the finest grid that was measured."""
        rows = self.wall_target(case)
        finest = max(row.size for row in rows)
        return ", ".join(
            f"{figures.label(row.quantity)} {100 * row.error:+.2f} %" for row in rows if row.size == finest
        )

    def missed(self) -> list[str]:
        """What is not met, from the numbers."""
        bad = sum(row.outcome == "bad" for row in self.rows if row.case.startswith("map"))
        finest = {row.quantity: row for row in self.of("fsi3", method="momentum load", setting="1300 x 288")}
        off = [f"{figures.label(q)} {100 * row.error:+.1f} %" for q, row in finest.items() if row.error is not None and abs(row.error) > 0.02]
        sequences = self.sequences()
        loose = [row for row in sequences if row[-1].startswith("not")]
        timed = {(row.case, row.method, row.setting): row for row in self.rows if row.cpu_s}.values()
        once = [row for row in timed if (row.repeats or 1) < 3]
        lines = [
            f"- FSI3 on 1300 x 288 is more than 2 % from FeatFlow's finest level in: {', '.join(off) or 'nothing'}.",
            f"- {len(loose)} of {len(sequences)} sequences are not asymptotic; where they are not there is no "
            f"extrapolated value.",
            *([f"- {bad} cells of the maps are bad: they went on and said nothing (section 2)."] if bad else []),
            *(
                f"- {case} by penalization, finest grid measured: {self.errors(case)}."
                for case in ("cylinder-2d1", "cylinder-2d2")
            ),
            f"- {len(once)} of {len(timed)} runs with a time were made once: without quartiles.",
            "- FLUSI, deal.II and nutils are cited, not run: they do not install from a registry.",
        ]
        return [
            "## What is missed",
            "",
            *lines,
            "",
            "Beside the peers, measured by the same command on the same machine, largest error over the quantities of "
            "each case (at rest: of "
            "discretisation) and CPU time. "
            "NGSolve solves 2D-1 by Newton's method for the steady flow, where ours marches to it; PyElastica is "
            "explicit and has a step for stability:",
            "",
            *self.beaten(),
            "",
        ]

    def draw(self, drawing: Callable, name: str, *arguments) -> None:
        """Let `drawing` write a figure beside the pages, if there is to be one."""
        if self.drawn:
            drawing(DOCS / name, *arguments)

    def write(self, name: str, lines: list[str]) -> None:
        self.pages[DOCS / name] = "\n".join(lines).rstrip("\n") + "\n"

    def made(self, drawn: bool) -> dict[Path, str]:
        """All pages by their path; figures are written if `drawn`."""
        self.drawn, self.pages = drawn, {}
        head = [
            "# Report",
            "",
            "Error against run time, stability, and what a scene leaves out. `make report` measures the short form and "
            "writes this page, `make report-full` everything. All numbers are in [results.json](results.json) and "
            "[results.csv](results.csv), one row each, with the command that gives it; the marked numbers of the other "
            "documents come from there by `python scripts/report render`.",
            "",
        ]
        parts = (self.missed, self.error_time, self.fsi3, self.stability, self.leave_out, self.cost)
        self.write("README.md", head + [line for part in parts for line in part()])
        return self.pages


def everything(data: dict, check: bool) -> list[Path]:
    """Write what has changed; with `check` only tell. Figures are not compared: other fonts draw other pixels."""
    values = {key: Value(**value) for key, value in data["values"].items()}
    tables = topics.tables(data["rows"])
    texts = {path: documents.filled(path.read_text(encoding="utf-8"), values, tables) for path in documents.DOCUMENTS}
    texts |= topics.pages() | Report(data).made(drawn=not check)
    changed = [path for path, text in texts.items() if not path.is_file() or path.read_text(encoding="utf-8") != text]
    if not check:
        for path in changed:
            path.write_text(texts[path], encoding="utf-8")
    return changed
