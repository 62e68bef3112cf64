"""python -m studies.versions: what a master spends on the FSI3 pair under FMI 2.0 and 3.0, into docs/versions.csv."""

import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import fmpy

from nervure import coupling
from nervure.files import write_csv
from nervure.resources import ROOT
from nervure.scene import load
from nervure.units import package
from nervure.units.fmu import Unit

RESULTS = ROOT / "docs" / "versions.csv"
ROUNDS, EXCHANGES = 30, 1000
"""How often each is measured, both versions in turn, of which the least counts; exchanges within one of them."""


def timed(call: Callable[[], Any]) -> float:
    """Wall time of a call, ms."""
    begin = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - begin)


class Pair:
    """The unpacked units of the shipped FSI3 scene."""

    def __init__(self, version: int, folder: Path):
        self.scene = load("fsi3-325x72")
        self.places: dict[str, Path] = {}
        for kind in package.kinds(self.scene):
            packed = package.pack(kind, self.scene, folder / str(version), version=version)
            self.places[kind] = Path(fmpy.extract(str(packed), str(folder / f"{version}-{kind}")))

    def parse(self) -> dict[str, Any]:
        """The model descriptions, checked against their schema."""
        return {kind: fmpy.read_model_description(str(place)) for kind, place in self.places.items()}

    def instantiate(self) -> None:
        end = self.scene.time.end
        self.units = {kind: Unit(place, kind, end) for kind, place in self.places.items()}

    def connect(self) -> None:
        coupling.couple(self.units, self.scene.coupling).start()

    def exchange(self) -> None:
        for _ in range(EXCHANGES):
            for unit in self.units.values():
                unit.set()
                unit.get_exchanged()

    def measure(self) -> dict[str, float]:
        """Times in ms, of one exchange in µs."""
        times = {step.__name__: timed(step) for step in (self.parse, self.instantiate, self.connect, self.exchange)}
        for unit in self.units.values():
            unit.close()
        return times | {"exchange": 1e3 * times["exchange"] / EXCHANGES}

    def sizes(self) -> dict[str, float]:
        """Variables of each unit, and kB of both model descriptions."""
        texts = [(place / "modelDescription.xml").stat().st_size for place in self.places.values()]
        counts = {kind: len(description.modelVariables) for kind, description in self.parse().items()}
        return counts | {"size": 1e-3 * sum(texts)}


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        pairs = {version: Pair(version, Path(folder)) for version in (2, 3)}
        rounds = [{version: pair.measure() for version, pair in pairs.items()} for _ in range(ROUNDS)]
        rows = []
        for version, pair in pairs.items():
            least = {name: min(times[version][name] for times in rounds) for name in rounds[0][version]}
            rows.append({"version": f"{version}.0"} | {k: f"{v:.4g}" for k, v in (pair.sizes() | least).items()})
            print(rows[-1])
    write_csv(RESULTS, rows)
