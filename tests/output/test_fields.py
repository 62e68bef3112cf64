"""Field files: what VTKHDF asks for, what the fluid and the beam show, and what is left of a run that was killed."""

import errno
import json
import os
import re
import signal
from typing import Any

import h5py
import numpy as np
import pytest
from PIL import Image

from nervure.errors import SceneError
from nervure.output import fields
from nervure.scene import validate
from nervure.simulation.results import BEAM_FIELDS, FIELDS, FLUID_FIELDS
from nervure.simulation.session import Session
from tests.conftest import nervure, run_scene, stopped

pytestmark = pytest.mark.usefixtures("libraries")


def write(scene, folder, interval):
    """Run `scene` in this process with fields; return its session, which is open."""
    session = Session(validate(scene), folder)
    session.observers = [fields.Fields(session, interval, pytest.fail)]
    assert session.run().completed
    return session


def test_fluid_fields_are_image_data_of_what_the_unit_shows(fluid_only, tmp_path):
    with write(fluid_only, tmp_path, 5e-3) as session, h5py.File(tmp_path / FLUID_FIELDS) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"ImageData" and tuple(root.attrs["Version"]) == (2, 0)
        assert tuple(root.attrs["WholeExtent"]) == (0, 63, 0, 31, 0, 0)
        assert tuple(root.attrs["Origin"]) == (-1.0, -0.5, 0.0)
        assert tuple(root.attrs["Spacing"]) == (2.0 / 64, 1.0 / 32, 1.0)
        assert root["Steps"].attrs["NSteps"] == 5
        assert root["Steps/Values"][:] == pytest.approx([0.0, 0.005, 0.01, 0.015, 0.02])
        velocity = root["PointData/velocity"]
        assert velocity.shape == (5, 32, 64, 3)
        for component, name in enumerate("uv"):
            assert (velocity[-1, ..., component] == session.units["fluid"].field(name).T.astype(np.float32)).all()
        assert (velocity[-1, ..., 2] == 0).all()
        assert (root["PointData/vorticity"][-1] == session.units["fluid"].field("vorticity").T.astype(np.float32)).all()
        assert (root["PointData/pressure"][-1] == session.units["fluid"].field("p").T.astype(np.float32)).all()


def test_the_beam_is_a_polygon_of_its_area_between_its_ends(small_fsi3, tmp_path):
    small_fsi3["time"]["end"] = 0.004
    write(small_fsi3, tmp_path, 0.002).close()
    with h5py.File(tmp_path / BEAM_FIELDS) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"PolyData" and root["Steps"].attrs["NSteps"] == 3
        points = root["Points"][:].reshape(3, 42, 3)
        assert root["Polygons/Offsets"][:].tolist() == [0, 42]
        assert root["Steps/PointOffsets"][:].tolist() == [0, 42, 84]
    x, y = points[0, :, 0], points[0, :, 1]
    area = abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) / 2
    assert area == pytest.approx(0.35 * 0.02, rel=1e-5)
    assert (points[2] != points[0]).any()


def test_a_rod_alone_shows_its_beam(rod_only, tmp_path):
    write(rod_only, tmp_path, 1e-3).close()
    assert not (tmp_path / FLUID_FIELDS).exists()
    with h5py.File(tmp_path / BEAM_FIELDS) as file:
        points = file["VTKHDF/Points"][:].reshape(11, 34, 3)
    assert points[-1, 16, 1] < points[0, 16, 1], "the tip falls"


def test_a_rod_in_space_is_a_line(rod_only, tmp_path):
    rod_only["beam"]["root"]["at"] = {"position": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    rod_only["rod"]["gravity"] = [0.0, 0.0, -2.0]
    write(rod_only, tmp_path, 1e-3).close()
    with h5py.File(tmp_path / BEAM_FIELDS) as file:
        assert file["VTKHDF/Lines/NumberOfCells"][0] == 1 and file["VTKHDF/Polygons/NumberOfCells"][0] == 0
        assert file["VTKHDF/Points"].shape == (11 * 17, 3)


def test_a_scene_without_anything_to_show_is_refused(fluid_only, tmp_path):
    with Session(validate(fluid_only), tmp_path) as session:
        session.units["fluid"].shown_field = lambda name: None
        with pytest.raises(SceneError, match="--fields-every needs a beam, a wing or a fluid that shows its fields"):
            fields.Fields(session, 0.1, pytest.fail)


def test_a_killed_run_leaves_readable_fields_which_its_resumption_completes(small_fsi3, tmp_path):
    small_fsi3["time"]["end"] = 0.04
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    options = ["--fields-every", "0.004"]
    assert run_scene(path, "--output", whole, *options).returncode == 0
    killed = stopped(signal.SIGKILL, 50, "run", path, "--output", parts, "--checkpoint-every", "0", *options)
    assert killed.returncode == -signal.SIGKILL, killed.stderr

    def frames(folder, name):
        with h5py.File(folder / name) as file:
            data = file["VTKHDF/PointData/vorticity" if name == FLUID_FIELDS else "VTKHDF/Points"][:]
            return file["VTKHDF/Steps"].attrs["NSteps"], file["VTKHDF/Steps/Values"][:], data

    expected = {name: frames(whole, name) for name in (FLUID_FIELDS, BEAM_FIELDS)}
    for name in expected:
        count, times, data = frames(parts, name)
        known = count * len(data) // expected[name][0]
        assert 0 < count < expected[name][0] and len(times) in (count, count + 1)
        assert (data[:known] == expected[name][2][:known]).all()

    gone = (parts / BEAM_FIELDS).rename(parts / "elsewhere")
    other = nervure("resume", parts)
    assert other.returncode == 2 and "cannot be continued" in other.stderr, other.stderr
    gone.rename(parts / BEAM_FIELDS)
    done = nervure("resume", parts)
    assert done.returncode == 0, done.stderr
    for name in expected:
        for found, wanted in zip(frames(parts, name), expected[name]):
            assert np.array_equal(found, wanted)
    assert (parts / "series.csv").read_bytes() == (whole / "series.csv").read_bytes()


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="the system takes no room beforehand")
def test_a_full_disk_ends_the_fields_before_hdf5_meets_it(fluid_only, tmp_path, monkeypatch):
    """HDF5 prints a page for each write that fails, and may end the process: it writes into room that is taken."""
    take, warned = os.posix_fallocate, list[str]()

    def full(file, begin, length):
        if len(session.recorder.series["time"]) > 10:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        take(file, begin, length)

    monkeypatch.setattr(os, "posix_fallocate", full)
    with Session(validate(fluid_only), tmp_path) as session:
        session.observers = [own := fields.Fields(session, 5e-3, warned.append)]
        assert own.files[0].file.id.get_access_plist().get_sieve_buf_size() == 0  # It would write around what it gets
        assert session.run().completed
    assert warned == ["no fields from t = 0.01 s on: [Errno 28] No space left on device"]
    with h5py.File(tmp_path / FLUID_FIELDS) as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 2


def test_an_animation_shows_the_frames_of_the_times_asked_for(small_fsi3, tmp_path):
    small_fsi3["time"]["end"] = 0.02
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    run = run_scene(path, "--output", tmp_path / "results", "--fields-every", "0.002")
    assert run.returncode == 0 and re.search(r"work on the rod \S+ J/m, by the fluid \S+ J/m", run.stdout), run.stdout
    done = nervure("animate", tmp_path / "results", "--begin", "0.009", "--end", "0.017")
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / "results" / "vorticity.gif") as film, Image.open(tmp_path / "results" / "phases.png"):
        assert film.n_frames == 4 and film.info["loop"] == 0  # type: ignore[attr-defined]
        colours: list[Any] = [colour for _, colour in film.convert("RGB").getcolors(1 << 20) or []]
    assert any(r > b + 50 for r, _, b in colours) and any(b > r + 50 for r, _, b in colours), "both signs are seen"

    none = nervure("animate", tmp_path / "results", "--begin", "7", "--end", "8")
    assert none.returncode == 2 and "the run has 0 to 0.02 s" in none.stderr, none.stderr


def test_one_frame_is_no_film(rod_only, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(rod_only))
    assert (
        stopped(signal.SIGINT, 5, "run", path, "--output", tmp_path / "results", "--fields-every", "1").returncode
        == 130
    )
    done = nervure("animate", tmp_path / "results")
    assert done.returncode == 2 and "has one frame, but a film needs two" in done.stderr, done.stderr


def test_a_folder_without_fields_is_said(tmp_path):
    done = nervure("animate", tmp_path)
    assert done.returncode == 2 and "--fields-every" in done.stderr, done.stderr


def test_fields_and_checkpoints_change_no_result(rod_only, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(rod_only))
    run_scene(path, "--output", tmp_path / "plain")
    run_scene(path, "--output", tmp_path / "kept", "--checkpoint-every", "0", "--fields-every", "1e-3")
    plain, kept = ((tmp_path / name / "series.csv").read_bytes() for name in ("plain", "kept"))
    assert plain == kept
    assert not set(FIELDS) & {file.name for file in (tmp_path / "plain").iterdir()}
