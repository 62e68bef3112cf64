"""Every command of the tutorials works as written, with the scenes of the tutorials."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import nervure
from nervure.resources import ROOT
from nervure.scene import validate
from tests.conftest import nervure as nervure_here

pytestmark = pytest.mark.pictures

GUIDE = ROOT / "docs" / "guide"
INSTALL = "make fsi3\nsource .venv/bin/activate\n"


def follow(page, folder, end=None):
    """Run every command of a page in an empty folder, those of `nervure` in this process, and return the JSON of the
    page; scenes end at `end` (s), or where the page lets them."""
    environment = os.environ | {"PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])}
    text = (GUIDE / page).read_text(encoding="utf-8")
    documents = [json.loads(block) for block in re.findall(r"```json\n(.*?)```", text, re.DOTALL)]
    for scene in (document for document in documents if "name" in document):
        scene["time"]["end"] = end or scene["time"]["end"]
        (folder / f"{scene['name']}.json").write_text(json.dumps(scene), encoding="utf-8")
    blocks = [block for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) if block != INSTALL]
    for command in "".join(blocks).replace("\\\n", " ").splitlines():
        short = re.sub("--end-time [0-9.]+", f"--end-time {end}", command) if end else command
        short = re.sub("--fields-every 0.02", "--fields-every 0.1", short)  # fewer pictures of a film
        if end and re.match(r"nervure run \S+/", command):  # A scene that the page does not hold
            short += f" --end-time {end}"
        program, *arguments = shlex.split(short)
        if program == "nervure":
            done = nervure_here(*arguments, cwd=folder)
        else:
            done = subprocess.run(["bash", "-c", short], cwd=folder, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        told = [line for line in done.stderr.splitlines() if "warning:" in line and "needs the package" not in line]
        known = re.findall(r"warned of: `([^`]+)`", text)
        known += ["starts at once"] if end else []  # a large part of a short run
        warned = [line for line in told if not any(words in line for words in known)]
        assert not warned, f"{command}\n{warned}"
    for path in re.findall(r"`(my-[a-z-]+/\S+?)`", text):
        assert (folder / path).is_file(), path
    return documents


def test_every_command_runs_as_written(tmp_path, libraries):
    assert INSTALL in (GUIDE / "tutorial.md").read_text(encoding="utf-8")
    follow("tutorial.md", tmp_path, end=2.1)
    found = nervure.read(tmp_path / "my-vein").summary.flapping
    assert found.thrust > 0 and 0 < found.efficiency < 1 and found.phase_lag_deg > 0, found
    header, *rows = (tmp_path / "my-sweep" / "sweep.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 3 and {"thrust", "efficiency"} <= set(header.split(","))


def test_every_command_in_space_runs_as_written(tmp_path, libraries):
    """Over a short time; the parts of a wing replace those of the scene with one."""
    documents = follow("space.md", tmp_path, end=0.05)
    (fin,) = (document for document in documents if "wing" in document)
    parts = [document for document in documents if "name" not in document]
    assert len(parts) == 2 and all(validate(fin | {"wing": fin["wing"] | part}) for part in parts)


def test_every_scene_of_the_page_of_shapes_runs(tmp_path, libraries):
    for scene in ("plate-inclined", "body-from-stl", "wing-own"):
        assert f"examples/{scene}.json" in (GUIDE / "shapes.md").read_text(encoding="utf-8")
    follow("shapes.md", tmp_path, end=0.02)


@pytest.mark.parametrize("union", ["Shape", "WingMesh"])
def test_the_page_of_shapes_has_every_key_of_the_schema(union):
    """Each in the row of its shape."""
    rows = re.findall(r"^- (.*(?:\n  .*)*)", (GUIDE / "shapes.md").read_text(encoding="utf-8"), re.MULTILINE)
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))["$defs"][union]
    for choice in schema["oneOf"]:
        (shape, content), *beside = choice["properties"].items()
        said = " ".join(row for row in rows if f"`{shape}`" in row.partition(":")[0])
        keys = [*content.get("properties", {}), *(key for key, _ in beside)]
        missing = [key for key in keys if f"`{key}`" not in said]
        assert said and not missing, f"{shape}: {missing}"


def test_the_environment_of_make_has_the_extras_of_the_tutorial():
    """Fields need h5py, sweeps distributed."""
    locked = (ROOT / "requirements" / "run.lock").read_text(encoding="utf-8")
    assert re.search("^h5py==", locked, re.MULTILINE) and re.search("^distributed==", locked, re.MULTILINE)


PAGES = [
    Path("README.md"),
    Path("CONTRIBUTING.md"),
    *sorted(path.relative_to(ROOT) for path in (ROOT / "docs").rglob("*.md")),
]


def typed_lines():
    """Yield document and line of every command that a reader may type."""
    for name in PAGES:
        text = (ROOT / name).read_text(encoding="utf-8")
        for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL):
            yield from ((str(name), line) for line in block.replace("\\\n", " ").splitlines())


@pytest.mark.parametrize(("document", "line"), list(typed_lines()))
def test_a_line_means_the_same_to_bash_and_zsh(document, line, tmp_path):
    """A comment behind a command does not: an interactive zsh passes it on as arguments."""
    assert "#" not in line, f"{document}: {line}"
    shells = [shell for shell in ("bash", "zsh") if shutil.which(shell)]
    asked = [subprocess.run([shell, "-c", f"printf '<%s>\\n' {line}"], cwd=tmp_path, capture_output=True, text=True)
             for shell in shells]  # fmt: skip
    assert len({(done.returncode, done.stdout) for done in asked}) == 1 and asked[0].returncode == 0, asked


@pytest.mark.parametrize("document", ["README.md", "docs/guide/python.md"])
def test_the_python_of_a_document_has_right_types(document, tmp_path):
    """Every attribute exists, and no value that may be None is used as if it were there."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(encoding="utf-8"), re.DOTALL)
    code = "\n".join(blocks)
    assert "nervure.run(" in code
    (tmp_path / "document.py").write_text(code, encoding="utf-8")
    options = ["--config-file", "pyproject.toml", tmp_path / "document.py"]
    done = subprocess.run([sys.executable, "-m", "mypy", *options], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
