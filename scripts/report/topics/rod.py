"""The rod: docs/rod.md and docs/rod."""

from collections.abc import Iterator

from cosim.scene import ROOT

from ..store import Row, csv_rows


def rows() -> Iterator[Row]:
    """docs/rod: error over n, error over the step and run time, cost of an iteration, stiff cells, situations."""
    folder, command = ROOT / "docs" / "rod", "make rod-study"
    for row in csv_rows(folder / "order_in_n.csv"):
        if row["plane"] == "xz":
            setting = f"g = {row['gravity']}, n = {row['n']}"
            yield Row(
                "rod-elastica",
                row["calibration"],
                setting,
                "tip",
                discretisation=float(row["error"]),
                size=float(row["n"]),
                command=command,
                source="docs/rod/order_in_n.csv",
            )
    for row in csv_rows(folder / "order_in_dt.csv"):
        yield Row(
            f"rod-swing, {row['case']}",
            row["scheme"],
            f"dt = {float(row['dt']):g} s",
            "tip",
            discretisation=float(row["error"]),
            step=float(row["dt"]),
            wall_s=float(row["seconds"]),
            command=command,
            source="docs/rod/order_in_dt.csv",
        )
    for row in csv_rows(folder / "runtime.csv"):
        for name in ("iteration_2d", "iteration_3d", "banded", "sparse", "dense"):
            if row[name]:
                yield Row(
                    "rod-cost",
                    name,
                    f"n = {row['n']}",
                    "time of one",
                    float(row[name]) * 1e6,
                    "µs",
                    size=float(row["n"]),
                    command=command,
                    source="docs/rod/runtime.csv",
                )
    for row in csv_rows(folder / "extreme.csv"):
        setting = ", ".join(f"{name} = {float(row[name]):g}" for name in ("n", "k_e", "EI", "dt"))
        yield Row(
            "map rod",
            "TR-BDF2",
            setting,
            "outcome",
            size=float(row["n"]),
            step=float(row["dt"]),
            **ended(row["result"]),
            source="docs/rod/extreme.csv",
        )
    for row in csv_rows(folder / "situations.csv"):
        yield Row(
            "map rod situations",
            row["scheme"],
            row["situation"],
            "outcome",
            **ended(row["result"]),
            source="docs/rod/situations.csv",
        )


def ended(result: str) -> dict[str, str]:
    """Outcome and reason: a gain of energy is what a rod must not have without saying so."""
    if result == "ok":
        return {}
    return {"outcome": "bad" if result.startswith("gain") else "error", "reason": result}
