"""Fly a body FMU with wing FMUs, in a fluid or without one, with fmpy alone, and write the way of the body.

    nervure build examples/hover-flyer.json --output units
    python scripts/flyer.py units/hover-flyer- body.csv 0.001 left right

An exchange: each wing announces what its root will bear, the body steps, the wings follow, then the fluid.
"""

import argparse
import csv
import math
import re
from collections.abc import Iterator
from pathlib import Path

from fsi3 import Unit  # type: ignore[import-not-found]

WAY = [*"xyz", "vx", "vy", "vz", "angle_x", "angle_y", "angle_z"]
BORNE, ANNOUNCED = re.compile(r"root\.(force|moment)_[xyz]"), re.compile(r"root\.(reaction|impedance)")


def give(source: Unit, target: Unit, names: dict[str, str]) -> None:
    """Set inputs of `target` to outputs of `source`, by the names of these; several outputs may be one array."""
    target.set([*dict.fromkeys(names.values())], source.get([*names]))


class Carried:
    """A wing with the names of what it exchanges with the body and with the fluid, where it has a prefix."""

    def __init__(self, unit: Unit, name: str, prefix: str, body: Unit, fluid: Unit | None):
        def outputs(kind: str) -> dict[str, str]:
            names = {f"{name}.{kind}.{own[5:]}": own for own in unit.inputs if own.startswith("root.")}
            return {at: own for to, own in names.items() for at in body.references if f"{at}[".startswith(f"{to}[")}

        self.unit, self.root, self.reference = unit, outputs("root"), outputs("reference")
        self.borne = {own: f"{name}.{own}" for own in unit.references if BORNE.fullmatch(own)}
        self.announced = {own: f"{name}.{own}" for own in unit.references if ANNOUNCED.match(own)}
        self.loads = {prefix + own: own for own in unit.inputs if not own.startswith("root.")}
        self.nodes = {at.removeprefix(prefix): at for at in (fluid.inputs if fluid else []) if at.startswith(prefix)}


def fly(body: Unit, wings: list[Carried], fluid: Unit | None, end: float) -> Iterator[list[float]]:
    """Time (s) and way of the body (m, m/s, rad), at t = 0 and after each exchange, of the scene's step or a part."""
    start, names = dict(zip("xyz", body.get([*"xyz"]), strict=True)), fluid.references if fluid else {}
    loads = {own: own[own.index("load.") :] for own in names if re.match(r"body\[\d+\]\.load\.", own)}
    shape = next(iter(loads), "").partition("load.")[0]
    motions = {own: own.partition("motion.")[2] for own in names if shape and own.startswith(f"{shape}motion.")}

    def follow() -> None:
        if fluid:
            for wing in wings:
                give(wing.unit, fluid, wing.nodes)
            for own, output in motions.items():
                fluid.set([own], [body.get([output])[0] - start.get(output, 0.0)])

    for wing in wings:
        give(body, wing.unit, wing.root)
    follow()
    for unit in filter(None, [*(wing.unit for wing in wings), body, fluid]):
        unit.fmu.exitInitializationMode()
    t, h = 0.0, body.get(["step"])[0]
    yield [t, *body.get(WAY)]
    while t < end - h / 2:
        h /= max(1, math.ceil(h / fluid.get(["longest_step"])[0] - 1e-9)) if fluid else 1  # Loads hold for one step
        body.set(["step"], [h])
        for wing in wings:
            give(wing.unit, body, wing.borne)
            if fluid:
                give(fluid, body, loads)
                give(fluid, wing.unit, wing.loads)
            give(body, wing.unit, wing.reference)
            wing.unit.set(["root.step"], [h])
            give(wing.unit, body, wing.announced)
        body.fmu.doStep(t, h)
        for wing in wings:
            give(body, wing.unit, wing.root)
            wing.unit.fmu.doStep(t, h)
        if fluid:
            follow()
            fluid.fmu.doStep(t, h)
        yield [t := t + h, *body.get(WAY)]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("units", help="beginning of the FMUs' names")
    parser.add_argument("csv", help="file to write")
    parser.add_argument("end", type=float, help="s")
    parser.add_argument("wings", nargs="+", help="their names")
    given = parser.parse_args()
    paths = {name: f"{given.units}{name}.fmu" for name in ["body", *given.wings, "fluid"]}
    units = {name: Unit(path, given.end) for name, path in paths.items() if Path(path).exists()}
    places = ["wing."] if len(given.wings) == 1 else [f"wing[{k}]." for k in range(1, len(given.wings) + 1)]
    body, fluid, named = units["body"], units.get("fluid"), zip(given.wings, places, strict=True)
    wings = [Carried(units[name], name, place, body, fluid) for name, place in named]
    with open(given.csv, "w", encoding="utf-8", newline="") as file:
        way = fly(body, wings, fluid, given.end)
        csv.writer(file).writerows([["time", *WAY], *([f"{value:.10g}" for value in row] for row in way)])
    for unit in units.values():
        unit.close()
