"""One decorator for every numerical kernel: compiled ahead of time, else by numba, else plain Python.

Where there is an object that was compiled from these very sources for this processor and system
(:mod:`frictionlab.hybrid.ahead_of_time`), its functions take the place of the kernels that Python calls, and
numba is not imported.  Otherwise numba compiles, and the results are kept in a folder of the user.  Its name
is a digest of the versions and of all sources that kernels depend on, because a kernel's code includes that
of functions *called* by it, from other files.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from frictionlab.cache_folder import DIGEST_LENGTH, digest_folder, read, write
from frictionlab.hybrid.ahead_of_time.loaded_kernels import LoadedKernels, load_kernels
from frictionlab.hybrid.ahead_of_time.manifest import kernel_sources

LOGGER = logging.getLogger(__name__)
DISABLE_VARIABLE = "FRICTIONLAB_DISABLE_NUMBA"  # kernels are plain Python, whatever is installed
COMPILE_VARIABLE = "FRICTIONLAB_COMPILE_KERNELS"  # numba compiles, even where an object exists


def _is_set(variable: str) -> bool:
    return os.environ.get(variable, "0") not in ("", "0")


def _numba() -> Any:
    try:
        numba: Any = import_module("numba")
    except ModuleNotFoundError as error:  # Pyodide, or a platform without llvmlite
        if error.name not in ("numba", "llvmlite"):
            _warn_of_numba(error)
        return None
    except Exception as error:  # its library cannot be loaded, or its version does not fit numpy's
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


def _warn_of_plain_python(reason: str) -> None:
    warnings.warn(
        f"{reason}: kernels run as plain Python, some hundred times slower; install numba, by "
        "pip install numba, which compiles them when they are first called, or ahead of time by "
        "python -m frictionlab.hybrid.ahead_of_time",
        RuntimeWarning,
        stacklevel=2,
    )


def _machine_code() -> tuple[LoadedKernels | None, Any]:
    """Kernels compiled ahead of time, or numba; neither where kernels are plain Python."""
    if _is_set(DISABLE_VARIABLE):
        return None, None
    loaded, reason = (None, "") if _is_set(COMPILE_VARIABLE) else load_kernels()
    if loaded is not None:
        return loaded, None
    LOGGER.info("%s: numba compiles them", reason)
    with warnings.catch_warnings(record=True) as caught:
        numba = _numba()
    for warning in caught:
        warnings.warn(warning.message, stacklevel=2)
    # No warning where numba's compilation has been switched off, nor in a browser, which has no numba.
    if "numba" not in sys.modules and not caught and reason and sys.platform != "emscripten":
        _warn_of_plain_python(reason)
    return None, numba


def _digest(numba: Any) -> str:
    text = b"".join(path.encode() + content for path, content in kernel_sources().items())
    versions = f"{numba.__version__} {sys.version}".encode()
    return hashlib.sha256(text + versions).hexdigest()[:DIGEST_LENGTH]


def cache_folder(numba: Any) -> str:
    """The folder that code compiled by numba is kept in, "" where there is none."""
    return digest_folder(_digest(numba))


class KernelCache:
    """The cache of one kernel, in place of numba's: a file for each of its signatures and processors.

    Numba's own cache finds the file of a signature by an index file, checks neither, and raises an error when
    one is damaged.
    """

    def __init__(self, function: Callable, folder: str) -> None:
        self._function = function
        self.cache_path = folder

    def load_overload(self, signature: Any, context: Any) -> Any:
        """A compilation's result if an earlier process has kept it, else None."""
        context.refresh()  # registers the types that the result is made of
        path = self._path(signature, context)
        content = None if path is None else read(path)
        if content is None:
            LOGGER.info("compiling kernel %s: not in the cache", self._function.__name__)
            return None
        LOGGER.debug("kernel %s found in the cache", self._function.__name__)
        from numba.core.compiler import CompileResult

        try:
            return CompileResult._rebuild(context, *pickle.loads(content))
        except Exception:  # written by another build of the same version of numba
            return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep the result of a compilation, unless it holds addresses of this process."""
        from numba.core.serialize import dumps

        path = self._path(signature, result.target_context)
        if path is not None and not result.library.has_dynamic_globals:
            write(path, dumps(result._reduce()))

    def flush(self) -> None:
        """Delete nothing: results from other sources have other names."""

    def _path(self, signature: Any, context: Any) -> Path | None:
        function = self._function
        source = _source_digest(function.__code__.co_filename, function.__globals__.get("__loader__"))
        what = signature, context.codegen().magic_tuple(), function.__module__, function.__qualname__
        text = repr((what, source))
        if not (self.cache_path and source) or function.__closure__ or " at 0x" in text:
            return None  # its code depends on more than its source and the types
        name = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
        return Path(self.cache_path) / f"{function.__name__}-{name}.kernel"


def has_kernel(folder: str, name: str) -> bool:
    """Whether the folder holds compiled code of a kernel of this name."""
    return any(Path(folder).glob(f"{name}-*.kernel"))


@cache
def _source_digest(file: str, loader: Any) -> str:
    """Digest of a source file, which may be in a zip file; "" where there is none, as at the prompt."""
    with suppress(OSError, AttributeError):
        return hashlib.blake2b(loader.get_data(file), digest_size=16).hexdigest()
    return ""


LOADED, NUMBA = _machine_code()
HAS_MACHINE_CODE = LOADED is not None or NUMBA is not None
if LOADED is not None:  # for the native code of modes, which is compiled on this machine
    CACHE_FOLDER = digest_folder(LOADED.digest[:DIGEST_LENGTH])
else:
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
    """The function as compiled ahead of time; else numba compiles it on its first call, once per machine;
    without numba the function itself."""
    return _compile(function, {"forceinline": False})  # else it inherits this from its callers


def inlined(function: Callable) -> Callable:
    """A kernel that is inlined into its callers: a call would pass some hundred numbers for its arrays."""
    return _compile(function, {"forceinline": True})


def c_address(name: str, function: Callable, signature: str) -> int:
    """Address at which C code calls a function; ahead of time it was compiled under this `name`."""
    return _c_function(function, signature).address if LOADED is None else LOADED.address(name)


@cache  # keeps the compiled function alive: its code is freed with it
def _c_function(function: Callable, signature: str) -> Any:
    from numba.core.ccallback import CFunc
    from numba.core.sigutils import normalize_signature

    compiled: Any = CFunc(function, normalize_signature(signature), locals={}, options=jit_options())
    compiled._cache = KernelCache(function, CACHE_FOLDER)
    compiled.compile()
    return compiled


def _compile(function: Callable, further: dict[str, bool]) -> Callable:
    if LOADED is not None:
        return LOADED.function(function)
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
