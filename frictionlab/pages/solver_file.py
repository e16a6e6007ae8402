"""The kernels as WebAssembly, and how they take their arguments.

Both are files that `frictionlab.hybrid.ahead_of_time` makes: ``kernels.wasm``, and ``manifest.json``, which
lists for each function the results and arguments in its table of words.
"""

from __future__ import annotations

import base64
import gzip
from typing import Any

from frictionlab.hybrid.ahead_of_time.manifest import changed_sources, read_manifest, read_object
from frictionlab.hybrid.ahead_of_time.targets import WEB

BUILD_COMMAND = "python -m frictionlab.hybrid.ahead_of_time --web"
CURE = f'in a clone, run `pip install -e ".[pages]"` and `{BUILD_COMMAND}` once'


class SolverNotBuiltError(FileNotFoundError):
    """The WebAssembly of these kernels has not been built."""


def solver_data(script: str) -> dict[str, Any]:
    """The compressed module as text, and the tables of those of its functions that a script calls by name.

    Raises
    ------
    SolverNotBuiltError
        Where the files are missing, damaged, or older than the kernels.
    """
    manifest = read_manifest()
    module = None if manifest is None else read_object(manifest, WEB.file)
    if manifest is None or module is None:
        raise SolverNotBuiltError(f"export_page needs the solver as WebAssembly, which is not there: {CURE}")
    if changed := changed_sources(manifest):
        raise SolverNotBuiltError(f"{changed[0]} has changed since it was compiled to WebAssembly: {CURE}")
    functions = {name: each for name, each in manifest.functions.items() if f'"{name}"' in script}
    tables = {
        name: {"results": each.results, "arguments": each.arguments} for name, each in functions.items()
    }
    packed = gzip.compress(module, 9, mtime=0)
    return {"module": base64.b64encode(packed).decode(), "tables": tables}
