"""A driven root: limits with exact solutions, the balance of energy, and the averages of the report."""

import numpy as np
import pytest

from cosim import coupling, flapping, master, statistics
from cosim.recorder import Recorder
from cosim.scene import ROOT, load
from cosim.statistics import Window

PITCHING = ROOT / "scenes" / "vein-pitching-320x240.json"


@pytest.fixture
def pitching():
    """The pitching vein on a grid that is good enough for questions about the balance, thicker so that the grid sees it."""
    scene = load(PITCHING)
    scene["name"] = "small-pitching"
    scene["time"] = {"end": 3.05, "communication_step": 1e-3}
    scene["fluid"]["box"]["cells"] = [128, 96]
    scene["fluid"]["time_stepping"]["max_step"] = 1e-3
    scene["beam"] |= {"thickness": 0.06, "segments": 24}
    scene["rod"]["material"]["section"]["line_density"] = 0.06
    return scene


@pytest.fixture
def record(instantiate):
    """Function that runs a scene and returns what was recorded."""

    def make(scene: dict, drive=None) -> Recorder:
        units = instantiate(scene)
        scheme = coupling.couple(units, scene.get("coupling"), drive)
        clock = master.Clock(scene["time"]["end"], scene["time"]["communication_step"])
        recorder = Recorder(units, clock.steps)
        outcome = master.run(scheme, clock, recorder)
        assert outcome.error is None, outcome.error
        return recorder

    return make


def pitch(scene: dict, t: float) -> tuple[float, float]:
    """Angle of the scene's root, rad, and its rate."""
    law = scene["rod"]["root_motion"]["laws"]["rotations"][0]["angle"]["sine"]
    omega, part = 2 * np.pi * law["frequency"], np.pi * min(t / law["ramp"], 1.0)
    share, growth = (1 - np.cos(part)) / 2, np.pi / law["ramp"] * np.sin(part) / 2
    sin, cos = np.sin(omega * t), np.cos(omega * t)
    return law["amplitude"] * share * sin, law["amplitude"] * (share * omega * cos + growth * sin)


def test_stiff_vein_makes_the_forces_of_the_prescribed_motion(pitching, record, instantiate):
    """Forces under a box filter of a fiftieth of the period: what is shorter is the mask that crosses the grid, in which a
    rod that gives way by 1e-4 differs from one that does not."""
    pitching["time"]["end"] = 2.0
    pitching["rod"]["material"]["section"] |= {"bending_stiffness": 1e5, "axial_stiffness": 1e8}
    stiff = record(pitching)

    rigid = {key: part for key, part in pitching.items() if key != "rod"} | {"name": "rigid-pitching"}
    fluid = instantiate(rigid)["fluid"]
    fluid.connect(["x", "y", "vx", "vy"], [])
    fluid.get()
    fluid.start()
    clock, s = master.Clock(2.0, 1e-3), np.linspace(0, 1, pitching["beam"]["segments"] + 1)
    forces = []
    for i in range(clock.steps):
        t, h = clock.step(i)
        angle, omega = pitch(pitching, t + h)
        sin, cos = np.sin(angle), np.cos(angle)
        fluid.inputs[:] = np.concatenate([s * cos, s * sin, -omega * s * sin, omega * s * cos])
        fluid.step(t, h)
        forces.append([fluid.output(name)[0] for name in ("beam.drag", "beam.lift", "beam.moment")])
    time = stiff.column("time")[1:]
    for column, prescribed in zip(("beam_drag", "beam_lift", "beam_moment"), np.transpose(forces)):
        both = [statistics.box_filter(time, values, 0.02)[10:-10] for values in (stiff.column(column)[1:], prescribed)]
        scale, difference = np.abs(both[1]).max(), np.abs(both[0] - both[1]).max()
        print(f"{column}: {difference / scale:.2e} of the largest, {scale:.3g}")
        assert difference < 0.01 * scale, f"{column}: {difference} of {scale}"


@pytest.mark.parametrize("chosen", [None, {"load": "pressure_jump"}])
def test_master_drives_the_root_as_the_laws_do(pitching, record, chosen):
    """Under either load, explicit and iterated."""
    pitching["time"]["end"] = 0.05
    if chosen:
        pitching["coupling"] = chosen
    by_laws = record(pitching)

    def drive(t: float) -> list[float]:
        return [0.0, 0.0, 0.0, 0.0, *pitch(pitching, t)]

    by_master = record(pitching | {"rod": pitching["rod"] | {"root_motion": "master"}}, drive)
    for column in ("tip_uy", "lift", "root_power"):
        found, expected = by_master.column(column), by_laws.column(column)
        assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max(), column


def test_root_that_nothing_drives_is_refused(pitching, record):
    pitching["rod"]["root_motion"] = "master"
    with pytest.raises(coupling.CouplingError, match="leaves the root to the master"):
        record(pitching)


def test_energy_balances_over_a_period(pitching, record):
    """By the loads that the rod took, and by what the fluid says it exerted: under the momentum load they differ by the step."""
    pitching["time"]["communication_step"] = 5e-4
    recorder = record(pitching)
    found = flapping.evaluate(pitching, recorder, Window(2.0, 3.0, 1))
    balance = found["energy_balance"]
    print(balance)
    assert found["window_s"] == pytest.approx([2.0, 3.0], abs=2e-3)
    assert abs(balance["missing"]) < 0.01, balance
    by_fluid = (balance["root"] + balance["fluid"] - balance["gained"]) / balance["root"]
    assert abs(by_fluid) < 0.01, balance


def test_base_excitation_in_vacuum_has_the_cantilever_s_transfer_function(record):
    """w(L)/w0 = (cos b + cosh b)/(1 + cos b cosh b), b^4 = mu omega^2 L^4/EI, by the scene file alone."""
    b, mu, ei, periods = 1.4, 0.024, 0.0134, 40
    frequency = b**2 * np.sqrt(ei / mu) / (2 * np.pi)
    scene = load(PITCHING)
    del scene["fluid"]
    scene["name"], scene["time"] = "vacuum", {"end": periods / frequency, "communication_step": 1 / (200 * frequency)}
    scene["rod"] |= {
        "scheme": "tr_bdf2",
        "root_motion": {"laws": {"y": {"sine": {"amplitude": 1e-4, "frequency": frequency, "ramp": 20 / frequency}}}},
    }
    recorder = record(scene)
    window = Window(30 / frequency, 40 / frequency, 10)
    tip, root = (
        flapping.harmonic(recorder.column("time"), recorder.column(name), window) for name in ("tip_uy", "rigid_tip_uy")
    )
    found, exact = (tip / root).real, (np.cos(b) + np.cosh(b)) / (1 + np.cos(b) * np.cosh(b))
    print(f"{found:.5f} against {exact:.5f}")
    assert found == pytest.approx(exact, rel=5e-3)


def test_averages_of_a_known_signal():
    """A drive of 2 Hz whose tip lags by 30 degrees and goes 1.5 times as far, in a stream along y."""
    time = np.linspace(0, 4, 4001)
    omega = 4 * np.pi
    columns = {
        "time": time,
        "rigid_tip_ux": 0.1 * np.sin(omega * time),
        "tip_ux": 0.15 * np.sin(omega * time - np.pi / 6),
        "root_power": 3.0 + np.cos(omega * time),
        "load_power": -2.0 + np.sin(omega * time),
        "damping_power": np.full_like(time, 0.75),
        "energy_elastic": 0.25 * time,
        "energy_kinetic": 0 * time,
        "energy_gravity": 0 * time,
        "beam_drag": np.sin(omega * time),
        "beam_lift": -0.5 + np.cos(omega * time),
    }

    class Known:
        def column(self, name):
            return columns[name]

    known = Known()
    known.columns = list(columns)
    scene = {"fluid": {"mean_flow": {"y": {"steady": 1.2}}}}
    found = flapping.evaluate(scene, known, statistics.find_window(time, columns["tip_ux"]))
    assert found["axis"] == "x"
    expected = {"power_in": 3.0, "thrust": 0.5, "lift": -0.5, "efficiency": 0.2, "tip_by_rigid_tip": 1.5}
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-4)
    assert found["phase_lag_deg"] == pytest.approx(30, abs=0.01)
    assert found["energy_balance"]["missing"] == pytest.approx(0, abs=1e-4)


def frequency_of_the_wet_plate(ei: float, mu: float, area: float) -> float:
    """First natural frequency, Hz, of a plate of chord 1 clamped at one edge in an ideal fluid of density 1 that repeats in a
    square of `area`, without a mean pressure gradient.

    A thin plate that moves across itself at w(x), x = (1 - cos theta)/2, makes the jump sum a_n sin(n theta) of the potential
    with w = sum n a_n sin(n theta)/sin(theta), and carries pi/4 sum n a_n b_n between two such motions. The dipoles of its
    images, d per area, move the fluid at the plate along at d/(2 area). The plate moves in the cantilever's own modes.
    """
    roots, n = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073]), np.arange(1, 60)
    theta = (np.arange(400) + 0.5) * np.pi / 400
    x, dx, sines = (1 - np.cos(theta)) / 2, np.sin(theta) * np.pi / 800, np.sin(np.outer(n, theta))
    b, s = roots[:, None] * x, (np.cosh(roots) + np.cos(roots)) / (np.sinh(roots) + np.sin(roots))
    modes = np.cosh(b) - np.cos(b) - s[:, None] * (np.sinh(b) - np.sin(b))
    jumps = 4 * (modes * dx) @ sines.T / np.pi / n
    dipoles, of_unit_velocity = np.pi / 4 * jumps[:, 0], np.pi / 4
    images = np.outer(dipoles, dipoles) / (2 * area + of_unit_velocity)
    mass = (modes * (mu * dx)) @ modes.T + np.pi / 4 * (jumps * n) @ jumps.T - images
    stiffness = np.diag(ei * roots**4 * ((modes * dx) * modes).sum(axis=1))
    return float(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min()) / (2 * np.pi))


def test_small_vibration_in_still_fluid_has_its_added_mass(record):
    """A plate, nudged at its root: its frequency falls by 42 % against vacuum, theory says 41 %."""
    ei, mu, side = 2.7121, 0.3, 3.0
    scene = load(PITCHING)
    scene["name"], scene["time"] = "free-vibration", {"end": 4.0, "communication_step": 5e-3}
    scene["fluid"] |= {"box": {"x": [-1.0, 2.0], "y": [-1.5, 1.5], "cells": [240, 240]}, "kinematic_viscosity": 1e-4}
    del scene["fluid"]["sponge"]
    scene["fluid"]["time_stepping"]["max_step"] = 5e-3
    scene["beam"] |= {"thickness": 0.03, "segments": 24}
    scene["rod"]["material"]["section"] = {"line_density": mu, "bending_stiffness": ei, "axial_stiffness": 1e4}
    nudge = {"table": {"times": [0.0, 0.25, 0.5], "values": [0.0, 0.004, 0.0]}}
    scene["rod"]["root_motion"] = {"laws": {"rotations": [{"angle": nudge}]}}
    recorder = record(scene)
    later = recorder.column("time") > 0.75
    time, uy = recorder.column("time")[later], recorder.column("tip_uy")[later]
    crossings = statistics.upward_crossings(time, uy, 0.0, uy.max())
    found = (crossings.size - 1) / (crossings[-1] - crossings[0])
    dry = 1.87510407**2 * np.sqrt(ei / mu) / (2 * np.pi)
    expected = frequency_of_the_wet_plate(ei, mu, side**2)
    print(f"{found:.4f} Hz over {crossings.size - 1} periods against {expected:.4f} Hz, in vacuum {dry:.4f} Hz")
    assert found == pytest.approx(expected, rel=0.05)
