"""Speed of the fluid: docs/fluid-speed.md."""

import re
from collections.abc import Iterator

from cosim.scene import ROOT

from ..store import Row


def rows() -> Iterator[Row]:
    """The phases of a step in docs/fluid-speed.md."""
    text = (ROOT / "docs" / "fluid-speed.md").read_text(encoding="utf-8")
    part = text.split("Where the time of a step goes", 1)[1].split("A step on one", 1)[0]
    for phase, micro in re.findall(r"^\| ([^|]+) \| (\d+) \|", part, re.M):
        yield Row(
            "phases of a fluid step",
            "FSI3, the bar swinging",
            "650 x 144",
            phase,
            float(micro),
            "µs",
            source="docs/fluid-speed.md",
            command="make bench-fluid",
        )
    for scene, grid, micro in re.findall(r"^\| ([\w-]+) \| (\d+x\d+) \| \d+ \| (\d+) \|", text, re.M):
        nx, ny = map(int, grid.split("x"))
        yield Row(
            "cost of a fluid step",
            scene,
            f"{nx} x {ny}",
            "step",
            float(micro),
            "µs",
            size=nx * ny,
            source="docs/fluid-speed.md",
            command="make bench-fluid",
        )
