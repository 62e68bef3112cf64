"""Scenes as environments of gymnasium."""

import functools
import math
import os
import runpy
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from nervure import gym  # noqa: E402
from nervure.errors import InputError  # noqa: E402
from nervure.gym import identity  # noqa: E402
from nervure.resources import ROOT  # noqa: E402
from nervure.scene import load  # noqa: E402
from nervure.simulation.session import Session  # noqa: E402

PLATE = ROOT / "examples" / "steered-plate.json"
TURN = gym.Action("root.angle", -0.3, 0.3, lag=0.05)
pytestmark = [
    pytest.mark.usefixtures("libraries"),
    pytest.mark.filterwarnings("ignore:.*(Box observation space|render modes)"),  # Without bounds; without a name
]


def plate(scene=PLATE, **options):
    given = {"starts": (0.0, 0.1), **options}
    return gym.Env(scene, [TURN], {"tip_uy": 0.1, "root.angle": 0.3}, lambda v, _: v["lift"], **given)


@pytest.fixture
def env():
    with plate(render_mode="rgb_array") as made:
        yield made


def episode(env, seed, steps=5):
    seen, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    rows = [seen]
    for _ in range(steps):
        seen, reward, *_ = env.step(env.action_space.sample())
        rows.append([*seen, reward])
    return np.concatenate(rows)


def test_the_check_of_gymnasium_passes(env):
    check_env(env)


def test_the_same_seed_gives_the_same_bits_also_after_other_episodes_and_in_another_environment(env):
    first = episode(env, 1)
    assert not np.array_equal(first, episode(env, 2))
    again = episode(env, 1)
    with plate(load(PLATE)) as other:
        assert np.array_equal(first, again) and np.array_equal(first, episode(other, 1))


def servo(t, target=0.2, lag=0.05):
    """Return place and speed of a critically damped servo that leaves 0 at t = 0."""
    return target * (1 - (1 + t / lag) * np.exp(-t / lag)), target * t / lag**2 * np.exp(-t / lag)


def test_an_environment_makes_the_steps_of_a_run_that_is_driven_as_its_servos_are(env):
    env.reset(options={"start": 0})
    env.step(np.array([0.2]))
    with Session(load(PLATE), drive=lambda t, _: dict(zip(("root.angle", "root.omega"), servo(t)))) as session:
        session.start()
        for _ in range(10):
            session.step()
        names = "tip_uy", "lift", "root.angle", "root.omega"
        expected = [session.recorder.values[name] for name in names]
    assert [env.values[name] for name in names] == pytest.approx(expected, rel=1e-9)


def test_a_servo_goes_on_from_action_to_action(env):
    env.reset(options={"start": 0})
    for number in range(1, 4):
        env.step(np.array([0.2]))
        found = env.values["root.angle"], env.values["root.omega"]
        assert found == pytest.approx(servo(0.1 * number), rel=1e-12)


def test_a_reset_goes_to_a_start_in_less_than_a_millisecond(env):
    env.reset(seed=0)
    begin = time.process_time()
    for _ in range(50):
        env.reset()
    spent = (time.process_time() - begin) / 50
    assert spent < 1e-3, f"{1e3 * spent:.2f} ms"
    assert env.reset(options={"start": 1})[1] == {"time": pytest.approx(0.1), "start": 1}


def test_a_cache_keeps_the_starts_and_a_damaged_one_is_made_again(tmp_path, monkeypatch):
    advance, made = gym.Env._advance, []
    monkeypatch.setattr(gym.Env, "_advance", lambda env, rows: made.append(len(rows)) or advance(env, rows))
    with plate() as first:
        expected = episode(first, 1)
    for damage, steps in ((None, [0, 10]), (0, []), (100, [10])):
        if damage:
            (*_, last) = sorted(tmp_path.iterdir())
            last.write_bytes(last.read_bytes()[:-damage])
        made.clear()
        with plate(cache=tmp_path) as again:
            assert made == steps
            assert np.array_equal(episode(again, 1), expected)


def test_a_controller_leads_to_the_starts_and_another_one_makes_them_anew(tmp_path):
    def make(target):
        return lambda _seen, time: np.array([target if time > 0.05 else 0.1])

    lead, follow = make(0.3), make(0.1)

    with plate(starts=(0.0, 0.2), before=lead, cache=tmp_path) as first, plate() as own:
        own.reset(options={"start": 0})
        for _ in range(2):
            expected = own.step(lead(None, own.session.time))[0]
        found = first.reset(options={"start": 1})[0]
        assert np.array_equal(found, expected)
        after = first.step(np.array([0.0]))[0]
    for before, same in ((lead, True), (follow, False)):
        with plate(starts=(0.0, 0.2), before=before, cache=tmp_path) as again:
            assert np.array_equal(again.reset(options={"start": 1})[0], found) == same
            assert np.array_equal(again.step(np.array([0.0]))[0], after) == same


CONTROLLERS = {
    "closure": "def make(k): return lambda o, t: k * o\nf = make({})",
    "default": "def f(o, t, k={}): return k * o",
    "keyword default": "def f(o, t, *, k={}): return k * o",
    "number of the module": "k = {}\ndef f(o, t): return k * o",
    "array of the module": "k = np.array([{}])\ndef f(o, t): return (lambda: k * o)()",
    "called function": "def g(o): return {} if o else f(o, 0)\ndef f(o, t): return g(o)",
    "attribute": "def f(o, t): return np.sin(o) if {} < 0.2 else np.cos(o)",
    "object": "class Net:\n def __init__(self, w): self.w = [w]\n def __call__(self, o, t): return 0\nf = Net({})",
    "bound method": "class Net:\n def __init__(self, w): self.w = w\n def go(self, o, t): return 0\nf = Net({}).go",
    "method": "class Net:\n def __call__(self, o, t): return self.gain(o)\n def gain(self, o): return {}\nf = Net()",
    "value of a class": "class Net:\n gain = {}\n def __call__(self, o, t): return self.gain\nf = Net()",
    "slot": "class Net:\n __slots__ = 'w'\n def __call__(self, o, t): return 0\nf = Net()\nf.w = {}",
    "partial": "def g(k, o, t): return k * o\nf = functools.partial(g, {})",
    "cached function": "@functools.cache\ndef g(o): return {} * o\ndef f(o, t): return g(o)",
    "generator": "rng = np.random.default_rng(int(100 * {}))\ndef f(o, t): return rng.random()",
}
"""Controllers `f` with a place for a number that decides what they return."""


@pytest.mark.parametrize("kind", CONTROLLERS)
def test_a_controller_is_told_by_all_that_it_computes_with(kind):
    def made(number):
        names = {"__name__": "controllers", "np": np, "functools": functools}
        exec(compile(CONTROLLERS[kind].format(number), "controllers.py", "exec"), names)
        return identity.digest(names["f"])

    assert made(0.1) == made(0.1) != made(0.3)


def test_a_name_in_numpy_tells_a_controller():
    assert identity.digest(lambda o, _: np.sin(o)) != identity.digest(lambda o, _: np.cos(o))


def test_a_controller_has_the_same_digest_in_another_process():
    """Sets have another order there."""
    code = "from nervure.gym import identity, tasks; k = {'a', 'b', 'c'}; f = lambda o, t: (k, tasks.take_off(o, t))"
    asked = [sys.executable, "-c", f"{code}; print(identity.digest(f))"]
    said = {subprocess.check_output(asked, env={**os.environ, "PYTHONHASHSEED": seed}) for seed in "123"}
    assert len(said) == 1


def test_a_cache_is_refused_for_a_controller_that_cannot_be_told_from_others(tmp_path):
    lock = threading.Lock()
    with pytest.raises(InputError, match="cannot tell `before` from another controller: it holds a lock, which"):
        plate(starts=(0.1,), before=lambda _seen, _time: [float(lock.locked())], cache=tmp_path)
    plate(starts=(0.1,), before=lambda _seen, _time: [float(lock.locked())]).close()


def test_a_flyer_hovers_by_its_classical_controller_and_falls_without_one():
    with gym.tasks.hover() as env:
        heights = []
        for control in (gym.BASELINES["nervure/Hover-v0"], lambda _seen, _time: np.zeros(4)):
            seen, info = env.reset(options={"start": 0})
            for _ in range(30):
                seen, *_, info = env.step(control(seen, info["time"]))
            heights.append(seen[0])
    print(heights)
    assert abs(heights[0]) < 0.2 and heights[1] < -0.4


def test_a_picture_is_that_of_the_flow(env):
    env.reset(seed=0)
    first = env.render()
    env.step(np.array([0.3]))
    assert first.dtype == np.uint8 and first.shape[2] == 3 and min(first.shape[:2]) > 200
    assert not np.array_equal(first, env.render())


def test_a_unit_that_fails_ends_the_episode_and_the_next_one_begins(env):
    wild = gym.Action("root.angle", -1e6, 1e6, lag=1e-3)
    with gym.Env(load(PLATE), [wild], {"tip_uy": 1.0}, lambda _v, _a: 1.0, failed=-5.0) as failing:
        seen, _ = failing.reset(seed=0)
        after, reward, ended, truncated, info = failing.step(np.array([1e6]))
        assert (reward, ended, truncated) == (-5.0, True, False) and "rod: " in info["error"]
        assert np.array_equal(seen, after)
        failing.reset()
        assert failing.step(np.array([0.0]))[1:3] == (1.0, False)


def test_an_episode_is_truncated_by_the_step_that_reaches_the_end_of_the_scene():
    scene = load(PLATE).copy({"time.end": 0.25})
    with gym.Env(scene, [TURN], {"tip_uy": 0.1}, lambda _v, _a: 0.0, ends=lambda v: v["time"] > 0.26) as env:
        for _ in range(2):
            env.reset()
            assert [env.step(np.zeros(1))[2:4] for _ in range(3)] == [(False, False)] * 2 + [(True, True)]


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (
            {"actions": [gym.Action("root.z", 0, 1, 1)]},
            "an action 'root.z', but the scene leaves open root.x, root.y",
        ),
        ({"actions": [gym.Action("root.y", 1, 1, 1)]}, "root.y has the range 1 to 1 .* must be finite and not empty"),
        ({"actions": [gym.Action("root.y", 0, 1, 0)]}, "the lag 0 s, but .* the lag from 1e-100 to"),
        ({"actions": [gym.Action("root.y", 0, 1, 1e-200)]}, "the lag 1e-200 s, but .* the lag from 1e-100 to"),
        ({"actions": [TURN, TURN]}, "there are 2 actions 'root.angle', but an input follows one"),
        ({"observed": {"tip_uz": 1.0}}, "there is no column `tip_uz`: did you mean tip_uy"),
        ({"observed": {"tip_uy": 0.0}}, "tip_uy has the scale 0.0, but must have a finite one other than 0"),
        ({"starts": ()}, "there are no starts"),
        ({"starts": (0.0, 6.0)}, "a start is at 6.0 s, but must be from 0 to before the end of the scene, 6 s"),
        ({"starts": (0.0, -1.0)}, "a start is at -1.0 s, but must be from 0 to before the end of the scene, 6 s"),
        ({"steps": 0}, "steps is 0, but must be a whole number from 1 to 100000"),
        ({"steps": 10**9}, "steps is 1000000000, but must be a whole number from 1 to 100000"),
        ({"steps": True}, "steps is True, but must be a whole number"),
        ({"actions": ["root.y"]}, "an action is 'root.y', but must be a `nervure.gym.Action`"),
        ({"actions": gym.Action("root.y", -1, 1, 1)}, "actions is Action.*, but must be a list of"),
        ({"actions": [gym.Action("root.y", "-1", 1, 1)]}, "`low` of the action root.y is '-1', but must be a finite"),  # type: ignore[arg-type]
        ({"observed": ["tip_uy"]}, "observed is .*, but must be a dictionary of scales by column"),
        ({"observed": {"tip_uy": "1"}}, "the scale of tip_uy is '1', but must be a finite number"),
        ({"reward": None}, "reward is None, but must be a function of values and action"),
        ({"ends": 5}, "ends is 5, but must be a function of values"),
        ({"before": 5}, "before is 5, but must be a function of observation and time"),
        (
            {"before": lambda _seen, _time: [0.0, 0.0], "starts": (0.5,)},
            "what `before` returns is .*, but must be 1 finite",
        ),
        ({"starts": 0.5}, "starts is 0.5, but must be a list of finite numbers"),
        ({"failed": None}, "failed is None, but must be a finite number"),
        ({"cache": "/dev/null/x"}, "cannot write into the folder `cache`, /dev/null/x"),
        ({"render_mode": "human"}, "render_mode is 'human', but must be None or rgb_array"),
    ],
)
def test_what_cannot_be_an_environment_is_refused_with_name_and_value(changed, words):
    given = {"actions": [TURN], "observed": {"tip_uy": 1.0}, "reward": lambda _v, _a: 0.0} | changed
    with pytest.raises(InputError, match=words):
        gym.Env(load(PLATE), **given)


def test_an_action_or_a_start_that_is_none_is_refused(env):
    env.reset(seed=0)
    for action in ([np.nan], [0.1, 0.2], ["up"]):
        with pytest.raises(InputError, match="must be 1 finite number$"):
            env.step(np.array(action))
    with pytest.raises(InputError, match="the option start is 2, but must be from 0 to 1"):
        env.reset(options={"start": 2})


@pytest.mark.parametrize("reward", [math.nan, None, "much"])
def test_a_reward_that_is_no_number_is_refused(reward):
    with gym.Env(load(PLATE), [TURN], {"tip_uy": 1.0}, lambda _v, _a: reward) as env:
        env.reset(seed=0)
        with pytest.raises(InputError, match=f"the reward is {reward!r} at t = .* s, but must be a finite number"):
            env.step(np.zeros(1))


def test_a_closed_environment_says_so():
    """A failed episode would look like one that ends."""
    env = plate()
    env.reset(seed=0)
    env.close()
    for call in (lambda: env.step(np.array([0.1])), env.reset):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="the environment is closed"):
            call()


def test_environments_run_in_processes_of_their_own():
    several = gymnasium.vector.AsyncVectorEnv([plate, plate])
    try:
        seen, _ = several.reset(seed=[1, 2])
        after, *_ = several.step(np.array([[0.1], [-0.1]]))
    finally:
        several.close()
    assert seen.shape == after.shape == (2, 2) and after[0, 1] == -after[1, 1] != 0


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as made:
        yield made


def short():
    return plate(load(PLATE).copy({"time.end": 0.3}))


def test_environments_on_dask_have_the_bits_that_each_has_alone_over_several_episodes(cluster):
    """They end and begin again as those of gymnasium."""
    several = gym.DaskVectorEnv(short, 2, cluster)
    alone = gymnasium.vector.SyncVectorEnv([short, short])
    assert several.metadata["autoreset_mode"] == alone.metadata["autoreset_mode"]
    several.action_space.seed(1)
    try:
        pairs: list[tuple[tuple, tuple]] = [(several.reset(seed=5), alone.reset(seed=5))]
        for _ in range(8):
            actions = several.action_space.sample()
            pairs.append((several.step(actions), alone.step(actions)))
        for found, expected in pairs:
            assert all(np.array_equal(own, other) for own, other in zip(found[:-1], expected[:-1], strict=True))
            assert found[-1].keys() == expected[-1].keys()
            assert np.array_equal(found[-1]["time"], expected[-1]["time"])
        assert len({found[0].tobytes() for found, _ in pairs}) > 3 and sum(found[3].any() for found, _ in pairs[1:]) > 1
        seen = [several.reset(seed=5)[0], several.step(np.array([[0.1], [0.2]]))[0]]
        several.reset(seed=5)
        for wrong in ([[0.1], [np.nan]], np.zeros((1, 1)), np.zeros((3, 1)), np.zeros((2, 2)), [[0.1], []], 0.1, None):
            with pytest.raises(
                InputError, match=r"(?s)actions is .* must be an array of finite numbers of shape \(2, 1\)"
            ):
                several.step(wrong)
        assert np.array_equal(several.step(np.array([[0.1], [0.2]]))[0], seen[1]), "none had made a step"
        seeds: list[Any] = [[5], [5, 6, 7], "56", 0.5]
        for seed in seeds:
            with pytest.raises(InputError, match="seed is .*, but must be a number or a list of 2"):
                several.reset(seed=seed)
    finally:
        several.close()
        alone.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        several.reset()
    with pytest.raises(InputError, match="there are no starts"):
        gym.DaskVectorEnv(lambda: plate(starts=()), 2, cluster)
    assert len(cluster.scheduler_info["workers"]) == 2, "the workers of another one go on"


def test_environments_on_dask_end_the_processes_that_they_started():
    psutil = pytest.importorskip("psutil")
    before = {*psutil.Process().children(recursive=True)}
    several = gym.DaskVectorEnv(plate, 1)
    new = {*psutil.Process().children(recursive=True)} - before
    started = [own for own in new if "resource_tracker" not in " ".join(own.cmdline())]
    several.reset(seed=1)
    several.close()
    _, alive = psutil.wait_procs(started, timeout=5)
    assert len(started) > 0 and not alive


@pytest.mark.parametrize("count", [0, True, 1.5])
def test_a_number_of_environments_that_is_none_is_refused(count):
    with pytest.raises(InputError, match=f"count is {count}, but must be a whole number from 1"):
        gym.DaskVectorEnv(plate, count)


def test_a_policy_acts_in_a_run_as_it_does_in_its_environment():
    policy = runpy.run_path(str(ROOT / "examples" / "drive_policy.py"))["drive"]
    with Session(load(PLATE), drive=policy) as session:
        session.start()
        for _ in range(30):
            session.step()
        expected = session.recorder.values["tip_uy"], session.recorder.values["root.angle"]
    actions = [gym.Action(own["name"], own["low"], own["high"], own["lag"]) for own in policy.actions]
    seen = dict(zip(policy.names, policy.scales))
    with gym.Env(load(PLATE), actions, seen, lambda _v, _a: 0.0) as own:
        found, _ = own.reset()
        for _ in range(3):
            found, *_ = own.step(policy.choose(found))
        assert (own.values["tip_uy"], own.values["root.angle"]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", gym.BASELINES)
def test_a_task_is_registered_and_its_classical_controller_acts_in_its_range(name):
    env = gymnasium.make(name)
    seen, info = env.reset(seed=0)
    action = gym.BASELINES[name](seen, info["time"])
    assert env.action_space.contains(np.clip(action, env.action_space.low, env.action_space.high))
    assert np.isfinite(env.step(action)[1])
    own = env.unwrapped
    left = own.session.grid.steps - max(start.steps for start in own.starts)
    assert left >= env.spec.max_episode_steps * own.steps, "the limit of the episodes is that of the registry"
    env.close()


def test_an_environment_step_costs_no_more_than_the_steps_of_a_run_that_is_driven_as_it_is():
    """In processor time, the best of several rounds."""

    def drive(t, values):
        return dict(zip(("root.angle", "root.omega"), servo(t)))

    with plate(starts=(0.0,)) as env, Session(load(PLATE), drive=drive) as session:
        env.reset()
        session.start()
        both = []
        for _ in range(6):
            begin = time.process_time()
            for _ in range(5):
                env.step(np.array([0.2]))
            middle = time.process_time()
            for _ in range(50):
                session.step()
            both.append((middle - begin, time.process_time() - middle))
    own, run = (min(times) for times in zip(*both))
    assert own < 1.05 * run, f"{1e3 * own:.2f} ms against {1e3 * run:.2f} ms"
