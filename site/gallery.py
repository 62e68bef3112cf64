"""Run the scripts of the gallery, keep what each prints and costs, and tell it on the site.

    python site/gallery.py [NAME ...]

A document shows a script where it has the line `<!--script:NAME-->`: the site puts docstring, printed numbers, time and
the scene of the lab there.
"""

import ast
import hashlib
import json
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from nervure.resources import ROOT

SCRIPTS = ROOT / "scripts" / "gallery"
KEPT = Path(__file__).with_name("gallery.json")
MARK = re.compile(r"<!--script:(\w+)-->")
LAB = {"fsi3": "fsi3", "flag": "flag", "flapping_vein": "vein"}  # Scenes of the lab by script
PICTURES = {
    "flag": "tip.png",
    "flapping_vein": "stiffness.png",
    "other_master": "tip.png",
    "own_solver": "tip.png",
    "segments": "sweep.png",
    "sphere": "speed.png",
}
"""Pictures that go into docs/pictures."""


def cpu() -> float:
    """Return the processor time of the processes that have ended, s."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def run(name: str) -> dict[str, Any]:
    """Run a script; return what it printed and its processor time, s."""
    with tempfile.TemporaryDirectory() as folder:
        before = cpu()
        command = [sys.executable, str(SCRIPTS / f"{name}.py"), "--output", f"{folder}/out"]
        done = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True)
        spent = cpu() - before
        if picture := PICTURES.get(name):
            shutil.copy(Path(folder, "out", picture), ROOT / "docs" / "pictures" / f"gallery-{name}.png")
        printed = [line for line in done.stdout.replace(folder, "").splitlines() if "out" not in line]
    return {"printed": printed, "cpu_s": round(spent), "digest": digest(name)}


def digest(name: str) -> str:
    """Return the digest of a script."""
    return hashlib.sha256((SCRIPTS / f"{name}.py").read_bytes()).hexdigest()[:16]


def told(name: str, lab: str) -> str:
    """Return the Markdown of a script; `lab` is the address of the lab."""
    docstring = ast.get_docstring(ast.parse((SCRIPTS / f"{name}.py").read_text(encoding="utf-8"))) or ""
    paragraphs = [part for part in docstring.split("\n\n") if not part.startswith("    ")]
    kept = json.loads(KEPT.read_text(encoding="utf-8"))[name]
    said = "\n".join(kept["printed"])
    time = f"`scripts/gallery/{name}.py` took {kept['cpu_s']} s of processor time."
    link = f" [Try it in the lab]({lab}#{LAB[name]})." if name in LAB else ""
    return "\n\n".join([*paragraphs, f"```text\n{said}\n```", time + link])


def main() -> None:
    """Run the named scripts, or all."""
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    for name in sys.argv[1:] or sorted(path.stem for path in SCRIPTS.glob("*.py")):
        kept[name] = run(name)
        text = json.dumps(dict(sorted(kept.items())), indent=1, ensure_ascii=False) + "\n"
        KEPT.write_text(text, encoding="utf-8")
        print(name, f"{kept[name]['cpu_s']} s")


if __name__ == "__main__":
    main()
