"""Stability of the couplings: FSI3 with rods of other densities, over C_eta, H and scheme, and scenes with other
parts."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from nervure.coupling import Explicit
from studies import simulate
from studies.engine import COUPLED, Case, Run, Study
from studies.fsi3 import COARSE, RAMP
from studies.store import Data, Record

RATIOS = (0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0, 1000.0)  # Density of the rod over that of the fluid

START = 0.2  # Start-up of the inflow, s; 2 s in FSI3

END, END_OTHER, END_ITERATED, END_LONG = 1.5, 1.0, 0.6, 3.0
"""End of the runs, s: of the default explicit scheme, other explicit schemes, iterated schemes, and one run at full
amplitude. An unstable iteration fails at once; an explicit scheme may fail late."""

MOST_NOISE = 0.25
"""Standard deviation of the second difference of the lift by that of the lift; a run above it is bad. The mask that
crosses the grid alone gives 0.16 when the tip swings by 40 mm, from 5 to 10 s as from 25 to 30 s."""

NUDGED, NUDGE, NUDGED_STEPS = 10, 1e-6, 600
"""Step with increased loads, relative increase, and number of steps of these runs."""

SCHEMES: dict[str, dict[str, Any]] = simulate.LISTED["coupling"]["schemes"]


PARTS: dict[str, dict[str, Any]] = simulate.LISTED["coupling"]["parts"]
"""Scenes with a part that FSI3 on its coarse grid lacks."""
FACTORS, PART_STEPS = (0.1, 1.0, 10.0), 1000
"""Factors on the mass of the rods of these scenes, and communication steps of their runs."""


def cell(
    scheme: str, ratio: float, c_eta: float, step: float = 4e-4, end: float = END, max_step: float | None = None
) -> Case:
    long = "-long" if end == END_LONG else ""
    name = f"{scheme}/{ratio:g}-{c_eta:g}-{step:g}{long}".replace(", ", "-").replace(" ", "-")
    changes = {
        "name": name.replace("/", "-"),
        "time.end": end,
        "time.communication_step": step,
        "fluid.time_stepping.max_step": max_step or min(step, 4e-4),
        RAMP: START,
        "fluid.mask.log_linear.c_eta": c_eta,
        "rod.material.plane_strain.density": 1000.0 * ratio,
        "coupling": SCHEMES[scheme],
    }
    about = {"scheme": scheme, "ratio": ratio, "c_eta": c_eta, "step": step, "end": end}
    return Case(name, COUPLED, COARSE, changes, about=about)


def heavier(scene: dict[str, Any], factor: float) -> dict[str, Any]:
    """Return the change that multiplies the mass of all rods by `factor`."""
    rods = [(f"rods.{i}.rod", rod["rod"]) for i, rod in enumerate(scene.get("rods", ()))]
    changes = {}
    for key, rod in rods or [("rod", scene["rod"])]:
        for kind, material in rod["material"].items():
            (mass,) = {"density", "line_density"} & material.keys()
            changes[f"{key}.material.{kind}.{mass}"] = factor * material[mass]
    return changes


def part(name: str, factor: float) -> Case:
    scene, changes = PARTS[name]["scene"], PARTS[name].get("changes", {})
    built = simulate.changed(scene, changes)
    step, mask = built["time"]["communication_step"], built["fluid"]["mask"]
    changes = changes | heavier(built, factor) | {"time.end": PART_STEPS * step}
    if scene.startswith("fsi3"):
        changes |= {RAMP: START, "coupling": {}}
    about = {"scheme": name, "ratio": factor, "c_eta": next(iter(mask.values()))["c_eta"], "step": step}
    about |= {"end": PART_STEPS * step, "part": name}
    return Case(f"parts/{name.replace(',', '').replace(' ', '-')}-{factor:g}", COUPLED, scene, changes, about=about)


def tips(scene: dict[str, Any], folder: Path, nudge: float) -> np.ndarray:
    """Return the position of the tip after each step, `[steps, 2]` in m; the loads of one step are 1 + `nudge` times as
    large."""
    h = scene["time"]["communication_step"]
    with simulate.session(scene, folder) as session:
        units, scheme = session.units, session.scheme
        assert isinstance(scheme, Explicit)
        [link], take, now = scheme.links, scheme.take_loads, 0

        def nudged() -> None:
            take()
            if now == NUDGED:
                link.rod_loads[: link.stations.size // 2] *= 1 + nudge

        setattr(scheme, "take_loads", nudged)  # noqa: B010
        scheme.start()
        path = []
        for now in range(NUDGED_STEPS):
            scheme.step(h * now, h)
            path.append([units["rod"].outputs[units["rod"].slices[name]][-1] for name in "xy"])
        return np.array(path)


def come_apart(case: Case, folder: Path) -> dict[str, Any]:
    """Run twice, once with other loads in one step. Return the largest distance of both tips, m, its step, the distance
    at the end, and the largest way of the tip in all and in a step."""
    path, other = (tips(case.built(), folder, nudge) for nudge in (0.0, NUDGE))
    apart = np.abs(other - path).max(1)
    way = np.abs(path - path[0]).max(1)
    return {
        "way": float(way.max()), "in_a_step": float(np.abs(np.diff(path, axis=0)).max()),
        "apart": float(apart.max()), "at": int(apart.argmax()), "later": float(apart[200]), "last": float(apart[-1]),
    }  # fmt: skip


def rounding(name: str, density: float, tolerance: float | None) -> Case:
    changes = {"name": "rounding", RAMP: START, "fluid.mask.log_linear.c_eta": 1e-5,
               "rod.material.plane_strain.density": density, "coupling": {}}  # fmt: skip
    if tolerance:
        changes["coupling"] = {"scheme": {"iterated": {"tolerance": tolerance}}}
    return Case(
        f"rounding/{name}",
        COUPLED,
        COARSE,
        changes,
        action=come_apart,
        about={"density": density, "tolerance": tolerance},
    )


def cases() -> Iterator[Case]:
    c_etas = (1e-3, 1e-4, 1e-5)
    for light in (False, True):
        for ratio in (ratio for ratio in RATIOS if (ratio < 1) == light):
            for c_eta in c_etas:
                yield cell("default", ratio, c_eta, end=END_ITERATED if light else END)
            yield cell("default", ratio, 1e-6, end=END_ITERATED if light else END)
    for c_eta in c_etas:
        yield cell("default", 1.0, c_eta, 2e-4)
    for ratio in RATIOS:
        for c_eta in c_etas:
            if ratio >= 1:
                yield cell("momentum, parallel", ratio, c_eta, end=END_OTHER)
            yield cell("pressure jump", ratio, c_eta, end=END_OTHER)
        yield cell("pressure jump, parallel", ratio, 1e-4, end=END_OTHER)
    for ratio in (1.0, 1000.0):
        yield cell("momentum", ratio, 1e-4, 1.6e-3, END_OTHER, 4e-4)
    for ratio in (0.1, 1.0, 1000.0):
        yield cell("default", ratio, 1e-4, 1.6e-3, END_ITERATED, 4e-4)
    for ratio in (0.1, 1.0, 10.0, 1000.0):
        yield cell("Aitken", ratio, 1e-4, end=END_ITERATED)
    for ratio in (1.0, 1000.0):
        yield cell("IQN-ILS", ratio, 1e-4, end=END_ITERATED)
    yield cell("default", 0.1, 1e-4, 2e-4, END_ITERATED)
    yield cell("default", 1.0, 1e-4, end=END_LONG)
    for name in PARTS:
        for factor in FACTORS:
            yield part(name, factor)
    yield rounding("momentum", 1000.0, None)
    for tolerance in (1e-4, 1e-6):
        yield rounding(f"pressure jump, {tolerance:g}", 500.0, tolerance)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the time reached (s), iterations a step, and the noise of the last third: second difference by spread of
    the lift, or of the tips in scenes with other parts, because mirror images have no lift."""
    if "apart" in run.found:
        return {"values": run.found}
    summary, series = run.found, run.series
    values = {"reached": summary["simulated_s"]}
    if not summary["error"]:
        signals = [name for name in series if name.endswith("tip_uy")] if "part" in case.about else ["lift"]
        noises = []
        for signal in (series[name][-(series[name].size // 3) :] for name in signals):
            noises.append(float(np.std(np.diff(signal, 2)) / np.std(signal)))
        noise = max(noises)
        values |= {"iterations": summary["iterations_mean"], "noise": noise if np.isfinite(noise) else np.inf}
    return {"values": values, "times": simulate.times(summary)}


def outcome(record: Record) -> str:
    """Return `ok`, `error`, or `bad` for a run that reached its end with noise as its result."""
    return "error" if record.error else "ok" if record["noise"] < MOST_NOISE else "bad"


def mapped(data: Data) -> list[Record]:
    """Return the cells of the map, with the scenes with other parts."""
    return [record for record in data.of("coupling/*") if "scheme" in record.view]


STUDY = Study("coupling", cases, extract)
