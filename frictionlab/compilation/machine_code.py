"""Where the machine code of kernels comes from: compiled ahead of time, else by numba, else there is none.

Where there is an object that was compiled from these very sources for this processor and system
(:mod:`frictionlab.compilation.loaded_kernels`), numba is not imported.  Otherwise numba compiles, and the
results are kept in a folder of the user.  Its name is a digest of the versions and of all sources that
kernels depend on, because a kernel's code includes that of functions *called* by it, from other files.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sys
import warnings
from importlib import import_module
from typing import Any

from frictionlab.cache_folder import DIGEST_LENGTH, digest_folder
from frictionlab.compilation.kernel_sources import kernel_sources
from frictionlab.compilation.loaded_kernels import LoadedKernels, load_kernels

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
        "python -m frictionlab.compilation",
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


LOADED, NUMBA = _machine_code()
HAS_MACHINE_CODE = LOADED is not None or NUMBA is not None
if LOADED is not None:  # for the native code of modes, which is compiled on this machine
    CACHE_FOLDER = digest_folder(LOADED.digest[:DIGEST_LENGTH])
else:
    CACHE_FOLDER = cache_folder(NUMBA) if NUMBA else ""
