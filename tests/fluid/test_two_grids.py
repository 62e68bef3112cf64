"""A fine box in a coarse one: a unit like any other, with fields of the large box, states, and refusals by key."""

import copy
import json
from typing import Any

import h5py
import numpy as np
import pytest

from nervure import api, load
from nervure.errors import InputError, SceneError
from nervure.library import check
from nervure.output.animation import Frames
from nervure.output.flow import View
from nervure.scene import validate
from nervure.simulation.results import FLUID_FIELDS
from nervure.simulation.session import Session
from tests.conftest import nervure

SCENE: dict[str, Any] = {
    "name": "two-grids",
    "time": {"end": 1.0, "communication_step": 0.0125},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.02,
        "box": {"x": [-4.0, 8.0], "y": [-4.0, 4.0], "cells": [48, 32]},
        "fine_box": {"x": [-2.05, 3.02], "y": [-2.0, 2.0], "ratio": 4},
        "initial_velocity": [1.0, 0.0],
        "mean_flow": {"x": {"constant": 1.0}},
        "sponge": {"x": [6.0, 8.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.3},
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "time_stepping": {"max_step": 0.0125, "max_cfl": 0.4},
    },
    "beam": {
        "root": {"at": {"position": [-0.5, 0.0], "direction": [1.0, 0.1]}},
        "length": 1.0,
        "thickness": 0.02,
        "segments": 24,
        "surface": "line",
    },
    "rod": {
        "material": {"section": {"line_density": 1e-6, "bending_stiffness": 1e-2, "axial_stiffness": 100.0}},
        "scheme": "bdf2",
    },
}
"""A flag almost without mass, held in a fine box whose ends are not on the large grid."""


def changed(**parts: object) -> dict:
    """Return `SCENE` with other parts of the fluid."""
    scene = copy.deepcopy(SCENE)
    scene["fluid"] |= parts
    return scene


def test_a_flag_without_mass_moves_on_two_grids_as_on_one(libraries, tmp_path):
    large, fine = SCENE["fluid"]["box"], SCENE["fluid"]["fine_box"]
    scenes = {
        "two": changed(box=large | {"cells": [96, 64]}, fine_box=fine | {"ratio": 2}),
        "one": changed(box=large | {"cells": [192, 128]}, fine_box=None),
    }
    two, one = (api.run(validate(scene), tmp_path / name, quiet=True).series for name, scene in scenes.items())
    for name in ("tip_uy", "drag"):
        found, expected = (float(series[name][-40:].mean()) for series in (two, one))
        assert abs(found / expected - 1) < 0.03, f"{name}: {found} beside {expected}"


def driven(end: float = 1.0) -> dict:
    """Return a scene with a cylinder that moves at 1 m/s along x and a fine box that follows it."""
    scene = changed(
        initial_velocity=[0.0, 0.0],
        mean_flow=None,
        sponge=None,
        fine_box={"x": [-3.0, 3.0], "y": [-3.0, 3.0], "ratio": 2, "follow": "body[1]"},
        bodies=[
            {
                "shape": {"circle": {"radius": 0.5}},
                "position": [0.0, 0.0],
                "motion": {"x": {"table": {"times": [0.0, 9.0], "values": [0.0, -9.0]}}},
            }
        ],
        probes=[{"name": "far", "position": [6.0, 0.0]}],
    )
    return {key: part for key, part in scene.items() if key not in ("beam", "rod")} | {
        "time": scene["time"] | {"end": end}
    }


def on_three_grids(scene: dict) -> dict:
    """Return a scene with a smaller fine box, of cells a quarter as long as the large ones, in a middle box."""
    scene = copy.deepcopy(scene)
    fine, ends = scene["fluid"]["fine_box"], ([-1.5, 1.5], [-3.25, 3.25])
    scene["fluid"]["fine_box"] = fine | {"x": ends[0], "y": ends[0], "ratio": 4}
    scene["fluid"]["middle_box"] = {"x": ends[1], "y": ends[1]}
    return scene


SCENES = {"still": SCENE, "follows": driven(), "three grids": on_three_grids(SCENE)} | {
    "three grids follow": on_three_grids(driven())
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("version", (2, 3))
def test_a_unit_on_two_grids_goes_back_and_on_in_another_instance(version, scene, instantiate):
    unit, other = (instantiate(scene, version=version)["fluid"] for _ in range(2))
    for own in (unit, other):
        own.start()
    # The box of the second scene moves before and after.
    for step in range(18):
        unit.step(step * 0.0125, 0.0125)
    other.deserialize(unit.serialize())
    unit.save()
    shown = []
    for own in (unit, other, unit):
        for step in range(18, 40):
            own.step(step * 0.0125, 0.0125)
        fields = [own.field(name) for name in ("u", "v", "p", "vorticity")]
        assert all(field.shape == (48, 32) for field in fields), "fields have the cells of the large box"
        shown.append(np.concatenate([own.outputs, *map(np.ravel, fields)]))
        unit.restore()
    assert np.array_equal(shown[0], shown[1]) and np.array_equal(shown[0], shown[2])


def test_a_run_with_a_box_that_follows_is_continued_from_its_checkpoint(libraries, tmp_path):
    whole = api.run(validate(driven(1.0)), tmp_path / "whole", fields_every=0.25, quiet=True)
    api.run(validate(driven(0.5)), tmp_path / "parts", checkpoint_every=1.0, quiet=True)
    parts = api.resume(tmp_path / "parts", end_time=1.0, quiet=True)
    for name, values in whole.series.items():
        # The last step of a part is not to the last bit as long as the others.
        difference = np.abs(values - parts.series[name]).max()
        assert difference < 1e-11, f"{name}: {difference}"
    low, at = (whole.series[name] for name in ("fine_box_x", "body_1_x"))
    assert low[0] == -3.0 and np.all(np.abs(at - low - 3.0) < 0.25), "the box is within a cell of its body"
    with h5py.File(tmp_path / "whole" / FLUID_FIELDS) as file:
        assert np.array_equal(file["fine_box"][:, 0], low[::20]), "frames say where the box is"
    frames = Frames(tmp_path / "whole")
    (box, *_), solid, fine = frames.fine_box(4), frames.solids(4)[0], frames.fine("u", 4)
    assert fine is not None and fine.shape == (48, 48), "frames have the cells of the fine box"
    first = round((low[-1] + 4.0) / 0.25), round((-3.0 + 4.0) / 0.25)
    shared = frames.field("u", 4)[first[0] : first[0] + 24, first[1] : first[1] + 24]
    shared, fine = shared[1:, 1:], fine[2::2, 2::2]
    assert np.abs(shared - fine).max() < 1e-6, "and the same flow where both have a point between its ends"
    assert np.ptp(box, axis=0).tolist() == [6, 6] and box[0, 0] == low[-1]
    assert abs(solid[:, 0].mean() - at[-1]) < 0.05


def test_a_run_moves_its_box_by_a_drive_as_a_box_that_follows_the_body(libraries, tmp_path):
    scene = driven(0.5)
    body = api.run(validate(scene), tmp_path / "body", quiet=True).series
    scene["fluid"]["fine_box"]["follow"] = "master"
    point = api.run(
        validate(scene), tmp_path / "point", drive=lambda time, _: {"fine_box.motion.x": -time}, quiet=True
    ).series
    assert body["fine_box_x"][-1] < -3.25, body["fine_box_x"][-1]
    for name in ("fine_box_x", "drag"):
        assert np.array_equal(body[name], point[name]), f"{name}: {body[name]}, by a drive {point[name]}"
    with pytest.raises(
        InputError, match=r"fine_box.motion.x, fine_box.motion.y to the master \(fluid.fine_box.follow\)"
    ):
        api.run(validate(scene), tmp_path / "nobody", quiet=True)


def test_a_box_that_goes_through_a_side_is_drawn_on_both():
    view = View(validate(driven()))
    boxes, solids = view.fine_box([-18.0, -3.0]), view.outlines([], [[-15.0, 0.0, 0.0]])
    ends = sorted((box[0, 0], box[1, 0]) for box in boxes)
    assert ends == [(-6.0, 0.0), (6.0, 12.0)] and abs(solids[0][:, 0].mean() + 3.0) < 0.05, ends


def test_inspect_shows_the_cells_of_both(libraries, tmp_path):
    (tmp_path / "scene.json").write_text(json.dumps(SCENE))
    shown = nervure("inspect", str(tmp_path / "scene.json")).stdout
    assert "48 x 32 cells of 0.25 x 0.25 m" in shown, shown
    assert "80 x 64 cells of 0.0625 x 0.0625 m" in shown, shown
    (tmp_path / "scene.json").write_text(json.dumps(on_three_grids(SCENE)))
    shown = nervure("inspect", str(tmp_path / "scene.json")).stdout
    assert "52 x 52 cells of 0.125 x 0.125 m" in shown and "48 x 48 cells of 0.0625 x 0.0625 m" in shown, shown


FINE = SCENE["fluid"]["fine_box"]
THREE = {name: on_three_grids(SCENE)["fluid"][name] for name in ("fine_box", "middle_box")}
MIDDLE = THREE["middle_box"]


@pytest.mark.parametrize(
    ("parts", "named"),
    (
        ({"fine_box": FINE | {"ratio": 9}}, ["fluid.fine_box.ratio"]),
        ({"fine_box": FINE | {"y": [-1.0, 1.0]}}, ["fluid.fine_box.y", "16 cells of the large box across, and has 8"]),
        ({"fine_box": FINE | {"x": [-5.0, 3.0]}}, ["fluid.fine_box.x", "inside the box"]),
        ({"fine_box": FINE | {"x": [-2.0, 7.0]}}, ["fluid.fine_box.x", "into the sponge"]),
        (
            {"inflow": {"x": [-4.0, -1.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1, "profile": "uniform"}},
            ["fluid.fine_box.x", "into the inflow"],
        ),
        ({"fine_box": [FINE, FINE]}, ["fluid.fine_box", "must be an object with `x` and `y`"]),
        ({"fine_box": FINE | {"fine_box": FINE}}, ["unknown key `fluid.fine_box.fine_box`"]),
        ({"fine_box": FINE | {"z": [-2.0, 2.0]}}, ["fluid.fine_box.z", "axes of `box`"]),
        ({"channel": {"y": [-1.5, 3.0]}}, ["fluid.fine_box.y", "between the walls"]),
        ({"fine_box": FINE | {"follow": "body[1]"}}, ["fluid.fine_box.follow", "it must be one of `beam`"]),
        ({"fine_box": {"x": [-2.0, 3.0], "y": [-2.0, 2.0], "follow": "beam"}}, ["beam.root", "rim of `fine_box`"]),
        (
            {"bodies": [{"shape": {"circle": {"radius": 0.5}}, "position": [0.0, 1.5]}]},
            ["fluid.bodies[0].position", "rim of `fine_box`"],
        ),
        ({"fine_box": FINE | {"x": [-1.0, 3.0]}}, ["beam.root", "rim of `fine_box`"]),
        ({"fine_box": None, "middle_box": MIDDLE}, ["fluid.middle_box", "must have a `fine_box` in it"]),
        (THREE | {"middle_box": MIDDLE | {"ratio": 3}}, ["fluid.middle_box.ratio", "`fine_box.ratio`, which is 4"]),
        (THREE | {"middle_box": MIDDLE | {"ratio": 4}}, ["fluid.middle_box.ratio", "a multiple of it, such as 8"]),
        (THREE | {"middle_box": MIDDLE | {"x": [-2.5, 3.0]}}, ["fluid.middle_box.x", "reach 5 cells", "1.250000 m"]),
        (THREE | {"middle_box": MIDDLE | {"y": [-3.0, 4.5]}}, ["fluid.middle_box.y", "inside the box"]),
        (THREE | {"middle_box": MIDDLE | {"x": [-3.0, 6.5]}}, ["fluid.middle_box.x", "into the sponge"]),
        (THREE | {"middle_box": MIDDLE | {"z": [-2.0, 2.0]}}, ["fluid.middle_box.z", "axes of `box`"]),
        (THREE | {"fine_box": THREE["fine_box"] | {"y": [-0.75, 1.0]}}, ["16 cells of the middle box", "has 14"]),
        (
            THREE | {"fine_box": THREE["fine_box"] | {"follow": "beam"}, "middle_box": MIDDLE | {"x": [-3.0, 3.25]}},
            ["fluid.middle_box.x", "reach 7 cells"],
        ),
    ),
)
def test_a_fine_box_that_cannot_be_is_refused_by_its_key(parts, named, libraries, tmp_path):
    (tmp_path / "scene.json").write_text(json.dumps(changed(**parts)))
    with pytest.raises(SceneError) as refused:
        load(tmp_path / "scene.json")
    assert all(part in str(refused.value) for part in named), refused.value


WALLED: dict[str, Any] = {
    "name": "walled",
    "time": {"end": 0.01, "communication_step": 0.005},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 1e-3,
        "box": {"x": [-0.7, 1.3], "y": [-0.03, 0.44], "cells": [200, 94]},
        "channel": {"y": [0.0, 0.41]},
        "fine_box": {"x": [-0.3, 1.0], "y": [0.0, 0.41], "ratio": 2},
        "initial_velocity": [0.1, 0.0],
        "mean_flow": {"x": {"constant": 0.1}},
        "sponge": {"x": [1.0, 1.3], "mean_velocity": {"constant": 0.1}, "c_eta": 0.5},
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "time_stepping": {"max_step": 0.005, "max_cfl": 0.4},
    },
}
"""A fine box that touches walls and a sponge at points of the grid, which rounding moves beyond them."""


@pytest.mark.parametrize("rows", [94, 80])
def test_a_fine_box_may_touch_walls_and_zones_at_points_of_the_grid(rows):
    scene = copy.deepcopy(WALLED)
    scene["fluid"]["box"]["cells"][1] = rows
    if rows == 94:
        with Session(validate(scene)) as session:
            assert session.run().error is None
    else:
        found = [fault.text for fault in check(json.dumps(scene))]
        assert found == [
            "`fluid.fine_box.y` is [0.0, 0.41], but its ends at the points of the grid, -0.000625 and 0.410625, must "
            "lie between the walls at [0.0, 0.41]"
        ]


@pytest.mark.parametrize("number, cells", [(1, 0), (2, 2)])
def test_a_box_follows_one_of_several_wings(number, cells, libraries):
    def wing(name: str, y: float, z: dict) -> dict:
        mesh = {"rectangular": {"length": 0.3, "width": 0.2, "along": 2}}
        membrane = {"areal_density": 1.0, "stretching_stiffness": 500.0, "bending_stiffness": 5.0}
        laws = {"y": {"constant": y}, "z": z}
        return {"name": name, "wing": {"mesh": mesh, "membrane": membrane, "root": "root", "root_motion": laws}}

    fine = {axis: [-1.2, 1.2] for axis in "xyz"} | {"ratio": 2, "follow": f"wing[{number}]"}
    scene = {
        "name": "pair",
        "time": {"end": 0.25, "communication_step": 0.005},
        "fluid": {
            "density": 1.0,
            "kinematic_viscosity": 0.02,
            "box": {axis: [-2.0, 2.0] for axis in "xyz"} | {"cells": [40, 40, 40]},
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": 0.005, "max_cfl": 0.4},
            "mean_flow": {},
            "fine_box": fine,
        },
        "wings": [
            wing("still", 0.1, {"constant": 0.0}),
            wing("rising", -0.3, {"cosine_ramp": {"value": 0.25, "duration": 0.25}}),
        ],
    }
    with Session(validate(scene)) as session:
        assert session.run().error is None
        place = np.array(session.recorder.series["fine_box_z"])
    assert place[-1] - place[0] == pytest.approx(0.1 * cells, abs=1e-9), place
