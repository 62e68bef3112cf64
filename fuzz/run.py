"""Run the fuzz targets one after the other, and write docs/fuzz.csv of what they did.

python fuzz/run.py -max_total_time=60       options are libFuzzer's; `make fuzz` does it
"""

import re
import subprocess
import sys
from pathlib import Path

FUZZ = Path(__file__).resolve().parent
sys.path.insert(0, str(FUZZ.parent / "studies"))

from nervure.files import write_csv

TARGETS = ("rod_state", "fluid_state", "rod_scene", "fluid_scene")
TABLE = FUZZ.parent / "docs" / "fuzz.csv"
OPTIONS = ("-timeout=30", "-max_len=65536", f"-dict={FUZZ / 'target' / 'scene.dict'}", "-print_final_stats=1")


def run(target: str, options: list[str]) -> dict:
    """A row of the table; what libFuzzer says is shown as it comes."""
    command = ["cargo", "+nightly", "fuzz", "run", "--fuzz-dir", FUZZ, target, "--", *OPTIONS, *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, errors="replace")
    said = []
    for line in process.stderr:
        sys.stderr.write(line)
        said.append(line)
    text = "".join(said)
    found = re.search(r"^SUMMARY: (.*)", text, re.M)
    done = re.search(r"^Done (\d+) runs in (\d+) second", text, re.M)
    if process.wait() and not found:
        raise SystemExit(f"{target} did not run")
    inputs, seconds = done.groups() if done else ("", "")
    return {"target": target, "inputs": inputs, "seconds": seconds, "found": found[1] if found else "nothing"}


def main(options: list[str]) -> int:
    rows = [run(target, options) for target in TARGETS]
    write_csv(TABLE, rows)
    return any(row["found"] != "nothing" for row in rows)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or ["-max_total_time=300"]))
