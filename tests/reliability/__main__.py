"""`python -m tests.reliability CHECK UNIT SCENE COUNT FILE` runs a check with so many cases and writes a row of CSV.

`make reliability` runs all checks at their full counts.
"""

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from nervure.files import write_csv

from .checks import CHECKS, unpack
from .unit import FMU2Unit

if __name__ == "__main__":
    name, kind, scene, count, file = sys.argv[1:]
    begin = time.perf_counter()
    with TemporaryDirectory() as folder:
        result = CHECKS[name].function(FMU2Unit(kind, unpack(kind, Path(folder), scene)), int(count))
    write_csv(Path(file), [{"result": result, "seconds": round(time.perf_counter() - begin)}])
