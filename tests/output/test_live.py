"""The page of a running run: `nervure run --live`."""

import base64
import http.client
import json
import socket
import threading
import time
from urllib.parse import urlencode, urlsplit

import numpy as np
import pytest

import nervure
from nervure.output import flow, live
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.scene.facts import Facts
from nervure.simulation.results import CHECKPOINT
from tests.fluid.test_two_grids import driven

pytestmark = pytest.mark.usefixtures("libraries")


@pytest.fixture
def pages(monkeypatch):
    """The pages that runs open, in the place of a browser."""
    found = []
    monkeypatch.setattr(live.Live, "open", lambda page: found.append(page))
    yield found
    for page in found:
        page.stopped = True  # where a test failed


class Run:
    """A run in a thread, and what a browser does with its page."""

    def __init__(self, pages, work):
        self.ended = None

        def target():
            try:
                self.ended = work()
            except BaseException as error:
                self.ended = error

        self.thread = threading.Thread(target=target)
        self.thread.start()
        wait(lambda: pages or not self.thread.is_alive())
        assert pages, self.ended
        self.url = urlsplit(pages[-1].url)

    def ask(self, path, method="GET", *, token=None, host=None, **query):
        """Return status and body of an answer."""
        query["token"] = self.url.query.removeprefix("token=") if token is None else token
        connection = http.client.HTTPConnection(self.url.netloc, timeout=20)
        connection.request(method, f"{path}?{urlencode(query, doseq=True)}", headers={"Host": host or self.url.netloc})
        answer = connection.getresponse()
        found = answer.status, answer.read().decode()
        connection.close()
        return found

    def state(self, **query):
        status, body = self.ask("/state", **query)
        assert status == 200, body
        return json.loads(body)


def wait(what, seconds=20.0):
    """Return the first true answer of a function."""
    end = time.monotonic() + seconds
    while not (found := what()) and time.monotonic() < end:
        time.sleep(0.02)
    return found


def test_a_page_shows_a_run_and_stops_it(two_rods, tmp_path, pages):
    two_rods["time"]["end"] = 100.0
    scene, folder = validate(two_rods), tmp_path / "run"
    run = Run(pages, lambda: nervure.run(scene, folder, quiet=True, live=True))

    assert run.url.hostname == "127.0.0.1"
    for token, host in (("", None), ("x" * 32, None), (None, "evil.example"), (None, "evil.example:80")):
        for path, method in (("/", "GET"), ("/state", "GET"), ("/stop", "POST")):
            assert run.ask(path, method, token=token, host=host) == (403, "Forbidden")
    for address in ("//[", "http://[x", "/%00?token=%ff", "/?" + "&" * 9):
        with socket.create_connection((run.url.hostname, run.url.port)) as stranger:
            stranger.sendall(f"GET {address} HTTP/1.1\r\nHost: {run.url.netloc}\r\n\r\n".encode())
            assert stranger.recv(100).startswith((b"HTTP/1.1 400", b"HTTP/1.1 403")), address
    assert run.ask("/passwd")[0] == run.ask("/run", "POST")[0] == 404
    status, page = run.ask("/")
    assert status == 200 and "<!doctype html>" in page and "http" not in page, "the page needs nothing from elsewhere"

    with socket.create_connection((run.url.hostname, run.url.port)) as browser:
        browser.sendall(f"GET /state?{run.url.query} HTTP/1.1\r\nHost: {run.url.netloc}\r\n\r\n".encode())
    begin = run.state()["steps"]
    assert wait(lambda: run.state()["steps"] > begin), "a browser that is killed must not stop the run"

    asked = {"column": ["upper_tip_uy", "drag", "nothing"], "field": "speed"}
    state = wait(lambda: (found := run.state(**asked))["frame"] and found["steps"] > 20 and found)
    frame, curve = state["frame"], state["curves"]["upper_tip_uy"]
    assert state["curves"].keys() == {"upper_tip_uy", "drag"} and state["columns"]["upper_tip_uy"] == "m"
    assert state["axes"] == ["x [m]", "y [m]"] and state["scale"] == 1 and state["slice"] == ""
    assert state["sponge"] == (list(scene.fluid.sponge.x) if scene.fluid.sponge else None)
    assert 0 <= state["time"] - frame["time"] < 1 and frame["time"] > 0
    speed = np.frombuffer(base64.b64decode(frame["values"]), "<f4").reshape(frame["shape"])
    assert speed.shape == (64, 128) and speed[:, :24].mean() == pytest.approx(1.0, abs=0.1)
    assert speed[43, 48] < 0.5 * speed[:, 48].max(), "slow at the rod, which is drawn where it is"
    assert [len(outline) for outline in frame["solids"]] == [34, 34]
    assert np.mean(frame["solids"][0], axis=0) == pytest.approx([1.5, 0.35], abs=0.1)

    assert run.ask("/checkpoint", "POST")[0] == 200
    assert "checkpoint at t =" in wait(lambda: run.state()["message"]) and (folder / CHECKPOINT).exists()
    assert run.ask("/stop", "POST")[0] == 200
    assert wait(lambda: run.state()["ended"]).endswith(f"`nervure resume {folder} --live` continues it.")
    run.thread.join(20)
    assert isinstance(run.ended, KeyboardInterrupt)
    with pytest.raises(ConnectionRefusedError):
        run.ask("/state")
    series = nervure.read(folder).series
    rows = np.searchsorted(series["time"], np.array(curve["time"]) - 1e-9)
    assert np.allclose(curve["values"], series["upper_tip_uy"][rows], rtol=1e-8)

    done = len(series["time"]) - 1
    pages.clear()
    again = Run(pages, lambda: nervure.resume(folder, quiet=True, live=True))
    assert wait(lambda: again.state()["steps"] > done + 5)
    again.ask("/stop", "POST")
    again.thread.join(20)
    assert np.array_equal(nervure.read(folder).series["drag"][: done + 1], series["drag"])


def test_a_rod_alone_has_curves_and_an_outline(rod_only, tmp_path, pages):
    rod_only["time"]["end"] = 100.0
    run = Run(pages, lambda: nervure.run(validate(rod_only), tmp_path, quiet=True, live=True))
    state = wait(lambda: (found := run.state(column="tip_uy", field="vorticity"))["frame"] and found)
    run.ask("/stop", "POST")
    run.thread.join(20)
    assert state["fields"] == [] and state["frame"].keys() == {"time", "solids"} and len(state["frame"]["solids"]) == 1
    assert state["curves"]["tip_uy"]["values"][-1] <= 0.0


@pytest.mark.usefixtures("libraries")
def test_a_wing_is_seen_from_above(tmp_path, pages):
    scene = nervure.load(ROOT / "examples" / "wing-hanging.json").copy({"time.end": 100.0})
    run = Run(pages, lambda: nervure.run(scene, tmp_path, quiet=True, live=True))
    around, *veins = wait(lambda: (found := run.state())["frame"] and found)["frame"]["solids"]
    run.ask("/stop", "POST")
    run.thread.join(20)
    mesh = Facts(scene).wing
    (edge,) = mesh.edges()
    assert len(veins) == len(mesh.veins) and veins[0] == veins[0][::-1]
    assert np.abs(np.array(around) - mesh.nodes[edge, :2]).max() < 0.1 * np.ptp(mesh.nodes[:, 0])
    sides, corners = (
        np.array([line, np.roll(line, -1, axis=-2)]) for line in (mesh.nodes[edge], mesh.nodes[mesh.triangles])
    )
    area = np.linalg.norm(np.cross(*sides).sum(axis=0)), np.linalg.norm(np.cross(*corners).sum(axis=(0, 1)))
    assert area[0] == pytest.approx(area[1]), "the edge is that of all triangles"


def test_a_page_shows_the_cells_of_a_fine_box_where_it_is(tmp_path, pages):
    scene = validate(driven(100.0))
    run = Run(pages, lambda: nervure.run(scene, tmp_path, quiet=True, live=True))
    frame = wait(lambda: (found := run.state(field="speed")["frame"]) and found["time"] > 0.5 and found)
    run.ask("/stop", "POST")
    run.thread.join(60)
    whole, fine = (
        np.frombuffer(base64.b64decode(part["values"]), "<f4").reshape(part["shape"]) for part in (frame, frame["fine"])
    )
    assert whole.shape == (32, 48) and fine.shape == (48, 48) and frame["boxes"] == [[-4.0, 8.0, -4.0, 4.0]]
    (left, right, low, high), *_ = frame["fine"]["boxes"]
    # The body goes at -1 m/s; a frame that comes late has the box at the other end of the 12 m.
    off = (left + 3.0 + frame["time"] + 6.0) % 12.0 - 6.0
    assert right - left == high - low == 6.0 and low == -3.0 and abs(off) < 0.25
    assert fine.max() > 1.0, "fast at the cylinder"


def test_a_slice_of_a_flow_in_space_has_the_mean_of_pictures(tmp_path, pages):
    scene = nervure.load("sphere-stream-144x96x96").copy({"fluid.box.cells": [48, 32, 32], "time.end": 100.0})
    run = Run(pages, lambda: nervure.run(scene, tmp_path, quiet=True, live=True))
    begun = 10 * scene.time.communication_step  # At the start the stream is in the sphere, too
    frame = wait(lambda: (found := run.state(field="speed")["frame"]) and found["time"] > begun and found)
    run.ask("/stop", "POST")
    run.thread.join(60)
    speed = np.frombuffer(base64.b64decode(frame["values"]), "<f4").reshape(frame["shape"])
    assert speed.shape == (32, 48) and speed[16, 18] < 0.5 < speed[2, 2] < 1.1, "slow at the sphere"
    assert len(frame["solids"]) == 1
    rough = np.random.default_rng(1).normal(size=(24, 18))
    at = [np.arange(n) / n for n in rough.shape]
    shown = flow.resample(flow.resample(rough, (0.0, 1.0), at[0]).T, (0.0, 1.0), at[1]).T
    assert np.allclose(flow.mean(rough), shown, atol=1e-12)


def test_without_live_nothing_listens(rod_only, tmp_path, monkeypatch):
    def refuse(*_):
        raise AssertionError("a socket listens")

    monkeypatch.setattr(socket.socket, "listen", refuse)
    assert nervure.run(validate(rod_only), tmp_path / "quiet", quiet=True).summary.completed
    with pytest.raises(AssertionError, match="listens"):
        nervure.run(validate(rod_only), tmp_path / "live", quiet=True, live=True)


def test_a_thinned_curve_keeps_its_peaks_and_its_end():
    values = np.sin(np.arange(100_000) / 300)
    values[[77, 50_000, 99_998]] = 5.0, np.nan, -7.0
    rows = live.thinned(values)
    assert {77, 99_998, 99_999} <= set(rows) and len(rows) <= 2 * live.BUCKETS + 1 and (np.diff(rows) > 0).all()
    assert live.thinned(np.array([1.0, np.inf, 2.0])).tolist() == [0, 2]
