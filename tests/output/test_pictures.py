"""Pictures of runs: what sets a scale, what things are called, and that nothing lies on anything else."""

import json
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from PIL import Image

import nervure
from nervure.errors import InputError
from nervure.evaluate import benchmark, statistics
from nervure.output import (
    animation,
    console,
    displayed_unit,
    flow,
    in_words,
    layout,
    lengths_in,
    plots,
    sweeps,
    title,
    unit_in,
)
from nervure.scene import validate
from nervure.scene.facts import Facts
from nervure.scene.types import Display, PublishedQuantity, Reference
from nervure.simulation.sweep import FINISHED
from studies import limits
from tests.conftest import nervure as command

pytestmark = [pytest.mark.usefixtures("libraries"), pytest.mark.pictures]


@pytest.fixture
def figures(monkeypatch):
    """Figures by the names of the files that are written, laid out."""
    found = {}

    def save(figure, path):
        figure.set_dpi(plots.DPI)
        FigureCanvasAgg(figure).draw()
        found[path.name] = figure
        return path

    monkeypatch.setattr(plots, "save", save)
    return found


@pytest.fixture
def pitching():
    """Three periods of a driven root."""
    scene = limits.small_pitching()
    scene["time"]["end"] = 3.1
    scene["display"] = {"length": "chords", "time": "periods"}
    return scene


@pytest.fixture
def periodic(fluid_only, tmp_path):
    """Function that makes a run over 10 s whose tip and drag are given, with ten periods but for the start-up."""
    run = nervure.run(validate(fluid_only), tmp_path, quiet=True)
    time = np.linspace(0, 10, 5001)
    window = statistics.find_window(time, np.sin(2 * np.pi * time))
    around = {"window_s": (window.begin, window.end), "periods": window.periods}

    def make(series, **other):
        summary = type(run.summary)(**vars(run.summary) | around | other)
        units = dict(run.units) | {"tip_uy": "m"}
        return nervure.Run(run.facts, run.folder, summary, {"time": time, **series}, units)

    return time, make


def check_labels(figure, name):
    """No label of a tick lies on another one of the picture, and no legend on an axis."""
    legends = [*figure.legends, *(legend for axis in figure.axes if (legend := axis.get_legend()))]
    shown = []
    for axis in figure.axes:
        for legend in legends:
            assert not legend.get_window_extent().overlaps(axis.patch.get_window_extent().padded(-1)), name
        for ticks in (axis.xaxis, axis.yaxis):
            low, high = sorted(ticks.get_view_interval())
            ticked = [tick for tick in ticks.get_major_ticks() if low <= tick.get_loc() <= high]
            labels = [label for tick in ticked for label in (tick.label1, tick.label2)]
            shown += [label for label in labels if axis.axison and label.get_visible() and label.get_text()]
    for one, other in combinations(shown, 2):
        overlap = one.get_window_extent().overlaps(other.get_window_extent())
        assert not overlap, (name, one.get_text(), other.get_text())


def check_bar(figure, name):
    """The colour bar, the last axes, is as high as the other axes together."""
    *axes, bar = figure.axes
    outline = bar._colorbar.outline.get_window_extent()
    low = min(axis.get_window_extent().y0 for axis in axes)
    high = max(axis.get_window_extent().y1 for axis in axes)
    assert outline.y0 == pytest.approx(low, abs=1) and outline.y1 == pytest.approx(high, abs=1), name


def test_pictures_of_a_run(figures, pitching, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(console, "FILE_INTERVAL", 0.5)
    run = nervure.run(validate(pitching), tmp_path / "run", fields_every=0.125)
    shown = capsys.readouterr().out
    told = [words in shown for words in ("left, tip_ux", "tip_uy mean [chords]", "phase lag [deg]", " mm")]
    assert told == [True, True, True, False], shown
    run.animate()
    assert {"tip.png", "drag.png", "lift.png", "flapping.png", "vorticity.png", "phases.png"} == figures.keys()
    for name, figure in figures.items():
        check_labels(figure, name)
    for name in ("vorticity.png", "phases.png"):
        check_bar(figures[name], name)
    path, tip, force, power = figures["flapping.png"].axes
    assert path.get_xlabel() == "tip, along x [chords]" and tip.get_xlabel() == force.get_xlabel() == "t/T"
    assert [text.get_text() for text in tip.get_legend().get_texts()] == ["rigid", "flexible"]
    assert [text.get_text() for text in force.get_legend().get_texts()] == ["thrust", "lift"]
    assert power.get_ylabel() == "power"
    assert figures["vorticity.png"].axes[0].get_ylabel() == "y [chords]"
    assert figures["vorticity.png"].axes[-1].get_ylabel() == "vorticity [1/periods]"
    assert figures["tip.png"].axes[-1].get_xlabel() == "time [periods]"
    with Image.open(tmp_path / "run" / "vorticity.gif") as film:
        assert film.width >= 720 and (tmp_path / "run" / "vorticity.gif").stat().st_size < 3e6


def test_the_start_up_does_not_set_an_axis_and_is_said(periodic):
    time, make = periodic
    values = np.sin(2 * np.pi * time)
    values[:20] = 2.0
    axis = plots.over_time({"run": make({"tip_uy": values})}, ["tip_uy"]).axes[0]
    low, high = axis.get_ylim()
    assert -1.2 < low < -1 and 1 < high < 1.2, (low, high)
    assert axis.get_title(loc="right") == "clipped: -1 to 2 m"

    axis = plots.over_time({"run": make({"tip_uy": values}, periods=0)}, ["tip_uy"]).axes[0]
    assert axis.get_ylim()[1] > 2 and not axis.get_title(loc="right"), "without periods all of the run is seen"


def test_the_published_band_covers_the_window_only(periodic):
    time, make = periodic
    run = make({"tip_uy": np.sin(2 * np.pi * time)})
    band = PublishedQuantity(unit="m", mean=0.0, amplitude=0.9)
    reference = Reference(source="a paper", quantities={"tip_uy": band})
    for axis in plots.over_time({"run": run}, ["tip_uy"], reference).axes:
        (drawn,) = axis.collections
        extent = drawn.get_paths()[0].get_extents()
        assert (extent.x0, extent.x1) == run.summary.window_s and extent.y1 == pytest.approx(0.9)


def test_runs_in_several_units_do_not_share_an_axis(periodic):
    time, make = periodic
    plane, space = (make({"drag": np.sin(2 * np.pi * time)}) for _ in range(2))
    space.units["drag"] = "N"
    axes = plots.over_time({"plane": plane, "space": space}, ["drag"]).axes
    labelled = [axis for axis in axes if axis.get_ylabel()]
    assert [axis.get_ylabel() for axis in labelled] == ["drag [N/m]", "drag [N]"]
    assert [len(axis.lines) for axis in labelled] == [2, 2], "raw and filtered"
    scene = space.scene.copy({"display": {"length": "chords", "time": "periods"}})
    other = nervure.Run(Facts(scene), space.folder, space.summary, space.series, space.units)
    with pytest.raises(InputError, match="other units of length and time"):
        plots.over_time({"plane": plane, "other": other}, ["drag"])


@pytest.mark.parametrize(("mean", "shown"), [(0.8, "lift_mean"), (0.01, "lift_amplitude")])
def test_a_sweep_shows_of_a_lift_what_is_larger(mean, shown):
    row = {"status": FINISHED, "drag_mean": 1.0, "drag_amplitude": 0.1, "lift_mean": mean, "lift_amplitude": 0.2}
    found = sweeps._quantities([row | {"side_mean": 0.0, "side_amplitude": 0.0}])
    assert [name for name, *_ in found[:2]] == ["drag_mean", shown] and {unit for *_, unit in found} == {"N"}, found


def test_a_changed_benchmark_has_neither_its_title_nor_its_values(periodic):
    shipped = nervure.load("flag-line-480x240")
    finer, other = (
        shipped.copy({"name": "my-flag", **changed})
        for changed in ({"fluid.box.cells": [640, 320]}, {"fluid.kinematic_viscosity": 0.005})
    )
    assert title(finer, 9) == title(shipped, 9) and benchmark.reference(finer) == shipped.reference is not None
    assert title(other, 9) == "my flag" and benchmark.reference(other) is None
    time, make = periodic
    run = make({"tip_uy": np.sin(2 * np.pi * time)})
    for scene, bands in ((finer, 2), (other, 0)):
        figure = nervure.Run(Facts(scene), run.folder, run.summary, run.series, run.units).plot("tip_uy")
        assert sum(len(axis.collections) for axis in figure.axes) == bands, scene.name


def test_a_unit_of_time_with_a_stroke_has_brackets():
    display = Display(length="flag lengths", time="L/U")
    found = [displayed_unit(unit, display)[0] for unit in ("s", "1/s", "m/s", "rad", "N")]
    assert found == ["L/U", "1/(L/U)", "flag lengths/(L/U)", "rad", ""], found


def test_a_force_is_drawn_filtered_over_the_raw_one(periodic):
    time, make = periodic
    smooth, hash_ = np.sin(2 * np.pi * time), 0.3 * np.sin(2 * np.pi * 50 * time)
    figure = plots.over_time({"run": make({"drag": smooth + hash_})}, ["drag"])
    raw, filtered = figure.axes[0].lines
    assert raw.get_alpha() < 0.5 and filtered.get_alpha() is None
    inside = (time > 0.1) & (time < 9.9)
    assert np.abs(raw.get_ydata() - smooth)[inside].max() > 0.28
    assert np.abs(filtered.get_ydata() - smooth)[inside].max() < 0.02
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["as computed", "mean over 0.04 s"]


def test_walls_and_solids_do_not_set_the_colour_scale(small_fsi3):
    scene = validate(small_fsi3)
    (x0, x1), (y0, y1) = scene.fluid.box.x, scene.fluid.box.y
    nx, ny, *_ = scene.fluid.box.cells
    x, y = np.meshgrid(np.linspace(x0, x1, nx, False), np.linspace(y0, y1, ny, False), indexing="ij")
    (cylinder,) = scene.fluid.cylinders
    cell = max((x1 - x0) / nx, (y1 - y0) / ny)
    from_cylinder = np.hypot(x - cylinder.center[0], y - cylinder.center[1]) - cylinder.radius
    assert scene.fluid.channel.y
    low, high = scene.fluid.channel.y
    near = (from_cylinder < 1.9 * cell) | (y < low + 1.9 * cell) | (y > high - 1.9 * cell)
    field = np.where(near, 1000.0, 1.0)
    assert flow.View(scene).colour_limit([(field, flow.View(scene).outlines([], []))]) == 1.0
    assert flow.View(scene).colour_limit([(field, [])]) == 1000.0


def test_a_solid_covers_the_field_inside_it(small_fsi3):
    scene = validate(small_fsi3)
    assert scene.fluid
    figure, axes = flow.View(scene).panels(plots.WIDTH)
    figure.set_dpi(50)
    picture = flow.Picture(axes[0, 0], flow.View(scene), 1.0)
    picture.show(np.ones(scene.fluid.box.cells), flow.View(scene).outlines([], []))
    (patch,) = picture.patches
    (cylinder,) = scene.fluid.cylinders
    ends, diameter = patch.get_path().get_extents(), 2e3 * cylinder.radius
    assert (ends.width, ends.height) == pytest.approx((diameter, diameter), rel=1e-3)
    assert patch.get_facecolor() == to_rgba(flow.SOLID) and patch.get_edgecolor() == to_rgba(flow.EDGE)
    left, right, bottom, top = flow.View(scene).extent
    box = axes[0, 0].get_window_extent()
    assert box.width / box.height == pytest.approx((right - left) / (top - bottom)), "true proportions"


def test_a_cylinder_that_moves_is_drawn_in_its_place(fluid_only, tmp_path):
    law = {"sine": {"amplitude": 0.1, "frequency": 10.0}}
    fluid_only["fluid"]["cylinders"] = [{"center": [0.0, -0.1], "radius": 0.15, "motion": {"y": law}}]
    run = nervure.run(validate(fluid_only), tmp_path, fields_every=0.01, quiet=True)
    frames = animation.Frames(run.folder)
    for frame, time in enumerate(frames.times):
        (outline,) = frames.solids(frame)
        place, expected = outline.mean(axis=0), (0.0, -0.1 + 0.1 * np.sin(2 * np.pi * 10 * time))
        assert place == pytest.approx(expected, abs=1e-9), (time, place, expected)


def test_between_grid_points_the_fourier_series_is_averaged_over_two_cells():
    n, ends, places = 32, (-1.0, 3.0), np.linspace(-1.0, 2.9, 57)
    grid = np.linspace(*ends, n, endpoint=False)

    def wave(x, order):
        return np.cos(2 * np.pi * order * (x + 0.3) / 4)

    cell = 4 / n
    for order in (0, 1, 5, 11):
        offsets = np.linspace(-cell, cell, 20001)
        mean = np.trapezoid(wave(places[:, None] + offsets, order), offsets, axis=1) / (2 * cell)
        assert flow.resample(wave(grid, order), ends, places) == pytest.approx(mean, abs=1e-7)
    stripes = (-1.0) ** np.arange(n)
    assert np.abs(flow.resample(stripes, ends, places)).max() < 1e-12, "what changes sign at each point is gone"


def test_words_and_units_of_a_picture(small_fsi3, rod_only):
    channel, alone = validate(small_fsi3), validate(rod_only)
    assert in_words("tip_uy", channel) == "tip, across" and in_words("upper_tip_ux", channel) == "upper: tip, along"
    assert in_words("tip_uz", alone) == "tip, along z" and in_words("root_power", alone) == "root power"
    assert lengths_in(channel, 2.5) == ("mm", 1e3) and lengths_in(channel, 25.0) == ("m", 1.0)
    told = channel.model_copy(update={"description": "A bar, which bends: in water.", "name": "bar-2"})
    assert title(told, 9) == "A bar" and title(told.model_copy(update={"description": ""}), 9) == "bar 2"
    assert len(title(told.model_copy(update={"description": "long " * 40}), 4.0)) <= 58
    assert not any(title(told, room) for room in (-1.0, 0.0, 0.1)), "the picture of a tall box is narrow"


def test_a_scene_in_numbers_of_order_1_has_no_millimetres():
    named = {"flag-line-480x240": "m", "sphere-stream-144x96x96": "m", "vein-3d": "m", "wing-hover-64x64x84": "m"}
    for name, expected in (named | {"csm3": "mm", "fsi3-325x72": "mm", "rod-hanging-160x160x48": "mm"}).items():
        scene = nervure.load(name)
        assert lengths_in(scene, 0.01)[0] == expected, (name, lengths_in(scene, 0.01))
        assert unit_in(scene, "N", 0.01) == ("N", 1.0)


def test_a_sponge_is_marked_where_it_is_seen():
    scene = nervure.load("flag-line-480x240")
    assert scene.fluid and scene.fluid.sponge
    begin = scene.fluid.sponge.x[0]
    for crop, marks in ((None, ["sponge"]), ([-0.5, begin - 0.1, -0.5, 0.5], [])):
        view = flow.View(scene, crop=crop)
        _, axes = view.panels(plots.WIDTH)
        flow.Picture(axes[0, 0], view, 1.0)
        assert [text.get_text() for text in axes[0, 0].texts] == marks, crop
        assert [line.get_xdata()[0] for line in axes[0, 0].lines] == [begin] * len(marks)
    with pytest.raises(InputError, match="inside the box -1, 4, -1.25, 1.25"):
        flow.View(scene, crop=[-9.0, 1.0, -1.0, 1.0])
    with pytest.raises(InputError, match="two dimensions"):
        flow.View(scene, across="z")


def test_pictures_are_written_as_vectors(periodic, tmp_path):
    time, make = periodic
    wave = np.sin(2 * np.pi * time)
    plots.write(tmp_path, [make({"drag": wave, "lift": wave})], "svg")
    assert b"<svg" in (tmp_path / "drag.svg").read_bytes()
    for folder, form in ((tmp_path, "pdf"), (tmp_path, "bmp")):
        done = command("plot", folder, "--format", form)
        assert done.returncode == (0 if form == "pdf" else 2), done.stderr
    assert (tmp_path / "drag.pdf").read_bytes().startswith(b"%PDF") and "png, svg, pdf" in done.stderr


def test_a_sweep_over_grids_has_the_cell_size_as_axis(figures, tmp_path):
    rows, scene = [], nervure.load("plate-stream-96x72x72")
    for n in (1, 2, 3):
        cells = [24 * n, 18 * n, 18 * n]
        (tmp_path / f"{n}").mkdir()
        text = json.dumps(scene.copy({"fluid.box.cells": cells}).document())
        (tmp_path / f"{n}" / "scene.json").write_text(text)
        step = {"time.communication_step": 0.1 / n}  # Changes together with the grid
        rows.append(
            {"folder": f"{n}", "scene": "plate", **step, sweeps.GRID: cells, "status": FINISHED, "drag_mean": 1.0 * n}
        )
    sweeps.plot(tmp_path, rows)
    axis = figures["sweep.png"].axes[0]
    assert axis.get_xlabel() == "cell size [m]" and axis.get_ylabel() == "drag, mean [N]"
    assert axis.lines[0].get_xdata() == pytest.approx([8 / 72, 8 / 48, 8 / 24])


def test_a_logarithmic_axis_has_the_lines_of_its_decades(figures, tmp_path):
    values = [4.0, 8.0, 16.0, 32.0, 64.0]
    rows = [
        {"folder": f"{value}", "scene": "bar", "beam.segments": value, "status": FINISHED, "st": value}
        for value in values
    ]
    sweeps.plot(tmp_path, rows)
    axis = figures["sweep.png"].axes[0]
    assert axis.get_xscale() == "log" and list(axis.get_xticks()) == values
    assert {5, 6, 7, 9, 10, 20, 30, 40, 50, 60} <= {round(float(tick)) for tick in axis.get_xticks(minor=True)}
    check_labels(figures["sweep.png"], "sweep.png")


@pytest.mark.parametrize("values", [[1.0, 1.1, 1.2, 40.0, 45.0], [float(n) for n in range(100000, 100040)]])
def test_labels_of_a_sweep_do_not_overlap(figures, tmp_path, values):
    rows = [
        {"folder": f"{n}", "scene": "bar", "rod.damping": value, "status": FINISHED, "tip_uy_mean": -0.01 * n}
        for n, value in enumerate(values)
    ]
    sweeps.plot(tmp_path, rows)
    (axis,) = figures["sweep.png"].axes
    check_labels(figures["sweep.png"], "sweep.png")
    assert axis.get_ylabel() == "tip, along y: mean [mm]" and axis.get_ylim()[0] < -10 * (len(values) - 1)


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
    still = np.full((20, 20, 3), 247, np.uint8)  # no vorticity
    animation.write_gif([still, pictures[0][:20, :20]], tmp_path / "still.gif")
    with Image.open(tmp_path / "still.gif") as film:
        assert np.ptp(np.asarray(film.convert("RGB"))[5, 5]) <= 1, "no tint"


def test_a_rod_alone_moves_in_its_frame(rod_only, tmp_path):
    run = nervure.run(validate(rod_only), tmp_path, fields_every=1e-3, quiet=True)
    written = {path.name for path in run.animate()}
    assert {"motion.png", "motion.gif"} <= written
    with Image.open(tmp_path / "motion.gif") as film:
        assert film.n_frames == 11  # type: ignore[attr-defined]
        ink = [np.asarray(film.convert("L")) < 200 for _ in [film.seek(n) for n in (0, 10)]]
    frames = animation.render_rod(animation.Frames(tmp_path), list(range(11)))
    assert (frames[0] != frames[10]).any() and ink[0].any() and frames[0].shape[1] >= 720


def test_a_rod_in_space_is_seen_from_three_sides_to_one_scale(figures, rod_only, tmp_path):
    rod_only["beam"]["root"]["at"] = {"position": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    rod_only["rod"]["gravity"] = [0.0, -1.0, -2.0]
    run = nervure.run(validate(rod_only), tmp_path, fields_every=1e-3, quiet=True)
    run.animate()
    figure = figures["motion.png"]
    check_labels(figure, "motion.png")
    check_bar(figure, "motion.png")
    views = [axis for axis in figure.axes[:-1] if axis.axison]
    assert len(views) == 3
    scales = []
    for axis in views:
        box = axis.get_window_extent()
        scales += [box.width / np.ptp(axis.get_xlim()), box.height / np.ptp(axis.get_ylim())]
        (path,) = axis.collections
        assert len(path.get_segments()) == len(run.series["time"]) - 1, "over the whole run"
        points = np.concatenate([*path.get_segments(), *(line.get_xydata() for line in axis.lines)])
        low, high = np.transpose([axis.get_xlim(), axis.get_ylim()])
        assert (points >= low).all() and (points <= high).all()
    assert scales == pytest.approx([scales[0]] * 6)
    bottom, tip = min(axis.get_ylim()[0] for axis in views), 1e3 * run.series["tip_uz"].min()
    assert bottom < tip


def test_axes_in_true_proportions_fit_into_the_width():
    for columns, rows in (([1.0], [20.0]), ([30.0], [1.0]), ([1.0, 2.0], [2.0, 0.5])):
        figure, axes = layout.grid(7.5, columns, rows)
        assert figure.get_figwidth() == 7.5 and sum(axis.get_position().height for axis in axes[:, 0]) < 1
        for (row, column), axis in np.ndenumerate(axes):
            box = axis.get_window_extent()
            assert box.width / box.height == pytest.approx(columns[column] / rows[row])
