"""What a Python program does with scenes and runs: `nervure.load`, `nervure.inspect`, `nervure.run`, `nervure.read`."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from nervure import results, simulation
from nervure.errors import InputError
from nervure.scene import Scene, load

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Run", "RunError", "compare", "inspect", "load", "read", "resume", "run"]


class Run(results.Results):
    """A run: `scene`, `folder`, `summary`, and its `series` by name, in `units`."""

    def plot(self, *names: str) -> "Figure":
        """The columns `names` over time, below each other; `figure.savefig(path)` writes them."""
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
        whole periods, into the folder; returns them. The run needs `fields_every`."""
        from nervure.output import animation

        return animation.write(self.folder, begin, end)


def compare(*runs: Run, names: Sequence[str] = ("tip_ux", "tip_uy")) -> "Figure":
    """The columns `names` of several runs over each other, labelled by their folders."""
    for run in runs:
        run._require(names)
    from nervure.output import plots

    return plots.over_time({run.folder.name: run for run in runs}, names, runs[0].scene.reference)


class RunError(Exception):
    """A unit failed in a run, or the coupling did; `run` has what was computed before."""

    def __init__(self, run: Run):
        super().__init__(run.summary.error)
        self.run = run


def inspect(scene: Scene | str | Path) -> None:
    """Print what a run of a scene, an object or the name of one, will do and take, as `nervure inspect` does; it makes
    steps for half a second. Raises `InputError` where the scene cannot be used."""
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
    fmi: Literal[2, 3] = 2,
) -> Run:
    """Run a scene, an object or the name of one, into the folder `output` or results/NAME.

    `overrides` (key=value), the FMUs in the place of ours, of several rods by their names, the minutes between
    checkpoints, the seconds between fields and between rows of the series, `force`, which replaces results of another
    scene, and `fmi`, the version of our units, are those of `nervure run`.
    Raises `InputError` where something that was given cannot be used, `RunError` where the run failed and
    `KeyboardInterrupt` where it was interrupted; in the last two cases the results so far are written.
    """
    if not isinstance(scene, Scene):
        scene = load(scene, overrides)
    elif overrides := list(overrides):
        raise InputError(f"{', '.join(overrides)}: a scene that is an object is changed by its attributes")
    if fmi not in (2, 3):
        raise InputError(f"fmi is {fmi!r}, but must be 2 or 3")
    if rod_fmu is not None and not isinstance(rod_fmu, Mapping):
        if scene.rods:
            raise InputError(f"rod_fmu is {rod_fmu}, but the scene has several rods: it must be a dict by their names")
        rod_fmu = {"rod": rod_fmu}
    rods = {name: Path(path) for name, path in (rod_fmu or {}).items()}
    foreign = simulation.replaced(scene, rods, fluid_fmu)
    if output == "":
        raise InputError("the output is empty, but it must be the path of a folder")
    folder = None if output is None else Path(output)
    every = {"checkpoint_every": checkpoint_every, "fields_every": fields_every, "series_every": series_every}
    return _ended(simulation.run(scene, folder, foreign, **every, quiet=quiet, force=force, fmi=fmi))


def resume(folder: str | Path, *, quiet: bool = False) -> Run:
    """Go on with the run in `folder` that was interrupted, from its checkpoint; raises what `run` does."""
    return _ended(simulation.resume(Path(folder), quiet))


def _ended(made: results.Results) -> Run:
    done = Run(**vars(made))
    if done.summary.error is not None:
        raise RunError(done)
    if not done.summary.completed:
        raise KeyboardInterrupt
    return done


def read(folder: str | Path) -> Run:
    """The run that is in `folder`."""
    return Run(**vars(results.read(Path(folder))))
