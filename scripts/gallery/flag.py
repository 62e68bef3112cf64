"""A flag in the wind: what its weight changes.

    python scripts/gallery/flag.py

The flag is a line without thickness in a stream of Reynolds number 1000; a gust across it sets it off. Its mass ratio
is the mass of its area by that of as much fluid as it is long.
"""

import argparse
from pathlib import Path

import nervure

parser = argparse.ArgumentParser(description="Run a flag of three weights.")
parser.add_argument("--end", type=float, default=24.0, help="end of the runs, lengths by speed (24)")
parser.add_argument("--output", type=Path, default=Path("gallery-flag"), help="folder of the results")
given = parser.parse_args()

runs = []
for mass_ratio in (0.075, 0.15, 0.3):
    scene = nervure.load("flag-massless-240x120")
    scene.time.end = given.end
    scene.time.communication_step = scene.fluid.time_stepping.max_step = 0.002
    scene.rod.material.section.line_density = mass_ratio
    run = nervure.run(scene, given.output / f"mass-{mass_ratio:g}", fields_every=0.1, quiet=True)
    runs.append(run)
    found = run.summary.quantities["tip_uy"]
    beat = f"beats {found.frequency_hz:.2f} times a unit of time" if found.frequency_hz else "does not beat"
    print(f"mass ratio {mass_ratio:g}: the tip moves by {found.amplitude:.3f} lengths and {beat}")

nervure.compare(*runs, names=["tip_uy"]).savefig(given.output / "tip.png", dpi=100)
runs[1].plot_field().savefig(given.output / "vorticity.png", dpi=100)
