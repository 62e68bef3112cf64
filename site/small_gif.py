"""Make the moving picture of a run small enough for the gallery, and name it by the run's folder without its grid.

python site/small_gif.py results/NAME docs/gallery
"""

import re
import sys
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from PIL import Image, ImageSequence

from nervure.show.plots import COLOUR_MAP

WIDTH, COLOURS, GREYS, FRAME_MS = 480, 48, 16, 80


def shrink(source: Path, target: Path) -> None:
    """Write `source` with `WIDTH` points, `COLOURS` colours of the vorticity's scale and `GREYS` greys."""
    with Image.open(source) as film:
        size = WIDTH, round(film.height * WIDTH / film.width)
        frames = [frame.convert("RGB").resize(size, Image.Resampling.LANCZOS) for frame in ImageSequence.Iterator(film)]
    scale = colormaps[COLOUR_MAP](np.linspace(0, 1, COLOURS))[:, :3]
    greys = np.repeat(np.linspace(0, 1, GREYS)[:, None], 3, axis=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((255 * np.concatenate([scale, greys])).round().astype(np.uint8).tobytes())
    small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    small[0].save(target, save_all=True, append_images=small[1:], duration=FRAME_MS, loop=0, optimize=True)


if __name__ == "__main__":
    run, gallery = map(Path, sys.argv[1:])
    shrink(next(run.glob("*.gif")), gallery / f"{re.sub(r'-[0-9]+x[0-9]+$', '', run.name)}.gif")
