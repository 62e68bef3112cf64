"""Fields over time in files that ParaView opens (VTKHDF 2): the fluid's grid in one, each beam in another.

Room for all frames is laid out at the start, and a frame is counted after it is written: the file of a killed run can
be read up to its last frame, and a resumed run fills the rest. So nothing is compressed. Values have single precision.
"""

import errno
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from nervure.errors import InputError, SceneError
from nervure.extras import require
from nervure.scene import Own, Scene, text, wings
from nervure.scene.types import Fluid
from nervure.simulation.loop import Observer, TimeLoop
from nervure.simulation.results import BEAM_FIELDS, FLUID_FIELDS, WING_FIELDS
from nervure.simulation.session import Session
from nervure.simulation.summary import RunStatus
from nervure.units.fmu import Unit

SCENE = "scene"  # Dataset with the text of the scene, which VTK ignores
FINE_BOX = "fine_box"  # Dataset with the lower ends of a fine box that moves, m, `[frames, axes]`, ignored too
FINE = "fine"  # Group with the fields on the cells of a fine box, ignored too
CELL_KINDS = ("Vertices", "Lines", "Polygons", "Strips")


def beam_file(own: Own) -> str:
    """Return the file name of a beam."""
    return f"beam-{own.unit}.vtkhdf" if own.prefix else BEAM_FIELDS


def station_positions(units: dict[str, Unit], own: Own) -> np.ndarray:
    """Return the present positions of a beam's stations, `[n, 2]`, or `[n, 3]` in space."""
    unit = units.get(own.unit) or units["fluid"]
    return np.column_stack([unit.read(name) for name in "xyz" if name in unit.variables])


def fine_box(fluid: Unit) -> list[float]:
    """Return the lower ends of a fine box that moves, m; none without one."""
    names = [name for axis in "xyz" if (name := f"{FINE_BOX}.{axis}") in fluid.variables]
    return [float(fluid.read(name)[0]) for name in names]


def wing_nodes(session: Session) -> np.ndarray:
    """Return the present positions of the nodes of all wings, `[n, 3]`."""
    units = [session.units[name] for name in wings(session.scene)]
    return np.concatenate([np.column_stack([unit.read(axis) for axis in "xyz"]) for unit in units])


def outline(centre_line: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    """Return the outline of a beam in the plane, `[2 n, 2]`, from its stations and its thickness there, `[n]`."""
    tangent = np.gradient(centre_line, axis=0)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]]) / np.linalg.norm(tangent, axis=1, keepdims=True)
    side = thickness[:, None] / 2 * normal
    return np.concatenate([centre_line + side, (centre_line - side)[::-1]])


def dataset(folder: Path, begin: float | None, end: float | None) -> Any:
    """Return the frames of the fluid's fields from `begin` to `end` (s) as an xarray Dataset over time, y and x, or
    over time, z, y and x."""
    xarray, h5py = require("xarray", "a dataset of fields"), require("h5py", "reading fields")
    if not (folder / FLUID_FIELDS).exists():
        raise InputError(f"{folder} holds no fields of a fluid: a run writes them with `fields_every`")
    with h5py.File(folder / FLUID_FIELDS) as file:
        root = file["VTKHDF"]
        times = root["Steps/Values"][: root["Steps"].attrs["NSteps"]]
        chosen = (times >= (-np.inf if begin is None else begin)) & (times <= (np.inf if end is None else end))
        frames = np.flatnonzero(chosen)
        if not frames.size:
            raise InputError(f"{folder} has no frames in that time, but {len(times)} elsewhere")
        part = slice(frames[0], frames[-1] + 1)
        origin, spacing = root.attrs["Origin"], root.attrs["Spacing"]
        read = {name: root["PointData"][name][part] for name in ("velocity", "vorticity", "pressure")}
    cells = read["velocity"].shape[1:-1]
    values = {name: (read["velocity"][..., i], "m/s") for i, name in enumerate("uvw"[: len(cells)])}
    if len(cells) == 3:
        values |= {f"vorticity_{name}": (read["vorticity"][..., i], "1/s") for i, name in enumerate("xyz")}
    else:
        values["vorticity"] = (read["vorticity"], "1/s")
    values["pressure"] = (read["pressure"], "Pa")
    axes = {"time": (times[part], "s")}
    for i in reversed(range(len(cells))):
        axes["xyz"[i]] = (origin[i] + spacing[i] * np.arange(cells[::-1][i]), "m")
    return xarray.Dataset(
        {name: (tuple(axes), field, {"units": unit}) for name, (field, unit) in values.items()},
        {name: (name, places, {"units": unit}) for name, (places, unit) in axes.items()},
    )


class Fields(Observer):
    """Writes the field files of a session, one frame every `interval` (s), rounded to whole steps, at most
    the whole run.

    A session that was resumed needs the files of the run before. Where the disk does not take a frame, `warn` is called
    and the run continues without fields.
    """

    def __init__(self, session: Session, interval: float, warn: Callable[[str], None]):
        scene, grid, units, folder = session.scene, session.grid, session.units, session.folder
        self.stride, self.warn = grid.stride(interval), warn
        frames, known = grid.steps // self.stride + 1, session.steps // self.stride + 1 if session.steps else 0
        shows = scene.fluid if "fluid" in units and units["fluid"].shown_field("u") is not None else None
        if not shows and not session.facts.beams and not session.facts.wing:
            raise SceneError("--fields-every needs a beam, a wing or a fluid that shows its fields (fmu_field)")
        self.files: list[Grid | Moving] = []
        if shows:
            self.files.append(Grid(folder / FLUID_FIELDS, scene, shows, units["fluid"], frames, known))
        for own in session.facts.beams:
            self.files.append(Beam(session, own, frames, known))
        if session.facts.wing:
            self.files.append(Wing(session, session.facts.wing.triangles, frames, known))
        session.stale_files -= {file.path for file in self.files}

    def step(self, loop: TimeLoop) -> None:
        if loop.steps % self.stride == 0 and self.files:
            try:
                for file in self.files:
                    file.write(loop.steps // self.stride, loop.time)
            except OSError as error:
                self.end(None)
                self.files = []
                self.warn(f"no fields from t = {loop.time:g} s on: {error}")

    def end(self, _status: RunStatus | None) -> None:
        for file in self.files:
            file.file.close()


class Series:
    """A VTKHDF file with room for `frames` frames, `known` of them filled."""

    def __init__(self, path: Path, scene: Scene, frames: int, known: int):
        h5py = require("h5py", "writing fields")
        self.path, access = path, h5py.h5p.create(h5py.h5p.FILE_ACCESS)
        access.set_fclose_degree(h5py.h5f.CLOSE_WEAK)
        access.set_libver_bounds(h5py.h5f.LIBVER_EARLIEST, h5py.h5f.LIBVER_LATEST)
        access.set_sieve_buf_size(0)  # It would write more than what `_fill` takes room for
        if not known:
            self.file = h5py.File(h5py.h5f.create(os.fsencode(path), h5py.h5f.ACC_TRUNC, fapl=access))
            self.file.create_dataset(SCENE, data=np.bytes_(text(scene).encode()))
            self.root = self.file.create_group("VTKHDF")
            self.root.attrs["Version"] = (2, 0)
            self.steps = self.root.create_group("Steps")
            self.steps.attrs["NSteps"] = 0
            self.times = self.steps.create_dataset("Values", (0,), float, maxshape=(frames,), chunks=(frames,))
            return
        try:
            self.file = h5py.File(h5py.h5f.open(os.fsencode(path), h5py.h5f.ACC_RDWR, fapl=access))
            self.root = self.file["VTKHDF"]
            self.steps, self.times = self.root["Steps"], self.root["Steps/Values"]
            fits = self.file[SCENE][()].decode() == text(scene) and self.times.maxshape == (frames,)
        except (OSError, KeyError) as error:
            raise SceneError(f"the fields in {path} cannot be continued: {error}") from error
        if not fits or len(self.times) < known:
            raise SceneError(
                f"the fields in {path} cannot be continued: another scene or --fields-every, or frames are missing"
            )
        self._count(known)

    def _place(self, group: Any, name: str, shape: tuple[int, ...]) -> Any:
        """Return a dataset of single precision whose room is laid out now and filled later."""
        h5py = require("h5py", "writing fields")
        layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        return group.create_dataset(name, shape, np.float32, dcpl=layout)

    def _fill(self, data: Any, rows: slice, values: Any) -> None:
        """Write rows of a dataset, for which room is taken on the disk before: HDF5 does not survive a full one."""
        size = data.dtype.itemsize * math.prod(data.shape[1:])
        length, begin = (rows.stop - rows.start) * size, data.id.get_offset()
        if length and begin is not None and hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(self.file.id.get_vfd_handle(), begin + rows.start * size, length)
            except OSError as error:
                if error.errno not in (errno.EINVAL, errno.EOPNOTSUPP):  # A file system that cannot
                    raise
        data[rows] = values

    def _count(self, frames: int, time: float | None = None) -> None:
        """Set the number of frames; a new last frame is at `time` (s)."""
        self.times.resize(frames, axis=0)
        if time is not None:
            self.times[frames - 1] = time
        self.file.flush()
        self.steps.attrs.modify("NSteps", frames)
        self.file.flush()


class Grid(Series):
    """Velocity, vorticity and pressure on the fluid's grid, as ImageData; vorticity is a vector in space."""

    def __init__(self, path: Path, scene: Scene, flow: Fluid, fluid: Unit, frames: int, known: int):
        super().__init__(path, scene, frames, known)
        self.fluid = fluid
        if not known:
            cells = fluid.field("u").shape
            ends = [flow.box.x, flow.box.y, flow.box.z or (0.0, 1.0)]
            counts = [*cells, 1][:3]
            spacing = [(high - low) / n for (low, high), n in zip(ends, counts, strict=True)]
            extent = [edge for n in counts for edge in (0, n - 1)]
            self.root.attrs.update(Type=np.bytes_("ImageData"), WholeExtent=extent)
            self.root.attrs.update(Origin=[low for low, _ in ends], Spacing=spacing, Direction=np.eye(3).ravel())
            self._lay_out(self.root.create_group("PointData"), frames, cells)
            if (of_fine := fluid.shown_field(f"{FINE}.u")) is not None:
                self._lay_out(self.file.create_group(FINE), frames, of_fine.shape)
            if f"{FINE_BOX}.x" in fluid.variables:
                self._place(self.file, FINE_BOX, (frames, len(cells)))
            self.file.flush()
        self.data = self.root["PointData"]

    def _lay_out(self, data: Any, frames: int, cells: tuple[int, ...]) -> None:
        """Lay out the fields of all frames on so many cells."""
        spin = (3,) if len(cells) == 3 else ()
        for name, components in (("velocity", (3,)), ("vorticity", spin), ("pressure", ())):
            self._place(data, name, (frames, *reversed(cells), *components))

    def write(self, frame: int, time: float) -> None:
        """Write the fluid's fields at `time` (s) as frame number `frame`."""
        self._write(self.data, frame, "")
        if FINE in self.file:
            self._write(self.file[FINE], frame, f"{FINE}.")
        if FINE_BOX in self.file:
            self._fill(self.file[FINE_BOX], slice(frame, frame + 1), fine_box(self.fluid))
        self._count(frame + 1, time)

    def _write(self, data: Any, frame: int, prefix: str) -> None:
        """Write the fields whose names begin so."""
        u, v, omega, p = (self.fluid.field(prefix + name).T for name in ("u", "v", "vorticity", "p"))
        w = np.zeros_like(u)
        if omega.ndim == 3:
            w, *across = (self.fluid.field(prefix + name).T for name in ("w", "vorticity_x", "vorticity_y"))
            omega = np.stack([*across, omega], axis=-1)
        for name, values in (("velocity", np.stack([u, v, w], axis=-1)), ("vorticity", omega), ("pressure", p)):
            self._fill(data[name], slice(frame, frame + 1), values)


class Moving(Series):
    """A body whose points move, as PolyData with the same cells in every frame."""

    def _points(self) -> np.ndarray:
        """Return the present points, `[n, 3]`."""
        raise NotImplementedError

    def _lay_out(self, shape: str, cells: np.ndarray, frames: int) -> None:
        """Lay out a file for `cells` of a kind `shape`, `[cells, corners]`."""
        n, (count, corners) = len(self._points()), cells.shape
        self.root.attrs["Type"] = np.bytes_("PolyData")
        self.root["NumberOfPoints"] = np.full(1, n)
        self._place(self.root, "Points", (frames * n, 3))
        for kind in CELL_KINDS:
            group, here = self.root.create_group(kind), count if kind == shape else 0
            group["NumberOfCells"] = np.full(1, here)
            group["NumberOfConnectivityIds"] = np.full(1, here * corners)
            group["Offsets"] = np.arange(here + 1) * corners
            group["Connectivity"] = cells.ravel()[: here * corners]
        self.steps["PartOffsets"] = np.zeros(frames, int)
        self.steps["NumberOfParts"] = np.ones(frames, int)
        self.steps["PointOffsets"] = np.arange(frames) * n
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            self.steps[name] = np.zeros((frames, len(CELL_KINDS)), int)
        self.file.flush()

    def write(self, frame: int, time: float) -> None:
        """Write the points at `time` (s) as frame number `frame`."""
        points = self._points()
        self._fill(self.root["Points"], slice(frame * len(points), (frame + 1) * len(points)), points)
        self._count(frame + 1, time)


class Beam(Moving):
    """A beam: its outline in the plane, its centre line in space."""

    def __init__(self, session: Session, own: Own, frames: int, known: int):
        super().__init__(session.folder / beam_file(own), session.scene, frames, known)
        units = session.units
        self.units, self.own, self.thickness = units, own, session.facts.thickness[own.force]
        if not known:
            shape = "Polygons" if station_positions(units, own).shape[1] == 2 else "Lines"
            self._lay_out(shape, np.arange(len(self._points()))[None], frames)

    def _points(self) -> np.ndarray:
        points = station_positions(self.units, self.own)
        return points if points.shape[1] == 3 else np.pad(outline(points, self.thickness), ((0, 0), (0, 1)))


class Wing(Moving):
    """The triangles of all wings."""

    def __init__(self, session: Session, triangles: np.ndarray, frames: int, known: int):
        super().__init__(session.folder / WING_FIELDS, session.scene, frames, known)
        self.session = session
        if not known:
            self._lay_out("Polygons", triangles, frames)

    def _points(self) -> np.ndarray:
        return wing_nodes(self.session)
