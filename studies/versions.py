"""python -m studies.versions: what a master spends on the FSI3 pair under FMI 2.0 and 3.0, into docs/versions.csv."""

import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import fmpy

from nervure import coupling
from nervure.files import write_csv
from nervure.pack import package
from nervure.resources import ROOT
from nervure.scene import load
from nervure.unit import Unit

RESULTS = ROOT / "docs" / "versions.csv"
TIMES, EXCHANGES = 15, 2000
"""How often each is measured, of which the median counts; exchanges within one of them."""


def timed(call: Callable[[], Any]) -> float:
    """Wall time of a call, ms."""
    begin = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - begin)


def measured(version: int, folder: Path) -> dict[str, Any]:
    """Variables of each unit; of both together the size of their descriptions in kB, and median times in ms, of an
    exchange in µs."""
    scene = load("fsi3-325x72")
    packed = {kind: package.pack(kind, scene, folder, version=version) for kind in package.kinds(scene)}
    places = {kind: Path(fmpy.extract(str(path), str(folder / kind))) for kind, path in packed.items()}
    descriptions = {kind: place / "modelDescription.xml" for kind, place in places.items()}
    variables = {kind: len(fmpy.read_model_description(str(d)).modelVariables) for kind, d in descriptions.items()}
    rows: dict[str, list[float]] = {"parse": [], "instantiate": [], "connect": [], "exchange": []}
    for _ in range(TIMES):
        rows["parse"].append(timed(lambda: [fmpy.read_model_description(str(path)) for path in descriptions.values()]))
        units: dict[str, Unit] = {}

        def make(units: dict[str, Unit] = units) -> None:
            units.update({kind: Unit(place, kind, scene.time.end) for kind, place in places.items()})

        rows["instantiate"].append(timed(make))

        def connect(units: dict[str, Unit] = units) -> None:
            coupling.couple(units, scene.coupling).start()

        rows["connect"].append(timed(connect))

        def exchange(units: dict[str, Unit] = units) -> None:
            for _ in range(EXCHANGES):
                for unit in units.values():
                    unit.set()
                    unit.get_exchanged()

        rows["exchange"].append(1e3 * timed(exchange) / EXCHANGES)
        for unit in units.values():
            unit.close()
    size = sum(path.stat().st_size for path in descriptions.values())
    times = {name: f"{median(values):.4g}" for name, values in rows.items()}
    return {"version": f"{version}.0", **variables, "size": f"{1e-3 * size:.4g}", **times}


if __name__ == "__main__":
    found = []
    for version in (2, 3):
        with TemporaryDirectory() as folder:
            found.append(measured(version, Path(folder)))
            print(found[-1])
    write_csv(RESULTS, found)
