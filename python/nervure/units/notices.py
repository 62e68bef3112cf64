"""Third-party crates in the libraries of the units: names, versions and licences, with their texts."""

import json
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nervure.errors import SceneError
from nervure.resources import BINARIES, ROOT

TEXT = re.compile(r"(LICEN[CS]E|COPYING|NOTICE|UNLICENSE)", re.IGNORECASE)


def notices(kind: str) -> str:
    """Return the licences of all crates in the library of unit `kind`: from a file in the wheel, or from cargo."""
    if (packed := BINARIES / f"third-party-{kind}.txt").is_file():
        return packed.read_text(encoding="utf-8")
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    try:
        answer = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise SceneError(f"cargo cannot list the crates of the {kind}: {error}") from error
    found = [
        f"{crate['name']} {crate['version']}: {crate['license']}\n\n{_texts(Path(crate['manifest_path']).parent)}"
        for crate in sorted(_crates(json.loads(answer), f"nervure-fmu-{kind}"), key=lambda crate: str(crate["name"]))
        if crate["source"] is not None
    ]
    head = (
        f"The library of the {kind} contains the standard library of Rust (MIT OR Apache-2.0, The Rust Project "
        "Developers) and these crates:"
    )
    return f"\n\n{'=' * 80}\n\n".join([head, *found])


def _crates(metadata: dict[str, Any], name: str) -> Iterator[dict[str, Any]]:
    """Yield a crate and the crates that are linked into it, without build and test dependencies."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    packages = {package["id"]: package for package in metadata["packages"]}
    todo, done = [key for key, package in packages.items() if package["name"] == name], set()
    while todo:
        key = todo.pop()
        if key not in done:
            done.add(key)
            yield packages[key]
            dependencies = nodes[key]["deps"]
            todo += [d["pkg"] for d in dependencies if any(kind["kind"] is None for kind in d["dep_kinds"])]


def _texts(folder: Path) -> str:
    """Return the licence files of a crate, joined."""
    files = sorted(path for path in folder.iterdir() if path.is_file() and TEXT.match(path.name))
    return "\n\n".join(path.read_text(encoding="utf-8", errors="replace").strip() for path in files)
