"""What a verification shows: its table, the picture of error over run time, and the recommended scene."""

from collections.abc import Sequence
from pathlib import Path

from pydantic import TypeAdapter
from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from nervure.errors import InputError
from nervure.files import write_whole
from nervure.output import forecast
from nervure.scene import Scene, text
from nervure.simulation.verified import FILE, Quantity, Share, Verified
from nervure.verification.process import Outcome

RECOMMENDED, PICTURE = "recommended.json", "verify.png"
SUFFIX = "-verified"  # Of the name of the recommended scene
LONGEST_NAME = 100  # Characters
NOTHING = 1e-4  # Smallest part that is shown
WIDTH = 130  # Characters of a line where the output is no terminal
DRAWN = 7  # Quantities in the picture


def read(folder: Path) -> Verified:
    """Read the verification in `folder`."""
    try:
        return TypeAdapter(Verified).validate_json((folder / FILE).read_bytes())
    except (OSError, ValueError) as error:
        raise InputError(f"{folder} holds no verification: {FILE}: {error}; `nervure verify` makes it") from error


def write(outcome: Outcome, folder: Path) -> list[Path]:
    """Write the picture and the recommended scene of a verification; return their paths."""
    written = []
    if outcome.recommended:
        scene = outcome.recommended.copy(name=outcome.recommended.name[: LONGEST_NAME - len(SUFFIX)] + SUFFIX)
        path = folder / RECOMMENDED
        write_whole(path, lambda place: place.write_text(text(scene), encoding="utf-8"))
        written.append(path)
    if outcome.verified:
        written.append(_draw(outcome, outcome.verified, folder / PICTURE))
    return written


def print_table(console: Console, verified: Verified) -> None:
    """Print values, limits and bars of all quantities, the errors of the scene by parameter, and what was spent."""
    names = list(dict.fromkeys(name for one in verified.quantities.values() for name in one.shares))
    headings = ("finest", "limit ± 95 %", "± %", "order", *(f"{name} %" for name in names))
    right = (Column(escape(name), justify="right", no_wrap=True) for name in headings)
    table = Table(
        Column("quantity", no_wrap=True),
        *right,
        box=None,
        padding=(0, 1),
        title=f"{verified.scene}: errors of the scene",
    )
    for name, one in verified.quantities.items():
        first, *_ = one.shares.values()
        order = f"{first.order:.1f}" if first.order else "–"
        label = f"{name.removesuffix('_hz').replace('_', ' ')} [{one.unit}]" if one.unit else name.replace("_", " ")
        limit = f"{one.limit:.4g} ± {one.uncertainty:.2g}"
        shares = (_share(one, one.shares.get(parameter)) for parameter in names)
        table.add_row(
            escape(label), f"{one.value:.4g}", limit, _percent(one.uncertainty / one.scale)[:-2], order, *shares
        )
    if not console.is_terminal:
        console.width = WIDTH
    console.print(table)
    reached = "all within" if verified.reached else "not all within"
    spent = forecast.duration(verified.wall_s)
    said = f"{reached} {_percent(verified.within)}; {verified.runs} runs of {spent}"
    console.print(said, markup=False, soft_wrap=True)


def print_outcome(console: Console, outcome: Outcome, folder: Path, written: Sequence[Path]) -> None:
    """Print all that a verification found, and where it is."""
    for problem in outcome.problems:
        console.print(problem, markup=False, soft_wrap=True)
    if (verified := outcome.verified) is None:
        return
    print_table(console, verified)
    if outcome.recommended and verified.recommended_wall_s is not None and verified.recommended_error is not None:
        far = verified.recommended_error > verified.within
        console.print(
            f"{'best within the budget' if far else 'recommended'}: {setting(outcome.recommended)}: errors up to "
            f"{_percent(verified.recommended_error)}, about {forecast.duration(verified.recommended_wall_s)}: "
            f"`nervure run {folder / RECOMMENDED}`",
            markup=False,
            soft_wrap=True,
        )
        if far and (better := [one for one in outcome.front if one[1] < verified.recommended_error]):
            wall, error = min(better, key=lambda one: one[1])
            console.print(f"finer ones: errors up to {_percent(error)} in {forecast.duration(wall)}", soft_wrap=True)
    console.print(f"table in {folder / FILE}, " + ", ".join(map(str, written)), markup=False, soft_wrap=True)


def setting(scene: Scene) -> str:
    """Return the numerical setting of a scene in words."""
    parts = []
    if fluid := scene.fluid:
        parts.append(f"{' x '.join(map(str, fluid.box.cells))} cells")
        (mask,) = fluid.mask.document().values()
        parts.append(f"c_eta {mask['c_eta']:.3g} s")
    if scene.beam or scene.rods:
        counts = [scene.beam.segments] if scene.beam else [own.beam.segments for own in scene.rods]
        parts.append(f"{', '.join(map(str, dict.fromkeys(counts)))} segments")
    return ", ".join([*parts, f"steps of {scene.time.communication_step:.3g} s"])


def _share(quantity: Quantity, share: Share | None) -> str:
    """Return the error by a parameter at the size of the scene, relative to the value, %; without one its bar."""
    if share is None:
        return "–"
    if not share.terms:
        return f"±{_digits(share.uncertainty / quantity.scale)}"
    error = share.error(1.0) / quantity.scale
    return ("-" if error < 0 else "+") + _digits(abs(error))


def _digits(part: float) -> str:
    """Return a part in per cent with two digits; what is below a hundredth of a per cent counts as nothing."""
    return f"{100 * part:.2g}" if part >= NOTHING else "0"


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %"


def _draw(outcome: Outcome, verified: Verified, path: Path) -> Path:
    """Draw the errors of the runs of the first parameter over their wall time, the expected front and the recommended
    setting."""
    from matplotlib.figure import Figure

    from nervure.output import plots, title

    figure = Figure(figsize=(7, 5), layout="constrained")
    axis = figure.subplots()
    first = outcome.plan.first.name
    sequence = [(one, row) for one, row in outcome.runs if one.factors.keys() <= {first}]
    for number, (name, quantity) in enumerate(list(verified.quantities.items())[:DRAWN]):
        points = sorted(
            (row["wall_s"], 100 * quantity.error(one.sizes) / quantity.scale)
            for one, row in sequence
            if row.get(name) is not None
        )
        colour = plots.CYCLE[number % len(plots.CYCLE)]
        axis.plot(
            *zip(*points, strict=True),
            "o",
            color=colour,
            markersize=4,
            label=name.removesuffix("_hz").replace("_", " "),
        )
    if outcome.front:
        wall, error = zip(*sorted(outcome.front), strict=True)
        axis.plot(wall, [100 * part for part in error], color="0.3", linewidth=0.9, label="expected, largest")
    axis.axhline(100 * verified.within, color="0.6", linewidth=0.8, linestyle="--")
    if verified.recommended_wall_s is not None and verified.recommended_error is not None:
        there = verified.recommended_wall_s, 100 * verified.recommended_error
        axis.plot(*there, "*", color="0.1", markersize=12, label="recommended")
    axis.set(xscale="log", yscale="log", xlabel="run time [s]", ylabel="largest error, 95 % [%]")
    axis.legend(fontsize="small")
    figure.suptitle(title(outcome.plan.scene, 7), fontsize="medium")
    return plots.save(figure, path)
