"""Advice of the guards on soft scenes that are shipped, made coarser: a run that takes it is quiet."""

import re

import pytest

from nervure.scene import Scene, load
from nervure.simulation.session import Session

pytestmark = pytest.mark.usefixtures("libraries")

SHORT = 'coupling={"guards": {"window_steps": 100}}'
FLAG_H = [
    SHORT,
    *("fluid.box.cells=[160,80]", "beam.segments=16", "rod.material.section.line_density=0.075"),
    *("time.communication_step=0.005", "fluid.time_stepping.max_step=0.005"),
]
"""The flag of the report `flagH`, which shorter steps stopped earlier."""

VALUE = re.compile(r"`([a-z_.\[\]\d]+)` of (\[[^]]*\]|[\d.e-]+)")


def said(scene: Scene) -> str:
    """Return what a run of `scene` says of the powers, in a warning or as its error; empty where it is quiet."""
    with Session(scene) as session:
        status = session.run()
        warned = [text for text in session.warnings if "the exchanged power" in text]
        return " ".join([*warned, status.error or ""]).strip()


def taken(advice: str) -> list[str]:
    """Return the last advice in a text as changes of a scene."""
    found = VALUE.findall(advice.rpartition("take ")[2])
    return [f"{key.replace('[', '.').replace(']', '')}={value}" for key, value in found]


@pytest.mark.parametrize(
    ("name", "coarser", "end"),
    [
        ("flag-massless-240x120", FLAG_H, 0.51),
        ("flag-line-480x240", ["fluid.box.cells=[120,60]", SHORT], 0.41),
        ("filament-line-192x192", ["fluid.box.cells=[64,64]"], 3.0),
        ("filament-swimming-144x48", ["fluid.box.cells=[72,24]"], 1.5),
        ("filament-trio-144x96", ["fluid.box.cells=[72,48]"], 7.5),
    ],
)
def test_a_run_that_takes_the_advice_is_quiet(name, coarser, end):
    warned = said(load(name, coarser, end_time=end))
    changes = taken(warned)
    assert changes, warned
    after = said(load(name, [*coarser, *changes], end_time=end))
    assert not after, (warned, changes, after)
