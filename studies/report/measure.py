"""Runs cases, each in a process of one thread, and makes rows of them."""

import json
import os
import shlex
import statistics
import subprocess

from nervure.resources import ROOT

from .cases import QUANTITIES, TOLERANCE, Case, references
from .store import Row

THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")}

LONGEST = 3600.0
"""Wall time that a case may take, s."""


def shown(case: Case) -> str:
    """A command that repeats the case."""
    if case.peer:
        return f"target/report/venv/bin/python studies/peers/{' '.join(case.peer)} {case.repeats}"
    return f"python scripts/report measure --only {shlex.quote(case.name)}"


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """Lower quartile, median and upper quartile."""
    if len(values) == 1:
        return (values[0],) * 3
    return tuple(statistics.quantiles(values, n=4, method="inclusive"))


def values_of(case: Case, found: dict) -> dict[str, float | None]:
    if "values" in found:  # a peer
        return found["values"]
    if found["coefficients"]:
        return found["coefficients"]["values"]
    return {
        f"{q}.{what}": value
        for q, part in found["quantities"].items()
        for what, value in (part | {"fit": (part["fit"] or {}).get("amplitude")}).items()
    }


def measure(case: Case) -> list[Row]:
    """Rows of a case; one row with the reason if it failed."""
    given = None if case.peer else json.dumps(case.scene())
    failed = Row(
        case.case,
        case.method,
        case.setting,
        "all",
        size=case.size,
        step=case.step,
        outcome="error",
        command=shown(case),
    )
    try:
        done = subprocess.run(
            case.command(),
            input=given,
            env=os.environ | THREADS,
            capture_output=True,
            text=True,
            timeout=LONGEST,
            cwd=ROOT,
        )
    except subprocess.TimeoutExpired:
        failed.reason = f"no end after {LONGEST:g} s"
        return [failed]
    except FileNotFoundError:
        failed.reason = "not installed: make target/report/venv/.ready"
        return [failed]
    if done.returncode != 0:
        failed.reason = done.stderr.strip().splitlines()[-1]
        return [failed]
    found = json.loads(done.stdout.strip().splitlines()[-1])
    if found.get("error"):
        failed.reason = found["error"]
        return [failed]
    if case.case == "cost":
        return cost(case, found)
    values, published, limit = values_of(case, found), references(case.case), case.limit()
    rows = []
    for name in QUANTITIES[case.case]:
        value = values.get(name)
        if value is None:
            continue
        expected, scale = published.get(name, (None, None))
        exact = limit.get(name)
        rows.append(
            Row(
                case.case,
                case.method,
                case.setting,
                name,
                value,
                unit_of(name),
                expected,
                (value - expected) / scale if expected is not None else None,
                (value - exact) / abs(exact) if exact is not None else None,
                size=found.get("dofs", case.size),
                step=case.step,
                **times(found),
                command=shown(case),
                tolerance=None if case.peer else TOLERANCE[case.case],
            )
        )
    phases = found.get("phases_s") or {}
    loop = sum(seconds for phase, seconds in phases.items() if phase != "output")
    for phase, seconds in phases.items():
        rows.append(
            Row(
                f"phases {case.case}",
                case.method,
                case.setting,
                phase,
                seconds / loop,
                "by wall time of the loop",
                size=case.size,
                step=case.step,
                command=shown(case),
            )
        )
    return rows


def times(found: dict) -> dict[str, float]:
    """What a row says of the time that its runs took: medians and quartiles, s."""
    wall, cpu = (quartiles([run[i] for run in found["runs"]]) for i in (0, 1))
    names = ("wall_q1", "wall_s", "wall_q3", "cpu_q1", "cpu_s", "cpu_q3")
    return dict(zip(names, (*wall, *cpu))) | {"repeats": len(found["runs"])}


def cost(case: Case, found: dict) -> list[Row]:
    """µs a step: the median CPU time of the whole, the shortest wall times of the parts."""
    shared = {"unit": "µs", "size": case.size, "step": case.step, "command": shown(case)}
    micro = 1e6 / found["steps"]
    rows = [
        Row(
            case.case,
            case.method,
            case.setting,
            "step",
            statistics.median(run[1] for run in found["runs"]) * micro,
            **times(found),
            **shared,
        )
    ]
    return rows + [
        Row(case.case, case.method, case.setting, phase, seconds * micro, **shared)
        for phase, seconds in found["phases_s"].items()
    ]


def unit_of(quantity: str) -> str:
    name, _, what = quantity.partition(".")
    if what == "frequency_hz":
        return "Hz"
    return {"tip_ux": "m", "tip_uy": "m", "drag": "N/m", "lift": "N/m", "dp_mean": "Pa"}.get(name, "1")
