"""Pictures of runs: what sets a scale, what things are called, and that nothing lies on anything else."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

import nervure
from nervure.evaluate import statistics
from nervure.output import animation, plots
from nervure.scene import validate
from studies import limits

pytestmark = pytest.mark.usefixtures("libraries")


@pytest.fixture
def drawn(monkeypatch, tmp_path):
    """Function that runs a scene and returns its pictures by name, laid out."""

    def draw(scene):
        figures = {}

        def save(figure, path):
            FigureCanvasAgg(figure).draw()
            figures[path.name] = figure
            return path

        monkeypatch.setattr(plots, "_save", save)
        nervure.run(validate(scene), tmp_path / "run", quiet=True)
        return figures

    return draw


@pytest.fixture
def pitching():
    """Three periods of a driven root."""
    scene = limits.small_pitching()
    scene["time"]["end"] = 3.1
    scene["display"] = {"length": "chords", "time": "periods"}
    return scene


def test_nothing_lies_on_anything_else_and_lengths_are_in_chords(drawn, pitching):
    figures = drawn(pitching)
    assert {"tip.png", "drag.png", "lift.png", "flapping.png", "vorticity.png"} == figures.keys()
    for name, figure in figures.items():
        legends = [*figure.legends, *(legend for axis in figure.axes if (legend := axis.get_legend()))]
        for axis in figure.axes:
            for legend in legends:
                assert not legend.get_window_extent().overlaps(axis.patch.get_window_extent().padded(-1)), name
            for ticks in (axis.xaxis, axis.yaxis):
                low, high = sorted(ticks.get_view_interval())
                ticked = [tick for tick in ticks.get_major_ticks() if low <= tick.get_loc() <= high]
                labels = [tick.label1 for tick in ticked if tick.label1.get_visible() and tick.label1.get_text()]
                shown = [label.get_window_extent() for label in labels]
                assert not any(one.overlaps(other) for one, other in pairwise(shown)), name
    path, tip, force, power = figures["flapping.png"].axes
    assert path.get_xlabel() == "tip ux [chords]" and tip.get_xlabel() == force.get_xlabel() == "t/T"
    assert [text.get_text() for text in tip.get_legend().get_texts()] == ["rigid", "flexible"]
    assert [text.get_text() for text in force.get_legend().get_texts()] == ["thrust", "lift"]
    assert power.get_ylabel() == "power"
    assert figures["vorticity.png"].axes[0].get_ylabel() == "y [chords]"
    assert figures["vorticity.png"].axes[1].get_ylabel() == "vorticity [1/periods]"
    assert figures["tip.png"].axes[-1].get_xlabel() == "time [periods]"


def test_a_peak_at_the_start_does_not_set_the_scale(rod_only, tmp_path):
    run = nervure.run(validate(rod_only), tmp_path, quiet=True)
    time = np.linspace(0, 10, 5001)
    values = np.sin(2 * np.pi * time)
    window = statistics.find_window(time, values)
    values[:20] = 40.0
    summary = type(run.summary)(
        **vars(run.summary) | {"window_s": (window.begin, window.end), "periods": window.periods}
    )
    made = nervure.Run(run.facts, run.folder, summary, {"time": time, "tip_uy": values}, run.units)
    low, high = plots.over_time({"run": made}, ["tip_uy"]).axes[0].get_ylim()
    assert -1300 < low < -1000 and 1000 < high < 1300, (low, high)  # mm
    values[:20] = 2.0
    _, high = plots.over_time({"run": made}, ["tip_uy"]).axes[0].get_ylim()
    assert high > 2000, "a peak that leaves the rest readable is shown"


@pytest.mark.filterwarnings("default")  # for the pipes that imageio-ffmpeg leaves to the garbage collector
def test_a_film_is_written_as_mp4(tmp_path):
    """Of odd numbers of points, which H.264 does not have."""
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    pictures = [np.full((101, 203, 3), shade, np.uint8) for shade in (0, 255, 0, 255)]
    animation.write_mp4(pictures, tmp_path / "film.mp4")
    reader = imageio_ffmpeg.read_frames(tmp_path / "film.mp4")
    about, *frames = reader
    assert about["size"] == (202, 100) and about["codec"] == "h264" and len(frames) == 4
    assert np.frombuffer(frames[1], np.uint8).mean() > 240
    animation.write_gif(pictures, tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as film:
        assert film.size == (203, 101)


def test_a_rod_alone_moves_in_its_frame(rod_only, tmp_path):
    run = nervure.run(validate(rod_only), tmp_path, fields_every=1e-3, quiet=True)
    written = {path.name for path in run.animate()}
    assert {"motion.png", "motion.gif"} <= written
    with Image.open(tmp_path / "motion.gif") as film:
        assert film.n_frames == 11  # type: ignore[attr-defined]
        ink = [np.asarray(film.convert("L")) < 200 for _ in [film.seek(n) for n in (0, 10)]]
    frames = animation.render_rod(animation.Frames(tmp_path), list(range(11)))
    assert (frames[0] != frames[10]).any() and ink[0].any()
