"""Provenance of a result: the revision of the sources, the machine, and versions of packages."""

import os
import platform
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from nervure.resources import SOURCE


@dataclass(frozen=True)
class Revision:
    """A git revision."""

    revision: str
    dirty: bool  # Whether files other than documents have changed


@dataclass(frozen=True)
class Machine:
    """A computer."""

    cpu: str
    cores: int | None
    system: str


@cache
def git_revision() -> Revision | None:
    """Return the revision of the source tree when this process first asked, as that of the code it has loaded; None
    outside git, or where the package is installed from a wheel."""
    if SOURCE is None:
        return None

    def git(*arguments: str) -> str:
        return subprocess.check_output(["git", *arguments], cwd=SOURCE, stderr=subprocess.DEVNULL, text=True).strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no", "--", ":!docs", ":!README.md")
        return Revision(git("rev-parse", "HEAD"), bool(changed))
    except (OSError, subprocess.CalledProcessError):
        return None


def machine() -> Machine:
    """Return this computer."""
    return Machine(cpu_model(), os.cpu_count(), platform.platform())


def cpu_model() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages behind the numbers."""
    from importlib.metadata import version  # which takes longer to import than to ask

    return {"python": platform.python_version()} | {name: version(name) for name in ("nervure", "fmpy", "numpy")}
