"""A run of a scene from its units to its results: everything that runs a scene goes through here."""

from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

from nervure.coupling import Drive, Driver, Scheme, couple
from nervure.coupling.guards import Limits
from nervure.errors import InputError
from nervure.files import unwritable
from nervure.library import library
from nervure.scene import Scene, wings
from nervure.scene.facts import Facts
from nervure.scene.solids import cell_lengths
from nervure.simulation import results, verified
from nervure.simulation.fit import check_fit
from nervure.simulation.loop import TimeGrid, TimeLoop
from nervure.simulation.oscillations import GridOscillationMonitor
from nervure.simulation.places import Places, counted
from nervure.simulation.recorder import Recorder
from nervure.simulation.results import Results
from nervure.simulation.summary import summarize
from nervure.units import package
from nervure.units.describe import Description, describe_all, unit_kinds, unit_label
from nervure.units.fmu import Unit, read_description

CHECKS, CHECK_EVERY = 100, 40  # Least checks of places in a run, and most steps between two

Units = dict[str, Unit]  # By name: `rod`, the names of several rods, `fluid`


class Session(TimeLoop):
    """A scene whose units are coupled and ready to run.

        with Session(scene, folder) as session:
            session.run()  # or `start`, and `step` for each step
            results = session.finish()

    The units are the FMUs `fmus`, of which `foreign` are not ours; the other ones are laid out in a temporary folder,
    as `described` or else as the scene describes them. `drive` sets what the scene leaves to the master; `scheme` makes
    another coupling scheme of the units.
    `series_every` is the time between two rows of the series, s, rounded to whole steps, at most the whole run.
    """

    def __init__(
        self,
        scene: Scene,
        folder: Path | None = None,
        fmus: Mapping[str, Path] | None = None,
        *,
        foreign: Collection[str] = (),
        described: Mapping[str, Description] | None = None,
        drive: Drive | None = None,
        scheme: Callable[[Units], Scheme] | None = None,
        series_every: float | None = None,
    ):
        self.scene, self.facts = scene, Facts(scene)
        grid = TimeGrid(scene.time.end, scene.time.communication_step)
        self.folder = folder or Path("results") / scene.name
        self.stale_files = results.field_files(self.folder)
        """Files of an earlier run in the folder, which `finish` removes."""
        self.units: Units = {}
        self.fmus, self.foreign = dict(fmus or {}), foreign
        with ExitStack() as stack:
            names = unit_kinds(scene)
            if missing := [name for name in names if name not in self.fmus]:
                place, own = Path(stack.enter_context(TemporaryDirectory())), described or describe_all(scene)
                self.fmus |= {name: package.lay_out(own[name], place) for name in missing}
            for unit, path in ((name, self.fmus[name]) for name in names):
                # Ours may go on after the end, from a checkpoint.
                self.units[unit] = Unit(path, unit_label(unit, names[unit]), grid.end if unit in foreign else None)
                stack.callback(self.units[unit].close)
            made = scheme(self.units) if scheme else couple(self.units, scene.coupling, foreign)
            self.driver = Driver(self.units, drive, made.left)
            stride = grid.stride(series_every) if series_every else 1
            super().__init__(made, grid, Recorder(self.units, grid.steps, stride))
            self.recorder.values.places |= self.driver.places
            self._open = stack.pop_all()
        self.warnings: list[str] = []
        """Warnings of the run so far."""
        self.places = Places(self.facts, self.units)
        fluid = self.units.get("fluid")
        # Without bodies our fluid keeps `sbdf2` below the CFL numbers at which waves grow.
        self.oscillations = None
        if scene.fluid and fluid and (self.facts.thickness or scene.fluid.time_stepping.scheme == "rk2"):
            self.oscillations = GridOscillationMonitor(scene.fluid, fluid, grid)
        self._limit_guards()

    def _limit_guards(self) -> None:
        """Give the guards the numbers from which they compute advice."""
        if (fluid := self.scene.fluid) is None or not self.scheme.guards:
            return
        ratio = fluid.fine_box.ratio if fluid.fine_box else 1
        cell = tuple(length / ratio for length in cell_lengths(fluid))
        stepping, (mask,) = fluid.time_stepping, fluid.mask.document().values()
        bodies = [
            (float(self.facts.thickness[own.force].max()), own.beam.surface == "line") for own in self.facts.beams
        ]
        bodies += [(max(cell), True)] * len(wings(self.scene))
        numbers = tuple(fluid.box.cells), cell, stepping.max_cfl, mask["c_eta"], stepping.max_step
        cfl = self.facts.numbers
        for (thickness, line), guard in zip(bodies, self.scheme.guards, strict=False):
            guard.limits = Limits(*numbers, thickness, line, self.facts.fluid_steps, (cfl and cfl.cfl) or 0.0)

    def _check(self) -> None:
        self.warnings += self.places.check(self.time)
        for name, unit in self.units.items():
            self.warnings += [] if name in self.foreign else counted(unit.take_warnings())
        for guard in self.scheme.guards:
            at_end = self.steps == self.grid.steps
            self.warnings += guard.warn(self.time, self.grid.communication_step, at_end)

    @classmethod
    def packed(
        cls,
        scene: Scene,
        folder: Path | None = None,
        foreign: Mapping[str, Path] | None = None,
        *,
        fmi: int = 2,
        force: bool = False,
        series_every: float | None = None,
        drive: Drive | None = None,
    ) -> Self:
        """Open a session whose FMUs, of that version of FMI, stay in its folder; `foreign` are in the place of ours.
        Raise `InputError` where the folder holds other results, unless `force` allows their loss."""
        folder, foreign = folder or Path("results") / scene.name, foreign or {}
        units = describe_all(scene, fmi)
        models = {name: unit.model for name, unit in units.items()}
        models |= {name: read_description(path).modelName for name, path in foreign.items() if name in units}
        stale = results.check_output_folder(folder, scene, models, force)
        # fmpy changes the working directory while it loads a library.
        place, session = folder.absolute(), None
        ours = {name: unit for name, unit in units.items() if name not in foreign}
        built = {name: {package.PLATFORM[fmi]: library(unit.kind).absolute()} for name, unit in ours.items()}
        try:
            with ThreadPoolExecutor() as packers:  # To compress a library leaves Python to the session
                packing = {name: packers.submit(package.pack, ours[name], place, built[name]) for name in ours}
                theirs = foreign.keys()
                session = cls(
                    scene, folder, foreign, foreign=theirs, described=units, series_every=series_every, drive=drive
                )
            session.fmus |= {name: packed.result() for name, packed in packing.items()}
        except OSError as error:
            if session:
                session.close()
            raise unwritable(folder, error) from error
        session.stale_files |= stale - {path.parent.resolve() / path.name for path in session.fmus.values()}
        return session

    def start(self) -> None:
        super().start()
        check_fit(self.scene, self.units, self.foreign)
        self._check()

    def step(self) -> None:
        t, h = self.grid.step(self.steps)
        self.recorder.values.time = t
        self.driver.move(t, h, self.recorder.values)
        super().step()
        if self.steps % max(1, min(self.grid.steps // CHECKS, CHECK_EVERY)) == 0 or self.steps == self.grid.steps:
            self._check()
        if self.oscillations:
            self.warnings += self.oscillations.check(self.steps, self.time, self.warnings)

    def finish(self) -> Results:
        """Evaluate the run, write its results into the folder in place of earlier ones, and return them."""
        summary = summarize(self.facts, self.units, self.scheme, self.recorder, self.status(), self.warnings)
        summary = replace(summary, verified=verified.bars(self.scene, self.folder.parent))
        made = Results(self.facts, self.folder, summary, self.recorder.series, self.recorder.units)
        try:
            results.write(made, self.scheme.logs(), self.stale_files)
            for observer in self.observers:
                observer.finish(made)
        except OSError as error:
            raise InputError(f"the results cannot be written into {self.folder}: {error.strerror}") from error
        return made

    def close(self) -> None:
        """Free the units and remove the temporary folder."""
        self._open.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
