"""Several rods in one fluid, each a unit of its own."""

import copy
import json
import zipfile

import h5py
import numpy as np
import pytest
from lxml import etree

import nervure as api
from nervure import coupling
from nervure.errors import InputError
from nervure.scene import validate
from nervure.scene.types import Iterated
from nervure.units import ssp
from nervure.units.describe import unit_names
from studies import flapping
from studies.simulate import assignments
from tests.conftest import nervure, output, run_scene
from tests.coupling.test_master import ADDED_MASS, PUSH, STIFFNESS, Fake, Spring

pytestmark = pytest.mark.usefixtures("libraries")

LIGHT = {"load": "pressure_jump"}


def pair(scheme):
    """Positions of the stations of both rods, `[2, 2, n]`: rod, axis, station."""
    return np.array([[output(rod, axis) for axis in "xy"] for rod in scheme.rods])


def steps(scheme, scene, n):
    h = scene["time"]["communication_step"]
    for i in range(n):
        scheme.step(i * h, h)


@pytest.mark.parametrize(
    "given", [{}, LIGHT, {"scheme": "parallel_explicit"}], ids=["explicit", "iterated", "parallel"]
)
def test_equal_rods_stay_mirror_images(given, two_rods, start):
    """The scene is its own mirror image at y = 0, so the rods are, to rounding, until the flow becomes unstable."""
    two_rods["coupling"] = given
    scheme = start(two_rods)
    before = pair(scheme)
    steps(scheme, two_rods, 100)
    (upper, lower), mirror = pair(scheme), np.array([[1.0], [-1.0]])
    moved = np.abs(upper - before[0]).max()
    assert moved > 1e-2, f"they moved by {moved} m only"
    apart = np.abs(upper - mirror * lower).max()
    assert apart < 1e-9, f"{apart} m from the mirror image, having moved by {moved} m"
    # The flow too: its vorticity changes sign. Row j is the mirror image of row ny - j.
    vorticity = scheme.fluid.field("vorticity")
    image = -np.roll(vorticity[:, ::-1], 1, axis=1)
    assert np.abs(vorticity - image).max() < 1e-9 * np.abs(vorticity).max()


def test_order_of_the_rods_changes_nothing(two_rods, start):
    """Each rod meets its own beam: with the list turned around the same rods do the same."""
    two_rods["rods"][1]["beam"] |= {"length": 0.7, "segments": 10}
    turned = copy.deepcopy(two_rods)
    turned["rods"].reverse()
    schemes = [start(scene) for scene in (two_rods, turned)]
    for scheme, scene in zip(schemes, (two_rods, turned), strict=True):
        steps(scheme, scene, 50)
    first, second = (
        dict(zip(["upper", "lower"][::way], s.rods, strict=True)) for s, way in zip(schemes, (1, -1), strict=True)
    )
    for name, rod in first.items():
        assert output(rod, "y").size == {"upper": 17, "lower": 11}[name]
        np.testing.assert_allclose(output(second[name], "y"), output(rod, "y"), rtol=0, atol=1e-12)


class TwoAddedMasses(Fake):
    """A constant push on each of two masses, less the inertia of a fluid that moves with both."""

    def __init__(self):
        beams = [f"beam[{i}]." for i in (1, 2)]
        super().__init__(
            "fluid",
            [beam + name for beam in beams for name in ("x", "y", "vx", "vy")],
            [b + "pressure_jump" for b in beams],
        )
        self.state = {"v": np.zeros(2)}

    def advance(self, _t, h):
        v = np.array([self.input(f"beam[{i}].vy") for i in (1, 2)])
        loads = [PUSH, 2 * PUSH] - MASSES @ (v - self.state["v"]) / h
        self.outputs[:] = np.repeat(loads, 2)
        self.state = {"v": v}


MASSES = np.array([[ADDED_MASS, 0.4 * ADDED_MASS], [0.4 * ADDED_MASS, 0.7 * ADDED_MASS]])


def test_iteration_over_two_rods_gives_the_monolithic_solution():
    """The fluid's inertia couples the rods with each other: it is not enough to iterate each with the fluid."""
    rods, h = [Spring(), Spring()], 1e-2
    scheme = coupling.Iterated(rods, TwoAddedMasses(), Iterated(tolerance=1e-9, max_iterations=20))
    q, v = np.zeros(2), np.zeros(2)
    scheme.start()
    for i in range(50):
        scheme.step(i * h, h)
        whole = np.eye(2) * (1 + STIFFNESS * h * h) + MASSES
        v = np.linalg.solve(whole, v + MASSES @ v + h * (np.array([PUSH, 2 * PUSH]) - STIFFNESS * q))
        q = q + h * v
    found = [rod.state["q"] for rod in rods]
    assert found == pytest.approx(q.tolist(), rel=1e-6) and found[0] != pytest.approx(found[1], rel=0.1)


def test_drive_gives_each_rod_its_own_root():
    rods = [Spring(), Spring()]
    for rod in rods:
        rod.variables |= Fake("rod", ["root.y", "root.vy"], []).variables
    fluid = TwoAddedMasses()
    scheme = coupling.Explicit(rods, fluid)
    units = {"upper": rods[0], "lower": rods[1], "fluid": fluid}
    driver = coupling.Driver(units, lambda t, _: {"upper.root.y": t, "lower.root.y": -t})
    driver.move(0.0, 0.5, {})
    scheme.step(0.0, 0.5)
    assert [rod.input("root.y") for rod in rods] == [0.5, -0.5]


def test_fluid_for_more_rods_is_refused():
    with pytest.raises(coupling.CouplingError, match=r"the fluid has the input `beam\[1\].x`, but there is no rod"):
        coupling.Explicit([], TwoAddedMasses())
    with pytest.raises(coupling.CouplingError, match=r"the rod has the input .*, but the fluid has no such output"):
        coupling.Explicit([Spring()], TwoAddedMasses())
    fluid = TwoAddedMasses()
    del fluid.variables["beam[2].pressure_jump"]
    with pytest.raises(coupling.CouplingError, match=r"but the fluid has no output `beam\[2\].pressure_jump`"):
        coupling.Explicit([Spring(), Spring()], fluid)


@pytest.fixture
def scene_file(two_rods, tmp_path):
    """The pair with one rod heavier than the other, so that nothing of theirs is the same."""
    two_rods["time"]["end"] = 0.1
    two_rods["rods"][1]["rod"]["material"]["section"]["line_density"] = 0.5
    path = tmp_path / "two.json"
    path.write_text(json.dumps(two_rods))
    return path


@pytest.mark.pictures
def test_run_gives_columns_files_and_sums_of_each_rod(scene_file, tmp_path):
    done = run_scene(scene_file, "--output", tmp_path / "results", "--fields-every", "0.02")
    assert done.returncode == 0, done.stderr
    run = api.read(tmp_path / "results")
    assert {"upper_tip_uy", "lower_load_work", "beam_1_drag", "beam_2_work"} <= run.series.keys()
    assert run.summary.units.keys() == {"upper", "lower", "fluid"}
    assert [run.summary.units[name].model for name in ("upper", "fluid")] == ["two.upper", "two.fluid"]
    assert {"upper_tip_uy", "lower_tip_ux", "drag", "lift"} <= run.summary.quantities.keys()
    assert run.summary.bodies.keys() == {"beam_1", "beam_2"}
    for name, beam in (("upper", "beam_1"), ("lower", "beam_2")):
        work = run.summary.rods[name].interface
        took, gave = run.series[f"{name}_load_work"][-1], run.series[f"{beam}_work"][-1]
        assert (work.work_on_rod, work.work_by_fluid) == (pytest.approx(took, rel=1e-9), pytest.approx(gave, rel=1e-9))
        assert gave != 0
    np.testing.assert_allclose(run.series["drag"], run.series["beam_1_drag"] + run.series["beam_2_drag"], rtol=1e-8)
    for name, side in (("upper", 1), ("lower", -1)):
        with h5py.File(tmp_path / "results" / f"beam-{name}.vtkhdf") as file:
            points = file["VTKHDF/Points"][:]
            assert points.shape == (6 * 34, 3) and (np.sign(points[:, 1]) == side).all()
    assert {path.suffix for path in run.animate()} >= {".png", ".gif"}
    for name in ("two-upper.fmu", "two-lower.fmu", "two-fluid.fmu", "tip.png", "vorticity.png"):
        assert (tmp_path / "results" / name).is_file(), name
    looked_at = nervure("inspect", scene_file).stdout
    assert "upper, lower and fluid" in looked_at and "beam of lower" in looked_at, looked_at


def test_each_rod_can_be_replaced_by_its_name(scene_file, two_rods, packed, tmp_path):
    """A stiffer FMU in the place of the lower rod does what a scene with a stiffer lower rod does."""
    stiff = copy.deepcopy(two_rods)
    stiff["rods"][1]["rod"]["material"]["section"]["bending_stiffness"] *= 5
    other = tmp_path / "other.json"
    other.write_text(json.dumps(stiff))
    own, whole, plain = (tmp_path / name for name in ("own", "whole", "plain"))
    swapped = f"lower={packed('lower', stiff)}"
    for path, folder, more in ((scene_file, own, ("--rod-fmu", swapped)), (other, whole, ()), (scene_file, plain, ())):
        done = run_scene(path, "--output", folder, *more, "--quiet")
        assert done.returncode == 0, done.stderr
    assert (own / "series.csv").read_bytes() == (whole / "series.csv").read_bytes()
    assert (own / "series.csv").read_bytes() != (plain / "series.csv").read_bytes()
    run = api.run(validate(two_rods), tmp_path / "api", rod_fmu={"lower": packed("lower", stiff)}, quiet=True)
    assert run.series["lower_tip_uy"].tolist() == pytest.approx(api.read(own).series["lower_tip_uy"].tolist(), rel=1e-9)


def test_fmu_without_the_name_of_its_rod_is_refused(scene_file, two_rods, packed, tmp_path):
    fmu = packed("upper", two_rods)
    for given, said in (
        ([str(fmu)], "the scene has several rods: it must be of the form NAME=FMU"),
        ([f"middle={fmu}"], "the scene has the rods upper, lower"),
        ([f"upper={fmu}", f"upper={fmu}"], "two FMUs for the rod upper"),
        (["upper=none.fmu"], "the file none.fmu does not exist"),
    ):
        done = run_scene(scene_file, "--output", tmp_path / "out", *(w for each in given for w in ("--rod-fmu", each)))
        assert done.returncode == 2 and said in done.stderr, done.stderr
    with pytest.raises(InputError, match="must be a dict by their names"):
        api.run(validate(two_rods), tmp_path / "out", rod_fmu=fmu)
    assert not (tmp_path / "out").exists()


def test_both_versions_of_fmi_give_the_same(scene_file, tmp_path):
    for version in (2, 3):
        done = run_scene(scene_file, "--output", tmp_path / str(version), "--fmi", version, "--quiet")
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "2" / "series.csv").read_bytes() == (tmp_path / "3" / "series.csv").read_bytes()


def test_system_structure_connects_each_rod_with_its_beam(two_rods, packed):
    fmus = {kind: packed(kind, two_rods) for kind in unit_names(two_rods)}
    root = etree.fromstring(ssp.structure("two", fmus, 1.0))
    found = {tuple(link.get(f"{end}{what}") for end in ("start", "end") for what in ("Element", "Connector"))
             for link in root.iter(f"{{{ssp.SSD}}}Connection")}  # fmt: skip
    assert ("upper", "x[1]", "fluid", "beam[1].x[1]") in found and (
        "lower",
        "vy[17]",
        "fluid",
        "beam[2].vy[17]",
    ) in found
    assert ("fluid", "beam[2].impedance[3]", "lower", "impedance[3]") in found
    assert len(found) == 2 * 17 * (4 + 3)


def test_terminals_of_a_rod_fit_those_of_its_beam(two_rods, packed):
    """Under FMI 3.0 a terminal of the fluid has the members that the rod's has, by the rod's names for them."""
    members = {}
    for kind in ("upper", "fluid"):
        with zipfile.ZipFile(packed(kind, two_rods, 3)) as archive:
            root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        for terminal in root.iter("Terminal"):
            inside = [(m.get("memberName"), m.get("variableName")) for m in terminal]
            members[kind, terminal.get("name")] = dict(inside)
    assert members["fluid", "beam[2].stations"] == {name: f"beam[2].{name}" for name in ("x", "y", "vx", "vy")}
    assert members["upper", "stations"].keys() == members["fluid", "beam[1].stations"].keys()
    assert members["upper", "load"].keys() == members["fluid", "beam[1].load"].keys()


def test_fluid_says_which_beam_has_a_wrong_station(two_rods, instantiate):
    units = instantiate(two_rods)
    scheme = coupling.couple(units, None)
    scheme.start()
    scheme.links[1].stations[2] = np.nan
    scheme.give_stations()
    with pytest.raises(Exception, match=r"beam\[2\]\.x\[3\]|station 3 of beam 2"):
        units["fluid"].step(0.0, 2e-3)


@pytest.mark.parametrize(("apart", "together"), [(1.0, False), (0.2, True)])
def test_two_filaments_flap_together_when_close_and_against_each_other_when_not(apart, together, tmp_path):
    """As in Huang, Shin & Sung (2007), from the same start: only the distance decides."""
    scene = api.load(flapping.FILAMENTS, assignments(flapping.two_filaments(apart) | {"time.end": 26.0}))
    run = api.run(scene, tmp_path, quiet=True)
    late = run.series["time"] > 19.0
    assert min(np.ptp(run.series[f"{name}_tip_uy"][late]) for name in flapping.NAMES) > 0.5, "both flap"
    found = flapping.correlation(run.series, 19.0, 26.0)
    assert found > 0.8 if together else found < -0.95, f"correlation {found:.3f}"
