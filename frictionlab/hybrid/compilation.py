"""One decorator for every numerical kernel: compiled and cached where numba exists, plain Python where not.

The compiled code is kept in a folder of the user, named by a digest of all kernel sources and the versions,
because a kernel's code holds that of functions *called* by it, in other files.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from frictionlab.hybrid.kernel_cache import DIGEST_LENGTH, KernelCache, digest_folder, has_kernel

DISABLE_VARIABLE = "FRICTIONLAB_DISABLE_NUMBA"
# In the sources that compiled code is made from.
KERNEL_MARKS = (b"@kernel", b"@inlined", b"NamedTuple", b"intrinsic", b"LLVM")


def _numba() -> Any:
    if os.environ.get(DISABLE_VARIABLE, "0") not in ("", "0"):
        return None
    try:
        import numba
    except ImportError:  # Pyodide, or a platform without llvmlite
        return None
    return numba


def _digest(numba: Any) -> str:
    sources = (path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py")))
    text = b"".join(source for source in sources if any(mark in source for mark in KERNEL_MARKS))
    versions = f"{numba.__version__} {sys.version}".encode()
    return hashlib.sha256(text + versions).hexdigest()[:DIGEST_LENGTH]


def cache_folder(numba: Any) -> str:
    """The folder that compiled code is kept in, "" where there is none."""
    return digest_folder(_digest(numba))


NUMBA = _numba()
CACHE_FOLDER = cache_folder(NUMBA) if NUMBA else ""
_FOUND: set[Any] = set()  # kernels found in the cache folder, so that it is read once for each


def needs_compilation(function: Any) -> bool:
    """Whether the next call of a kernel compiles it: neither loaded nor in the cache folder."""
    if NUMBA is None or function.overloads or function in _FOUND:
        return False
    if CACHE_FOLDER and has_kernel(CACHE_FOLDER, function.__name__):
        _FOUND.add(function)
    return function not in _FOUND


def kernel(function: Callable) -> Callable:
    """Compile `function` on its first call, once per machine; without numba return it as it is."""
    return _compile(function, {})


def inlined(function: Callable) -> Callable:
    """A kernel that is inlined into its callers: a call would pass some hundred numbers for its arrays."""
    return _compile(function, {"forceinline": True})


def c_function(function: Callable, signature: str) -> Any:
    """A function compiled now, as C code calls it; its ``address`` is that of the code, while it is kept."""
    from numba.core.ccallback import CFunc
    from numba.core.sigutils import normalize_signature

    compiled: Any = CFunc(function, normalize_signature(signature), locals={}, options=_options())
    compiled._cache = KernelCache(function, CACHE_FOLDER)
    compiled.compile()
    return compiled


def _compile(function: Callable, further: dict[str, bool]) -> Callable:
    if NUMBA is None:
        return function
    compiled = NUMBA.njit(nogil=True, **_options(), **further)(function)
    compiled._cache = KernelCache(function, CACHE_FOLDER)
    return compiled


def _options() -> dict[str, Any]:
    """Compile without reference counts: kernels allocate nothing, and counting would take most of their
    time."""
    counts = {"_nrt": False} if hasattr(NUMBA.core.options.DefaultOptions, "_nrt") else {}
    return {"error_model": "numpy", "boundscheck": False, **counts}
