"""The Python interface: `nervure.load`, `nervure.inspect`, `nervure.run`, `nervure.resume`, `nervure.read`."""

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nervure.errors import InputError
from nervure.extras import require
from nervure.files import undone_on_error
from nervure.scene import Scene, load
from nervure.simulation import checkpoint, results
from nervure.simulation.loop import interruptible
from nervure.simulation.session import Session

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Run", "RunError", "compare", "inspect", "load", "read", "resume", "run"]


class Run(results.Results):
    """A run: `scene`, `folder`, `summary`, and its `series` by name, in `units`."""

    def plot(self, *names: str) -> "Figure":
        """Draw the columns `names` over time, below each other; `figure.savefig(path)` writes them."""
        self._require(names)
        if "ipykernel" in sys.modules:
            import matplotlib.pyplot  # noqa: F401  lets the notebook draw a figure that a cell gives

        from nervure.output import plots

        return plots.over_time({self.scene.name: self}, names, self.scene.reference)

    def _require(self, names: Iterable[str]) -> None:
        """Raise `InputError` where one of `names` was not recorded."""
        for name in names:
            if name not in self.series:
                raise InputError(f"{name} was not recorded: there are {', '.join(self.series)}")

    def animate(self, begin: float | None = None, end: float | None = None) -> list[Path]:
        """Write vorticity.gif, vorticity.mp4 and phases.png of the times from `begin` to `end` (s), or of the last two
        whole periods, into the folder; return their paths. The run needs `fields_every`."""
        from nervure.output import animation

        return animation.write(self.folder, begin, end)


def compare(*runs: Run, names: Sequence[str] = ("tip_ux", "tip_uy")) -> "Figure":
    """Draw the columns `names` of several runs over each other, labelled by their folders."""
    for run in runs:
        run._require(names)
    from nervure.output import plots

    return plots.over_time({run.folder.name: run for run in runs}, names, runs[0].scene.reference)


class RunError(Exception):
    """A unit or the coupling failed in a run; `run` has the results before the failure."""

    def __init__(self, run: Run):
        super().__init__(run.summary.error)
        self.run = run


def inspect(scene: Scene | str | Path) -> None:
    """Print what `nervure inspect` prints of a scene, an object or a name; it makes steps for half a second. Raise
    `InputError` where the scene cannot be used."""
    from rich.console import Console

    from nervure.output import inspection

    inspection.show_scene(Console(highlight=False), scene if isinstance(scene, Scene) else load(scene))


def run(
    scene: Scene | str | Path,
    output: str | Path | None = None,
    *,
    overrides: Iterable[str] = (),
    rod_fmu: Path | Mapping[str, Path] | None = None,
    fluid_fmu: Path | None = None,
    checkpoint_every: float | None = None,
    fields_every: float | None = None,
    series_every: float | None = None,
    force: bool = False,
    quiet: bool = False,
    fmi: int = 2,
) -> Run:
    """Run a scene, an object or a name, into the folder `output` or results/NAME.

    The arguments are the options of `nervure run`: `overrides` (key=value), FMUs in the place of ours (`rod_fmu` by
    name where the scene has several rods), minutes between checkpoints, seconds between fields and between rows of the
    series, `force`, which replaces results of another scene, and `fmi`, the version of our units.
    Raise `InputError` where an argument cannot be used, `RunError` where the run failed and `KeyboardInterrupt` where
    it was interrupted; in the last two cases the results so far are written.
    """
    if not isinstance(scene, Scene):
        scene = load(scene, overrides)
    elif overrides := list(overrides):
        raise InputError(f"{', '.join(overrides)}: a scene that is an object is changed by its attributes")
    if fmi not in (2, 3):
        raise InputError(f"fmi is {fmi!r}, but must be 2 or 3")
    if output == "":
        raise InputError("the output is empty, but it must be the path of a folder")
    if fields_every is not None:
        require("h5py", "writing fields")  # before units are packed
    folder, foreign = None if output is None else Path(output), _foreign(scene, rod_fmu, fluid_fmu)
    options = {"checkpoint_every": checkpoint_every, "fields_every": fields_every, "series_every": series_every}
    for name, value in options.items():
        if value is not None and not (math.isfinite(value) and value >= 0):
            raise InputError(f"{name} is {value}, but must be a finite number of at least 0")
    with undone_on_error(folder or Path("results") / scene.name) as keep:
        session = Session.packed(scene, folder, foreign, fmi=fmi, force=force, series_every=series_every)
        return _run(session, options, quiet, keep)


def resume(folder: str | Path, *, quiet: bool = False) -> Run:
    """Continue the interrupted run in `folder` from its checkpoint; raise what `run` raises."""
    return _run(*checkpoint.resume(Path(folder)), quiet, started=lambda: None)


def _foreign(scene: Scene, rod_fmu: Path | Mapping[str, Path] | None, fluid_fmu: Path | None) -> dict[str, Path]:
    """Return the FMUs in the place of ours by unit; raise `InputError` for a rod that the scene does not have."""
    if rod_fmu is not None and not isinstance(rod_fmu, Mapping):
        if scene.rods:
            raise InputError(f"rod_fmu is {rod_fmu}, but the scene has several rods: it must be a dict by their names")
        rod_fmu = {"rod": rod_fmu}
    foreign = {name: Path(path) for name, path in (rod_fmu or {}).items()}
    names = [own.name for own in scene.rods] or (["rod"] if scene.rod else [])
    for name in foreign:
        if name not in names:
            one = "one rod, which needs no name" if names else "no rod"
            known = f"the rods {', '.join(names)}" if scene.rods else one
            raise InputError(f"an FMU is given for the rod `{name}`, but the scene has {known}")
    if fluid_fmu and not scene.fluid:
        raise InputError(f"the FMU {fluid_fmu} is given for the fluid, but the scene has no fluid")
    return foreign | ({"fluid": Path(fluid_fmu)} if fluid_fmu else {})


def _run(session: Session, options: checkpoint.Options, quiet: bool, started: Callable[[], None]) -> Run:
    """Run a session to its end or an interruption, with everything that watches it; call `started` before its start."""
    from nervure.output import console, fields, plots

    with session:
        if options["fields_every"] is not None:
            session.observers.append(fields.Fields(session, options["fields_every"], console.warn))
        session.observers.append(plots.Pictures(session))
        if options["checkpoint_every"] is not None or all(unit.can_serialize for unit in session.units.values()):
            session.observers.append(checkpoint.Checkpoint(session, options, console.warn))
        if not quiet:
            session.observers.append(console.Terminal(session))
        started()
        with interruptible() as stopping:
            session.run(stopping)
        done = Run(**vars(session.finish()))
    if done.summary.error is not None:
        raise RunError(done)
    if not done.summary.completed:
        raise KeyboardInterrupt
    return done


def read(folder: str | Path) -> Run:
    """Read the run in `folder`."""
    return Run(**vars(results.read(Path(folder))))
