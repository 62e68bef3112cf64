"""Animation and phases of a run with --fields-every.

vorticity.gif repeats the last whole periods without a seam, vorticity.mp4 shows them where imageio-ffmpeg is installed,
and phases.png has four phases of the last period. A rod alone has motion.png and motion.gif of the last period instead.
"""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from PIL import Image

from nervure.errors import InputError
from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series
from nervure.files import write_whole
from nervure.output import axis_label, fields, plots
from nervure.scene import beams, validate
from nervure.simulation import results
from nervure.simulation.results import BEAM_FIELDS, FLUID_FIELDS

PERIODS = 2  # Whole periods in the animation, unless times are given
PHASES = 4
FILM = 60  # Largest number of frames in motion.gif
SHAPES = 24  # Largest number of shapes in motion.png
WIDTH, DPI = 9.0, 100  # Width of the animation, in, and points an inch
FRAME_MS = 60  # Duration of a frame, ms
GREYS = 32  # Colours of the palette for text, axes and solids; the colour scale has the others


class Frames:
    """The frames in a result folder: times (s), vorticity, outlines of the beams."""

    def __init__(self, folder: Path):
        alone = not (folder / FLUID_FIELDS).exists() and (folder / BEAM_FIELDS).exists()
        self.fluid: Any = None if alone else h5py.File(folder / FLUID_FIELDS)
        first: Any = h5py.File(folder / BEAM_FIELDS) if alone else self.fluid
        self.scene = scene = validate(json.loads(first[fields.SCENE][()]))
        self.times = first["VTKHDF/Steps/Values"][: first["VTKHDF/Steps"].attrs["NSteps"]]
        self.beams: list[Any] = [h5py.File(folder / fields.beam_file(own))["VTKHDF"] for own in beams(scene)]
        self.moves = self._moves(results.read(folder).series) if scene.fluid and scene.fluid.bodies else []

    def _moves(self, series: Series) -> list[np.ndarray]:
        """Return position and angle of each body at the times of the frames, `[frames, 3]`, m and rad."""
        bodies = range(1, len(self.scene.fluid.bodies) + 1) if self.scene.fluid else ()
        of = [
            [np.interp(self.times, series["time"], series[f"body_{i}_{part}"]) for part in plots.POSE] for i in bodies
        ]
        return [np.transpose(parts) for parts in of]

    def poses(self, frame: int) -> list[list[float]]:
        """Return position and angle of each body."""
        return [move[frame].tolist() for move in self.moves]

    def vorticity(self, frame: int) -> np.ndarray:
        return np.array(self.fluid["VTKHDF/PointData/vorticity"][frame]).T

    def points(self, frame: int, beam: int = 0) -> np.ndarray:
        """Return the outline of a beam in the plane, or its centre line in space, `[n, 3]`."""
        n = self.beams[beam]["NumberOfPoints"][0]
        return np.array(self.beams[beam]["Points"][frame * n : (frame + 1) * n])

    def title(self, frame: int) -> str:
        return f"t = {self.times[frame]:.3f} {plots.unit('s', self.scene)}"

    def outlines(self, frame: int) -> list[np.ndarray]:
        return [self.points(frame, beam)[:, :2] for beam in range(len(self.beams))]

    def between(self, begin: float, end: float) -> list[int]:
        """Return the frames from `begin` to before `end` (s)."""
        return np.flatnonzero((self.times >= begin) & (self.times < end)).tolist()


def write(folder: Path, begin: float | None, end: float | None) -> list[Path]:
    """Write vorticity.gif and vorticity.mp4 of the times from `begin` to `end` (s), and phases.png, into a result
    folder; of a rod alone motion.png, motion.gif and motion.mp4. Return their paths."""
    try:
        frames = Frames(folder)
    except (OSError, KeyError) as error:
        raise InputError(f"{folder} holds no fields, which a run writes with --fields-every: {error}") from error
    try:
        window = results.read(folder).summary.window
    except InputError:
        window = None
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
    if frames.fluid is None:
        shown = chosen if begin is not None or end is not None else frames.between(last.begin, last.end)
        write_whole(folder / "motion.png", lambda path: motion(frames, shown, path))
        return [folder / "motion.png", *_films(folder / "motion", render_rod(frames, shown))]
    sampled = [frames.vorticity(frame) for frame in chosen[:: max(1, len(chosen) // 8)]]
    limit = plots.vorticity_limit(frames.scene, sampled)

    at = last.begin + (last.end - last.begin) * np.arange(PHASES) / PHASES
    nearest = [int(np.argmin(np.abs(frames.times - time))) for time in at]
    write_whole(folder / "phases.png", lambda path: phases(frames, nearest, limit, path))
    return [folder / "phases.png", *_films(folder / "vorticity", render(frames, chosen, limit))]


def _has_ffmpeg() -> bool:
    """Return whether imageio-ffmpeg is installed with a program for this system."""
    try:
        import imageio_ffmpeg

        return bool(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return False


def _films(path: Path, pictures: list[np.ndarray]) -> list[Path]:
    """Write the pictures as GIF and, with ffmpeg, as MP4; return the paths."""
    written = [path.with_suffix(".gif")]
    write_whole(written[0], lambda unfinished: write_gif(pictures, unfinished))
    if _has_ffmpeg():
        written.append(path.with_suffix(".mp4"))
        write_whole(written[1], lambda unfinished: write_mp4(pictures, unfinished))
    return written


def phases(frames: Frames, chosen: list[int], limit: float, path: Path) -> None:
    """Draw four frames with one colour scale: below each other, or two by two where the box is high."""
    columns = 2 if plots.size(frames.scene, WIDTH)[1] > WIDTH / 2 else 1
    _, height = plots.size(frames.scene, WIDTH / columns)
    rows = len(chosen) // columns
    figure = Figure(figsize=(WIDTH, (height - 0.5) * rows + 0.5), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True)
    for axis, frame in zip(axes.flat, chosen, strict=True):
        picture = plots.draw_vorticity(
            axis, frames.scene, frames.vorticity(frame), frames.outlines(frame), limit, frames.poses(frame)
        )
        axis.set_title(frames.title(frame), fontsize="medium")
        axis.label_outer()
    figure.colorbar(picture, ax=axes, label=plots.vorticity_label(frames.scene), extend="both", pad=0.01)
    figure.savefig(path, dpi=150)


def _rod_figure(frames: Frames, chosen: list[int]) -> tuple[Figure, list[Any], list[tuple[int, int]], Any, Any]:
    """Return a figure of a rod alone with axes for each view, one in the plane or three in space; the views as pairs of
    coordinates; the shapes, `[frames, points, 3]`; and the path of the tip, `[frames, 3]`."""
    shapes = np.array([frames.points(frame) for frame in chosen])
    in_space = bool(np.ptp(shapes[..., 2]))
    views = [(0, 1), (0, 2), (1, 2)] if in_space else [(0, 1)]
    figure = Figure(figsize=(4.2 * len(views) + 1, 4.6), layout="constrained")
    axes = list(figure.subplots(1, len(views), squeeze=False)[0])
    metre = plots.unit("m", frames.scene)
    for axis, (across, up) in zip(axes, views, strict=True):
        axis.set(xlabel=axis_label("xyz"[across], metre), ylabel=axis_label("xyz"[up], metre), aspect="equal")
        axis.locator_params(nbins=5)
    middle = shapes.shape[1] // 2
    return figure, axes, views, shapes, shapes[:, -1] if in_space else shapes[:, middle - 1 : middle + 1].mean(axis=1)


def render_rod(frames: Frames, chosen: list[int]) -> list[np.ndarray]:
    """Return pictures of a rod alone with the path of its tip, `[height, width, 3]` of bytes; at most `FILM`."""
    chosen = chosen[:: -(-len(chosen) // FILM)]
    figure, axes, views, shapes, tip = _rod_figure(frames, chosen)
    figure.set_dpi(DPI)
    canvas, lines, pictures = FigureCanvasAgg(figure), [], []
    for axis, (across, up) in zip(axes, views, strict=True):
        axis.plot(tip[:, across], tip[:, up], color="0.7", linewidth=0.8)
        (line,) = axis.plot(shapes[..., across].ravel(), shapes[..., up].ravel(), color=plots.BLUE, linewidth=1.5)
        axis.set(xlim=axis.get_xlim(), ylim=axis.get_ylim())
        lines.append(line)
    for frame, shape in zip(chosen, shapes, strict=True):
        for line, (across, up) in zip(lines, views, strict=True):
            line.set_data(shape[:, across], shape[:, up])
        figure.suptitle(frames.title(frame), fontsize="medium")
        canvas.draw()
        pictures.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    return pictures


def motion(frames: Frames, chosen: list[int], path: Path) -> None:
    """Draw a rod alone in the frames `chosen`, coloured by time, with the path of its tip."""
    figure, axes, views, shapes, tip = _rod_figure(frames, chosen)
    shown = np.unique(np.linspace(0, len(chosen) - 1, SHAPES).round().astype(int))
    times = Normalize(frames.times[chosen[0]], frames.times[chosen[-1]])
    for axis, (across, up) in zip(axes, views, strict=True):
        axis.plot(tip[:, across], tip[:, up], color="0.5", linewidth=0.8)
        for number in shown:
            colour = colormaps["viridis"](times(frames.times[chosen[number]]))
            axis.plot(shapes[number][:, across], shapes[number][:, up], color=colour, linewidth=1.0)
    key = ScalarMappable(times, "viridis")
    figure.colorbar(key, ax=axes, label=axis_label("t", plots.unit("s", frames.scene)), pad=0.01)
    figure.suptitle("the rod, and in grey the path of its tip", fontsize="medium")
    figure.savefig(path, dpi=150)


def render(frames: Frames, chosen: list[int], limit: float) -> list[np.ndarray]:
    """Return the frames as pictures, `[height, width, 3]` of bytes."""
    figure = Figure(figsize=plots.size(frames.scene, WIDTH), dpi=DPI, layout="constrained")
    canvas, axis = FigureCanvasAgg(figure), figure.subplots()
    bar, pictures = None, []
    for frame in chosen:
        axis.clear()
        picture = plots.draw_vorticity(
            axis, frames.scene, frames.vorticity(frame), frames.outlines(frame), limit, frames.poses(frame)
        )
        axis.set_title(frames.title(frame), fontsize="medium")
        bar = bar or figure.colorbar(picture, label=plots.vorticity_label(frames.scene), extend="both", pad=0.01)
        canvas.draw()
        pictures.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    return pictures


def write_gif(pictures: list[np.ndarray], path: Path) -> None:
    """Write an endless GIF. One palette without dithering: still parts need no bytes."""
    scale = colormaps[plots.COLOUR_MAP](np.linspace(0, 1, 256 - GREYS))[:, :3]
    greys = np.repeat(np.linspace(0, 1, GREYS)[:, None], 3, axis=1)
    palette = Image.new("P", (1, 1))
    palette.putpalette((255 * np.concatenate([scale, greys])).round().astype(np.uint8).tobytes())
    images = [Image.fromarray(one).quantize(palette=palette, dither=Image.Dither.NONE) for one in pictures]
    images[0].save(path, "GIF", save_all=True, append_images=images[1:], duration=FRAME_MS, loop=0, optimize=True)


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
