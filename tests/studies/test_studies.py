"""The engine of the studies: stale results, missing runs, and changes of the committed results."""

import pytest

from nervure.resources import ROOT
from studies import catalogue, commands, engine, flight, fluid, roofline, same, show, speed
from studies.engine import Case, Study
from studies.store import Data, Record


def act(case: Case, folder) -> dict:
    """An action that notes that it was called."""
    with open(folder.parent / "ran", "a") as file:
        file.write(f"{case.name}\n")
    return {"value": case.options["value"], "seconds": (folder.parent / "ran").stat().st_size}


STUDY = Study(
    "small",
    lambda: [
        Case(f"group/{n}", (room,), options={"value": n / 3}, action=act) for n, room in ((1, "fluid"), (2, "rod"))
    ],
    lambda case, run: {"values": {"value": run.found["value"]}, "times": {"cpu_s": run.found["seconds"]}},
)


def take(data: Data, study: Study, case: Case) -> None:
    """Record what a case found."""
    run = study.run_of(case)
    assert run
    data.take(study, case, run)


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Return a function that runs what is missing of a study with two sources, and returns the data."""
    monkeypatch.setattr(engine, "ROOT", tmp_path)
    monkeypatch.setattr(engine, "RESULTS", tmp_path / "results")
    monkeypatch.setattr(engine, "SOURCES", {room: (f"{room}/*.rs",) for room in ("fluid", "rod")})
    for room in ("fluid", "rod"):
        (tmp_path / room).mkdir()
        (tmp_path / room / "lib.rs").write_text("// A comment.\nlet x = 1;\n")

    def run(again: bool = False) -> Data:
        engine.source_digest.cache_clear()
        data = Data([STUDY]).load(tmp_path)
        for case in STUDY.cases():
            record = data.get(f"small/{case.name}")
            if again or record is None or record.stale:
                engine.execute(case, STUDY.folder(case))
                take(data, STUDY, case)
        data.save(tmp_path)
        return data

    run.folder = tmp_path  # type: ignore[attr-defined]
    run.ran = lambda: (tmp_path / "results" / "small" / "ran").read_text().split()  # type: ignore[attr-defined]
    yield run
    engine.source_digest.cache_clear()


def test_a_changed_line_makes_exactly_the_rows_stale_that_depend_on_it(small):
    small()
    (small.folder / "fluid" / "lib.rs").write_text("// A comment.\nlet x = 2;\n")
    engine.source_digest.cache_clear()
    data = Data([STUDY]).load(small.folder)
    assert [record.name for record in data.stale()] == ["small/group/1"]


def test_a_changed_comment_makes_nothing_stale(small):
    small()
    (small.folder / "fluid" / "lib.rs").write_text("// Another comment.\n\nlet x = 1;\n")
    engine.source_digest.cache_clear()
    assert Data([STUDY]).load(small.folder).stale() == []


def test_prose_is_no_code(tmp_path):
    (tmp_path / "a.py").write_text('"""Two\nlines."""\n\n# A comment.\nx = """y"""\n"""Of x."""\n')
    assert list(engine.code(tmp_path / "a.py")) == ['x = """y"""']


def test_a_study_runs_only_what_is_missing(small):
    small()
    small()
    (small.folder / "rod" / "lib.rs").write_text("let x = 2;\n")
    small()
    assert small.ran() == ["group/1", "group/2", "group/2"]


def test_a_run_that_agrees_changes_no_file(small):
    small()
    before = [(small.folder / name).read_bytes() for name in ("results.json", "times.json")]
    small(again=True)
    assert len(small.ran()) == 4
    assert before == [(small.folder / name).read_bytes() for name in ("results.json", "times.json")]


def test_a_program_that_fails_is_no_result_and_stops_no_other(tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "RESULTS", tmp_path)
    write = "open('{folder}/found.csv', 'w').write('n\\n1\\n')"
    options = [{"command": ["{python}", "-c", code]} for code in ("raise SystemExit('broken')", write)]
    cases = [Case(f"group/{n}", ("fuzz",), options=own, action=commands.tables) for n, own in enumerate(options)]
    study = Study("programs", lambda: cases, lambda case, run: {})
    ended, runs = [], engine.run([(study, case) for case in cases])
    with pytest.raises(ChildProcessError, match="group/0: broken"):
        for _, case, run in runs:
            ended.append((case.name, run.found["tables"]["found"]))
    assert ended == [("group/1", [{"n": 1.0}])]


def test_every_check_of_reliability_passed():
    records = Data(catalogue.STUDIES).load().of("reliability/*")
    assert len(records) > 50 and not [record.name for record in records if record.error]


def test_a_source_that_has_moved_is_noticed(small):
    (small.folder / "rod" / "lib.rs").unlink()
    engine.source_digest.cache_clear()
    with pytest.raises(FileNotFoundError, match="'rod'"):
        engine.source_digest("rod", small.folder)


def test_a_stale_result_is_kept_only_if_first_steps_and_a_whole_run_come_out_again(small, monkeypatch):
    """By hashes and values that stand for runs: of four cases one differs at first, and one in its evaluation."""
    cases = [Case(f"{group}/{n}", ("fluid",), "csm1", action=act) for group in ("a", "b") for n in (1, 2)]
    study = Study("plain", lambda: cases, lambda case, run: {})
    data = Data([study])
    for case in cases:
        name = f"plain/{case.name}"
        data.records[name] = Record(name, case, "", f"of {name}", {"value": 1.0}, times={"cpu_s": 1.0})
    digests = {record.digest for record in data.records.values()}

    def hashes(wanted, checkout, fresh, jobs):
        there = checkout == small.folder
        return {digest: "differs" if there and digest == "of plain/a/1" else "same" for digest in digests & set(wanted)}

    monkeypatch.setattr(same, "hashes", hashes)
    monkeypatch.setattr(same, "dropped", lambda record: set() if record.case.name.startswith("a") else None)
    kept = same.carry_over(data, ["plain"], small.folder, 1)
    assert kept == ["plain/a/2"]
    assert data["plain/a/2"].carried and not data["plain/a/2"].stale
    assert data["plain/a/1"].stale and data["plain/b/1"].stale and data["plain/b/2"].stale


@pytest.mark.usefixtures("libraries")
def test_units_that_give_other_bits_are_told_apart(monkeypatch):
    monkeypatch.setenv("NERVURE_LIBRARIES", "")  # Put back what the comparison leaves in the environment
    case = fluid.cylinder("2D-2", 100, "grid/same", 2e-3)
    thicker = fluid.cylinder("2D-2", 100, "grid/same", 2e-3)
    thicker.changes["fluid.kinematic_viscosity"] = 1e-3 * (1 + 1e-15)
    assert same.first_steps(case, ROOT) == same.first_steps(case, ROOT)
    assert same.first_steps(case, ROOT) != same.first_steps(thicker, ROOT)
    flown = next(case for case in flight.cases() if case.options)
    assert same.first_steps(flown, ROOT) is None, "a scene under a drive was said to run without it"


def test_errors_are_by_the_published_value_the_amplitude_or_one():
    case = Case("a/b", (), about={"published": "fsi3-325x72", "only": ("lift.mean", "drag.mean", "tip_uy.amplitude"),
                                  "expected": {"cd": 2.0, "work": 0.0}})  # fmt: skip
    values = {"lift.mean": 2.5 + 15.391, "drag.mean": 1.1 * 460.5, "drag.amplitude": 0.0, "cd": 1.9, "work": 0.03}
    found = Record("x/a/b", case, "", "", values, {"found": [{"quantity": "exact", "error": -0.2}]}).errors()
    assert found == pytest.approx({"lift.mean": 0.1, "drag.mean": 0.1, "cd": -0.05, "work": 0.03, "exact": -0.2})


def test_every_source_has_files():
    for room in engine.SOURCES:
        assert engine.source_digest(room, ROOT), room


def test_cases_have_names_of_their_own():
    for study in catalogue.STUDIES:
        cases = list(study.cases())
        assert len({study.folder(case) for case in cases}) == len(cases), study.name


def test_an_offset_moves_the_grid_by_parts_of_a_cell():
    still, moved = (fluid.cylinder("2D-2", 100, "x/y", 1e-3, offset=(x, x)).built()["fluid"] for x in (0.0, 0.25))
    for axis, cells in (("x", 100), ("y", 20)):
        (low, high), (low_moved, high_moved) = still["box"][axis], moved["box"][axis]
        assert low_moved - low == pytest.approx(0.25 * (high - low) / cells)
        assert high_moved - low_moved == pytest.approx(high - low)
    assert moved["cylinders"] == still["cylinders"] and moved["channel"] == still["channel"]


@pytest.mark.usefixtures("libraries")
def test_a_scene_is_run_and_one_that_is_refused_keeps_its_reason(tmp_path, monkeypatch):
    good = fluid.cylinder("2D-2", 100, "grid/good", 2e-3)
    good.changes["time.end"] = 0.1
    bad = fluid.cylinder("2D-2", 100, "grid/bad", 2e-3, c_eta=-1.0)
    study = Study("fluid", lambda: [good, bad], fluid.extract)
    monkeypatch.setattr(engine, "RESULTS", tmp_path)
    data = Data([study])
    for case in study.cases():
        engine.execute(case, study.folder(case))
        take(data, study, case)
    found = data["fluid/grid/good"]
    assert found["cd_mean"] > 0 and found["flow_rate"] > 0 and found.times["runs"] == 3
    assert 0 < found.times["cpu_s"][0] <= found.times["cpu_s"][1] <= found.times["cpu_s"][2]
    assert "c_eta" in data["fluid/grid/bad"].error


def test_a_form_leaves_out_what_is_missing():
    assert show.form("{a[mm]:.1f}< ({b:+.1%})>", {"a": 0.0123, "b": 0.5}) == "12.3 (+50.0 %)"
    assert show.form("{a:.1f}< ({b:+.1%})>", {"a": 2.0, "b": None}) == "2.0"
    assert show.form("{a:.1f}", {}) == ""


def test_a_roofline_has_rates_shares_and_floors():
    found = roofline.reached({"µs": 1000.0, "MB": 32.0, "Mflop": 20.0}, bandwidth=40.0, peak=50.0)
    assert found == pytest.approx({"GB/s": 32, "Gflop/s": 20, "of bandwidth": 0.8, "of peak": 0.4}
                                  | {"by bytes": 800, "by operations": 400})  # fmt: skip


def test_the_roofline_of_a_step_adds_up():
    """By numbers that are easily seen: two phases with 2 and 3 MB, one of which waits, in a step of 100 µs."""
    rows = [("set", 9.0, "MB"), ("bandwidth", 100.0, "GB/s"), ("peak", 50.0, "Gflop/s")]
    for name, *values in (("a", 20.0, 5.0, 2.0, 0.5), ("b", 40.0, 44.0, 3.0, 1.0)):
        columns = (("", "µs"), (": in cache", "µs"), (": moved", "MB"), (": operations", "Mflop"))
        rows += [(name + of, value, unit) for (of, unit), value in zip(columns, values)]
    data = Data([speed.STUDY])
    case = next(iter(speed.cases()))
    lines = [
        [table, "scene", grid, *row]
        for table, grid, _ in speed.ROOFLINES
        for table, row in [(table, row) for row in rows]
        + [(table.replace("roofline", "phases"), ("step", 100.0, "µs"))]
    ]
    name = f"{speed.STUDY.name}/{case.name}"
    data.records[name] = Record(name, case, "", "", times={"rows": lines})
    a, b, both, others = speed.rooflines(data)[:4]
    assert (a["waits"], a["bound"], a["GB/s"], a["of peak"]) == (0.75, "data", 100, 0.5)
    assert (b["waits"], b["bound"], b["GB/s"], b["of peak"]) == (0, "instructions", 75, 0.5)
    assert (both["µs"], both["in cache, µs"], both["MB"], both["Mflop"]) == (60, 49, 5, 1.5)
    assert others["µs"] == 40
