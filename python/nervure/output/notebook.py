"""A run in a notebook: a figure that follows its steps, and the finished run as a table with its last picture."""

import base64
import io
from html import escape
from time import perf_counter
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from nervure.output import axis_label, displayed_unit, in_words, plots, unit_in
from nervure.output.console import NotebookDisplay, shown_columns
from nervure.simulation.loop import Observer, TimeLoop
from nervure.simulation.results import Results
from nervure.simulation.session import Session
from nervure.simulation.summary import RunStatus

SHARE = 0.05  # Part of the time of a run that its figure takes
INTERVAL = 0.5  # Least time between two figures, s
DPI = 80
PICTURES = ("vorticity.png", "wing.png", "tip.png")  # The first that a run has is shown


class Figures(Observer):
    """Shows the flow or the wing of a session, and its curves so far, below the cell that runs it."""

    def __init__(self, session: Session):
        self.session, self.display, self.due = session, NotebookDisplay(), 0.0

    def step(self, loop: TimeLoop) -> None:
        if loop.wall < self.due:
            return
        begin = perf_counter()
        self.show()
        self.due = loop.wall + max(INTERVAL, (perf_counter() - begin) / SHARE)

    def end(self, status: RunStatus | None) -> None:
        if status and status.error is None:
            self.show()

    def show(self) -> None:
        """Replace the figure by one of the present time."""
        session, figures = self.session, [plots.vorticity(self.session)]
        if mesh := session.facts.wing:
            from nervure.output import wings

            figures.append(wings.draw(session, mesh))
        figures.append(curves(session))
        caption = f"t = {session.time:.3g} of {session.grid.end:g} {displayed_unit('s', session.scene.display)[0]}"
        self.display.show({"image/png": png([own for own in figures if own]), "text/plain": caption})


def curves(session: Session) -> Figure | None:
    """Draw the columns that show how a run goes over the time so far; None where there is none."""
    columns, recorder, display = shown_columns(session), session.recorder, session.scene.display
    if not columns:
        return None
    figure = Figure(figsize=(plots.WIDTH, 2.6), layout="constrained")
    for axis, column, colour in zip(figure.subplots(1, len(columns)), columns, plots.COLOURS, strict=False):
        unit, scale = unit_in(session.scene, recorder.units[column], 0.0)
        axis.plot(recorder.series["time"], scale * recorder.series[column], color=colour, linewidth=1.0)
        axis.set(xlabel=axis_label("time", displayed_unit("s", display)[0]))
        axis.set(ylabel=axis_label(in_words(column, session.scene), unit))
    return figure


def png(figures: list[Figure]) -> str:
    """Return figures of one width below each other as one PNG in base 64."""
    drawn: list[Any] = []
    for figure in figures:
        figure.set_dpi(DPI)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        drawn.append(np.asarray(canvas.buffer_rgba())[..., :3])
    file = io.BytesIO()
    Image.fromarray(np.concatenate(drawn)).save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()


def html(run: Results) -> str:
    """Return how far a run came, its quantities as a table, and its last picture."""
    summary, display = run.summary, run.scene.display
    clock = displayed_unit("s", display)[0]
    how = "" if summary.completed else f", {summary.error or 'interrupted'}"
    caption = f"{run.scene.name}, {summary.steps} steps to t = {summary.simulated_s:g} {clock}{how}"
    per_time = displayed_unit("1/s", display)[0] if display else "Hz"
    rows = [("quantity", "unit", "mean", "amplitude", f"frequency [{per_time}]")]
    for name, found in summary.quantities.items():
        unit, scale = unit_in(run.scene, found.unit, abs(found.mean) + found.amplitude)
        frequency = f"{found.frequency_hz:.4g}" if found.frequency_hz else "–"
        rows.append((name, unit, f"{found.mean * scale:.4g}", f"{found.amplitude * scale:.4g}", frequency))
    kinds = ("th", *["td"] * (len(rows) - 1))
    lines = ["".join(f"<{kind}>{escape(cell)}</{kind}>" for cell in row) for kind, row in zip(kinds, rows, strict=True)]
    text = f"<p>{escape(caption)}</p><table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"
    for path in (run.folder / name for name in PICTURES):
        if path.exists():
            content = base64.b64encode(path.read_bytes()).decode()
            return f'{text}<img src="data:image/png;base64,{content}" alt="{path.stem}" width="720">'
    return text
