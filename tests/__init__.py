"""Tests of the whole: units, couplings, the Python package and its documents."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # As the command does, before anything imports NumPy
