"""Bodies that settle in a tank, and spheres that bounce from its floor, beside published values."""

from __future__ import annotations

import cmath
from collections.abc import Iterator
from math import pi, tau
from typing import Any

import numpy as np

from nervure.resources import ROOT
from studies import simulate
from studies.engine import FLUID, Case, Run, Study

SPHERE, CYLINDER = "sphere-settling-80x80x120", "cylinder-settling-140x392"
TANKS = {1.5: (970, 0.373, 4.2, 0.0363), 4.1: (965, 0.212, 2.45, 0.0571), 11.6: (962, 0.113, 1.7, 0.0869),
         31.9: (960, 0.058, 1.28, 0.1226)}  # fmt: skip
"""By the Reynolds number: density, kg/m³, and viscosity, Pa s, of the fluid, end of the run, s, and largest speed, m/s,
of the spheres of ten Cate et al. (2002)."""
STEP = 0.0028 * 0.1226  # Length of a step by the speed, m
REYNOLDS = 495
"""Largest Reynolds number of the cylinder (Uhlmann 2005; from 438 to 466 by Glowinski et al. 2001, 503 by Wang et al.
2008), with the density of the body. That is inferred: only so does the case of a density ratio of 1.25 and ten times
the viscosity, published at 17.3, agree (17.4 on 16 cells)."""

REBOUND = str(ROOT / "examples" / "sphere-rebound.json")
ROUGHNESS = {"": 1e-4, ", rough": 3e-3}
"""Roughness by the radius: of the beads of Gondret et al. (2002), and as Biegert et al. (2017) calibrate it."""
FINE = (1.07e-5, 935.0, 8.342, 0.003, 12)
"""Viscosity, m²/s, density, kg/m³, ratio of densities, diameter, m, and cells across the sphere at St 152."""
BOUNCES = {
    27: {"impact": 0.518, "first": 0.329},
    152: {"impact": 0.585, "first": 2.489, "second": 0.745, "third": 0.173},
}
"""By the Stokes number: speed of the fall, m/s, and heights of the gap after the bounces by the diameter (Gondret et
al. 2002, digitized by Biegert et al. 2017)."""
PAIR = str(ROOT / "examples" / "drafting-spheres.json")
KISS = 18.2
"""Time at which the upper of two spheres reaches the lower one, s: 18.03 to 18.34 in FeatFloWer by the model of
contact. Here they are then within the range of contact."""
HEIGHTS = {27: 12.5, 152: 22}
"""Heights at the start by the diameter."""
START, RELEASE = 40.0, 0.5
"""Rate of the smooth start to the speed of the fall, 1/s, and gap at which the sphere is free, by the diameter."""


def led(height: float, diameter: float, speed: float) -> dict[str, Any]:
    """Return the changes of the scene for a sphere that is led from a height (m) to `RELEASE` with the velocity
    u (exp(-40 t) - 1)."""
    times = np.linspace(0.0, 1.0, 10_001)
    ways = speed * (times + np.expm1(-START * times) / START)
    release = float(np.interp(height - (0.5 + RELEASE) * diameter, ways, times))
    times = np.linspace(0.0, release, 41)
    ways, slope = -speed * (times + np.expm1(-START * times) / START), speed * float(np.expm1(-START * release))
    table = {"times": times.tolist(), "values": ways.tolist(), "end_slopes": [0.0, slope]}
    return {"fluid.bodies.0.motion": {"z": {"table": table}}, "fluid.bodies.0.mount.release": release}


def falling(nu: float, density: float, ratio: float, diameter: float, cells: int) -> dict[str, Any]:
    """Return the changes of the scene for a sphere in a box 24 diameters high and 6 wide; arguments as of `FINE`."""
    side, ends, step = 3 * diameter, [-0.5 * diameter, 23.5 * diameter], 0.2 * diameter / cells / BOUNCES[152]["impact"]
    return {
        "fluid.kinematic_viscosity": nu,
        "fluid.density": density,
        "fluid.box": {"x": [-side, side], "y": [-side, side], "z": ends, "cells": [6 * cells, 6 * cells, 24 * cells]},
        "fluid.channel.z": [0.0, 23 * diameter],
        "fluid.bodies.0.shape.sphere.radius": 0.5 * diameter,
        "fluid.bodies.0.position": [0.0, 0.0, HEIGHTS[152] * diameter],
        "fluid.bodies.0.mount.mass": ratio * density * np.pi / 6 * diameter**3,
        "fluid.mask.log_linear.c_eta": step / 50,
        "time.end": 0.3,
    } | dict.fromkeys(("time.communication_step", "fluid.time_stepping.max_step"), step)


NU, DISPLACED = 0.04, pi / 6
"""Viscosity, m²/s, and displaced mass, kg, of a sphere of the diameter 1 m on a spring, twice as heavy as its fluid."""
STIFFNESS = (tau / 4) ** 2 * 2.5 * DISPLACED


def stokes() -> tuple[float, float]:
    """Return period, s, and damping by the critical one of the sphere on a spring in slow flow: at the complex rate s
    the force is -(m s + 6 pi mu R (1 + R (s/nu)^1/2)) v with half of the displaced mass as m (Stokes 1851)."""
    rate = 1j * tau / 4
    for _ in range(100):
        drag = 3 * pi * NU * (1 + 0.5 * cmath.sqrt(rate / NU))
        rate = 1j * cmath.sqrt(STIFFNESS / (2.5 * DISPLACED + drag / rate))
    return tau / rate.imag, -rate.real / rate.imag


def springs() -> Iterator[Case]:
    """Yield the sphere on a spring in a box of 12.8 diameters, on two grids."""
    position, start = [0.01, 0.02, 0.03], 0.05
    mount = {"mass": 2 * DISPLACED, "y": {"stiffness": STIFFNESS, "rest": -start}}
    period, damping = stokes()
    for n, ratio, side in ((10, 2, 1.8), (20, 4, 2.2)):
        box, fine = ({axis: [-half, half] for axis in "xyz"} for half in (6.4, side))
        changes: dict[str, Any] = {
            "time": {"end": 14.0, "communication_step": 0.4 / n},
            "fluid": {
                "density": 1.0,
                "kinematic_viscosity": NU,
                "box": box | {"cells": [128 * n // 10 // ratio] * 3},
                "fine_box": fine | {"ratio": ratio},
                "mean_flow": {axis: {"constant": 0.0} for axis in "xyz"},
                "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": position, "mount": mount}],
                "mask": {"log_linear": {"c_eta": 1e-4}},
                "time_stepping": {"max_step": 0.4 / n, "max_cfl": 0.4},
            },
        }
        about = {"expected": {"period": period, "damping": damping}, "grid": f"{n} cells"}
        yield Case(f"spring/{n} cells", FLUID, SPHERE, changes, about=about)


def rings(run: Run) -> dict[str, float]:
    """Return period, s, and damping of the second cycle of the sphere on a spring."""
    time, way = run.series["time"], run.series["body_1_y"] - run.series["body_1_y"][0] + 0.05
    passes = np.flatnonzero(way[:-1] * way[1:] < 0)
    times = time[passes] - way[passes] * np.diff(time)[passes] / np.diff(way)[passes]
    turns = np.abs(way[1:-1][np.diff(way)[:-1] * np.diff(way)[1:] < 0])
    return {"period": float(times[3] - times[1]), "damping": float(np.log(turns[0] / turns[2])) / tau}


def cases() -> Iterator[Case]:
    yield from springs()
    for reynolds, (density, viscosity, end, speed) in TANKS.items():
        changes: dict[str, Any] = {"fluid.density": density, "fluid.kinematic_viscosity": viscosity / density}
        changes |= {"time.end": end} | dict.fromkeys(
            ("time.communication_step", "fluid.time_stepping.max_step"), STEP / speed
        )
        about = {"expected": {"speed": speed}, "grid": f"Re {reynolds}"}
        yield Case(f"sphere/Re {reynolds}", FLUID, SPHERE, changes, about=about)
    expected = {"reynolds": REYNOLDS}
    finer = {"fluid.box.cells": [210, 588]} | dict.fromkeys(
        ("time.communication_step", "fluid.time_stepping.max_step"), 1e-4
    )
    for n, changes in ((16, {}), (24, finer)):
        about = {"expected": expected, "grid": f"{n} cells"}
        yield Case(f"cylinder/{n} cells", FLUID, CYLINDER, changes, about=about)
    finer = {"fluid.box.cells": [84, 84, 300], "fluid.mask.log_linear.c_eta": 6e-4}
    finer |= dict.fromkeys(("time.communication_step", "fluid.time_stepping.max_step"), 0.03)
    for n, changes in ((8, {}), (12, finer)):
        yield Case(f"pair/{n} cells", FLUID, PAIR, changes, about={"expected": {"kiss": KISS}, "grid": f"{n} cells"})
    for stokes, (label, roughness) in [(27, own) for own in ROUGHNESS.items()] + [(152, (", rough", 3e-3))]:
        changes, diameter = ({"time.end": 0.22}, 0.006) if stokes == 27 else (falling(*FINE), FINE[3])
        changes |= led(HEIGHTS[stokes] * diameter, diameter, BOUNCES[stokes]["impact"])
        changes["contact.film.roughness"] = roughness * 0.5 * diameter
        about = {"expected": BOUNCES[stokes], "grid": f"St {stokes}{label}"}
        yield Case(f"rebound/St {stokes}{label}", FLUID, REBOUND, changes, about=about)


def bounces(case: Case, run: Run) -> dict[str, float]:
    """Return the largest speed of the fall, m/s, and the heights of the gap after the bounces by the diameter."""
    radius = case.built()["fluid"]["bodies"][0]["shape"]["sphere"]["radius"]
    gap, speed = 0.5 * (run.series["body_1_z"] / radius - 1), run.series["body_1_vz"]
    tops = gap[1:][(speed[:-1] > 0) & (speed[1:] <= 0) & (gap[1:] > 0.01)]
    return {"impact": float(-speed.min())} | dict(zip(("first", "second", "third"), map(float, tops), strict=False))


def kiss(case: Case, run: Run) -> float:
    """Return the first time at which two spheres of diameter 1 m are within the range of contact, s."""
    way = np.array([run.series[f"body_2_{axis}"] - run.series[f"body_1_{axis}"] for axis in "xyz"])
    near = np.linalg.norm(way, axis=0) < 1 + case.built()["contact"]["range"]
    return float(run.series["time"][np.argmax(near)])


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the largest speed, m/s, of the cylinder as a Reynolds number; see `bounces`."""
    if case.scene == REBOUND:
        values: dict[str, Any] = bounces(case, run)
        values = {name: value for name, value in values.items() if name in case.about["expected"]}
    elif case.scene == PAIR:
        values = {"kiss": kiss(case, run)}
    elif case.name.startswith("spring/"):
        values = rings(run)
    elif case.scene == SPHERE:
        values = {"speed": float(-run.series["body_1_vz"].min())}
    else:
        values = {"reynolds": float(-run.series["body_1_vy"].min()) * 2.5e-3 / 1e-6 * 1.5}
    return {"values": values, "times": simulate.times(run.found)}


STUDY = Study("settling", cases, extract)
