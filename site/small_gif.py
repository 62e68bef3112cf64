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


def shrink(source: Path, target: Path) -> None:
    """Write all frames of `source`; where the file would exceed `LARGEST`, their first half, one period of two, and
    then every other, every third … of these, each shown for longer."""
    with Image.open(source) as film:
        frames = [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)]
    animation.write_gif(frames, target)
    half, stride = frames[: len(frames) // 2], 1
    while target.stat().st_size > LARGEST and stride < len(half):
        animation.write_gif(half[::stride], target, every=stride)
        stride += 1


if __name__ == "__main__":
    run, gallery = map(Path, sys.argv[1:])
    name = f"{re.sub(r'-[0-9]+(x[0-9]+)+$', '', run.name)}.gif"
    shrink(next(run.glob("*.gif")), gallery / name if gallery.is_dir() else gallery)
