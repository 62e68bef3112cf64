"""What is said before a run, and the dimensionless results after it."""

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import nervure
from nervure.evaluate import bodies, flapping
from nervure.output import forecast
from nervure.resources import ROOT
from nervure.scene import override, read, validate
from nervure.scene.facts import Facts
from nervure.scene.solids import counts_of
from nervure.simulation import ranges
from nervure.simulation.loop import TimeGrid
from tests.conftest import FSI3, run_scene
from tests.rod.test_flapping import known_signal


def numbers(name, *overrides):
    return Facts(validate(read(name, overrides))).numbers


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        # Turek & Hron 2006: Re 200, density ratio 1, Ae = E/(rho Ubar²) = 1400; K = Ae (h/L)³ / (12 (1 - nu²))
        (
            "fsi3-650x144",
            {
                "reynolds": 200,
                "density_ratio": 1,
                "mass_ratio": 0.02 / 0.35,
                "stiffness": 1400 * (0.02 / 0.35) ** 3 / (12 * (1 - 0.4**2)),
                "added_mass_ratio": np.pi / 4 * 0.35 / 0.02,
            },
        ),
        ("cylinder-2d1-450x90", {"reynolds": 20, "density_ratio": None, "stiffness": None, "reduced_frequency": None}),
        # k = pi f c / U, as the description has it: Re 200
        ("vein-forward-288x144", {"reynolds": 200, "reduced_frequency": np.pi / 2.5, "density_ratio": 2}),
        # In still fluid the drive gives the velocity: k = L / (2 A)
        ("vein-hover-216x192", {"reynolds": 1.25 * 2 * np.pi / 0.08, "reduced_frequency": 1 / 2.5}),
        ("cylinder-oscillating-460x100", {"reynolds": 0.25 * 2 * np.pi * 0.25 * 0.1 / 1e-3}),
    ],
)
def test_dimensionless_numbers_are_those_of_the_definition(name, expected):
    found = vars(numbers(name))
    for key, value in expected.items():
        assert found[key] == (value if value is None else pytest.approx(value, rel=1e-12)), key


def test_cells_in_diameter_thickness_and_layer():
    found = numbers("fsi3-1300x288")
    dx = 2.6771 / 1300
    cylinder, beam = found.bodies["cylinder_1"], found.bodies["beam"]
    assert cylinder.thickness_cells == pytest.approx(0.1 / dx)
    assert beam.thickness_cells == pytest.approx(0.02 / dx)
    assert cylinder.layer_cells == pytest.approx(np.sqrt(1e-3 * 0.1 / (4 * 3.0)) / dx)  # u_max of the parabola is 3 m/s
    assert beam.layer_cells is None, "the beam is in the cylinder's wake"


@pytest.mark.parametrize(
    ("name", "body", "kind", "sides"),
    [
        # A wing of 2.5 mm on cells of 12.8/48 mm; its mean chord is area by span.
        ("examples/flyer-pid.json", "wing_2", "surface", {"mean chord": 0.844037e-3, "span": 2.478391e-3}),
        ("examples/plate-inclined.json", "body_1", "surface", {}),
        ("rod-hanging-160x160x48", "beam", "line", {"length": None}),
        ("flag-line-480x240", "beam", "line", {"thickness": None, "length": 1.0}),
    ],
)
def test_cells_along_what_the_fluid_meets_as_a_line_or_a_surface(name, body, kind, sides):
    facts = Facts(nervure.load(ROOT / name if "/" in name else name))
    cell = max(np.ptp(facts.scene.fluid.box.x) / facts.scene.fluid.box.cells[0],
               np.ptp(facts.scene.fluid.box.y) / facts.scene.fluid.box.cells[1])  # fmt: skip
    shown = dict(forecast.scene_rows(facts))[f"cells of {body}"]
    assert shown.endswith(f"; the fluid meets it as a {kind}") and ("no thickness" in shown) == (not sides), shown
    for side, length in sides.items():
        (count,) = (float(own.split()[0]) for own in shown.split(", ") if f"in the {side}" in own)
        assert length is None or count == pytest.approx(length / cell, rel=5e-3), shown


def test_a_scene_without_flow_or_fluid_has_no_such_numbers(fluid_only):
    assert Facts(validate(read("csm1"))).numbers is None
    fluid_only["fluid"] |= {"initial_velocity": [0.0, 0.0], "inflow": None}
    found = Facts(validate(fluid_only)).numbers
    assert (found.velocity, found.reynolds, found.cfl) == (None, None, None)
    assert list(ranges.warnings(Facts(validate(fluid_only)))) == []


@pytest.mark.parametrize(
    ("assignments", "said"),
    [
        ([], []),
        (
            ["fluid.box.cells=[325, 72]", "reference=null"],
            [
                "the front of cylinder_1 has 0.35 cells",
                "2.43 cells in the thickness of beam are few: a first look wants 2.5, forces within some per cent 5",
            ],
        ),
        (["fluid.box.cells=[1300, 500]", "reference=null"], ["cells are 1.74 times as long along x as along y"]),
        (["fluid.box.cells=[1292, 286]"], ["three times as long; 1287 and 1296 have none"]),
        (["fluid.kinematic_viscosity=5e-4"], ["Re is 400; forces were compared with published ones from 20 to 200"]),
        (["rod.material.plane_strain.density=1e7"], ["the rod weighs 1e+04 of the fluid it displaces"]),
        (["fluid.precision=single"], []),
        (
            ["fluid.precision=single", "rod.material.plane_strain.density=100", "coupling={}"],
            ["the rod weighs 0.1 of the fluid it displaces, which wants `precision` double"],
        ),
        (["fluid.mask.log_linear.c_eta=1e-3"], ["the mask is soft: C_eta U/L is 0.02"]),
        (["beam.segments=100"], ["segments are 0.17 thicknesses long"]),
    ],
)
def test_what_is_outside_of_the_tried_ranges_is_warned_of(assignments, said):
    warnings = list(ranges.warnings(Facts(validate(read("fsi3-1300x288", assignments)))))
    assert len(warnings) == len(said) and all(part in text for part, text in zip(said, warnings, strict=True)), warnings


def test_the_cells_of_a_fine_box_are_those_of_the_unit_and_are_warned_of():
    """Ends at halves of cells go up: from -2.25 m to point 12, from 2.25 m to point 21 of cells of 0.5 m from -8 m."""
    box = {"x": [-8.0, 8.0], "y": [-8.0, 8.0], "cells": [32, 32]}
    middle = {"x": [-7.0, 7.0], "y": [-5.5, 5.5], "ratio": 2}
    fine = {"x": [-2.25, 2.25], "y": [-2.25, 1.75], "ratio": 4}
    fluid = read("cylinder-stream-384x512")["fluid"] | {"box": box, "fine_box": fine, "middle_box": middle}
    fluid |= {"sponge": None, "initial_velocity": [0.0, 0.0], "mean_flow": {}}
    scene = validate(read("cylinder-stream-384x512") | {"fluid": fluid, "reference": None})
    assert scene.fluid and scene.fluid.fine_box
    assert counts_of(scene.fluid.fine_box, scene.fluid) == [36, 32]
    scene.fluid.fine_box.x = (-4.5, 4.0)
    warned = [text for text in ranges.warnings(Facts(scene)) if "prime factor" in text]
    assert len(warned) == 1 and warned[0].startswith("68 cells of the fine box along x"), warned
    assert "64 and 72 have none" in warned[0]


@pytest.mark.parametrize(
    ("cells", "reynolds", "warned"), [([96, 128], 100, True), ([144, 192], 100, False), ([96, 128], 40, False)]
)
def test_few_large_cells_across_what_sheds_vortices_are_warned_of(cells, reynolds, warned):
    fine = {"x": [-2.5, 3.5], "y": [-2.0, 2.0], "ratio": 4}
    scene = read("cylinder-stream-384x512")
    scene["fluid"] |= {"fine_box": fine, "kinematic_viscosity": 1 / reynolds}
    scene["fluid"]["box"]["cells"] = cells
    found = [text for text in ranges.warnings(Facts(validate(scene | {"reference": None}))) if "large cells" in text]
    assert bool(found) == warned and (not found or "has 4 large cells" in found[0])


def test_two_driven_wings_have_the_numbers_of_one():
    document = read("wing-hover-64x64x84")
    wing = document.pop("wing")
    one = Facts(validate(document | {"wing": wing})).numbers
    two = Facts(validate(document | {"wings": [{"name": name, "wing": wing} for name in ("a", "b")]})).numbers
    assert one.velocity > 0 and one.mass_ratio > 0
    for name in ("velocity", "reynolds", "reduced_frequency", "mass_ratio", "stiffness"):
        assert getattr(two, name) == pytest.approx(getattr(one, name), rel=1e-9), name


def test_fsi3_warns_of_nothing_as_its_table_shows_its_errors():
    for name in ("fsi3-325x72", "fsi3-324x54", "fsi3-650x144", "fsi3-1300x288"):
        warned = list(ranges.warnings(Facts(validate(read(name)))))
        assert warned == [], (name, warned)
    other = read("fsi3-325x72", ["fluid.kinematic_viscosity=1.1e-3"])
    assert len(list(ranges.warnings(Facts(validate(other))))) == 2


@pytest.mark.usefixtures("libraries")
def test_the_summary_has_each_warning_that_was_printed_once(fluid_only, tmp_path, capfd):
    fluid_only["fluid"]["box"]["cells"] = [68, 34]
    fluid_only["time"]["end"] = 2e-3
    run = nervure.run(validate(fluid_only), tmp_path)
    printed = [line.removeprefix("warning: ") for line in capfd.readouterr().err.splitlines()]
    assert run.summary.warnings == printed == list(dict.fromkeys(printed))
    assert sum("prime factor" in text for text in printed) == 2 and any("is soft" in text for text in printed)


@pytest.mark.parametrize(("name", "shape"), [("disk", {"radius": 0.5}), ("plate", {"length": 1.0, "width": 1.0})])
def test_a_body_without_thickness_has_no_few_cells_in_it(name, shape):
    """As the disk of the report `st-disk-broad`."""
    scene = read("plate-stream-96x72x72")
    scene["fluid"]["bodies"][0]["shape"] = {name: shape}
    warned = [text for text in ranges.warnings(Facts(validate(scene))) if "few" in text]
    assert warned == []


@pytest.mark.parametrize(
    ("assignments", "said"),
    [([], 0), (["beam.surface=mask"], 1), (["beam.surface=mask", "beam.thickness=0.15", "beam.segments=16"], 0)],
)
def test_a_line_is_proposed_for_a_beam_of_few_cells(assignments, said):
    """1.9 cells across as shipped, 4.8 where it is 0.15 thick."""
    warnings = list(ranges.warnings(Facts(validate(read("vein-hover-216x192", assignments)))))
    assert len(warnings) == said and all("`surface: line` is steadier" in text for text in warnings), warnings


PLATE = {"shape": {"plate": {"length": 1.0, "width": 2.0}}}


@pytest.mark.parametrize("kind", ["stream", "still"])
def test_coefficients_of_a_body_are_its_forces_by_those_of_the_flow(kind):
    """A beam of 1 m in a stream along y with 1.2 m/s, or driven at 0.4 π m/s in still fluid of 1 kg/m³."""
    known, window = known_signal()
    document = read("vein-hover-216x192")
    override(document, 'rod.root_motion.laws.y={"sine": {"amplitude": 0.1, "frequency": 2.0}}')
    if kind == "stream":
        override(document, "fluid.initial_velocity=[0, 1.2]")
        override(document, 'fluid.mean_flow={"y": {"constant": 1.2}}')
    scene = validate(document)
    facts = Facts(scene)
    velocity = 1.2 if kind == "stream" else 0.1 * 4 * np.pi
    assert facts.numbers.velocity == pytest.approx(velocity)
    found = bodies.evaluate(facts, known, window, 0.0)["beam"]
    pressure = velocity**2 / 2
    along, across = (-0.5, 0.25) if kind == "stream" else (-0.25, -0.5)
    assert found.cd_mean == pytest.approx(along / pressure, rel=1e-4)
    assert found.cl_mean == pytest.approx(across / pressure, rel=1e-4)
    assert found.cl_amplitude == pytest.approx(1.0 / pressure, rel=1e-4)
    assert found.ct == pytest.approx((0.5 if kind == "stream" else 0.25) / pressure, rel=1e-4)
    assert found.cp == pytest.approx(3.0 / pressure / velocity, rel=1e-4)
    assert found.st == pytest.approx(2.0 / velocity, rel=1e-4)
    assert found.st_tip == pytest.approx(2.0 * 0.3 / velocity, rel=1e-4)
    if kind == "stream":
        assert found.ct / found.cp == pytest.approx(
            flapping.evaluate(facts, facts.scales["beam"], known, window).efficiency, rel=1e-9
        )


@pytest.mark.parametrize(
    ("body", "stream", "said"),
    [
        (
            {"motion": {"y": {"sine": {"amplitude": 0.02, "frequency": 8.0, "ramp": 0.2}}}},
            0.0,
            "Stokes layer of 0.3191",
        ),
        ({"motion": {"y": {"sine": {"amplitude": 0.02, "frequency": 0.5, "ramp": 0.2}}}}, 0.0, None),
        (
            {"motion": {"y": {"table": {"times": [0, 0.2], "values": [0, 0.02], "end_slopes": [0, 0.2]}}}},
            0.0,
            "at once",
        ),
        ({"motion": {"y": {"sine": {"amplitude": 0.02, "frequency": 0.5}}}}, 0.0, "at once"),
        ({"turn": {"axis": [0, 0, -1], "angle": 0.5236}, **PLATE}, 4.0, "0.42426 cells, and its chord 12"),
        ({"turn": {"axis": [0, 0, -1], "angle": 0.5236}, **PLATE}, 1.0, None),
        (PLATE, 4.0, None),
    ],
)
def test_layers_that_the_grid_does_not_resolve_are_told(body, stream, said):
    """A sphere in still fluid of 0.01 m²/s on cells of 1/16 m, and a plate on cells of 1/12 m."""
    cells = 64 if stream == 0.0 else 48
    fluid = {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": {axis: [-2.0, 2.0] for axis in "xyz"} | {"cells": [cells] * 3},
        "initial_velocity": [stream, 0.0, 0.0],
        "mean_flow": {"x": {"constant": stream}},
        "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0.01, 0.01, 0.01], **body}],
        "mask": {"log_linear": {"c_eta": 1e-5}},
        "time_stepping": {"max_step": 0.002, "max_cfl": 0.4},
    }
    scene = {"name": "layers", "time": {"end": 0.4, "communication_step": 0.002}, "fluid": fluid}
    told = [text for text in Facts(validate(scene)).warnings if "layer" in text]
    assert len(told) == (said is not None) and all(said in text for text in told), told


def test_pace_counts_steps_after_the_first_and_those_of_the_fluid_to_come():
    """Steps of 30 ms, 20 of them in the fluid, which will have to divide each into 2: (30 + 20) ms for each of 100."""
    scene = read("vein-pitching-320x240")
    override(scene, "time.end=0.04")
    fluid: Any = SimpleNamespace(seconds=0.0)
    session: Any = SimpleNamespace(facts=Facts(validate(scene)), units={"fluid": fluid}, grid=TimeGrid(0.04, 4e-4))
    pace = forecast.Pace(session)
    assert pace.factor == 2 and pace.steps == 100
    wall, found = 0.0, []
    for done in range(12):
        pace.see(done, wall)
        found.append(pace.total)
        step = 5.0 if done < forecast.WARM_UP else 0.03
        wall, fluid.seconds = wall + step, fluid.seconds + step * 2 / 3
    assert found[: forecast.WARM_UP + 1] == [None] * (forecast.WARM_UP + 1)
    assert found[forecast.WARM_UP + 1 :] == pytest.approx([5.0] * (11 - forecast.WARM_UP))


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.16, "0.16 s"), (7.84, "7.8 s"), (119, "119 s"), (130, "2.2 min"), (7300, "2 h"), (3e6, "35 days")],
)
def test_durations_have_two_digits(seconds, text):
    assert forecast.duration(seconds) == text


def test_head_of_a_run_has_numbers_steps_and_warnings(libraries, tmp_path, monkeypatch):
    monkeypatch.setattr(forecast, "TIMED", 0.0)
    command = [FSI3, "--output", tmp_path, "--end-time", "0.004", "--set", "reference=null"]
    done = run_scene(*command)
    for part in (
        "Re 200",
        "mass ratio 0.0571",
        "12.1 in the diameter",
        "steps: 10 of",
        "load: momentum",
        "forecast: about",
    ):
        assert part in done.stdout, done.stdout
    assert "warning: 2.43 cells in the thickness of beam" in done.stderr, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["dimensionless"]["reynolds"] == pytest.approx(200)
    assert {"cd_mean", "cl_amplitude", "ct", "cp", "st"} <= summary["bodies"]["cylinder_1"].keys()
    quiet = run_scene(*command, "--quiet")
    assert (quiet.stdout, quiet.stderr) == ("", "")


def test_many_warnings_of_one_kind_are_one_with_their_number():
    scene = read("cylinder-2d1-450x90")
    radius, places = 1e-3, [(x / 10, y / 20) for x in range(3, 20) for y in range(1, 5)]
    scene["fluid"]["cylinders"] = [{"center": list(place), "radius": radius} for place in places]
    few = [text for text in ranges.warnings(Facts(validate(scene))) if "in the diameter" in text]
    assert len(few) == 1 and few[0].endswith(f"(and {len(places) - 1} more like it)"), few


def test_a_run_of_many_segments_says_first_that_it_takes_a_while():
    found = list(ranges.warnings(Facts(validate(read("csm1", ["beam.segments=60000"])))))
    assert any("60000 segments take about 20 s to pack and to load" in text for text in found), found
