"""Runs that are interrupted and go on: they leave, to the last bit, what an uninterrupted run does, or are refused."""

import functools
import json
import math
import operator
import resource
import signal
import zipfile
from typing import Any

import numpy as np
import pytest

from nervure import api
from nervure.errors import InputError
from nervure.scene import validate
from nervure.simulation import checkpoint
from nervure.simulation.results import CHECKPOINT
from nervure.simulation.session import Session
from tests.conftest import nervure, run_scene, stopped
from tests.fluid.test_space import SPHERE

pytestmark = pytest.mark.usefixtures("libraries")

ITERATED = {"load": "pressure_jump", "scheme": {"iterated": {"max_iterations": 50}}}
TIMES = ("wall_s", "cpu_s", "wall_s_per_simulated_s", "phases_s")


@pytest.fixture
def scenes(rod_only, fluid_only, small_fsi3, two_rods):
    """Small scenes by kind, of some forty steps."""
    rod_only["time"]["end"], fluid_only["time"]["end"], small_fsi3["time"]["end"] = 0.004, 0.04, 0.016
    iterated = json.loads(json.dumps(small_fsi3))
    iterated["coupling"], iterated["time"]["end"] = ITERATED, 0.016
    iterated["fluid"]["mask"] = {"cosine": {"c_eta": 1e-3, "half_width": 1.0}}
    aitken = json.loads(json.dumps(iterated))
    aitken["coupling"]["scheme"]["iterated"]["acceleration"] = "aitken"
    two_rods["coupling"], two_rods["time"]["end"] = {"load": "pressure_jump"}, 0.08
    scenes = {"rod": rod_only, "fluid": fluid_only, "explicit": small_fsi3, "iqn_ils": iterated, "aitken": aitken}
    in_space = json.loads(json.dumps(SPHERE))
    in_space["time"]["end"] = 0.8
    return scenes | {"several": two_rods, "space": in_space}


def run_scene_of(scene, tmp_path, *arguments):
    """Run a scene given as a dict into `tmp_path`/results."""
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene))
    return run_scene(path, "--output", tmp_path / "results", *arguments)


def load(saved):
    checkpoint.restore(saved.session, checkpoint.read(saved.path.parent))
    return saved.session.steps


def results(folder):
    """All tables as bytes and summary.json without what it says of wall times."""
    summary = json.loads((folder / "summary.json").read_text())
    tables = {file.name: file.read_bytes() for file in folder.glob("*.csv")}
    return tables, {key: part for key, part in summary.items() if key not in TIMES}


@pytest.fixture
def saved(fluid_only, tmp_path):
    """Checkpoint of a session in this process, saved after three steps."""
    options = {"checkpoint_every": 0.0, "fields_every": None, "series_every": None}
    with Session(validate(fluid_only), tmp_path) as session:
        session.start()
        for _ in range(3):
            session.step()
        kept = checkpoint.Checkpoint(session, options)
        kept.save()
        session.scheme.start = lambda: None  # `restore` starts the units of a new session
        yield kept


@pytest.mark.parametrize("kind", ["rod", "fluid", "explicit", "iqn_ils", "aitken", "several", "space"])
def test_a_killed_run_goes_on_as_if_nothing_had_been(kind, scenes, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scenes[kind]))
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert run_scene(path, "--output", whole).returncode == 0
    killed = stopped(signal.SIGKILL, 23, "run", path, "--output", parts, "--checkpoint-every", "0")
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    assert not (parts / "summary.json").exists()
    done = nervure("resume", parts)
    assert done.returncode == 0, done.stderr
    assert results(parts) == results(whole)
    assert not (parts / CHECKPOINT).exists(), "a run that has reached its end leaves no checkpoint"


def test_an_interrupted_run_writes_where_it_was_and_another_run_does_not_replace_it(fluid_only, tmp_path):
    path, folder = tmp_path / "scene.json", tmp_path / "results"
    path.write_text(json.dumps(fluid_only))
    assert stopped(signal.SIGINT, 9, "run", path, "--output", folder, "--checkpoint-every", "0").returncode == 130
    assert json.loads((folder / "summary.json").read_text())["steps"] == 9
    with np.load(folder / CHECKPOINT) as archive:
        assert json.loads(archive["about"].tobytes())["done"] == 9

    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    done = run_scene(path, "--output", folder, "--set", "fluid.density=2.0")
    assert done.returncode == 2, done.stderr
    assert f"`nervure resume {folder}` continues it" in done.stderr, done.stderr
    assert before == {file.name: file.read_bytes() for file in folder.iterdir()}


def test_ctrl_c_keeps_a_checkpoint_that_nobody_asked_for(scenes, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scenes["explicit"]))
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert run_scene(path, "--output", whole).returncode == 0
    done = stopped(signal.SIGINT, 23, "run", path, "--output", parts, "--fields-every", "0.004")
    said = done.stdout
    assert done.returncode == 130 and f"`nervure resume {parts}` continues it" in said, said
    assert "the run ended at t = " in said.replace("not compared with published values: ", ""), said
    assert nervure("resume", parts).returncode == 0
    assert results(parts)[0] == results(whole)[0]


def test_a_run_that_failed_keeps_its_last_checkpoint(scenes, tmp_path):
    scene = scenes["rod"]
    scene["time"]["end"] = 0.1
    turning = {"sine": {"amplitude": 3.0, "frequency": 1000.0, "ramp": 0.05}}
    scene["rod"]["root_motion"] = {"laws": {"rotations": [{"angle": turning}]}}  # too far in a step from 0.04 s on
    path, folder = tmp_path / "scene.json", tmp_path / "results"
    path.write_text(json.dumps(scene))
    first = run_scene(path, "--output", folder, "--checkpoint-every", "0")
    assert first.returncode == 1 and "less than a right angle" in first.stderr, first.stderr
    series = (folder / "series.csv").read_bytes()
    again = nervure("resume", folder)
    assert again.returncode == 1 and again.stderr == first.stderr.splitlines(keepends=True)[-1]
    assert (folder / "series.csv").read_bytes() == series


def test_nothing_to_resume_is_said(rod_only, tmp_path):
    assert run_scene_of(rod_only, tmp_path).returncode == 0
    done = nervure("resume", tmp_path / "results")
    assert done.returncode == 2 and "there is no checkpoint" in done.stderr, done.stderr
    assert "--checkpoint-every" in done.stderr, done.stderr


def about(arrays, **changes):
    arrays["about"] = np.frombuffer(json.dumps(json.loads(arrays["about"].tobytes()) | changes).encode(), np.uint8)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda arrays: about(arrays, format=0), f"has format 0, not {checkpoint.FORMAT}"),
        (lambda arrays: about(arrays, guids={"fluid": "{other}"}), "of another fluid: its GUID is"),
        (lambda arrays: arrays.update(fluid_state=arrays["fluid_state"][:-1]), "of another build of the fluid"),
        (lambda arrays: arrays.pop("about"), "is damaged"),
    ],
    ids=["format", "guid", "state", "part"],
)
def test_a_checkpoint_of_another_build_is_refused(change, message, saved):
    with np.load(saved.path) as archive:
        arrays = dict(archive)
    change(arrays)
    del arrays[checkpoint.DIGEST]
    np.savez(saved.path, digest=checkpoint.digest(arrays), **arrays)
    with pytest.raises(checkpoint.CheckpointError, match=message):
        load(saved)


def test_a_damaged_or_cut_file_is_refused(saved):
    """Wherever a byte of the content is changed: the archive's checksums see it."""
    good = saved.path.read_bytes()
    with zipfile.ZipFile(saved.path) as archive:
        ends = [entry.header_offset for entry in archive.infolist()[1:]] + [archive.start_dir]
        lengths = [entry.file_size for entry in archive.infolist()]
    for at in [end - 1 for end in ends] + [end - length for end, length in zip(ends, lengths)]:
        damaged = bytearray(good)
        damaged[at] ^= 1
        for bad in (damaged, good[:at]):
            saved.path.write_bytes(bad)
            with pytest.raises(checkpoint.CheckpointError, match="is damaged"):
                load(saved)
    saved.path.write_bytes(good)
    assert load(saved) == 3


def test_a_full_disk_leaves_the_checkpoint_before(saved):
    """The limit on a file's size stands for the disk: a write fails in the middle of the new checkpoint."""
    good = saved.path.read_bytes()
    said: list[str] = []
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(good) // 2, hard))
    try:
        saved.warn = said.append
        saved.step(saved.session)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert len(said) == 1 and "no checkpoint at t = 0.003 s" in said[0], said
    assert saved.path.read_bytes() == good
    assert not saved.path.with_name(f"unfinished-{CHECKPOINT}").exists()


VALUES: tuple[Any, ...] = (None, -1, "text", [], {}, 1e9, math.nan, ...)
"""Values of an edited key; the last leaves it out."""


def edits(arrays):
    """Every array and every key of `about` once missing and once of another kind, by name."""
    for name in arrays:
        yield f"no {name}", {key: array for key, array in arrays.items() if key != name}
        if arrays[name].size:
            yield f"short {name}", arrays | {name: arrays[name].ravel()[:-1]}
        yield f"text {name}", arrays | {name: np.array("text")}
    yield "another array", arrays | {"scheme_other": np.zeros(3)}
    known = json.loads(arrays["about"].tobytes())
    for path in paths(known):
        for value in VALUES:
            changed = json.loads(json.dumps(known))
            *parents, last = path
            part = functools.reduce(operator.getitem, parents, changed)
            if value is ...:
                del part[last]
            else:
                part[last] = value
            if changed != known:
                yield f"{path} {value}", arrays | {"about": np.frombuffer(json.dumps(changed).encode(), np.uint8)}


def paths(part, path=()):
    """The paths of all keys below a part of `about`."""
    for key, value in part.items():
        yield (*path, key)
        if isinstance(value, dict):
            yield from paths(value, (*path, key))


def test_an_edited_checkpoint_is_refused_whatever_was_edited(saved):
    with np.load(saved.path) as archive:
        arrays = dict(archive)
    count = 0
    for name, changed in edits(arrays):
        with open(saved.path, "wb") as file:
            np.savez(file, **changed)
        with pytest.raises(checkpoint.CheckpointError, match="is damaged|has format"):
            checkpoint.resume(saved.path.parent)
            pytest.fail(name)
        count += 1
    assert count > 200, count


def test_whatever_an_edited_checkpoint_with_a_right_digest_holds_is_refused_or_goes_on(small_fsi3, tmp_path):
    """Every fifteenth edit."""
    options = {"checkpoint_every": 0.0, "fields_every": None, "series_every": None}
    with Session.packed(validate(small_fsi3), tmp_path) as session:
        session.start()
        session.step()
        saved = checkpoint.Checkpoint(session, options)
        saved.save()
    with np.load(saved.path) as archive:
        arrays = dict(archive)
    refused = went_on = 0
    for _, changed in list(edits(arrays))[::15]:
        changed.pop(checkpoint.DIGEST, None)
        with open(saved.path, "wb") as file:
            np.savez(file, digest=checkpoint.digest(changed), **changed)
        try:
            resumed, _ = checkpoint.resume(saved.path.parent)
        except InputError:
            refused += 1
            continue
        with resumed:
            resumed.step()
            went_on += 1
    assert refused > 4 * went_on > 0, (refused, went_on)


@pytest.mark.parametrize("every", [None, 0.004, 0.015, 1.0])
def test_a_finished_run_goes_on_to_a_later_end_as_if_it_had_been_the_first(rod_only, every, tmp_path):
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    at_once = api.run(validate(rod_only).copy(time__end=0.02), whole, quiet=True, series_every=every).series
    options = {"checkpoint_every": 60.0, "series_every": every}
    api.run(validate(rod_only).copy(time__end=0.01), parts, quiet=True, **options)
    for folder, said in ((whole, "there is no checkpoint"), (parts, "is finished: `--end-time` lets it go on")):
        with pytest.raises(InputError, match=said):
            api.resume(folder)
    with pytest.raises(InputError, match="the end time is 0.01 s, but the run in .* has reached 0.01 s"):
        api.resume(parts, end_time=0.01)
    longer = api.resume(parts, end_time=0.02, quiet=True)
    assert longer.summary.completed and longer.scene.time.end == 0.02
    for column, values in at_once.items():
        assert np.array_equal(longer.series[column], values), column


def test_an_edited_scene_beside_a_checkpoint_is_refused_and_that_of_a_replaced_run_is_not(rod_only, tmp_path):
    scene, path = validate(rod_only), tmp_path / "scene.json"
    api.run(scene, tmp_path, quiet=True, on_step=lambda time, _: time > 0.005)
    own = path.read_text()
    for key, value, said in (
        ("rod.gravity", [0.0, -1.0], r"rod.gravity.1 is -1.0 in .*scene.json, but -2.0 in the scene of the run"),
        ("time.end", 0.02, "time.end is 0.02 in .*, but 0.01 in .*: `--end-time` changes the end"),
    ):
        path.write_text(edited := json.dumps(scene.copy({key: value}).document()))
        with pytest.raises(InputError, match=said):
            api.resume(tmp_path, quiet=True)
        assert path.read_text() == edited and (tmp_path / CHECKPOINT).exists()
    path.write_text("{")
    with pytest.raises(InputError, match="scene.json cannot be read, and the run would replace it"):
        api.resume(tmp_path, quiet=True)
    path.write_text(own)
    assert api.resume(tmp_path, quiet=True).summary.completed

    other = tmp_path / "other.json"
    other.write_text(json.dumps(scene.copy({"rod.gravity": [0.0, -1.0]}).document()))
    options = "--output", tmp_path, "--force", "--checkpoint-every", "0"
    assert stopped(signal.SIGKILL, 23, "run", other, *options).returncode == -signal.SIGKILL
    assert path.read_text() == own
    assert api.resume(tmp_path, quiet=True).scene.rod.gravity == [0.0, -1.0]


def test_the_guards_go_on_with_their_history(small_fsi3, tmp_path):
    def step(session):
        session.step()
        return session.scheme.guards[0].balance

    options = {"checkpoint_every": 0.0, "fields_every": None, "series_every": None}
    with Session.packed(validate(small_fsi3), tmp_path) as session:
        session.start()
        for _ in range(4):
            step(session)
        checkpoint.Checkpoint(session, options).save()
        expected = [step(session) for _ in range(3)]
    resumed, _ = checkpoint.resume(tmp_path)
    with resumed:
        assert [step(resumed) for _ in range(3)] == expected
    found = expected[-1]._asdict()
    assert found.pop("steps") == 7 and found.pop("rate") == 0.0 and all(found.values()), "this fluid needs no speeds"


def test_what_was_told_of_places_is_kept_and_not_told_again(two_rods, tmp_path):
    for own, gravity in zip(two_rods["rods"], (-200.0, 200.0), strict=True):
        own["rod"]["gravity"] = [0.0, gravity]
        own["beam"]["root"]["at"]["direction"][1] = 0.0
    options = {"checkpoint_every": 0.0, "fields_every": None, "series_every": None}
    with Session.packed(validate(two_rods), tmp_path) as session:
        session.start()
        while not session.warnings:
            session.step()
        checkpoint.Checkpoint(session, options).save()
        told = list(session.warnings)
    assert "the rod lower meets the rod upper near" in told[0], told
    resumed, _ = checkpoint.resume(tmp_path)
    with resumed:
        for _ in range(5):
            resumed.step()
        assert resumed.warnings == told
