"""The crate of docs/reference/own-fmu.md, packed by `cargo fmu package` for both versions of FMI, in fmpy."""

import re
import shutil
import subprocess
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from nervure.resources import ROOT

PAGE = (ROOT / "docs" / "reference" / "own-fmu.md").read_text(encoding="utf-8")
LINES = 60
"""The page promises to be short."""


def block(language: str) -> str:
    """The one block of code in a language on the page."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    return found


@pytest.fixture(scope="module")
def command():
    """`cargo fmu`, as a user who installed it has it."""
    build = ["cargo", "build", "--quiet", "--release", "--locked", "--package", "nervure-cargo-fmu"]
    subprocess.run(build, cwd=ROOT, check=True)
    return [ROOT / "target" / "release" / "cargo-fmu", "fmu"]


@pytest.fixture(scope="module")
def crate(tmp_path_factory):
    """The crate of the page, with the versions that are locked here."""
    folder = tmp_path_factory.mktemp("hinge")
    (folder / "src").mkdir()
    manifest = block("toml").replace("../nervure", str(ROOT))
    (folder / "Cargo.toml").write_text(manifest + "\n[workspace]\n", encoding="utf-8")
    (folder / "src" / "lib.rs").write_text(block("rust"), encoding="utf-8")
    (folder / "Cargo.lock").write_bytes((ROOT / "Cargo.lock").read_bytes())
    return folder


@pytest.fixture(scope="module", params=[2, 3], ids=["fmi2", "fmi3"])
def fmu(request, command, crate):
    output = crate / f"hinge{request.param}.fmu"
    options = ["package", "--fmi", str(request.param), "--output", output]
    # Compiled without optimization, the crates that it depends on take half the time.
    options += ["--offline", "--profile", "dev", "--target-dir", ROOT / "target" / "own-fmu"]
    answer = subprocess.run([*command, *options], cwd=crate, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.strip() == str(output)
    return output


def exact(t, inertia=1e-4, damping=1e-3, stiffness=1.0, moment=0.1):
    """Angle of the hinge under a moment that is held from t = 0 on."""
    a, rest = damping / (2 * inertia), -moment / stiffness
    w = np.sqrt(stiffness / inertia - a**2)
    return rest * (1 - np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t)))


def test_the_page_is_short():
    assert len(block("rust").splitlines()) < LINES


def test_fmpy_finds_no_fault(fmu):
    assert validate_fmu(str(fmu)) == []


def test_the_fmu_has_its_library_where_its_version_wants_it(fmu):
    version = fmpy.read_model_description(str(fmu)).fmiVersion
    folder = {"2.0": fmpy.platform, "3.0": fmpy.platform_tuple}[version]
    with zipfile.ZipFile(fmu) as archive:
        assert archive.namelist() == ["modelDescription.xml", f"binaries/{folder}/hinge{fmpy.sharedLibraryExtension}"]


def test_the_hinge_moves_as_the_exact_solution(fmu):
    errors = []
    for h in (2e-4, 1e-4):
        result = fmpy.simulate_fmu(
            str(fmu), stop_time=0.1, output_interval=h, start_values={"root.moment": 0.1}, output=["root.angle"]
        )
        errors.append(np.abs(result["root.angle"] - exact(result["time"])).max())
    assert errors[1] < 1e-3 * 0.1, errors
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05), "second order"


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (["pack"], ['unknown command "pack"', "Usage: cargo fmu package"]),
        (["package", "--fmi", "1"], ['--fmi is "1", but must be 2 or 3']),
        (["package", "--target", "riscv64gc-unknown-linux-gnu"], ["FMI defines no name", "riscv64gc"]),
        (["package", "--resources", "nowhere"], ["nowhere: No such file"]),
    ],
    ids=lambda value: value[-1] if isinstance(value, list) else "",
)
def test_what_cannot_be_packed_is_refused_with_the_reason(options, parts, command, crate):
    profile = ["--offline", "--profile", "dev", "--target-dir", ROOT / "target" / "own-fmu"]
    options = options + profile if options[0] == "package" else options
    answer = subprocess.run([*command, *options], cwd=crate, capture_output=True, text=True, check=False)
    assert answer.returncode == 1 and answer.stdout == ""
    assert all(part in answer.stderr for part in parts), answer.stderr


def test_resources_go_with_it(command, crate, tmp_path):
    """The hinge with its inertia from a file."""
    source, changes = block("rust"), {
        "type State = [f64; 2];": 'type State = [f64; 2];\n    const RESOURCES: &[&str] = &["inertia.txt"];',
        "load(_: &Resources)": "load(resources: &Resources)",
        "= (1e-4, 1e-3, 1.0);": '= (resources.text("inertia.txt")?.parse().unwrap(), 1e-3, 1.0);',
    }  # fmt: skip
    for before, after in changes.items():
        assert before in source
        source = source.replace(before, after)
    shutil.copytree(crate, tmp_path / "hinge")
    (tmp_path / "hinge" / "src" / "lib.rs").write_text(source, encoding="utf-8")
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "inertia.txt").write_text("4e-4", encoding="utf-8")
    options = ["package", "-p", "hinge", "--resources", tmp_path / "data", "--output", tmp_path / "hinge.fmu"]
    options += ["--offline", "--profile", "dev", "--target-dir", ROOT / "target" / "own-fmu"]
    subprocess.run([*command, *options], cwd=tmp_path / "hinge", check=True, capture_output=True)
    assert validate_fmu(str(tmp_path / "hinge.fmu")) == []
    with zipfile.ZipFile(tmp_path / "hinge.fmu") as archive:
        assert archive.read("resources/inertia.txt") == b"4e-4"
    found = fmpy.simulate_fmu(
        str(tmp_path / "hinge.fmu"),
        stop_time=0.1,
        output_interval=1e-4,
        start_values={"root.moment": 0.1},
        output=["root.angle"],
    )
    assert np.abs(found["root.angle"] - exact(found["time"], inertia=4e-4)).max() < 1e-3 * 0.1
