"""Whether numba can compile kernels here, those too that were compiled ahead of time."""

import os
from importlib.util import find_spec

HAS_NUMBA = find_spec("numba") is not None and os.environ.get("FRICTIONLAB_DISABLE_NUMBA", "0") in ("", "0")
