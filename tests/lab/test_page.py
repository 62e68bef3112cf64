"""Parts of the page of the lab that need no browser: its address, and what it measures of a curve."""

import json
import shutil
import subprocess

import pytest

from nervure.resources import ROOT

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="there is no node")

SCENES = [
    {"id": "fsi3", "json": {}, "sliders": []},
    {"id": "vein", "json": {"a": 2}, "sliders": [{"id": "amplitude", "min": 0, "max": 1, "paths": ["a"]}]},
]
PAGE = (ROOT / "lab" / "page").as_uri()


def answer(script):
    """Return what a script answers, which sees `fromHash`, `measure` and `range`."""
    text = json.dumps(json.dumps(SCENES))
    source = f"""globalThis.document = {{ getElementById: () => ({{ textContent: {text} }}) }};
    const {{ fromHash }} = await import("{PAGE}/scenes.js");
    const {{ History, measure, range }} = await import("{PAGE}/plot.js");
    const measured = (...curves) => {{
      const history = new History(curves.length + 1, 4000);
      const rows = Array.from({{ length: 1000 }}, (_, i) => [i / 100, ...curves.map((f) => f(i / 100, i))]);
      history.add(Float64Array.from(rows.flat()));
      return measure(history, 1);
    }};
    const wave = (t) => Math.sin(2 * Math.PI * t);
    console.log(JSON.stringify({script}));"""
    done = subprocess.run(
        ["node", "--input-type=module", "-e", source], capture_output=True, text=True, check=True, timeout=30
    )
    return json.loads(done.stdout)


def test_what_an_address_does_not_know_falls_back():
    asked = ["#vein&amplitude=50%", "#fsi3?x", "#vein?amplitude=0.5", "#vein%26amplitude=0.25", "#%E0%A4", ""]
    found = answer(
        f"{json.dumps(asked)}.map(fromHash).map(({{ scene, values }}) => [scene.id, values.amplitude ?? null])"
    )
    assert found == [["vein", 2], ["fsi3", None], ["vein", 0.5], ["vein", 0.25], ["fsi3", None], ["fsi3", None]]


def test_rounding_has_no_frequency():
    curves = (
        "(t, i) => 1 + (i % 7 < 3 ? 3e-16 : -3e-16)",
        "(t) => 1e-14 * wave(3 * t), () => 1",
        "(t) => 1 + 1e-3 * wave(t)",
        "(t) => 1e-14 * wave(t), () => 1e-14",
    )
    found = answer(f"[{', '.join(f'measured({of})' for of in curves)}].map((own) => own.frequency)")
    assert found == [None, None, pytest.approx(1.0), pytest.approx(1.0)]


def test_the_blow_of_a_placed_cylinder_sets_no_axis():
    blow = answer("[measured((t, i) => wave(t) + (i > 800 && i < 805 ? 500 : 0)).amplitude, "
                  "range(Array.from({ length: 1000 }, (_, i) => wave(i / 100) + (i === 900 ? -500 : 0)))]")  # fmt: skip
    assert blow == [pytest.approx(1.0, abs=0.02), pytest.approx([-1.0, 1.0], abs=0.02)]
    assert answer("range([...Array(990).fill(0), ...Array(10).fill(3)])") == [0, 3], "what happens now is seen"
