"""A free body with what it carries (`docs/theory/flyer.md`): one exchange a step, from t to t + H.

    hinges, loads at t  →  body: reference of each root  →  wing: reaction and impedance of the coming step
    body.step  →  roots at t + H  →  wing.step  →  nodes at t + H  →  fluid.step  →  loads of the next step

The body and all it carries are one implicit system; what a reaction turns out to be less what the body assumed
reaches the body a step later.
"""

from collections.abc import Callable, Sequence

import numpy as np

from nervure.coupling.drive import WithinStep, driven_inputs, master_inputs
from nervure.coupling.foreign import RepeatedSteps
from nervure.coupling.guards import CouplingError
from nervure.coupling.schemes import Explicit, Link
from nervure.scene.types import Guards
from nervure.units.fmu import Unit

AXES = "xyz"
REACTION = [f"root.{kind}_{axis}" for kind in ("force", "moment") for axis in AXES]
RESPONSE = ["root.reaction", "root.impedance"]
LOAD = [f"load.{kind}_{axis}" for kind in ("force", "moment") for axis in AXES]
MOTION = {
    **{f"motion.{kind}{axis}": f"{kind}{axis}" for kind in ("", "v") for axis in AXES},
    **{f"motion.{kind}_{axis}": f"{kind}_{axis}" for kind in ("angle", "omega") for axis in AXES},
}
"""Inputs of the body's shape in the fluid by the outputs of the body."""

MOTION_OF_ROOT = [*AXES, *(f"v{axis}" for axis in AXES), "rotation", *(f"omega_{axis}" for axis in AXES)]
TRIAL = 1e-5
"""Change of the root in a trial step, small against a motion and large against rounding."""
MOVED = 2 / 3
"""Share of a step for which a changed velocity moves a root by two-step backward differences."""


def places(unit: Unit, names: Sequence[str]) -> dict[str, slice]:
    """Return the places of variables of `unit` that stand one after the other."""
    ends = np.cumsum([unit.variables[name].size for name in names], dtype=int).tolist()
    return {name: slice(end - unit.variables[name].size, end) for name, end in zip(names, ends, strict=True)}


class Carried:
    """A wing or rod that hinge `name` of a body carries."""

    def __init__(self, name: str, link: Link, body: Unit):
        self.name, self.unit, self.body = name, link.rod, body
        self.root = link.rod.inputs[link.rod_loads.size :]
        self.inputs = places(self.unit, master_inputs(self.unit))
        self.moved = [own for own in self.inputs if own != "root.step"]
        announces = {*RESPONSE} <= self.unit.variables.keys()
        needed = REACTION if announces or "root.rotation" in self.inputs else [*RESPONSE, *REACTION]
        for own in needed:
            if own not in self.unit.variables:
                raise CouplingError(
                    f"the body carries the {self.unit.name}, which has no output `{own}`: a body needs the force on "
                    "its root before its step, and the rate at which it falls with the root's velocities"
                )
        if not announces and not self.unit.can_roll_back:
            raise CouplingError(
                f"the body carries the {self.unit.name}, which has no output `{RESPONSE[0]}`: it must try its steps, "
                "but cannot restore its state (canGetAndSetFMUstate)"
            )
        self.announced = [self.unit.reader([own]) for own in RESPONSE] if announces else []
        self.repeated = None if announces else RepeatedSteps([self.unit])

    def outputs(self, kind: str) -> list[str]:
        """Return the outputs of the body for the inputs of the root: its `root`, or the `reference` of that."""
        return [f"{self.name}.{kind}.{own.removeprefix('root.')}" for own in self.moved]

    def move(self, kind: str, h: float) -> None:
        """Give the root its place at the end of a step of `h` (s), or the `reference` of that."""
        if "root.step" in self.inputs:
            self.root[self.inputs["root.step"]] = h
        for own, output in zip(self.moved, self.outputs(kind), strict=True):
            self.root[self.inputs[own]] = self.body.outputs[self.body.slices[output]]

    def respond(self, t: float, h: float) -> dict[str, np.ndarray]:
        """Return reaction and impedance of the step from `t` to `t + h` (s)."""
        if self.announced:
            self.unit.set()
            return {own: read().ravel() for own, read in zip(RESPONSE, self.announced, strict=True)}
        return dict(zip(RESPONSE, self._try(t, h), strict=True))

    def _try(self, t: float, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Find both by trial steps: with the root given, and with each of its velocities changed by `TRIAL` of those
        that turn the wing or carry it by its size in a step."""
        unit, before, root = self.unit, self.unit.outputs.copy(), self.root.copy()
        unit.save()
        if self.repeated:
            self.repeated.test(t, h)

        def tried() -> np.ndarray:
            unit.step(t, h)
            borne = -np.concatenate(list(self.reaction().values()))
            unit.restore()
            return borne

        reference, falls = tried(), np.empty((6, 6))
        at = {own: self.inputs[f"root.{own}"] for own in MOTION_OF_ROOT}
        size = float(max(np.ptp(before[unit.slices[axis]]) for axis in AXES))
        for k in range(6):
            axis, change = AXES[k % 3], TRIAL / h * (size if k < 3 else 1.0)
            if k < 3:
                self.root[at[f"v{axis}"]] += change
                self.root[at[axis]] += change * MOVED * h
            else:
                turn = MOVED * h * change * np.cross(np.eye(3)[k - 3], np.eye(3)).T
                self.root[at[f"omega_{axis}"]] += change
                self.root[at["rotation"]] += (turn @ root[at["rotation"]].reshape(3, 3)).ravel()
            falls[:, k] = (reference - tried()) / change
            self.root[:] = root
        unit.outputs[:] = before
        return reference, falls.ravel()

    def reaction(self) -> dict[str, np.ndarray]:
        """Return force and moment of the body on the root in the last step."""
        return {own: self.unit.outputs[self.unit.slices[own]] for own in REACTION}


class Flight(Explicit):
    """A body, wings and rods by name, of which it carries some, and a fluid if there is one."""

    flow: Unit | None
    shape: Callable[[], np.ndarray] | None = None
    """Reader of the loads of the fluid on the body's shape; None where the fluid does not feel the body."""

    def __init__(self, body: Unit, rods: dict[str, Unit], fluid: Unit | None, guards: Guards | None):
        self.body, self.flow = body, fluid
        self.inputs = places(body, [v.name for v in body.variables.values() if v.causality == "input"])
        self.carried_units = [unit for name, unit in rods.items() if f"{name}.root.reaction" in self.inputs]
        if fluid:
            super().__init__([*rods.values()], fluid, guards if rods else None)
            self.bodies = fluid.inputs[self.fluid_stations.size :]
        else:
            self.rods, self.bodies = [*rods.values()], np.zeros(0)
            self.links = [self._alone(rod) for rod in self.rods]
        self.units = [*self.rods, body, *([fluid] if fluid else [])]
        links = {name: link for name, link in zip(rods, self.links, strict=True) if link.rod in self.carried_units}
        self.carried = [Carried(name, link, body) for name, link in links.items()]
        roots = [name for one in self.carried for kind in ("reference", "root") for name in one.outputs(kind)]
        self._find_shape()
        body.connect([*self.inputs], roots, [*self.motion])
        self.driven = WithinStep(self.units, self.left)

    def watched(self, rod: Unit) -> list[str]:
        return REACTION if rod in self.carried_units else []

    def left(self, unit: Unit) -> list[str]:
        if unit in self.carried_units:
            return []
        prefix = self._prefix() if unit is self.flow else ""
        return [name for name in driven_inputs(unit) if not (prefix and name.startswith(prefix))]

    def _prefix(self) -> str:
        """Return the prefix of the body's shape at the fluid, such as `body[1].`; empty without one."""
        names = self.flow.variables if self.flow else {}
        return next((name.removesuffix(LOAD[0]) for name in names if name.endswith(f".{LOAD[0]}")), "")

    def _alone(self, rod: Unit) -> Link:
        """Connect a rod without a fluid."""
        none = np.zeros(0)
        rod.connect(master_inputs(rod), [], self.watched(rod))
        return Link(rod, rod.exchanged, none, none, none)

    def _find_shape(self) -> None:
        """Find the shape of the body in the fluid: the places of its motion, and its loads."""
        prefix, self.motion = self._prefix(), dict[str, slice]()
        if self.flow is None or not prefix:
            return
        own = places(self.flow, master_inputs(self.flow))
        self.motion = {MOTION[name.removeprefix(prefix)]: at for name, at in own.items() if name.startswith(prefix)}
        loads, impedance = (self.flow.reader([prefix + name for name in names]) for names in (LOAD, ["load.impedance"]))
        self.shape = lambda: np.concatenate([loads().ravel(), impedance().ravel()])

    def give(self, name: str, value: np.ndarray | float) -> None:
        """Give the body an input."""
        self.body.inputs[self.inputs[name]] = value

    def give_body(self) -> None:
        """Give the fluid the motion of the body's shape."""
        for name, at in self.motion.items():
            start = self.rest.get(name, 0.0)
            self.bodies[at] = self.body.outputs[self.body.slices[name]] - start

    def start(self) -> None:
        self.body.set()
        self.body.get()
        self.rest = {axis: self.body.outputs[self.body.slices[axis]].item() for axis in AXES}
        for one in self.carried:
            one.move("root", self.body.inputs[self.inputs["step"]].item())
        for rod in self.rods:
            rod.set()
        self.give_body()
        if self.flow:
            super().start()
        for rod in self.rods if not self.flow else []:
            rod.get()
            rod.start()
        self.body.start()

    def step_rods(self, t: float, h: float) -> None:
        """Step the body and the rods from `t` to `t + h` (s) with the loads of the fluid."""
        self.take_loads()
        self.give("step", h)
        if self.shape:
            for name, value in zip([*LOAD, "load.impedance"], np.split(self.shape(), range(1, 7)), strict=True):
                self.give(name, value)
        for one in self.carried:
            for name, value in one.reaction().items():
                self.give(f"{one.name}.{name}", value)
        self.body.set()
        self.body.get_exchanged()
        for one in self.carried:
            one.move("reference", h)
            for name, value in one.respond(t, h).items():
                self.give(f"{one.name}.{name}", value)
        self.body.step(t, h)
        for one in self.carried:
            one.move("root", h)
        for rod in self.rods:
            rod.step(t, h)
        for watch in self.watches:
            watch.check(t + h)

    def exchange(self, t: float, h: float) -> None:
        self.step_rods(t, h)
        if self.flow:
            self.give_stations()
            self.give_body()
            self.flow.step(t, h)
