"""A flow in space: the drag of a sphere in a stream at Re 100.

    python scripts/gallery/sphere.py

A shipped scene on half of its grid, with six cells across the sphere: twelve bring the drag closer.
"""

import argparse
import math

import nervure

parser = argparse.ArgumentParser(description="Run the flow past a sphere on a coarse grid.")
parser.add_argument("--end", type=float, default=10.0, help="end of the run, diameters by speed (10)")
parser.add_argument("--output", default="gallery-sphere", help="folder of the results")
given = parser.parse_args()

scene = nervure.load("sphere-stream-144x96x96")
scene.time.end = given.end
scene.fluid.box.cells = [cells // 2 for cells in scene.fluid.box.cells]
run = nervure.run(scene, given.output, fields_every=given.end / 2, quiet=True)
drag = run.series["drag"][-1] / (scene.fluid.density / 2 * math.pi / 4)
print(f"drag coefficient {drag:.3f}; Johnson and Patel (1999) give 1.102")
run.plot_field("speed").savefig(run.folder / "speed.png", dpi=100)
