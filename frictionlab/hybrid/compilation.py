"""One decorator for every numerical kernel: compiled and cached where numba exists, plain Python where not.

The compiled code is kept in a folder of the user, named by a digest of all kernel sources and the versions,
because a kernel's code holds that of functions *called* by it, in other files.
"""

from __future__ import annotations

import hashlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from importlib import import_module, resources
from typing import Any

from frictionlab.hybrid.kernel_cache import DIGEST_LENGTH, KernelCache, digest_folder, has_kernel

DISABLE_VARIABLE = "FRICTIONLAB_DISABLE_NUMBA"
# In the sources that compiled code is made from.
KERNEL_MARKS = (b"@kernel", b"@inlined", b"NamedTuple", b"intrinsic", b"LLVM")


def _numba() -> Any:
    if os.environ.get(DISABLE_VARIABLE, "0") not in ("", "0"):
        return None
    try:
        numba: Any = import_module("numba")
    except ModuleNotFoundError as error:  # Pyodide, or a platform without llvmlite
        if error.name not in ("numba", "llvmlite"):
            _warn_of_numba(error)
        return None
    except Exception as error:  # its library cannot be loaded, or it does not fit to numpy
        _warn_of_numba(error)
        return None
    return None if numba.config.DISABLE_JIT else numba


def _warn_of_numba(error: Exception) -> None:
    warnings.warn(
        f"numba cannot be imported ({type(error).__name__}: {error}): kernels run as plain Python, some "
        "hundred times slower; install numba and llvmlite again, in versions that fit to numpy",
        RuntimeWarning,
        stacklevel=2,
    )


def _digest(numba: Any) -> str:
    sources = _python_sources(resources.files("frictionlab.hybrid"))
    text = b"".join(source for source in sources if any(mark in source for mark in KERNEL_MARKS))
    versions = f"{numba.__version__} {sys.version}".encode()
    return hashlib.sha256(text + versions).hexdigest()[:DIGEST_LENGTH]


def _python_sources(folder: Any) -> Iterator[bytes]:
    """The sources in a folder and those in it, in their order; it may be in a zip file."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _python_sources(entry)
        elif entry.name.endswith(".py"):
            yield entry.read_bytes()


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

    compiled: Any = CFunc(function, normalize_signature(signature), locals={}, options=jit_options())
    compiled._cache = KernelCache(function, CACHE_FOLDER)
    compiled.compile()
    return compiled


def _compile(function: Callable, further: dict[str, bool]) -> Callable:
    if NUMBA is None:
        return function
    compiled = NUMBA.njit(nogil=True, **jit_options(), **further)(function)
    compiled._cache = KernelCache(function, CACHE_FOLDER)
    return compiled


def jit_options() -> dict[str, Any]:
    """Compile without reference counts: kernels allocate nothing, and counting would take most of their
    time."""
    counts = {"_nrt": False} if hasattr(NUMBA.core.options.DefaultOptions, "_nrt") else {}
    return {"error_model": "numpy", "boundscheck": False, **counts}
