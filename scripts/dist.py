"""Put the units of a scene into a folder that a master's user can take without Rust.

python scripts/dist.py scenes/fsi3-325x72.json dist      FMUs, SSP, SHA256SUMS and manifest.json; `make dist` builds first
"""

import hashlib
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import fmpy
import typer

from cosim import package, ssp
from cosim.scene import ROOT, SceneError, load

OLDEST_GLIBC = (2, 17)
"""The version that the libraries must run on: that of 2012."""


def glibc(library: Path) -> tuple[int, int]:
    """The oldest glibc that has every symbol which a library asks for."""
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    return max(((int(major), int(minor)) for major, minor in versions), default=(0, 0))


def revision() -> str:
    """The source's commit, with `-dirty` after it where files differ from it."""
    command = ["git", "describe", "--always", "--abbrev=40", "--dirty", "--exclude=*"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def describe(path: Path) -> dict:
    return {"size": path.stat().st_size, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def main(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE.json", help="Scene file: fluid, rod or both.")],
    folder: Annotated[Path, typer.Argument(help="Folder to write; one that exists is replaced as a whole.")],
) -> None:
    """Make a folder to hand out."""
    try:
        scene = load(scene_file)
        kinds = package.kinds(scene)
        needed = {kind: glibc(package.library(kind)) for kind in kinds}
        for kind, version in needed.items():
            if sys.platform == "linux" and version > OLDEST_GLIBC:
                raise SceneError(
                    f"the library of the {kind} needs glibc {'.'.join(map(str, version))}, but "
                    f"{'.'.join(map(str, OLDEST_GLIBC))} is to suffice; `make dist` builds it so"
                )
        unfinished = folder.with_name(folder.name + ".unfinished")
        shutil.rmtree(unfinished, ignore_errors=True)
        files = [package.pack(kind, scene, unfinished) for kind in kinds]
        if len(kinds) > 1:
            files.append(ssp.pack(scene, unfinished))
        manifest = {
            "source_revision": revision(),
            "scene": scene["name"],
            "platform": fmpy.platform,
            "glibc": ".".join(map(str, max(needed.values()))),
            "files": {path.name: describe(path) for path in files},
        }
        (unfinished / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
        listed = [*files, unfinished / "manifest.json"]
        sums = "".join(f"{describe(path)['sha256']}  {path.name}\n" for path in listed)
        (unfinished / "SHA256SUMS").write_text(sums, encoding="utf-8")
        shutil.rmtree(folder, ignore_errors=True)
        unfinished.rename(folder)
        typer.echo(folder)
    except SceneError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error


if __name__ == "__main__":
    typer.run(main)
