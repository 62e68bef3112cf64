"""Recorder of the scalar outputs of units over time, in one table that is allocated before the run."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from nervure.catalogue import hint
from nervure.errors import InputError
from nervure.resources import COUPLERS
from nervure.units.fmu import Unit

MAX_ROWS = 200_000  # Largest number of rows: a longer run is recorded at every second, third, … step
KINDS = ("Real", "Integer")  # FMI types of the recorded outputs, in the order of the columns of a unit
PUNCTUATION = re.compile(r"[.\[\]]+")


def column(name: str) -> str:
    """Return the name of the column of an output."""
    return PUNCTUATION.sub("_", name)


class Values(Mapping[str, float]):
    """The columns of the present row, whether it is recorded or not, and driven inputs; fetches what a step did not."""

    def __init__(self) -> None:
        self.time = 0.0  # s
        self.places: dict[str, tuple[np.ndarray, int]] = {}
        self.outputs: dict[str, tuple[Unit, str]] = {}

    def __getitem__(self, name: str) -> float:
        if name == "time":
            return self.time
        if name not in self.places:
            raise KeyError(f"there is no column `{name}`: {hint(name, self)}")
        values, place = self.places[name]
        if name in self.outputs:
            unit, output = self.outputs[name]
            if unit.stale:
                unit.fetch(output)
        return float(values.item(place))

    def reader(self, names: Sequence[str]) -> Callable[[], np.ndarray]:
        """Return a function that reads columns at once, faster than one by one. Raise `InputError` for no column."""
        if unknown := [name for name in names if name != "time" and name not in self.places]:
            raise InputError(f"there is no column `{unknown[0]}`: {hint(unknown[0], self)}")
        fetched: dict[int, tuple[Unit, list[str], list[int]]] = {}
        held = []
        for i, name in enumerate(names):
            unit, output = self.outputs.get(name, (None, ""))
            if unit and unit.variables[output].kind == "Real":
                _, outputs, places = fetched.setdefault(id(unit), (unit, [], []))
                outputs.append(output)
                places.append(i)
            else:
                held.append((name, i))
        parts = [(unit.scalars_reader(outputs), np.array(places)) for unit, outputs, places in fetched.values()]

        def read() -> np.ndarray:
            found = np.empty(len(names))
            for one, places in parts:
                found[places] = one()
            for name, i in held:
                found[i] = self[name]
            return found

        return read

    def __iter__(self) -> Iterator[str]:
        return iter(["time", *self.places])

    def __len__(self) -> int:
        return 1 + len(self.places)


class Recorder:
    """Table of time (s), the scalar outputs of connected `units`, and iterations: one row for every `stride`-th of
    `steps` steps. With a stride above 1, scalars are fetched for these rows only.

    In the names of columns, dots and brackets become underscores. The name of the unit stands in front where two units
    have an output of one name, once, and always for several rods and wings and for a flyer's body. `units` has the
    physical unit of each column but the last.
    """

    def __init__(self, units: dict[str, Unit], steps: int, stride: int = 1):
        self.stride = max(stride, -(-steps // MAX_ROWS))
        self.sampled = list(units.values()) if self.stride > 1 else []
        for unit in self.sampled:
            unit.all_in_step = False
        outputs = [(own, name) for own, unit in units.items() for kind in KINDS for name in unit.scalars(kind)]
        several = len(units.keys() - {"body", *COUPLERS}) > 1
        before = {own: f"{own}_" if own == "body" or (several and own not in COUPLERS) else "" for own in units}
        names = [before[own] + column(name) for own, name in outputs]
        self.units: dict[str, str | None] = {"time": "s"}
        self.values = Values()
        for (own, name), made in zip(outputs, names, strict=True):
            made, unit = made if names.count(made) == 1 or before[own] else f"{own}_{made}", units[own]
            self.units[made] = unit.variables[name].unit
            is_real = unit.variables[name].kind == "Real"
            number = unit.scalars("Real" if is_real else "Integer").index(name)
            self.values.places[made] = unit.reals if is_real else unit.integers, number
            self.values.outputs[made] = unit, name
        self.units["iterations"] = None
        self.columns = list(self.units)
        self.table = np.empty((steps // self.stride + 1, len(self.columns)))
        self.rows = 0
        scalars = [values for unit in units.values() for values in (unit.reals, unit.integers)]
        ends = np.cumsum([1, *(values.size for values in scalars)]).tolist()
        places = [slice(begin, end) for begin, end in pairwise(ends)]
        self._scalars = [(place, values) for place, values in zip(places, scalars, strict=True) if values.size]

    def record(self, step: int, time: float, iterations: int) -> None:
        """Add a row if step number `step` is recorded."""
        if step % self.stride:
            return
        for unit in self.sampled:
            unit.get()
        row = self.table[self.rows]
        row[0], row[-1] = time, iterations
        for place, values in self._scalars:
            row[place] = values
        self.rows += 1

    def resume(self, table: np.ndarray) -> None:
        """Begin with the rows of `table`, recorded before a resumption."""
        self.rows = len(table)
        self.table[: self.rows] = table

    @property
    def series(self) -> dict[str, np.ndarray]:
        """The recorded rows, by column."""
        return dict(zip(self.columns, self.table[: self.rows].T, strict=True))
