"""Record the page for README: a flag flaps, a mouse pulls at it and places a cylinder.

python -m lab.record target/lab/index.html docs/pictures/lab.gif
"""

import argparse
import base64
import io
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from nervure.output import animation
from tests.lab.browser import Browser, wait

SCENE = "#flag"
SIZE = (1100, 540)  # Of the recorded part of the page, pixels
WIDTH = 720  # Of the picture
COLOURS = 48
STEPS = 36  # Between two frames
BEFORE, FRAMES = 1000, 24  # Steps before the first frame; number of frames
PULL, PLACE = range(3, 11), range(12, 15)  # Frames in which the mouse pulls, and draws a cylinder


def mouse(browser: Browser, kind: str, x: float, y: float) -> None:
    """Press, move or release the mouse at a point of the page."""
    buttons = {"button": "left", "buttons": int(kind != "mouseReleased"), "clickCount": 1}
    browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **buttons)


def frames(browser: Browser) -> Iterator[np.ndarray]:
    """Yield pictures of the page."""
    left, top, height = browser.run(
        "{ const { left, top, height } = document.getElementById('flow').getBoundingClientRect(); "
        "[left, top, height]; }"
    )
    low, high = browser.run("lab.part()")[0], browser.run("lab.part()")[3]
    scale = height / (2 * high)

    def at(point: list[float]) -> tuple[float, float]:
        return left + (point[0] - low) * scale, top + height / 2 - point[1] * scale

    def click(value: str) -> None:
        browser.run(f"document.querySelector('[name=tool][value={value}]').click()")

    browser.run(f"lab.step({BEFORE})")
    for i in range(FRAMES):
        if i == PULL.start:
            held = at(browser.run("lab.shapes()[0].map((list) => list.at(-1))"))
            mouse(browser, "mousePressed", *held)
        if i in PULL:
            share = (i - PULL.start + 1) / len(PULL)
            mouse(browser, "mouseMoved", held[0] - 60 * share, top + height * (0.5 - 0.36 * share))
        if i == PULL.stop:
            mouse(browser, "mouseReleased", 0, 0)
        center = at([1.75, 0.02])
        if i == PLACE.start:
            click("place")
            mouse(browser, "mousePressed", *center)
        if i in PLACE:
            mouse(browser, "mouseMoved", center[0] + 6 * (i - PLACE.start), center[1])
        if i == PLACE.stop:
            mouse(browser, "mouseReleased", *center)
            click("pull")
        browser.run(f"lab.step({STEPS}).then(() => lab.draw())")
        time.sleep(0.4)  # until it is on the screen
        clip = {"x": 0, "y": 0, "width": SIZE[0], "height": SIZE[1], "scale": 1}
        picture = base64.b64decode(browser.call("Page.captureScreenshot", format="png", clip=clip)["data"])
        image = Image.open(io.BytesIO(picture)).convert("RGB")
        yield np.asarray(image.resize((WIDTH, WIDTH * SIZE[1] // SIZE[0]), Image.Resampling.LANCZOS))


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=Path)
    parser.add_argument("picture", type=Path)
    wanted = parser.parse_args()
    with Browser(*SIZE) as browser:
        size = {"width": SIZE[0], "height": SIZE[1]}
        browser.call("Emulation.setScrollbarsHidden", hidden=True)
        browser.call("Emulation.setDeviceMetricsOverride", **size, deviceScaleFactor=1, mobile=False)
        browser.open(f"{wanted.page.resolve().as_uri()}{SCENE}")
        wait(browser, "Boolean(globalThis.lab?.scene())")
        browser.run("lab.pause(), lab.restart()")
        pictures = list(frames(browser))
    some = Image.fromarray(np.concatenate(pictures[:: FRAMES // 6]))
    palette = some.quantize(COLOURS).getpalette() or []
    animation.write_gif(pictures, wanted.picture, np.array(palette, np.uint8).reshape(-1, 3)[:COLOURS])


if __name__ == "__main__":
    main()
