"""The mesh of a wing from a file of another program."""

import json
import sys

import numpy as np
import pytest

from nervure.errors import InputError, SceneError
from nervure.resources import ROOT
from nervure.scene import load, read, with_files, write_copy
from nervure.scene.types import WingMeshFile
from nervure.simulation import sweep
from nervure.units.describe import describe
from tests.reliability.unit import WING

meshio = pytest.importorskip("meshio")

POINTS = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0.0]])
TRIANGLES = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
LINES = [[0, 3], [0, 1], [1, 2]]


@pytest.fixture
def scene(tmp_path):
    """Return a function that writes a scene whose mesh is a file, and returns its path."""

    def write(mesh: str, **keys: object):
        wing = {key: WING["wing"][key] for key in ("membrane",)} | {"mesh": {"file": mesh}} | keys
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(WING | {"wing": wing}, indent=2))
        return path

    return write


def write(path, lines=True, **keys):
    cells = [("triangle", TRIANGLES)] + [("line", LINES)] * lines
    meshio.Mesh(np.vstack([POINTS, [9, 9, 9.0]]) if lines else POINTS, cells, **keys).write(path)


@pytest.mark.parametrize("suffix", ["obj", "stl", "vtk", "vtu"])
def test_triangles_of_each_format_are_those_of_the_file(suffix, scene, tmp_path):
    write(tmp_path / f"wing.{suffix}", lines=False)
    mesh = load(scene(f"wing.{suffix}")).wing.mesh.triangles
    corners = np.array(mesh.nodes)[np.array(mesh.triangles)]
    assert np.allclose(np.sort(corners.sum(axis=1), axis=0), np.sort(POINTS[TRIANGLES].sum(axis=1), axis=0))
    assert len(mesh.nodes) == len(POINTS)


def test_physical_groups_of_gmsh_are_chains_in_the_order_of_their_lines_and_groups(scene, tmp_path):
    tags = [np.array([3, 4, 3, 3]), np.array([1, 2, 2])]
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    names = {"root": np.array([1, 1]), "costa": np.array([2, 1]), "film": np.array([3, 2]), "cell": np.array([4, 2])}
    meshio.Mesh(
        np.vstack([POINTS, [9, 9, 9.0]]), [("triangle", TRIANGLES), ("line", LINES)], cell_data=data, field_data=names
    ).write(tmp_path / "wing.msh", file_format="gmsh22", binary=False)
    vein = {"chain": "costa", "line_density": 0.1, "bending_stiffness": 1.0, "axial_stiffness": 10.0}
    mesh = load(scene("wing.msh", root="root", veins=[vein])).wing.mesh.triangles
    assert {chain.name: chain.nodes for chain in mesh.chains} == {"root": [0, 3], "costa": [0, 1, 2]}
    assert {group.name: group.triangles for group in mesh.groups} == {"film": [0, 2, 3], "cell": [1]}
    assert len(mesh.nodes) == 6  # Without the point of no cell


def test_a_file_is_named_on_the_command_line_and_no_unit_reads_it(scene, tmp_path):
    write(tmp_path / "wing.stl", lines=False)
    found = load(scene("none.stl"), ['wing.mesh={"file":"wing.stl"}']).wing.mesh.triangles
    assert len(found.nodes) == len(POINTS)
    with pytest.raises(SceneError, match=r"`wing.mesh.file` is \"wing.stl\".* only `nervure` reads files"):
        describe("wing", WING | {"wing": WING["wing"] | {"mesh": {"file": "wing.stl"}}})


def test_each_of_several_wings_has_its_file(tmp_path):
    """A wing in `wings` was refused for its file."""
    write(tmp_path / "wing.vtk", cell_data={"vein": [np.zeros(4, int), np.array([7, 8, 8])]})
    document = read(ROOT / "examples" / "hover-flyer.json")
    for own, unit in zip(document["wings"], (1e-3, 2e-3), strict=True):
        own["wing"] |= {"mesh": {"file": "wing.vtk", "unit": unit}, "root": "7"}
    (tmp_path / "scene.json").write_text(json.dumps(document))
    found = load(tmp_path / "scene.json")
    spans = [np.ptp(own.wing.mesh.triangles.nodes, axis=0) for own in found.wings]
    assert np.allclose(spans, [[0.002, 0.001, 0], [0.004, 0.002, 0]])
    with pytest.raises(SceneError, match=r"`wings\[1\].wing.mesh.file` is 'none.stl', but there is no such file"):
        found.copy({"wings.1.wing.mesh.file": "none.stl"})


def test_numbers_of_line_cells_name_chains(scene, tmp_path):
    write(tmp_path / "wing.vtk", cell_data={"vein": [np.zeros(4, int), np.array([7, 8, 8])]})
    mesh = load(scene("wing.vtk", root="7")).wing.mesh.triangles
    assert {chain.name: chain.nodes for chain in mesh.chains} == {"7": [0, 3], "8": [0, 1, 2]}


def test_files_that_make_no_wing_are_refused_by_key(scene, tmp_path, monkeypatch):
    with pytest.raises(SceneError, match=r"`wing.mesh.file` is .*none.obj.*no such file"):
        load(scene("none.obj"))
    (tmp_path / "bad.vtk").write_text("nothing")
    with pytest.raises(SceneError, match="meshio cannot read"):
        load(scene("bad.vtk"))
    meshio.Mesh(POINTS, [("quad", [[0, 1, 4, 3]])]).write(tmp_path / "quad.vtk")
    with pytest.raises(SceneError, match="cells quad, and a wing has triangles"):
        load(scene("quad.vtk"))
    meshio.Mesh(POINTS, [("line", LINES)]).write(tmp_path / "line.vtk")
    with pytest.raises(SceneError, match="no triangles"):
        load(scene("line.vtk"))
    write(tmp_path / "loop.vtk", cell_data={"vein": [np.zeros(4, int), np.array([7, 8, 7])]})
    with pytest.raises(SceneError, match="the lines of '7' must be one chain"):
        load(scene("loop.vtk"))
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(InputError, match="pip install meshio"):
        load(scene("loop.vtk"))


def test_faults_keep_the_line_of_the_scene_file(scene, tmp_path):
    write(tmp_path / "wing.stl", lines=False)
    path = scene("wing.stl", root="tip")
    line = next(i for i, text in enumerate(path.read_text().splitlines(), 1) if '"root"' in text)
    with pytest.raises(SceneError, match=f"line {line}, column"):
        load(path)


def test_a_copy_and_a_sweep_name_other_files_as_a_run_does(scene, tmp_path):
    write(tmp_path / "wing.stl", lines=False)
    meshio.Mesh(2 * POINTS, [("triangle", TRIANGLES)]).write(tmp_path / "large.stl")
    base = load(scene("wing.stl"))
    large = base.copy({"wing.mesh.file": "large.stl"})
    assert np.ptp(large.wing.mesh.triangles.nodes, axis=0).tolist() == [4, 2, 0]
    assert large.copy({"wing.mesh.file": "wing.stl"}) == base
    for given in (base, read(scene("wing.stl"))):
        cases = sweep.grid([given], [{"wing.mesh.file": ["wing.stl", "large.stl"]}])
        assert [case.scene for case in cases] == [base.document(), large.document()]
    base.wing.mesh = WingMeshFile(file=str(tmp_path / "large.stl"))
    assert with_files(base).wing.mesh == large.wing.mesh


def test_another_surface_keeps_the_unit_of_the_file(tmp_path):
    pytest.importorskip("trimesh")
    for name, size in (("small.stl", 1.0), ("large.stl", 2.0)):
        meshio.Mesh(size * POINTS, [("triangle", TRIANGLES)]).write(tmp_path / name)
    bodies = [{"shape": {"triangulation": {"file": "small.stl", "unit": 0.1}}, "position": [0, 0, 0]}]
    document = read("sphere-oscillating-64x64x64")
    document["fluid"] |= {"bodies": bodies}
    (tmp_path / "scene.json").write_text(json.dumps(document))
    found = load(tmp_path / "scene.json").copy({"fluid.bodies.0.shape.triangulation.file": "large.stl"})
    nodes = found.fluid.bodies[0].shape.triangulation.nodes
    assert np.allclose(np.ptp(nodes, axis=0), [0.4, 0.2, 0]), nodes


def test_a_new_scene_names_the_file_of_the_scene_that_it_copies(scene, tmp_path, monkeypatch):
    write(tmp_path / "wing.stl", lines=False)
    base = scene("wing.stl")
    (tmp_path / "else").mkdir()
    monkeypatch.chdir(tmp_path)
    for name in ("mine", "else/mine"):
        copied = write_copy(name, base)
        assert load(copied).wing == load(base).wing and "triangles" not in copied.read_text()
    assert '"../wing.stl"' in (tmp_path / "else" / "mine.json").read_text()
