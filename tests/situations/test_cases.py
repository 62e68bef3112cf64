"""Situations that people reported of similar tools, each by the name of its report: what is right comes out.

They are shortened and on coarse grids. More inputs of the same kinds are in `test_situations.py`, `test_geometry.py`
and `test_foreign_units.py`.
"""

import copy
import json
import math
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from pythonfmu.builder import FmuBuilder

from nervure import coupling
from nervure.errors import UnitFailure
from nervure.library import check, facts
from nervure.resources import ROOT
from nervure.scene import assign, validate
from nervure.simulation.results import Results
from nervure.simulation.session import Session
from tests.conftest import nervure as command
from tests.reliability.checks import unpack
from tests.reliability.unit import FMU2Unit

pytestmark = pytest.mark.usefixtures("libraries")

Scene = dict[str, Any]


def changed(scene: Scene, **changes: Any) -> Scene:
    """Return the scene with other values of keys, in which `__` stands for a point."""
    scene = copy.deepcopy(scene)
    for key, value in changes.items():
        assign(scene, key.replace("__", "."), value)
    return scene


def flow(box: Scene, nu: float, step: float, **more: Any) -> Scene:
    """Return a fluid of density 1."""
    own = {"density": 1.0, "kinematic_viscosity": nu, "box": box, "mask": {"log_linear": {"c_eta": 1e-4}}}
    return own | {"time_stepping": {"max_step": step, "max_cfl": 0.4}} | more


def stream(until: float, begin: float) -> Scene:
    """Return a stream that begins at once, and its sponge."""
    sponge = {"x": [begin, until], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1}
    return {"initial_velocity": [1.0, 0.0], "mean_flow": {"x": {"constant": 1.0}}, "sponge": sponge}


def beam(length: float, thickness: float, segments: int, x: float = 1.0, y: float = 0.0) -> Scene:
    """Return a beam whose root is at the origin, in a direction."""
    root = {"at": {"position": [0.0, 0.0], "direction": [x, y]}}
    return {"root": root, "length": length, "thickness": thickness, "segments": segments}


def rod(line_density: float, bending: float, axial: float, **more: Any) -> Scene:
    """Return a rod of a section."""
    section = {"line_density": line_density, "bending_stiffness": bending, "axial_stiffness": axial}
    return {"material": {"section": section}} | more


def circle(x: float, y: float, radius: float, **more: Any) -> Scene:
    """Return a circular body."""
    return {"shape": {"circle": {"radius": radius}}, "position": [x, y]} | more


def clock(end: float, step: float) -> Scene:
    """Return end and step of a run."""
    return {"end": end, "communication_step": step}


def sine(amplitude: float, frequency: float, **more: float) -> Scene:
    """Return a law of a sine."""
    return {"sine": {"amplitude": amplitude, "frequency": frequency} | more}


CHANNEL = {
    "name": "channel",
    "time": clock(1.0, 0.01),
    "fluid": flow(
        {"x": [-2.0, 4.0], "y": [-1.5, 1.5], "cells": [120, 60]},
        0.01,
        0.01,
        channel={"y": [-1.0, 1.0]},
        inflow={
            "x": [-2.0, -1.5],
            "profile": "parabolic",
            "mean_velocity": {"cosine_ramp": {"value": 1.0, "duration": 0.5}},
            "c_eta": 1e-3,
        },
    ),
}
CYLINDER = {
    "name": "cylinder",
    "time": clock(80.0, 0.015),
    "fluid": flow({"x": [-6.0, 14.0], "y": [-6.0, 6.0], "cells": [320, 192]}, 0.01, 0.015, **stream(14.0, 11.0)),
}
BLADE = {
    "name": "blade",
    "time": clock(14.0, 0.02),
    "fluid": flow({"x": [-3.0, 3.0], "y": [-2.0, 4.0], "cells": [48, 48]}, 0.01, 0.02),
    "beam": beam(1.0, 0.2, 8, 0.0, 1.0),
    "rod": rod(0.6, 1.2, 1000.0, scheme="bdf2"),
}
PAIR = {
    "name": "pair",
    "time": clock(0.2, 0.004),
    "fluid": flow({"x": [-1.0, 3.0], "y": [-1.0, 1.0], "cells": [96, 48]}, 0.01, 0.004, **stream(3.0, 2.4)),
    "beam": beam(1.0, 0.15, 8, 1.0, 0.3),
    "rod": {
        "material": {"plane_strain": {"density": 5.0, "youngs_modulus": 4000.0, "poisson_ratio": 0.3}},
        "scheme": "bdf2",
    },
    "coupling": {"load": "momentum", "scheme": "explicit"},
}
JUMP = changed(PAIR, coupling={"load": "pressure_jump"}, time=clock(0.24, 0.008), beam__segments=24)


class Bench:
    """What a situation is tried with."""

    def __init__(self, folder, packed, instantiate):
        self.folder, self.packed, self.instantiate = folder, packed, instantiate

    def run(self, scene: Scene) -> Results:
        with Session(validate(scene), self.folder / scene["name"]) as session:
            assert session.run().error is None
            return session.finish()

    def command(self, scene: Scene, *arguments: Any, output: str = "results") -> subprocess.CompletedProcess:
        path = self.folder / "scene.json"
        path.write_text(json.dumps(scene))
        return command("run", path, "--output", self.folder / output, "--quiet", "--force", *arguments)

    def modal(self, name: str, scene: Scene, change: Callable[[str], str] = str) -> Any:
        """Pack the modal beam of `examples` with a change of its text."""
        folder = self.folder / name
        folder.mkdir()
        (folder / "scene.json").write_text(json.dumps(scene))
        (folder / f"contract_{name}.py").write_text(jump_in_contract((ROOT / "examples" / "contract.py").read_text()))
        text = (
            (ROOT / "examples" / "modal_beam.py")
            .read_text()
            .replace("from contract import", f"from contract_{name} import")
        )
        (folder / f"{name}.py").write_text(change(text))
        files = [folder / f"contract_{name}.py", folder / "scene.json"]
        states = {"canGetAndSetFMUstate": True, "canSerializeFMUstate": True}
        FmuBuilder.build_FMU(folder / f"{name}.py", dest=folder / f"{name}.fmu", project_files=files, **states)
        return folder / f"{name}.fmu"


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    return text


def jump_in_contract(text: str) -> str:
    """Let the contract of the examples take the pressure jump too."""
    return replaced(
        text,
        ('!= "momentum"', 'not in ("momentum", "pressure_jump")'),
        ("BASE_UNITS = {", 'BASE_UNITS = {\n    "Pa": {"kg": 1, "m": -1, "s": -2},'),
    )


def under_pressure(text: str) -> str:
    """Let the modal beam take the pressure jump, with the whole mass."""
    return replaced(
        text,
        ('material["density"] - self.scene["fluid"]["density"]', 'material["density"]'),
        ('"force_x", "force_y", "impedance")\n', '"pressure_jump")\n'),
        ("self.vx, self.vy,", "self.pressure_jump = np.zeros_like(self.s)\n        self.vx, self.vy,"),
        ('(("force_x", "N/m"), ("force_y", "N/m"), ("impedance", "kg/(m.s)"))', '(("pressure_jump", "Pa"),)'),
        (
            "force = self.normal @ (self.force_x, self.force_y)",
            'force = -self.pressure_jump * station_lengths(self.scene["beam"])',
        ),
        ("backward_differences, root_of", "backward_differences, root_of, station_lengths"),
    )


@pytest.fixture
def bench(tmp_path, packed, instantiate):
    return Bench(tmp_path, packed, instantiate)


def blades(bench):
    """The same physics turned by 90 degrees has the same numbers."""
    up = changed(BLADE, fluid__mean_flow={"x": sine(1.0, 0.25, ramp=4.0)})
    turned = changed(BLADE, name="turned", fluid__mean_flow={"y": sine(1.0, 0.25, ramp=4.0)})
    turned["fluid"]["box"] |= {"x": [-2.0, 4.0], "y": [-3.0, 3.0]}
    turned["beam"]["root"]["at"]["direction"] = [1.0, 0.0]
    one, other = (bench.run(scene).summary for scene in (up, turned))
    assert one.window_s == pytest.approx(other.window_s) and one.periods == other.periods >= 1
    across, along = one.quantities["tip_ux"], other.quantities["tip_uy"]
    assert across.frequency_hz == pytest.approx(0.25, rel=0.05)
    assert along.frequency_hz == pytest.approx(across.frequency_hz, rel=1e-6)
    assert along.amplitude == pytest.approx(across.amplitude, rel=1e-6)
    found = [summary.bodies["beam"].st_tip for summary in (one, other)]
    assert found[0] == pytest.approx(found[1], rel=1e-6) and found[0] > 0.1


def blocked(bench):
    (fault,) = check(json.dumps(changed(CHANNEL, fluid__bodies=[circle(0.0, 0.0, 1.2)])))
    assert fault.key == "fluid.bodies[0].position" and "fills the channel from -1 to 1" in fault.text


def in_inflow(bench):
    (fault,) = check(json.dumps(changed(CHANNEL, fluid__bodies=[circle(-1.7, 0.0, 0.3)])))
    assert fault.key == "fluid.bodies[0].position" and "in the inflow zone, x [-2.0, -1.5]" in fault.text


def bodies_collide(bench):
    moved = circle(-0.5, 0.0, 0.3, motion={"x": sine(1.0, 0.5)})
    warning, *_ = facts(json.dumps(changed(CHANNEL, fluid__bodies=[moved, circle(0.6, 0.0, 0.3)])))["warnings"]
    assert warning["text"].startswith("`fluid.bodies[1]` meets `fluid.bodies[0]` near [0.")
    # Half a metre is left between them: sin(pi t) = 0.5.
    assert warning["time"] == pytest.approx(1 / 6, abs=0.01)


def cant_3d_z(bench):
    """0.56 Hz, the first mode of a cantilever, and 10 whole periods of the 11 of the run."""
    held = beam(1.0, 0.02, 24)
    held["root"]["at"] = {"position": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    own = rod(1.0, 1.0, 1e4, gravity=[0.0, 0.0, -0.5], scheme="trapezoid")
    summary = bench.run({"name": "cantilever", "time": clock(20.0, 0.01), "beam": held, "rod": own}).summary
    assert summary.periods == 10
    assert summary.quantities["tip_uz"].frequency_hz == pytest.approx(1.8751**2 / (2 * math.pi), rel=0.01)


def pressed_beam(bench):
    """The modal beam under the pressure jump, whose modules have names of their own, moves as the rod does: with 8
    segments they are 7 % apart, with 24 2 %."""
    fmu = bench.modal("whole", JUMP, under_pressure)
    paths = []
    for arguments, output in ((["--rod-fmu", fmu], "foreign"), ([], "own")):
        done = bench.command(JUMP, *arguments, output=output)
        assert done.returncode == 0, done.stderr
        paths.append(np.genfromtxt(bench.folder / output / "series.csv", delimiter=",", names=True)["tip_uy"])
    foreign, own = paths
    assert np.abs(foreign - own).max() < 0.03 * np.abs(own).max()


def half_a_state(bench):
    fmu = bench.modal("half", JUMP, lambda text: replaced(under_pressure(text), ('"v_before", "h_before", ', "")))
    done = bench.command(JUMP, "--rod-fmu", fmu)
    assert done.returncode == 1 and "the rod does not come back to the state that it saved" in done.stderr


def exitinit(bench):
    failing = '    def exit_initialization_mode(self):\n        raise RuntimeError("no licence")\n\n    def do_step'
    fmu = bench.modal("exitinit", PAIR, lambda text: replaced(text, ("    def do_step", failing)))
    done = bench.command(PAIR, "--rod-fmu", fmu)
    assert (done.returncode, done.stderr) == (1, "error: rod: no licence\n")


def nans(bench):
    """The unit gives no number from the first step after 0.1 s on."""
    begin = "step_size: float) -> bool:\n"
    spoilt = "        if current_time > 0.1:\n            self.x[-1] = float('nan')\n            return True\n"
    fmu = bench.modal("nans", PAIR, lambda text: replaced(text, (begin, begin + spoilt)))
    done = bench.command(PAIR, "--rod-fmu", fmu)
    assert done.returncode == 1 and done.stderr.startswith("error: rod: its output x[9] is nan m at t = 0.108 s")


def pair_small(bench):
    """The pair by itself runs: the rods of others are refused for what they are."""
    done = bench.command(PAIR)
    assert done.returncode == 0, done.stderr


def short_rod(bench):
    done = bench.command(PAIR, "--rod-fmu", bench.packed("rod", changed(PAIR, name="short-rod", beam__length=0.5)))
    assert done.returncode == 2
    assert "the FMU of the rod, short-rod.rod, is of another scene than pair: its station 9" in done.stderr


def light_rod(bench):
    done = bench.command(PAIR, "--rod-fmu", bench.packed("rod", changed(PAIR, name="light-rod", fluid__density=4.0)))
    assert done.returncode == 2
    assert "light-rod.rod, is of another scene than pair: its `displaced_line_density` is 0.6 kg/m2" in done.stderr


def filament_gravity(bench):
    """At a step of 5 ms the fluid divides what a filament under a thousand times its weight moves. It holds, as units
    exchange in each of its steps; with one exchange the guard stopped it."""
    scene = {
        "name": "filament",
        "time": clock(0.5, 5e-3),
        "fluid": flow({"x": [-1.0, 4.0], "y": [-2.0, 2.0], "cells": [80, 64]}, 5e-3, 5e-3, **stream(4.0, 3.2)),
        "beam": beam(1.0, 0.08, 32, 0.951, 0.309),
        "rod": rod(1.5, 1.5e-3, 1000.0, gravity=[500.0, 0.0], root="pinned", scheme="bdf2"),
        "coupling": {"guards": {"window_steps": 50}},
    }
    with Session(validate(scene)) as session:
        assert session.run().error is None and session.recorder.series["iterations"].max() > 1


def fluid_fold_nan(bench):
    """A station in front of the one before it."""
    for version in (2, 3):
        scheme = coupling.couple(bench.instantiate(PAIR, version), validate(PAIR).coupling)
        assert isinstance(scheme, coupling.Explicit)
        scheme.start()
        scheme.step(0.0, 0.004)
        x, y = scheme.fluid.inputs[:9], scheme.fluid.inputs[9:18]
        assert (np.diff(x) > 0.0).all()
        x[3], y[3] = 1.1 * x[2] - 0.1 * x[3], 1.1 * y[2] - 0.1 * y[3]
        with pytest.raises(UnitFailure, match="fold"):
            scheme.fluid.step(0.004, 0.004)


def law_table_20(bench):
    """A table of a sine by 20 points a period drives as the sine does, but for the ends of the table."""

    def root_force(name: str, law: Scene) -> np.ndarray:
        own = rod(0.5, 2.0, 1000.0, damping=0.0, root_motion={"laws": {"y": law}})
        series = bench.run({"name": name, "time": clock(4.0, 0.004), "beam": beam(1.0, 0.05, 20), "rod": own}).series
        return series["root_force_y"][(series["time"] > 0.5) & (series["time"] < 3.8)]

    times = np.arange(81) / 20
    points = (0.2 * np.sin(2 * np.pi * times)).tolist()
    exact = root_force("sine", sine(0.2, 1.0))
    table = root_force("table", {"table": {"times": times.tolist(), "values": points}})
    assert np.sqrt(np.mean((table - exact) ** 2) / np.mean(exact**2)) < 0.03


def load_unload_leak(bench):
    """An instance, a step and the library gone again."""
    for kind in ("rod", "fluid"):
        done = subprocess.run([sys.executable, "-c", LOADS, kind, str(bench.folder)], capture_output=True, text=True)
        assert done.returncode == 0 and float(done.stdout) < 20.0, done.stdout + done.stderr


LOADS = """
import _ctypes, sys, pathlib
from tests.reliability.checks import unpack
from tests.reliability.unit import FMU2Unit
unit = FMU2Unit(sys.argv[1], unpack(sys.argv[1], pathlib.Path(sys.argv[2])))
def size():
    return 4 * int(pathlib.Path("/proc/self/statm").read_text().split()[1])
def once():
    new = unit.new()
    new.step()
    new.close()
    _ctypes.dlclose(unit.dll._handle)
    unit.load()
for _ in range(20):
    once()
begin = size()
for _ in range(60):
    once()
print((size() - begin) / 60)
"""


def long_description(bench):
    path = bench.folder / "long.json"
    path.write_text(json.dumps(changed(CHANNEL, description="x" * 10_000_000)))
    done = command("inspect", path)
    assert done.returncode == 2 and "is larger than 4 MB" in done.stderr


def mooring(bench):
    hanging = beam(40.0, 0.06, 39, 0.0, -1.0)
    own = rod(3.0, 10.0, 5e7, damping=0.0, gravity=[0.0, -9.81], root_motion="master")
    done = bench.command({"name": "mooring", "time": clock(10.0, 0.01), "beam": hanging, "rod": own})
    assert done.returncode == 2 and "to the master (root_motion)" in done.stderr


def nosponge(bench):
    scene = changed(CYLINDER, fluid__sponge=None, fluid__bodies=[circle(0.0, 0.02, 0.5)])
    (warning,) = facts(json.dumps(scene))["warnings"]
    assert "without a `sponge`: `fluid.bodies[0]` is in its own wake from t = 20" in warning["text"]


def sym_cylinder(bench):
    scene = changed(CYLINDER, fluid__bodies=[circle(0.0, 0.0, 0.5)])
    (warning,) = facts(json.dumps(scene))["warnings"]
    assert warning["key"] == "fluid.disturbance" and "mirror images at y = 0" in warning["text"]
    assert facts(json.dumps(changed(scene, fluid__disturbance=0.01)))["warnings"] == []


def rates(bench):
    """Two points of a table are a constant rate, as four on the same line are."""
    forces = []
    for times in ([-10.0, 100.0], [-10.0, -5.0, 95.0, 100.0]):
        law = {"angle": {"table": {"times": times, "values": [t / 5 for t in times]}}}
        box = {"x": [-6.0, 14.0], "y": [-6.0, 6.0], "cells": [80, 48]}
        fluid = flow(box, 0.05, 0.04, bodies=[circle(0.0, 0.0, 0.5, motion=law)], **stream(14.0, 11.0))
        series = bench.run({"name": f"rate-{len(times)}", "time": clock(2.0, 0.04), "fluid": fluid}).series
        assert series["body_1_angle"] == pytest.approx(series["time"] / 5, abs=1e-9)
        forces.append(series["lift"])
    assert forces[0] == pytest.approx(forces[1], rel=1e-6, abs=1e-9) and abs(forces[0][-1]) > 0.01


def rod_drive_inf(bench):
    """A root that turns with 1.7e308 rad/s: the step is refused, and the state can be put back."""
    own = rod(1.0, 1.0, 1e4, root_motion="master")
    scene = {"name": "master", "time": clock(1.0, 5e-3), "beam": beam(1.0, 0.02, 8), "rod": own}
    for version in (2, 3):
        (unit,) = bench.instantiate(scene, version).values()
        names = ["root.angle", "root.omega"]
        unit.connect(names, ["x", "y"])
        unit.start()
        unit.step(0.0, 5e-3)
        state = unit.serialize()
        unit.inputs[:] = [1.0, 1.7e308]
        with pytest.raises(UnitFailure):
            unit.step(5e-3, 5e-3)
        unit.deserialize(state)
        unit.inputs[:] = 0.0
        unit.step(5e-3, 5e-3)
        assert np.isfinite(unit.outputs).all()


def shed_squares(bench):
    """An impulsive start and a ramp end in the same statistics, and the start-up is no part of them."""
    fluid = flow(
        {"x": [-4.0, 10.0], "y": [-4.0, 4.0], "cells": [84, 48]},
        0.01,
        0.04,
        bodies=[{"shape": {"rectangle": {"length": 1.0, "thickness": 1.0}}, "position": [0.0, 0.02]}],
        disturbance=0.1,
        **stream(10.0, 8.0),
    )
    impulse = {"name": "impulse", "time": clock(60.0, 0.04), "fluid": fluid}
    ramp = {"cosine_ramp": {"value": 1.0, "duration": 2.0}}
    smooth = changed(impulse, name="ramp", fluid__initial_velocity=[0.0, 0.0], fluid__mean_flow={"x": ramp})
    found = [bench.run(scene).summary for scene in (impulse, smooth)]
    for summary in found:
        assert summary.window_s[0] > 15.0 and summary.periods >= 2, summary.window_s
    for name, value, share in (("lift", "frequency_hz", 0.02), ("drag", "mean", 0.02)):
        one, other = (getattr(summary.quantities[name], value) for summary in found)
        assert one == pytest.approx(other, rel=share), (name, one, other)


def start_time(bench):
    law = {"y": sine(0.3, 0.5)}
    scene = changed(CHANNEL, fluid__bodies=[circle(0.0, 0.0, 0.2, motion=law)])
    arguments = {"stop_time": 0.27, "step_size": 0.01, "output_interval": 0.01, "output": ["body[1].y"]}
    for version in (2, 3):
        found = fmpy.simulate_fmu(str(bench.packed("fluid", scene, version)), start_time=0.25, **arguments)
        for time, y in found:
            assert y == pytest.approx(0.3 * math.sin(math.pi * time), abs=1e-9), version


def state_not_restorable(bench):
    """A parameter that does not fit: no state is given that could not be put back, and a right value goes on."""
    unit = FMU2Unit("fluid", unpack("fluid", bench.folder)).new(start=False)
    (parameter,) = (v.valueReference for v in unit.variables if v.name == "max_cfl")
    unit.setReal([parameter], [0.9])
    with pytest.raises(FMICallException):
        unit.serialize()
    assert "max_cfl" in unit.messages[-1], unit.messages
    unit.setReal([parameter], [0.2])
    unit.restore(unit.serialize(), 0)
    unit.start()
    unit.step()


def stretchy(bench):
    own = rod(1.0, 0.01, 0.5, damping=2.0, gravity=[9.81, 0.0])
    found = bench.run({"name": "stretchy", "time": clock(2.0, 0.01), "beam": beam(1.0, 0.02, 40), "rod": own})
    assert found.summary.warnings[-1].startswith("the rod is 1.5 times as long as at rest"), found.summary.warnings


CASES = {
    "blade-turned": blades,
    "blade-up": blades,
    "blocked": blocked,
    "bodies-collide": bodies_collide,
    "cant-3d-z": cant_3d_z,
    "contract_pj": pressed_beam,
    "exitinit": exitinit,
    "filament-gravity": filament_gravity,
    "fluid_fold_nan": fluid_fold_nan,
    "in-inflow": in_inflow,
    "law-sine": law_table_20,
    "law-table-20": law_table_20,
    "light-rod": light_rod,
    "load_unload_leak": load_unload_leak,
    "long_description": long_description,
    "mooring": mooring,
    "nans": nans,
    "nosponge": nosponge,
    "pack_pj": pressed_beam,
    "pair-pj": pressed_beam,
    "pair-small": pair_small,
    "pj_beam": pressed_beam,
    "pj_half": half_a_state,
    "rate-2points": rates,
    "rate-4points": rates,
    "rod_drive_inf": rod_drive_inf,
    "shed-square-impulse": shed_squares,
    "shed-square-ramp": shed_squares,
    "short-rod": short_rod,
    "start_time": start_time,
    "state_not_restorable": state_not_restorable,
    "stretchy": stretchy,
    "sym-cylinder": sym_cylinder,
}
"""The function that tries each report; those of one function are tried together, once."""

TOGETHER = {situation: [name for name in CASES if CASES[name] is situation] for situation in CASES.values()}


@pytest.mark.parametrize("situation", TOGETHER, ids=["+".join(names) for names in TOGETHER.values()])
def test_case(situation, bench):
    situation(bench)
