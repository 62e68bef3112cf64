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

LARGEST = 1_500_000  # Size of a picture of two periods from which one period is left out, bytes


def shrink(source: Path, target: Path) -> None:
    """Write all frames of `source`, or their first half where the file would exceed `LARGEST`."""
    with Image.open(source) as film:
        frames = [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)]
    for shown in (frames, frames[: len(frames) // 2]):
        animation.write_gif(shown, target)
        if target.stat().st_size <= LARGEST:
            break


if __name__ == "__main__":
    run, gallery = map(Path, sys.argv[1:])
    name = f"{re.sub(r'-[0-9]+x[0-9]+$', '', run.name)}.gif"
    shrink(next(run.glob("*.gif")), gallery / name if gallery.is_dir() else gallery)
