"""`python -m tests.fuzz TARGET SECONDS FILE` writes the seeds of all targets, fuzzes one, and writes a row of CSV.

Inputs that a target found before stay in tests/fuzz/corpus. `make fuzz` runs all targets.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from nervure.files import write_csv
from nervure.resources import ROOT
from nervure.scene import read, text
from nervure.units.describe import unit_kinds
from tests.conftest import COUPLED
from tests.reliability.checks import unpack
from tests.reliability.trials import header
from tests.reliability.unit import SCENE, WING, FMU2Unit

FUZZ = ROOT / "tests" / "fuzz"
BUILD = ROOT / "target" / "fuzz"
COMMAND = ("cargo", "+nightly", "fuzz")
OPTIONS = ("-timeout=30", "-max_len=65536", f"-dict={BUILD / 'scene.dict'}", "-print_final_stats=1")


def write_seeds() -> None:
    """Scenes with a small grid and a short beam, states of the units, and a dictionary of the scene's words."""
    files: dict[Path, bytes] = {}
    for path in sorted((ROOT / "scenes").glob("*.json")):
        scene = read(path)
        if fluid := scene.get("fluid"):
            fluid["box"]["cells"] = [32, 16] if len(fluid["box"]["cells"]) == 2 else [16, 8, 8]
        for owner in (scene, *scene.get("rods", ())):
            if beam := owner.get("beam"):
                beam["segments"] = 6
        if wing := scene.get("wing"):
            (mesh,) = wing["mesh"].values()
            mesh["along"] = 4
        files |= {
            FUZZ / f"corpus/{kind}_scene/{path.stem}": text(scene).encode() for kind in unit_kinds(scene).values()
        }
    for kind in (*COUPLED, "wing"):
        own = text(WING if kind == "wing" else SCENE).encode()
        files[BUILD / kind / "scene.json"] = files[FUZZ / f"corpus/{kind}_scene/small"] = own
        with TemporaryDirectory() as folder:
            unit = FMU2Unit(kind, unpack(kind, Path(folder))).new()
            for step in range(4):
                state = unit.serialize()
                files[FUZZ / f"corpus/{kind}_state/steps-{step}"] = state[header(state) :]
                unit.step()
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    files[BUILD / "scene.dict"] = "".join(f'"\\"{word}\\""\n' for word in sorted(words(schema))).encode()
    for path, data in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


def words(schema: object) -> set[str]:
    """Keys and named values of a JSON schema."""
    if not isinstance(schema, dict):
        return set().union(*map(words, schema)) if isinstance(schema, list) else set()
    found = {*schema.get("properties", {}), *schema.get("enum", []), schema.get("const")}
    return {word for word in found if isinstance(word, str)}.union(*map(words, schema.values()))


def run(target: str, seconds: str) -> dict[str, Any]:
    """Fuzz a target with libFuzzer and return the row of its results; pass on the messages as they come."""
    command = [*COMMAND, "run", "--fuzz-dir", str(FUZZ), "--target-dir", str(BUILD), target, "--", *OPTIONS]
    said = ""
    with subprocess.Popen(
        [*command, f"-max_total_time={seconds}"], stderr=subprocess.PIPE, text=True, errors="replace"
    ) as process:
        assert process.stderr
        for line in process.stderr:
            sys.stderr.write(line)
            said += line
    found = re.search(r"^SUMMARY: (.*)", said, re.MULTILINE)
    done = re.search(r"^Done (\d+) runs in (\d+) second", said, re.MULTILINE)
    if process.returncode and not found:
        raise SystemExit(f"{target} did not run")
    inputs, spent = done.groups() if done else ("", "")
    return {"inputs": inputs, "seconds": spent, "found": found[1] if found else "nothing"}


if __name__ == "__main__":
    target, seconds, file = sys.argv[1:]
    write_seeds()
    if subprocess.run([*COMMAND, "--version"], capture_output=True, check=False).returncode:
        needed = "rustup toolchain install nightly --profile minimal; cargo install cargo-fuzz"
        print(
            f"the seeds are in tests/fuzz/corpus; fuzzing needs nightly Rust and cargo-fuzz: {needed}", file=sys.stderr
        )
        sys.exit(2)
    write_csv(Path(file), [run(target, seconds)])
