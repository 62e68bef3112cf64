"""The lab in a browser beside the units: times of a step, first frame, frames a second, and FSI3 to its end.

`make lab` builds the page, and Chromium opens it.
"""

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from nervure.errors import InputError
from nervure.evaluate import statistics
from nervure.resources import ROOT
from studies import simulate
from studies.engine import COUPLED, Case, Run, Study
from tests.lab.browser import CHROMIUM, PAGE, Browser, opened, rows, wait

SCENES: list[dict[str, Any]] = json.loads((ROOT / "lab" / "scenes.json").read_text(encoding="utf-8"))
ROUNDS, STEPS = 150, 4  # Measurements, of which the shortest counts, and steps in each
LOADS, LOOKS = 5, 5  # Times that the page is opened; seconds in which frames are counted
PRECISIONS = ("double", "single")
SOURCES = (*COUPLED, "lab")
PART = 1000  # Steps of FSI3 between two answers of the page
COLUMNS = ("time", "drag", "lift", "tip_ux", "tip_uy")
FIRST = """{ const draw = CanvasRenderingContext2D.prototype.drawImage;
    CanvasRenderingContext2D.prototype.drawImage = function (...a) {
      globalThis.first ??= performance.now(); return draw.apply(this, a); }; }"""
STEP = f"""lab.ask("frame", {{ steps: {STEPS}, budget: Infinity }})
    .then(({{ made, seconds, bitmap }}) => {{ bitmap?.close(); return (1000 * seconds) / made; }})"""


def browser() -> Browser:
    if CHROMIUM is None or not PAGE.is_file():
        raise InputError("the lab is measured in Chromium, from the page that `make lab` builds")
    return Browser()


def native(scene: dict[str, Any], folder: Path) -> float:
    """Return the shortest mean wall time of a step of the units, ms."""
    spent = []
    with simulate.session(scene, folder) as session:
        session.start()
        for _ in range(ROUNDS):
            begin = time.perf_counter()
            for _ in range(STEPS):
                session.step()
            spent.append(1e3 * (time.perf_counter() - begin) / STEPS)
    return min(spent)


def speed(case: Case, folder: Path) -> dict[str, Any]:
    """Return the shortest times of a step, ms, and from opening the page to its first frame, s, and the most frames in
    a second while the scene runs: others share the machine."""
    found: dict[str, Any] = {}
    with browser() as page:
        page.call("Page.addScriptToEvaluateOnNewDocument", source=FIRST)
        first = []
        for _ in range(LOADS):
            opened(page, f"#{case.options['id']}")
            wait(page, "Boolean(globalThis.first)")
            first.append(1e-3 * page.run("first"))
        found["first_s"] = min(first)
        page.run("document.getElementById('run').click()")
        seen = []
        for _ in range(LOOKS):
            time.sleep(1)
            seen.append(page.run("lab.speed().fps"))
        found["frames"] = max(seen)
        for precision in PRECISIONS:
            scene = case.built()
            scene["fluid"]["precision"] = precision
            found[f"native_{precision}_ms"] = native(scene, folder)
            opened(page, f"#{case.options['id']}")
            page.run(f"lab.ask('load', {{ scene: {json.dumps(json.dumps(scene))} }})")
            found[f"page_{precision}_ms"] = min(page.run(STEP) for _ in range(ROUNDS))
    return found


def to_the_end(case: Case, folder: Path) -> dict[str, Any]:
    """Return uy over the last whole periods of a run by the page."""
    time_grid = case.built()["time"]
    steps = round(time_grid["end"] / time_grid["communication_step"])
    with browser() as page:
        opened(page, f"#{case.options['id']}")
        sampled = np.array([row for _ in range(steps // PART) for row in rows(page, PART)])
    clock, moved = sampled[:, 0], sampled[:, COLUMNS.index("tip_uy")]
    found = statistics.evaluate(clock, moved, statistics.find_window(clock, moved))
    return {f"tip_uy.{name}": value for name, value in vars(found).items()}


def cases() -> Iterator[Case]:
    for own in SCENES:
        changes, options = own.get("set", {}), {"id": own["id"]}
        cells = simulate.changed(own["scene"], changes)["fluid"]["box"]["cells"]
        about = {"title": own["title"], "grid": " x ".join(map(str, cells))}
        yield Case(f"speed/{own['id']}", SOURCES, own["scene"], changes, options, speed, about)
    yield Case("end/fsi3", SOURCES, "fsi3-325x72", options={"id": "fsi3"}, action=to_the_end, quick=False)


def extract(case: Case, run: Run) -> dict[str, Any]:
    return {"times" if case.action is speed else "values": run.found}


STUDY = Study("lab", cases, extract)
