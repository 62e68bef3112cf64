"""The machine and the revision of a measurement."""

import os
import platform
import subprocess
from dataclasses import asdict
from datetime import date
from functools import lru_cache
from importlib.metadata import version
from typing import Any

from nervure.provenance import cpu_model, git_revision


@lru_cache
def here() -> dict[str, Any]:
    """Return machine, versions, revision of the sources and date."""
    git, memory = git_revision(), os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "memory_gb": round(memory / 1e9, 1),
        "system": platform.system(),
        "python": platform.python_version(),
        "rustc": subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.strip(),
        "packages": {name: version(name) for name in ("fmpy", "numpy")},
        "git": asdict(git) if git else None,
        "date": date.today().isoformat(),
    }


def key(about: dict[str, Any]) -> str:
    """Return a short name of date and revision."""
    revision = about["git"]["revision"][:9] if about["git"] else "no git"
    return f"{about['date']}, {revision}" + (", changed" if about["git"] and about["git"]["dirty"] else "")
