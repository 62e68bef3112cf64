"""Copy the moving picture of a run into the gallery, with fewer colours, named after the run without its grid.

Two periods stay, or one where two would be too large.

    python site/small_gif.py results/NAME docs/pictures
    python site/small_gif.py results/NAME docs/pictures/OTHER.gif
"""

import re
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from PIL import Image, ImageSequence

from nervure.output.flow import COLOUR_MAP
from nervure.output.plots import BLUE

COLOURS, GREYS, FRAME_MS = 47, 16, 80
LARGEST = 1_500_000  # Bytes of a picture of two periods


def shrink(source: Path, target: Path) -> None:
    """Write `source` with `COLOURS` colours of the vorticity's scale, `GREYS` greys and the blue of a rod."""
    with Image.open(source) as film:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film)]
    colours = colormaps[COLOUR_MAP](np.linspace(0, 1, COLOURS))[:, :3]
    greys = np.repeat(np.linspace(0, 1, GREYS)[:, None], 3, axis=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((255 * np.concatenate([colours, greys, [to_rgb(BLUE)]])).round().astype(np.uint8).tobytes())
    small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    for shown in (small, small[: len(small) // 2]):
        gif = BytesIO()
        shown[0].save(gif, "GIF", save_all=True, append_images=shown[1:], duration=FRAME_MS, loop=0, optimize=True)
        if gif.tell() <= LARGEST:
            break
    target.write_bytes(gif.getvalue())


if __name__ == "__main__":
    run, gallery = map(Path, sys.argv[1:])
    name = f"{re.sub(r'-[0-9]+x[0-9]+$', '', run.name)}.gif"
    shrink(next(run.glob("*.gif")), gallery / name if gallery.is_dir() else gallery)
