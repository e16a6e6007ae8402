"""The kernels as WebAssembly, and how they take their arguments.

Both are files that `frictionlab.hybrid.ahead_of_time` makes: ``kernels.wasm``, and ``manifest.json``, which
lists for each function the results and arguments in its table of words.
"""

from __future__ import annotations

import base64
import gzip
import json
from importlib import resources
from typing import Any

FOLDER, MODULE, MANIFEST = "objects", "kernels.wasm", "manifest.json"
BUILD_COMMAND = "python -m frictionlab.hybrid.ahead_of_time --web"
# Those that solver.js and sampling.js call.
FUNCTIONS = (
    "select_mode",
    "advance_taylor",
    "advance_affine",
    "longest_common_step",
    "affine_map_columns",
    "sample_states",
)


class SolverNotBuiltError(FileNotFoundError):
    """The WebAssembly of the kernels has not been built."""


def solver_data() -> dict[str, Any]:
    """The compressed module as text, and the tables of its functions.

    Raises
    ------
    SolverNotBuiltError
        Where the files are missing.
    """
    folder = resources.files("frictionlab.hybrid").joinpath("ahead_of_time", FOLDER)
    module, manifest = folder.joinpath(MODULE), folder.joinpath(MANIFEST)
    if not (module.is_file() and manifest.is_file()):
        raise SolverNotBuiltError(
            "export_page needs the solver as WebAssembly, which this installation was built without: run "
            f"`{BUILD_COMMAND}` once, with numba and ziglang installed"
        )
    functions = json.loads(manifest.read_text(encoding="utf-8"))["functions"]
    tables = {name: {key: functions[name][key] for key in ("results", "arguments")} for name in FUNCTIONS}
    packed = gzip.compress(module.read_bytes(), 9, mtime=0)
    return {"module": base64.b64encode(packed).decode(), "tables": tables}
