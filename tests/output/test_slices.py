"""Slices and vortices of a fluid in space: where they lie, what they show of the solids, and what can be chosen."""

import copy
import shutil

import numpy as np
import pytest
from matplotlib.figure import Figure

import nervure
from nervure.errors import InputError
from nervure.output import animation, flow, plots, space
from nervure.scene import validate
from tests.conftest import nervure as command

pytestmark = pytest.mark.usefixtures("libraries")

STILL = {
    "name": "still",
    "time": {"end": 0.02, "communication_step": 0.01},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.05,
        "box": {"x": [-1.5, 2.5], "y": [-1.0, 1.0], "z": [-1.0, 1.0], "cells": [32, 16, 16]},
        "initial_velocity": [1.0, 0.0, 0.0],
        "mean_flow": {"x": {"constant": 1.0}},
        "sponge": {"x": [1.5, 2.5], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1},
        "mask": {"log_linear": {"c_eta": 1e-3}},
        "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
    },
}
"""A stream along x in space, without a body."""

CORNERS = [[x, y, z] for x in (-0.4, 0.4) for y in (-0.3, 0.3) for z in (-0.6, 0.6)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BOX = {"nodes": CORNERS, "triangles": [list(half) for a, b, c, d in SIDES for half in ((a, b, c), (a, c, d))]}
"""A closed box as a triangulation."""

FIN = {
    "mesh": {"rectangular": {"length": 1.0, "width": 1.5, "along": 4}},
    "membrane": {"areal_density": 0.2, "stretching_stiffness": 1e3, "bending_stiffness": 1.0, "poisson_ratio": 0.3},
    "root": "root",
    "relaxation_time": 0.01,
}


def scene(wing=None, **fluid):
    document = copy.deepcopy(STILL)
    document["fluid"] |= fluid
    return validate(document | ({"wing": wing} if wing else {}))


def cuboid(*lengths, position=(0.0, 0.0, 0.0)):
    return {"shape": {"cuboid": {"lengths": lengths}}, "position": position}


FALLS = {"mount": {"mass": 1.0, "gravity": [0.0, 0.0, -9.81], "z": {}}}
AT_REST = {"initial_velocity": [0, 0, 0], "mean_flow": None, "sponge": None}
ALONG_Z = {"initial_velocity": [0, 0, 1], "mean_flow": {"z": {"constant": 1.0}}, "sponge": None}


@pytest.mark.parametrize(
    ("given", "normal", "place"),
    [
        (scene(), 2, 0.0),
        (scene(bodies=[cuboid(0.5, 0.5, 1.0)]), 2, 0.0),
        (scene(bodies=[cuboid(0.5, 1.0, 0.5, position=[0, 0.5, 0])]), 1, 0.5),
        (scene(bodies=[cuboid(2.0, 0.5, 0.5)]), 2, 0.0),
        (scene(bodies=[cuboid(0.5, 0.5, 1.0)], **ALONG_Z), 1, 0.0),
        (scene(bodies=[cuboid(0.5, 0.5, 0.5) | FALLS], **AT_REST), 1, 0.0),
        (scene(wing=FIN), 1, 0.0),
    ],
)
def test_a_slice_lies_in_the_stream_across_the_longest_side(given, normal, place):
    assert flow.View(given).plane == space.Plane(normal, place)


def test_a_slice_shows_the_wing_and_its_place():
    view = flow.View(scene(wing=FIN))
    mesh = nervure.scene.facts.Facts(view.scene).wing
    (outline,) = view.outlines([], [], (mesh.nodes, mesh.triangles))
    assert flow.is_line(outline) and np.ptp(outline, axis=0) == pytest.approx([1.0, 0.0])
    figure, axes = view.panels(7.0)
    picture = flow.Picture(axes[0, 0], view, 1.0)
    picture.show(np.zeros((32, 16)), [outline])
    picture.say(0.5)
    assert axes[0, 0].get_title(loc="right") == "y = 0 m, t = 0.500 s" and axes[0, 0].get_ylabel() == "z [m]"
    (patch,) = picture.patches
    assert patch.get_linewidth() == flow.THIN and len(figure.axes) == 1


def test_a_closed_surface_is_cut_in_a_filled_outline_and_a_sheet_in_a_line():
    plane = space.Plane(2, 0.1)
    (around,) = plane.cut(np.array(CORNERS), np.array(BOX["triangles"]))
    assert not flow.is_line(around) and (around[0] == around[-1]).all()
    assert [*around.min(axis=0), *around.max(axis=0)] == pytest.approx([-0.4, -0.3, 0.4, 0.3])
    doubled = np.array(CORNERS)[np.array(BOX["triangles"]).ravel()]  # As in an STL file, each triangle its own corners
    (same,) = plane.cut(doubled, np.arange(len(doubled)).reshape(-1, 3))
    assert len(same) == len(around)
    (line,) = plane.cut(np.array(CORNERS), np.array(BOX["triangles"][:2]))
    assert flow.is_line(line)


def test_a_rod_is_cut_in_a_circle_and_lies_as_a_stripe():
    line = np.linspace([0, 0, -1], [0.5, 0, 1], 21)
    (circle,) = space.Plane(2, 0.03).rod(line, 0.02)
    assert circle.mean(axis=0) == pytest.approx([0.2575, 0.0], abs=1e-3)
    assert np.ptp(circle, axis=0) == pytest.approx([0.04, 0.04], rel=1e-2)
    (stripe,) = space.Plane(1, 0.01).rod(line, 0.02)
    assert np.ptp(stripe, axis=0) == pytest.approx([0.5, 2.0], abs=0.04)
    assert space.Plane(1, 0.03).rod(line, 0.02) == []


@pytest.fixture(scope="module")
def run(tmp_path_factory, libraries):
    """A closed box from triangles at the start of a stream, with a field of its end."""
    pytest.importorskip("h5py")
    given = scene(bodies=[{"shape": {"triangulation": BOX}, "position": [0.0, 0.0, 0.0]}])
    return nervure.run(given, tmp_path_factory.mktemp("slices") / "run", fields_every=0.02, quiet=True)


def test_a_chosen_slice_has_the_values_of_the_field(run):
    pytest.importorskip("xarray")
    data = run.fields().isel(time=-1)
    for across, name, at in (("x", "vorticity_x", 0.5), ("y", "vorticity_y", -0.25), ("z", "vorticity_z", 0.25)):
        frames = animation.Frames(run.folder, animation.Part(across, at))
        expected = data[name].sel({across: at}).values.T
        assert np.array_equal(frames.field("vorticity", len(frames.times) - 1), expected), across
        figure = run.plot_field("vorticity", across=across, at=at)
        assert figure.axes[0].get_title(loc="right").startswith(f"{across} = {at:g} m, t = ")
        assert figure.axes[1].get_ylabel() == f"vorticity about {across} [1/s]"
    figure = run.plot_field("speed", crop=[-1.0, 1.0, -0.5, 0.5, -1.0, 1.0])
    assert figure.axes[0].get_xlim() == (-1.0, 1.0) and figure.axes[0].get_ylim() == (-0.5, 0.5)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"across": "w"}, "across is w, but must be x, y or z"),
        ({"across": "z", "at": 3.0}, "at is 3 m, but the box is from -1 to 1 m along z"),
        ({"crop": [0.0, 1.0]}, "the crop is 0, 1, but must be ends inside the box -1.5, 2.5, -1, 1, -1, 1 m"),
        ({"q": -1.0}, "q is -1.0, but must be a finite number above 0"),
        ({"camera": [0.0, 0.0, 0.0]}, "must be a direction"),
        ({"background": "windy"}, "the background is 'windy', but must be a colour"),
    ],
)
def test_what_cannot_be_shown_is_refused_before_anything_is_written(run, wrong, told):
    with pytest.raises(InputError, match=told):
        run.animate(**wrong)
    assert not (run.folder / "phases.png").exists()


def test_the_command_takes_the_same_choices(run, tmp_path):
    shutil.copytree(run.folder, tmp_path / "run")
    choices = ["--across", "y", "--at", "0.25", "--crop", "-1,2,-1,1,-0.5,0.5", "--q", "3", "--camera", "-1,0.5,1"]
    done = command("animate", tmp_path / "run", *choices, "--background", "black")
    assert done.returncode == 0 and (tmp_path / "run" / "vorticity.gif").exists(), done.stderr
    for wrong, told in (
        (["--crop", "1,2"], "the crop is 1, 2,"),
        (["--camera", "a,1"], "--camera is a,1, but must be"),
    ):
        done = command("animate", tmp_path / "run", *wrong)
        assert done.returncode == 2 and told in done.stderr, done.stderr


def test_phases_say_where_the_slice_lies(run, monkeypatch):
    found: dict[str, Figure] = {}
    monkeypatch.setattr(plots, "save", lambda figure, path: found.setdefault(path.name, figure))
    frames = animation.Frames(run.folder, animation.Part("y", 0.25))
    animation.phases(frames, [0, 0, 1, 1], 1.0, run.folder / "phases.png")
    assert found["phases.png"].get_suptitle() == "still, y = 0.25 m"


def test_vortices_are_those_outside_of_solids_in_a_part_around_them(run):
    pytest.importorskip("pyvista")
    from nervure.output import vortices

    frames = animation.Frames(run.folder)
    flow_now = frames.flow(len(frames.times) - 1)
    around = vortices.Space(run.scene, vortices.Look(), None, [flow_now])
    inside = around.free(flow_now.poses, 0.0)[12, 8, 8], around.free(flow_now.poses, 0.0)[0, 0, 0]
    assert inside == (False, True), "the middle of a closed surface is solid"
    (body,) = run.scene.fluid.bodies
    solid = around._solid(body, flow_now.poses[0])
    everywhere = around.pyvista.Sphere(radius=0.45)
    kept = around._outside(everywhere, [solid]).points
    beyond = np.max(np.abs(kept) - [0.4, 0.3, 0.6], axis=1)
    assert len(kept) == 0 or beyond.min() > 0.9 * vortices.MASKED * 0.125, beyond.min()
    lengths = [high - low for low, high in around.part]
    assert lengths[0] < 0.8 + 2 * 2.75 * 1.2 and 1.2 / lengths[2] > 0.5, "the body is large"

    choices = {"q": 50.0, "camera": [0, 0, 1]}, {"crop": [-1, 1, -1, 1, -1, 1], "background": "#101010"}
    plain, *others = (np.asarray(run.plot_vortices(**chosen)) for chosen in ({}, *choices))
    assert all((other != plain).mean() > 0.001 for other in others)
    assert (plain[0, 0] == 255).all() and (others[-1][0, 0] == 16).all()
