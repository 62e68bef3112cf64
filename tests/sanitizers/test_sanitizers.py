"""The units under AddressSanitizer and under valgrind without a report, and planted bugs that both report.

`make sanitizers` builds what is run here; the calls are in `src/calls.rs`. AddressSanitizer looks for leaks at the end
as well.
"""

import subprocess

import pytest

from nervure.resources import ROOT

BUILDS = ROOT / "target" / "sanitizers"
TOOLS = {
    "asan": ([], BUILDS / "asan" / "x86_64-unknown-linux-gnu" / "sanitizers"),
    "valgrind": (
        [
            "valgrind",
            "--quiet",
            "--error-exitcode=99",
            "--leak-check=full",
            "--errors-for-leak-kinds=definite,possible",
        ],
        BUILDS / "plain" / "sanitizers",
    ),
}
"""What a program is run with, and where it was built for that."""

BUGS = {
    "use_after_free": {"asan": "heap-use-after-free", "valgrind": "Invalid read of size 8"},
    "out_of_bounds": {"asan": "heap-buffer-overflow", "valgrind": "Invalid read of size 8"},
    "leak": {"asan": "detected memory leaks", "valgrind": "definitely lost"},
}
"""What each tool says about a bug."""

FSI3 = "scenes/fsi3-325x72.json"
SCENES = {"rod": FSI3, "fluid": FSI3, "wing": "tests/reliability/wing.json"}

with_each_tool = pytest.mark.parametrize("tool", TOOLS)


def run(tool: str, program: str, argument: str) -> subprocess.CompletedProcess:
    command, folder = TOOLS[tool]
    return subprocess.run([*command, folder / program, argument], capture_output=True, text=True, timeout=600)


@with_each_tool
@pytest.mark.parametrize("kind", SCENES)
def test_unit_gives_no_report(tool, kind):
    answer = run(tool, kind, str(ROOT / SCENES[kind]))
    assert answer.returncode == 0, answer.stderr
    assert "==" not in answer.stderr, answer.stderr


@with_each_tool
@pytest.mark.parametrize("bug", BUGS)
def test_planted_bug_is_found(tool, bug):
    assert run(tool, "planted", "none").returncode == 0
    answer = run(tool, "planted", bug)
    assert answer.returncode != 0
    assert BUGS[bug][tool] in answer.stderr, answer.stderr
