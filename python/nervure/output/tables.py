"""Table of a run in the terminal: its quantities beside published values."""

from dataclasses import fields

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from nervure.output import axis_label, displayed_unit
from nervure.scene.types import Display
from nervure.simulation.summary import Published, Summary


def print_table(console: Console, summary: Summary, display: Display | None = None) -> None:
    """Print quantities, published values, window and cost of a run; `display` is the key of its scene."""
    known = summary.coefficients is not None and bool(summary.coefficients.reference)
    known |= any(quantity.reference is not None for quantity in summary.quantities.values())
    compared = known and summary.not_compared is None
    shown = ("computed", "reference", "difference") if compared else ("computed",)
    headings = (Column(heading, justify="right") for heading in shown)
    table = Table("quantity", *headings, title=summary.scene)

    def row(label: str, value: float | None, expected: float | None, digits: int, scale: float = 1.0) -> None:
        cells = [f"{v * scale:.{digits}g}" if v is not None else "–" for v in (value, expected)]
        apart = f"{(value / expected - 1) * 100:+.1f} %" if value is not None and expected else ""
        table.add_row(escape(label), *[*cells, apart][: len(shown)])

    for name, quantity in summary.quantities.items():
        unit, scale = displayed_unit(quantity.unit, display)
        published = quantity.reference or Published()
        row(axis_label(f"{name} mean", unit), quantity.mean, published.mean, 4, scale)
        row(axis_label(f"{name} amplitude", unit), quantity.amplitude, published.amplitude, 4, scale)
        per_time = f"1/{display.time}" if display else "Hz"
        row(f"{name} frequency [{per_time}]", quantity.frequency_hz, published.frequency_hz, 4)
    if found := summary.coefficients:
        for name, value in found.values.items():
            row(name.replace("_", " "), value, found.reference.get(name), 6)
    rods = {f"{name} ": (own.flapping, own.interface) for name, own in (summary.rods or {}).items()}
    rods = rods or {"": (summary.flapping, summary.interface)}
    for name, (flapping, _) in rods.items():
        for field in fields(flapping) if flapping else ():
            value = getattr(flapping, field.name)
            if isinstance(value, float):
                row(name + field.name.replace("_", " "), value, None, 4)
    console.print(table)
    if summary.not_compared is not None:
        console.print(f"not compared with published values: {summary.not_compared}", markup=False, soft_wrap=True)

    if summary.window_s:
        begin, end = summary.window_s
        drift = summary.amplitude_drift
        steady = "" if drift is None else f", amplitude drift {drift * 100:+.1f} %"
        console.print(f"window {begin:.3f} – {end:.3f} s, {summary.periods} periods{steady}")
    for name, (_, work) in rods.items():
        if work and work.imbalance is not None:
            console.print(
                f"interface: work on the rod {name}{work.work_on_rod:.4g} J, by the fluid {work.work_by_fluid:.4g} J, "
                f"{work.imbalance:+.1%} of {work.exchanged:.4g} J",
                soft_wrap=True,
            )
    phases = ", ".join(f"{phase.replace('_', ' ')} {seconds:.1f} s" for phase, seconds in summary.phases_s.items())
    reached = f"{summary.steps} steps to t = {summary.simulated_s:g} s"
    console.print(f"{reached} in {summary.wall_s:.1f} s of wall time ({phases})", soft_wrap=True)
