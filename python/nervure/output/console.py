"""The terminal or notebook of a run: forecast, progress, table and the last messages."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

from rich.progress import BarColumn, Progress, TextColumn

from nervure.output import forecast, tables, unit_in
from nervure.scene.facts import Facts
from nervure.simulation import ranges
from nervure.simulation.loop import Observer, TimeLoop
from nervure.simulation.results import CHECKPOINT, Results
from nervure.simulation.session import Session
from nervure.simulation.summary import RunStatus
from nervure.terminal import Console

TERMINAL_INTERVAL = 0.2  # Wall time between two updates in a terminal or a notebook, s
FILE_INTERVAL = 10.0  # Wall time between two lines where the output is no terminal, s
NOTEBOOK_WIDTH = 100  # Characters of a line in a notebook
SHOWN = (("tip_ux", "tip_uy"), ("drag", "lift"))  # Columns in a line of progress: the first pair that a run has


def in_notebook() -> bool:
    """Return whether a kernel runs this process."""
    return "ipykernel" in sys.modules


def text_console(quiet: bool = False, stderr: bool = False) -> Console:
    """Return a console; in a notebook its lines are one text, where rich would make an output of each."""
    if in_notebook():  # It asks for colours, which its saved form shows as signs
        return Console(quiet=quiet, force_jupyter=False, force_terminal=False, width=NOTEBOOK_WIDTH, stderr=stderr)
    return Console(quiet=quiet, stderr=stderr)


class NotebookDisplay:
    """A display in a notebook that is replaced: a saved notebook has the last content only."""

    def __init__(self) -> None:
        self.handle: Any = None

    def show(self, content: dict[str, str]) -> None:
        """Replace the content, which has a text for each MIME type."""
        from IPython.display import display

        if self.handle is None:
            self.handle = display(content, raw=True, display_id=True)
        else:
            self.handle.update(content, raw=True)


def shown_columns(session: Session) -> tuple[str, ...]:
    """Return the columns of the series that show best how a run goes."""
    return next((names for names in SHOWN if names[0] in session.recorder.columns), ())


def warn(message: str) -> None:
    """Print a warning to the standard error."""
    text_console(stderr=True).print(f"warning: {message}", markup=False, soft_wrap=True)


def announce(facts: Facts) -> None:
    """Print what is known of a run before its units are made: numbers, steps and warnings."""
    _print_rows(text_console(), forecast.scene_rows(facts))
    for text in ranges.warnings(facts):
        warn(text)


def _print_rows(console: Console, rows: Iterable[tuple[str, str]]) -> None:
    for name, value in rows:
        console.print(f"{name}: {value}", markup=False, soft_wrap=True)


class Terminal(Observer):
    """Prints the scheme and, soon after the start, the forecast of a session, its progress, and its summary."""

    def __init__(self, session: Session):
        self.console, self.session, self.line = text_console(), session, NotebookDisplay()
        _print_rows(self.console, forecast.scheme_rows(session))
        self.warned = len(session.warnings)
        self.pace: forecast.Pace | None = forecast.Pace(session)
        units = session.recorder.units
        self.shown = {name: unit_in(session.scene, units[name], 0.0) for name in shown_columns(session)}
        in_place = self.console.is_terminal or in_notebook()
        self.interval = TERMINAL_INTERVAL if in_place else FILE_INTERVAL
        self.due = self.interval
        self.bar = _bar(self.console)
        self.task = self.bar.add_task("", total=session.grid.end)
        self.bar.start()

    def step(self, loop: TimeLoop) -> None:
        wall = loop.wall
        for text in self.session.warnings[self.warned :]:
            warn(text)
        self.warned = len(self.session.warnings)
        if self.pace:
            self.pace.see(loop.steps, wall)
            if self.pace.total is not None and self.pace.timed >= forecast.TIMED:
                self.console.print(f"forecast: {forecast.cost(self.pace.total)}", soft_wrap=True)
                self.pace = None
        if wall >= self.due and loop.time > 0.0:
            self.due = wall + self.interval
            self._show(loop, wall)

    def _show(self, loop: TimeLoop, wall: float) -> None:
        values = []
        for name, (unit, scale) in self.shown.items():
            values.append(f"{name} {loop.recorder.series[name][-1] * scale:.{2 if scale > 1 else 3}f} {unit}".rstrip())
        end, left = loop.grid.end, wall * (loop.grid.end - loop.time) / loop.time
        text = ", ".join([f"t {loop.time:.3f} of {end:g} s", f"wall {wall:.0f} s, {left:.0f} s left", *values])
        if self.console.is_terminal:
            self.bar.update(self.task, completed=loop.time, description=text)
        elif in_notebook():
            self.line.show({"text/plain": text})
        else:
            self.console.print(text)

    def end(self, status: RunStatus | None) -> None:
        self.bar.stop()

    def finish(self, results: Results) -> None:
        folder, summary = results.folder, results.summary
        tables.print_table(self.console, summary, results.scene)
        self.console.print(f"results in {folder}", soft_wrap=True)
        if not summary.completed and summary.error is None:
            kept = (folder / CHECKPOINT).exists()
            how = f"`nervure resume {folder}` continues it" if kept else "there is no checkpoint"
            end = self.session.grid.end
            self.console.print(f"stopped at t = {summary.simulated_s:g} of {end:g} s; {how}", soft_wrap=True)


def _bar(console: Console) -> Progress:
    """Return a progress bar, which is shown in a terminal only."""
    columns = BarColumn(), TextColumn("{task.description}")
    return Progress(*columns, console=console, transient=True, disable=console.quiet or not console.is_terminal)


@contextmanager
def sweep_progress(console: Console, runs: int, steps: int) -> Iterator[Callable[[int, int], None]]:
    """Yield a function that shows how many of `runs` and of their `steps` are done, and the time left; any thread may
    call it."""
    begin, due = perf_counter(), FILE_INTERVAL

    def show(runs_done: int, steps_done: int) -> None:
        nonlocal due
        spent, share = perf_counter() - begin, steps_done / steps if steps else runs_done / max(1, runs)
        left = f", {spent * (1 / share - 1):.0f} s left" if share else ""
        text = f"{runs_done} of {runs} runs, {share:.0%} of the steps{left}"
        if console.is_terminal:
            bar.update(task, completed=share, description=text)
        elif spent >= due and runs_done < runs:
            due = spent + FILE_INTERVAL
            console.print(text)

    with _bar(console) as bar:
        task = bar.add_task(f"0 of {runs} runs", total=1.0)
        yield show
