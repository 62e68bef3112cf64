"""The command in a process that sends itself a signal, so that a test need not wait for the moment:

    python tests/stopped.py NUMBER STEP run SCENE --output FOLDER

sends signal NUMBER after STEP steps. The checkpoints that are asked for end three steps before, so rows behind the last
one are in the files. No pictures are drawn.
"""

import os
import sys
from unittest.mock import patch

from nervure.cli import main
from nervure.output.pictures import Pictures
from nervure.simulation.checkpoint import Checkpoint
from nervure.simulation.loop import TimeLoop

if __name__ == "__main__":
    number, last = int(sys.argv.pop(1)), int(sys.argv.pop(1))
    notify, keep = TimeLoop._notify, Checkpoint.step

    def stop(loop: TimeLoop) -> None:
        notify(loop)
        if loop.steps == last:
            os.kill(os.getpid(), number)

    def keep_early(kept: Checkpoint, loop: TimeLoop) -> None:
        if loop.steps <= last - 3:
            keep(kept, loop)

    undrawn = patch.object(Pictures, "finish", lambda self, results: None)
    with patch.object(TimeLoop, "_notify", stop), patch.object(Checkpoint, "step", keep_early), undrawn:
        main()
