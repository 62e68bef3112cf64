"""Runs through the command line: one unit alone, foreign units, interruption."""

import json
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest

import nervure
from nervure.scene import validate
from nervure.units import package
from nervure.units.describe import describe
from nervure.units.fmu import Unit
from tests.conftest import FSI3, TOOL, run_scene

TABLES = ("scene.json", "series.csv", "summary.json")

pytestmark = pytest.mark.usefixtures("libraries")


def run(tmp_path, scene, *arguments):
    """Run a scene given as a dict; returns its series by column name and its summary."""
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene))
    done = run_scene(path, "--output", tmp_path / "results", "--force", *arguments)
    assert done.returncode == 0, done.stderr
    return results(tmp_path / "results")


def results(folder):
    series = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
    return series, json.loads((folder / "summary.json").read_text())


def files(folder):
    return {path.name for path in folder.iterdir()}


@pytest.mark.pictures
def test_a_rod_alone_falls_freely_until_it_feels_its_clamp(rod_only, tmp_path):
    series, summary = run(tmp_path, rod_only)
    assert summary["completed"] and summary["steps"] == 100
    fallen = -0.5 * 2.0 * series["time"][-1] ** 2
    assert series["tip_uy"][-1] == pytest.approx(fallen, rel=0.01)
    assert files(tmp_path / "results") == {"falling-rod-rod.fmu", "tip.png", *TABLES}


@pytest.mark.parametrize("push", [0.0, 1e-3])
def test_work_and_motion_of_rounding_are_not_judged(push, tmp_path, capsys):
    """A neutral rod in still fluid, and one in a weak stream."""
    scene = {
        "name": "neutral",
        "time": {"end": 0.2, "communication_step": 0.005},
        "fluid": {
            "density": 1.0,
            "kinematic_viscosity": 0.01,
            "box": {"x": [-2, 2], "y": [-1, 1], "cells": [64, 32]},
            "mask": {"log_linear": {"c_eta": 1e-4}},
            "time_stepping": {"max_step": 0.005, "max_cfl": 0.4},
            "initial_velocity": [0.0, push],
            "mean_flow": {"y": {"constant": push}},
        },
        "beam": {
            "root": {"at": {"position": [-0.5, 0.0], "direction": [1, 0]}},
            "length": 1.0,
            "thickness": 0.2,
            "segments": 12,
        },
        "rod": {
            "material": {"plane_strain": {"density": 1.0, "youngs_modulus": 1000.0, "poisson_ratio": 0.3}},
            "gravity": [0, -3.0],
            "root": "clamped",
        },
    }
    summary = nervure.run(validate(scene), tmp_path).summary
    is_judged = "interface: work on the rod" in capsys.readouterr().out
    states = {summary.quantities[name].state for name in ("tip_ux", "tip_uy")}
    assert is_judged == (summary.interface.imbalance is not None) == ("rounding" not in states) == (push > 0), summary


@pytest.mark.pictures
def test_a_symmetric_flow_has_drag_and_no_lift(fluid_only, tmp_path):
    series, summary = run(tmp_path, fluid_only)
    assert summary["completed"] and summary["steps"] == 20
    drag, lift = series["drag"][-1], series["lift"][-1]
    assert drag > 0
    assert abs(lift) < 1e-9 * drag
    pictures = {"drag.png", "lift.png", "vorticity.png", "coefficients.png"}
    assert files(tmp_path / "results") == {"cylinder-in-a-stream-fluid.fmu", *pictures, *TABLES}


def test_a_rigid_beam_in_the_fluid_needs_no_rod(small_fsi3, tmp_path):
    del small_fsi3["rod"], small_fsi3["coupling"]
    series, summary = run(tmp_path, small_fsi3, "--end-time", "0.01")
    assert summary["steps"] == round(0.01 / small_fsi3["time"]["communication_step"])
    assert series["drag"][-1] > 0
    assert "tip_uy" not in series.dtype.names


def test_iterated_and_explicit_coupling_agree_where_both_hold(small_fsi3, tmp_path):
    small_fsi3["fluid"]["mask"] = {"cosine": {"c_eta": 1e-3, "half_width": 1.0}}
    tips = {}
    for scheme in ("explicit", {"iterated": {"tolerance": 1e-4, "max_iterations": 50}}):
        small_fsi3["coupling"] = {"load": "pressure_jump", "scheme": scheme}
        series, summary = run(tmp_path, small_fsi3, "--end-time", "0.05")
        tips[str(scheme)] = series["tip_ux"][-1]
    assert 1 < summary["iterations_mean"] < 20
    explicit, iterated = tips.values()
    assert iterated == pytest.approx(explicit, rel=0.05)


def test_single_precision_runs_like_double(small_fsi3, tmp_path):
    double, _ = run(tmp_path, small_fsi3, "--end-time", "0.05")
    small_fsi3["fluid"]["precision"] = "single"
    single, _ = run(tmp_path, small_fsi3, "--end-time", "0.05")
    for name in ("tip_ux", "tip_uy", "drag", "lift"):
        far = np.abs(single[name] - double[name]).max() / np.abs(double[name]).max()
        assert 0 < far < 1e-3, (name, far)


def test_the_end_time_is_reached_by_a_shorter_last_step(rod_only, tmp_path):
    series, summary = run(tmp_path, rod_only, "--end-time", "0.00025")
    assert summary["steps"] == 3
    assert series["time"][-1] == pytest.approx(0.00025, rel=1e-12)


def test_a_series_is_sampled_from_the_same_run(small_fsi3, tmp_path):
    """With guards, which need the powers in every step, and with probes of pressure."""
    small_fsi3["fluid"]["probes"] = [{"name": "wake", "position": [1.0, 0.2]}]
    small_fsi3["coupling"]["guards"] = {"window_steps": 5}
    whole, _ = run(tmp_path, small_fsi3, "--end-time", "0.02")
    part, summary = run(tmp_path, small_fsi3, "--end-time", "0.02", "--series-every", "0.004")
    assert summary["steps"] == 50 and part.size == 6
    for name in part.dtype.names:
        assert (part[name] == whole[name][::10]).all(), name


@pytest.mark.parametrize("name", ["series_every", "fields_every"])
@pytest.mark.parametrize(
    ("interval", "made"), [(2.5e-3, "0.002"), (4e-4, "0.001"), (0.0, None), (1e-3, None), (5e-3, None), (1.0, None)]
)
def test_an_interval_of_no_whole_steps_is_told(name, interval, made, fluid_only, tmp_path, capsys):
    """Of steps of 1 ms in a run of 20 ms."""
    run = nervure.run(validate(fluid_only), tmp_path, **{name: interval})
    told = [text for text in run.summary.warnings or () if name in text]
    said = f"`{name}` is {interval:g} s, but a multiple of the 0.001 s of a step is taken: {made} s"
    assert told == ([said] if made else []) and (said in capsys.readouterr().err) == bool(made)


def test_guards_watch_every_step_of_a_sampled_run(small_fsi3, tmp_path):
    small_fsi3["coupling"]["guards"] = {"window_steps": 5, "largest_imbalance": 1e-6}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    options = ["--output", tmp_path / "results", "--end-time", "0.02", "--quiet", "--force"]
    whole = run_scene(path, *options)
    part = run_scene(path, *options, "--series-every", "0.008")
    assert whole.returncode == part.returncode == 1 and whole.stderr == part.stderr, (whole.stderr, part.stderr)


def test_outputs_are_read_only_for_rows_that_are_recorded(fluid_only, tmp_path, monkeypatch):
    read = []
    monkeypatch.setattr(Unit, "get", lambda self, get=Unit.get: read.append(self.name) or get(self))
    scene = validate(fluid_only)
    nervure.run(scene, tmp_path / "a", quiet=True)
    every = len(read)
    nervure.run(scene, tmp_path / "b", quiet=True, series_every=0.01)
    assert every == 21 and len(read) - every == 4  # at the start twice, and at two of the 20 steps


def test_a_long_series_is_written_with_all_its_digits(rod_only, tmp_path, monkeypatch):
    monkeypatch.setattr("nervure.simulation.results.LONG", 100)
    scene = validate(rod_only)
    done = nervure.run(scene, tmp_path, quiet=True)
    with h5py.File(tmp_path / "series.h5") as file:
        assert list(file) == list(done.series) and file["tip_uy"].attrs["unit"] == "m"
        assert (file["tip_uy"][:] == done.series["tip_uy"]).all()
    again = nervure.read(tmp_path)
    assert all((again.series[name] == values).all() for name, values in done.series.items())
    nervure.run(scene, tmp_path, quiet=True, series_every=1e-3)
    assert not (tmp_path / "series.h5").exists(), "a shorter series leaves none of the longer one"


def test_an_override_is_in_the_scene_that_is_kept(rod_only, tmp_path):
    run(tmp_path, rod_only, "--set", "beam.segments=8", "--set", "rod.gravity=[0, 0]")
    kept = json.loads((tmp_path / "results" / "scene.json").read_text())
    assert kept["beam"]["segments"] == 8 and kept["rod"]["gravity"] == [0, 0]


def test_units_given_as_files_take_the_place_of_ours(small_fsi3, tmp_path):
    heavier = json.loads(json.dumps(small_fsi3))
    heavier["rod"]["material"]["plane_strain"]["density"] = 4000.0
    foreign = package.pack(describe("rod", heavier), tmp_path / "foreign")
    ours, _ = run(tmp_path, small_fsi3, "--end-time", "0.01")
    theirs, _ = run(tmp_path, small_fsi3, "--end-time", "0.01", "--rod-fmu", foreign)
    direct, _ = run(tmp_path, heavier, "--end-time", "0.01")
    assert theirs["tip_vx"][-1] == direct["tip_vx"][-1]
    assert theirs["tip_vx"][-1] != ours["tip_vx"][-1]


def test_guards_of_the_scene_are_for_foreign_units_too(small_fsi3, packed, tmp_path):
    small_fsi3["coupling"]["guards"] = {"window_steps": 5, "largest_imbalance": 1e-6}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    done = run_scene(
        path, "--output", tmp_path / "results", "--rod-fmu", packed("rod", small_fsi3), "--end-time", "0.01"
    )
    assert done.returncode == 1 and "over the last 5 steps the power on the rod" in done.stderr, done.stderr


def test_a_unit_that_does_not_fit_is_refused_with_exit_code_2(small_fsi3, rod_only, tmp_path):
    alone = package.pack(describe("rod", rod_only), tmp_path / "foreign")
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    done = run_scene(path, "--output", tmp_path / "results", "--rod-fmu", alone)
    assert done.returncode == 2
    assert "at the rod" in done.stderr or "the rod has no such output" in done.stderr, done.stderr


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_what_it_has(number, tmp_path):
    command = [*TOOL, "run", FSI3, "--output", tmp_path, "--end-time", "20", "--checkpoint-every", "0.001"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not (tmp_path / "checkpoint.npz").exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    process.send_signal(number)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 130, errors
    series, summary = results(tmp_path)
    assert not summary["completed"] and summary["error"] is None
    assert summary["steps"] > 0
    assert series.size == summary["steps"] + 1
    assert not [name for name in files(tmp_path) if "unfinished" in name]


def test_a_run_that_fails_keeps_what_it_has_and_exits_with_1(small_fsi3, tmp_path):
    impossible = {"iterated": {"tolerance": 1e-15, "max_iterations": 2}}
    small_fsi3["coupling"] = {"load": "pressure_jump", "scheme": impossible}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    done = run_scene(path, "--output", tmp_path / "results", "--quiet")
    assert done.returncode == 1
    assert "did not converge in 2 iterations" in done.stderr, done.stderr
    assert done.stdout == ""
    _, summary = results(tmp_path / "results")
    assert not summary["completed"] and "did not converge" in summary["error"]
