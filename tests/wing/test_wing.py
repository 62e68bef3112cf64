"""A wing alone: its run, its unit in both versions of FMI, its states, and what it refuses."""

import copy
import math
import re
import zipfile
from itertools import combinations
from typing import Any

import fmpy
import h5py
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from matplotlib.backends.backend_agg import FigureCanvasAgg

import nervure
from nervure.errors import SceneError
from nervure.output import animation
from nervure.output.wings import WingPicture
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.simulation import checkpoint
from nervure.simulation.session import Session
from nervure.units import package
from nervure.units.describe import describe
from nervure.units.fmu import read_description
from tests.conftest import nervure as command
from tests.reliability.checks import CHECKS, unpack
from tests.reliability.unit import WING, child, tried

pytestmark = [pytest.mark.usefixtures("libraries"), pytest.mark.pictures]
HANGING = ROOT / "examples" / "wing-hanging.json"
COARSE = ["wing.mesh.insect.along=4", "time.end=0.02"]


@pytest.fixture
def wing():
    """A small wing, as JSON."""
    return copy.deepcopy(WING)


@pytest.fixture(scope="module")
def run(tmp_path_factory, libraries):
    """The example on a coarse mesh, with fields."""
    folder = tmp_path_factory.mktemp("wing") / "run"
    return nervure.run(HANGING, folder, overrides=COARSE, fields_every=2e-3, quiet=True)


def test_its_energies_and_works_balance(run):
    """Gravity gives what bending, motion and damping take, within 2 % in 20 steps."""
    series = run.series
    assert (
        run.summary.completed
        and {"tip_ux", "tip_uz", "root_force_z", "load_work", "section_twist", "section_camber"} <= series.keys()
    )
    held = series["energy_elastic"] + series["energy_kinetic"] + series["energy_gravity"]
    lost = np.trapezoid(series["damping_power"], series["time"])
    assert series["energy_gravity"][-1] < -1e-6
    assert series["energy_kinetic"][-1] > -0.2 * series["energy_gravity"][-1]
    assert held[-1] + lost == pytest.approx(0.0, abs=-0.02 * series["energy_gravity"][-1])


def test_its_pictures_and_its_file_show_the_mesh(run):
    mesh = run.facts.wing
    assert {"tip.png", "wing.png", "wing.vtkhdf"} <= {path.name for path in run.folder.iterdir()}
    with h5py.File(run.folder / "wing.vtkhdf") as file:
        root = file["VTKHDF"]
        points = root["Points"][:].reshape(-1, len(mesh.nodes), 3)
        assert len(points) == root["Steps"].attrs["NSteps"] == 11
        assert np.array_equal(root["Polygons/Connectivity"][:].reshape(-1, 3), mesh.triangles)
    assert points[0] == pytest.approx(mesh.nodes, abs=1e-8)
    assert np.abs(points[:, mesh.roots[0]] - mesh.nodes[mesh.roots[0]]).max() < 1e-8
    tip = int(np.argmax(np.linalg.norm(mesh.nodes, axis=1)))
    assert points[-1, tip, 2] == pytest.approx(run.series["tip_uz"][-1], abs=1e-7) != 0.0


def test_the_path_of_its_tip_is_as_smooth_as_the_series(run):
    frames = animation.Frames(run.folder)
    mesh, chosen = frames.facts.wing, list(range(2, 11))
    assert mesh is not None
    (path,) = animation._paths_of_tips(frames, mesh, chosen)
    assert len(path) == 17, "each step from the first frame to the last"
    tip = int(np.argmax(np.linalg.norm(mesh.nodes, axis=1)))
    seen = np.array(frames.wing["VTKHDF/Points"][tip :: len(mesh.nodes)])[chosen]
    assert path[::2] == pytest.approx(seen, abs=1e-7)


@pytest.mark.parametrize("sizes", [(1, 1, 0), (2.5, 1, 5), (1, 2, 0.4), (0.1, 1, 0.1), (3, 0.2, 0.2), (0.7, 0.1, 2.5)])
@pytest.mark.parametrize("width", [7.5, 9.0])
def test_no_label_of_its_axes_lies_on_another(run, sizes, width):
    """For a wing that moves over a box of these sizes; numbers in mm are the longest."""
    corners = np.array([[0, -1, -0.5], [1, 0, 0.5]]) * sizes
    picture = WingPicture(run.scene, run.facts.wing, corners[None], np.empty((0, 3)), width)
    picture.figure.set_dpi(100)
    FigureCanvasAgg(picture.figure).draw()
    axes = [picture.axes.xaxis, picture.axes.yaxis, picture.axes.zaxis]
    texts = [text for axis in axes for text in (axis.label, *axis.get_majorticklabels()) if text.get_text()]
    assert len(texts) >= 7, [text.get_text() for text in texts]
    for ends in (axis.label.get_window_extent().extents for axis in axes):
        assert (ends > 0).all() and (ends[2:] < [100 * width, 100 * picture.figure.get_figheight()]).all(), ends
    for one, other in combinations(texts, 2):
        assert not one.get_window_extent().overlaps(other.get_window_extent()), (one.get_text(), other.get_text())


def test_a_wing_wider_than_the_square_of_its_axes_is_drawn_whole(run):
    nodes = run.facts.wing.nodes
    picture = WingPicture(run.scene, run.facts.wing, nodes[None], nodes, 9.0)
    picture.add(nodes)
    picture.draw_path(nodes)
    picture.show(nodes)
    drawn = [*picture.axes.collections, *picture.axes.lines]
    assert len(drawn) == 9 and not any(artist.get_clip_on() for artist in drawn), drawn


def test_the_command_animates_and_inspects_it(run, tmp_path):
    done = command("animate", run.folder)
    assert done.returncode == 0 and {"motion.png", "motion.gif"} <= {path.name for path in run.folder.iterdir()}
    done = command("inspect", HANGING, "--set", COARSE[0], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert f"{len(run.facts.wing.nodes)} nodes, {len(run.facts.wing.triangles)} triangles, 5 veins" in done.stdout
    assert (tmp_path / "results" / "wing-hanging" / "mesh.png").stat().st_size > 10_000


def test_a_resumed_run_has_the_bits_of_a_whole_one(wing, tmp_path):
    wing["wing"]["gravity"], wing["time"]["end"] = [0.0, 0.0, -9.81], 0.01
    scene = validate(wing)
    whole = nervure.run(scene, tmp_path / "whole", quiet=True)
    half = nervure.run(scene, tmp_path / "half", quiet=True, on_step=lambda time, _: time > 0.005)
    assert not half.summary.completed
    session, _ = checkpoint.resume(half.folder)
    with session:
        session.run()
        rest = session.finish()
    assert len(rest.series["time"]) == 51
    assert [name for name in whole.series if not np.array_equal(whole.series[name], rest.series[name])] == []


@pytest.mark.parametrize("version", [2, 3])
def test_fmpy_finds_no_fault(version, wing, packed):
    assert validate_fmu(str(packed("wing", wing, version))) == []


def test_the_versions_of_fmi_give_the_same_motion_to_another_master(wing, packed):
    wing["wing"]["gravity"] = [0.0, 0.0, -9.81]
    names = ["tip.uz", "energy.elastic"]
    times = {"stop_time": 0.01, "step_size": 2e-4, "output_interval": 2e-4}
    two, three = (
        fmpy.simulate_fmu(str(packed("wing", wing, version)), output=names, validate=False, **times)
        for version in (2, 3)
    )
    assert len(two) == 51 and two["tip.uz"][-1] < -1e-5
    assert all(np.array_equal(two[name], three[name]) for name in names)


def test_it_claims_states_and_no_derivatives(wing, packed):
    about = read_description(packed("wing", wing)).coSimulation
    assert about.canGetAndSetFMUstate and about.canSerializeFMUstate
    assert not about.providesDirectionalDerivative
    assert not read_description(packed("wing", wing, 3)).coSimulation.providesAdjointDerivatives


def test_the_same_scene_gives_the_same_bytes_and_another_scene_another_identity(wing, tmp_path):
    first, second = (package.pack(describe("wing", wing), tmp_path / folder) for folder in "ab")
    assert first.read_bytes() == second.read_bytes()
    wing["wing"]["membrane"]["tension"] = 1.0
    assert read_description(package.pack(describe("wing", wing), tmp_path)).guid != read_description(first).guid
    with zipfile.ZipFile(first) as archive:
        page = archive.read("documentation/index.html").decode("utf-8")
    assert "<td>force_x[1] … force_x[" in page


@pytest.mark.parametrize(
    "name", ["sequences", "sequences_3", "hostile", "corrupted", "forged", "processes", "rollbacks", "threads", "modes"]
)
def test_check_of_units_finds_nothing(name, tmp_path):
    check = CHECKS[name]
    count = min(check.few, 30) if name == "hostile" else check.few  # A solve under absurd loads is long
    child("forkserver", 60.0, tried, check.function, "wing", unpack("wing", tmp_path), count)


SQUARE: dict[str, Any] = {
    "nodes": [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]],
    "triangles": [[0, 1, 2], [0, 2, 3]],
    "chains": [{"name": "root", "nodes": [0, 3]}, {"name": "left", "nodes": [3, 2]}],
}


def test_a_square_of_two_triangles_is_a_wing(wing):
    wing["wing"]["mesh"] = {"triangles": SQUARE}
    assert "force_x[4]" in describe("wing", wing).xml


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("triangles", [[0, 1, 2], [0, 2, 2]], r"triangles\[1\]` is \[0, 2, 2\], but it must be a triangle with"),
        ("triangles", [[0, 1, 2], [0, 2, 4]], r"triangles\[1\]` is \[0, 2, 4\], but it must be three numbers"),
        ("triangles", [[0, 1, 2], [2, 0, 3]], r"triangles\[1\]` is \[2, 0, 3\], .* the same sense of rotation"),
        ("nodes", [*SQUARE["nodes"], [0.2, 0.0, 0.0]], r"nodes\[4\]` is .*in no triangle and no vein"),
        ("nodes", [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [0, 0.1, 0]], r"triangles\[0\]` is .* a triangle with"),
        ("nodes", [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0.1, 0.1, 0]], r"triangles\[1\]` .* a triangle with"),
        ("nodes", [[0, 0, 0], [0.1, 0, 0], [0.1, math.inf, 0], [0, 0.1, 0]], r"nodes\[2\]\[1\]` must be a number"),
        ("chains", [{"name": "root", "nodes": [0, 9]}, SQUARE["chains"][1]], r"chains\[0\]\.nodes\[1\]` is 9"),
        ("chains", [SQUARE["chains"][0]], r'`wing\.veins\[0\]\.chain` is "left", .*the chains of the mesh are `root`'),
        ("chains", [SQUARE["chains"][1]], r'`wing\.root` is "root", .*the chains of the mesh are `left`'),
        ("chains", [SQUARE["chains"][0], {"name": "left", "nodes": [2, 2]}], r"nodes\[1\]` is 2, .*has it already"),
    ],
)  # fmt: skip
def test_a_bad_mesh_is_refused_with_its_place(key, value, said, wing):
    wing["wing"]["mesh"] = {"triangles": SQUARE | {key: value}}
    with pytest.raises(SceneError, match=said):
        describe("wing", wing)


STRIP: dict[str, Any] = {
    "nodes": [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [2, 0, 0], [2, 1, 0]],
    "triangles": [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
    "chains": [{"name": "root", "nodes": [0, 1]}, {"name": "tip", "nodes": [4, 5]}],
    "groups": [{"name": "stiff", "triangles": [2, 3]}],
}
FILM = {"areal_density": 1e-6, "stretching_stiffness": 100.0, "bending_stiffness": 1.0}


def with_regions(regions, mesh, membrane=FILM):
    """A scene of a wing alone with regions, as JSON."""
    own = {"mesh": mesh, "membrane": membrane, "regions": regions}
    return {"name": "regions", "time": {"end": 4.0, "communication_step": 0.02}, "wing": own}


@pytest.mark.parametrize("where", [{}, {"polygon": [[1, 0], [3, 0], [3, 1], [1, 1]]}])
def test_two_materials_in_a_row_strain_by_their_stiffnesses(where):
    """A bar of 1 kg/m in a pull of 0.01 m/s² hangs from a strip, of which the outer half is three times as stiff."""
    scene = with_regions(
        [{"name": "stiff", "membrane": FILM | {"stretching_stiffness": 300.0}} | where], {"triangles": STRIP}
    )
    bar = {"chain": "tip", "line_density": 1.0, "bending_stiffness": 1.0, "axial_stiffness": 1e3}
    scene["wing"] |= {"root": "root", "veins": [bar], "gravity": [0.01, 0.0, 0.0], "relaxation_time": 0.23}
    with Session(validate(scene)) as session:
        session.run()
        x = np.array(session.units["wing"].read("x"))
    strains = np.diff(x[::2]) - 1.0
    print(strains)
    assert strains == pytest.approx([1e-4, 1e-4 / 3], rel=1e-3)


def test_a_falling_wing_stays_above_a_ground_with_contact(tmp_path):
    """A wing without a root falls by 0.1 m in 0.143 s, and bounces at a gap within the range of 0.03 m."""
    scene: Any = {
        "format": 2,
        "name": "dropped",
        "time": {"end": 0.3, "communication_step": 1e-3},
        "wing": {
            "mesh": {"rectangular": {"length": 0.2, "width": 0.1, "along": 4}},
            "membrane": {
                "areal_density": 1.0,
                "stretching_stiffness": 1e5,
                "bending_stiffness": 0.01,
                "poisson_ratio": 0.3,
            },
            "gravity": [0, 0, -9.81],
        },
    }
    ground = {"shape": {"cuboid": {"lengths": [2, 2, 1]}}, "position": [0, 0, -0.6]}
    with pytest.raises(SceneError, match=r"contact.range.*a wing without a fluid needs it"):
        describe("wing", scene | {"contact": {"obstacles": [ground]}})
    scene["contact"] = {"range": 0.03, "damping": 20, "obstacles": [ground]}
    run = nervure.run(validate(scene), tmp_path / "run", quiet=True)
    assert run.summary.completed and run.series["energy_contact"].max() > 0.0
    assert -0.1 < run.series["tip_uz"].min() < -0.07


def test_a_falling_wing_has_the_mass_of_its_regions(tmp_path):
    """The second region takes triangles from the first; the kinetic energy of a free fall gives the mass."""
    square = [[0.5, -1], [2, -1], [2, 1], [0.5, 1]]
    heavy, heavier = (FILM | {"areal_density": density} for density in (2.0, 5.0))
    regions = [
        {"name": "outer", "polygon": square, "membrane": heavy},
        {"name": "left", "polygon": [[0.5, 0], [2, 0], [2, 1], [0.5, 1]], "membrane": heavier},
    ]
    mesh = {"rectangular": {"length": 1.0, "width": 1.0, "along": 6}}
    scene = with_regions(regions, mesh, FILM | {"areal_density": 1.0})
    scene["wing"]["gravity"], scene["time"]["end"] = [0.0, 0.0, -10.0], 0.1
    run = nervure.run(validate(scene), tmp_path, force=True, quiet=True)
    own = run.facts.wing
    corners = own.nodes[own.triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    mass = areas @ np.array([1.0, 2.0, 5.0])[own.materials]
    found = run.series["energy_kinetic"][-1] / 0.5
    print(found, mass)
    assert sorted(set(own.materials)) == [0, 1, 2] and found == pytest.approx(mass, rel=1e-9)


@pytest.mark.parametrize(
    ("region", "groups", "said"),
    [
        ({"name": "soft"}, None, r'`wing\.regions\[0\]\.name` is "soft", .*groups of the mesh are `stiff`.*`polygon`'),
        ({"name": "soft"}, [], r'`wing\.regions\[0\]\.name` is "soft", .*no groups: a region needs a `polygon`'),
        ({"name": "a", "polygon": [[5, 0], [6, 0], [6, 1]]}, None, r"regions\[0\]\.polygon` is .*middle of a triangle"),
        ({"name": "a", "polygon": [[5, 0], [6, 0]]}, None, r"regions\[0\]\.polygon` .*3"),
        ({"name": "stiff"}, [{"name": "stiff", "triangles": [4]}], r"triangles\[0\]` is 4, .*triangles 0 to 3"),
    ],
)  # fmt: skip
def test_a_bad_region_is_refused_with_its_key(region, groups, said):
    mesh = {"triangles": STRIP if groups is None else STRIP | {"groups": groups}}
    with pytest.raises(SceneError, match=said):
        describe("wing", with_regions([region | {"membrane": FILM}], mesh))


def test_the_picture_of_a_mesh_names_its_regions(tmp_path):
    regions = ['wing.regions=[{"name": "outer", "polygon": [[0.03, -1], [1, -1], [1, 1], [0.03, 1]], "membrane": '
               '{"areal_density": 0.1, "stretching_stiffness": 500}}]']  # fmt: skip
    done = command("inspect", HANGING, "--set", COARSE[0], "--set", regions[0], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "regions outer (" in said and re.search(r"wing [\d.]+ x [\d.]+ x 0 m, \d+ nodes", said), said
    assert (tmp_path / "results" / "wing-hanging" / "mesh.png").stat().st_size > 10_000
