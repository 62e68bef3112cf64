"""Every command of the tutorial works as written, with the scene of the tutorial."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import nervure
from nervure.resources import ROOT

TUTORIAL = ROOT / "docs" / "guide" / "tutorial.md"


def test_every_command_runs_as_written(tmp_path, libraries):
    """In an empty folder, with the `nervure` of the environment that runs the tests."""
    environment = os.environ | {"PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])}
    text = TUTORIAL.read_text(encoding="utf-8")
    (scene,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    (tmp_path / "my-vein.json").write_text(scene, encoding="utf-8")
    install, *blocks = re.findall(r"```sh\n(.*?)```", text, re.DOTALL)
    assert install == "make fsi3\nsource .venv/bin/activate\n"
    for command in "".join(blocks).splitlines():
        done = subprocess.run(["bash", "-c", command], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    for path in re.findall(r"`(my-[a-z-]+/\S+?)`", text):
        assert (tmp_path / path).is_file(), path
    found = nervure.read(tmp_path / "my-vein").summary.flapping
    assert found.thrust > 0 and 0 < found.efficiency < 1 and found.phase_lag_deg > 0, found
    header, *rows = (tmp_path / "my-sweep" / "sweep.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 3 and {"thrust", "efficiency"} <= set(header.split(","))


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
    code = "\n".join(block for block in blocks if "rod.set(" not in block)  # An excerpt of scripts/fsi3.py
    assert "nervure.run(" in code
    (tmp_path / "document.py").write_text(code, encoding="utf-8")
    options = ["--config-file", "pyproject.toml", "--ignore-missing-imports", tmp_path / "document.py"]
    done = subprocess.run([sys.executable, "-m", "mypy", *options], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
