"""A solver of one's own in the place of the rod: an Euler-Bernoulli beam in Python, in FSI3.

    pip install pythonfmu
    python scripts/gallery/own_solver.py

`examples/modal_beam.py` is the solver, `examples/pack.py` makes an FMU of it. Over the first 0.3 s, while the stream
begins, the tips differ by less than a hundredth of their way.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import nervure

EXAMPLES = Path(__file__).parents[2] / "examples"
sys.path.insert(0, str(EXAMPLES))
from pack import pack  # noqa: E402

parser = argparse.ArgumentParser(description="Run FSI3 with a rod of one's own beside ours.")
parser.add_argument("--end", type=float, default=0.3, help="end of the runs, s (0.3)")
parser.add_argument("--output", type=Path, default=Path("gallery-solver"), help="folder of the results")
given = parser.parse_args()

scene = nervure.load("fsi3-325x72")
scene.time.end = given.end
scene.reference = None  # of times that come later
ours = nervure.run(scene, given.output / "rod", quiet=True)
own_fmu = given.output / "modal-beam.fmu"
pack(EXAMPLES / "modal_beam.py", ours.folder / "scene.json", own_fmu)
own = nervure.run(scene, given.output / "modal-beam", rod_fmu=own_fmu, quiet=True)

apart = np.abs(own.series["tip_uy"] - ours.series["tip_uy"]).max() / np.abs(ours.series["tip_uy"]).max()
print(f"largest difference of the tip's way: {apart:.2%} of the way")
nervure.compare(ours, own, names=["tip_uy"]).savefig(given.output / "tip.png", dpi=150)
