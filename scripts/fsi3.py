"""Couple a rod FMU and a fluid FMU with fmpy alone, and write the motion of the rod's tip.

    nervure build fsi3-325x72 --output units
    python scripts/fsi3.py units/fsi3-325x72-rod.fmu units/fsi3-325x72-fluid.fmu tip.csv

This is all that a master has to do: connect equal names, step the rod, step the fluid. Copy it into your own tool.
"""

import argparse
import csv
import math
import shutil
from collections.abc import Iterator

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

TIP = ["tip.ux", "tip.uy", "tip.vx", "tip.vy"]


class Unit:
    """An FMU of FMI 2.0 or 3.0 in initialization mode; `references` are those of its variables by name."""

    def __init__(self, path: str, stop_time: float):
        description = fmpy.read_model_description(path, validate=False)
        self.is_3 = description.fmiVersion.startswith("3")
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.sizes = {v.name: math.prod(v.shape or ()) for v in description.modelVariables}
        self.inputs = [v.name for v in description.modelVariables if v.causality == "input"]
        self.folder = fmpy.extract(path)
        model = description.coSimulation.modelIdentifier
        self.fmu = (FMU3Slave if self.is_3 else FMU2Slave)(
            guid=description.guid, modelIdentifier=model, instanceName=model, unzipDirectory=self.folder
        )
        self.fmu.instantiate()
        if self.is_3:
            self.fmu.enterInitializationMode(startTime=0.0, stopTime=stop_time)
        else:
            self.fmu.setupExperiment(startTime=0.0, stopTime=stop_time)
            self.fmu.enterInitializationMode()

    def get(self, names: list[str]) -> list[float]:
        references = [self.references[name] for name in names]
        if self.is_3:
            return list(self.fmu.getFloat64(references, sum(self.sizes[name] for name in names)))
        return list(self.fmu.getReal(references))

    def set(self, names: list[str], values: list[float]) -> None:
        references = [self.references[name] for name in names]
        (self.fmu.setFloat64 if self.is_3 else self.fmu.setReal)(references, values)

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)


def couple(rod: Unit, fluid: Unit, end: float, h: float) -> Iterator[list[float]]:
    """Time (s) and motion of the tip (m, m/s), at t = 0 and after every communication step of `h` (s)."""
    loads, stations = rod.inputs, fluid.inputs  # each is an output of the other
    fluid.set(stations, rod.get(stations))
    rod.set(loads, fluid.get(loads))
    for unit in (rod, fluid):
        unit.fmu.exitInitializationMode()
    yield [0.0, *rod.get(TIP)]

    for i in range(round(end / h)):
        t = i * h
        rod.set(loads, fluid.get(loads))
        rod.fmu.doStep(t, h)
        fluid.set(stations, rod.get(stations))
        fluid.fmu.doStep(t, h)
        yield [t + h, *rod.get(TIP)]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Couple a rod FMU and a fluid FMU, one exchange a step.")
    for name, text in (("rod", "FMU of the rod"), ("fluid", "FMU of the fluid"), ("csv", "file for the tip's series")):
        parser.add_argument(name, help=text)
    parser.add_argument("--end", type=float, default=8.0, help="end of the run, s (8)")
    parser.add_argument("--step", type=float, default=4e-4, help="communication step, s (4e-4)")
    given = parser.parse_args()
    rod, fluid = Unit(given.rod, given.end), Unit(given.fluid, given.end)
    with open(given.csv, "w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["time", *TIP])
        rows.writerows([f"{value:.10g}" for value in row] for row in couple(rod, fluid, given.end, given.step))
    for unit in (rod, fluid):
        unit.close()
