"""Another master: a loop of fmpy runs the units, and finds the tip where nervure finds it.

    python scripts/gallery/other_master.py

`scripts/fsi3.py` is this master; it knows nothing of nervure.
"""

import argparse
import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import nervure

parser = argparse.ArgumentParser(description="Run FSI3 with fmpy alone and with nervure.")
parser.add_argument("--end", type=float, default=1.0, help="end of the runs, s (1)")
parser.add_argument("--output", type=Path, default=Path("gallery-master"), help="folder of the results")
given = parser.parse_args()

scene = nervure.load("fsi3-325x72")
scene.time.end = given.end
ours = nervure.run(scene, given.output / "nervure", quiet=True)
units = [ours.folder / f"{scene.name}-{name}.fmu" for name in ("rod", "fluid")]
loop = Path(__file__).parents[1] / "fsi3.py"
subprocess.run([sys.executable, loop, *units, given.output / "tip.csv", f"--end={given.end}"], check=True)
with (given.output / "tip.csv").open(encoding="utf-8") as file:
    table = np.array([[float(row[name]) for name in ("time", "tip.uy")] for row in csv.DictReader(file)])

apart = np.abs(table[:, 1] - ours.series["tip_uy"]).max()
print(f"largest difference of the tip: {apart:.1g} m, where it moves by {np.abs(table[:, 1]).max():.2g} m")
figure = Figure(figsize=(8, 3), layout="constrained")
axes = figure.subplots()
axes.plot(ours.series["time"], 1e3 * ours.series["tip_uy"], label="nervure")
axes.plot(*table.T * [[1], [1e3]], "--", label="fmpy alone")
axes.set(xlabel="time [s]", ylabel="tip, across [mm]")
axes.legend()
figure.savefig(given.output / "tip.png", dpi=100)
