"""Sweeps: a grid of small runs on Dask's workers, what is kept of failures, and what a second sweep does."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from distributed import Client, LocalCluster

from nervure.errors import InputError, SceneError
from nervure.output import sweeps
from nervure.simulation import sweep
from tests.conftest import TOOL, nervure as nervure_here

pytestmark = [
    pytest.mark.usefixtures("libraries"),
    pytest.mark.filterwarnings("default"),  # for those of Dask, whose clusters some tests hold in this process
]


def nervure(*arguments):
    """Run the command in a process of its own, whose workers begin as its users' do."""
    return subprocess.run([*TOOL, *arguments], capture_output=True, text=True)


@pytest.fixture
def scene(rod_only, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(rod_only))
    return path


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler with two workers, started as their users do: nothing of ours is on their path."""
    folder = tmp_path / "cluster"
    folder.mkdir()
    file = folder / "scheduler.json"
    command = [
        sys.executable,
        "-m",
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
    ]
    worker = [
        sys.executable,
        "-m",
        "distributed.cli.dask_worker",
        "--nthreads",
        "1",
        "--nworkers",
        "2",
        "--no-dashboard",
    ]
    processes = []
    try:
        for start in (command, worker):
            quiet = {"cwd": folder, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            processes.append(subprocess.Popen([*start, "--scheduler-file", file], **quiet))
        deadline = time.monotonic() + 60
        while not (file.exists() and file.stat().st_size) and time.monotonic() < deadline:
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        with Client(address) as client:
            client.wait_for_workers(2, timeout=60)
        yield address
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait(timeout=60)


def table(folder):
    with open(folder / "sweep.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_grid_is_run_a_failure_is_kept_and_only_what_is_missing_is_run_again(scene, cluster, tmp_path):
    folder = tmp_path / "sweep"
    command = ["sweep", scene, "--output", folder, "--scheduler", cluster]
    command += ["--vary", "rod.gravity=[[0, -2], [0, -4]]", "--vary"]
    first = nervure_here(*command, "beam.segments=8,-3")
    assert first.returncode == 1, first.stderr
    assert "4 runs, 4 to do" in first.stdout
    rows = table(folder)
    assert [(row["rod.gravity"], row["beam.segments"], row["status"]) for row in rows] == [
        ("[0, -2]", "8", "finished"),
        ("[0, -2]", "-3", "failed"),
        ("[0, -4]", "8", "finished"),
        ("[0, -4]", "-3", "failed"),
    ]
    assert "beam.segments" in rows[1]["reason"] and "-3" in rows[1]["reason"]
    light, heavy = (float(rows[k]["tip_uy_mean"]) for k in (0, 2))
    assert heavy == pytest.approx(2 * light, rel=1e-3) and light < 0
    for row in rows[::2]:
        assert float(row["wall_s"]) > 0 and float(row["cpu_s"]) > 0 and int(row["steps"]) == 100
        summary = json.loads((folder / row["folder"] / "summary.json").read_text())
        assert float(row["tip_uy_mean"]) == summary["quantities"]["tip_uy"]["mean"]
    values = json.loads((folder / "sweep.json").read_text())
    assert [row["beam.segments"] for row in values] == [8, -3, 8, -3] and values[1]["wall_s"] is not None

    before = {row["folder"]: (folder / row["folder"] / "row.json").stat().st_mtime_ns for row in rows}
    (folder / rows[2]["folder"] / "row.json").unlink()  # as if the sweep had been stopped before it
    again = nervure_here(*command, "beam.segments=8,-3,12")
    assert again.returncode == 1 and "6 runs, 3 to do" in again.stdout, again.stderr
    after = {row["folder"]: (folder / row["folder"] / "row.json").stat().st_mtime_ns for row in table(folder)}
    assert len(after) == 6
    assert [name for name in before if before[name] == after[name]] == [rows[k]["folder"] for k in (0, 1, 3)]

    retried = nervure_here(*command, "beam.segments=-3", "--retry-failed")
    assert "2 runs, 2 to do" in retried.stdout, retried.stderr


def test_a_sweep_shows_its_values_and_replaces_no_other_scene(scene, tmp_path):
    """Folders, table, picture and progress go by the values; nothing is packed or drawn for a single run."""
    folder = tmp_path / "sweep"
    command = ["sweep", scene, "--output", folder, "--vary", "beam.segments=8,16"]
    command += ["--vary", "rod.material.plane_strain.youngs_modulus=1e6,2e6"]
    first = nervure(*command)
    assert first.returncode == 0, first.stderr
    names = [f"segments={n},youngs_modulus={e}" for n in (8, 16) for e in (1000000, 2000000)]
    assert {path.name for path in folder.iterdir()} == {*names, "sweep.csv", "sweep.json", "sweep.png"}
    assert {path.name for path in (folder / names[0]).iterdir()} == {
        "scene.json", "series.csv", "summary.json", "row.json"
    }  # fmt: skip
    assert " 16        2000000         finished" in first.stdout, first.stdout
    inspected = nervure_here("inspect", folder)
    assert inspected.stdout.splitlines()[0] in first.stdout and "tip uy mean" in inspected.stdout, inspected.stderr

    drawn = (folder / "sweep.png").read_bytes()
    (folder / "sweep.png").unlink()
    assert nervure_here("plot", folder).returncode == 0 and (folder / "sweep.png").read_bytes() == drawn
    listed = nervure_here(*command, "--list", "--vary", "time.end=0.01,0.02")
    assert "8 runs, 8 to do" in listed.stdout and f"{names[0]},end=0.02: 200 steps to do" in listed.stdout
    assert f"{names[0]}: finished" in nervure_here(*command, "--list").stdout

    before = (folder / names[0] / "series.csv").read_bytes()
    other = nervure_here(*command, "--set", "rod.gravity=[0, -3]")
    assert other.returncode == 2 and "rod.gravity.1 is -2.0 there, but -3 here" in other.stderr, other.stderr
    assert (folder / names[0] / "series.csv").read_bytes() == before
    one = [part.replace("8,16", "8").replace("1e6,2e6", "1e6") for part in map(str, command)]
    forced = nervure(*one, "--set", "rod.gravity=[0, -3]", "--force")
    assert forced.returncode == 0 and (folder / names[0] / "series.csv").read_bytes() != before, forced.stderr


def test_a_sweep_tells_how_many_steps_are_done(rod_only, tmp_path):
    rod_only["time"]["end"] = 0.3
    cases, told = sweep.grid([rod_only], [sweep.variation("beam.segments=8,32")]), []
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
        sweep.run(cases, tmp_path, cluster.scheduler_address, progress=lambda *done: told.append(done))
    assert told[-1] == (2, 6000) and any(0 < steps < 6000 for _, steps in told), told


@pytest.mark.parametrize(
    ("workers", "said"), [({"n_workers": 0}, "has no workers"), ({"threads_per_worker": 2}, "--nthreads 1")]
)
def test_a_cluster_that_cannot_run_is_said(workers, said, scene, tmp_path):
    options = {"n_workers": 1, "processes": False, "dashboard_address": "127.0.0.1:0", "protocol": "tcp://"}
    with LocalCluster(**(options | workers)) as cluster:
        done = nervure_here("sweep", scene, "--output", tmp_path / "sweep", "--scheduler", cluster.scheduler_address)
    assert done.returncode == 2 and said in done.stderr, done.stderr


def test_a_scheduler_that_does_not_answer_is_said(scene, tmp_path):
    done = nervure_here("sweep", scene, "--output", tmp_path / "sweep", "--scheduler", "tcp://127.0.0.1:9")
    assert done.returncode == 2 and "no scheduler answers at tcp://127.0.0.1:9" in done.stderr, done.stderr


@pytest.mark.parametrize(
    "command",
    [
        ["sweep", "--vary", 'rod.root_motion=[{"laws": {"y": {"constant": 0.0}}}, "master"]', "--workers", "1"],
        ["verify", "--set", 'rod.root_motion="master"'],
    ],
    ids=["sweep", "verify"],
)
def test_a_scene_that_needs_a_drive_is_refused_before_any_run(command, scene, tmp_path):
    done = nervure_here(command[0], scene, *command[1:], "--output", tmp_path / "out")
    assert done.returncode == 2 and not (tmp_path / "out").exists(), done.stderr
    assert "the scene leaves root.x, root.y, root.angle to the master (root_motion), but runs of a" in done.stderr
    assert "give laws of time" in done.stderr and "--drive" not in done.stderr, done.stderr


def running(process: subprocess.Popen) -> list[psutil.Process]:
    """Workers of a sweep in which the library of a rod is loaded; the sweep itself has it too, and until a new child
    begins its own program it is a copy of the sweep."""
    found = []
    for child in psutil.Process(process.pid).children(recursive=True):
        try:
            maps = Path(f"/proc/{child.pid}/maps").read_text()
            if "fmu_rod" in maps and "nervure" not in child.cmdline():
                found.append(child)
        except (OSError, psutil.Error):
            pass
    return found


@pytest.mark.parametrize("content", ["", "[1]", "null", '[{"folder": 1}]'])
def test_rows_and_tables_that_are_damaged_are_made_again_or_said(content, rod_only, tmp_path):
    case, *_ = sweep.grid([rod_only], [{"beam.segments": [8]}])
    (tmp_path / case.folder).mkdir()
    (tmp_path / case.folder / sweep.ROW).write_text(content)
    assert sweep.missing_cases([case], tmp_path, False) == [case]
    (tmp_path / "sweep.json").write_text(content)
    with pytest.raises(InputError, match="holds no sweep"):
        sweeps.read(tmp_path)


def test_values_that_no_scene_can_have_are_refused(rod_only):
    with pytest.raises(SceneError, match="the values of time.end are nothing for a scene: Object of type object"):
        sweep.grid([rod_only], [{"time.end": [object()]}])


def test_on_this_machine_a_worker_that_is_killed_costs_a_row_and_not_the_sweep(scene, tmp_path):
    folder = tmp_path / "sweep"
    command = ["sweep", scene, "--output", folder, "--vary", "time.end=1e-3,1e5"]
    environment = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
    process = subprocess.Popen(
        [*TOOL, *command], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 120
    while not list(folder.glob("*/row.json")) and time.monotonic() < deadline:
        time.sleep(0.1)
    killed = 0
    while process.poll() is None and time.monotonic() < deadline:
        for worker in running(process):
            worker.send_signal(signal.SIGKILL)
            worker.wait()
            killed += 1
        time.sleep(0.1)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 1, errors
    assert killed >= 2  # a quick run is made again where its result was still with a worker that is killed
    quick, endless = table(folder)
    assert quick["status"] == "finished"
    assert (endless["status"], endless["reason"]) == ("killed", "its worker died 2 times")

    again = nervure_here(*command)
    assert again.returncode == 1 and "2 runs, 0 to do" in again.stdout, again.stderr


@pytest.mark.parametrize("moment", ["while workers start", "in a run"])
def test_ctrl_c_ends_a_sweep_without_a_traceback(moment, scene, tmp_path):
    """It goes to all processes of the terminal, at any moment, and none of them stays."""
    command = [*TOOL, "sweep", scene, "--output", tmp_path / "sweep", "--vary", "time.end=1e4,1e5"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    children = psutil.Process(process.pid).children
    reached = (lambda: running(process)) if moment == "in a run" else (lambda: len(children(recursive=True)) > 1)
    deadline = time.monotonic() + 60
    while not reached() and time.monotonic() < deadline:
        time.sleep(0.05)
    workers = children(recursive=True)
    os.killpg(process.pid, signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "the same command continues" in output, output + errors
    assert "Traceback" not in errors, errors
    assert len(workers) > 1 and not psutil.wait_procs(workers, timeout=10)[1]


def test_ctrl_c_is_raised_where_the_sweep_asks_for_it():
    """Not where it comes: in a destructor it would be lost."""
    with sweep._interruption() as check:
        check()
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            check()


@pytest.mark.parametrize(
    ("variations", "message"),
    [
        (["beam.segments"], "must be of the form key=value,value"),
        (["beam.segments="], "must be of the form key=value,value"),
        (["beam.segments=8", "beam.segments=16"], "name a key twice"),
        (["fluid.cylinders.0.radius=1"], "names a key that the scene does not have"),
        (["beam.segments=[]"], "must be of the form key=value,value"),
        (["beam.segments=8,16; time.end=1"], "equally many values: beam.segments has 2, time.end has 1"),
        (["beam.segments=8; beam.segments=16"], "name a key twice"),
        (["beam.segments=8", "beam.segmens=3,4"], "did you mean `segments`"),
    ],
)
def test_a_variation_that_leads_nowhere_is_said(variations, message, rod_only):
    with pytest.raises(SceneError, match=message):
        sweep.grid([rod_only], [sweep.variation(text) for text in variations])


@pytest.mark.parametrize(
    ("variation", "folders"),
    [
        ("fluid.box.cells=[[32, 16], [64, 32]]", ["cells=32_16", "cells=64_32"]),
        ("fluid.cylinders.0.radius=0.1,0.2", ["radius=0.1", "radius=0.2"]),
        ("fluid.cylinders.0=1e-5,2e6", ["cylinders.0=1e-05", "cylinders.0=2000000"]),
        ("name=..,-v", ["name=..", "name=-v"]),
        (f"description={'x' * 150},y", [f"description={'x' * 79}-", "description=y"]),
    ],
)
def test_a_folder_is_named_by_its_values(variation, folders, fluid_only):
    cases = sweep.grid([fluid_only], [sweep.variation(variation)])
    assert all(case.folder.startswith(folder) and len(case.folder) <= 100 for case, folder in zip(cases, folders))


def test_a_value_with_and_without_a_point_makes_one_run_unless_the_key_is_one_of_whole_numbers(rod_only):
    cases = sweep.grid([rod_only], [sweep.variation("rod.gravity=[[0, -1], [0.0, -1.0], [0, -1.5]]")])
    assert [case.varied["rod.gravity"] for case in cases] == [[0, -1], [0, -1.5]]
    refused = sweep.grid([rod_only], [sweep.variation("beam.segments=8,8.0")])
    assert [case.varied["beam.segments"] for case in refused] == [8, 8.0]


def test_several_scenes_and_listed_values_make_one_grid(rod_only, fluid_only):
    variations = [sweep.variation("time.end=0.1,0.2"), sweep.variation('name=["one", "two"]')]
    cases = sweep.grid([rod_only, fluid_only], variations)
    assert len({case.folder for case in cases}) == len(cases) == 8
    assert cases[1].varied == {"time.end": 0.1, "name": "two"} and cases[1].scene["name"] == "two"
    assert rod_only["name"] == "falling-rod", "the scene that is varied stays as it was"


def test_keys_of_one_variation_change_together(rod_only):
    together = sweep.variation("beam.segments=8,16; time.communication_step=[1e-4, 5e-5]")
    cases = sweep.grid([rod_only], [together, sweep.variation("rod.damping=0,1")])
    assert [tuple(case.varied.values()) for case in cases] == [
        (8, 1e-4, 0), (8, 1e-4, 1), (16, 5e-5, 0), (16, 5e-5, 1)
    ]  # fmt: skip
    assert sweep.variation('description=["a; b", "c"]') == {"description": ["a; b", "c"]}


@pytest.mark.parametrize(
    ("pairs", "curves"), [([(1, 10), (2, 20), (3, 30)], [3]), ([(1, 10), (1, 20), (2, 10), (2, 20)], [2, 2])]
)
def test_a_key_that_changes_with_the_first_makes_no_curves(pairs, curves, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr("nervure.output.plots.save", lambda figure, path: drawn.append(figure))
    rows = [{"scene": "s", "folder": "f", "a.x": x, "a.y": y, "status": "finished", "drag_mean": 1.0 * x}
            for x, y in pairs]  # fmt: skip
    sweeps.plot(tmp_path, rows)
    assert [len(line.get_xdata()) for line in drawn[0].axes[0].lines] == curves


def test_a_script_without_a_guard_is_not_run_by_its_workers(scene, tmp_path):
    """Workers are spawned processes, which would import it."""
    script = tmp_path / "script.py"
    script.write_text(
        "import nervure\n"
        "print('begun', flush=True)\n"
        f"rows = nervure.sweep({str(scene)!r}, {{'beam.segments': [8]}}, {str(tmp_path / 'out')!r}, quiet=True)\n"
        "print(rows[0]['status'])\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stdout.split() == ["begun", "finished"], done.stdout + done.stderr
