"""Table of a run in the terminal: its quantities beside published values, and the coefficients of its bodies."""

from collections.abc import Iterator, Sequence
from dataclasses import fields

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from nervure.coupling.guards import WARN_RATIO
from nervure.evaluate.bodies import ReferenceScales
from nervure.evaluate.statistics import NOISY, Character
from nervure.output import axis_label, displayed_unit, unit_in
from nervure.scene import Scene, wings
from nervure.scene.types import Display
from nervure.simulation.summary import Published, Quantity, Summary
from nervure.units.describe import unit_label

MOST_BODIES = 8  # Bodies whose coefficients are printed
NEAR_ZERO = 0.1  # Mean by amplitude below which the difference of a mean is given by the amplitude

FLAPPING = {
    "power_in": ("power in, cycle mean", "W/m"),
    "thrust": ("thrust, cycle mean", "N/m"),
    "lift": ("lift, cycle mean", "N/m"),
    "side": ("side force, cycle mean", "N/m"),
    "efficiency": ("efficiency", ""),
    "thrust_by_power": ("thrust by power", "s/m"),
    "tip_amplitude": ("tip amplitude", "m"),
    "tip_by_rigid_tip": ("tip by rigid tip", ""),
    "phase_lag_deg": ("phase lag", "deg"),
}
"""Label and unit of the rows of a driven root; forces and power are per metre of depth in two dimensions."""


def difference(value: float | None, expected: float | None, amplitude: float | None = None) -> str:
    """Return the difference from a published value: relative to it, or where it is a mean near zero relative to the
    published amplitude."""
    if value is None or expected is None:
        return ""
    if amplitude and abs(expected) < NEAR_ZERO * abs(amplitude):
        return f"{(value - expected) / abs(amplitude) * 100:+.1f} % of ampl."
    return f"{(value / expected - 1) * 100:+.1f} %" if expected else ""


def _remark(quantity: Quantity) -> str:
    return Character(quantity.state, quantity.drift, quantity.noise).remark()


def print_table(console: Console, summary: Summary, scene: Scene) -> None:
    """Print quantities, published values, window and cost of a run of `scene`, in the units of its pictures."""
    display = scene.display
    known = summary.coefficients is not None and bool(summary.coefficients.reference)
    known |= any(quantity.reference is not None for quantity in summary.quantities.values())
    compared = known and summary.not_compared is None
    shown = ("computed", "reference", "difference") if compared else ("computed",)
    bars = summary.verified or {}
    headings = [Column(heading, justify="right") for heading in (shown[0], *(["± 95 %"] if bars else []), *shown[1:])]
    remarks = {name: _remark(quantity) for name, quantity in summary.quantities.items()}
    noted = any(remarks.values())
    table = Table("quantity", *headings, *([Column("remark")] if noted else []), title=summary.scene)

    def row(
        label: str,
        value: float | None,
        expected: float | None,
        digits: int,
        scale: float = 1.0,
        amplitude: float | None = None,
        remark: str = "",
        column: str = "",
    ) -> None:
        cells = [f"{v * scale:.{digits}g}" if v is not None else "–" for v in (value, expected)]
        cells = [*cells, difference(value, expected, amplitude)][: len(shown)]
        if bars:
            cells.insert(1, f"{bars[column].error * scale:.2g}" if column in bars else "")
        table.add_row(escape(label), *cells, *([escape(remark)] if noted else []))

    for name, quantity in summary.quantities.items():
        unit, scale = unit_in(scene, quantity.unit, abs(quantity.mean) + quantity.amplitude)
        published = quantity.reference or Published()
        mean = axis_label(f"{name} mean", unit)
        row(mean, quantity.mean, published.mean, 4, scale, published.amplitude, remarks[name], f"{name}_mean")
        amplitude = axis_label(f"{name} amplitude", unit)
        row(amplitude, quantity.amplitude, published.amplitude, 4, scale, column=f"{name}_amplitude")
        per_time = displayed_unit("1/s", display)[0] if display else "Hz"
        frequency = f"{name} frequency [{per_time}]"
        row(frequency, quantity.frequency_hz, published.frequency_hz, 4, column=f"{name}_frequency_hz")
    if found := summary.coefficients:
        for name, value in found.values.items():
            row(name.replace("_", " "), value, found.reference.get(name), 6, column=name)
    rods = {
        f"{name} ": (own.flapping, own.interface)
        for name, own in {**(summary.rods or {}), **(summary.wings or {})}.items()
    }
    rods = rods or {"": (summary.flapping, summary.interface)}
    space = any(name.endswith("tip_uz") or name == "side" for name in summary.quantities)
    for name, (flapping, _) in rods.items():
        for field in fields(flapping) if flapping else ():
            value = getattr(flapping, field.name)
            if isinstance(value, float):
                label, unit = FLAPPING[field.name]
                unit, scale = unit_in(scene, unit.removesuffix("/m") if space else unit, abs(value))
                row(axis_label(name + label, unit), value, None, 4, scale)
    console.print(table)
    if any(quantity.noise and quantity.noise > NOISY for quantity in summary.quantities.values()):
        console.print(
            "noise is the part of a signal above six times its frequency; it raises amplitudes, not those of `fit` in "
            "summary.json. Five cells across each moving body that has a thickness lessen it",
            soft_wrap=True,
        )
    if summary.not_compared is not None:
        console.print(f"not compared with published values: {summary.not_compared}", markup=False, soft_wrap=True)

    for line in _coefficients(summary, display):
        console.print(line, markup=False, soft_wrap=True)
    if summary.window_s:
        begin, end = summary.window_s
        drift = summary.amplitude_drift
        steady = "" if drift is None else f", amplitude drift {drift * 100:+.1f} %"
        console.print(f"window {begin:.3f} – {end:.3f} s, {summary.periods} periods{steady}")
    other = "the fluid" if scene.fluid else "contact"
    joule = next((unit for name, unit in summary.series.items() if name.endswith("load_work")), "J")
    for name, (_, work) in rods.items():
        if work and work.imbalance is not None:
            kind = "wing" if scene.wing or name.strip() in wings(scene) else "rod"
            console.print(
                f"interface: work on the {unit_label(name.strip() or kind, kind)} {work.work_on_rod:.4g} {joule}, "
                f"by {other} {work.work_by_fluid:.4g} {joule}, {work.imbalance:+.1%} of "
                f"{work.exchanged:.4g} {joule}{_judge(work.imbalance)}",
                soft_wrap=True,
            )
    phases = ", ".join(f"{phase.replace('_', ' ')} {seconds:.1f} s" for phase, seconds in summary.phases_s.items())
    reached = f"{summary.steps} steps to t = {summary.simulated_s:g} s"
    console.print(f"{reached} in {summary.wall_s:.1f} s of wall time ({phases})", soft_wrap=True)


def _judge(imbalance: float) -> str:
    return f"; more than {WARN_RATIO:.0%} is too much" if abs(imbalance) > WARN_RATIO else ""


def _coefficients(summary: Summary, display: Display | None) -> Iterator[str]:
    """Yield a line for each body: its coefficients, and what they refer to."""
    for name, body in list(summary.bodies.items())[:MOST_BODIES]:
        values = [_value("cD", body.cd_mean, body.cd_amplitude), _value("cL", body.cl_mean, body.cl_amplitude)]
        if body.cs_mean is not None:
            values.append(_value("cS", body.cs_mean, body.cs_amplitude))
        several = {"cT": body.ct, "cP": body.cp, "St": body.st, "KC": body.kc}
        values += [f"{label} {value:.4g}" for label, value in several.items() if value is not None]
        yield "; ".join(
            [f"{name}: {', '.join(values)}", *([_reference(body.reference, display)] if body.reference else [])]
        )
    if (left := len(summary.bodies) - MOST_BODIES) > 0:
        yield f"coefficients of {left} more bodies are in summary.json"


def _value(name: str, mean: float, amplitude: float | None) -> str:
    return f"{name} {mean:.4g}" + (f" ± {amplitude:.2g}" if amplitude else "")


def _reference(own: ReferenceScales, display: Display | None) -> str:
    """Return the scales and directions of coefficients in words."""
    length, scale = ("m", 1.0) if display is None else displayed_unit("m", display)
    speed = "m/s" if display is None else displayed_unit("m/s", display)[0]
    area = "" if own.area is None else f", A {own.area:.4g} {length}²"
    lift = _along(own.lift)
    return f"U {own.speed:.4g} {speed} ({own.speed_of}), L {own.length * scale:.4g} {length}{area}, drag along " + (
        f"{_along(own.drag)}, lift along {lift}"
    )


def _along(direction: Sequence[float]) -> str:
    """Return an axis by its name, another direction by its components."""
    for axis, component in zip("xyz", direction, strict=False):
        if abs(component) > 1 - 1e-9:
            return axis if component > 0 else f"−{axis}"
    return f"[{', '.join(f'{component:.3g}' for component in direction)}]"
