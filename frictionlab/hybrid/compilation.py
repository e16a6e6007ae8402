"""One decorator for every numerical kernel: compiled and cached where numba exists, plain Python where not.

The compiled code is kept in a folder of the user, named by a digest of all kernel sources and the versions,
because numba's own cache neither survives a read-only installation nor notices that a function *called* by a
cached one, in another file, has changed.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

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
    return hashlib.sha256(text + versions).hexdigest()[:16]


def _user_cache() -> Path:
    if chosen := os.environ.get("FRICTIONLAB_CACHE_DIR"):
        return Path(chosen)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "frictionlab"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "frictionlab"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "frictionlab"


def cache_folder(numba: Any) -> str:
    """First writable folder for compiled code: the user's cache, else the temporary folder."""
    private = f"frictionlab-{os.environ.get('USER') or os.environ.get('USERNAME') or 'user'}"
    for base in (_user_cache, lambda: Path(tempfile.gettempdir()) / private):
        try:
            folder = base() / _digest(numba)
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return str(folder)
        except (OSError, RuntimeError):  # read-only, no home folder
            continue
    return ""


NUMBA = _numba()
CACHE_FOLDER = cache_folder(NUMBA) if NUMBA else ""
_FOUND: set[Any] = set()  # kernels found in the cache folder, so that it is read once for each


def needs_compilation(function: Any) -> bool:
    """Whether the next call of a kernel compiles it: neither loaded nor in the cache folder."""
    if NUMBA is None or function.overloads or function in _FOUND:
        return False
    if CACHE_FOLDER and any(Path(CACHE_FOLDER).glob(f"*/*.{function.__name__}-*.nbi")):
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
    return _cached(function, lambda options: NUMBA.cfunc(signature, **options))


def _without_reference_counts() -> dict[str, bool]:
    """Compile without reference counts: kernels allocate nothing, and counting would take most of their
    time."""
    return {"_nrt": False} if hasattr(NUMBA.core.options.DefaultOptions, "_nrt") else {}


def _compile(function: Callable, further: dict[str, bool]) -> Callable:
    if NUMBA is None:
        return function
    return _cached(function, lambda options: NUMBA.njit(nogil=True, **options, **further))


def _cached(function: Callable, decorator: Callable[[dict[str, Any]], Callable]) -> Any:
    """What numba's decorator makes of a function, with our options and our folder."""
    before = NUMBA.config.CACHE_DIR
    NUMBA.config.CACHE_DIR = CACHE_FOLDER or before
    options = {"error_model": "numpy", "boundscheck": False, **_without_reference_counts()}
    try:
        return decorator({"cache": bool(CACHE_FOLDER), **options})(function)
    finally:
        NUMBA.config.CACHE_DIR = before
