"""A free body with what it carries (`docs/theory/flyer.md`): one exchange a step, from t to t + H.

    hinges, loads at t  →  body.reference  →  each wing: reaction and impedance of the coming step
    body.step  →  roots at t + H  →  wing.step  →  nodes at t + H  →  fluid.step  →  loads of the next step

The body and all it carries are one implicit system; what a wing's reaction turns out to be less what the body assumed
reaches the body a step later.
"""

from collections.abc import Sequence

import numpy as np

from nervure.coupling.guards import CouplingError
from nervure.coupling.schemes import BODY_MOTION, Drive, Explicit, Link, driven_inputs
from nervure.scene.types import Guards
from nervure.units.fmu import Unit

REACTION = tuple(f"root.{kind}_{axis}" for kind in ("force", "moment") for axis in "xyz")
RESPONSE = ("root.reaction", "root.impedance")


class Carried:
    """A wing or rod that the body carries, `name` among its hinges."""

    def __init__(self, name: str, body: Unit, unit: Unit, link: Link):
        self.name, self.body, self.unit, self.link = name, body, unit, link
        self.names = [own for own in driven_inputs(unit) if own != "root.step"]
        for own in (*RESPONSE, *REACTION):
            if own not in unit.variables:
                raise CouplingError(
                    f"the body carries the {unit.name}, which does not announce `{own}`: a body needs the force on its "
                    "root before its step, and the rate at which this falls with the root's velocities"
                )
        sizes = [unit.variables[own].size for own in driven_inputs(unit)]
        ends = dict(zip(driven_inputs(unit), np.cumsum(sizes), strict=True))
        self.step_at = int(ends["root.step"]) - 1
        self.roots = np.array([k for own in self.names for k in range(ends[own] - unit.variables[own].size, ends[own])])
        self.announced = [unit.reader([own]) for own in RESPONSE]

    def outputs(self, kind: str) -> list[str]:
        """Return the outputs of the body for this root, `root` or `reference`."""
        return [f"{self.name}.{kind}.{own.removeprefix('root.')}" for own in self.names]

    def move(self, kind: str, h: float) -> None:
        """Give the root its place at the end of a step of `h` (s), or the `reference` of it."""
        values = [np.atleast_1d(self.body.outputs[self.body.slices[own]]) for own in self.outputs(kind)]
        self.link.root[self.roots], self.link.root[self.step_at] = np.concatenate(values), h

    def respond(self) -> list[np.ndarray]:
        """Return reaction and impedance of the coming step."""
        self.unit.set()
        return [read().ravel() for read in self.announced]

    def reaction(self) -> np.ndarray:
        """Return force and moment of the body on the root in the last step."""
        return np.concatenate([self.unit.outputs[self.unit.slices[own]] for own in REACTION])


class Flight(Explicit):
    """A body, what it carries, and a fluid if there is one."""

    def __init__(
        self,
        body: Unit,
        rods: dict[str, Unit],
        fluid: Unit | None,
        drive: Drive | None = None,
        guards: Guards | None = None,
    ):
        self.body = body
        names = {name.partition(".root.")[0] for name in body.variables if ".root." in name}
        self.carried_units = [unit for name, unit in rods.items() if name in names]
        self.watched = {id(unit): list(REACTION) for unit in self.carried_units}
        if fluid is None:
            self.rods, self.drive, self.links = [*rods.values()], drive, [self._alone(unit) for unit in rods.values()]
            self.bodies = np.zeros(0)
        else:
            super().__init__([*rods.values()], fluid, drive, guards if rods else None)
        self.flow = fluid
        self.units = [*self.rods, body, *([fluid] if fluid else [])]
        links = {id(link.rod): link for link in self.links}
        self.carried = [
            Carried(name, body, unit, links[id(unit)]) for name, unit in rods.items() if unit in self.carried_units
        ]
        inputs = [v.name for v in body.variables.values() if v.causality == "input"]
        body.connect(inputs, [own for one in self.carried for kind in ("reference", "root") for own in one.outputs(kind)])
        ends = np.cumsum([body.variables[name].size for name in inputs]).tolist()
        self.places = {name: slice(end - body.variables[name].size, end) for name, end in zip(inputs, ends, strict=True)}
        hinged = [f"{one.name}.{angle}" for one in self.carried for angle in ("stroke", "deviation", "pitch")]
        self.hinges = [name for name in inputs if name.removesuffix("_rate") in hinged]
        if self.hinges and drive is None:
            raise CouplingError(
                "the scene leaves a hinge to the master (flyer.hinges[k].motion), but nothing drives it: give laws of "
                "time, or a function as `drive` of a `Session` in Python (docs/guide/python.md)"
            )
        self.shape = self._find_shape()

    def _alone(self, unit: Unit) -> Link:
        """Connect a unit without a fluid."""
        root, none = driven_inputs(unit), np.zeros(0)
        unit.connect(root, [], self.watched.get(id(unit), ()))
        return Link(unit, unit.exchanged, none, none, none, unit.inputs)

    def _find_shape(self) -> str:
        """Return the prefix of the body's shape at the fluid, `body[1].` or so; none where it has no shape there."""
        of_loads = "load.force_x"
        return next((name.removesuffix(of_loads) for name in self.flow.variables if name.endswith(of_loads)), "")

    def _connect_shape(self) -> None:
        """Find the places of the motion of the body's shape among the fluid's inputs."""
        names = driven_inputs(self.flow)
        ends = np.cumsum([self.flow.variables[name].size for name in names])
        start = self.body.outputs.astype(float) * 0.0

    def drivers(self) -> list[np.ndarray]:
        """Return what `drive` moves: roots that the body does not carry, then bodies of the fluid but its own."""
        roots = [link.root for link in self.links if link.rod not in self.carried_units and link.root.size]
        return roots

    def move_driven(self, t: float) -> None:
        """Move roots and hinges that `drive` drives to their place at `t` (s)."""
        if not self.drive:
            return
        values = np.asarray(self.drive(t), float)
        for part in self.drivers():
            part[:], values = values[: part.size], values[part.size :]
        for name, value in zip(self.hinges, values, strict=True):
            self.body.inputs[self.places[name]] = value

    def start(self) -> None:
        self.move_driven(0.0)
        self.body.set()
        self.body.get()
        for one in self.carried:
            one.move("root", self.body.inputs[self.places["step"]][0])
        for rod in self.rods:
            rod.set()
        if self.flow:
            self.give_body()
            super().start()
        else:
            for rod in self.rods:
                rod.get()
                rod.start()
        self.body.start()

    def give_body(self) -> None:
        """Copy the place of the body to its shape in the fluid."""
        for k, name in self.shape:
            self.bodies[k] = self.body.outputs[self.body.slices[name]].item()

    def step_rods(self, t: float, h: float) -> None:
        """Step the body and the rods from `t` to `t + h` (s) with the loads of the fluid."""
        body, places = self.body, self.places
        self.take_loads()
        self.move_driven(t + h)
        body.inputs[places["step"]] = h
        for one in self.carried:
            reaction = one.reaction()
            for own, value in zip(REACTION, reaction, strict=True):
                body.inputs[places[f"{one.name}.{own}"]] = value
        body.set()
        body.get()
        for one in self.carried:
            one.move("reference", h)
            for own, value in zip(RESPONSE, one.respond(), strict=True):
                body.inputs[places[f"{one.name}.{own}"]] = value
        body.step(t, h)
        for one in self.carried:
            one.move("root", h)
        for rod in self.rods:
            rod.step(t, h)
        for watch in self.watches:
            watch.check(t + h)

    def step(self, t: float, h: float) -> int:
        self.step_rods(t, h)
        if self.flow:
            self.give_stations()
            self.give_body()
            self.flow.step(t, h)
        return 1


def flight(units: dict[str, Unit], drive: Drive | None, guards: Guards | None) -> Flight:
    """Return the scheme of a scene with a flyer."""
    rods = {name: unit for name, unit in units.items() if name not in ("body", "fluid")}
    return Flight(units["body"], rods, units.get("fluid"), drive, guards)
