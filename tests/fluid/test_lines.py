"""Beams and rigid bodies that the fluid meets as lines, and the weight of lines and masks."""

import numpy as np
import pytest

import nervure
from nervure.errors import SceneError
from nervure.output import flow
from nervure.scene import validate
from nervure.scene.facts import Facts
from studies import simulate, slit, thin

FLAG = [
    "fluid.box.cells=[128,64]", "time.communication_step=0.008", "fluid.time_stepping.max_step=0.008",
    "beam.segments=16", "rod.material.section.bending_stiffness=0.01", "time.end=1.2",
]  # fmt: skip


def flag(folder, *more):
    return nervure.run("flag-massless-240x120", folder, overrides=[*FLAG, *more], quiet=True)


def test_a_rod_without_mass_needs_one_exchange(tmp_path):
    """Its tip follows the gust, and rod and fluid agree on the work between them."""
    run = flag(tmp_path)
    tip, works = run.series["tip_uy"], [run.series[f"{side}_work"] for side in ("load", "beam")]
    assert run.summary.iterations_mean == 1 and 0.002 < np.abs(tip).max() < 0.1
    assert np.abs(works[0] - works[1]).max() < 0.05 * np.abs(works[1]).max()


def test_one_exchange_gives_what_an_iteration_gives(tmp_path):
    """A heavy rod under the momentum load, and under the pressure jump along the line with iterations."""
    heavy = "rod.material.section.line_density=1"
    tips = [
        flag(tmp_path / name, heavy, *more).series["tip_uy"]
        for name, more in {
            "momentum": (),
            "pressure": ('coupling={"load": "pressure_jump", "scheme": {"iterated": {}}}',),
        }.items()
    ]
    assert np.abs(tips[0] - tips[1]).max() < 0.05 * np.abs(tips[0]).max()


@pytest.mark.parametrize("unit_of_mass", [1.0, 1e-15])
def test_a_rod_at_rest_in_a_fluid_at_rest_runs_on(unit_of_mass, tmp_path):
    """The powers that it exchanges are rounding, in any unit of mass, and no instability; nor are large loads."""
    kg = 1 / unit_of_mass
    section = {"line_density": 1.0 * kg, "bending_stiffness": 0.1 * kg, "axial_stiffness": 200.0 * kg}
    scene = validate({
        "name": "rest",
        "time": {"end": 0.6, "communication_step": 0.01},
        "fluid": {
            "density": kg,
            "kinematic_viscosity": 0.01,
            "box": {"x": [-1, 2], "y": [-1, 1], "cells": [24, 16]},
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
        },
        "beam": {
            "root": {"at": {"position": [0.01, 0.02], "direction": [1.0, 0.3]}},
            "length": 0.8, "thickness": 0.05, "segments": 8, "surface": "line",
        },
        "rod": {"material": {"section": section}, "scheme": "bdf2"},
        "coupling": {"guards": {"window_steps": 20}},
    })  # fmt: skip
    still = nervure.run(scene, tmp_path / "still", quiet=True)
    assert still.summary.completed and not still.summary.warnings
    moved = {"fluid.initial_velocity": [1.0, 0.0], "coupling.guards.window_steps": 500}
    assert nervure.run(scene.copy(moved), tmp_path / "stream", quiet=True).summary.completed


@pytest.mark.parametrize("mass", [0.01, 1.0])
def test_the_error_of_the_tip_falls_with_the_step(mass, tmp_path):
    """Halved, 3 times less with C_eta far below the step; 1.8 times less with 1e-4 s and the light rod."""
    changes = thin.SMOOTH | {"fluid.mask.log_linear.c_eta": 1e-8, "rod.material.section.line_density": mass}

    def way(step):
        steps = {"time.communication_step": step, "fluid.time_stepping.max_step": step}
        run = nervure.run(validate(simulate.changed(thin.SCENE, changes | steps)), tmp_path / str(step), quiet=True)
        return np.interp(thin.ORDER_TIMES, run.series["time"], run.series["tip_uy"])

    fine = way(0.001)
    coarse, half = (np.abs(way(step) - fine).max() / np.abs(fine).max() for step in (0.008, 0.004))
    assert half < 0.4 * coarse < 0.004, (coarse, half)


@pytest.mark.parametrize("angle", slit.ANGLES)
def test_a_plate_of_no_thickness_has_the_forces_of_a_mesh_with_a_slit(angle, tmp_path):
    """On 24 cells a chord, after an impulsive start at Re 100."""
    case = slit.case(angle, 24, "mean", slit.changes(angle, 24))
    found = slit.measured(case, tmp_path)["values"]
    for name, expected in case.about["expected"].items():
        assert found[name] == pytest.approx(expected, rel=0.02), (name, found[name], expected)


@pytest.fixture
def plates(fluid_only):
    """A plate that pitches about its left end, and a hook that stands still, in a stream."""
    sine = {"sine": {"amplitude": 0.5, "frequency": 2.0}}
    fluid_only["fluid"] |= {"cylinders": [], "box": {"x": [-1.0, 2.0], "y": [-0.5, 0.5], "cells": [96, 32]}}
    fluid_only["fluid"]["bodies"] = [
        {"shape": {"plate": {"length": 0.4}}, "position": [0.2, 0.0], "pivot": [-0.2, 0], "motion": {"angle": sine}},
        {"shape": {"polyline": {"points": [[0, 0], [0.2, 0], [0.2, 0.1]]}}, "position": [0.9, 0.1]},
    ]
    return fluid_only


@pytest.mark.pictures
def test_rigid_lines_have_forces_places_and_pictures(plates, tmp_path):
    run = nervure.run(validate(plates), tmp_path, quiet=True)
    assert np.abs(run.series["body_1_moment"]).max() > 0 and run.series["body_2_drag"][-1] > 0
    assert run.series["body_1_angle"] == pytest.approx(0.5 * np.sin(4 * np.pi * run.series["time"]))
    assert run.facts.lines == {"body_1", "body_2"} and (tmp_path / "vorticity.png").exists()
    hook = flow.View(run.scene).outlines([], [(0.2, 0, 0), (0.9, 0.1, 0)])[1]
    assert hook == pytest.approx(np.array([[0.9, 0.1], [1.1, 0.1], [1.1, 0.2], [1.1, 0.1]]))


def test_a_beam_does_not_cross_a_plate(plates):
    root = {"at": {"position": [0.3, -0.2], "direction": [0, 1]}}
    plates["beam"] = {"root": root, "length": 0.3, "thickness": 0.01, "segments": 4, "surface": "line"}
    with pytest.raises(SceneError, match=r"the beam meets `fluid.bodies\[0\]` at \[0.3, -0.05\]"):
        Facts(validate(plates)).numbers  # noqa: B018


def test_a_line_needs_its_scheme(tmp_path):
    with pytest.raises(SceneError, match="a line needs the scheme sbdf2"):
        flag(tmp_path, "fluid.time_stepping.scheme=rk2")


def test_powers_agree_where_the_fluid_divides_a_step(tmp_path):
    """A heavy flag exchanges in each step of the fluid; with one exchange in two or three of them a tenth of the power
    was missing."""
    heavy = ["rod.material.section.line_density=1", 'coupling={"guards": {"window_steps": 200}}', "time.end=5"]
    summary = flag(tmp_path, *heavy, "time.communication_step=0.02", "fluid.time_stepping.max_step=0.02").summary
    powers = [text for text in summary.warnings or [] if "exchanged" in text]
    assert not powers and summary.iterations_mean > 1.1


def test_a_filament_that_heaves_swims(tmp_path):
    """It swims ahead; driven along the way that it swam, it needs no force along it."""

    def swim(name, changes):
        scene = simulate.changed("filament-swimming-144x48", {"time.end": 3.0} | changes)
        return nervure.run(validate(scene), tmp_path / name, quiet=True).series

    free = swim("free", {})
    way = {"times": free["time"].tolist(), "values": free["root_ux"].tolist()}
    driven = swim("driven", {"rod.slide": "absent", "rod.root_motion.laws.x": {"table": way}})
    late = free["time"] > 1.0
    assert free["root_vx"][late].mean() < -0.5
    force, load = driven["root_force_x"][late].mean(), np.ptp(driven["load_x"][late]) / 2
    assert abs(force) < 0.01 * load, (force, load)
    assert np.abs(driven["tip_uy"] - free["tip_uy"]).max() < 0.01


SAGGING = {
    "name": "sagging",
    "time": {"end": 12.0, "communication_step": 0.01},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.1,
        "box": {"x": [-1.0, 2.0], "y": [-1.0, 1.0], "cells": [60, 40]},
        "mean_flow": {},
        "mask": {"log_linear": {"c_eta": 1e-5}},
        "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
    },
    "beam": {
        "root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}},
        "length": 1.0,
        "thickness": 0.08,
        "segments": 16,
        "surface": "line",
    },
}
"""A clamped line in still fluid, of which 0.073 kg/m moves with it."""


@pytest.mark.parametrize(("load", "mass"), [("momentum", 0.5), ("momentum", 0.05), ("pressure_jump", 0.5)])
def test_a_line_in_the_plane_sags_under_its_whole_weight(load, mass, tmp_path):
    """A line displaces no fluid. A light one is not thrown in its first step, before the loads tell of the fluid."""
    section = {"line_density": mass, "bending_stiffness": 0.5, "axial_stiffness": 1e4}
    rod = {"material": {"section": section}, "scheme": "bdf2", "gravity": [0.0, -0.05]}
    run = nervure.run(validate(SAGGING | {"rod": rod, "coupling": {"load": load}}), tmp_path, quiet=True)
    assert run.series["tip_uy"][-1] == pytest.approx(-mass * 0.05 / 8 / 0.5, rel=0.01)
    assert abs(run.series["tip_vy"][1]) < 1.5 * 0.05 * 0.01


@pytest.mark.parametrize(("load", "mass"), [("momentum", 0.6), ("pressure_jump", 0.6), ("pressure_jump", 0.1)])
def test_the_fluid_carries_a_mask_by_its_weight(load, mass, tmp_path):
    """Whatever the load: 0.2 kg/m of fluid are inside the mask, in which a lighter bar rises."""
    section = {"line_density": mass, "bending_stiffness": 0.5, "axial_stiffness": 1e4}
    rod = {"material": {"section": section}, "scheme": "bdf2", "gravity": [0.0, -0.05], "damping": 0.5}
    fluid = SAGGING["fluid"] | {"kinematic_viscosity": 0.2, "mask": {"log_linear": {"c_eta": 1e-4}}}
    fluid |= {"box": SAGGING["fluid"]["box"] | {"cells": [45, 30]}}
    time, beam = {"end": 16.0, "communication_step": 0.02}, SAGGING["beam"] | {"thickness": 0.2, "surface": "mask"}
    bar = SAGGING | {"time": time, "fluid": fluid, "beam": beam, "rod": rod, "coupling": {"load": load}}
    run = nervure.run(validate(bar), tmp_path, quiet=True)
    assert run.series["tip_uy"][-1] == pytest.approx(-(mass - 0.2) * 0.05 / 8 / 0.5, rel=0.02)


@pytest.mark.parametrize("mass", [0.3, 0.1])
@pytest.mark.parametrize("shape", [{"plate": {"length": 1.0}}, {"disk": {"radius": 0.5}}], ids=["plane", "space"])
def test_a_thin_body_falls_along_itself_with_gravity(shape, mass, tmp_path):
    """The fluid slides along it, and none of it belongs to the body: a plate fell at up to seven times gravity."""
    axes = "xyz" if "disk" in shape else "xy"
    down = [-1.0, 0.0, 0.0][: len(axes)]
    mount = {"mass": mass, "gravity": down, "x": {}}
    fluid = SAGGING["fluid"] | {
        "kinematic_viscosity": 1e-3,
        "box": {axis: [-1.5, 1.5] for axis in axes} | {"cells": [36] * len(axes)},
        "bodies": [{"shape": shape, "position": [0.03, 0.01, 0.02][: len(axes)], "mount": mount}],
        "time_stepping": {"max_step": 0.002, "max_cfl": 0.4},
    }
    scene = {"name": "falling", "time": {"end": 0.02, "communication_step": 0.002}, "fluid": fluid}
    series = nervure.run(validate(scene), tmp_path, quiet=True).series
    assert series["body_1_vx"][-1] / series["time"][-1] == pytest.approx(-1.0, abs=0.04)
    assert series["drag"][-1] == pytest.approx(0.0, abs=0.05 * mass)
