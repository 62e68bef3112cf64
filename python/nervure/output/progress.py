"""What a run shows while it goes on, and how it is asked to stop."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from nervure.output import shown_in
from nervure.recorder import Recorder

TERMINAL_INTERVAL = 0.2  # Wall time between two updates in a terminal or a notebook, s
FILE_INTERVAL = 10.0  # Wall time between two lines where the output is no terminal, s
NOTEBOOK_WIDTH = 100  # Characters of the line of a notebook: what was longer before it is written over
SHOWN = (("tip_ux", "tip_uy"), ("drag", "lift"))  # What is shown besides the times: the first of these that there is


@contextmanager
def display(console: Console, recorder: Recorder, end: float) -> Iterator[Callable[[int, float, float], None]]:
    """Within it, the watcher that it gives shows simulated time, wall time, time left and the tip (or the forces, where
    there is no rod); cheap unless it is time to show."""
    shown = next((names for names in SHOWN if names[0] in recorder.columns), ())
    interval = TERMINAL_INTERVAL if console.is_terminal or console.is_jupyter else FILE_INTERVAL
    due = inf if console.quiet else interval

    def show(_steps: int, time: float, wall: float) -> None:
        nonlocal due
        if wall < due or time == 0.0:
            return
        due = wall + interval
        values = []
        for name in shown:
            unit, scale = shown_in(recorder.units[name])
            values.append(f"{name} {recorder.series[name][-1] * scale:.2f} {unit}")
        left = wall * (end - time) / time
        text = ", ".join([f"t {time:.3f} of {end:g} s", f"wall {wall:.0f} s, {left:.0f} s left", *values])
        if console.is_terminal:
            bar.update(task, completed=time, description=text)
        elif console.is_jupyter:  # one line that is written over: rich's own bar needs ipywidgets there
            sys.stdout.write(f"\r{text:<{NOTEBOOK_WIDTH}}")
            sys.stdout.flush()
        else:
            console.print(text)

    columns = BarColumn(), TextColumn("{task.description}")
    with Progress(*columns, console=console, transient=True, disable=console.quiet or not console.is_terminal) as bar:
        task = bar.add_task("", total=end)
        yield show
    if console.is_jupyter and interval < due < inf:
        sys.stdout.write("\n")


@contextmanager
def counting(console: Console, runs: int, steps: int) -> Iterator[Callable[[int, int], None]]:
    """Within it, the function that it gives shows how many of `runs` and of their `steps` are done, and the time left;
    it may be called from any thread."""
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

    columns = BarColumn(), TextColumn("{task.description}")
    with Progress(*columns, console=console, transient=True, disable=console.quiet or not console.is_terminal) as bar:
        task = bar.add_task(f"0 of {runs} runs", total=1.0)
        yield show


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Within it, the first Ctrl-C or SIGTERM only makes the function it gives answer True; a second one kills. A thread
    beside the main one gets no signals, so there it always answers False."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    asked = threading.Event()
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def ask(*_: object) -> None:
        asked.set()
        restore()

    for number in before:
        signal.signal(number, ask)
    try:
        yield asked.is_set
    finally:
        restore()
