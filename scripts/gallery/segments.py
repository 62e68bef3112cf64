"""How many segments a rod needs: a sweep over the bar of CSM3, which swings in gravity.

    python scripts/gallery/segments.py

Turek and Hron (2006) publish a frequency of 1.0995 Hz and an amplitude of 65.16 mm.
"""

import argparse
from pathlib import Path

import nervure

parser = argparse.ArgumentParser(description="Run CSM3 with several numbers of segments.")
parser.add_argument("--end", type=float, default=10.0, help="end of the runs, s (10)")
parser.add_argument("--output", type=Path, default=Path("gallery-segments"), help="folder of the results")
given = parser.parse_args()

scene = nervure.load("csm3").copy({"time.end": given.end})
for row in nervure.sweep(scene, {"beam.segments": [4, 8, 16, 32, 64]}, given.output, quiet=True):
    found = nervure.read(given.output / row["folder"]).summary.quantities["tip_uy"]
    print(f"{row['beam.segments']} segments: {1e3 * found.amplitude:.2f} mm, {found.frequency_hz or 0:.4f} Hz")
