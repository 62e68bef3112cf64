"""Copy the moving picture of a run into the gallery, named after the run without its grid, or to a file.

python site/small_gif.py results/NAME docs/pictures
python site/small_gif.py results/NAME docs/pictures/OTHER.gif
"""

import re
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageSequence

from nervure.output import animation

LARGEST = 1_000_000  # Size of a picture, bytes
SMALLER = 0.85  # Factor of width and height of one trial after the other


def shrink(source: Path, target: Path) -> None:
    """Write all frames of `source`, or their first half where the file would exceed `LARGEST`: one period of two. Make
    this half smaller until it fits."""
    with Image.open(source) as film:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film)]
    animation.write_gif([np.asarray(frame) for frame in frames], target)
    half, factor = frames[: len(frames) // 2], 1.0
    while target.stat().st_size > LARGEST:
        size = [round(length * factor) for length in half[0].size]
        animation.write_gif([np.asarray(frame.resize(size, Image.Resampling.LANCZOS)) for frame in half], target)
        factor *= SMALLER


if __name__ == "__main__":
    run, gallery = map(Path, sys.argv[1:])
    name = f"{re.sub(r'-[0-9]+x[0-9]+$', '', run.name)}.gif"
    shrink(next(run.glob("*.gif")), gallery / name if gallery.is_dir() else gallery)
