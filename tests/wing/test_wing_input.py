"""Wings and surfaces that cannot be meant, refused or warned of by what needs no library of a wing.

Reports: `mesh-seam` (sheets that share no node), `wfile-w` and `wfile-w-mm` (the unit of a file), `wing-curved-veins`.
"""

import json
from typing import Any

import numpy as np
import pytest

from nervure.errors import SceneError
from nervure.scene import load
from nervure.scene.facts import Facts

pytestmark = pytest.mark.usefixtures("libraries")

LONG, WIDE = 4, 2
NODES = [[i / LONG, j / 2 / WIDE, 0.0] for i in range(LONG + 1) for j in range(WIDE + 1)]
TRIANGLES = [
    corners
    for a in (3 * i + j for i in range(LONG) for j in range(WIDE))
    for corners in ([a, a + 3, a + 4], [a, a + 4, a + 1])
]
CHAINS: dict[str, list[int]] = {"root": [0, 1, 2], "left": [0, 3, 6, 9, 12], "point": [0], "corners": [0, 2]}
FILM = {"areal_density": 1.0, "stretching_stiffness": 1e4, "bending_stiffness": 1.0, "poisson_ratio": 0.0}
TORSION: dict[str, float] = {"torsional_stiffness": 0.5}
VEIN = {"line_density": 0.1, "bending_stiffness": 1.0, "axial_stiffness": 10.0}
TIME = {"end": 0.02, "communication_step": 0.005}
NO_AXES = [[1e308, 0, 0], [0, 1e-200, 0]]
CUBE = {"cuboid": {"lengths": [1, 1, 1]}}
HALF = [[0, 0], [0.6, 0], [0.6, 1], [0, 1]]
OTHER = [[0.4, 0], [1, 0], [1, 1], [0.4, 1]]


def wing(nodes: Any = NODES, triangles: Any = TRIANGLES, chains: Any = None, veins: Any = (), **keys: Any) -> Any:
    """Return a scene of a wing of 1 m by 0.5 m with its root at x = 0, as JSON."""
    named = [{"name": name, "nodes": list(nodes)} for name, nodes in (CHAINS | (chains or {})).items()]
    groups = keys.pop("groups", [])
    mesh = {"triangles": {"nodes": nodes, "triangles": triangles, "chains": named, "groups": groups}}
    own = {"mesh": mesh, "membrane": FILM, "veins": [{"chain": chain} | VEIN for chain in veins], "root": "root"}
    return {"name": "wing", "time": TIME, "wing": own | keys}


def body(shape: Any, **keys: Any) -> Any:
    """Return a scene of a body in a cube of 4 m, as JSON."""
    box = {axis: [-2, 2] for axis in "xyz"} | {"cells": [16, 16, 16]}
    own = {"density": 1.0, "kinematic_viscosity": 0.01, "box": box, "initial_velocity": [0, 1.0, 0]}
    rest = {"mask": {"log_linear": {"c_eta": 1e-4}}, "time_stepping": {"max_step": 0.005, "max_cfl": 0.4}}
    bodies = [{"shape": shape, "position": [0, 0, 0]} | keys]
    return {"name": "body", "time": TIME, "fluid": own | rest | {"bodies": bodies}}


def twisted(chain: list[int], vein: Any = (), **keys: Any) -> Any:
    """Return a scene of that wing with veins with torsion along `chain` and along its left side."""
    scene = wing(chains={"v": chain}, veins=["v", "left"], **keys)
    for own in scene["wing"]["veins"]:
        own |= TORSION | dict(vein)
    return scene


def regions(*polygons: Any) -> Any:
    return [{"name": f"r{i}", "polygon": polygon, "membrane": FILM} for i, polygon in enumerate(polygons)]


def turns(axis: Any) -> Any:
    return {"rotations": [{"axis": axis, "angle": {"sine": {"amplitude": 0.1, "frequency": 1.0}}}]}


def cut(y: float | None = None) -> tuple[Any, Any]:
    """Return nodes and triangles of two sheets along y, or, with `y`, of a wing that is slit along it."""
    nodes, triangles = [list(node) for node in NODES], [list(corners) for corners in TRIANGLES]
    if y is None:
        more = [[corner + len(NODES) for corner in corners] for corners in TRIANGLES]
        return nodes + [[1 + a, b, c] for a, b, c in NODES], triangles + more
    twins = {k: len(NODES) + i for i, k in enumerate(k for k, node in enumerate(NODES) if node[1] == y)}
    for corners in triangles:
        if max(NODES[k][1] for k in corners) > y:
            corners[:] = [twins.get(k, k) for k in corners]
    return nodes + [NODES[k] for k in twins], triangles


@pytest.fixture
def loaded(tmp_path):
    """Return a function that writes a scene and reads it as a run does."""

    def read(scene: Any, *sets: str) -> Any:
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(scene))
        return load(path, sets)

    return read


def test_the_wing_and_the_body_of_these_tests_are_sound(loaded):
    assert Facts(loaded(wing(veins=["left"]))).warnings == []
    cylinder = {"circular_cylinder": {"radius": 0.3, "axis": "z"}}
    quarter, spin = {"axis": [0, 1, 0], "angle": np.pi / 2}, {"axis": [0, 0, -1], "angle": {"constant": 0.1}}
    for keys in ({}, {"turn": quarter}, {"motion": spin}, {"turn": {"axis": [0, 0, 2], "angle": 0.5}}):
        loaded(body(cylinder, **keys))


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (wing(chains={"root": []}), r"chains\[0\]\.nodes` must be a list of at least 1"),
        (wing(chains={"root": [0, 1, 2, 1]}), r"chains\[0\]\.nodes\[3\]` is 1, but the list has it already"),
        (wing(chains={"tip": [14, 15]}), r"chains\[4\]\.nodes\[1\]` is 15, but the mesh has nodes 0 to 14"),
        (wing(root="point"), "`wing.root` is .* holds no edge of a triangle, which clamped needs"),
        (wing(root="corners"), "`wing.root` is .* holds no edge of a triangle"),
        (wing(root="point", support={"hinge": {"stiffness": 1.0}}), "which a hinge needs"),
        (wing(chains={"root": range(15)}), "`wing.root` is .* holds all nodes"),
        (wing(chains={"rev": [12, 9, 6, 3, 0]}, veins=["rev"]), r"`wing\.veins\[0\]\.chain` is .* ends at the root"),
        (wing(chains={"v": [0, 3, 9, 6]}, veins=["v"]), "folds back at its node 9"),
        (wing(chains={"v": [0, 3, 7]}, veins=["v"]), "turns at its node 3, .* straight at rest"),
        (twisted([0, 3, 7, 3]), r"chains\[4\]\.nodes\[3\]` is 3, but the list has it already"),
        (twisted([0, 3, 7, 15]), r"chains\[4\]\.nodes\[3\]` is 15, but the mesh has nodes 0 to 14"),
        (twisted([0, 3, 10]), r"`wing\.veins\[0\]\.chain` is \"v\", .*its node 3, .* and node 10 share no edge"),
        (twisted([1, 4, 3, 6]), r"`wing\.veins\[1\]\.chain` .*its node 3, .* and node 6 lie on another vein"),
        (twisted([0, 3, 9, 6]), "folds back at its node 9"),
        (twisted([1, 4, 8, 12, 15], nodes=[*NODES, NODES[12]]), "its node 12, .* and the next lie in one place"),
        (twisted([1, 4, 8], vein={"bending_stiffness": 0.0}), r"veins\[0\]\.bending_stiffness` is 0.*above 0"),
        (wing(veins=["point"]), "the chain has one node, and a vein at least two"),
        (wing(veins=["left", "left"]), r"veins\[1\]\.chain` is .*another vein lies along this chain"),
        (wing(*cut()), "`wing.mesh` is of several parts, .*node 15, .* share .* the root; nodes 12 and 15 lie in one"),
        (wing(*cut(), root=None), "share no triangle and no vein with the rest"),
        (wing(regions=regions([[0, 0], [1, 0.5], [1, 0], [0, 0.5]])), r"polygon\[0\]` .*meets the side .* corner 2"),
        (wing(regions=regions(HALF, [[-1, -1], [2, -1], [2, 2], [-1, 2]])), r"regions\[0\]` .*later regions have all"),
        (wing(groups=[{"name": "g", "triangles": [i]} for i in (0, 1)]), r"groups\[1\]\.name` .*another group"),
        (wing(nodes=[[1e100 * x for x in node] for node in NODES]), r"nodes\[1\]` .*numbers from -1e30 to 1e30"),
        (wing(nodes=[[1e-100 * x for x in node] for node in NODES]), r"triangles\[0\]` .*of at least 1e-30 m"),
        *((wing(root_motion=turns(axis)), r"rotations\[0\]\.axis` .*1e-150") for axis in NO_AXES),
        *((body(CUBE, turn={"axis": axis, "angle": 0.1}), r"turn\.axis` .*1e-150") for axis in NO_AXES),
        (body({"circular_cylinder": {"radius": 0.3}}, turn={"axis": [1, 1, 0], "angle": 0.5}), "turn` .*`length`"),
        (
            body({"circular_cylinder": {"radius": 0.3}}, motion={"axis": [1, 0, 0], "angle": {"constant": 0.5}}),
            "motion.angle` .*`length`",
        ),
        (body({"triangulation": {"nodes": [[0, 0, 0], *NO_AXES, [0, 0, 1]], "triangles": [[0, 1, 3]]}}), "far apart"),
    ],
)  # fmt: skip
def test_what_no_wing_or_surface_can_be_is_refused_by_its_key(scene, said, loaded):
    with pytest.raises(SceneError, match=said):
        loaded(scene)


def test_two_chains_of_one_name_are_refused(loaded):
    scene = wing()
    scene["wing"]["mesh"]["triangles"]["chains"].append({"name": "root", "nodes": [12, 13]})
    with pytest.raises(SceneError, match=r"chains\[4\]\.name` is \"root\", but another chain has this name"):
        loaded(scene)


def test_a_vein_without_bending_stiffness_may_curve(loaded):
    scene = wing(chains={"v": [0, 3, 7]}, veins=["v"])
    scene["wing"]["veins"][0]["bending_stiffness"] = 0.0
    loaded(scene)


def test_a_vein_with_torsion_may_curve(loaded):
    loaded(twisted([1, 4, 8, 11, 14]))


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (
            wing(*cut(0.25), chains={"root": [0, 1, 15, 2]}),
            "5 nodes of the wing lie in the place of others, as 15 of 1",
        ),
        (wing(regions=regions(HALF, OTHER)), r"`wing.regions\[1\]` \(r1\) crosses the region r0: 4 triangles"),
    ],
)
def test_seams_and_crossing_regions_are_warned_of(scene, said, loaded):
    with pytest.raises(AssertionError, match=said):
        assert Facts(loaded(scene)).warnings == []


OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in NODES)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 15\nproperty double x\nproperty double y\nproperty double z\n"
    "element face 16\nproperty list uchar int vertex_indices\nend_header\n"
)
VTK = "# vtk DataFile Version 3.0\nwing\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 15 double\n"


def written(suffix: str, triangles: Any) -> str:
    """Return the text of a file of triangles."""
    if suffix == "obj":
        return OBJ + "".join(f"f {a} {b} {c}\n" for a, b, c in np.array(triangles) + 1)
    places = "".join(f"{x} {y} {z}\n" for x, y, z in NODES)
    cells = "".join(f"3 {a} {b} {c}\n" for a, b, c in triangles)
    if suffix == "ply":
        return PLY + places + cells
    return f"{VTK}{places}CELLS 16 64\n{cells}CELL_TYPES 16\n" + "5\n" * 16


@pytest.mark.parametrize("suffix", ["obj", "ply", "vtk"])
@pytest.mark.parametrize("place", ["wing", "body"])
@pytest.mark.parametrize("node", [-15, -1, 15])
def test_a_file_that_names_nodes_that_it_lacks_is_refused(suffix, place, node, loaded, tmp_path):
    if (place, suffix) == ("body", "vtk"):
        return  # No format of surfaces
    scene = wing() if place == "wing" else body({"triangulation": {"file": f"it.{suffix}"}})
    if place == "wing":
        scene["wing"] |= {"mesh": {"file": f"it.{suffix}"}, "root": None}
    (tmp_path / f"it.{suffix}").write_text(written(suffix, TRIANGLES))
    loaded(scene)
    (tmp_path / f"it.{suffix}").write_text(written(suffix, [*TRIANGLES[:-1], [node, 0, 1]]))
    with pytest.raises(SceneError, match=rf"file` is 'it.{suffix}', but .*names the node {node}, .* has 15 nodes"):
        loaded(scene)


@pytest.mark.parametrize(("unit", "said"), [(True, "not true"), (0, "> 0"), (-1.0, "> 0"), ("mm", 'not "mm"')])
def test_a_unit_that_is_no_length_is_refused(unit, said, loaded, tmp_path):
    (tmp_path / "it.obj").write_text(written("obj", TRIANGLES))
    place = {"file": "it.obj", "unit": unit}
    for scene in (wing(mesh=place, root=None), body({"triangulation": place})):
        with pytest.raises(SceneError, match=rf"unit` .*{said}"):
            loaded(scene)


def test_a_file_is_read_in_its_unit_and_not_beside_nodes(loaded, tmp_path):
    (tmp_path / "it.obj").write_text(written("obj", TRIANGLES))
    scene = wing(mesh={"file": "it.obj", "unit": 1e-3}, root=None)
    nodes = np.array(loaded(scene).wing.mesh.triangles.nodes)
    assert np.ptp(nodes, axis=0) == pytest.approx([1e-3, 5e-4, 0.0])
    assert np.array(loaded(scene, "wing.mesh.unit=2").wing.mesh.triangles.nodes).max() == 2.0
    scene["wing"]["mesh"] = {"file": "it.obj"} | wing()["wing"]["mesh"]
    with pytest.raises(SceneError, match=r"unknown key `wing\.mesh\.triangles`: the keys here are `file` and `unit`"):
        loaded(scene)
    shape = {"triangulation": {"file": "it.obj", "nodes": NODES, "triangles": TRIANGLES}}
    with pytest.raises(SceneError, match=r"triangulation\.file` .*remove one of the two"):
        loaded(body(shape))


def test_a_mesh_that_is_too_large_for_a_scene_is_named_with_what_fits(loaded, tmp_path, monkeypatch):
    monkeypatch.setattr("nervure.scene.files.MOST_BYTES", 2000)
    (tmp_path / "it.obj").write_text(written("obj", TRIANGLES))
    scene = wing(mesh={"file": "it.obj"}, root=None)
    with pytest.raises(SceneError, match=r"nodes and triangles of `wing.mesh.file`, but at most .*a coarser mesh"):
        loaded(scene)
