"""Kernels that numba has compiled, kept in a folder of the user for later processes."""

from __future__ import annotations

import hashlib
import logging
import pickle
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from frictionlab.cache_folder import read, write

LOGGER = logging.getLogger(__name__)


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
