"""Animation and phases of a run with --fields-every.

vorticity.gif repeats the last whole periods without a seam, vorticity.mp4 shows them where imageio-ffmpeg is installed,
and phases.png has four phases of the last period. Rods without a fluid and wings have motion.png and motion.gif. A
fluid in space has vortices.png and vortices.gif, too, where pyvista is installed.
"""

import json
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from nervure import arguments
from nervure.catalogue import hint
from nervure.errors import InputError
from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series
from nervure.extras import require
from nervure.files import write_whole
from nervure.output import console, fields, flow, layout, plots, title, vortices
from nervure.output.motion import RodPicture
from nervure.output.wings import WingPicture
from nervure.scene import beams, column_names, validate, wings
from nervure.scene.facts import Facts, WingMesh
from nervure.simulation import results
from nervure.simulation.recorder import column
from nervure.simulation.results import FLUID_FIELDS, WING_FIELDS

ROUNDING = 1e-9  # Relative, of a time
PERIODS = 2  # Whole periods in the animation, unless times are given
PHASES = 4
FILM = 60  # Largest number of frames in motion.gif
SHAPES = 24  # Largest number of shapes of a rod in motion.png
WINGS = 5  # Number of shapes of a wing in motion.png
SAMPLES = 8  # Frames that set the colour scale
WIDTH, DPI = 7.5, 100  # Width of the animation, in, and points an inch
FRAME_MS = 60  # Duration of a frame, ms
FIELDS = {"vorticity": "1/s", "pressure": "Pa", "speed": "m/s", "u": "m/s", "v": "m/s", "w": "m/s"}  # With their units
SHADES = 255  # Colours of the palette for vortices, besides white
COLOURS, GREYS = 95, 32  # Colours of the palette for the scale, and for text, axes and solids


class Part(NamedTuple):
    """The part of a fluid in pictures, see `flow.View`; what is None is chosen by the scene."""

    across: str | None = None
    at: float | None = None
    crop: Sequence[float] | None = None

    def checked(self) -> "Part":
        """Return the part with numbers of Python; raise `InputError` where an argument has another type."""
        if not (self.across is None or isinstance(self.across, str)):
            raise InputError(f"across is {arguments.shown(self.across)}, but must be x, y or z")
        crop = None if self.crop is None else arguments.numbers("crop", self.crop)
        return Part(self.across, arguments.if_given("at", self.at), crop)


ALL, PLAIN = Part(), vortices.Look()


class Frames:
    """The frames in a result folder: times (s), vorticity, outlines of the beams."""

    def __init__(self, folder: Path, part: Part = ALL):
        """Read a folder; `part` is what pictures of the fluid show."""
        h5py = require("h5py", "an animation")
        self.folder = folder
        if not (paths := results.field_files(folder)):
            raise InputError(f"{folder} holds no fields: `nervure run` writes them with --fields-every")
        files: dict[str, Any] = {path.name: h5py.File(path) for path in sorted(paths)}
        first = files.get(FLUID_FIELDS, next(iter(files.values())))
        self.fluid: Any = files.get(FLUID_FIELDS)
        self.wing: Any = files.get(WING_FIELDS)
        self.scene = scene = validate(json.loads(first[fields.SCENE][()]))
        self.facts = Facts(scene)
        self.times = first["VTKHDF/Steps/Values"][: first["VTKHDF/Steps"].attrs["NSteps"]]
        self.beams: list[Any] = [files[fields.beam_file(own)]["VTKHDF"] for own in beams(scene)]
        moves = scene.fluid and flow.poses(scene, str)
        self.moves = self._moves(results.read(folder).series) if moves else []
        self.part = part

    def _moves(self, series: Series) -> list[np.ndarray]:
        """Return the place of each body at the times of the frames, `[frames, parts]`, m and rad (see `flow.poses`)."""
        found = flow.poses(self.scene, lambda name: np.interp(self.times, series["time"], series[column(name)]))
        return [np.transpose(parts) for parts in found]

    @cached_property
    def run(self) -> results.Results | None:
        """The results of the run; None where they cannot be read."""
        try:
            return results.read(self.folder)
        except InputError:
            return None

    @cached_property
    def view(self) -> flow.View:
        """What pictures of the fluid show."""
        return flow.View(self.scene, *self.part)

    def vorticity(self, frame: int) -> np.ndarray:
        return self.field("vorticity", frame)

    def field(self, name: str, frame: int) -> np.ndarray:
        """Return one of `FIELDS` in the view of a frame, `[n, m]`, in space the vorticity about the axis across it."""
        return self._cut(self.fluid["VTKHDF/PointData"], name, frame, self.view.number if self.view.plane else 0)

    def fine(self, name: str, frame: int) -> np.ndarray | None:
        """Return the same on the cells of the fine box; None where there is none in the view."""
        if fields.FINE not in self.fluid:
            return None
        number = self.view.fine_number(self.view.fine_ends(self._lows(frame))) if self.view.plane else 0
        return None if number is None else self._cut(self.fluid[fields.FINE], name, frame, number)

    def _cut(self, data: Any, name: str, frame: int, number: int) -> np.ndarray:
        """Return a field of some data in the view, in space of a slice by its number."""
        plane = self.view.plane
        of, is_part = (name, False) if name in data else ("velocity", True)
        where: list[slice | int] = [slice(None)] * (3 if plane else 2)
        if plane:
            where[2 - plane.normal] = number
        values = np.swapaxes(data[of][(frame, *where)], 0, 1)  # Axes of the file are z, y, x
        if is_part:
            u, v, w = np.moveaxis(values, -1, 0)
            found: np.ndarray = np.sqrt(u**2 + v**2 + w**2) if name == "speed" else {"u": u, "v": v, "w": w}[name]
            return found
        return np.array(values[..., plane.normal] if plane and name == "vorticity" else values)

    def flow(self, frame: int) -> vortices.Flow:
        """Return a fluid in space with all that is in it in a frame."""
        velocity = np.array(self.fluid["VTKHDF/PointData/velocity"][frame]).swapaxes(0, 2)
        time = float(self.times[frame])
        return vortices.Flow(velocity, self.poses(frame), self.rods(frame), self.membrane(frame), time)

    def nearest(self, time: float | None) -> int:
        """Return the frame nearest to `time` (s), by default the last; raise `InputError` for one outside."""
        if time is None:
            return len(self.times) - 1
        reached = max(self.times[-1], results.read(self.folder).summary.simulated_s)
        if not -ROUNDING <= time <= reached + ROUNDING * reached:
            raise InputError(f"the run in {self.folder} goes from 0 to {reached:g} s, but the time is {time:g} s")
        return int(np.argmin(np.abs(self.times - time)))

    def points(self, frame: int, beam: int = 0) -> np.ndarray:
        """Return the outline of a beam in the plane, or its centre line in space, `[n, 3]`."""
        n = self.beams[beam]["NumberOfPoints"][0]
        return np.array(self.beams[beam]["Points"][frame * n : (frame + 1) * n])

    def title(self, frame: int) -> str:
        return f"t = {self.times[frame]:.3f} {plots.unit('s', self.scene)}"

    def solids(self, frame: int) -> list[np.ndarray]:
        """Return the outlines of the solids in the view, m, each `[n, 2]`."""
        beams = [self.points(frame, beam)[:, :2] for beam in range(len(self.beams))]
        if plane := self.view.plane:
            beams = [outline for rod in self.rods(frame) for outline in plane.rod(*rod)]
        return self.view.outlines(beams, self.poses(frame), self.membrane(frame))

    def fine_box(self, frame: int) -> list[np.ndarray]:
        """Return the outlines of the fine box in the view, m."""
        return self.view.fine_box(self._lows(frame))

    def _lows(self, frame: int) -> Sequence[float] | None:
        """Return the lower ends of a fine box that moves, m."""
        return self.fluid[fields.FINE_BOX][frame].tolist() if fields.FINE_BOX in self.fluid else None

    def rods(self, frame: int) -> list[tuple[np.ndarray, float]]:
        """Return centre line, `[n, 3]`, and largest radius of each beam in space, m."""
        thickness = self.facts.thickness if self.beams else {}
        return [
            (self.points(frame, i), float(np.max(thickness[own.force])) / 2) for i, own in enumerate(beams(self.scene))
        ]

    def membrane(self, frame: int) -> tuple[np.ndarray, np.ndarray] | None:
        """Return nodes, `[n, 3]`, m, and triangles, `[m, 3]`, of the wings, if the scene has some."""
        mesh = self.facts.wing if self.wing is not None else None
        if mesh is None:
            return None
        count = len(mesh.nodes)
        return np.array(self.wing["VTKHDF/Points"][frame * count : (frame + 1) * count]), mesh.triangles

    def poses(self, frame: int) -> list[list[float]]:
        """Return the places of the bodies (see `flow.poses`)."""
        return [move[frame].tolist() for move in self.moves]

    def lines(self, frame: int) -> list[np.ndarray]:
        """Return the points of each beam, m, `[n, 3]`."""
        return [self.points(frame, beam) for beam in range(len(self.beams))]

    @cached_property
    def has_lines(self) -> bool:
        """Whether the beams are centre lines in space."""
        return any(beam["Lines/NumberOfCells"][0] for beam in self.beams)

    @cached_property
    def shapes(self) -> list[np.ndarray]:
        """The points of each beam in each frame, m, `[frames, n, 3]`."""
        each = range(len(self.times)), range(len(self.beams))
        return [np.array([self.points(frame, beam) for frame in each[0]]) for beam in each[1]]

    @cached_property
    def tips(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Times (s) and paths of the tips of the beams, m, `[times, 3]`: from the series, or else from the frames."""
        series, paths = self.run.series if self.run else None, []
        for own, shapes in zip(beams(self.scene), self.shapes, strict=True):
            middle = shapes.shape[1] // 2
            path = shapes[:, -1] if self.has_lines else shapes[:, middle - 1 : middle + 1].mean(axis=1)
            if series:
                still = np.zeros_like(series["time"])
                moved = np.transpose([series.get(f"{own.prefix}tip_u{axis}", still) for axis in "xyz"])
                path = path[0] + moved - moved[0]
            paths.append(path)
        return (series["time"] if series else self.times), paths

    def between(self, begin: float, end: float) -> list[int]:
        """Return the frames from `begin` to before `end` (s)."""
        return np.flatnonzero((self.times >= begin) & (self.times < end)).tolist()


def write(
    folder: Path, begin: float | None, end: float | None, part: Part = ALL, look: vortices.Look = PLAIN
) -> list[Path]:
    """Write vorticity.gif and vorticity.mp4 of the times from `begin` to `end` (s), and phases.png, into a result
    folder; of rods alone or wings motion.png, motion.gif and motion.mp4; of a fluid in space also vortices.png,
    vortices.gif and vortices.mp4 where pyvista is installed. Return their paths."""
    try:
        frames = Frames(folder, part)
    except (OSError, KeyError) as error:
        raise InputError(f"the fields in {folder} cannot be read: {error}") from error
    in_space = bool(frames.scene.fluid and frames.scene.fluid.box.z)
    if len(frames.times) < 2:
        raise InputError(f"the run in {folder} has one frame, but a film needs two: record them more often")
    look = look.checked()
    if look != PLAIN and not in_space:
        raise InputError("q, camera and background are of vortices in space, but there is no fluid in space")
    if frames.fluid is None and part != ALL:
        raise InputError("across, at and crop are of a fluid, but there is none")
    if frames.fluid is not None:
        _ = frames.view  # Refuses a part that is not there, before anything is written
    window = frames.run.summary.window if frames.run else None
    if window and window.periods:
        looped, last = window.last(PERIODS), window.last(1)
    else:
        looped = last = statistics.Window(0.0, float(frames.times[-1]) * (1 + 1e-9), 0)
    first, stop = looped.begin if begin is None else begin, looped.end if end is None else end
    chosen = frames.between(first, stop)
    if not chosen:
        raise InputError(
            f"no frames from {first:g} s to {stop:g} s: the run has {frames.times[0]:g} to {frames.times[-1]:g} s"
        )
    of_wing = wing_motion(frames, chosen, folder) if frames.wing is not None else []
    if frames.fluid is None and of_wing:
        return of_wing
    if frames.fluid is None:
        shown = chosen if begin is not None or end is not None else frames.between(last.begin, last.end)
        motion(frames, shown, folder / "motion.png")
        return [folder / "motion.png", *_films(folder / "motion", render_rod(frames, shown))]
    sampled = chosen[:: max(1, len(chosen) // SAMPLES)]
    limit = frames.view.colour_limit([(frames.vorticity(frame), frames.solids(frame)) for frame in sampled])

    at = last.begin + (last.end - last.begin) * np.arange(PHASES) / PHASES
    phases(frames, [frames.nearest(float(time)) for time in at], limit, folder / "phases.png")
    written = [*of_wing, folder / "phases.png", *_films(folder / "vorticity", render(frames, chosen, limit))]
    if in_space:
        try:
            require("pyvista", "vortices.gif")
        except InputError as error:
            console.warn(str(error))
        else:
            written += _vortices(frames, chosen, look)
    return written


def _vortices(frames: Frames, chosen: list[int], look: vortices.Look) -> list[Path]:
    """Write vortices.png of the last frame and the films of at most `FILM` frames; return their paths."""
    chosen = chosen[:: -(-len(chosen) // FILM)]
    space = vortices.Space(frames.scene, look, frames.part.crop, map(frames.flow, chosen[:: max(1, len(chosen) // 3)]))
    pictures = [space.picture(frames.flow(frame)) for frame in chosen]
    path = frames.folder / "vortices.png"
    write_whole(path, lambda unfinished: Image.fromarray(pictures[-1]).save(unfinished, "PNG"))
    # The background is a third of a picture and would take the palette's colours from the surfaces.
    colours, behind = np.concatenate(pictures[:: max(1, len(pictures) // 3)]).reshape(-1, 3), pictures[0][0, 0]
    few = Image.fromarray(colours[(colours != behind).any(axis=-1)][None]).quantize(SHADES)
    palette = np.append(np.reshape(few.getpalette() or [], (-1, 3)), [behind], axis=0).astype(np.uint8)
    return [path, *_films(frames.folder / "vortices", pictures, palette)]


def plot_vortices(folder: Path, time: float | None, look: vortices.Look, part: Part = ALL) -> Image.Image:
    """Draw the vortices at the frame nearest to `time` (s), by default the last."""
    look = look.checked()
    frames = Frames(folder, part)
    if frames.fluid is None or not (frames.scene.fluid and frames.scene.fluid.box.z):
        raise InputError(f"{folder} holds no fields of a fluid in space")
    flow = frames.flow(frames.nearest(time))
    return Image.fromarray(vortices.Space(frames.scene, look, part.crop, [flow]).picture(flow))


def plot_field(folder: Path, name: str, time: float | None, part: Part = ALL) -> Figure:
    """Draw one of `FIELDS` at the frame nearest to `time` (s), by default the last; raise `InputError` for a time
    outside of the run."""
    if name not in FIELDS:
        raise InputError(f"there is no field {name}: {hint(name, FIELDS)}")
    frames = Frames(folder, part)
    if frames.fluid is None:
        raise InputError(f"{folder} holds no fields of a fluid")
    if name == "w" and not (frames.scene.fluid and frames.scene.fluid.box.z):
        raise InputError("there is no field w: the fluid has two dimensions")
    frame = frames.nearest(time)
    field, solids = frames.field(name, frame), frames.solids(frame)
    percentile = flow.PERCENTILE if name == "vorticity" else 100.0
    limit = frames.view.colour_limit([(field, solids)], percentile)
    figure, axes = frames.view.panels(plots.WIDTH)
    picture = flow.Picture(axes[0, 0], frames.view, limit)
    if name == "speed":
        picture.image.set(cmap="viridis", clim=(0.0, limit))
    picture.show(field, solids, frames.fine_box(frame), frames.fine(name, frame))
    picture.say(float(frames.times[frame]))
    flow.colour_bar(figure, axes, picture.image, frames.view, name, FIELDS[name])
    return figure


def _has_ffmpeg() -> bool:
    """Return whether imageio-ffmpeg is installed with a program for this system."""
    try:
        import imageio_ffmpeg

        return bool(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return False


def _films(path: Path, pictures: list[np.ndarray], palette: np.ndarray | None = None) -> list[Path]:
    """Write the pictures as GIF and, with ffmpeg, as MP4; return the paths."""
    written = [path.with_suffix(".gif")]
    write_whole(written[0], lambda unfinished: write_gif(pictures, unfinished, palette))
    if _has_ffmpeg():
        written.append(path.with_suffix(".mp4"))
        write_whole(written[1], lambda unfinished: write_mp4(pictures, unfinished))
    return written


def phases(frames: Frames, chosen: list[int], limit: float, path: Path) -> None:
    """Draw four frames below each other, or two by two where the box is high, with one colour scale."""
    left, right, bottom, top = frames.view.extent
    columns = 2 if top - bottom > (right - left) / 2 else 1
    figure, axes = frames.view.panels(plots.WIDTH, len(chosen) // columns, columns, 2 * layout.TOP)
    figure.set_dpi(plots.DPI)
    for axis, frame in zip(axes.flat, chosen, strict=True):
        picture = flow.Picture(axis, frames.view, limit)
        boxes, fine = frames.fine_box(frame), frames.fine("vorticity", frame)
        picture.show(frames.vorticity(frame), frames.solids(frame), boxes, fine)
        axis.set_title(frames.title(frame), loc="right", fontsize="small")
    layout.label_outer(axes)
    words = title(frames.scene, plots.WIDTH - 0.1 * len(frames.view.place))
    figure.suptitle(", ".join(filter(None, (words, frames.view.place))), fontsize="medium")
    flow.colour_bar(figure, axes, picture.image, frames.view)
    plots.save(figure, path)


def motion(frames: Frames, chosen: list[int], path: Path) -> None:
    """Draw the paths of the tips of rods over the whole run, coloured by time, and their shapes at `chosen`."""
    times, of_tips = frames.tips
    picture = RodPicture(frames.scene, frames.shapes, of_tips, plots.WIDTH, in_space=frames.has_lines)
    picture.draw_paths(of_tips, times)
    for number in np.unique(np.linspace(0, len(chosen) - 1, SHAPES).round().astype(int)):
        for shapes in frames.shapes:
            picture.add(shapes[chosen[number]], color="0.3", linewidth=0.7)
    first, last = (f"{frames.times[chosen[end]]:.3g}" for end in (0, -1))
    what = "rod" if len(of_tips) == 1 else "rods"
    picture.caption.set_text(f"{what} from {first} to {last} {picture.clock}")
    plots.save(picture.figure, path)


def render_rod(frames: Frames, chosen: list[int]) -> list[np.ndarray]:
    """Return pictures of rods with the paths of their tips, `[height, width, 3]` of bytes; at most `FILM`."""
    _, of_tips = frames.tips
    picture = RodPicture(frames.scene, frames.shapes, of_tips, WIDTH, in_space=frames.has_lines)
    picture.draw_paths(of_tips)
    rods = [(shapes, picture.add(shapes[0], color=plots.BLUE, linewidth=1.5)) for shapes in frames.shapes]

    def show(frame: int) -> None:
        for shapes, lines in rods:
            for line, view in zip(lines, picture.views, strict=True):
                line.set_data(*picture.line(shapes[frame], view))
        picture.caption.set_text(frames.title(frame))

    return filmed(picture.figure, chosen[:: -(-len(chosen) // FILM)], show)


def wing_motion(frames: Frames, chosen: list[int], folder: Path) -> list[Path]:
    """Write motion.png and the films of wings with the paths of their tips, and of the rods beside them."""
    scene, mesh = frames.scene, frames.facts.wing
    assert mesh is not None, "the file is of wings"
    count = len(mesh.nodes)
    shapes = np.array(frames.wing["VTKHDF/Points"][: len(frames.times) * count]).reshape(-1, count, 3)[chosen]
    paths, rods = _paths_of_tips(frames, mesh, chosen), [frames.lines(frame) for frame in chosen]
    others = np.concatenate([*paths, *(line for lines in rods for line in lines)])
    still = WingPicture(scene, mesh, shapes, others, plots.WIDTH)
    for number in np.unique(np.linspace(0, len(chosen) - 1, WINGS).round().astype(int))[:-1]:
        still.add(shapes[number], rods[number])
    for path in paths:
        still.draw_path(path)
    still.show(shapes[-1], rods[-1])
    first, last = (f"{frames.times[chosen[end]]:.3g}" for end in (0, -1))
    still.caption.set_text(f"t = {first} to {last} {still.clock}")
    plots.save(still.figure, folder / "motion.png")

    picture = WingPicture(scene, mesh, shapes, others, WIDTH)
    for path in paths:
        picture.draw_path(path)

    def show(place: int) -> None:
        picture.show(shapes[place], rods[place])
        picture.caption.set_text(frames.title(chosen[place]))

    pictures = filmed(picture.figure, range(0, len(chosen), -(-len(chosen) // FILM)), show)
    return [folder / "motion.png", *_films(folder / "motion", pictures)]


def _paths_of_tips(frames: Frames, mesh: WingMesh, chosen: list[int]) -> list[np.ndarray]:
    """Return the path of the tip of each wing over the times of the frames `chosen`, m, `[times, 3]`: from the series,
    or else from the frames."""
    frames_of_tips = [np.array(frames.wing["VTKHDF/Points"][tip :: len(mesh.nodes)])[chosen] for tip in mesh.tips]
    series = frames.run.series if frames.run else {"time": np.zeros(0)}
    begin, end = frames.times[chosen[0]], frames.times[chosen[-1]]
    rows = (series["time"] >= begin * (1 - 1e-9)) & (series["time"] <= end * (1 + 1e-9))
    paths = []
    for name, points in zip(wings(frames.scene), frames_of_tips, strict=True):
        columns = [f"{column_names(frames.scene)[name][0]}tip_u{axis}" for axis in "xyz"]
        if series.keys() >= set(columns) and rows.sum() >= len(chosen):
            moved = np.transpose([series[column][rows] for column in columns])
            points = points[0] + moved - moved[0]
        paths.append(points)
    return paths


def render(frames: Frames, chosen: list[int], limit: float) -> list[np.ndarray]:
    """Return pictures of the fluid in the frames `chosen`, `[height, width, 3]` of bytes."""
    figure, axes = frames.view.panels(WIDTH)
    figure.set_dpi(DPI)
    picture = flow.Picture(axes[0, 0], frames.view, limit)
    flow.colour_bar(figure, axes, picture.image, frames.view)

    def show(frame: int) -> None:
        boxes, fine = frames.fine_box(frame), frames.fine("vorticity", frame)
        picture.show(frames.vorticity(frame), frames.solids(frame), boxes, fine)
        picture.say(float(frames.times[frame]))

    return filmed(figure, chosen, show)


def filmed(figure: Figure, frames: Iterable[int], show: Callable[[int], None]) -> list[np.ndarray]:
    """Return a picture of the figure after each call of `show`, `[height, width, 3]` of bytes."""
    figure.set_dpi(DPI)
    canvas, pictures = FigureCanvasAgg(figure), []
    for frame in frames:
        show(frame)
        canvas.draw()
        pictures.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    return pictures


def write_gif(pictures: list[np.ndarray], path: Path, palette: np.ndarray | None = None, every: int = 1) -> None:
    """Write the pictures as an endless GIF with one palette and without dithering, so that still parts cost nothing.
    The usual palette is for the vorticity in a plane. Each picture stands for `every` frames."""
    if palette is None:
        scale = colormaps[flow.COLOUR_MAP](np.linspace(0, 1, COLOURS))[:, :3]
        greys = np.repeat(np.linspace(0, 1, GREYS)[:, None], 3, axis=1)
        palette = (255 * np.concatenate([scale, greys, [to_rgb(plots.BLUE)]])).round().astype(np.uint8)
    images = [Image.fromarray(_nearest(one, palette)) for one in pictures]
    for image in images:
        image.putpalette(palette.tobytes())
    shown = {"duration": every * FRAME_MS, "loop": 0, "optimize": True}
    images[0].save(path, "GIF", save_all=True, append_images=images[1:], **shown)


def _nearest(picture: np.ndarray, palette: np.ndarray) -> np.ndarray:
    """Return the number of the nearest colour of `palette` for each point. Pillow's own search tints white."""
    packed = picture.astype(np.int32) @ np.array([1 << 16, 1 << 8, 1], np.int32)
    found, places = np.unique(packed, return_inverse=True)
    colours = np.stack([found >> 16, found >> 8 & 255, found & 255], axis=-1)
    distances = ((colours[:, None] - palette.astype(np.int32)) ** 2).sum(axis=-1)
    nearest: np.ndarray = distances.argmin(axis=1).astype(np.uint8)[places].reshape(packed.shape)
    return nearest


def write_mp4(pictures: list[np.ndarray], path: Path) -> None:
    """Write H.264 in colours that every player shows; an odd last row or column is left out."""
    import imageio_ffmpeg

    height, width = (size // 2 * 2 for size in pictures[0].shape[:2])
    options: dict[str, Any] = {"fps": 1000 / FRAME_MS, "codec": "libx264", "pix_fmt_out": "yuv420p"}
    file = imageio_ffmpeg.write_frames(
        path, (width, height), macro_block_size=1, ffmpeg_log_level="error", output_params=["-f", "mp4"], **options
    )
    file.send(None)
    for one in pictures:
        file.send(np.ascontiguousarray(one[:height, :width]))
    file.close()
