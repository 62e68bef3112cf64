"""Stop a release whose tag, versions, changelog or project address do not fit: `check_release.py v1.2.3`."""

import sys
import tomllib
from pathlib import Path


def faults(tag: str) -> list[str]:
    """Return what has to change before the release."""
    cargo = tomllib.loads(Path("Cargo.toml").read_text(encoding="utf-8"))["workspace"]
    python = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]
    version = cargo["package"]["version"]
    crates = {name: crate["version"] for name, crate in cargo["dependencies"].items() if "path" in crate}
    versions = {"the tag": tag.removeprefix("v"), "pyproject.toml": python["version"], **crates}
    found = [f"{place} says {other}, Cargo.toml {version}" for place, other in versions.items() if other != version]
    if f"\n## {version} " not in Path("CHANGELOG.md").read_text(encoding="utf-8"):
        found.append(f"CHANGELOG.md has no section for {version}")
    if "example.org" in cargo["package"]["repository"]:
        found.append("`repository` in Cargo.toml is still the placeholder")
    return found


if __name__ == "__main__":
    sys.exit("\n".join(faults(sys.argv[1])) or None)
