"""A run in a notebook, in a real kernel: a figure that follows it, and the run as a table with its last picture."""

import base64
import importlib.util
import io
import os

import numpy as np
import pytest
from PIL import Image

from nervure.resources import ROOT

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytestmark = [
    pytest.mark.usefixtures("libraries"),
    # Not imported: this process would count as a notebook.
    pytest.mark.skipif(importlib.util.find_spec("ipykernel") is None, reason="there is no kernel"),
]

FOLLOWED = """\
import nervure
from nervure.output import notebook

notebook.INTERVAL, notebook.SHARE = 0.0, float("inf")
show, times = notebook.Figures.show, []
notebook.Figures.show = lambda self: (times.append(self.session.time), show(self))
scene = nervure.load(r"{scene}").copy({changes})
run = nervure.run(scene, "run", live=True, quiet=True)
print(len(times), times[0], times[-1])
"""


def executed(folder, *cells):
    """Return the outputs of each cell, by MIME type, in a kernel of its own."""
    made = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    path = os.pathsep.join([str(ROOT / "python"), os.environ.get("PYTHONPATH", "")])
    client = nbclient.NotebookClient(made, timeout=120, resources={"metadata": {"path": str(folder)}})
    client.execute(env={**os.environ, "PYTHONPATH": path})
    return [[output.get("data", output) for output in cell.outputs] for cell in made.cells]


def picture(content):
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(content))).convert("RGB")).astype(int)


def coloured(pixels):
    """Part of a picture that is no grey."""
    return float((np.ptp(pixels, axis=-1) > 60).mean())


def test_a_cell_shows_the_flow_while_it_runs_and_the_run_afterwards(tmp_path):
    changes = {"time.end": 0.4, "time.communication_step": 0.05, "fluid.box.cells": [128, 24]}
    run = FOLLOWED.format(scene="cylinder-2d2-900x180", changes=changes)
    (followed, said), (shown,) = executed(tmp_path, run, "run")
    assert said["text"].split() == ["10", "0.0", "0.4"], "a figure at the start, after each step, and at the end"
    assert followed["text/plain"] == "t = 0.4 of 0.4 s"
    pixels = picture(followed["image/png"])
    assert pixels.shape[1] == 720 and coloured(pixels[: len(pixels) // 2]) > 0.02, "vorticity in its colours"
    assert coloured(pixels[-150:]) > 0.002, "curves below"
    assert "<td>lift</td><td>N/m</td>" in shown["text/html"] and "<img src=" in shown["text/html"]
    assert "Run of cylinder-2d2-900x180" in shown["text/plain"]


def test_a_rod_alone_has_its_curves(tmp_path):
    (followed, _), (shown,) = executed(tmp_path, FOLLOWED.format(scene="csm3", changes={"time.end": 0.02}), "run")
    assert picture(followed["image/png"]).shape[0] < 250 and 'alt="tip"' in shown["text/html"]


@pytest.mark.usefixtures("libraries")
def test_a_wing_is_seen(tmp_path):
    scene = FOLLOWED.format(scene=ROOT / "examples" / "wing-hanging.json", changes={"time.end": 0.02})
    (followed, _), (shown,) = executed(tmp_path, scene, "run")
    assert picture(followed["image/png"]).shape[0] > 400 and 'alt="wing"' in shown["text/html"]
