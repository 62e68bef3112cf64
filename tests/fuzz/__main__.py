"""Write what the fuzz targets begin with, run them one after the other, and write docs/fuzz.csv of what they did.

python -m fuzz -max_total_time=60       options are libFuzzer's; what the targets found before stays in fuzz/corpus
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from nervure.files import write_csv
from nervure.library import KINDS
from nervure.resources import ROOT
from nervure.scene import kinds, read, text
from tests.reliability.__main__ import unpack
from tests.reliability.trials import header
from tests.reliability.unit import SCENE, FMU2Unit

FUZZ = ROOT / "tests" / "fuzz"
TARGETS = ("rod_state", "fluid_state", "rod_scene", "fluid_scene")
COMMAND = ("cargo", "+nightly", "fuzz")
OPTIONS = ("-timeout=30", "-max_len=65536", f"-dict={FUZZ / 'target' / 'scene.dict'}", "-print_final_stats=1")


def write_seeds() -> None:
    """Scenes with a small grid and a short beam, states of both units, and a dictionary of the scene's words."""
    files = {"target/flag/scene.json": text(SCENE).encode()}
    for path in sorted((ROOT / "scenes").glob("*.json")):
        scene = read(path)
        for part, key, value in (("fluid", "box", {"cells": [32, 16]}), ("beam", "segments", 6)):
            if scene.get(part):
                scene[part][key] = scene[part][key] | value if key == "box" else value
        files |= {f"corpus/{kind}_scene/{path.stem}": text(scene).encode() for kind in kinds(scene)}
    for kind in KINDS:
        files[f"corpus/{kind}_scene/flag"] = text(SCENE).encode()
        with TemporaryDirectory() as folder:
            unit = FMU2Unit(kind, unpack(kind, Path(folder))).new()
            for step in range(4):
                state = unit.serialize()
                files[f"corpus/{kind}_state/steps-{step}"] = state[header(state) :]
                unit.step()
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    files["target/scene.dict"] = "".join(f'"\\"{word}\\""\n' for word in sorted(words(schema))).encode()
    for name, data in files.items():
        (FUZZ / name).parent.mkdir(parents=True, exist_ok=True)
        (FUZZ / name).write_bytes(data)


def words(schema: object) -> set[str]:
    """Keys and named values of a JSON schema."""
    if not isinstance(schema, dict):
        return set().union(*map(words, schema)) if isinstance(schema, list) else set()
    found = {*schema.get("properties", {}), *schema.get("enum", []), schema.get("const")}
    return {word for word in found if isinstance(word, str)}.union(*map(words, schema.values()))


def run(target: str, options: list[str]) -> dict:
    """A row of the table; what libFuzzer says is shown as it comes."""
    command = [*COMMAND, "run", "--fuzz-dir", FUZZ, target, "--", *OPTIONS, *options]
    said = ""
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, errors="replace") as process:
        for line in process.stderr:
            sys.stderr.write(line)
            said += line
    found = re.search(r"^SUMMARY: (.*)", said, re.MULTILINE)
    done = re.search(r"^Done (\d+) runs in (\d+) second", said, re.MULTILINE)
    if process.returncode and not found:
        raise SystemExit(f"{target} did not run")
    inputs, seconds = done.groups() if done else ("", "")
    return {"target": target, "inputs": inputs, "seconds": seconds, "found": found[1] if found else "nothing"}


if __name__ == "__main__":
    write_seeds()
    if subprocess.run([*COMMAND, "--version"], capture_output=True, check=False).returncode:
        needed = "rustup toolchain install nightly --profile minimal; cargo install cargo-fuzz"
        sys.exit(f"The seeds are in fuzz/corpus. To run the targets, install nightly Rust and cargo-fuzz: {needed}")
    rows = [run(target, sys.argv[1:] or ["-max_total_time=300"]) for target in TARGETS]
    write_csv(ROOT / "docs" / "fuzz.csv", rows)
    sys.exit(any(row["found"] != "nothing" for row in rows))
