"""Factorise the matrices of a folder by CHOLMOD, in its supernodes: medians of processor time by file, ms, as JSON.

A file holds an entry (row, column, value) of the lower triangle in each line. CHOLMOD chooses its own order.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import numpy as np
from cvxopt import cholmod, spmatrix

REPEATS = 10
cholmod.options["supernodal"] = 2

found = {}
for path in Path(sys.argv[1]).glob("*.txt"):
    rows, columns, values = np.loadtxt(path, unpack=True)
    matrix = spmatrix(values.tolist(), rows.astype(int).tolist(), columns.astype(int).tolist())
    factor = cholmod.symbolic(matrix)
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        cholmod.numeric(matrix, factor)
        times.append(1e3 * (time.process_time() - start))
    found[path.stem] = statistics.median(times)
print(json.dumps(found))
