"""The command `nervure verify` on small scenes: its plan, its budget, what it keeps, and what later runs say."""

import copy
import json
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import pytest

import nervure
from nervure import InputError
from nervure.errors import SceneError
from nervure.evaluate.statistics import Window
from nervure.scene import validate
from nervure.simulation import sweep, verified
from nervure.simulation.session import Session
from nervure.simulation.verified import Quantity
from nervure.verification import process
from nervure.verification.plan import VARY, Plan, scaled
from nervure.verification.process import chosen
from studies import elastica
from tests.conftest import FLUID_ONLY, nervure as tool

pytestmark = pytest.mark.usefixtures("libraries")


@pytest.fixture
def bar(rod_only):
    """A bar that comes to rest under its weight."""
    scene = copy.deepcopy(rod_only)
    scene["beam"]["segments"] = 8
    scene["rod"]["damping"] = 300.0
    scene["time"] = {"end": 6.0, "communication_step": 0.02}
    return validate(scene)


def quietly(scene, folder, **how):
    return nervure.verify(scene, folder, workers=1, quiet=True, **{"budget": 60, **how})


def test_the_plan_of_a_flag_varies_all_that_it_has_on_coarse_grids():
    plan = Plan(nervure.load("flag-line-480x240"))
    settings = {one.name: one for one in plan.first_settings()}
    assert [one.name for one in plan.parameters] == ["cells", "segments", "step", "c_eta", "box"]
    assert list(settings)[:2] == ["cells=2.83", "cells=2.83,segments=2"]
    cost = {name: one.work / plan.setting({}).work for name, one in settings.items()}
    print(cost)
    assert sum(cost.values()) <= 0.9 and cost["cells=2"] <= 0.2
    assert settings["cells=2"].scene.fluid.box.cells == (240, 120)
    assert settings["cells=2"].scene.time.communication_step == pytest.approx(0.004)
    step = plan.setting({"cells": 2.0, "step": 0.5})
    assert step.scene.time.communication_step == pytest.approx(0.002) and step.sizes["cells"] == pytest.approx(2.0)
    assert settings["cells=2.83,c_eta=2"].scene.fluid.mask.log_linear.c_eta == pytest.approx(4e-4)
    larger = settings["cells=2.83,box=0.667"].scene.fluid
    assert larger.box.x == pytest.approx((-2.25, 5.25)) and larger.sponge.x == pytest.approx((4.45, 5.25))
    assert not plan.left_out


def test_a_tight_fine_box_is_verified_on_finer_grids_alone():
    """Coarser cells would be too large for it."""
    plan = Plan(nervure.load("plate-rolling-96x80x80"))
    names = [one.name for one in plan.first_settings()]
    assert names == ["scene", "c_eta=2", "box=0.667", "ratio=0.5", "fine_box=0.8", "cells=0.707"]
    assert [*plan.left_out] == ["cells x 2", "cells x 1.41"], plan.left_out


@pytest.mark.parametrize("impossible", [["segments"], ["segments", "step"]])
def test_a_parameter_that_cannot_vary_is_left_out_and_the_next_one_is_verified(impossible, bar, tmp_path, monkeypatch):
    def refuse(scene, factor):
        raise SceneError("the scene needs it as it is")

    for name in impossible:
        monkeypatch.setitem(VARY, name, refuse)
    if len(impossible) == 2:
        with pytest.raises(InputError, match="no run beside falling-rod is possible: .*; `--parameters` chooses"):
            quietly(bar, tmp_path)
        return
    found = quietly(bar, tmp_path, within=0.05)
    assert "not varied: segments: no two of its runs are possible" in found.problems, found.problems
    assert {*found.verified.quantities["tip_uy_mean"].shares} == {"step"}


def test_walls_and_cylinders_through_the_box_keep_their_box():
    assert verified.free_axes(nervure.load("cylinder-2d1-450x90")) == [0]
    assert "box" not in verified.sizes(nervure.load("sphere-oscillating-64x64x64"))
    inflow = Plan(nervure.load("cylinder-2d1-450x90")).setting({"box": 2 / 3}).scene.fluid
    assert inflow.box.x[0] == -0.752 and inflow.box.x[1] > 3.6 and inflow.inflow.x == (-0.752, 0.0)


def test_two_wings_are_verified_like_one():
    one = nervure.load("flag-square-144x96x96").copy({"wing.max_step": 1e-3})
    wing = one.document()["wing"]
    two = one.copy({"wing": None, "wings": [{"name": name, "wing": wing} for name in ("upper", "lower")]})
    assert set(verified.sizes(two)) == set(verified.sizes(one)) - {"mesh"}
    assert [own.wing.max_step for own in Plan(two).setting({"cells": 2.0}).scene.wings] == [2e-3] * 2


@pytest.mark.parametrize(
    ("cells", "factor", "right"),
    [([648, 108], 0.5, [324, 54]), ([96, 72, 72], 0.5**0.5, [64, 48, 48]), ([325, 72], 0.5, [162, 36])],
)
def test_numbers_of_cells_keep_proportions_and_fast_transforms(cells, factor, right):
    assert scaled(cells, factor) == right


def test_the_bar_under_its_weight_is_verified_by_one_command(bar, tmp_path):
    found = quietly(bar, tmp_path / "verify-bar", within=0.02)
    material, h = bar.rod.material.plane_strain, bar.beam.thickness
    plate = material.youngs_modulus / (1 - material.poisson_ratio**2)
    x, y = elastica.tip(bar.beam.length, 2.0 * material.density * h, plate * h**3 / 12, plate * h)
    for name, exact in (("tip_ux_mean", x), ("tip_uy_mean", y)):
        known = found.verified.quantities[name]
        print(name, known.value, known.limit, known.uncertainty, exact, known.shares["segments"].order)
        assert abs(known.limit - exact) <= known.uncertainty <= 0.02 * abs(exact)
        assert known.shares["segments"].order == pytest.approx(2.0, abs=0.4)
    assert found.reached and (tmp_path / "verify-bar" / "verify.png").is_file()
    again = nervure.run(found.recommended, tmp_path / "again", quiet=True)
    error = abs(again.summary.quantities["tip_uy"].mean / y - 1)
    said = again.summary.verified["tip_uy_mean"].error / abs(y)
    print(error, said, found.verified.recommended_error)
    assert error <= said <= 0.02
    assert json.loads((tmp_path / "again" / "summary.json").read_text())["verified"]["tip_uy_mean"]["unit"] == "m"
    assert "± 95 %" in tool("inspect", tmp_path / "again").stdout
    assert "tip uy mean" in tool("inspect", tmp_path / "verify-bar").stdout
    begin = time.perf_counter()
    repeated = quietly(bar, tmp_path / "verify-bar", within=0.02)
    print(time.perf_counter() - begin, repeated.verified.wall_s)
    same = repeated.verified.quantities == found.verified.quantities
    assert same and repeated.verified.wall_s == found.verified.wall_s  # Of the first time: nothing ran again


def test_a_fluid_is_verified_within_its_budget(tmp_path):
    scene = validate(copy.deepcopy(FLUID_ONLY) | {"time": {"end": 0.1, "communication_step": 2e-3}})
    found = process.Verification(scene, tmp_path, 1e-6, 1.2, cpu=True).run()  # Beside other work too
    spent = sum(row["cpu_s"] for _, row in found.runs)
    print(spent, found.problems)
    assert not found.reached and any("the budget ended" in problem for problem in found.problems)
    assert {"cells", "c_eta", "box"} <= set(found.verified.quantities["drag_mean"].shares)
    assert spent <= 1.1 * 1.2


def test_a_run_that_overruns_the_budget_is_stopped_and_made_by_the_next_command(bar, tmp_path, monkeypatch):
    with monkeypatch.context() as late:
        late.setattr(sweep, "time", lambda: float("inf"))
        found = quietly(bar, tmp_path)
    rows = {row["folder"]: row["status"] for row in json.loads((tmp_path / "sweep.json").read_text())}
    print(found.problems, rows)
    assert set(rows.values()) == {sweep.STOPPED} and not found.reached
    assert any("it took longer than was left" in problem for problem in found.problems)
    assert quietly(bar, tmp_path, within=0.05).reached


def test_a_budget_too_small_for_two_runs_is_refused_with_what_they_take(bar, tmp_path):
    with pytest.raises(InputError, match=r"the budget of .* is too small for two runs of .*: the cheapest two take"):
        quietly(bar, tmp_path, budget=1e-3)
    slow = process.Verification(bar, tmp_path, 0.02, 36000.0)
    slow.begin -= 35000.0
    slow.rows["scene"] = {}  # A first run, which took that long
    with (
        patch.object(slow, "_cost", lambda _: 7200.0),
        patch.object(slow.costs, "measure"),
        pytest.raises(InputError, match=r"of 10 h, of which a first run left 17 min, is .* take about 4 h"),
    ):
        slow._first_round()


def test_a_scene_that_fails_on_the_finest_keeps_and_judges_the_other_runs(bar, tmp_path, monkeypatch):
    whole = sweep.run_case

    def run_case(scene, folder, *rest):
        if folder.name == "scene":
            return {"status": sweep.FAILED, "reason": "the rod diverged", "wall_s": 0.0, "cpu_s": 0.0}
        return whole(scene, folder, *rest)

    monkeypatch.setattr(sweep, "run_case", run_case)
    found = quietly(bar, tmp_path, within=1e-4)
    print(found.problems)
    assert "the run scene failed: the rod diverged" in found.problems and not found.reached
    assert min(found.verified.quantities["tip_uy_mean"].shares["segments"].sizes) == pytest.approx(4 / 3)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"parameters": ["mesh"]}, "there is nothing to vary in falling-rod"),
        ({"parameters": ["colour"]}, "`colour` is unknown: there are cells, segments"),
        ({"quantities": ["tip_u"]}, "the quantity `tip_u` is not in the results"),
        ({"quantities": ["wall_s"]}, "`wall_s` is not in the results: there are tip_ux, tip_uy"),
        ({"quantities": ["lift"]}, "`lift` is not in the results: there are tip_ux, tip_uy, tip_ux_mean"),
        ({"within": 0.0}, "within is 0.0, but must be a finite number above 0"),
    ],
)
def test_bad_input_is_refused_in_words_before_any_run(bar, tmp_path, how, words, monkeypatch):
    monkeypatch.setattr(sweep, "run", None)
    with pytest.raises(InputError) as refused:
        quietly(bar, tmp_path, **how)
    assert words in str(refused.value)


@pytest.mark.parametrize(
    ("name", "wanted", "wrong"),
    [
        ("cylinder-2d1-450x90", ["lift", "drag_amplitude", "st", "cl_max", "periods"], "tip_ux"),
        ("fsi3-325x72", ["tip_ux_frequency_hz", "lift_mean"], "st"),
        ("vein-pitching-320x240", ["efficiency", "power_in", "side"], "axis"),
    ],
)
def test_names_that_only_some_runs_of_a_scene_have_are_accepted(name, wanted, wrong):
    with Session(nervure.load(name)) as session:
        process.check_names(wanted, session.facts, session.recorder.columns)
        with pytest.raises(InputError, match=f"`{wrong}` is not in the results"):
            process.check_names([wrong], session.facts, session.recorder.columns)


def test_numbers_of_the_method_are_no_physics():
    base = validate(copy.deepcopy(FLUID_ONLY))
    numerical = {"fluid.box.cells": [128, 64], "time.communication_step": 5e-4, "fluid.mask.cosine.c_eta": 1e-3}
    assert verified.physics(base) == verified.physics(base.copy(numerical))
    assert verified.physics(base) != verified.physics(base.copy({"fluid.kinematic_viscosity": 2e-2}))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--within", "much"], "0.02"),
        (["--budget", "-3"], "20min"),
        (["--budget", "1e400s"], "20min"),
        (["--within", "inf"], "0.02"),
    ],
)
def test_options_without_a_meaning_are_refused(arguments, words):
    done = tool("verify", "csm1", *arguments)
    assert done.returncode == 2 and words in done.stdout + done.stderr


def test_a_flow_shows_one_frequency_that_of_its_periods_and_no_swing_that_dies_away():
    def signal(mean, amplitude, frequency, unit="N", state="periodic"):
        return SimpleNamespace(mean=mean, amplitude=amplitude, frequency_hz=frequency, unit=unit, state=state)

    outputs = {"tip_ux": signal(-0.2, 0.1, 0.63, "m"), "tip_uy": signal(0.0, 0.5, 0.31, "m")}
    outputs |= {"drag": signal(0.9, 0.004, 1.9), "lift": signal(0.0, 0.8, 0.92)}
    summary: Any = SimpleNamespace(quantities=outputs, window=Window(10.0, 26.0, 5), amplitude_drift=0.02)
    names = chosen(summary, {}, ())
    print(names)
    assert [name for name in names if "frequency" in name] == ["tip_uy_frequency_hz"]
    assert "drag_mean" in names and "drag_amplitude" not in names
    assert "lift_frequency_hz" in chosen(summary, {}, ["lift"])
    # Another run may have the frequency that this one does not have.
    assert chosen(summary, {"lift_frequency_hz": None, "lift_mean": 1.0}, ["lift_frequency_hz", "lift_mean"]) == [
        "lift_mean"
    ]
    summary.amplitude_drift = -0.7
    assert chosen(summary, {}, ()) == ["drag_mean"] and "tip_uy_amplitude" in chosen(summary, {}, ["tip_uy"])


def known_flag(folder, effect):
    """Return a verification of a flag on three grids of other flows, with c_eta changed by `effect` on the coarsest."""
    found = process.Verification(nervure.load("flag-line-480x240"), folder, 0.02, 60.0)
    drags = {"cells=2.83": 1.0, "cells=2": 0.5, "cells=1.41": 0.3, "cells=2.83,c_eta=2": 1.0 + effect}
    for setting in found.plan.first_settings():
        if setting.name in drags:
            found.settings[setting.name] = setting
            found.rows[setting.name] = {"status": sweep.FINISHED, "drag_mean": drags[setting.name]}
    found.names, found.units = ["drag_mean"], {"drag_mean": "N"}
    return found


@pytest.mark.parametrize(("effect", "again"), [(1e-3, False), (1.0, True)])
def test_a_parameter_of_small_effect_on_a_coarse_run_is_not_varied_on_a_finer_one(tmp_path, effect, again):
    flag = known_flag(tmp_path, effect)
    known = flag._found()
    wanted = [one.name for one in flag._next_round(known)]
    print(wanted, {name: share.uncertainty for name, share in known["drag_mean"].shares.items()})
    assert "c_eta" in known["drag_mean"].shares and "scene" in wanted
    assert ("cells=1.41,c_eta=2" in wanted) == again


@pytest.mark.parametrize(("scatter", "beside"), [(0.05, "cells=2.83"), (0.3, "cells=2")])
def test_other_parameters_vary_beside_a_run_that_hardly_scatters(tmp_path, scatter, beside):
    flag = known_flag(tmp_path, 0.0)
    del flag.rows["cells=2.83,c_eta=2"], flag.settings["cells=2.83,c_eta=2"]
    for row in flag.rows.values():
        row["drag_mean"] = 1.0
    flag.noise["cells=2.83", "drag_mean"] = scatter
    assert flag._base().name == beside


def test_a_parameter_whose_runs_stand_beside_another_flow_is_varied_again(tmp_path):
    """Finer segments change the coarsest run, which scatters, by half, and no further run beside it narrows that."""
    flag = known_flag(tmp_path, 0.0)
    base = flag.settings["cells=2.83"]
    for factor, drag in ((0.5, 0.5), (2.0, 1.02)):
        setting = flag.plan.setting({**base.factors, "segments": factor})
        flag.settings[setting.name] = setting
        flag.rows[setting.name] = {"status": sweep.FINISHED, "drag_mean": drag}
    flag.noise["cells=2.83", "drag_mean"] = 0.3
    for name in ("cells=2", "cells=1.41"):
        flag.rows[name]["drag_mean"] = 1.0
    wanted = [one.name for one in flag._next_round(flag._found())]
    assert flag._base().name == "cells=2" and "cells=2,segments=2" in wanted


def test_what_makes_most_of_a_bar_is_varied_on_however_many_small_bars_make_it(tmp_path):
    """Three bars of two thirds of the tolerance make one that is too wide, and none alone is much."""
    flag = known_flag(tmp_path, 1e-3)
    share = flag._found()["drag_mean"].shares["cells"]
    bars = {"cells": 0.0133, "segments": 0.0131, "c_eta": 0.0132}
    shares = {name: replace(share, uncertainty=bar) for name, bar in bars.items()}
    wide = [Quantity(1.0, 1.0, 0.0229, 1.0, "N", shares)]
    assert [process._matters(wide, name, 0.02 / 2**0.5) for name in bars] == [True, False, False]


def test_a_verification_that_no_further_run_helps_says_so_below_its_budget(bar, tmp_path, monkeypatch):
    monkeypatch.setattr(process.Verification, "_next_round", lambda *_: [])
    found = quietly(bar, tmp_path, within=1e-6)
    print(found.problems)
    assert not found.reached
    (said,) = [problem for problem in found.problems if "the budget is not used up" in problem]
    assert "comes mostly from segments, and no further run narrows that" in said


def test_workers_that_were_slow_to_start_are_not_started_again_for_short_runs(bar, tmp_path, monkeypatch):
    clock, asked = [0.0], []

    def run(*arguments):
        asked.append(arguments[7])
        clock[0] += 50.0
        return []

    monkeypatch.setattr(process, "time", lambda: clock[0])
    monkeypatch.setattr(sweep, "run", run)
    found = process.Verification(bar, tmp_path, 0.02, 600.0, workers=2)
    settings = list(found.plan.first_settings())
    found.costs.paces.append((settings[0].work, 10.0))
    for _ in range(2):
        found._make(settings)
    print(asked, found.start)
    assert asked == [2, 1] and found.start == 50.0


@pytest.mark.filterwarnings("default")  # For those of Dask
def test_workers_of_a_scheduler_find_what_this_process_does(bar, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as cluster:
        found = nervure.verify(bar, tmp_path / "two", scheduler=cluster.scheduler_address, quiet=True)
        assert sweep.at_once(cluster.scheduler_address, None) == 2
    own = quietly(bar, tmp_path / "one")
    assert found.reached and found.verified.quantities == own.verified.quantities
