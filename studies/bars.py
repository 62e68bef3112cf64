"""Error bars of shipped scenes by `nervure verify`, as a user of the scene gets them, beside published values."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from shutil import rmtree
from time import process_time
from typing import Any

from nervure.errors import InputError
from nervure.scene import validate
from nervure.verification.process import Verification
from studies import simulate, space
from studies.engine import COUPLED, FLUID, ROD, Case, Study
from studies.store import Data

BUDGET = 300.0  # Processor time of each verification, s
WING = (*COUPLED, "wing")
SCENES: dict[str, tuple[float, tuple[str, ...], tuple[str, ...]]] = {
    "csm1": (0.01, ROD, ("tip_ux_mean", "tip_uy_mean")),
    "csm3": (0.02, ROD, ("tip_uy_mean", "tip_uy_amplitude", "tip_uy_frequency_hz")),
    "cylinder-2d1-450x90": (0.01, FLUID, ("cd_mean", "dp_mean")),
    "sphere-oscillating-64x64x64": (0.05, FLUID, ("drag_amplitude",)),
    "plate-stream-96x72x72": (0.05, FLUID, ("drag_mean", "lift_mean")),  # As a surface at 30°
    "flag-line-480x240": (0.05, COUPLED, ("tip_uy_amplitude", "tip_uy_frequency_hz")),
    "fsi3-324x54": (0.05, COUPLED, ("tip_uy_amplitude", "tip_uy_frequency_hz", "drag_mean", "lift_amplitude")),
    "wing-hover-64x64x84": (0.1, WING, ("lift_mean", "drag_amplitude")),
}
"""Tolerance, sources and quantities of the verified scenes."""


def cases() -> Iterator[Case]:
    for name, (within, sources, quantities) in SCENES.items():
        options = {"within": within, "budget": BUDGET, "quantities": quantities}
        changes = space.SHEET | space.turned(30) if name.startswith("plate") else {}
        yield Case(f"scene/{name}", (*sources, "verification"), name, changes, options, verified)


def verified(case: Case, folder: Path) -> dict[str, Any]:
    """Verify a scene by processor time; return a row for each quantity, the errors and cost of the recommended setting,
    and the part of the budget that was spent."""
    within, budget, quantities = (case.options[key] for key in ("within", "budget", "quantities"))
    begin = process_time()
    rmtree(folder / "runs", ignore_errors=True)
    runs = Verification(
        validate(case.built()), folder / "runs", within, budget, quantities, workers=1, force=True, cpu=True
    )
    found = runs.run()
    spent = process_time() - begin
    if found.verified is None:
        raise InputError("; ".join(found.problems))
    known = {} if case.changes else simulate.published(case.scene)
    rows = []
    for name, quantity in found.verified.quantities.items():
        row = {
            "quantity": name,
            "value": quantity.value,
            "limit": quantity.limit,
            "bar": quantity.uncertainty / quantity.scale,
        }
        value, scale = next((pair for key, pair in known.items() if key.replace(".", "_") == name), (None, None))
        rows.append(row | ({"published": value, "off": (quantity.limit - value) / scale} if value and scale else {}))
    own = found.verified
    values = {"runs": own.runs, "error": own.recommended_error}
    times = {"spent_s": spent, "cost": own.wall_s / own.recommended_wall_s if own.recommended_wall_s else None}
    return {"values": values, "tables": {"bars": rows}, "times": times, "problems": found.problems}


def by_scene(data: Data) -> list[dict[str, Any]]:
    """Return the bars of each scene, the first one with what its verification took."""
    rows = []
    for record in data.of("bars/scene/*"):
        about = {"within": record.case.options["within"], "spent": record["spent_s"]}
        for row in record.tables["bars"]:
            name = record.case.scene + " at 30°" * bool(record.case.changes)
            rows.append({"scene": name, **row, **about})
            about = {}
    return rows


STUDY = Study("bars", cases, lambda case, run: {key: part for key, part in run.found.items() if key != "problems"},
              {"bars": by_scene})  # fmt: skip
