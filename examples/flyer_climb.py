"""A drive that lets the flyer of `flyer_pid.py` climb, with faster wings, by its body's height in five strokes.

nervure run examples/flyer-pid.json --drive examples/flyer_climb.py
"""

import runpy
from pathlib import Path

CLIMB, FREQUENCY = 0.05, 230.0  # m/s, Hz

drive = runpy.run_path(str(Path(__file__).with_name("flyer_pid.py")))["Pid"](CLIMB, FREQUENCY)
