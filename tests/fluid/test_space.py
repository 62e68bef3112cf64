"""Fluids of three dimensions: the unit and its states, a run with its fields and pictures, and refusals."""

import copy
import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from nervure import api, load
from nervure.errors import SceneError, UnitError
from nervure.output import flow, space, vortices
from nervure.output.animation import Frames, Part
from nervure.scene import validate
from nervure.scene.solids import PLACE, TURN, placed, rotation
from nervure.simulation.results import FLUID_FIELDS
from nervure.simulation.session import Session
from nervure.units.fmu import read_description
from tests.conftest import TOOL, goes_back_and_on

SPHERE = {
    "name": "sphere",
    "time": {"end": 0.1, "communication_step": 0.02},
    "fluid": {
        "density": 2.0,
        "kinematic_viscosity": 0.05,
        "box": {"x": [-1.5, 2.5], "y": [-1.0, 1.0], "z": [-1.0, 1.0], "cells": [32, 16, 16]},
        "initial_velocity": [1.0, 0.0, 0.0],
        "mean_flow": {"x": {"constant": 1.0}},
        "bodies": [{"shape": {"sphere": {"radius": 0.4}}, "position": [0.0, 0.0, 0.0]}],
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "probes": [{"name": "wake", "position": [1.0, 0.0, 0.0]}],
        "time_stepping": {"max_step": 0.02, "max_cfl": 0.4},
    },
}
"""A sphere in a stream that starts at once."""


def changed(**parts: object) -> dict:
    """Return `SPHERE` with other parts of the fluid."""
    scene = copy.deepcopy(SPHERE)
    scene["fluid"] |= parts
    return scene


pytestmark = pytest.mark.pictures


@pytest.fixture(scope="module")
def run(libraries, tmp_path_factory):
    folder = tmp_path_factory.mktemp("space")
    return api.run(validate(SPHERE), folder / "run", fields_every=0.04, quiet=True), folder / "run"


def test_forces_and_probes_of_a_sphere_are_recorded_and_evaluated(run):
    found, _ = run
    series, drag = found.series, found.series["drag"]
    assert {"drag", "lift", "side", "body_1_moment_z", "body_1_z", "probe_wake_w", "probe_wake_p"} <= series.keys()
    assert drag[-1] > 0 and np.allclose(drag, series["body_1_drag"])
    assert abs(series["lift"][-1]) < 1e-9 * drag[-1] and abs(series["side"][-1]) < 1e-9 * drag[-1]
    # The flow rate through the box is that of the mean flow.
    assert np.allclose(series["flow_rate"], 4.0, rtol=1e-12)
    pressure = 0.5 * 2.0 * np.pi * 0.4**2
    assert found.summary.quantities["drag"].unit == "N"
    mean = found.summary.quantities["drag"].mean
    assert found.summary.bodies["body_1"].cd_mean == pytest.approx(mean / pressure)


def test_fields_are_those_of_the_flow_in_a_container_of_vtk(run):
    h5py = pytest.importorskip("h5py")
    _, folder = run
    with h5py.File(folder / FLUID_FIELDS) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"ImageData" and list(root.attrs["WholeExtent"]) == [0, 31, 0, 15, 0, 15]
        assert np.allclose(root.attrs["Spacing"], 0.125) and np.allclose(root.attrs["Origin"], [-1.5, -1, -1])
        assert root["Steps"].attrs["NSteps"] == 3
        u, omega = (root["PointData"][name][-1] for name in ("velocity", "vorticity"))
        assert u.shape == omega.shape == (16, 16, 32, 3) and root["PointData/pressure"].shape == (3, 16, 16, 32)
    # The mean flow, and a ring of vortices around the sphere: about y above it, about -z beside it.
    assert np.allclose(u.mean(axis=(0, 1, 2)), [1, 0, 0], atol=1e-6)
    assert omega[11, 8, 12, 1] > 0.1 and omega[8, 11, 12, 2] == pytest.approx(-omega[11, 8, 12, 1], abs=1e-4)
    assert (folder / "vorticity.png").stat().st_size > 5000


def test_both_versions_of_the_unit_give_the_same_numbers(run, tmp_path):
    other = api.run(validate(SPHERE), tmp_path / "run", fmi=3, quiet=True)
    assert np.array_equal(other.series["drag"], run[0].series["drag"])


def test_fields_become_a_dataset_in_space(run):
    pytest.importorskip("xarray")
    found = run[0].fields(0.03)
    assert found.w.dims == ("time", "z", "y", "x") and found.time.values == pytest.approx([0.04, 0.08])
    assert found.z.attrs["units"] == "m" and found.vorticity_x.attrs["units"] == "1/s"
    slope = {
        a: 2j * np.pi * np.fft.fftfreq(found.sizes[a], 0.125).reshape([-1 if a == b else 1 for b in "zyx"])
        for a in "xyz"
    }
    wave = {name: np.fft.fftn(found[name].values[-1]) for name in "uvw"}
    for (a, b), (v, w), name in zip(map(tuple, ("yz", "zx", "xy")), map(tuple, ("vw", "wu", "uv")), "xyz", strict=True):
        curl = np.fft.ifftn(slope[a] * wave[w] - slope[b] * wave[v]).real
        off = np.abs(curl - found[f"vorticity_{name}"].values[-1]).max()
        assert off < 2e-3 * np.abs(found.vorticity_z).max(), name


def test_a_slice_shows_a_field_and_the_bodies_in_it(run):
    for name in ("vorticity", "pressure", "speed", "w"):
        figure = run[0].plot_field(name, 0.03)
        assert figure.axes[0].get_title(loc="right") == "z = 0 m, t = 0.040 s"
        named = "vorticity about z" if name == "vorticity" else name
        assert figure.axes[1].get_ylabel().startswith(f"{named} [")
        (solid,) = figure.axes[0].patches
        FigureCanvasAgg(figure).draw()
        extent = solid.get_path().get_extents()
        assert [extent.x0, extent.x1, extent.y0, extent.y1] == pytest.approx([-0.4, 0.4, -0.4, 0.4], abs=1e-3)


MIDDLE = space.Plane(normal=2, place=0.0)


def test_sections_are_those_of_turned_bodies():
    """A plane through the pivot cuts a cuboid that is turned about z as a rectangle, about x along a longer side; one
    beside a body does not cut it."""
    cuboid = {"shape": {"cuboid": {"lengths": [0.8, 0.2, 0.6]}}, "position": [0, 0, 0]}
    bodies = [
        cuboid | {"turn": {"axis": [0, 0, 2], "angle": 0.5}},
        cuboid | {"turn": {"axis": [1, 0, 0], "angle": 0.2}, "pivot": [0.4, 0, 0]},
        {"shape": {"circular_cylinder": {"axis": "x", "radius": 0.3}}, "position": [0, 0, 0]},
        {"shape": {"ellipsoid": {"lengths": [0.8, 0.4, 0.2]}}, "position": [0, 0, 0]},
        {"shape": {"capsule": {"axis": "x", "radius": 0.2, "length": 0.8}}, "position": [0, 0, 0]},
    ]
    scene = validate(changed(bodies=bodies, box=SPHERE["fluid"]["box"] | {"cells": [32, 32, 32]}))
    assert scene.fluid
    turned, tipped, cylinder, flat, capsule = scene.fluid.bodies
    (outline,) = MIDDLE.body(turned, [0.0, 0.0, 0.0, 0.0], scene.fluid)
    corner = rotation([0, 0, 1], 0.5)[:2, :2] @ [0.4, -0.1]
    assert outline.max(axis=0)[0] == pytest.approx(corner[0], abs=2e-3)
    (outline,) = MIDDLE.body(tipped, [0.4, 0.0, 0.0, 0.0], scene.fluid)
    ends = [*outline.min(axis=0), *outline.max(axis=0)]
    assert ends == pytest.approx([-0.4, -0.1 / np.cos(0.2), 0.4, 0.1 / np.cos(0.2)], abs=3e-3)
    (outline,) = MIDDLE.body(cylinder, [0.0, 0.0, 0.18, 0.0], scene.fluid)
    assert outline[:, 1].max() == pytest.approx(0.24, abs=2e-3)
    assert outline[:, 0].max() - outline[:, 0].min() > 4.0, "it goes through the box"
    assert MIDDLE.body(flat, [0.0, 0.0, 0.11, 0.0], scene.fluid) == []
    (outline,) = MIDDLE.body(capsule, [0.0, 0.0, 0.12, 0.0], scene.fluid)
    assert outline.max(axis=0) == pytest.approx([0.2 + 0.16, 0.16], abs=2e-3), "0.16 from its core"
    solids = flow.View(scene).outlines([], [[0.0, 0.0, 0.0, 0.0]] * 5)
    assert len(solids) == 5


PLATE = {"shape": {"plate": {"length": 0.8, "width": 0.6}}, "position": [0.0, 0.0, 0.05]}
TURNED = {"turn": {"axis": [0, 0, -1], "angle": 0.5}, "pivot": [-0.2, 0, 0]}
CORNERS = [(-0.4, 0, -0.3), (0.4, 0, -0.3), (0.4, 0, 0.3), (-0.4, 0, 0.3)]


def test_a_plate_is_cut_in_a_line_and_a_disk_in_its_diameter():
    bodies = [PLATE | TURNED, {"shape": {"disk": {"radius": 0.5}}, "position": [0.1, 0, 0.3]}]
    scene = validate(changed(bodies=bodies))
    assert scene.fluid
    first, disk = scene.fluid.bodies
    lines = np.concatenate(MIDDLE.body(first, [0.0, 0.0, 0.05, 0.1], scene.fluid))
    # The length from -0.2 to 0.6 of the pivot, downwards to the right by 0.4.
    ends = np.array([[-0.2], [0.6]]) * [np.cos(0.4), -np.sin(0.4)]
    assert lines.min(axis=0) == pytest.approx(ends.min(axis=0)) and lines.max(axis=0) == pytest.approx(ends.max(axis=0))
    lines = np.concatenate(MIDDLE.body(disk, [0.1, 0.0, 0.3, 0.0], scene.fluid))
    assert lines[:, 0].max() == pytest.approx(0.1 + 0.4, rel=2e-3) and abs(lines[:, 1]).max() == 0.0
    assert MIDDLE.body(disk, [0.1, 0.0, 0.6, 0.0], scene.fluid) == []
    assert len(flow.View(scene).outlines([], [[0.0, 0.0, 0.05, 0.0], [0.1, 0.0, 0.3, 0.0]])) == 2, "a line each"


def test_a_plate_is_the_same_as_its_triangles_also_from_a_file(libraries, tmp_path):
    """Triangles in the order of the plate's own give its bits; a file in millimetres gives its forces to rounding."""
    trimesh = pytest.importorskip("trimesh")
    triangles = [(0, 1, 2), (0, 2, 3)]
    mesh = trimesh.Trimesh([[1000 * x for x in corner] for corner in CORNERS], triangles, process=False)
    mesh.export(tmp_path / "plate.obj")
    shapes = [
        PLATE["shape"],
        {"triangulation": {"nodes": CORNERS, "triangles": triangles}},
        {"triangulation": {"file": "plate.obj", "unit": 1e-3}},
    ]
    series, coefficients = [], []
    for i, shape in enumerate(shapes):
        (tmp_path / f"{i}.json").write_text(json.dumps(changed(bodies=[PLATE | TURNED | {"shape": shape}])))
        done = api.run(load(tmp_path / f"{i}.json"), tmp_path / f"run-{i}", quiet=True)
        series.append(done.series)
        coefficients.append(done.summary.bodies["body_1"].cd_mean)
    plate, same, read = series
    assert coefficients == pytest.approx([coefficients[0]] * 3, rel=1e-9), "they have one area"
    assert all(np.array_equal(plate[name], same[name]) for name in plate)
    for name in ("drag", "lift", "body_1_moment_z"):
        assert read[name] == pytest.approx(plate[name], rel=1e-9, abs=1e-9) and plate[name][-1] != 0.0


@pytest.mark.parametrize(
    ("shape", "named"),
    [
        ({"plate": {"length": 1.0}}, ["fluid.bodies[0].shape`", "a width"]),
        ({"plate": {"length": 1.0, "width": 0.0}}, ["width", "> 0"]),
        ({"disk": {"radius": -1.0}}, ["disk.radius", "> 0"]),
        ({"triangulation": {}}, ["triangulation.triangles", "list of 0", "1 to 100000"]),
        ({"triangulation": {"nodes": CORNERS, "triangles": [[0, 1, 4]]}}, ["triangles[0]", "4 nodes"]),
        ({"triangulation": {"nodes": CORNERS, "triangles": [[0, 1, 2], [1, 2, 1]]}}, ["triangles[1]", "no area"]),
        ({"triangulation": {"nodes": CORNERS, "triangles": [[0, 1, -2]]}}, ["triangles[0][2]"]),
        ({"triangulation": {"nodes": CORNERS, "triangles": [[0, 1, 2]], "unit": 1.0}}, ["triangulation.unit", "file"]),
        ({"triangulation": {"file": "none.stl"}}, ["triangulation.file", "No such file"]),
        ({"triangulation": {"file": "scene.json"}}, ["triangulation.file", ".stl"]),
        ({"triangulation": {"file": "bad.stl"}}, ["triangulation.file", "triangles"]),
        ({"triangulation": {"file": "bad.stl", "unit": -1.0}}, ["triangulation.unit", "> 0"]),
    ],
)
def test_a_surface_that_is_none_is_refused_by_key(shape, named, libraries, tmp_path):
    (tmp_path / "bad.stl").write_text("solid nothing\nendsolid nothing\n")
    (tmp_path / "scene.json").write_text(json.dumps(changed(bodies=[PLATE | {"shape": shape}])))
    with pytest.raises(SceneError) as refused:
        load(tmp_path / "scene.json")
    assert all(part in str(refused.value) for part in named), refused.value


def test_an_animation_in_space_has_slices_and_vortices(run, monkeypatch, capsys):
    found, folder = run
    has = importlib.util.find_spec("pyvista") is not None
    films = {path.name for path in found.animate() if path.suffix != ".mp4"}
    assert films == {"phases.png", "vorticity.gif"} | ({"vortices.png", "vortices.gif"} if has else set())
    if has:
        with Image.open(folder / "vortices.gif") as film:
            assert film.n_frames == 3 and film.width >= 720  # type: ignore[attr-defined]
        with Image.open(folder / "vortices.png") as picture:
            colours = np.asarray(picture.convert("RGB"), int).reshape(-1, 3)
        grey = np.ptp(colours, axis=1) < 12
        assert (~grey).mean() > 0.01, "coloured surfaces"
        assert (grey & (colours[:, 0] > 60) & (colours[:, 0] < 235)).mean() > 0.002, "the sphere between them"
    monkeypatch.setitem(sys.modules, "pyvista", None)
    capsys.readouterr()
    assert not {"vortices.gif"} & {path.name for path in found.animate(0.07)}
    assert "-m pip install pyvista`" in capsys.readouterr().err


def test_a_body_that_falls_and_turns_is_shown_where_it_is(libraries, tmp_path):
    """A long cuboid falls freely, and a spring turns it about z; pictures cut it where the fluid has it."""
    mount = {"mass": 1.0, "inertia": [0.4, 0.5, 0.3], "y": {}, "angle_z": {"stiffness": 60.0, "rest": 0.8}}
    body = {"shape": {"cuboid": {"lengths": [0.8, 0.3, 0.6]}}, "position": [0.0, 0.3, 0.0]}
    scene = changed(bodies=[body | {"mount": mount | {"gravity": [0.0, -9.0, 0.0]}}], mean_flow={}, probes=[])
    scene["fluid"]["initial_velocity"], scene["time"]["end"] = [0.0, 0.0, 0.0], 0.2
    done = api.run(validate(scene), tmp_path / "run", fields_every=0.1, quiet=True)
    series, numbers = done.series, done.summary.dimensionless
    y, angle = series["body_1_y"], series["body_1_angle_z"]
    # It falls no faster than under its weight less that of the fluid, without the fluid that it takes along.
    assert 0.05 < 0.3 - y[-1] < 0.5 * 9.0 * (1 - 2 * 0.144) * 0.2**2 and 0.8 < angle[-1] < 1.6
    assert (series["body_1_x"] == 0.0).all() and not series["body_1_angle_x"].any()
    assert numbers.mounts["body_1"].mass_ratio == pytest.approx(1 / 0.288)
    assert numbers.mounts["body_1"].supports["angle_z"].natural_frequency == pytest.approx(200**0.5 / (2 * np.pi))
    assert numbers.velocity_of == "fall of body 1" and {"body_1_y", "body_1_vy"} <= {*done.summary.quantities}
    frames = Frames(tmp_path / "run", Part(across="z"))
    (outline,) = frames.solids(len(frames.times) - 1)
    turn = rotation([0, 0, 1], angle[-1])[:2, :2]
    corners = np.array([(0.4, 0.15), (-0.4, 0.15), (-0.4, -0.15), (0.4, -0.15)]) @ turn.T + [0.0, y[-1]]
    for found, expected in ((outline.min(axis=0), corners.min(axis=0)), (outline.max(axis=0), corners.max(axis=0))):
        assert found == pytest.approx(expected, abs=5e-3)


def test_the_master_moves_a_body_in_space(libraries):
    """By a rotation vector about an oblique axis: the unit and the pictures turn the body alike."""
    axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0]

    def drive(t, _):
        turn = {f"angle_{about}": 3 * t * along for about, along in zip("xyz", axis)}
        turn |= {f"omega_{about}": 3 * along for about, along in zip("xyz", axis)}
        return {f"body[1].motion.{part}": value for part, value in {"x": 0.1 * t, "z": t, **turn}.items()}

    scene = changed(bodies=[SPHERE["fluid"]["bodies"][0] | {"motion": "master"}])
    with Session(validate(scene), drive=drive) as session:
        unit = session.units["fluid"]
        names = [f"body[1].motion.{part}" for part in (*PLACE, *TURN)]
        names += [f"body[1].motion.{part}" for part in ("vx", "vy", "vz", "omega_x", "omega_y", "omega_z")]
        assert [name for name in unit.variables if ".motion." in name] == names
        session.run()
        (pose,) = flow.poses(session.scene, lambda name: float(unit.read(name)[0]))
    assert pose == pytest.approx([0.01, 0.0, 0.1, *(0.3 * along for along in axis)])
    turn, origin = placed(session.scene.fluid.bodies[0], pose)
    assert turn == pytest.approx(rotation(axis, 0.3)) and origin == pytest.approx([0.01, 0.0, 0.1])


def test_a_body_pitches_and_rolls_about_its_edge(libraries, tmp_path):
    roll, pitch = 0.8, 0.5  # rad, at the end

    def law(angle: float) -> dict:
        return {"sine": {"amplitude": angle, "frequency": 2.5}}

    body = {
        "shape": {"plate": {"length": 0.5, "width": 0.5}},
        "position": [0.1, 0.0, -0.2],
        "pivot": [0.0, 0.0, -0.25],
        "motion": {"angle": law(pitch), "rotations": [{"axis": [2, 0, 0], "angle": law(roll)}]},
    }
    scene = validate(changed(bodies=[body], mask={"log_linear": {"c_eta": 1e-3}}))
    series = api.run(scene, tmp_path, quiet=True).series
    place = [series[f"body_1_{name}"][-1] for name in (*PLACE, *TURN)]
    axes, origin = placed(scene.fluid.bodies[0], place)
    expected = rotation([1, 0, 0], roll) @ rotation([0, 0, 1], pitch)
    assert np.allclose(axes, expected, atol=1e-12), f"{axes} against {expected}"
    assert np.allclose(origin, [0.1, 0, -0.2] + expected @ [0, 0, 0.25]), origin
    assert series["body_1_power"][2] < 0, f"the fluid gives {series['body_1_power']} W to a body that is driven"


def test_q_is_that_of_a_vortex_and_of_a_strain():
    """A column of Taylor and Green has Q = ± k² where it turns and where it strains, by differences a little less."""
    n, k = 32, 2 * np.pi
    x, y, _ = np.meshgrid(*[np.arange(n) / n] * 3, indexing="ij")
    u = np.stack([np.sin(k * x) * np.cos(k * y), -np.cos(k * x) * np.sin(k * y), 0 * x], axis=-1)
    found = vortices.strength(u, [1 / n] * 3)
    share = (np.sin(k / n) * n / k) ** 2
    assert found[0, 0, 3] == pytest.approx(-(k**2) * share) and found[n // 4, n // 4, 0] == pytest.approx(k**2 * share)


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_in_space_goes_back_and_on_in_another_instance(version, instantiate):
    scene = changed(precision="single") | {"time": {"end": 0.2, "communication_step": 0.02}}
    scene["fluid"]["bodies"][0]["motion"] = {"y": {"sine": {"amplitude": 0.1, "frequency": 3.0}}}
    first, second = (instantiate(scene, version)["fluid"] for _ in range(2))

    def shown(unit, begin):
        for step in range(begin, begin + 3):
            unit.step(0.02 * step, 0.02)
        unit.get()
        return np.concatenate([unit.outputs, *(unit.field(name).ravel() for name in ("u", "w", "p", "vorticity_x"))])

    for unit in (first, second):
        unit.connect([], ["drag", "body[1].y", "kinetic_energy"])
        unit.start()
    goes_back_and_on(first, second, shown, 3)


def test_a_unit_of_fmi_3_has_few_variables_and_no_fault(packed):
    path = packed("fluid", SPHERE, 3)
    assert validate_fmu(str(path)) == []
    assert len(read_description(path).modelVariables) < 60


def test_a_step_that_diverges_is_refused_until_a_state_is_restored(instantiate):
    jump = {"table": {"times": [0.0, 0.02, 0.04, 0.06], "values": [1.0, 1.0, 1.0, 1e3]}}
    unit = instantiate(changed(mean_flow={"x": jump}))["fluid"]
    unit.start()
    unit.save()
    unit.step(0.0, 0.02)
    unit.step(0.02, 0.02)
    for _ in range(2):
        with pytest.raises(UnitError, match="diverged"):
            unit.step(0.04, 0.02)
    unit.restore()
    unit.step(0.0, 0.02)


LIMITED = """
import resource, sys
from nervure import api
resource.setrlimit(resource.RLIMIT_AS, (3 * 10**9,) * 2)
api.run("sphere-stream-144x96x96", sys.argv[1], overrides=["fluid.box.cells=[400, 400, 400]"], quiet=True)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the memory of a process of Linux")
def test_memory_that_is_not_there_is_said_before_the_run(tmp_path, libraries):
    done = subprocess.run([TOOL[0], "-c", LIMITED, tmp_path / "run"], capture_output=True, text=True)
    assert done.returncode == 1 and "memory" in done.stderr.splitlines()[-1], done.stderr


@pytest.mark.parametrize(
    ("parts", "named"),
    [
        ({"box": SPHERE["fluid"]["box"] | {"cells": [32, 16]}}, ["fluid.box.cells", "3 numbers"]),
        ({"box": SPHERE["fluid"]["box"] | {"cells": [32, 16, 7]}}, ["fluid.box.cells", "8"]),
        ({"box": SPHERE["fluid"]["box"] | {"cells": [32, 16, 16.5]}}, ["fluid.box.cells"]),
        ({"channel": {"y": [-0.9, 0.9], "z": [-3.0, 0.9]}}, ["fluid.channel.z"]),
        ({"probes": [{"name": "far", "position": [1.0, 0.0]}]}, ["fluid.probes", "3 components"]),
        ({"bodies": [{"shape": {"sphere": {"radius": -0.1}}, "position": [0, 0, 0]}]}, ["radius", "> 0"]),
        (
            {"bodies": [SPHERE["fluid"]["bodies"][0] | {"turn": {"axis": [0, 0, 0], "angle": 1}}]},
            ["turn.axis"],
        ),
        ({"box": SPHERE["fluid"]["box"] | {"z": [1.0, -1.0]}}, ["fluid.box.z"]),
        ({"box": {"x": [-1.5, 2.5], "y": [-1.0, 1.0], "cells": [32, 16]}}, ["two dimensions", "sphere"]),
        ({"cylinders": [{"center": [0.0, 0.0], "radius": 0.1}]}, ["fluid.cylinders", "bodies"]),
        ({"bodies": [{"shape": {"circle": {"radius": 0.1}}, "position": [0, 0, 0]}]}, ["circle", "sphere"]),
        (
            {
                "bodies": [
                    SPHERE["fluid"]["bodies"][0]
                    | {"motion": {"rotations": [{"angle": {"constant": 1}, "axis": [0, 0, 0]}]}}
                ]
            },
            ["bodies[0].motion.rotations[0].axis"],
        ),
        ({"bodies": [{"shape": {"sphere": {"radius": 0.1}}, "position": [0, 0]}]}, ["position", "3 components"]),
        ({"bodies": [{"shape": {"cuboid": {"lengths": [1, 0, 1]}}, "position": [0, 0, 0]}]}, ["lengths", "> 0"]),
        ({"time_stepping": {"max_step": 0.02, "max_cfl": 0.4, "scheme": "rk2"}}, ["scheme", "sbdf2"]),
        ({"box": SPHERE["fluid"]["box"] | {"cells": [4096, 4096, 4096]}}, ["fluid.box.cells", "67108864"]),
    ],
)
def test_parts_of_other_dimensions_are_refused_by_their_key(parts, named, libraries, tmp_path):
    with pytest.raises(SceneError) as refused:
        api.run(validate(changed(**parts)), tmp_path / "run", quiet=True)
    assert all(part in str(refused.value) for part in named), refused.value
