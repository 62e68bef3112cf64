"""Shrink the moving picture of a run for the gallery, and name it after the run without its grid.

Two periods stay, or one where two would be too large.

    python site/small_gif.py results/NAME docs/pictures
"""

import re
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from PIL import Image, ImageSequence

from nervure.output.plots import COLOUR_MAP

WIDTH, HEIGHT, COLOURS, GREYS, FRAME_MS = 480, 430, 48, 16, 80
LARGEST = 600_000  # Bytes of a picture of two periods


def shrink(source: Path, target: Path) -> None:
    """Write `source` with at most `WIDTH` x `HEIGHT` points, `COLOURS` colours of the vorticity's scale and `GREYS`
    greys."""
    with Image.open(source) as film:
        scale = min(WIDTH / film.width, HEIGHT / film.height)
        size = round(film.width * scale), round(film.height * scale)
        frames = [frame.convert("RGB").resize(size, Image.Resampling.LANCZOS) for frame in ImageSequence.Iterator(film)]
    colours = colormaps[COLOUR_MAP](np.linspace(0, 1, COLOURS))[:, :3]
    greys = np.repeat(np.linspace(0, 1, GREYS)[:, None], 3, axis=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((255 * np.concatenate([colours, greys])).round().astype(np.uint8).tobytes())
    small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    for shown in (small, small[: len(small) // 2]):
        gif = BytesIO()
        shown[0].save(gif, "GIF", save_all=True, append_images=shown[1:], duration=FRAME_MS, loop=0, optimize=True)
        if gif.tell() <= LARGEST:
            break
    target.write_bytes(gif.getvalue())


if __name__ == "__main__":
    run, gallery = map(Path, sys.argv[1:])
    shrink(next(run.glob("*.gif")), gallery / f"{re.sub(r'-[0-9]+x[0-9]+$', '', run.name)}.gif")
