"""Build the page of the lab as one file, which needs no server.

    python lab/make_lab.py target/lab/index.html [--home ../index.html]

The solvers become WebAssembly by cargo, which needs the target wasm32-unknown-unknown. Modules stay modules: a map of
imports names them. `--home` is the address of the documentation, beside the page.
"""

import argparse
import base64
import gzip
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE = Path(__file__).with_name("page")
TARGET = "wasm32-unknown-unknown"
MODULES = ("colours", "draw", "plot", "scenes")


def has_target() -> bool:
    """Return whether the compiler has the target for browsers."""
    command = ["rustc", "--print", "target-libdir", "--target", TARGET]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    return found.returncode == 0 and Path(found.stdout.strip()).is_dir()


def solvers() -> bytes:
    """Build the crate for browsers and return the program."""
    folder = ROOT / "target" / "lab"
    flags = f"-C target-feature=+simd128 --remap-path-prefix={ROOT}=nervure"
    home = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo"))
    environment = {
        **os.environ,
        "RUSTFLAGS": f"{flags} --remap-path-prefix={home}=cargo",
        "CARGO_PROFILE_RELEASE_STRIP": "symbols",
        "CARGO_PROFILE_RELEASE_LTO": "thin",  # for the size
    }
    command = ["cargo", "build", "--quiet", "--release", "--locked", "-p", "nervure-lab", "--target", TARGET]
    subprocess.run([*command, "--target-dir", folder], cwd=ROOT, env=environment, check=True)
    return (folder / TARGET / "release" / "lab.wasm").read_bytes()


def changed(scene: Any, changes: dict[str, Any]) -> Any:
    """Return the JSON of a scene with `changes` of its keys, such as `fluid.box.cells`."""
    for path, value in changes.items():
        *keys, last = path.split(".")
        part = scene
        for key in keys:
            part = part[key]
        part[last] = value
    return scene


def scenes() -> list[dict[str, Any]]:
    """Return the scenes of the page, each with its JSON."""
    listed: list[dict[str, Any]] = json.loads((PAGE.parent / "scenes.json").read_text(encoding="utf-8"))
    for own in listed:
        text = (ROOT / "scenes" / f"{own['scene']}.json").read_text(encoding="utf-8")
        own["json"] = changed(json.loads(text), own.pop("set", {}))
    return listed


def page(program: bytes, home: str | None) -> str:
    """Return the whole page."""
    read = {path.name: path.read_text(encoding="utf-8") for path in PAGE.iterdir()}

    def inline(kind: str, content: str, name: str) -> str:
        content = content.replace("</script", r"<\/script")
        return f'<script type="{kind}" id="{name}">{content}</script>'

    def address(name: str) -> str:
        return "data:text/javascript;base64," + base64.b64encode(read[f"{name}.js"].encode()).decode()

    imports = {f"lab/{name}": address(name) for name in MODULES}
    parts = [
        inline("importmap", json.dumps({"imports": imports}), "imports"),
        inline("text/plain", base64.b64encode(gzip.compress(program, mtime=0)).decode(), "wasm"),
        inline("text/plain", read["worker.js"], "worker"),
        inline("application/json", json.dumps(scenes()), "scenes"),
        inline("module", read["main.js"], "main"),
    ]
    text = read["index.html"].replace('<link rel="stylesheet" href="style.css">', f"<style>{read['style.css']}</style>")
    link = f'<a id="home" href="{home}">' if home else None
    text = text.replace('<a id="home" href="#">', link) if link else re.sub(r"<nav.*?</nav>", "", text)
    return text.replace('<script type="module" src="main.js"></script>', "\n".join(parts))


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=Path)
    parser.add_argument("--home")
    wanted = parser.parse_args()
    if not has_target():
        sys.exit(f"the compiler has no target {TARGET}: run `rustup target add {TARGET}`")
    wanted.page.parent.mkdir(parents=True, exist_ok=True)
    wanted.page.write_text(page(solvers(), wanted.home), encoding="utf-8")


if __name__ == "__main__":
    main()
