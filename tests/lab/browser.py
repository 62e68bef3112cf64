"""A headless Chromium, driven over a pipe by the DevTools protocol."""

import itertools
import json
import os
import shutil
import subprocess
import tempfile
import time
from typing import Any

from nervure.resources import ROOT

PAGE = ROOT / "target" / "lab" / "index.html"  # Of `make lab`
AXE = ROOT / "target" / "axe" / "package" / "axe.min.js"  # Of `make lab-test`: checks of accessibility
NAMES = ("chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((found for name in NAMES if (found := shutil.which(name))), None)

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-renderer-backgrounding",  # It would run behind everything else on the machine
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-pipe",
    "about:blank",
)


class Browser:
    """A browser with one page, to be used in a `with` statement."""

    def __init__(self, width: int = 1280, height: int = 1000):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        (read, self.write), (self.read, write) = os.pipe(), os.pipe()
        size = [f"--window-size={width},{height}", f"--user-data-dir={self.folder.name}"]

        def pipes() -> None:  # The browser reads from 3 and writes to 4
            inner = os.dup(read), os.dup(write)
            os.dup2(inner[0], 3)
            os.dup2(inner[1], 4)

        command = [CHROMIUM or "chromium", *size, *OPTIONS]
        self.process = subprocess.Popen(
            command, preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(read)
        os.close(write)
        self.ids, self.buffer = itertools.count(1), b""
        self.events: list[Any] = []
        self.session: str | None = None
        targets = self.call("Target.getTargets")["targetInfos"]
        target = next(own["targetId"] for own in targets if own["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for part in ("Page", "Runtime"):
            self.call(f"{part}.enable")

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self.write)
        os.close(self.read)
        self.folder.cleanup()

    def call(self, method: str, **parameters: Any) -> Any:
        """Return the result of a method of the protocol."""
        number = next(self.ids)
        message = {"id": number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def _receive(self) -> Any:
        while b"\0" not in self.buffer:
            piece = os.read(self.read, 1 << 16)
            if not piece:
                raise RuntimeError("the browser ended")
            self.buffer += piece
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def open(self, address: str) -> None:
        """Go to an address."""
        self.call("Page.navigate", url=address)

    def run(self, script: str) -> Any:
        """Return the value of JavaScript, which may be a promise."""
        asked = {"expression": script, "awaitPromise": True, "returnByValue": True, "userGesture": True}
        result = self.call("Runtime.evaluate", **asked)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["exception"].get("description", script))
        return result["result"].get("value")

    def errors(self) -> list[str]:
        """Return what the page could not do, and its errors on the console."""
        thrown = [e["params"]["exceptionDetails"] for e in self.events if e.get("method") == "Runtime.exceptionThrown"]
        return [str(own.get("exception", own).get("description", own)) for own in thrown]


def wait(browser: Browser, condition: str, seconds: float = 60) -> None:
    """Wait until JavaScript is true."""
    end = time.monotonic() + seconds
    while not browser.run(condition):
        assert time.monotonic() < end, f"{condition} did not become true: {browser.errors()}"
        time.sleep(0.05)


def opened(browser: Browser, state: str = "") -> Browser:
    """Open the page of the lab in a state, paused at t = 0."""
    browser.open("about:blank")
    browser.open(f"{PAGE.as_uri()}{state}")
    wait(browser, "Boolean(globalThis.lab?.scene())")
    browser.run("(lab.pause(), lab.restart())")
    return browser


def rows(browser: Browser, steps: int) -> list[list[float]]:
    """Step, and return the samples of the steps."""
    flat = browser.run(f"lab.step({steps}).then((rows) => Array.from(rows))")
    columns = len(flat) // steps
    return [flat[i : i + columns] for i in range(0, len(flat), columns)]
