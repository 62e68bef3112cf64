"""Every variable of both units does what its name says: set one, see what moves."""

import copy

import numpy as np
import pytest

from nervure.scene import assign, load

H = 1e-3

SECTION = {"line_density": 20.0, "bending_stiffness": 1.1, "axial_stiffness": 3e4, "shear_stiffness": 1e4}


@pytest.fixture
def bar(rod_only):
    """A rod in the plane with all parameters, whose root is the master's."""
    rod_only["rod"] |= {
        "material": {"section": dict(SECTION)},
        "damping": 3.0,
        "clamp_compliance_length": 2e-3,
        "root_motion": "master",
    }
    rod_only["time"]["end"] = 1.0
    return rod_only


@pytest.fixture
def still(bar):
    """The same without gravity."""
    bar["rod"]["gravity"] = [0.0, 0.0]
    return bar


@pytest.fixture
def spatial(still):
    """The same in space, along x."""
    still["beam"]["root"]["at"] = {"position": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    still["rod"]["gravity"] = [0.0, 0.0, 0.0]
    del still["rod"]["material"]["section"]["shear_stiffness"]
    return still


@pytest.fixture
def run(instantiate):
    """Function that makes the unit `kind` of a scene, sets values by name (an array's by its first reference and index)
    and makes some steps; returns the unit."""

    def make(scene, kind="rod", parameters=None, inputs=None, steps=5):
        unit = instantiate(scene)[kind]
        reals = {v.name: v for v in unit.variables.values() if v.kind == "Real"}
        unit.fmu.setReal([reals[name].references[0] for name in parameters or {}], list((parameters or {}).values()))
        unit.start()
        for (name, element), value in (inputs or {}).items():
            unit.fmu.setReal([reals[name].references[element]], [value])
        for k in range(steps):
            unit.fmu.doStep(currentCommunicationPoint=k * H, communicationStepSize=H)
        unit.read = lambda name: np.array(unit.fmu.getReal(reals[name].references))
        return unit

    return make


ROD_KEYS = {
    "line_density": "rod.material.section.line_density",
    "bending_stiffness": "rod.material.section.bending_stiffness",
    "axial_stiffness": "rod.material.section.axial_stiffness",
    "shear_stiffness": "rod.material.section.shear_stiffness",
    "damping": "rod.damping",
    "clamp_compliance_length": "rod.clamp_compliance_length",
    "gravity.x": "rod.gravity.0",
    "gravity.y": "rod.gravity.1",
}
FLUID_KEYS = {
    "density": "fluid.density",
    "kinematic_viscosity": "fluid.kinematic_viscosity",
    "c_eta": "fluid.mask.cosine.c_eta",
    "max_step": "fluid.time_stepping.max_step",
    "max_cfl": "fluid.time_stepping.max_cfl",
}


@pytest.mark.parametrize("name", ROD_KEYS)
def test_parameter_of_the_rod_is_the_key_of_the_scene(name, bar, run):
    bar["rod"]["gravity"] = [1.0, -2.0]
    value = 0.7 * run(bar, steps=0).read(name)[0]
    changed = copy.deepcopy(bar)
    assign(changed, ROD_KEYS[name], value)
    by_parameter, by_key, unchanged = run(bar, parameters={name: value}), run(changed), run(bar)
    for output in ("x", "y", "vx", "vy"):
        assert np.array_equal(by_parameter.read(output), by_key.read(output)), output
    assert not np.array_equal(by_parameter.read("vy"), unchanged.read("vy"))


def test_displaced_line_density_is_that_of_the_fluid(small_fsi3, run):
    small_fsi3["rod"]["gravity"] = [0.0, -2.0]
    lighter = copy.deepcopy(small_fsi3)
    lighter["fluid"]["density"] = 700.0
    by_parameter = run(small_fsi3, parameters={"displaced_line_density": 14.0})
    assert np.array_equal(by_parameter.read("y"), run(lighter).read("y"))
    assert not np.array_equal(by_parameter.read("y"), run(small_fsi3).read("y"))


@pytest.mark.parametrize("name", FLUID_KEYS)
def test_parameter_of_the_fluid_is_the_key_of_the_scene(name, fluid_only, run):
    value = 0.3 * run(fluid_only, "fluid", steps=0).read(name)[0]
    if name == "max_cfl":
        value = 0.01  # what the flow would exceed
    changed = copy.deepcopy(fluid_only)
    assign(changed, FLUID_KEYS[name], value)
    found = [run(fluid_only, "fluid", {name: value}), run(changed, "fluid"), run(fluid_only, "fluid")]
    by_parameter, by_key, unchanged = (
        [unit.read(name)[0] for name in ("drag", "cfl", "kinetic_energy")] for unit in found
    )
    assert by_parameter == by_key
    assert by_parameter != unchanged


def test_no_parameter_of_the_fluid_chooses_another_load(instantiate):
    """Where a scene leaves the load open, a shorter step is taken, and a fluid too heavy for the load refused."""
    scene = load("vein-pitching-320x240", ["fluid.box.cells=[80, 60]"]).document()
    for name, value in {"max_step": 0.3, "density": 3.0}.items():
        unit = instantiate(scene)["fluid"]
        reals = {v.name: v.references for v in unit.variables.values() if v.kind == "Real"}
        (before,) = unit.fmu.getReal(reals[name])
        unit.fmu.setReal(reals[name], [value * before])
        if name == "density":
            with pytest.raises(Exception, match="the rod weighs .* of the fluid it displaces"):
                unit.start()
        else:
            unit.start()
            assert np.isfinite(unit.fmu.getReal(reals["force_x"])).all()


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("station", [3, 12])
def test_force_moves_its_station_along_its_axis(axis, station, spatial, run):
    unit = run(spatial, inputs={(f"force_{axis}", station): 1e-3}, steps=1)
    moved = {other: unit.read(f"v{other}") for other in "xyz"}
    assert np.argmax(np.abs(moved[axis])) == station and moved[axis][station] > 0.0, moved[axis]
    for other in set("xyz") - {axis}:
        assert np.abs(moved[other]).max() < 1e-3 * moved[axis][station], other
    assert [unit.read(f"load.{other}")[0] for other in "xyz"] == [1e-3 * (other == axis) for other in "xyz"]


def test_pressure_jump_pushes_its_station_to_the_right_of_the_way_to_the_tip(still, run):
    unit = run(still, inputs={("pressure_jump", 7): 2.0}, steps=1)
    moved = unit.read("vy")
    assert np.argmax(np.abs(moved)) == 7 and moved[7] < 0.0, moved
    length = 0.35 / 16
    assert unit.read("load.y")[0] == pytest.approx(-2.0 * length, rel=1e-12)


@pytest.mark.parametrize("station", [4, 11])
def test_impedance_holds_its_station(station, small_fsi3, run):
    small_fsi3["rod"]["max_step"] = H
    pushed = {("force_y", k): 0.1 for k in range(21)}
    free, held = (
        run(small_fsi3, inputs=pushed, steps=1),
        run(small_fsi3, inputs=pushed | {("impedance", station): 10.0}, steps=1),
    )
    assert 0.0 < held.read("vy")[station] < free.read("vy")[station]
    # The load falls from the velocity at the beginning of the step on, which was 0.
    taken = 0.1 * 21 - 10.0 * held.read("vy")[station]
    assert held.read("load.y")[0] == pytest.approx(taken, rel=1e-12)


@pytest.mark.parametrize("axis", "xy")
def test_root_moves_the_rod_along_its_axis(axis, still, run):
    there = 2e-3
    before, unit = (
        run(still, steps=0),
        run(still, inputs={(f"root.{axis}", 0): there, (f"root.v{axis}", 0): there / H}, steps=1),
    )
    other = "y" if axis == "x" else "x"
    moved, across = (unit.read(name) - before.read(name) for name in (axis, other))
    assert moved[0] == pytest.approx(there, rel=1e-12) and moved[1] > 0.05 * there, moved
    assert unit.read(f"v{axis}")[0] == there / H and unit.read(f"v{other}")[0] == 0.0
    assert abs(across[0]) == 0.0 and np.abs(across).max() < 0.05 * there, across
    assert unit.read(f"rigid_tip.u{axis}")[0] == pytest.approx(there, rel=1e-12)
    power = unit.read(f"root.force_{axis}")[0] * there / H
    assert unit.read("root.power")[0] == pytest.approx(power, rel=1e-12) and power != 0.0


def test_root_angle_turns_the_rod_to_the_left(still, run):
    unit = run(still, inputs={("root.angle", 0): 0.01, ("root.omega", 0): 10.0}, steps=1)
    assert unit.read("y")[1] > 0.02 * 0.01 * 0.35 / 16 and unit.read("vy")[1] > 0.0
    assert unit.read("rigid_tip.uy")[0] == pytest.approx(0.35 * np.sin(0.01), rel=1e-12)
    assert unit.read("rigid_tip.ux")[0] == pytest.approx(0.35 * (np.cos(0.01) - 1.0), rel=1e-9)
    assert unit.read("root.moment")[0] > 0.0
    power = unit.read("root.moment")[0] * 10.0
    assert unit.read("root.power")[0] == pytest.approx(power, rel=1e-12)
    assert unit.read("root.work")[0] == pytest.approx(power * H, rel=1e-12)


@pytest.mark.parametrize(("name", "seen", "turning"), [("direction.y", "uy", "z"), ("direction.z", "uz", "y")])
def test_root_direction_turns_the_rod_in_space(name, seen, turning, spatial, run):
    unit = run(spatial, inputs={(f"root.{name}", 0): 0.01}, steps=1)
    assert unit.read(f"rigid_tip.{seen}")[0] == pytest.approx(0.35 * 0.01 / np.hypot(1.0, 0.01), rel=1e-9)
    moments = {axis: abs(unit.read(f"root.moment_{axis}")[0]) for axis in "xyz"}
    assert max(moments, key=moments.__getitem__) == turning, moments


def test_outputs_of_the_rod_follow_from_its_stations(bar, run):
    """Tip, energies and powers from the positions and velocities that the unit shows."""
    unit, rest = run(bar, inputs={("force_x", 5): 0.3, ("force_y", 9): -0.2}, steps=40), run(bar, steps=0)
    x, y, vx, vy = (unit.read(name) for name in ("x", "y", "vx", "vy"))
    mass = SECTION["line_density"] * 0.35 / 16 * np.r_[0.5, np.ones(15), 0.5]
    share = mass / SECTION["line_density"]
    expected = {
        "tip.ux": x[-1] - rest.read("x")[-1],
        "tip.uy": y[-1] - rest.read("y")[-1],
        "tip.vx": vx[-1],
        "tip.vy": vy[-1],
        "load.x": 0.3,
        "load.y": -0.2,
        "load.power": 0.3 * vx[5] - 0.2 * vy[9],
        "energy.kinetic": 0.5 * mass @ (vx**2 + vy**2),
        "energy.gravity": 2.0 * mass @ (y - y[0]),
        "damping.power": 3.0 * share @ (vx**2 + vy**2),
    }
    assert {name: unit.read(name)[0] for name in expected} == pytest.approx(expected, rel=1e-9)
    done = unit.read("load.work")[0] - unit.read("energy.kinetic")[0] - unit.read("energy.gravity")[0]
    assert 0.5 * done < unit.read("energy.elastic")[0] < done, "what work and fall leave, less what the damping took"


@pytest.fixture
def flow(fluid_only):
    """A stream past a cylinder and, away from it, a beam, with a probe beside either."""
    fluid_only["fluid"]["cylinders"] = [{"center": [-0.4, 0.0], "radius": 0.1}]
    fluid_only["fluid"]["mask"] = {"log_linear": {"c_eta": 1e-4}}
    probes = {"above": [0.5, 0.15], "ahead": [-0.55, 0.0], "behind": [-0.25, 0.0]}
    fluid_only["fluid"]["probes"] = [{"name": name, "position": at} for name, at in probes.items()]
    root = {"at": {"position": [0.3, 0.0], "direction": [1.0, 0.0]}}
    fluid_only["beam"] = {"root": root, "length": 0.4, "thickness": 0.1, "segments": 8}
    return fluid_only


def test_positions_of_the_stations_are_where_the_fluid_is_held(flow, run):
    at_rest = run(flow, "fluid")
    along = at_rest.read("x")
    assert along == pytest.approx(np.linspace(0.3, 0.7, 9), abs=1e-15) and not at_rest.read("y").any()
    raised = run(flow, "fluid", inputs={("y", k): 0.15 for k in range(9)})
    assert abs(raised.read("probe.above.u")[0]) < 0.1 and at_rest.read("probe.above.u")[0] > 0.5
    ahead = run(flow, "fluid", inputs={("y", k): 0.15 for k in range(9)} | {("x", k): along[k] - 0.3 for k in range(9)})
    assert ahead.read("probe.above.u")[0] > 0.5, "the beam has gone"


@pytest.mark.parametrize(("axis", "force", "load"), [("x", "drag", "force_x"), ("y", "lift", "force_y")])
def test_moving_stations_are_held_back_along_their_axis(axis, force, load, flow, run):
    flow["fluid"]["initial_velocity"], flow["fluid"]["inflow"] = [0.0, 0.0], None
    pushed = run(flow, "fluid", inputs={(f"v{axis}", k): 1.0 for k in range(9)})
    other = {"drag": "lift", "lift": "drag"}[force]
    assert (
        pushed.read(f"beam.{force}")[0] < 0.0
        and abs(pushed.read(f"beam.{other}")[0]) < -0.3 * pushed.read(f"beam.{force}")[0]
    )
    one = run(flow, "fluid", inputs={(f"v{axis}", 4): 1.0}).read(load)
    assert np.argmin(one) == 4 and one[4] < 0.0, one


def test_forces_and_probes_tell_bodies_and_sides_apart(flow, run):
    unit = run(flow, "fluid", steps=20)
    for total, parts in (("drag", "drag"), ("lift", "lift")):
        found = unit.read(f"cylinder[1].{parts}")[0] + unit.read(f"beam.{parts}")[0]
        assert unit.read(total)[0] == pytest.approx(found, rel=1e-9, abs=1e-12)
    assert (
        unit.read("cylinder[1].drag")[0] > 0.0
        and abs(unit.read("cylinder[1].lift")[0]) < 0.05 * unit.read("cylinder[1].drag")[0]
    )
    assert unit.read("probe.ahead.p")[0] > unit.read("probe.behind.p")[0]
    assert unit.read("probe.above.u")[0] > 0.5 > abs(unit.read("probe.above.v")[0])
    tilted = copy.deepcopy(flow)
    tilted["fluid"]["initial_velocity"] = [1.0, 0.5]
    lifted = run(tilted, "fluid", steps=20)
    assert lifted.read("beam.lift")[0] > 0.0 < lifted.read("probe.above.v")[0]
    assert lifted.read("pressure_jump")[4] < 0.0, "the stream comes from below"
    assert lifted.read("beam.moment")[0] > 0.0, "and turns the beam to the left about its root"


def test_newton_outputs_count_sub_steps_and_iterations(still, instantiate):
    """Four sub-steps where `max_step` asks for them, each with at least one iteration. A long step under a push needs
    shift and line search, and meets negative pivots only past Euler's load."""
    del still["rod"]["material"]["section"]["shear_stiffness"]
    euler = np.pi**2 * SECTION["bending_stiffness"] / (4 * still["beam"]["length"] ** 2)
    still["time"]["end"] = 10.0

    def newton(step, push, **keys):
        scene = copy.deepcopy(still)
        scene["rod"] |= keys
        unit = instantiate(scene)["rod"]
        unit.start()
        unit.fmu.setReal([unit.variables["force_x"].references[-1]], [push])
        unit.fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=step)
        names = ("iterations", "substeps", "rescues", "negative_pivots")
        return unit.fmu.getInteger([unit.variables[f"newton.{name}"].references[0] for name in names])

    iterations, substeps, rescues, pivots = newton(0.01, 0.0, max_step=2.5e-3)
    assert (substeps, rescues, pivots) == (4, 0, 0) and iterations >= 2 * substeps, iterations
    iterations, substeps, rescues, pivots = newton(0.7, -0.5 * euler, max_step=0.7)
    assert (substeps, pivots) == (1, 0) and 0 < rescues < iterations
    iterations, substeps, rescues, pivots = newton(0.7, -4 * euler, max_step=0.7)
    assert substeps == 1 and pivots > 0 and rescues > 0 and iterations > rescues + pivots
