"""FSI3 of Turek and Hron (2006), from the shipped scene to curves and a moving picture.

    python scripts/gallery/fsi3.py

The flag of rubber swings up from rest; from about 6 s on it is periodic. A run takes about half a minute.
"""

import argparse

import nervure

parser = argparse.ArgumentParser(description="Run FSI3 and draw it.")
parser.add_argument("--end", type=float, default=8.0, help="end of the run, s (8)")
parser.add_argument("--output", default="gallery-fsi3", help="folder of the results")
given = parser.parse_args()

scene = nervure.load("fsi3-325x72")
scene.time.end = given.end
run = nervure.run(scene, given.output, fields_every=0.01, quiet=True)

for name, found in run.summary.quantities.items():
    published = found.reference
    line = f"{name}: {found.mean:.4g} ± {found.amplitude:.4g} {found.unit}"
    if published and run.summary.not_compared is None:
        line += f", published {published.mean:.4g} ± {published.amplitude:.4g}"
    print(line)
print(run.summary.not_compared or "the run is periodic")

run.plot("tip_uy", "lift").savefig(run.folder / "curves.png", dpi=150)
print(*run.animate())
