"""The live view of a run: a page on this machine that shows the curves and the flow while the units step.

The server listens on the loopback address only, and answers requests that carry the token of its address. It reads the
recorded rows by itself; all that needs the units (a frame, a checkpoint) is done by the run between two steps.
"""

import base64
import json
import os
import secrets
import sys
import threading
import webbrowser
from collections.abc import Sequence
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Self
from urllib.parse import parse_qs, urlsplit

import numpy as np

from nervure.output import axis_label, displayed_unit, fields, flow, lengths_in, space, title, unit_in
from nervure.simulation.checkpoint import Checkpoint
from nervure.simulation.loop import Observer, TimeLoop
from nervure.simulation.recorder import column
from nervure.simulation.results import CHECKPOINT, Results
from nervure.simulation.session import Session
from nervure.simulation.summary import RunStatus

LOOPBACK = "127.0.0.1"
PAGE = Path(__file__).with_suffix(".html")
FIELDS = {"vorticity": ("vorticity",), "speed": ("u", "v", "w"), "pressure": ("p",)}  # With what the unit shows
UNITS = {"vorticity": "1/s", "speed": "m/s", "pressure": "Pa"}
MOST_POINTS = 512  # Points of a frame along an axis
BUCKETS = 400  # Parts of a curve, each drawn from its least to its largest value
PATIENCE = 1.0  # Time that a request waits for a frame, and the end of the run for a page to see it, s
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class Live(Observer):
    """Serves the page of a session at `url` until it is closed. `checkpoint` writes checkpoints, where the units can;
    `stopped` is True after somebody stopped the run on the page."""

    def __init__(self, session: Session, checkpoint: Checkpoint | None):
        self.session, self.checkpoint, self.stopped = session, checkpoint, False
        self.message, self.ended = "", ""
        self.token = secrets.token_urlsafe(24)
        self._wanted: str | None = None
        self._frames: dict[str, dict[str, Any]] = {}
        self._save = False
        self._news = threading.Condition()
        self._seen = threading.Event()  # A page knows of the end
        self._watched = False
        fluid = session.units.get("fluid")
        self.fields = [name for name, (first, *_) in FIELDS.items() if fluid and fluid.shown_field(first) is not None]
        scene = session.scene
        self.view = flow.View(scene) if scene.fluid else None
        self.unit, self.scale = lengths_in(scene, 0.0)
        columns = session.recorder.units.items()
        self.shown = {name: unit_in(scene, unit, 0.0) for name, unit in columns if name != "time"}
        live = self

        class Handler(_Handler):
            page = live

        self.server = _Server((LOOPBACK, 0), Handler)
        self.hosts = {f"{name}:{self.server.server_port}" for name in (LOOPBACK, "localhost")}
        self.url = f"http://{LOOPBACK}:{self.server.server_port}/?token={self.token}"
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.server.shutdown()
        self.server.server_close()

    def open(self) -> None:
        """Open the page where there is a screen: a browser in the terminal would take the place of the run's output."""
        if sys.platform in ("darwin", "win32") or os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
            webbrowser.open(self.url)

    def step(self, loop: TimeLoop) -> None:
        if self._save or self._wanted is not None:
            self._attend()

    def end(self, status: RunStatus | None) -> None:
        if status and self._wanted is not None:
            self._attend()

    def finish(self, results: Results) -> None:
        summary, folder = results.summary, results.folder
        if summary.error:
            ended = f"The run failed at t = {summary.simulated_s:g} s: {summary.error}"
        elif summary.completed:
            ended = f"The run is finished. Results are in {folder}."
        else:
            kept = (folder / CHECKPOINT).exists()
            how = f"`nervure resume {folder} --live` continues it." if kept else "There is no checkpoint."
            ended = f"The run was stopped at t = {summary.simulated_s:g} s. {how}"
        with self._news:
            self.ended = ended
            self._news.notify_all()
        if self._watched:
            self._seen.wait(PATIENCE)

    def _attend(self) -> None:
        """Do what the page asked for, between two steps."""
        with self._news:
            if self._save and self.checkpoint and self.session.steps:
                try:
                    self.checkpoint.save()
                    self.message = f"checkpoint at t = {self.session.time:g} s in {self.checkpoint.path}"
                except OSError as error:
                    self.message = f"no checkpoint at t = {self.session.time:g} s: {error}"
                self._save = False
            if self._wanted is not None:
                self._frames[self._wanted] = self._frame(self._wanted)
                self._wanted = None
            self._news.notify_all()

    def _frame(self, name: str) -> dict[str, Any]:
        """Return a field, empty where there is none, and the solids, as the page draws them."""
        session, view, units = self.session, self.view, self.session.units
        mesh, solids = session.facts.wing, list[np.ndarray]()
        for own in session.facts.beams:
            if {"x", "y"} <= (units.get(own.unit) or units["fluid"]).variables.keys():
                points, thickness = fields.station_positions(units, own), session.facts.thickness[own.force]
                if view:
                    solids += view.beam(points, thickness)
                elif points.shape[1] == 2:
                    solids.append(fields.outline(points, thickness))
                else:  # from above
                    solids.append(space.there_and_back(points[:, :2]))
        wing = (fields.wing_nodes(session), mesh.triangles) if mesh else None
        if view:
            solids = view.outlines(solids, self._poses(), wing)
        elif mesh and wing:
            seen = wing[0][:, :2]
            solids += [
                *(seen[edge] for edge in mesh.edges()),
                *(space.there_and_back(seen[vein]) for vein in mesh.veins),
            ]
        frame: dict[str, Any] = {"time": session.time, "solids": [outline.tolist() for outline in solids]}
        if name and view:
            parts = [view.component] if name == "vorticity" else FIELDS[name][: 3 if view.plane else 2]
            found = [view.cut(units["fluid"].field(part)) for part in parts]
            stride = max(1, -(-max(found[0].shape) // MOST_POINTS))
            values = np.sqrt(np.sum(np.square(found), axis=0)) if len(found) > 1 else found[0]
            unit, _ = displayed_unit(UNITS[name], session.scene.display)
            whole = [[*view.ends[0], *view.ends[1]]]
            frame |= {"name": name, "unit": unit, "view": view.extent}
            frame |= _packed(flow.mean(values)[::stride, ::stride], whole) | {"fine": self._fine(parts, view)}
        return frame

    def _fine(self, parts: Sequence[str], view: flow.View) -> dict[str, Any] | None:
        """Return the length of a vector, or a field, by its `parts` on the cells of the fine box; None where the view
        has none of it."""
        fluid = self.session.units["fluid"]
        lows = fields.fine_box(fluid) or None
        if not (boxes := view.fine_box(lows)):
            return None
        found = [fluid.field(f"{fields.FINE}.{part}") for part in parts]
        if view.plane:
            found = [np.take(own, view.fine_number(view.fine_ends(lows)) or 0, view.plane.normal) for own in found]
        values = np.sqrt(np.sum(np.square(found), axis=0)) if len(found) > 1 else found[0]
        stride = max(1, -(-max(values.shape) // MOST_POINTS))
        ends = [[*box[[0, 2], 0].tolist(), *box[[0, 2], 1].tolist()] for box in boxes]
        return _packed(values[::stride, ::stride], ends)

    def _poses(self) -> list[list[float]]:
        """Return the last recorded position (m) and angle or rotation vector (rad) of each body."""
        recorder = self.session.recorder
        row = dict(zip(recorder.columns, recorder.table[recorder.rows - 1].tolist(), strict=True))
        return flow.poses(self.session.scene, lambda name: row.get(column(name), 0.0))

    def state(self, columns: list[str], field: str) -> dict[str, Any]:
        """Return what the page shows: the curves of `columns` and, once the run has made it, a frame of `field`."""
        session, view = self.session, self.view
        recorder, display = session.recorder, session.scene.display
        with self._news:
            self._watched = True
            field = field if field in self.fields else ""
            if not self.ended:
                self._wanted = field
                self._news.wait_for(lambda: self._wanted is None or bool(self.ended), PATIENCE)
            frame, message, ended = self._frames.get(field), self.message, self.ended
        table = recorder.table[: recorder.rows]
        shown = self.shown
        curves = {}
        for name in filter(shown.__contains__, columns):
            values = table[:, recorder.columns.index(name)] * shown[name][1]
            rows = thinned(values)
            curves[name] = {"time": table[rows, 0].tolist(), "values": values[rows].tolist()}
        return {
            "title": title(session.scene, 6.0),
            "time": session.time,
            "end": session.grid.end,
            "time_unit": displayed_unit("s", display)[0],
            "steps": session.steps,
            "all_steps": session.grid.steps,
            "wall": session.wall,
            "columns": {name: unit for name, (unit, _) in shown.items()},
            "fields": self.fields,
            "curves": curves,
            "frame": frame,
            "message": message,
            "ended": ended,
            "axes": [axis_label(name, self.unit) for name in (view.names if view else "xy")],
            "scale": self.scale,
            "slice": view.place if view else "",
            "sponge": view.sponge if view else None,
            "can_save": self.checkpoint is not None,
            "resume": f"nervure resume {session.folder} --live",
        }

    def ask(self, what: str) -> bool:
        """Stop the run or write a checkpoint after the present step; return False for anything else."""
        if what == "stop":
            self.stopped = True
        elif what == "checkpoint" and self.checkpoint:
            self._save = True
        else:
            return False
        return True

    def note_answer(self, ended: str) -> None:
        """Note that a page got this answer."""
        if ended:
            self._seen.set()


def _packed(values: np.ndarray, boxes: list[list[float]]) -> dict[str, Any]:
    """Return a field and the boxes that it fills, with their ends along both axes, as the page reads them."""
    image = values.T.astype("<f4")
    return {"shape": image.shape, "boxes": boxes, "values": base64.b64encode(image.tobytes()).decode()}


def thinned(values: np.ndarray) -> np.ndarray:
    """Return the rows of a curve that show it: the least and the largest finite value of each part, and the last."""
    finite = np.flatnonzero(np.isfinite(values))
    last, width = len(finite) - 1, -(-len(finite) // BUCKETS)
    if width <= 2:
        return finite
    parts = np.pad(values[finite], (0, -len(finite) % width), mode="edge").reshape(-1, width)
    begins = width * np.arange(len(parts))
    rows = np.concatenate([begins + parts.argmin(axis=1), begins + parts.argmax(axis=1), [last]])
    shown: np.ndarray = finite[np.unique(np.minimum(rows, last))]
    return shown


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing where a page is closed during an answer."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    page: Live
    protocol_version, timeout = "HTTP/1.1", 30

    def do_GET(self) -> None:
        path, query = self._request()
        if query is None:
            return
        if path == "/":
            self._answer(PAGE.read_bytes(), "text/html; charset=utf-8")
        elif path == "/state":
            state = self.page.state(query.get("column", []), query.get("field", [""])[0])
            self._answer(json.dumps(state).encode(), "application/json")
            self.page.note_answer(state["ended"])
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

    def do_POST(self) -> None:
        path, query = self._request()
        if query is None:
            return
        if self.page.ask(path.removeprefix("/")):
            self._answer(b"{}", "application/json")
        else:
            self._refuse(HTTPStatus.NOT_FOUND)

    def _request(self) -> tuple[str, dict[str, list[str]] | None]:
        """Return path and query; None, with a refusal, for no address, without the token, or under another name: a
        foreign site may let its name point to this machine."""
        try:
            url = urlsplit(self.path)
            query = parse_qs(url.query)
        except ValueError:
            self._refuse(HTTPStatus.BAD_REQUEST)
            return self.path, None
        token = query.get("token", [""])[0].encode()
        if self.headers["Host"] in self.page.hosts and secrets.compare_digest(token, self.page.token.encode()):
            return url.path, query
        self._refuse(HTTPStatus.FORBIDDEN)
        return url.path, None

    def _refuse(self, status: HTTPStatus) -> None:
        self.close_connection = True  # A body that was not read would be taken for the next request
        self._answer(status.phrase.encode(), "text/plain", status)

    def _answer(self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.send_response(status)
        for name, value in (HEADERS | {"Content-Type": kind, "Content-Length": str(len(body))}).items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing: the terminal is the run's."""
