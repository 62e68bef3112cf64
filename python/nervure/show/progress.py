"""What a run shows while it goes on, and how it is asked to stop."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from nervure.recorder import Recorder
from nervure.show import shown_in

TERMINAL_INTERVAL = 0.2
"""Wall time between two updates in a terminal or a notebook, s."""

FILE_INTERVAL = 10.0
"""Wall time between two lines where the output is no terminal, s."""

NOTEBOOK_WIDTH = 100
"""Characters of the line of a notebook: what was longer before it is written over."""

SHOWN = (("tip_ux", "tip_uy"), ("drag", "lift"))
"""What is shown besides the times: the first of these that there is."""


class Display:
    """Shows simulated time, wall time, time left and the tip (or the forces, where there is no rod)."""

    def __init__(self, console: Console, recorder: Recorder, end: float):
        self.recorder, self.end, self.console = recorder, end, console
        self.shown = next((names for names in SHOWN if names[0] in recorder.columns), ())
        self.bar: Progress | None = None
        self.interval = float("inf") if console.quiet else FILE_INTERVAL
        if console.is_terminal and not console.quiet:
            self.interval = TERMINAL_INTERVAL
            self.bar = Progress(BarColumn(), TextColumn("{task.description}"), console=console, transient=True)
            self.task = self.bar.add_task("", total=end)
        elif console.is_jupyter and not console.quiet:
            self.interval = TERMINAL_INTERVAL
        self.next = self.interval

    def __enter__(self) -> Self:
        if self.bar:
            self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar:
            self.bar.stop()
        elif self.console.is_jupyter and self.next > self.interval:
            sys.stdout.write("\n")

    def show(self, _steps: int, time: float, wall: float) -> None:
        """Called after every step with the simulated time and the wall time, s; cheap unless it is time to show."""
        if wall < self.next or time == 0.0:
            return
        self.next = wall + self.interval
        latest = self.recorder.latest
        values = []
        for name in self.shown:
            unit, scale = shown_in(self.recorder.units[name])
            values.append(f"{name} {latest[name] * scale:.2f} {unit}")
        left = wall * (self.end - time) / time
        text = ", ".join([f"t {time:.3f} of {self.end:g} s", f"wall {wall:.0f} s, {left:.0f} s left", *values])
        if self.bar:
            self.bar.update(self.task, completed=time, description=text)
        elif self.console.is_jupyter:  # one line that is written over: rich's own bar needs ipywidgets there
            sys.stdout.write(f"\r{text:<{NOTEBOOK_WIDTH}}")
            sys.stdout.flush()
        else:
            self.console.print(text)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Within it, the first Ctrl-C or SIGTERM only makes the function it gives answer True; a second one kills. A thread
    beside the main one gets no signals, so there it always answers False."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    asked: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def ask(number: int, _frame: FrameType | None) -> None:
        asked.append(number)
        restore()

    for number in before:
        signal.signal(number, ask)
    try:
        yield lambda: bool(asked)
    finally:
        restore()
