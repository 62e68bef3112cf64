"""Scenes, files and arguments that nervure refuses, and its messages.

    python tests/scene/bad_input.py > messages.csv  # by `make messages`

Each entry of `TYPES` and `RELATIONS` is a shipped scene with a key replaced, as `--set` does it. The JSON Schema
refuses the first too, only the units the second.
"""

import csv
import io
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

from nervure.cli import main
from nervure.errors import SceneError
from nervure.resources import ROOT
from nervure.scene import load, read

FSI3, CSM1, CYLINDER, VEIN, HOVER = (
    "fsi3-325x72", "csm1", "cylinder-2d1-450x90", "vein-pitching-320x240", "vein-hover-216x192"
)  # fmt: skip
PAIR = "filament-pair-192x128"
BEAM = '{"root": {"at": {"position": [0, 0], "direction": [1, 0]}}, "length": 1, "thickness": 0.08, "segments": 8}'
BODY = 'fluid.bodies=[{"position": [1.5, 0.2]'
CIRCLE = '"shape": {"circle": {"radius": 0.02}}'
SINE, AT_ONE = '{"sine": {"amplitude": 0.1, "frequency": 1}}', '"mount": {"mass": 9, "y": {}, "release": 1}'
THESIS, VEIN_3D = "fsi3-thesis-325x72", "vein-3d"
LAW, LOAD = "fluid.inflow.mean_velocity", "coupling.load"
PROBE = '{{"name": "{}", "position": {}}}'

TYPES = [
    (FSI3, "format=1"),
    (FSI3, "format=3"),
    (FSI3, "format=two"),
    (FSI3, "format=2.0"),
    (FSI3, "name="),
    (FSI3, "name=a/b"),
    (FSI3, "name=.."),
    (FSI3, "name=-x"),
    (FSI3, f"name={'long-' * 21}"),
    (FSI3, "name=7"),
    (FSI3, "description=null"),
    (FSI3, "colour=red"),
    (FSI3, "time=null"),
    (FSI3, "time=[8, 4e-4]"),
    (FSI3, "time=8"),
    (FSI3, 'time={"end": 8}'),
    (FSI3, "time.end=0"),
    (FSI3, "time.end=-1"),
    (FSI3, "time.end=NaN"),
    (FSI3, "time.end=Infinity"),
    (FSI3, "time.end=1e999"),
    (FSI3, 'time.end="8"'),
    (FSI3, "time.end=true"),
    (FSI3, "time.begin=0"),
    (PAIR, "rods=2"),
    (PAIR, "rods.0.name=7"),
    (PAIR, "rods.0.name=left-hand"),
    (PAIR, "rods.0.rod=null"),
    (PAIR, "rods.0.colour=red"),
    (FSI3, "time.communication_step=0"),
    (FSI3, "fluid=3"),
    (FSI3, "fluid={}"),
    (FSI3, "fluid=[]"),
    (FSI3, "fluid.colour=1"),
    (FSI3, "fluid.density=0"),
    (FSI3, "fluid.density=-1000"),
    (FSI3, "fluid.density=heavy"),
    (FSI3, "fluid.density=null"),
    (FSI3, "fluid.kinematic_viscosity=0"),
    (FSI3, "fluid.box=3"),
    (FSI3, "fluid.box.x=0"),
    (FSI3, "fluid.box.x=[0, 1, 2]"),
    (FSI3, 'fluid.box.y=[0, "1"]'),
    (FSI3, "fluid.box.cells=[325]"),
    (FSI3, "fluid.box.cells=[325.0, 72]"),
    (FSI3, "fluid.box.cells.1=0"),
    (FSI3, "fluid.box.cells.0=-325"),
    (FSI3, "fluid.box.cells.0=1e9"),
    (FSI3, "fluid.initial_velocity=1"),
    (FSI3, "fluid.channel=[0, 0.41]"),
    (FSI3, "fluid.channel={}"),
    (FSI3, "fluid.inflow.profile=poiseuille"),
    (FSI3, "fluid.inflow.c_eta=0"),
    (FSI3, f"{LAW}=2"),
    (FSI3, f"{LAW}=fast"),
    (FSI3, f"{LAW}={{}}"),
    (FSI3, f'{LAW}={{"constant": [2]}}'),
    (FSI3, f'{LAW}={{"jump": 2}}'),
    (FSI3, f'{LAW}={{"constant": 2, "sine": {{}}}}'),
    (FSI3, f'{LAW}={{"cosine_ramp": {{"value": 2, "duration": 0}}}}'),
    (FSI3, f'{LAW}={{"sine": {{"amplitude": 1}}}}'),
    (FSI3, f'{LAW}={{"sine": {{"amplitude": 1, "frequency": -1}}}}'),
    (FSI3, f'{LAW}={{"table": {{"times": [0], "values": [0]}}}}'),
    (FSI3, "fluid.cylinders={}"),
    (FSI3, "fluid.cylinders=[7]"),
    (FSI3, "fluid.cylinders.0.radius=0"),
    (FSI3, "fluid.cylinders.0.center=[0.2]"),
    (FSI3, "fluid.cylinders.0.diameter=0.1"),
    (FSI3, f'{BODY}, "shape": {{"circle": {{"radius": -0.1}}}}}}]'),
    (FSI3, f'{BODY}, "shape": {{"square": {{"length": 0.1}}}}}}]'),
    (FSI3, "fluid.mask={}"),
    (FSI3, "fluid.mask=sharp"),
    (FSI3, 'fluid.mask={"sharp": {"c_eta": 1e-3}, "cosine": {"c_eta": 1e-3, "half_width": 1}}'),
    (FSI3, 'fluid.mask={"sharp": {}}'),
    (FSI3, 'fluid.mask={"sharp": {"c_eta": 0}}'),
    (FSI3, 'fluid.mask={"cosine": {"c_eta": 1e-3, "half_width": 0}}'),
    (FSI3, "fluid.mask.log_linear.c_eta=-1e-5"),
    (FSI3, "fluid.mask.log_linear.decay_length_cells=0"),
    (FSI3, "fluid.mask.log_linear.wall_correction=mirror"),
    (FSI3, "fluid.filter=sharp"),
    (FSI3, "fluid.filter=1"),
    (FSI3, "fluid.time_stepping.scheme=euler"),
    (FSI3, "fluid.time_stepping.max_step=0"),
    (FSI3, "fluid.time_stepping.max_cfl=0"),
    (FSI3, "fluid.time_stepping.max_cfl=0.5"),
    (FSI3, 'fluid.time_stepping={"max_step": 1e-4, "max_cfl": 1, "scheme": "rk2"}'),
    (FSI3, "fluid.threads=0"),
    (FSI3, "fluid.threads=2000"),
    (FSI3, "fluid.precision=half"),
    (CYLINDER, f"fluid.probes=[{PROBE.format('a.b', '[0, 0.2]')}]"),
    (CYLINDER, f"fluid.probes=[{PROBE.format('a', '0.2')}]"),
    (FSI3, "beam.length=0"),
    (FSI3, "beam.thickness=thin"),
    (FSI3, "beam.thickness=0"),
    (FSI3, 'beam.thickness={"taper": {"root": 0.02}}'),
    (FSI3, 'beam.thickness={"taper": {"root": 0.02, "tip": 0}}'),
    (FSI3, 'beam.thickness={"points": {"s": [0], "values": [0.02]}}'),
    (FSI3, "beam.segments=8.5"),
    (FSI3, "beam.segments=1"),
    (FSI3, "beam.segments=1000000000000"),
    (FSI3, "beam.root=cylinder"),
    (FSI3, "beam.root.on_cylinder.cylinder=-1"),
    (CSM1, "beam.root.at.position=[0.25]"),
    (CSM1, "rod=elastic"),
    (CSM1, 'rod.material={"steel": {}}'),
    (CSM1, "rod.root=hinged"),
    (CSM1, 'rod.root={"torsion_spring": {"stiffness": 0}}'),
    (CSM1, 'rod.root={"torsion_spring": {"stiffness": 1, "damping": -1}}'),
    (CSM1, "rod.material.plane_strain.density=0"),
    (CSM1, "rod.material.plane_strain.poisson_ratio=0.5"),
    (CSM1, "rod.material.plane_strain.shear_factor=2"),
    (CSM1, "rod.gravity=-2"),
    (CSM1, "rod.damping=-1"),
    (CSM1, "rod.scheme=newmark"),
    (CSM1, 'rod.scheme={"generalised_alpha": {"rho_inf": 2}}'),
    (CSM1, "rod.max_step=0"),
    (VEIN, "rod.root_motion=free"),
    (VEIN, 'rod.root_motion.laws.rotations=[{"axis": [0, 0, 1]}]'),
    (FSI3, f"{LOAD}=traction"),
    (FSI3, 'coupling.scheme={"iterated": {"max_iterations": 1}}'),
    (FSI3, 'coupling.guards={"window_steps": 0}'),
    (FSI3, "coupling.axial_pressure_strain=1"),
    (FSI3, "reference.source="),
    (FSI3, "reference.quantities.tip_uy.amplitude=-1"),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": "slave"}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": {{"z": {{}}}}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "mount": {{"mass": 0, "y": {{}}}}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "mount": {{"mass": 9, "y": {{"stiffness": -1}}}}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": {{}}, "mount": {{"mass": 9, "y": {{}}, "release": -1}}}}]'),
]
"""Values that types and ranges do not allow."""

RELATIONS = [
    (CSM1, 'display={"length": "mm", "time": "s"}'),
    (VEIN, "display.time=ms"),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": "master", "mount": {{"mass": 9, "y": {{}}}}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": {{}}, "mount": {{"mass": 9, "y": {{}}}}}}]'),
    (FSI3, f"{BODY}, {CIRCLE}, {AT_ONE}}}]"),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": {{"x": {SINE}}}, {AT_ONE}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "motion": {{"angle": {SINE}}}, {AT_ONE}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "mount": {{"mass": 9}}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "mount": {{"mass": 9, "angle": {{}}}}}}]'),
    (FSI3, f'{BODY}, {CIRCLE}, "mount": {{"mass": 9, "inertia": 1, "y": {{}}}}}}]'),
    (
        FSI3,
        f'{BODY}, "shape": {{"ellipse": {{"length": 0.1, "thickness": 0.05}}}}, "mount": {{"mass": 3, "y": {{}}}}}}]',
    ),
    (THESIS, f'{BODY}, {CIRCLE}, "mount": {{"mass": 9, "y": {{}}}}}}]'),
    (FSI3, f'{BODY}, "shape": {{"rectangle": {{"length": 0.1, "thickness": 0.2, "ends": "round"}}}}}}]'),
    (FSI3, f'{BODY}, "shape": {{"polygon": {{"corners": [[0, 0], [0.1, 0.1], [0.1, 0], [0, 0.1]]}}}}}}]'),
    (FSI3, 'fluid.bodies=[{"position": [5, 0.2], "shape": {"circle": {"radius": 0.1}}}]'),
    (FSI3, "fluid=null"),
    (FSI3, "rod=null"),
    (CSM1, "beam=null"),
    (FSI3, "fluid.box.x=[2.5, -0.1771]"),
    (FSI3, "fluid.box.cells=[32768, 32768]"),
    (FSI3, "fluid.channel=null"),
    (FSI3, "fluid.channel.y=[0.0, 4.1]"),
    (FSI3, "fluid.inflow.x=[-9, 0]"),
    (FSI3, f'{LAW}={{"table": {{"times": [1, 0], "values": [0, 1]}}}}'),
    (FSI3, f'{LAW}={{"table": {{"times": [0, 1], "values": [0, 1, 2]}}}}'),
    (FSI3, 'fluid.mean_flow={"x": {"constant": 0}}'),
    (HOVER, 'fluid.mean_flow={"x": {"constant": 1}}'),
    (HOVER, "fluid.gust=master"),
    (FSI3, "fluid.time_stepping.max_cfl=1e-9"),
    (FSI3, "fluid.time_stepping.max_step=1e-12"),
    (FSI3, "rod.max_step=1e-12"),
    (FSI3, "time.communication_step=1e-300"),
    (CYLINDER, f"fluid.probes=[{PROBE.format('a', '[0, 9]')}]"),
    (CYLINDER, f"fluid.probes=[{PROBE.format('a', '[0, 0]')}, {PROBE.format('a', '[0, 0.1]')}]"),
    (FSI3, "beam.root.on_cylinder.cylinder=5"),
    (FSI3, "beam.length=35"),
    (FSI3, "beam.rest_angles=[0, 0.1]"),
    (CSM1, "beam.root.at.direction=[0, 0]"),
    (CSM1, "beam.root.at.direction=[1, 0, 0]"),
    (CSM1, "rod.gravity=[0, -2, 0]"),
    (FSI3, 'beam.thickness={"points": {"s": [0, 0.5], "values": [0.02, 0.01]}}'),
    (FSI3, 'beam.thickness={"points": {"s": [0, 1], "values": [0.02, 0.01, 0.01]}}'),
    (THESIS, 'beam.thickness={"taper": {"root": 0.02, "tip": 0.01}}'),
    (THESIS, "rod.root=pinned"),
    (FSI3, 'rod.root={"free": {}}'),
    (FSI3, "rod.root=pinned"),
    (VEIN, 'rod.root={"free": {}}'),
    (VEIN, "rod.root=pinned"),
    (CSM1, 'rod.root={"free": {"force_z": {"constant": 1}}}'),
    (VEIN_3D, 'rod.root={"torsion_spring": {"stiffness": 1, "damping": 1}}'),
    (VEIN, "rod.root_motion.laws.rotations.0.axis=[0, 0, 0]"),
    (VEIN, "rod.root_motion.laws.rotations.0.axis=[1, 0, 0]"),
    (CSM1, 'coupling={"load": "momentum"}'),
    (FSI3, "rod.material.plane_strain.density=900"),
    (FSI3, 'coupling.scheme={"iterated": {}}'),
    (FSI3, 'coupling={"load": "pressure_jump", "axial_pressure_strain": true}'),
    (VEIN, 'coupling={"load": "momentum", "axial_pressure_strain": true}'),
    (FSI3, "reference.spread.quantities.lift.amplitude=[174, 146]"),
    (PAIR, "rods.1.name=Upper"),
    (PAIR, "rods.1.name=fluid"),
    (PAIR, 'rods.1.beam.root.at={"position": [0, 0.5], "direction": [0.9510565162951535, 0.3090169943749474]}'),
    (PAIR, "rods.1.beam.root.at.position=[0, 3]"),
    (PAIR, "rods.1.rod.gravity=[0, 0, 1]"),
    (PAIR, f"beam={BEAM}"),
    (PAIR, "this_rod=middle"),
    (FSI3, "this_rod=rod"),
    (PAIR, "fluid=null"),
]
"""Values that contradict the rest of the scene."""

FILES = {
    "empty": "",
    "a comma too few": '{\n  "name": "x"\n  "time": {}\n}',
    "a comment": '{\n  "name": "x", // mine\n}',
    "a list": "[]",
    "a key twice": '{\n  "name": "x",\n  "time": { "end": 1, "communication_step": 0.1, "end": 2 }\n}',
    "a thousand brackets": "[" * 1000,
    "a number that JSON lacks": '{\n  "name": "x",\n  "time": { "end": NaN, "communication_step": 0.1 }\n}',
    "the keys of format 1": '{\n  "format": 1,\n  "name": "x",\n  "time": { "end": 1, "communication_step": 0.1 },\n'
    '  "coupling": { "pressure_level": true }\n}',
    "several faults": '{\n  "nam": "x",\n  "time": {\n    "end": -1,\n    "communicaton_step": "0.1"\n  }\n}',
    "a number of 5000 digits": '{\n  "name": "x",\n  "time": { "end": 1'
    + "0" * 5000
    + ', "communication_step": 0.1 }\n}',
    "too long": f'{{"name": "{"x" * (4 << 20)}"}}',
    "a wrong value": '{\n  "name": "x",\n  "time": {\n    "end": -1,\n    "communication_step": 0.1\n  }\n}',
    "a missing key": '{\n  "name": "x",\n  "time": {\n    "end": 1\n  }\n}',
    "no text": b"\x89PNG\r\n",
}
"""Texts of a scene file."""

ARGUMENTS = [
    ["run"],
    ["run", "fsi3"],
    ["run", "nothing-like-it.json"],
    ["run", "."],
    ["run", FSI3, "--end-time", "0"],
    ["run", FSI3, "--end-time", "nan"],
    ["run", FSI3, "--end-time", "soon"],
    ["run", FSI3, "--set", "fluid.density"],
    ["run", FSI3, "--set", "fluid.nothing.here=1"],
    ["run", FSI3, "--set", "fluid.cylinders.5.radius=1"],
    ["run", FSI3, "--set", 'fluid.mask={"sharp": 1, "sharp": 2}'],
    ["run", FSI3, "--rod-fmu", "none.fmu"],
    ["run", PAIR, "--rod-fmu", "my.fmu"],
    ["run", PAIR, "--rod-fmu", "upper=none.fmu"],
    ["run", FSI3, "--checkpoint-every", "-1"],
    ["run", FSI3, "--fields-every", "-1"],
    ["run", FSI3, "--colour"],
    ["resume", "."],
    ["inspect", "none.fmu"],
    ["inspect", "none.fmu", "--set", "time.end=1"],
    ["inspect", "nothing-like-it.json"],
    ["plot", "."],
    ["merge", "one.fmu", "--output", "two.fmu"],
    ["sweep", FSI3, "--vary", "fluid.density"],
    ["fly"],
]
"""Arguments of the command."""


class Row(NamedTuple):
    """A bad input, and its message."""

    heading: str
    given: str
    status: str  # Exit status of the command
    faults: str  # Kind, key and place of each fault of a scene, `range time.end 4:5`
    message: str


def said(*arguments: str) -> tuple[int, str]:
    """Return exit status and message of the command, run in this process."""
    wide = {"TERMINAL_WIDTH": "1000", "COLUMNS": "1000", "NO_COLOR": "1"}
    errors, status = io.StringIO(), 0
    try:
        with (
            patch.dict(os.environ, wide),
            patch.object(sys, "argv", ["nervure", *arguments]),
            redirect_stdout(io.StringIO()),
            redirect_stderr(errors),
        ):
            main()
    except SystemExit as ended:
        status = int(ended.code or 0)
    return status, errors.getvalue().replace(f"{ROOT}{os.sep}", "")


def sentence(text: str) -> str:
    """Return a message without the frame and the usage that the command line puts around it."""
    lines = [line.strip("│ ").strip() for line in text.splitlines() if not set(line.strip()) <= set("╭╰─╮╯ Error")]
    lines = [line for line in lines if line and not line.startswith(("Usage:", "Try "))]
    return "\n".join(lines).removeprefix("error: ")


def scene(base: str, assignment: str) -> dict:
    """Return the document of an entry of `TYPES` and `RELATIONS`."""
    return read(base, [assignment])


def faults(name: str, *assignments: str) -> str:
    """Return kind, key and place of each fault of a scene."""
    try:
        load(name, assignments)
    except SceneError as error:
        places = (f" {fault.line}:{fault.column}" if fault.line else "" for fault in error.faults)
        return "; ".join(f"{fault.kind} {fault.key}{place}" for fault, place in zip(error.faults, places, strict=True))
    return ""


def rows() -> Iterator[Row]:
    """Give every bad input to the command."""

    def row(heading: str, given: str, found: str, *arguments: str) -> Row:
        status, text = said(*arguments)
        return Row(heading, given, str(status), found, sentence(text))

    for heading, cases in (("Types and ranges", TYPES), ("Contradictions", RELATIONS)):
        for base, assignment in cases:
            yield row(heading, assignment, faults(base, assignment), "run", base, "--set", assignment)
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        path = Path("my-scene.json")
        for name, text in FILES.items():
            path.write_bytes(text if isinstance(text, bytes) else str(text).encode())
            yield row("Files", name, faults(str(path)), "run", str(path))
        path.unlink()
        for arguments in ARGUMENTS:
            yield row("Arguments", " ".join(arguments), "", *arguments)
        assert not os.listdir(), os.listdir()


if __name__ == "__main__":
    csv.writer(sys.stdout, lineterminator="\n").writerows([Row._fields, *rows()])
