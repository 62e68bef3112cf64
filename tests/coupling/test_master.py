"""The loop itself, with units written in Python whose coupled motion is known."""

import copy
import re
from unittest.mock import MagicMock

import numpy as np
import pytest

from nervure import coupling
from nervure.errors import UnitError
from nervure.scene.types import Iterated
from nervure.simulation.loop import TimeGrid, TimeLoop
from nervure.simulation.recorder import Recorder
from nervure.units.fmu import Variable


class Fake:
    """A unit with the interface of `nervure.units.fmu.Unit`; `advance` makes its step."""

    can_roll_back = True

    def __init__(self, name, inputs, outputs):
        sized = [(n, "input", 2) for n in inputs] + [(n, "output", 2) for n in outputs]
        self.name, self.seconds = name, 0.0
        self.variables = {n: Variable(n, "Real", c, "m", list(range(k)), [None] * k) for n, c, k in sized}
        self.state = {"q": 0.0, "v": 0.0}
        self.reals, self.integers = np.empty(0), np.empty(0, int)

    def connect(self, inputs, outputs, _watched=()):
        self.names, self.inputs, self.outputs = inputs, np.zeros(2 * len(inputs)), np.zeros(2 * len(outputs))
        self.input_slices = {name: slice(2 * i, 2 * i + 2) for i, name in enumerate(inputs)}
        self.slices = {name: slice(2 * i, 2 * i + 2) for i, name in enumerate(outputs)}
        self.exchanged = self.outputs

    def input(self, name):
        return self.inputs[2 * self.names.index(name)]

    def scalars(self, _kind):
        return []

    def set(self):
        pass

    get = start = terminate = set

    def check_outputs(self, _t):
        pass

    def step(self, t, h):
        self.advance(t, h)

    def save(self):
        self.saved = copy.deepcopy(self.state)

    def restore(self):
        self.state = copy.deepcopy(self.saved)


class Spring(Fake):
    """Unit mass on a spring, implicit Euler."""

    def __init__(self):
        super().__init__("rod", ["pressure_jump"], ["x", "y", "vx", "vy"])

    def advance(self, _t, h):
        q, v = self.state["q"], self.state["v"]
        v = (v + h * (self.input("pressure_jump") - STIFFNESS * q)) / (1 + STIFFNESS * h * h)
        self.state = {"q": q + h * v, "v": v}
        self.outputs[self.slices["y"]] = q + h * v
        self.outputs[self.slices["vy"]] = v


class AddedMass(Fake):
    """A constant push, less the inertia of the fluid around the mass."""

    def __init__(self):
        super().__init__("fluid", ["x", "y", "vx", "vy"], ["pressure_jump"])

    def advance(self, _t, h):
        v = self.input("vy")
        self.outputs[:] = PUSH - ADDED_MASS * (v - self.state["v"]) / h
        self.state = {"q": 0.0, "v": v}


STIFFNESS, ADDED_MASS, PUSH = 400.0, 10.0, 1.0
GRID = TimeGrid(0.5, 1e-2)


def monolithic():
    """Position at the end, mass and added mass in one implicit Euler step."""
    q = v = 0.0
    h = GRID.communication_step
    for _ in range(GRID.steps):
        v = ((1 + ADDED_MASS) * v + h * (PUSH - STIFFNESS * q)) / (1 + ADDED_MASS + STIFFNESS * h * h)
        q += h * v
    return q


def run(scheme, stopping=lambda: False):
    recorder = Recorder({"rod": scheme.rods[0], "fluid": scheme.fluid}, GRID.steps)
    return TimeLoop(scheme, GRID, recorder).run(stopping), recorder


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_loop_that_is_resumed_has_the_time_of_one_that_came_there(steps):
    """The third step ends at 0.1 + 0.2 s, which is not 0.3 s."""
    grid, quiet = TimeGrid(0.3, 0.1), MagicMock(guards=[])
    stepped, resumed = (TimeLoop(quiet, grid, MagicMock()) for _ in range(2))
    for _ in range(steps):
        stepped.step()
    resumed.resume_at(steps, 0.0)
    assert resumed.time == stepped.time


def test_iterated_scheme_gives_the_monolithic_solution_at_ten_times_the_mass():
    scheme = coupling.Iterated([Spring()], AddedMass(), Iterated(tolerance=1e-8, max_iterations=20))
    outcome, recorder = run(scheme)
    assert outcome.error is None
    assert scheme.rods[0].state["q"] == pytest.approx(monolithic(), rel=1e-6)
    assert recorder.series["iterations"][1:].max() <= 5, "Aitken's relaxation is exact for one unknown"


class Steady(Spring):
    """A unit that goes on at 3 m/s, whatever its load."""

    def advance(self, t, h):
        self.outputs[self.slices["y"]] = 3.0 * (t + h)
        self.outputs[self.slices["vy"]] = 3.0


def test_a_steady_motion_is_guessed_from_its_second_step_on():
    outcome, recorder = run(coupling.Iterated([Steady()], AddedMass(), Iterated(tolerance=1e-8, max_iterations=20)))
    assert outcome.error is None
    assert recorder.series["iterations"][2:].tolist() == [1] * (GRID.steps - 1)


def test_explicit_scheme_blows_up_at_ten_times_the_mass():
    scheme = coupling.Explicit([Spring()], AddedMass())
    run(scheme)
    assert abs(scheme.rods[0].state["q"]) > 1e6 * monolithic()


def test_iteration_that_does_not_converge_names_time_residual_and_limit():
    outcome, recorder = run(coupling.Iterated([Spring()], AddedMass(), Iterated(tolerance=1e-8, max_iterations=2)))
    assert not outcome.completed
    assert "from t = 0 s to 0.01 s did not converge in 2 iterations" in outcome.error, outcome.error
    assert "residual" in outcome.error and "limit" in outcome.error, outcome.error
    assert recorder.rows == 1


class Moody(AddedMass):
    """A load that follows a law of how often it was asked for instead of the stations."""

    def __init__(self, law):
        super().__init__()
        self.law, self.asked = law, 0

    def advance(self, _t, _h):
        self.asked += 1
        self.outputs[:] = self.law(self.asked)


@pytest.mark.parametrize(
    ("fluid", "options", "helps"),
    [
        (
            Moody(lambda n: np.nan if n > 2 else 1.0),
            {"max_iterations": 9},
            "a `time.communication_step` of 0.005 s",
        ),
        (AddedMass(), {"max_iterations": 2, "acceleration": "aitken"}, "`acceleration` iqn_ils holds"),
        (AddedMass(), {"max_iterations": 2}, "still falling: take a `max_iterations` of "),
        (Moody(lambda n: 1 + 1e-3 * np.sin(n * n)), {"max_iterations": 30}, "which a `tolerance` above that accepts"),
        (Moody(lambda n: 1 + 0.5 * np.sin(n * n)), {"max_iterations": 30}, "a heavier rod or a larger `c_eta`"),
    ],
)
def test_iteration_that_does_not_converge_says_what_helps(fluid, options, helps):
    outcome, _ = run(coupling.Iterated([Spring()], fluid, Iterated(tolerance=1e-8, **options)))
    assert helps in outcome.error, outcome.error


def test_the_iterations_that_are_advised_suffice():
    def outcome(most):
        return run(coupling.Iterated([Spring()], AddedMass(), Iterated(tolerance=1e-8, max_iterations=most)))[0]

    advised = int(re.search(r"`max_iterations` of (\d+)", outcome(2).error)[1])
    assert outcome(advised).completed and advised < 60


def test_iterated_scheme_refuses_the_momentum_load():
    rod, fluid = Spring(), AddedMass()
    for unit, causality in ((rod, "input"), (fluid, "output")):
        unit.variables["impedance"] = Variable("impedance", "Real", causality, "m", [0, 1], [None] * 2)
    with pytest.raises(coupling.CouplingError, match="needs the load pressure_jump"):
        coupling.Iterated([rod], fluid, Iterated())


def test_iterated_scheme_refuses_a_unit_without_rollback():
    rod = Spring()
    rod.can_roll_back = False
    with pytest.raises(coupling.CouplingError, match="the rod cannot restore its state"):
        coupling.Iterated([rod], AddedMass(), Iterated())


def test_missing_output_is_named():
    rod = Spring()
    del rod.variables["vy"]
    with pytest.raises(coupling.CouplingError, match="fluid has the input `vy`, but the rod has no such output"):
        coupling.Explicit([rod], AddedMass())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": [None] * 3}, "size of `y` is 2 at the fluid, but 3 at the rod"),
        ({"unit": "mm"}, "unit of `y` is m at the fluid, but mm at the rod"),
        ({"kind": "Integer"}, "kind of `y` is Real at the fluid, but Integer at the rod"),
    ],
)
def test_quantities_that_do_not_fit_are_named(change, message):
    rod = Spring()
    for field, value in change.items():
        setattr(rod.variables["y"], field, value)
    with pytest.raises(coupling.CouplingError, match=message):
        coupling.Explicit([rod], AddedMass())


def test_a_failing_unit_leaves_what_was_computed_before():
    scheme = coupling.Explicit([Spring()], AddedMass())

    def fail(t, _h):
        if t >= 0.1:
            raise UnitError("fluid: no solution")

    scheme.fluid.advance = fail
    outcome, recorder = run(scheme)
    assert (outcome.error, outcome.completed, outcome.steps) == ("fluid: no solution", False, 10)
    assert recorder.rows == 11


def test_a_stopped_run_is_not_completed():
    asked = iter([False] * 7 + [True])
    outcome, recorder = run(coupling.Explicit([Spring()], AddedMass()), stopping=lambda: next(asked))
    assert (outcome.error, outcome.completed, outcome.steps) == (None, False, 7)
    assert recorder.rows == 8


@pytest.mark.parametrize(
    ("end", "step", "steps", "last"),
    [(8.0, 2e-4, 40000, 2e-4), (1.0, 0.3, 4, 0.1), (0.1, 0.3, 1, 0.1), (0.3, 0.1, 3, 0.1)],
)
def test_time_grid_lands_on_the_end(end, step, steps, last):
    grid = TimeGrid(end, step)
    assert grid.steps == steps
    t, h = grid.step(steps - 1)
    assert t + h == pytest.approx(end, rel=1e-15)
    assert h == pytest.approx(last, rel=1e-9)


@pytest.mark.parametrize(("steps", "stride"), [(200_000, 1), (200_001, 2), (399_999, 2), (1_000_000, 5)])
def test_long_runs_are_recorded_in_a_table_of_bounded_size(steps, stride):
    recorder = Recorder({"rod": Spring()}, steps)
    for step in range(0, steps + 1, 1 if steps < 300_000 else stride):
        recorder.record(step, float(step), 1)
    assert recorder.rows == len(recorder.table) == steps // stride + 1 <= 200_001, (recorder.rows, steps)
    assert recorder.series["time"].tolist() == list(range(0, steps + 1, stride))
