"""Settings of the whole test run; environment variables, so that subprocesses and notebooks have them too."""

import os
import sys

from hypothesis import settings

os.environ["MPLBACKEND"] = "Agg"

if os.environ.get("FRICTIONLAB_DISABLE_NUMBA", "0") not in ("", "0"):
    sys.modules["numba"] = None  # any import of it fails, as if it were not installed

# The first example may compile the solver, so no deadline; the same examples on every machine.
settings.register_profile("frictionlab", deadline=None, derandomize=True)
settings.load_profile("frictionlab")
