"""The pages of the lab and of a run in a browser: the digits of the units, scenes, controls, and accessibility."""

import json
import subprocess
import sys
import time

import make_lab
import numpy as np
import pytest
import record_digits

import nervure
from nervure.evaluate import statistics
from nervure.resources import ROOT
from nervure.scene import validate
from tests.lab.browser import AXE, CHROMIUM, PAGE, Browser, opened, rows, wait
from tests.simulation.record import RECORDED

EARLY = json.loads(RECORDED.read_text(encoding="utf-8"))["early"]
SCENES = {own["id"]: own for own in make_lab.scenes()}

pytestmark = [
    pytest.mark.usefixtures("libraries"),
    pytest.mark.skipif(not PAGE.is_file(), reason="`make lab` has not built the page"),
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
]


@pytest.fixture(scope="module")
def browser():
    subprocess.run([sys.executable, make_lab.__file__, PAGE], check=True)  # with the sources as they are
    with Browser() as browser:
        yield browser


def test_fsi3_has_the_digits_of_the_units(browser):
    found = rows(opened(browser, "#fsi3"), 500)
    for i in (0, 1):  # t = 0.1 s and 0.2 s
        expected = [EARLY[name][i] for name in ("drag", "lift", "tip_ux", "tip_uy")]
        assert found[250 * (i + 1) - 1][1:] == pytest.approx(expected, rel=1e-8)


def test_fsi3_flaps_as_with_the_units(browser, tmp_path):
    coarse = {"fluid.box.cells": [162, 36], "fluid.inflow.mean_velocity": {"constant": 2.0}, "time.end": 3.0}
    coarse |= {"time.communication_step": 8e-4, "fluid.time_stepping.max_step": 8e-4}
    scene = nervure.load("fsi3-325x72").copy(coarse)
    units = nervure.run(scene, tmp_path, quiet=True).series
    text = json.dumps(json.dumps(scene.document()))
    opened(browser, "#fsi3").run(f"lab.ask('load', {{ scene: {text} }})")
    found = np.array(rows(browser, len(units["time"]) - 1))
    series = {"time": found[:, 0], "tip_uy": found[:, 4]}
    page, expected = (
        statistics.evaluate(time, uy, statistics.find_window(time, uy))
        for time, uy in ((own["time"], own["tip_uy"]) for own in (series, units))
    )
    assert expected.amplitude > 0.03 and expected.frequency_hz > 6, "the bar flaps"
    assert vars(page) == pytest.approx(vars(expected), rel=0.01, abs=0.01 * expected.amplitude)


def test_a_wing_has_the_digits_of_the_units(browser):
    recorded = json.loads(record_digits.RECORDED.read_text(encoding="utf-8"))
    scene = nervure.load(recorded["scene"]).copy(recorded["set"])
    text = json.dumps(json.dumps(scene.document()))
    opened(browser, "#wing").run(f"lab.ask('load', {{ scene: {text} }})")
    found = rows(browser, recorded["steps"])[-1]
    expected = np.array([recorded["outputs"][name] for name in record_digits.COLUMNS])
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("name", SCENES)
def test_scenes_run_and_are_scenes_of_the_command(browser, name):
    found = rows(opened(browser, f"#{name}"), 10)
    scene = browser.run("lab.scene()")
    validate(scene)
    assert scene == SCENES[name]["json"]
    assert found[-1][0] == pytest.approx(10 * scene["time"]["communication_step"])
    assert not browser.errors()


@pytest.mark.parametrize("name", SCENES)
def test_ends_of_the_sliders_are_scenes_that_run(browser, name):
    for end in ("min", "max"):
        state = "&".join([name, *(f"{own['id']}={own[end]}" for own in SCENES[name]["sliders"])])
        rows(opened(browser, f"#{state}"), 3)
        validate(browser.run("lab.scene()"))


def test_a_link_keeps_the_state(browser):
    state = "#flag&stiffness=5&cylinder=1.5,0.4,0.1&field=speed"
    scene = opened(browser, state).run("lab.scene()")
    assert scene["rod"]["material"]["section"]["bending_stiffness"] == pytest.approx(5e-4)
    assert scene["fluid"]["cylinders"] == [{"center": [1.5, 0.4], "radius": 0.1}]
    assert browser.run("location.hash") == state


def test_a_changed_value_continues_the_flow(browser):
    rows(opened(browser, "#flag"), 20)
    browser.run("""{ const slider = document.getElementById("s-speed"); slider.value = 900;
                     slider.dispatchEvent(new Event("input")); }""")
    wait(browser, "lab.scene().name.endsWith('-lab')")
    ((t, *_),) = rows(browser, 1)
    assert t == pytest.approx(21 * SCENES["flag"]["json"]["time"]["communication_step"])


def test_a_placed_cylinder_continues_the_flow(browser):
    ((_, before, *_),) = rows(opened(browser, "#flag"), 20)[-1:]
    browser.run("lab.place([1.5, 0.4], 0.1)")
    found = rows(browser, 5)
    assert found[-1][0] == pytest.approx(25 * SCENES["flag"]["json"]["time"]["communication_step"])
    assert found[-1][1] > 2 * before


def test_an_arrow_key_pulls_the_rod(browser):
    wait(opened(browser, "#filament"), "lab.shapes().length > 0")
    browser.run("document.getElementById('flow').focus()")
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowDown")
    pulled = rows(browser, 40)[-1][4]
    browser.call("Input.dispatchKeyEvent", type="keyUp", key="ArrowDown")
    free = rows(opened(browser, "#filament"), 40)[-1][4]
    assert pulled < free - 1e-3


def test_a_stiff_wing_twists_less(browser):
    stiff, own = (rows(opened(browser, state), 120)[-1] for state in ("#wing&stiffness=10", "#wing"))
    assert abs(own[-1]) > 4.0 * abs(stiff[-1]) > 0.01
    scene = opened(browser, "#wing&stiffness=0.5").run("lab.scene()")
    veins = zip(scene["wing"]["veins"], SCENES["wing"]["json"]["wing"]["veins"], strict=True)
    assert all(here["bending_stiffness"] == pytest.approx(0.5 * there["bending_stiffness"]) for here, there in veins)


COLOURS = """{ const { width, height } = document.getElementById("flow");
    const { data } = document.getElementById("flow").getContext("2d").getImageData(0, 0, width, height);
    [...new Uint32Array(data.buffer)]; }"""


def test_space_is_seen_from_the_side_to_which_keys_and_the_mouse_turn_it(browser):
    rows(opened(browser, "#wing"), 200)

    def drawn():
        browser.run("lab.draw()")
        time.sleep(0.5)
        return np.array(browser.run(COLOURS))

    first, camera = drawn(), browser.run("lab.camera()")
    assert np.unique(first).size > 100, "vorticity, and a wing over it"
    browser.run("document.getElementById('flow').focus()")
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowRight")
    assert browser.run("lab.camera()") == pytest.approx([camera[0] + 0.12, camera[1]])
    turned = drawn()
    assert np.mean(turned != first) > 0.05
    for kind, x in (("mousePressed", 400), ("mouseMoved", 340), ("mouseReleased", 340)):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=300, button="left", buttons=1, clickCount=1)
    assert browser.run("lab.camera()")[0] > camera[0] + 0.12 + 0.3
    hidden = "[...document.querySelectorAll('#tools, [name=field][value=pressure]')].map((own) => own.offsetParent)"
    assert browser.run(hidden) == [None, None]
    assert browser.run("(location.hash = '#fsi3', true)")
    wait(browser, "lab.camera() === null")


def test_what_fails_is_said(browser):
    opened(browser)
    with pytest.raises(RuntimeError, match="missing required key"):
        browser.run("lab.ask('load', { scene: '{}' })")
    # A panic ends the program: this picture has more pixels than there are addresses.
    view = "{ field: 0, range: [0, 1], part: [0, 1, 0, 1], pixels: [2 ** 31, 4], colours: [] }"
    browser.run(f"lab.restart().then(() => lab.ask('view', {{ view: {view} }}))")
    with pytest.raises(RuntimeError, match="panicked at"):
        browser.run("lab.step(1)")
    browser.run("lab.restart()")
    assert len(rows(browser, 2)) == 2


def test_controls_have_names(browser):
    nodes = opened(browser).call("Accessibility.getFullAXTree")["nodes"]
    controls = [own for own in nodes if any(p["name"] == "focusable" for p in own.get("properties", ()))]
    named = [own for own in controls if own.get("role", {}).get("value") != "RootWebArea"]
    assert len(named) > 15
    assert all(own["name"]["value"] for own in named), [own for own in named if not own["name"]["value"]]


@pytest.mark.skipif(not AXE.is_file(), reason="`make lab-test` has not fetched axe-core")
@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize(("scene", "width"), [("fsi3", 390), ("fsi3", 1280), ("wing", 390)])
def test_nothing_stands_in_the_way_of_anybody(browser, scene, width, dark):
    feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    browser.call("Emulation.setEmulatedMedia", features=[feature])
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
    rows(opened(browser, f"#{scene}"), 100)
    checked(browser)
    browser.call("Emulation.clearDeviceMetricsOverride")


def checked(browser):
    """Check the accessibility of the open page."""
    browser.run(AXE.read_text(encoding="utf-8"))
    found = browser.run("axe.run().then(({ violations, passes }) => ({ violations, passes: passes.length }))")
    told = [(own["id"], own["help"], [node["html"] for node in own["nodes"]]) for own in found["violations"]]
    assert not told and found["passes"] > 15


def test_the_page_of_a_run_says_that_the_run_was_killed(browser, tmp_path):
    command = [sys.executable, "-m", "nervure", "run", "fsi3-325x72", "--live", "--quiet", "--output", tmp_path / "run"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as run:
        browser.open(run.stdout.readline().removeprefix("live: ").strip())
        wait(browser, "document.getElementById('done')?.value > 0 && !document.getElementById('flow').hidden")
        browser.run("drawChart = () => {}; charts.length = 0; find('charts').replaceChildren(); addCharts()")
        assert browser.run("[...document.querySelectorAll('[role=img]')].every((own) => own.ariaLabel)")
        if AXE.is_file():
            checked(browser)
        run.kill()
    wait(browser, "document.getElementById('said').textContent.includes('was killed')")
    assert not browser.errors()
